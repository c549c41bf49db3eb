"""One C function a rule: first taking everything for known, then, only where something is not, with worst and best cases."""

from __future__ import annotations

from dataclasses import dataclass

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.expressions import Expressions
from trackmarshal.backends.c.functions.margins import told_by_margin
from trackmarshal.backends.c.functions.quantifiers import quantify
from trackmarshal.backends.c.functions.several import either, takes_several
from trackmarshal.backends.c.functions.writer import Writer
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import comment, where, written
from trackmarshal.backends.over_run.outcome import is_ahead
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.spec import RuleInfo

#: Parameters of the functions of rules.
PARAMETERS = (("tm_context *", "context"), ("const tm_input *", "in"), ("tm_result *", "out"))
_OUT = c.Name("out")


@dataclass(frozen=True)
class RuleCode:
    """The functions of a rule, and what the report says about them."""

    rule: RuleInfo
    c_name: str
    #: The function that computes it by itself.
    entry: str
    text: str
    series: int
    #: A function that says the formula's value at every sample, for the binding; empty for rules without a timeline.
    along: str
    #: The function whose values the report counts.
    counted: c.Function


def constant(c_name: str) -> str:
    """The place of a rule's result among all results, as C calls it."""
    return f"TM_RULE_{c_name.upper()}"


def rule_code(plan: Layout, rule: RuleInfo, grouped: bool) -> RuleCode:
    """Write a rule; raises TrackmarshalError E470 for what has no C counterpart. grouped: its function for known values is that of a group."""
    name = plan.rule_names[rule.name]
    try:
        waits = is_ahead(rule)
        full, series = _waiting(plan, rule) if waits else _function(plan, rule, False)
        texts, entry, counted = [list(c.printed(full))], f"tm_rule_{name}_any", full
        if not grouped and not rule.over_run:
            counted, more = _function(plan, rule, True)
            at_once, _ = _function(plan, rule, True, True) if takes_several(plan, [rule]) else (None, 0)
            whole = _entry(plan, rule, name)
            texts = [either(counted, at_once), *texts, list(c.printed(whole))]
            entry, series = whole.name, max(series, more)
        along, most = ("", 0) if rule.along is None or rule.course is not None else _along(plan, rule)
    except RecursionError as error:
        span = rule.span
        raise TrackmarshalError(
            "E470", f"rule `{rule.name}` is nested too deeply", file=span.file.path, line=span.line
        ) from error
    first, *others, last = _about(rule)
    head = [f"/* {first}", *(f"   {line}".rstrip() for line in others), f"   {last} */"]
    lines = [line for text in texts for line in (*text, "")]
    return RuleCode(rule, name, entry, "\n".join([*head, *lines]), max(series, most), along, counted)


def _waiting(plan: Layout, rule: RuleInfo) -> tuple[c.Function, int]:
    """The function of a rule that looks ahead: what is said of the last cycles was worked out for all such rules."""
    future = c.Address(c.Member(c.Member(c.Name("context"), "run", True), "future", False))
    number = c.Literal(f"{[each.name for each in plan.future.rules].index(rule.name)}u")
    said = c.Evaluate(c.Call("tm_worst_said", (future, number, _OUT)))
    body = (c.Evaluate(c.Name("in"), True), said)
    name = f"tm_rule_{plan.rule_names[rule.name]}_any"
    return c.Function((_SAID[False],), "void", name, PARAMETERS, body), 0


def _function(plan: Layout, rule: RuleInfo, known: bool, several: bool = False) -> tuple[c.Function, int]:
    """A rule's function, and the series that it needs. several: it takes several samples at once."""
    formula, active = rule.formula, rule.active
    assert formula is not None
    writer = Expressions(plan, [rule], known, [formula], [] if active is None else [active], several)
    _unless_asked(writer, rule)
    for said in _said(writer, rule, *_value(writer)):
        writer.add(writer.root, said)
    body, series = writer.finished()
    name = f"tm_rule_{plan.rule_names[rule.name]}"
    suffix, result = ("known", "bool") if known else ("any", "void")
    made = c.Function((_SAID[known],), result, f"{name}_{suffix}", PARAMETERS, body)
    return made, series


def _said(writer: Writer, rule: RuleInfo, holds: c.Expr, applies: c.Expr) -> tuple[c.Statement, ...]:
    """What a rule says, at the end of its function."""
    if writer.known:
        return (c.Return(concluded(writer, rule, writer.name("out"), applies, holds)),)
    return (c.Evaluate(writer.over("conclude", writer.name("out"), applies, holds)),)


def _unless_asked(writer: Writer, rule: RuleInfo) -> None:
    """Before all else of a rule with a `whenever`: where that does not hold, the rest is not worked out. What is remembered is noted elsewhere."""
    formula, root = writer.formulas[0], writer.root
    if not isinstance(formula, ir.Guarded):
        return
    guard = writer.formula(formula.guard, root, "guard", named=True)
    inactive = _said(writer, rule, writer.over("whenever", guard, writer.over("true")), guard)
    ended = inactive if writer.known else (*inactive, c.Return())
    writer.add(root, c.If(c.Unary("!", writer.over("may_hold", guard)), ended))


def concluded(writer: Writer, rule: RuleInfo, out: c.Expr, applies: c.Expr, holds: c.Expr) -> c.Expr:
    """What a rule says where everything is known. Where its margin tells whether it holds, nobody has to keep that besides."""
    assert rule.formula is not None
    return writer.over("conclude_margin" if told_by_margin(rule.formula) else "conclude", out, applies, holds)


#: What the two kinds of functions are.
_SAID = {
    True: "Where everything is known; false, and nothing is said, where something is not.",
    False: "The worst and the best case of what is not known.",
}


def _about(rule: RuleInfo) -> tuple[str, ...]:
    """Lines of a comment on a rule: where it is, and how it is written."""
    text = written(rule.text) or (comment(f"{rule.name}: {rule.title}"),)
    return (
        f"{where(rule.span)}; margin in {comment(rule.unit)}.",
        "",
        *(f"  {line}" if line else "" for line in text),
    )


def _value(writer: Writer) -> tuple[c.Expr, c.Expr]:
    """Whether a rule holds, and whether it applies."""
    formula, active, root = writer.formulas[0], writer.guards[0] if writer.guards else None, writer.root
    outer, inner = _outermost(formula), None if active is None else _outermost(active)
    if outer is not None and inner is not None and outer.axis is inner.axis and not writer.facts.free(outer):
        names = ["all" if outer.extreme is Extreme.LEAST else "some", "applies"]
        root.known.update(zip((outer, inner), quantify(writer, [outer, inner], root, names=names)))
    holds = writer.formula(formula, root)
    applies = writer.over("true") if active is None else writer.formula(active, root, "applies")
    return holds, applies


def _outermost(formula: ir.Formula) -> ir.Quantify | None:
    """The one quantifier that a formula is, whatever has to hold besides."""
    if isinstance(formula, ir.Quantify):
        return formula
    if isinstance(formula, ir.Guarded):
        return _outermost(formula.body)
    if isinstance(formula, ir.Connective):
        found = [each for each in map(_outermost, (formula.left, formula.right)) if each is not None]
        return found[0] if len(found) == 1 else None
    return None


def _along(plan: Layout, rule: RuleInfo) -> tuple[str, int]:
    """The formula at every sample of the rule's timeline, and the series that it needs."""
    assert isinstance(rule.formula, ir.At)
    axis, operand = rule.formula.axis, rule.formula.operand
    writer = Expressions(plan, [rule], False, [operand])
    operand = writer.formulas[0]
    loop = writer.loop(axis, writer.root, (rule.formula.name,))
    value = writer.formula(operand, loop)
    at = c.Address(c.Element(writer.name("out"), writer.index(axis, loop)))
    writer.add(loop, c.Evaluate(writer.over("conclude", at, writer.over("true"), value)))
    writer.root.close(loop)
    body, series = writer.finished()
    undefined: list[c.Statement] = []
    for times, count in _timed(plan, rule):
        each = c.Evaluate(c.Call("tm_undefined", (c.Address(c.Element(_OUT, c.Name("i"))),)))
        step = c.Unary("++", c.Name("i"))
        all_of_them = c.For("i", c.Binary("<", c.Name("i"), count), step, (each,))
        undefined.append(c.If(_out_of_order(times, count), (all_of_them, c.Return())))
    said = (f"{comment(rule.name)} at every sample.",)
    made = c.Function(
        said, "void", f"tm_rule_{plan.rule_names[rule.name]}_along", PARAMETERS, (*undefined, *body)
    )
    return "\n".join([*c.printed(made), ""]), series


def _out_of_order(times: c.Expr, count: c.Expr) -> c.Expr:
    return c.Unary("!", c.Call("tm_times", (times, count)))


def _timed(plan: Layout, rule: RuleInfo) -> list[tuple[c.Expr, c.Expr]]:
    """C of the times and their number of every timeline that temporal operators of a rule run along."""
    places = {
        (plan.input(node.axis.signal).c_name, plan.field_name(node.axis.signal, "t"))
        for root in rule.roots
        for node in ir.below(root)
        if isinstance(node, (ir.Temporal, ir.Until, ir.Tallied)) and node.axis.signal not in plan.courses
    }
    signals = [(c.Member(c.Name("in"), signal, True), t) for signal, t in sorted(places)]
    return [(c.Member(signal, t, False), c.Member(signal, "count", False)) for signal, t in signals]


def _entry(plan: Layout, rule: RuleInfo, name: str) -> c.Function:
    """The function of a rule that others call."""
    given = tuple(c.Name(each) for _, each in PARAMETERS)
    body: list[c.Statement] = []
    for times, count in _timed(plan, rule):
        undefined = c.Evaluate(c.Call("tm_undefined", (_OUT,)))
        body.append(c.If(_out_of_order(times, count), (undefined, c.Return())))
    if rule.course is not None:  # put together before the rules are asked
        courses = c.Member(c.Name("context"), "course", True)
        joined = c.Member(courses, plan.courses[rule.course.signal.name].c_name, False)
        none = c.Binary("==", c.Member(joined, "count", False), c.Literal("0u"))
        body.append(c.If(none, (c.Evaluate(c.Call("tm_undefined", (_OUT,))), c.Return())))
    full = c.Evaluate(c.Call(f"tm_rule_{name}_any", given))
    body.append(c.If(c.Unary("!", c.Call(f"tm_rule_{name}_known", given)), (full,)))
    return c.Function((), "void", f"tm_rule_{name}", PARAMETERS, tuple(body))
