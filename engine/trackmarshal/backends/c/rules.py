"""One C function a rule: first taking everything for known, then, only where something is not, with worst and best cases."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.expressions import Writer, takes_several, told_by_margin
from trackmarshal.backends.c.layout import Layout, roots
from trackmarshal.backends.c.names import comment, written
from trackmarshal.backends.c.slots import assign
from trackmarshal.backends.over_run.outcome import is_ahead
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.spec import RuleInfo

#: How deep formulas may be nested; the generator goes down by calls.
DEEPEST = 900
#: Parameters of the functions of rules.
PARAMETERS = (("tm_context *", "context"), ("const tm_input *", "in"), ("tm_result *", "out"))
_OUT = c.Name("out")
#: What formulas are in C: where everything is known, and where something is not.
TRUTH = """/* Whether a formula holds, and by how much; `doubt`: zero, or NaN where something that it needs is missing. */
typedef struct {
  double margin;
  bool sat;
  double doubt;
} tm_truth;
"""
CASES = """/* The margin of a formula and whether it holds, in the worst and in the best case of what is not known (strong Kleene logic). */
typedef struct {
  double worst;
  double best;
  bool worst_sat;
  bool best_sat;
} tm_cases;
"""
#: Formulas of several samples at once.
SEVERAL = """/* How many samples are worked out at once: as many as a register of the target holds. Results are the same for any number. */
#ifndef TM_SEVERAL
#ifdef __AVX__
#define TM_SEVERAL 4u
#else
#define TM_SEVERAL 1u
#endif
#endif

#if TM_SEVERAL > 1u
/* What holds of all samples, or of one, of each place of a pass by itself: the margin, and `doubt` as above; and what the samples of the
   present pass add: whether they are in range (1, -1), and the margin, NaN where that is not known. */
typedef struct {
  double margin[TM_SEVERAL];
  double doubt[TM_SEVERAL];
  double guard[TM_SEVERAL];
  double body[TM_SEVERAL];
} tm_several;
#endif
"""

#: How often formulas held in C.
TALLY = """/* How often something held, surely and possibly, and whether the count starts anew there. */
typedef struct {
  uint64_t sure;
  uint64_t possible;
  bool surely_anew;
  bool possibly_anew;
} tm_tally;
"""

#: Numbers of many in C, while they are worked out.
FOLD = """/* One number of many, so far; `place`: which one has it, -1.0 where there is none. */
typedef struct {
  double value;
  double place;
  bool some;
} tm_fold;
"""


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

    @property
    def operations(self) -> tuple[tuple[tuple[str, ...], int], ...]:
        """For every body of the function: the signals whose loops it lies in, and how many values it computes."""
        return tuple(_operations(self.counted.body, ()))


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
            texts = [_either(counted, at_once), *texts, list(c.printed(whole))]
            entry, series = whole.name, max(series, more)
        along, most = ("", 0) if rule.along is None or rule.course is not None else _along(plan, rule)
    except RecursionError as error:
        span = rule.span
        raise TrackmarshalError(
            "E470", f"rule `{rule.name}` is nested too deeply", file=span.file.path, line=span.line
        ) from error
    head = [
        f"/* {about(rule)[0]}",
        *(f"   {line}".rstrip() for line in about(rule)[1:-1]),
        f"   {about(rule)[-1]} */",
    ]
    lines = [line for text in texts for line in (*text, "")]
    return RuleCode(rule, name, entry, "\n".join([*head, *lines]), max(series, most), along, counted)


def _either(one: c.Function, several: c.Function | None) -> list[str]:
    """The text of a function that takes one sample after the other, and of the one beside it where there is one that takes several."""
    text = [] if several is None else list(c.printed(several))
    if not any("tm_several " in line for line in text):
        return list(c.printed(one))
    return ["#if TM_SEVERAL > 1u", *text, "#else", *c.printed(one), "#endif"]


def _waiting(plan: Layout, rule: RuleInfo) -> tuple[c.Function, int]:
    """The function of a rule that looks ahead: what is said of the last cycles was worked out for all such rules."""
    future = c.Address(c.Member(c.Member(c.Name("context"), "run", True), "future", False))
    number = c.Literal(f"{[each.name for each in plan.future.rules].index(rule.name)}u")
    said = c.Evaluate(c.Call("tm_worst_said", (future, number, _OUT)))
    body = (c.Evaluate(c.Name("in"), True), said)
    name = f"tm_rule_{plan.rule_names[rule.name]}_any"
    return c.Function((_SAID[False],), "void", name, PARAMETERS, body), 0


def _operations(
    body: Iterable[c.Statement], around: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], int]]:
    own = 0
    for item in body:
        own += sum(
            [1 for expr in c.expressions(item) for each in c.within(expr) if isinstance(each, _COMPUTED)]
        )
        if isinstance(item, c.For | c.If):
            yield from _operations(
                item.body, (*around, item.over) if isinstance(item, c.For) and item.over else around
            )
    yield around, own


#: What the report counts as a value computed.
_COMPUTED = (c.Call, c.Unary, c.Binary, c.Conditional, c.Element)


def _function(plan: Layout, rule: RuleInfo, known: bool, several: bool = False) -> tuple[c.Function, int]:
    """A rule's function, and the series that it needs. several: it takes several samples at once."""
    formula, active = rule.formula, rule.active
    assert formula is not None
    writer = Writer(plan, [rule], known, [formula], [] if active is None else [active], several)
    _unless_asked(writer, rule)
    for said in _said(writer, rule, *_value(writer)):
        writer.add(writer.root, said)
    body, series = finished(writer)
    name = f"tm_rule_{plan.rule_names[rule.name]}"
    suffix, result = ("known", "bool") if known else ("any", "void")
    made = c.Function((_SAID[known],), result, f"{name}_{suffix}", PARAMETERS, body)
    return made, series


def _said(writer: Writer, rule: RuleInfo, holds: c.Expr, applies: c.Expr) -> tuple[c.Statement, ...]:
    """What a rule says, at the end of its function."""
    if writer.known:
        return (c.Return(_concluded(writer, rule, writer.name("out"), applies, holds)),)
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


def _concluded(writer: Writer, rule: RuleInfo, out: c.Expr, applies: c.Expr, holds: c.Expr) -> c.Expr:
    """What a rule says where everything is known. Where its margin tells whether it holds, nobody has to keep that besides."""
    assert rule.formula is not None
    return writer.over("conclude_margin" if told_by_margin(rule.formula) else "conclude", out, applies, holds)


#: What the two kinds of functions are.
_SAID = {
    True: "Where everything is known; false, and nothing is said, where something is not.",
    False: "The worst and the best case of what is not known.",
}


def about(rule: RuleInfo) -> tuple[str, ...]:
    """Lines of a comment on a rule: where it is, and how it is written."""
    place = comment(f"{rule.span.file.path}:{rule.span.line}")
    text = written(rule.text) or (comment(f"{rule.name}: {rule.title}"),)
    return (f"{place}; margin in {comment(rule.unit)}.", "", *(f"  {line}" if line else "" for line in text))


def _value(writer: Writer) -> tuple[c.Expr, c.Expr]:
    """Whether a rule holds, and whether it applies."""
    formula, active, root = writer.formulas[0], writer.guards[0] if writer.guards else None, writer.root
    outer, inner = _outermost(formula), None if active is None else _outermost(active)
    if outer is not None and inner is not None and outer.axis is inner.axis and not writer.facts.free(outer):
        names = ["all" if outer.extreme is Extreme.LEAST else "some", "applies"]
        root.known.update(zip((outer, inner), writer.quantify([outer, inner], root, names=names)))
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


def _names(body: Iterable[c.Statement]) -> Iterator[str]:
    """The names that statements, and those within, read."""
    for item in body:
        for expr in c.expressions(item):
            yield from (each.name for each in c.within(expr) if isinstance(each, c.Name))
        if isinstance(item, c.For | c.If):
            yield from _names(item.body)


def finished(
    writer: Writer, parameters: tuple[str, ...] = ("context", "in")
) -> tuple[tuple[c.Statement, ...], int]:
    """A function's body with all that it needs around what was written, and how many series it has."""
    body = writer.root.statements([""])
    series = 0
    if writer.slots:
        body, series = assign(body)
        if writer.known:
            *before, last = body
            unknown = c.If(c.Unary("!", c.Name("known")), (c.Return(c.Literal("false")),))
            body = (c.Declare("bool", "known", c.Literal("true"), False), *before, unknown, last)
    read = set(_names(body))
    unused = [c.Evaluate(c.Name(name), True) for name in parameters if name not in read]
    return (*unused, *body), series


def _along(plan: Layout, rule: RuleInfo) -> tuple[str, int]:
    """The formula at every sample of the rule's timeline, and the series that it needs."""
    assert isinstance(rule.formula, ir.At)
    axis, operand = rule.formula.axis, rule.formula.operand
    writer = Writer(plan, [rule], False, [operand])
    operand = writer.formulas[0]
    loop = writer.loop(axis, writer.root, (rule.formula.name,))
    value = writer.formula(operand, loop)
    at = c.Address(c.Element(writer.name("out"), writer.index(axis, loop)))
    writer.add(loop, c.Evaluate(writer.over("conclude", at, writer.over("true"), value)))
    writer.root.close(loop)
    body, series = finished(writer)
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
        for root in roots(rule)
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


@dataclass(frozen=True)
class GroupCode:
    """Rules over one timeline or set whose functions for known values are joined in one loop."""

    rules: tuple[RuleInfo, ...]
    c_name: str
    text: str


def group_codes(plan: Layout) -> list[GroupCode]:
    """The groups of rules that can share a loop: what they compute alike is computed once, and the loop runs once."""
    found: dict[ir.Axis, list[RuleInfo]] = {}
    for rule in plan.rules:
        axis = _axis(rule)
        if axis is not None:
            found.setdefault(axis, []).append(rule)
    groups = [(axis, rules) for axis, rules in found.items() if len(rules) > 1]
    return [
        _group(plan, f"{plan.input(axis.signal).c_name}_{i}", rules) for i, (axis, rules) in enumerate(groups)
    ]


def _axis(rule: RuleInfo) -> ir.Axis | None:
    """The timeline or set that a rule quantifies over, if it does nothing else that loops; a projection on a prepared line does not."""
    formula, active = rule.formula, rule.active
    if not isinstance(formula, ir.Quantify) or rule.over_run:
        return None
    if active is not None and not (isinstance(active, ir.Quantify) and active.axis is formula.axis):
        return None
    looping = ir.Quantify | ir.Fold | ir.At | ir.Timed | ir.Geometry
    inner = [
        node
        for root in roots(rule)
        for node in ir.below(root)
        if (isinstance(node, looping) and node is not root)
        or (isinstance(node, ir.Along) and node.line.kind == "path")
    ]
    return None if inner else formula.axis


def _group(plan: Layout, name: str, rules: Sequence[RuleInfo]) -> GroupCode:
    one = _joined(plan, name, rules)
    several = _joined(plan, name, rules, True) if takes_several(plan, rules) else None
    return GroupCode(tuple(rules), one.name, "\n".join([*_either(one, several), ""]))


def _joined(plan: Layout, name: str, rules: Sequence[RuleInfo], several: bool = False) -> c.Function:
    """The function of a group. several: it takes several samples at once."""
    formulas = [rule.formula for rule in rules if rule.formula is not None]
    guards = [rule.active for rule in rules if rule.active is not None]
    writer = Writer(plan, rules, True, formulas, guards, several)
    owners: list[RuleInfo] = []
    names: list[str] = []
    nodes: list[ir.Quantify] = []
    waiting = iter(writer.guards)
    for rule, formula in zip(rules, writer.formulas):
        for root, ending in ((formula, ""), (None if rule.active is None else next(waiting), "_applies")):
            if isinstance(root, ir.Quantify):
                nodes.append(root)
                owners.append(rule)
                names.append(plan.rule_names[rule.name] + ending)
    values = dict(zip(names, writer.quantify(nodes, writer.root, owners, names)))
    for rule in rules:
        writer.of(rule)
        c_name = plan.rule_names[rule.name]
        place = c.Member(writer.name("out"), "rule", True)
        result = c.Address(c.Element(place, c.Name(f"TM_RULE_{c_name.upper()}")))
        applies = values.get(f"{c_name}_applies", writer.over("true"))
        said = _concluded(writer, rule, result, applies, values[c_name])
        full = writer.call(f"tm_rule_{c_name}_any", writer.name("context"), writer.name("in"), result)
        writer.add(writer.root, c.If(c.Unary("!", said), (c.Evaluate(full),)))
    body, _ = finished(writer)
    comment_ = (
        f"In one loop: {comment(', '.join(rule.name for rule in rules))}; each by itself where something that it needs is not known.",
    )
    parameters = (*PARAMETERS[:2], ("tm_output *", "out"))
    return c.Function(comment_, "void", f"tm_rules_{name}", parameters, body)
