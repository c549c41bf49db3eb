"""Running inline tests, with both evaluators, and which rules they cover."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from typing import Any, NamedTuple

from trackmarshal.backends.over_run.program import Remembering
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.margins import SCALED, margin_units
from trackmarshal.ir.spec import RuleInfo, Spec, remembers
from trackmarshal.records.tests import apart, not_on_it
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.verdict import VERDICTS, RuleResult
from trackmarshal.testing.boundary import Distances, near
from trackmarshal.testing.cases import PreparedTest
from trackmarshal.testing.moving import moved, moves
from trackmarshal.testing.si import spec_in_si
from trackmarshal.units import beside, written

#: How many tests a rule has at least, by side, where a project does not say otherwise.
ONE_EACH = (("satisfied", 1), ("violated", 1), ("boundary", 1))


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
    """Which sides of a rule's boundary its tests stand on: at least one of them, and as many as are asked for. beside: of tests that are to be on it and
    are not, why; and of copies of tests, where some are lacking, of which. lacking: the sides that are asked for and lack tests, with how many."""

    rule: RuleInfo
    tests: int
    satisfied: bool
    violated: bool
    boundary: bool
    beside: tuple[str, ...] = ()
    lacking: tuple[tuple[str, int], ...] = ()

    @property
    def complete(self) -> bool:
        return not self.lacking


def has_boundary(rule: RuleInfo) -> bool:
    """Whether a rule's margin is made of numbers, so that a case can lie exactly on its boundary: guards choose what is demanded, and no case lies on one."""
    return rule.formula is not None and bool(margin_units(rule.formula))


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
    spec = spec_in_si(spec)
    evaluators: dict[tuple[str, str], Evaluator] = {}
    for name, group in groupby(tests, lambda test: test.rule.name):
        together = list(group)
        frames: Frames = {}
        problems = dict.fromkeys(range(len(together)), ("passed", ""))
        for backend in backends:
            left = [place for place, (outcome, _) in problems.items() if outcome == "passed"]
            key = (name, backend)
            if left and key not in evaluators:
                evaluators[key] = Evaluator(spec, [name], backend)
            found = _problems(evaluators[key], [together[place] for place in left], frames) if left else []
            problems |= {
                place: (outcome, f"{backend}: {message}" if message else "")
                for place, (outcome, message) in zip(left, found, strict=True)
            }
        for test, (outcome, message) in zip(together, problems.values()):
            on_it = outcome == "passed" and near(test, spec, distances).narrow
            unmoved = _unmoved(spec, test, distances, frames) if on_it else ""
            yield Outcome(test, outcome, message, unmoved)


#: The cycles of cases as they were read, by the identity of their tests: what a rule reads is the same for all evaluators, and wherever its limits are.
Frames = dict[int, tuple[Frame, ...]]


def _problems(evaluator: Evaluator, tests: Sequence[PreparedTest], frames: Frames) -> list[tuple[str, str]]:
    """What becomes of tests of one rule: (passed, failed or error; why). Those of one cycle are evaluated together, if nothing is wrong with
    any of them."""
    try:
        said = _said(evaluator, tests, frames)
        return [_compared(test, one) for test, one in zip(tests, said, strict=True)]
    except TrackmarshalError as error:
        if len(tests) == 1:
            return [("error", error.message)]
    return [found for test in tests for found in _problems(evaluator, [test], frames)]


def _compared(test: PreparedTest, said: _Said) -> tuple[str, str]:
    if _as_expected(test, said):
        return "passed", ""
    result = said.result()
    # An explanation of something else than was said must not pass for what was said.
    if result.verdict != said.verdict or repr(result.margin) != repr(said.margin):
        message = (
            f"says {said.verdict} with {said.margin!r}, and explains {result.verdict} with {result.margin!r}"
        )
        return "error", message
    problem = mismatch(test, result)
    return ("failed", problem) if problem else ("passed", "")


def _unmoved(spec: Spec, test: PreparedTest, distances: Distances, frames: Frames) -> str:
    """Which way a rule's limits can be moved so that a test passes all the same; empty where it fails both ways.

    The reference alone is asked: what is looked for is whether the test could fail. `spec` reads data in SI.
    """
    formula = test.rule.formula
    assert formula is not None, "a test of a rule without a formula"
    held = [
        way
        for way, tried in zip(("looser", "stricter"), moves(formula))
        if not any(_fails(spec, test, moved(formula, move, distances.of), frames) for move in tried)
    ]
    return " or ".join(held)


def _fails(spec: Spec, test: PreparedTest, formula: ir.Formula, frames: Frames) -> bool:
    """Whether a test fails where its rule is another formula. One that leaves it open, or undefined, shows nothing of a limit."""
    rule = RuleInfo(**{**test.rule.__dict__, "formula": formula})
    rules = tuple(rule if one.name == rule.name else one for one in spec.rules)
    evaluator = Evaluator(Spec(**{**spec.__dict__, "rules": rules}), [rule.name], "reference")
    other = PreparedTest(**{**test.__dict__, "rule": rule})
    (said,) = _said(evaluator, [other], {id(other): frames[id(test)]} if id(test) in frames else {})
    if said.verdict not in ("satisfied", "violated"):
        return False
    return _differs(other, said) or _compared(other, said)[0] == "failed"


class _Said(NamedTuple):
    """What a rule says of a test's case, and with what decided it, where that is asked for."""

    verdict: str
    margin: float
    result: Callable[[], RuleResult]


def _said(evaluator: Evaluator, tests: Sequence[PreparedTest], frames: Frames) -> list[_Said]:
    """What one rule says in the cases of its tests; of a rule over the run, in the last of each one's cycles."""
    unread = [test for test in tests if id(test) not in frames]
    if tests and remembers(tests[0].rule):
        frames |= {id(test): _cycles(evaluator, test) for test in unread}
        results = [_over_run(evaluator, test, frames[id(test)]) for test in tests]
        return [_Said(result.verdict, result.margin, partial(_itself, result)) for result in results]
    if unread:  # else what reads them need not be made
        frames |= zip(map(id, unread), zip(evaluator.read_all([test.case for test in unread])))
    judged = evaluator.judge_all([frame for test in tests for frame in frames[id(test)]])
    rated = [one for each in judged for one in each.rated.values()]
    return [
        _Said(VERDICTS[one.verdicts[0]], float(one.margins[0]), partial(one.explain, 0, False))
        for one in rated
    ]


def _itself(result: RuleResult) -> RuleResult:
    return result


def _cycles(evaluator: Evaluator, test: PreparedTest) -> tuple[Frame, ...]:
    return tuple(_read(evaluator, test, *cycle) for cycle in ((0.0, test.case["signals"]), *test.later))


def _ahead(evaluator: Evaluator, cycles: Iterable[Frame]) -> None:
    """Evaluate together what the cycles of a run say by themselves. Those that it refuses, and those that are gaps in it, are not evaluated."""
    program = evaluator.program
    if isinstance(program, Remembering):
        program.ahead([frame for frame in cycles if not frame.faults and evaluator.takes(frame)])


def _over_run(evaluator: Evaluator, test: PreparedTest, cycles: Sequence[Frame]) -> RuleResult:
    _ahead(evaluator, cycles)
    run = evaluator.over_run()
    gaps = []
    *before, last = cycles
    for frame in before:
        run.remember(frame)
    result = run.step(last)
    for frame in (*before, last):
        gaps += [f"of the cycle at {frame.t:g} s nothing is known: {fault}" for fault in frame.faults[:1]]
    said = result.rules[test.rule.name]
    if not gaps or result.faults:  # what is wrong with the last cycle is its own reason
        return said
    return replace(said, reason="; ".join(filter(None, (said.reason, gaps[0]))))


def _read(evaluator: Evaluator, test: PreparedTest, t: float, signals: Mapping[str, Any]) -> Frame:
    """A cycle of a test."""
    named = {name: _named(value) for name, value in signals.items()}
    return evaluator.read({**test.case, "signals": named, "t": t})


def _named(value: Any) -> Any:
    """The elements of a set with ids: they are told apart by their places in the list."""
    if not isinstance(value, list):
        return value
    return [
        {"id": str(number), **element} if isinstance(element, dict) else element
        for number, element in enumerate(value)
    ]


def _as_expected(test: PreparedTest, said: _Said) -> bool:
    """Whether nothing differs from what a test expects, as far as verdict and margin tell, where it expects no more than that."""
    return test.unit is None and test.binder is None and not _differs(test, said)


def _differs(test: PreparedTest, said: _Said) -> bool:
    """Whether verdict or margin are others than a test expects: whatever decided them, it fails."""
    if said.verdict != test.verdict:
        return True
    return test.margin is not None and not _close(said.margin, test.margin, test.tolerance)


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
        said = f"expected margin {expected}{within}, got {beside(result.margin, unit, shown, 12)}"
        if not test.tolerance and written(result.margin, unit, shown, 9) == expected:
            said += f": the last bits differ, expect `margin about {expected} within ...`"
        return said
    unit = result.witness.unit if test.rule.unit == SCALED and result.witness else result.unit
    # Of a rule over the run, nothing keeps which comparison it was.
    known = result.witness is not None or not result.about
    if test.unit is not None and known and unit != test.unit:
        return f"expected a margin in {test.unit}, the comparison that decides is in {unit}"
    if test.binder is not None:
        binders = result.witness.binders if result.witness is not None else {}
        if str(binders.get(test.binder)) != test.at:
            decided = ", ".join(f"{name} = {value}" for name, value in binders.items())
            return f"expected {test.binder} = {test.at} to decide, got {decided or 'nothing'}"
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
    failed: Collection[tuple[str, str]] = (),
    needs: Iterable[tuple[str, int]] = ONE_EACH,
    says: Callable[[PreparedTest], str] = lambda test: "",
) -> list[Coverage]:
    """Every rule and monitor with what its tests show, in the order of the spec.

    unmoved: of tests that were run, by rule and title, which way limits can be moved so that they pass all the same. failed: those that
    did not pass, which show nothing. needs: how many tests each rule has at least, by side. says: the fingerprint of what a test gives and
    expects, by which copies are known; empty for one that is none.
    """
    wanted = dict(needs)
    distances, unmoved = distances or Distances(), unmoved or {}
    several = any(number > 1 for number in wanted.values())
    by_rule: dict[str, list[PreparedTest]] = {}
    for test in tests:
        by_rule.setdefault(test.rule.name, []).append(test)
    result = []
    for rule in spec.rules:
        if rule.formula is None:
            continue
        own = by_rule.get(rule.name, [])
        shown = [test for test in own if (rule.name, test.title) not in failed]
        again: tuple[str, ...] = ()
        if several:  # where one is enough, a copy does no harm
            shown, again = apart(shown, says)
        said = [
            not_on_it(test.title, *near(test, spec, distances), unmoved.get((rule.name, test.title), ""))
            for test in shown
            if near(test, spec, distances).distance
        ]
        have = {
            "satisfied": sum(test.verdict == "satisfied" for test in shown),
            "violated": sum(test.verdict == "violated" for test in shown),
            "boundary": sum(not why for why in said),
        }
        there = {side: have[side] >= max(1, wanted[side]) for side in have}
        lacking = tuple(
            (side, wanted[side])
            for side in have
            if have[side] < wanted[side] and (side != "boundary" or has_boundary(rule))
        )
        beside = () if there["boundary"] else tuple(filter(None, said))
        beside += again if lacking else ()
        result.append(Coverage(rule, len(own), **there, beside=beside, lacking=lacking))
    return result
