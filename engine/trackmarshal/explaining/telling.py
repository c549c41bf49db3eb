"""What is told of a rule's verdict in one cycle: the verdict, what decided it, and every number in that."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from trackmarshal.backends.over_run.history import recalled_of
from trackmarshal.explaining.numbers import Env, kept_units, numbers
from trackmarshal.explaining.scope import Alone, Cycle, InRun, why_inactive
from trackmarshal.explaining.trail import Trail, at
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.margins import undecided
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.lowering.rules import levels_of
from trackmarshal.runtime.verdict import About, RuleResult, Witness, decides
from trackmarshal.units import beside

if TYPE_CHECKING:
    from trackmarshal.backends.over_run.history import History
    from trackmarshal.backends.reference.evaluator import Reference


def told(rule: RuleInfo, result: RuleResult, values: Reference) -> list[str]:
    """Of a rule about one cycle alone."""
    return [*_verdict(rule, result), *behind(rule, result, values)]


def behind(rule: RuleInfo, result: RuleResult, values: Reference) -> list[str]:
    """The same without the verdict. What the result says that decided is not looked for again, whichever evaluator found it."""
    from trackmarshal.backends.witness import Descent

    lines = [f"  {result.reason}"] if result.reason and result.verdict != "inactive" else []
    if rule.formula is None or values.frame.unusable(rule.reads):
        return lines
    if result.verdict == "inactive":
        return lines + _inactive(rule, Alone(values))
    witness = result.witness
    if witness is None:
        witness = Descent(values).find(rule.formula)
    if witness is None or witness.at is None:
        return lines
    node, env = witness.at
    return [*lines, *_decided(rule, witness, node, dict(env), values, witness.binders)]


def told_over_run(rule: RuleInfo, result: RuleResult, history: History) -> list[str]:
    """Of a rule over the run, in the last cycle of a history: about this cycle, and about those that are decided in it."""
    return [*_verdict(rule, result), *behind_over_run(rule, result, history)]


def behind_over_run(rule: RuleInfo, result: RuleResult, history: History) -> list[str]:
    """The same without the verdict."""
    assert rule.formula is not None
    lines: list[str] = []
    places = {cycle.name: place for place, cycle in enumerate(history.cycles)}
    for about in result.about:
        place = places[about.cycle]
        now = history.cycles[place].now
        assert now is not None, "cycles are kept whole where they are explained"
        lines.append(f"  about the cycle at {at(now.t)}: {_said(about, rule)}")
        missing = now.frame.unusable(rule.reads)
        if missing is not None:
            lines.append(f"  {missing}")
        elif about.verdict == "inactive":
            lines += _inactive(rule, InRun(now.reference({}), history, place))
        else:
            lines += _trail(rule, rule.formula, history, place)
    return lines


def _trail(rule: RuleInfo, formula: ir.Formula, history: History, place: int) -> list[str]:
    trail = Trail(history)
    found = trail.find(formula, place, {})
    lines = [f"  {line}" for line in trail.said]
    if found is not None:
        lines += _decided(rule, found.witness, found.node, found.env, found.values, trail.binders)
    return lines


def _verdict(rule: RuleInfo, result: RuleResult) -> Iterator[str]:
    yield f"{rule.name}: {rule.title}"
    yield f"  {result.verdict}, margin {beside(result.margin, result.unit, result.shown, 9)}{decides(result)}"
    yield f"  satisfies {', '.join(name for name, _ in rule.satisfies) or 'nothing'}; declared at {rule.span}"


def _said(about: About, rule: RuleInfo) -> str:
    if about.verdict in ("open", "inactive"):
        return about.verdict
    return f"{about.verdict}, margin {beside(about.margin, undecided(rule.unit), '', 9)}{'' if about.final else ', which may still change'}"


def _inactive(rule: RuleInfo, cycle: Cycle) -> list[str]:
    if rule.typed is None:
        return ["  nothing in its range"]
    return [f"  {line}" for line in why_inactive(levels_of(rule.typed), cycle)] or ["  nothing in its range"]


def _decided(
    rule: RuleInfo, witness: Witness, node: ir.Formula, env: Env, values: Reference, binders: dict[str, str | int]
) -> Sequence[str]:  # fmt: skip
    """The comparison that decided, at which samples and elements, with every number in it."""
    lines = []
    if binders:
        lines.append("  decided at " + ", ".join(f"{name} = {index}" for name, index in binders.items()))
    if witness.span is not None:
        lines.append(f"  by {witness.span}: {witness.span.in_line}")
    kept = kept_units(rule) if recalled_of(node) else {}
    return lines + [f"    {text} = {shown}" for text, shown in numbers(node, env, values, rule.names, kept)]
