"""Running inline tests, with both evaluators, and which rules they cover."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from trackmarshal.backends.over_run.program import remembers
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.margins import SCALED
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.records import not_on_it
from trackmarshal.runtime.verdict import RuleResult
from trackmarshal.testing.boundary import Distances, near
from trackmarshal.testing.cases import PreparedTest
from trackmarshal.testing.moving import moved, moves
from trackmarshal.testing.si import spec_in_si
from trackmarshal.units import beside, written


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a test: passed, failed (with what was found instead) or error.

    unmoved: of one that stands on the boundary of its rule, and passes with limits moved as well, which way; else empty.
    """

    test: PreparedTest
    outcome: str
    message: str
    unmoved: str = ""


@dataclass(frozen=True, slots=True)
class Coverage:
    """Which sides of a rule's boundary its tests stand on. beside: of tests that are to be on it and are not, why."""

    rule: RuleInfo
    tests: int
    satisfied: bool
    violated: bool
    boundary: bool
    beside: tuple[str, ...] = ()

    @property
    def complete(self) -> bool:
        return self.satisfied and self.violated and (self.boundary or not has_boundary(self.rule))


def has_boundary(rule: RuleInfo) -> bool:
    """Whether a rule compares numbers, so that a case can lie exactly on its boundary."""
    return rule.unit != "1" or any(
        type(n).__name__ == "Compare" and getattr(n, "op", "") != "is" for n in _nodes(rule)
    )


def _nodes(rule: RuleInfo) -> Iterator[object]:
    from trackmarshal.ir.nodes import below

    return below(rule.formula) if rule.formula is not None else iter(())


def run_tests(
    spec: Spec,
    tests: Iterable[PreparedTest],
    backends: tuple[str, ...] = ("reference", "numpy"),
    distances: Distances | None = None,
) -> Iterator[Outcome]:
    """Run each test with each evaluator; it passes when all of them say what it expects.

    Those that stand on the boundary of their rule are run again with its limits moved by `distances`.
    """
    distances = distances or Distances()
    evaluators: dict[tuple[str, str], Evaluator] = {}
    spec = spec_in_si(spec)
    for test in tests:
        message = ""
        outcome = "passed"
        for backend in backends:
            key = (test.rule.name, backend)
            if key not in evaluators:
                evaluators[key] = Evaluator(spec, [test.rule.name], backend)
            try:
                evaluator = evaluators[key]
                result = _result(evaluator, test)
            except TrackmarshalError as error:
                outcome, message = "error", f"{backend}: {error.message}"
                break
            problem = mismatch(test, result)
            if problem:
                outcome, message = "failed", f"{backend}: {problem}"
                break
        on_it = outcome == "passed" and near(test, spec, distances).narrow
        yield Outcome(test, outcome, message, _unmoved(spec, test, distances) if on_it else "")


def _unmoved(spec: Spec, test: PreparedTest, distances: Distances) -> str:
    """Which way a rule's limits can be moved so that a test passes all the same; empty where it fails both ways.

    The reference alone is asked: what is looked for is whether the test could fail. `spec` reads data in SI.
    """
    formula = test.rule.formula
    assert formula is not None, "a test of a rule without a formula"
    held = [
        way
        for way, tried in zip(("looser", "stricter"), moves(formula))
        if not any(_fails(spec, test, moved(formula, move, distances.of)) for move in tried)
    ]
    return " or ".join(held)


def _fails(spec: Spec, test: PreparedTest, formula: ir.Formula) -> bool:
    """Whether a test fails where its rule is another formula. One that leaves it open, or undefined, shows nothing of a limit."""
    rule = RuleInfo(**{**test.rule.__dict__, "formula": formula})
    rules = tuple(rule if one.name == rule.name else one for one in spec.rules)
    evaluator = Evaluator(Spec(**{**spec.__dict__, "rules": rules}), [rule.name], "reference")
    other = PreparedTest(**{**test.__dict__, "rule": rule})
    result = _result(evaluator, other)
    return result.verdict in ("satisfied", "violated") and bool(mismatch(other, result))


def _result(evaluator: Evaluator, test: PreparedTest) -> RuleResult:
    """What the rule says in a test's case; of a rule over the run, in the last of its cycles."""
    if not remembers(test.rule):
        return next(iter(evaluator.evaluate([evaluator.read(test.case)]))).rules[test.rule.name]
    run = evaluator.over_run()
    for t, signals in ((0.0, test.case["signals"]), *test.later):
        named = {name: _named(value) for name, value in signals.items()}
        result = run.step(evaluator.read({**test.case, "signals": named, "t": t}))
    return result.rules[test.rule.name]


def _named(value: Any) -> Any:
    """The elements of a set with ids: they are told apart by their places in the list."""
    if not isinstance(value, list):
        return value
    return [
        {"id": str(number), **element} if isinstance(element, dict) else element
        for number, element in enumerate(value)
    ]


def mismatch(test: PreparedTest, result: RuleResult) -> str:
    """What differs from what the test expects; empty when nothing does."""
    margin = f", margin {beside(result.margin, result.unit, result.shown, 9)}"
    if result.verdict != test.verdict:
        reason = f" ({result.reason})" if result.reason else ""
        return f"expected {test.verdict}, got {result.verdict}{margin}{reason}"
    if test.margin is not None and not _close(result.margin, test.margin, test.tolerance):
        unit, shown = result.unit, result.shown
        within = f" within {written(test.tolerance, unit, shown)}" if test.tolerance else ""
        expected = written(test.margin, unit, shown, 9)
        return f"expected margin {expected}{within}, got {beside(result.margin, unit, shown, 12)}"
    unit = result.witness.unit if test.rule.unit == SCALED and result.witness else result.unit
    if test.unit is not None and unit != test.unit:
        return f"expected a margin in {test.unit}, the comparison that decides is in {unit}"
    if test.binder is not None:
        binders = result.witness.binders if result.witness is not None else {}
        if str(binders.get(test.binder)) != test.at:
            return f"expected {test.binder} = {test.at} to decide, got {binders or 'nothing'}"
    return ""


def _close(value: float, wanted: float, tolerance: float) -> bool:
    if math.isnan(wanted):
        return math.isnan(value)
    return value == wanted or abs(value - wanted) <= tolerance


def coverage(
    spec: Spec,
    tests: Iterable[PreparedTest],
    unmoved: Mapping[tuple[str, str], str] | None = None,
    distances: Distances | None = None,
) -> list[Coverage]:
    """Every rule and monitor with what its tests show, in the order of the spec.

    unmoved: of tests that were run, by rule and title, which way limits can be moved so that they pass all the same.
    """
    distances, unmoved = distances or Distances(), unmoved or {}
    by_rule: dict[str, list[PreparedTest]] = {}
    for test in tests:
        by_rule.setdefault(test.rule.name, []).append(test)
    result = []
    for rule in spec.rules:
        if rule.formula is None:
            continue
        own = by_rule.get(rule.name, [])
        verdicts = {test.verdict for test in own}
        said = [
            not_on_it(test.title, *near(test, spec, distances), unmoved.get((rule.name, test.title), ""))
            for test in own
            if near(test, spec, distances).distance
        ]
        on_it = any(not why for why in said)
        result.append(
            Coverage(
                rule,
                len(own),
                "satisfied" in verdicts,
                "violated" in verdicts,
                on_it,
                () if on_it else tuple(said),
            )
        )
    return result
