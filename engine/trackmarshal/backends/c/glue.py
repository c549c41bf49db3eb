"""The binding of a program: everything flattened to arrays, so that Python needs to know no struct."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from trackmarshal.backends.c.binding import glue as supervised
from trackmarshal.backends.c.online import glue as online
from trackmarshal.backends.c.source import Source


@dataclass(frozen=True)
class Flat:
    """The order of what the binding takes: sets and timelines; their columns; numbers; flags, events among them (field "")."""

    counts: tuple[str, ...]
    columns: tuple[tuple[str, str, bool], ...]
    numbers: tuple[tuple[str, str], ...]
    flags: tuple[tuple[str, str], ...]


def flat(source: Source) -> Flat:
    """The order for a program."""
    inputs = source.plan.inputs.values()
    return Flat(
        tuple(item.name for item in inputs if item.kind == "columns"),
        tuple(
            (item.name, info.name, info.kind == "bool")
            for item in inputs
            if item.kind == "columns"
            for info, _ in item.fields
        ),
        tuple(
            (item.name, info.name)
            for item in inputs
            if item.kind == "record"
            for info, _ in item.fields
            if info.kind != "bool"
        ),
        tuple(
            (item.name, info.name if info is not None else "")
            for item in inputs
            for info in (
                [None]
                if item.kind == "event"
                else [f for f, _ in item.fields if item.kind == "record" and f.kind == "bool"]
            )
        ),
    )


def glue(source: Source) -> str:
    """The C of the binding."""
    return "\n".join([*_lines(source), ""])


def _lines(source: Source) -> Iterator[str]:
    yield f'#include "{source.name}.c"'
    yield "size_t tmg_size(void) { return sizeof(tm_context); }"
    yield "int tmg_init(void *c) { return (int)tm_init((tm_context *)c); }"
    yield from _rules(source) if source.supervised is None else supervised(source.supervised)
    yield from online(list(source.monitors))


def _rules(source: Source) -> Iterator[str]:
    """The rules by themselves."""
    plan, order = source.plan, flat(source)
    yield "int tmg_set_param(void *context, size_t index, double value) {"
    yield "  tm_context *c = (tm_context *)context;"
    yield "  (void)c; (void)value;"
    yield "  switch (index) {"
    for i, c_name in enumerate(plan.params.values()):
        yield f"    case {i}: c->params.{c_name} = value; return 0;"
    yield "    default: return 1;"
    yield "  }"
    yield "}"
    yield "int tmg_set_table(void *context, size_t index, const double *knots, const double *values, size_t count) {"
    yield "  tm_context *c = (tm_context *)context;"
    yield "  (void)c; (void)knots; (void)values; (void)count;"
    yield "  switch (index) {"
    for i, c_name in enumerate(plan.tables.values()):
        yield f"    case {i}: return tm_set_table(&c->tables.{c_name}, knots, values, count) ? 0 : 1;"
    yield "    default: return 1;"
    yield "  }"
    yield "}"
    from trackmarshal.backends.c.places import glue as places

    yield from places(plan)
    yield "static void tmg_input(tm_input *in, const size_t *counts, const void *const *columns, const double *numbers,"
    yield "                      const signed char *flags) {"
    yield "  (void)in; (void)counts; (void)columns; (void)numbers; (void)flags;"
    for i, name in enumerate(order.counts):
        yield f"  in->{plan.input(name).c_name}.count = counts[{i}];"
    for i, (name, field, flag) in enumerate(order.columns):
        kind = "tm_flag" if flag else "double"
        yield f"  in->{plan.input(name).c_name}.{plan.field_name(name, field)} = (const {kind} *)columns[{i}];"
    for i, (name, field) in enumerate(order.numbers):
        yield f"  in->{plan.input(name).c_name}.{plan.field_name(name, field)} = numbers[{i}];"
    for i, (name, field) in enumerate(order.flags):
        place = f"in->{plan.input(name).c_name}" + (f".{plan.field_name(name, field)}" if field else "")
        yield f"  {place} = flags[{i}];"
    if not plan.inputs:
        yield "  in->unused = 0;"
    yield "}"
    sizes = (len(order.counts), len(order.columns), len(order.numbers), len(order.flags))
    given = ", ".join(
        f"&{name}[k * {size}u]" for name, size in zip(("counts", "columns", "numbers", "flags"), sizes)
    )
    yield "int tmg_run(void *context, size_t cases, const size_t *counts, const void *const *columns, const double *numbers,"
    yield "            const signed char *flags, double *margins, signed char *verdicts) {"
    yield "  tm_context *c = (tm_context *)context;"
    yield "  int worst = 0;"
    yield "  for (size_t k = 0; k < cases; ++k) {"
    yield "    tm_input in;"
    yield "    tm_output out;"
    yield "    int status;"
    yield f"    tmg_input(&in, {given});"
    yield "    status = (int)tm_check(c, &in, &out);"
    yield "    if (status > worst) { worst = status; }"
    yield "    for (size_t r = 0; r < TM_RULES; ++r) {"
    yield "      margins[k * TM_RULES + r] = out.rule[r].margin;"
    yield "      verdicts[k * TM_RULES + r] = (signed char)out.rule[r].verdict;"
    yield "    }"
    yield "  }"
    yield "  return worst;"
    yield "}"
    yield from _along(source)


def _along(source: Source) -> Iterator[str]:
    """The value of a rule at every sample of its timeline: `count` results; 0, or the status of an input that does not fit."""
    yield from (code.along for code in source.rules if code.along)
    yield "int tmg_along(void *context, size_t rule, const size_t *counts, const void *const *columns, const double *numbers,"
    yield "              const signed char *flags, tm_result *out) {"
    yield "  tm_context *c = (tm_context *)context;"
    yield "  tm_input in;"
    yield "  int status;"
    yield "  tmg_input(&in, counts, columns, numbers, flags);"
    yield "  status = (int)tm_fits(&in);"
    yield "  if (status != 0) { return status; }"
    yield "  (void)c; (void)out;"
    yield "  switch (rule) {"
    for index, code in enumerate(source.rules):
        if code.along:
            yield f"    case {index}u: tm_rule_{code.c_name}_along(c, &in, out); return 0;"
    yield "    default: return -1;"
    yield "  }"
    yield "}"
