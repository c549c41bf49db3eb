"""Parameters, limits and tables of a Supervisor in C: what they may be is checked when they are put into a context."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.expressions import Expressions
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import comment, literal
from trackmarshal.backends.c.places import initial as places
from trackmarshal.backends.c.supervised.checks import text
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.backends.c.supervised.interface import LIMITS, MARKS, declared
from trackmarshal.ir.spec import ConstraintInfo, RuleInfo
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.machine import NO_EMERGENCY_YET


def configuration(plan: Layout, given: Supervised) -> Iterator[str]:
    """Definitions: the spec's constraints, tm_defaults, tm_configure, tm_init."""
    for number, constraint in enumerate(plan.spec.constraints):
        yield from _constraint(plan, number, constraint)
    yield from _put_limits()
    groups = [name for name, _ in _groups(plan)]
    for name, body in _groups(plan):
        yield f"static void {name}(tm_context *c, const tm_configuration *given, tm_configured *said, size_t *parts)"
        yield "{"
        yield from body
        yield "  ++*parts;"
        yield "}"
        yield ""
    yield from _defaults(plan)
    yield "tm_configured tm_configure(tm_context *c, const tm_configuration *configuration)"
    yield "{"
    yield '  tm_configured said = {TM_OK, ""};'
    yield "  size_t parts = 0u;"
    yield "  const tm_limits before = c->limits;"
    yield "  c->configured = 0u;"
    yield "  if (!tm_as_written()) {"
    yield "    said.status = TM_UNSUPPORTED;"
    yield '    said.which = "arithmetic";'
    yield "  }"
    yield "  tm_put_limits(c, configuration, &said, &parts);"
    yield from (f"  {name}(c, configuration, &said, &parts);" for name in groups)
    yield f"  if ((said.status == TM_OK) && (parts == {1 + len(groups)}u)) {{"
    yield "    c->configured = TM_MADE;"
    yield "  } else if (said.status == TM_OK) {"
    yield "    said.status = TM_UNUSABLE;"
    yield '    said.which = "configuration";'
    yield "  } else {"
    yield "    /* it says what cannot stand */"
    yield "  }"
    yield "  if (c->configured != TM_MADE) {"
    yield "    c->limits = before; /* what is stored is driven on, and held to them */"
    yield "  }"
    yield "  return said;"
    yield "}"
    yield ""
    yield from _init(plan, given)


def _groups(plan: Layout) -> list[tuple[str, list[str]]]:
    """Functions that put a kind of values in, by name."""
    found = []
    if plan.params:
        found.append(("tm_put_params", list(_params(plan))))
    if declared(plan):
        found.append(("tm_put_declared", list(_declared(plan))))
    if plan.tables:
        found.append(("tm_put_tables", list(_tables(plan))))
    if plan.spec.constraints:
        found.append(("tm_put_together", list(_together(plan))))
    return found


def _refused(status: str, name: str) -> str:
    """Statement that remembers the first value that cannot stand."""
    return f"if (said->status == TM_OK) {{ said->status = {status}; said->which = {text(name)}; }}"


def _put_limits() -> Iterator[str]:
    yield "/* Limits are numbers from 0 on; infinite ones are none. */"
    yield "static void tm_put_limits(tm_context *c, const tm_configuration *given, tm_configured *said, size_t *parts)"
    yield "{"
    for name in LIMITS:
        yield f"  if (given->limits.{name} >= 0.0) {{"
        yield f"    c->limits.{name} = given->limits.{name};"
        yield "  } else {"
        yield f"    {_refused('TM_BAD_LIMIT', name)}"
        yield "  }"
    yield "  ++*parts;"
    yield "}"
    yield ""


def _params(plan: Layout) -> Iterator[str]:
    for name, c_name in plan.params.items():
        info = plan.spec.params[name]
        low = "-DBL_MAX" if info.lower is None else literal(info.lower)
        high = "DBL_MAX" if info.upper is None else literal(info.upper)
        place = f"given->params.{c_name}"
        yield f"  if (({place} >= {low}) && ({place} <= {high}) && tm_finite({place})) {{ /* {comment(str(info.span))} */"
        yield f"    c->params.{c_name} = {place};"
        yield "  } else {"
        yield f"    {_refused('TM_BAD_PARAM', name)}"
        yield "  }"


def _declared(plan: Layout) -> Iterator[str]:
    """What constraints hold of a limit, they hold of the parameter that declares it: one alone is not changed."""
    yield "  (void)given;"
    for limit, name in declared(plan).items():
        held, param = f"c->limits.{limit}", f"c->params.{plan.params[name]}"
        yield f"  if (tm_finite({held}) && (({held} < {param}) || ({held} > {param}))) {{"
        yield f"    {_refused('TM_BAD_LIMIT', limit)}"
        yield "  }"


def _tables(plan: Layout) -> Iterator[str]:
    for name, c_name in plan.tables.items():
        rows, table = f"given->tables.{c_name}", f"c->tables.{c_name}"
        way = plan.spec.tables[name].way
        inside = ""
        if way.length > 0.0:
            inside = f" || !({table}.knot[0] >= 0.0) || !({table}.knot[{table}.count - 1u] < {literal(way.length)})"
        yield f"  {table}.count = 0u;"
        yield f"  if (({rows}.knots == NULL) || ({rows}.values == NULL) ||"
        yield f"      !tm_fill_table(&{table}, {rows}.knots, {rows}.values, {rows}.count) || ({table}.count != {rows}.count){inside}) {{"
        yield f"    {_refused('TM_BAD_TABLE', name)}"
        yield "  }"


def _together(plan: Layout) -> Iterator[str]:
    yield "  (void)given;"
    yield "  bool holds = false;"
    for number, constraint in enumerate(plan.spec.constraints):
        yield "  holds = false;"
        yield f"  if (said->status == TM_OK) {{ tm_constraint_{number}(c, &holds); }}"
        yield f"  if (!holds) {{ {_refused('TM_BAD_CONSTRAINT', str(constraint.span))} }}"


def _constraint(plan: Layout, number: int, constraint: ConstraintInfo) -> Iterator[str]:
    """A constraint as the rules are written; it holds where it surely does."""
    shown = " ".join(constraint.span.text.split("because")[0].split())
    rule = _as_rule(constraint)
    writer = Expressions(plan, [rule], False, [constraint.formula])
    writer.root.names.add("holds")
    value = writer.formula(writer.formulas[0], writer.root)
    if not isinstance(value, c.Name):
        value = writer.declare(writer.root, writer.type, value, "demand")
    surely = c.Unary("*", c.Name("holds"))
    writer.add(writer.root, c.Assign(surely, c.Member(value, "worst_sat", False)))
    body, _ = writer.finished(("context",))
    said = (f"{comment(shown)} {comment(str(constraint.span))}",)
    parameters = (("tm_context *", "context"), ("bool *", "holds"))
    yield from c.printed(c.Function(said, "void", f"tm_constraint_{number}", parameters, body))
    yield ""


def _as_rule(constraint: ConstraintInfo) -> RuleInfo:
    """A constraint as the rule that the writer of formulas expects."""
    empty: frozenset[tuple[str, str]] = frozenset()
    return RuleInfo(
        "constrain", "rule", "", "", constraint.formula, None, None, "", (), (), "", constraint.because or "", "", "", "", empty, "",
        constraint.span,
    )  # fmt: skip


def _defaults(plan: Layout) -> Iterator[str]:
    yield "void tm_defaults(tm_configuration *configuration)"
    yield "{"
    held = Limits.of(plan.spec)
    for name in LIMITS:
        yield f"  configuration->limits.{name} = {literal(getattr(held, name))};"
    for name, c_name in plan.params.items():
        info = plan.spec.params[name]
        yield f"  configuration->params.{c_name} = {literal(info.value)}; /* {comment(name)} {comment(str(info.span))} */"
    for name, c_name in plan.tables.items():
        count = len(plan.spec.tables[name].knots)
        yield f"  configuration->tables.{c_name}.knots = tm_{c_name}_knots;"
        yield f"  configuration->tables.{c_name}.values = tm_{c_name}_values;"
        yield f"  configuration->tables.{c_name}.count = {count}u;"
    yield "}"
    yield ""


def _init(plan: Layout, given: Supervised) -> Iterator[str]:
    yield "tm_status tm_init_of(tm_context *c, unsigned long program, size_t context, size_t decision)"
    yield "{"
    yield "  tm_configuration own;"
    yield "  tm_configured said;"
    yield "  tm_status status = TM_OK;"
    yield "  c->made = 0u; /* the first member, wherever the others are */"
    yield "  if ((program != TM_PROGRAM) || (context != sizeof(tm_context)) || (decision != sizeof(tm_decision))) {"
    yield "    return TM_UNSUPPORTED;"
    yield "  }"
    yield "  c->configured = 0u;"
    yield "  c->serial = 0u;"
    for part in MARKS:
        yield f"  c->marks.{part} = 0u;"
    yield "  c->reading = -DBL_MAX;"
    yield "  c->stamp = 0.0;"
    yield "  c->number = 0;"
    yield "  c->stamped = false;"
    yield "  c->numbered = false;"
    yield f"  c->state = TM_STATE_{NO_EMERGENCY_YET.upper()};"
    yield "  c->stored.serial = 0u;"
    yield "  c->stored.number = 0;"
    yield "  c->stored.t = 0.0;"
    yield "  c->stored.confirmed = 0.0;"
    yield "  c->stored.count = 0u;"
    for signal in given.borders:
        kept = f"c->lines.{given.signals[signal.name]}"
        for field in signal.lines:
            yield f"  {kept}.{given.lines[signal.name, field.name]}.id = 0u;"
            yield f"  {kept}.{given.lines[signal.name, field.name]}.count = 0u;"
        yield f"  {kept}.closed = false;"
        yield f"  {kept}.set = false;"
    for signal in given.lanes:
        yield "  for (size_t lane = 0u; lane < TM_MAX_ELEMENTS; ++lane) {"
        yield f"    c->lanes.{given.signals[signal.name]}[lane].set = false;"
        yield f"    c->lanes.{given.signals[signal.name]}[lane].bad = false;"
        yield "  }"
    for name in LIMITS:
        yield f"  c->limits.{name} = 0.0;"
        yield f"  own.limits.{name} = TM_NAN; /* what tm_defaults leaves out is refused */"
    for c_name in plan.params.values():
        yield f"  c->params.{c_name} = TM_NAN;"
        yield f"  own.params.{c_name} = TM_NAN;"
    for c_name in plan.tables.values():
        yield f"  c->tables.{c_name}.count = 0u;"
        yield f"  own.tables.{c_name}.knots = NULL;"
        yield f"  own.tables.{c_name}.values = NULL;"
        yield f"  own.tables.{c_name}.count = 0u;"
    yield from places(plan)
    if plan.remembers:
        yield "  c->run.any = false;"
        yield "  c->run.missed = 0u;"
        yield "  c->run.crowded = false;"
        yield "  c->run.serial = 0u;"
        yield "  c->run.number = 0;"
        yield "  c->run.begun = 0u;"
    yield "  tm_defaults(&own);"
    yield "  said = tm_configure(c, &own);"
    yield "  c->made = TM_MADE;"
    yield "  return (said.status == TM_OK) ? status : said.status;"
    yield "}"
    yield ""
