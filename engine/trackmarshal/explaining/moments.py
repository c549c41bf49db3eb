"""The numbers behind a run's verdicts, for its page: of the cycles in which a rule is against a candidate, and of those next to its bound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from trackmarshal.backends.over_run.history import History, Past, Settled
from trackmarshal.backends.over_run.keeping import past
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.backends.reference.functions import Functions
from trackmarshal.explaining.course import along_course
from trackmarshal.explaining.telling import behind, behind_over_run
from trackmarshal.ir.spec import RuleInfo, remembers
from trackmarshal.runtime.contract import FOLLOWED, IS_EMERGENCY, PLAN
from trackmarshal.runtime.driven import as_driven, in_doubt
from trackmarshal.runtime.verdict import RuleResult, Said
from trackmarshal.scenarios.replay import CycleOutcome, Replay, intervals

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.runtime.decision import Decision
    from trackmarshal.runtime.frame import Frame

#: Cycles of which numbers are told, for each rule and candidate; of a rule that remembers, which takes all cycles before it, fewer.
MOST, MOST_REMEMBERED = 60, 3
#: What a rule reads that is not the same for all candidates.
_OF_CANDIDATES = {PLAN, FOLLOWED, IS_EMERGENCY}


def told_moments(replay: Replay, evaluator: Evaluator) -> list[dict[str, Any]]:
    """A record for each rule and candidate of which there is something to tell, as plain data: `rule`, `candidate`, by number of the cycle
    the lines (`cycles`) that `trackmarshal explain` prints below the verdict, and of how many unsafe cycles there are none (`untold`).

    Told are the first, the last and the worst cycle of every stretch in which a rule is against a candidate, the cycle with the least
    margin, both sides of every change of the verdict, and of the other unsafe cycles as many as MOST allows; of a rule that remembers, of
    the cycles in which it is against a candidate as many as MOST_REMEMBERED. The replay has kept what was seen; raises AssertionError where
    it has not.
    """
    run = _Run(replay, evaluator)
    found, candidates = [], replay.candidates
    for place, rule in enumerate(evaluator.rules):
        for candidate in candidates:
            results = replay.said(candidate, rule.name)
            numbers = chosen(results, remembers(rule))
            if not numbers:
                continue
            told = {str(number): run.lines(place, rule, candidate, number) for number in numbers}
            unsafe = sum(result is not None and result.fired for result in results)
            there = sum(results[number].fired for number in numbers)  # type: ignore[union-attr]
            if any(told.values()):
                lines = {number: each for number, each in told.items() if each}
                found.append(
                    {"rule": rule.name, "candidate": candidate, "cycles": lines, "untold": unsafe - there}
                )
    return found


def chosen(results: Sequence[RuleResult | Said | None], remembering: bool) -> list[int]:
    """The numbers of the cycles of which numbers are told, ascending: where those would be too many, those that matter more."""
    known = {i: result for i, result in enumerate(results) if result is not None}
    told = {i: result for i, result in known.items() if result.verdict != "inactive"}
    if not told:
        return []
    unsafe = [i for i, result in told.items() if result.fired]
    firsts: dict[int, None] = {}
    for first, last in intervals(unsafe, range(len(results))):
        inside = range(int(first), int(last) + 1)
        violated = [i for i in inside if told[i].verdict == "violated"]
        worst = min(violated, key=lambda i: told[i].margin, default=int(first))
        firsts |= dict.fromkeys((int(first), worst, int(last)))
    if remembering:
        return sorted(_evenly(list(firsts), MOST_REMEMBERED))
    measured = [i for i, result in told.items() if result.verdict in ("satisfied", "violated")]
    least = [min(measured, key=lambda i: told[i].margin)] if measured else []
    verdicts = {i: result.verdict for i, result in known.items()}
    changes = [
        i
        for i in told
        if not verdicts.get(i - 1, verdicts[i]) == verdicts[i] == verdicts.get(i + 1, verdicts[i])
    ]
    wanted: dict[int, None] = {}
    for group in (least, list(firsts), changes, unsafe):
        more = [i for i in group if i not in wanted]
        wanted |= dict.fromkeys(_evenly(more, MOST - len(wanted)))
    return sorted(wanted)


def _evenly(numbers: Sequence[int], most: int) -> list[int]:
    """At most so many of some, the first among them."""
    if len(numbers) <= most:
        return list(numbers)
    return [numbers[i * len(numbers) // most] for i in range(most)]


class _Run:
    """The cycles of a replay, explained one by one."""

    def __init__(self, replay: Replay, evaluator: Evaluator) -> None:
        self._cycles = replay.cycles
        self._given = replay.recording.cycles
        self._spec = evaluator.spec
        self._functions = Functions(often=True)
        #: By cycle and candidate: what rules have in common is computed once.
        self._values: dict[tuple[int, str], Reference] = {}
        self._histories: dict[tuple[int, str], History] = {}
        #: What is known of the cycles before a moment holds for all later moments.
        self._settled = Settled()
        #: Of rules that are the same for all candidates, by the number of the cycle.
        self._shared: dict[tuple[str, int], tuple[RuleResult, list[str]]] = {}
        #: What is remembered of all cycles, and of each what `_until` says, with how many of them are before it.
        self._kept: list[Past] = []
        self._gaps: list[tuple[int, int]] | None = None

    def lines(self, place: int, rule: RuleInfo, candidate: str, number: int) -> list[str]:
        """What is told of a rule, that of this place among all, in a cycle."""
        result = self._cycles[number].results[candidate].rules[rule.name]
        if rule.course is not None or not _OF_CANDIDATES.isdisjoint(signal for signal, _ in rule.reads):
            return self._lines(place, rule, candidate, number)
        known = self._shared.get((rule.name, number))
        if known is None or known[0] != result:
            known = self._shared[rule.name, number] = result, self._lines(place, rule, candidate, number)
        return known[1]

    def _lines(self, place: int, rule: RuleInfo, candidate: str, number: int) -> list[str]:
        result = self._cycles[number].results[candidate].rules[rule.name]
        if not remembers(rule):
            if (
                result.verdict != "inactive"
            ):  # what decided is known to the evaluator, for many cycles at once
                result = self._cycles[number].whole(candidate, place, rule.name)
            return behind(rule, result, self._reference(candidate, number))
        if rule.course is not None:
            return behind(rule, result, along_course(rule, self._until(candidate, number)))
        key = number, candidate
        if key not in self._histories:
            cycles = self._until(candidate, number)
            self._histories[key] = History(cycles, common=len(cycles) - 1, settled=self._settled)
        return behind_over_run(rule, result, self._histories[key])

    def _reference(self, candidate: str, number: int) -> Reference:
        key = number, candidate
        if key not in self._values:
            frame, _ = _seen(self._cycles[number])
            self._values[key] = Reference(self._spec, frame.of(candidate), functions=self._functions)
        return self._values[key]

    def _until(self, candidate: str, number: int) -> list[Past]:
        """The cycles that are remembered before one, as they were driven, and that one as a candidate has it."""
        if self._gaps is None:
            self._gaps = list(self._remembered())
        missed, count = self._gaps[number]
        frame, _ = _seen(self._cycles[number])
        return [*self._kept[:count], past(self._spec, frame.of(candidate), missed, self._functions)]

    def _remembered(self) -> Iterator[tuple[int, int]]:
        """For each cycle how many are missing right before it, and how many before it are remembered."""
        missed = 0
        for cycle, given in zip(self._cycles, self._given):
            missed += given.missing if self._kept else 0  # what comes before the first cycle is no gap
            yield missed, len(self._kept)
            frame, decision = _seen(cycle)
            if decision.judged is None or in_doubt(frame, decision):
                missed += bool(self._kept)
            else:
                self._kept.append(past(self._spec, as_driven(frame, decision), missed, self._functions))
                missed = 0


def _seen(cycle: CycleOutcome) -> tuple[Frame, Decision]:
    assert cycle.seen is not None, "cycles are kept whole where they are explained"
    return cycle.seen
