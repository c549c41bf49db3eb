"""A whole program: header, source, and the binding that Python calls."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from trackmarshal.backends.c import machine, parts
from trackmarshal.backends.c.configuration import configuration
from trackmarshal.backends.c.contract import Supervised, supervised_layout
from trackmarshal.backends.c.door import Door
from trackmarshal.backends.c.header import header
from trackmarshal.backends.c.judging import calls as rule_calls
from trackmarshal.backends.c.judging import judge
from trackmarshal.backends.c.layout import Layout, layout
from trackmarshal.backends.c.names import comment, literal
from trackmarshal.backends.c.online import Monitor, monitors
from trackmarshal.backends.c.places import calls, initial, own_places, setters
from trackmarshal.backends.c.rules import CASES, TRUTH, GroupCode, RuleCode, group_codes, rule_code
from trackmarshal.ir.spec import RuleInfo, Spec


@dataclass(frozen=True)
class Source:
    """The generated files' texts, and what they are made of."""

    plan: Layout
    rules: tuple[RuleCode, ...]
    header: str
    source: str
    name: str
    monitors: tuple[Monitor, ...]
    #: The input contract, where the program is a whole Supervisor and not the rules alone.
    supervised: Supervised | None

    @property
    def series(self) -> int:
        return max((code.series for code in self.rules), default=0)


def generate(
    spec: Spec,
    rules: Sequence[RuleInfo],
    name: str = "supervisor",
    online: bool = False,
    doored: bool = False,
) -> Source:
    """C for the chosen rules; raises TrackmarshalError E470 for a rule that has no C counterpart.

    online: with a monitor, a sample at a time, of every rule along a timeline that can have one. doored: the whole Supervisor around
    the rules; raises E482 for a spec that cannot be supervised with.
    """
    supervised: Supervised | None = None
    if doored:
        plan, supervised = supervised_layout(spec, rules)
    else:
        plan = layout(spec, rules)
    groups = group_codes(plan)
    grouped = {rule.name for group in groups for rule in group.rules}
    codes = tuple(rule_code(plan, rule, rule.name in grouped) for rule in plan.rules)
    series = max((code.series for code in codes), default=0)
    found = tuple(monitors(plan)) if online else ()
    return Source(
        plan, codes, header(plan, codes, series, name, found, supervised),
        "\n".join([*_source(plan, codes, groups, name, found, supervised), ""]), name, found, supervised,
    )  # fmt: skip


#: gcc 12.2 at -O2 takes a series that was written anew for the one before: what a function writes is lost from its summary
#: when constants are propagated into it. Seen by comparison with the reference; clang, -O1 and the sanitizers agree with it.
_COMPILER = (
    "/* Some gcc (seen in 12.2, from -O2 on) forget what a function writes when they summarise it for its callers. */",
    "#if defined(__GNUC__) && !defined(__clang__)",
    "#if __GNUC__ >= 11",
    '#pragma GCC optimize("no-ipa-modref")',
    "#endif",
    "#endif",
    "",
)


def _source(
    plan: Layout,
    codes: Sequence[RuleCode],
    groups: Sequence[GroupCode],
    name: str,
    found: Sequence[Monitor],
    supervised: Supervised | None,
) -> Iterator[str]:
    data = list(_data(plan))
    types: list[str] = []
    if supervised is None:
        tail = [*_check(plan, codes, groups), *data, *_init(plan), *setters(plan)]
    else:
        door = Door(supervised, calls(plan, supervised.lines))
        types = list(machine.types(supervised, door.parts))
        tail = [
            *data, *setters(plan, True), "", *door.functions, *judge(plan, supervised, codes, groups),
            *machine.functions(supervised), *configuration(plan, supervised),
        ]  # fmt: skip
    bodies = [
        *(code.text for code in codes), *(group.text for group in groups), *(monitor.text for monitor in found)
    ]  # fmt: skip
    yield f"/* Generated from a spec by trackmarshal; the spec is what is maintained. Fingerprint {plan.spec.fingerprint[:16]}. */"
    yield f'#include "{name}.h"'
    yield ""
    yield "#include <float.h>"
    yield "#include <math.h>"
    yield ""
    yield from _COMPILER
    yield "#define TM_INF ((double)INFINITY)"
    yield "#define TM_NAN ((double)NAN)"
    yield ""
    yield from types
    yield TRUTH
    if not found:  # the header has it for them
        yield CASES
    known = parts.functions()
    for function in parts.needed([*bodies, *tail]):
        yield known[function]
    yield from bodies
    yield from tail


def _check(plan: Layout, codes: Sequence[RuleCode], groups: Sequence[GroupCode]) -> Iterator[str]:
    yield "/* Whether an input fits the capacities, and has the samples that every timeline has. */"
    yield "static tm_status tm_fits(const tm_input *in)"
    yield "{"
    columns = [item for item in plan.inputs.values() if item.kind == "columns"]
    if not columns:
        yield "  (void)in;"
    for item in columns:
        assert item.signal is not None
        limit = "TM_MAX_SAMPLES" if item.signal.sequence else "TM_MAX_ELEMENTS"
        yield f"  if (in->{item.c_name}.count > {limit}) {{ return TM_OVER_CAPACITY; }}"
        if item.signal.sequence:
            yield f"  if (in->{item.c_name}.count < 1u) {{ return TM_TOO_SHORT; }}"
    yield "  return TM_OK;"
    yield "}"
    yield ""
    yield "/* All rules on one input. Where the input does not fit, every rule is undefined. */"
    yield "tm_status tm_check(tm_context *c, const tm_input *in, tm_output *out)"
    yield "{"
    yield "  const tm_status status = tm_fits(in);"
    yield "  if (status != TM_OK) {"
    yield "    for (size_t i = 0u; i < TM_RULES; ++i) { tm_undefined(&out->rule[i]); }"
    yield "    return status;"
    yield "  }"
    yield from rule_calls(codes, groups)
    yield "  return TM_OK;"
    yield "}"
    yield ""


def _data(plan: Layout) -> Iterator[str]:
    """The spec's own tables and places."""
    spec = plan.spec
    for table, c_name in plan.tables.items():
        info = spec.tables[table]
        yield f"/* {comment(table)} {comment(str(info.span))} */"
        for what, numbers in (("knots", info.knots), ("values", info.values)):
            yield f"static const double tm_{c_name}_{what}[{len(numbers)}] = {{{', '.join(literal(v) for v in numbers)}}};"
    for shape in own_places(plan):
        place = spec.places[shape.key[1]]
        flat = ", ".join(literal(v) for point in place.points for v in point)
        yield f"/* {comment(place.name)} {comment(str(place.span))} */"
        yield f"static const double tm_{shape.c_name}_points[{2 * len(place.points)}] = {{{flat}}};"
    yield ""


def _init(plan: Layout) -> Iterator[str]:
    spec = plan.spec
    yield "/* The spec's own parameters, tables and places. Tracks and lines of signals are set by the caller. */"
    yield "tm_status tm_init(tm_context *c)"
    yield "{"
    yield "  tm_status status = TM_OK;"
    if not plan.params and not plan.tables and not plan.shapes:
        yield "  (void)c;"
    for name, c_name in plan.params.items():
        param = spec.params[name]
        yield f"  c->params.{c_name} = {literal(param.value)}; /* {comment(name)} {comment(str(param.span))} */"
    for table, c_name in plan.tables.items():
        count = len(spec.tables[table].knots)
        yield f"  if (!tm_set_table(&c->tables.{c_name}, tm_{c_name}_knots, tm_{c_name}_values, {count}u)) {{ status = TM_UNUSABLE; }}"
    yield from initial(plan)
    yield "  return status;"
    yield "}"
    if plan.tables:
        yield ""
        yield "/* Replace a table; false, and nothing is changed, for no row, too many, or knots that do not ascend. */"
        yield "bool tm_set_table(tm_table *table, const double *knots, const double *values, size_t count)"
        yield "{"
        yield "  return tm_fill_table(table, knots, values, count);"
        yield "}"
