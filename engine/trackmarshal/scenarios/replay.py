"""A recording through the rules: verdicts of both candidates in every cycle, what is driven, and the ground truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.faults import Fault
from trackmarshal.runtime.machine import DRIVE, NO_SAFE_TRAJECTORY, PREVIOUS_EMERGENCY
from trackmarshal.runtime.verdict import CaseResult
from trackmarshal.scenarios.recording import CANDIDATES, TRUTHS, Recording
from trackmarshal.scenarios.supervised import supervised

#: What is driven: the planned trajectory, the last safe emergency trajectory, or nothing safe is known.
ACTIONS = (DRIVE, PREVIOUS_EMERGENCY, NO_SAFE_TRAJECTORY)


@dataclass(frozen=True, slots=True)
class CycleOutcome:
    """One cycle: the results of each candidate, the decision, the time its trajectory is from, and the door's faults."""

    t: float
    results: Mapping[str, CaseResult]
    decision: str
    decision_from: float | None
    faults: tuple[Fault, ...] = ()

    @property
    def safe(self) -> bool:
        """Both candidates are there, and safe, and the Supervisor's door has nothing against them; one that is missing cannot
        be driven."""
        there = len(self.results) == len(CANDIDATES) and not self.faults
        return there and all(result.safe for result in self.results.values())


@dataclass(frozen=True, slots=True)
class TruthOutcome:
    """Verdicts of one kind of rules against the recording's ground truth."""

    kind: str
    #: Times at which the truth says safe (unsafe) and the rules say otherwise.
    missed: tuple[float, ...]
    false_alarms: tuple[float, ...]
    judged: int

    @property
    def inside(self) -> bool:
        return not self.missed and not self.false_alarms


@dataclass(frozen=True, slots=True)
class Replay:
    """A whole run."""

    recording: Recording
    cycles: tuple[CycleOutcome, ...]
    truths: tuple[TruthOutcome, ...]
    #: Tables of the recording that the spec does not know.
    ignored: tuple[str, ...]
    #: Times at which something is unsafe of which no ground truth says what to expect.
    unexpected: tuple[float, ...] = ()

    @property
    def met(self) -> bool:
        """Whether the run is as it was declared to be, and safe where nothing was declared."""
        return not self.unexpected and all(truth.inside for truth in self.truths)

    @property
    def fired(self) -> bool:
        return not all(cycle.safe for cycle in self.cycles)

    def unsafe_times(self, candidate: str, rule: str) -> list[float]:
        """When a rule made a candidate unsafe, or would have, were it not advisory."""
        return [c.t for c in self.cycles if candidate in c.results and c.results[candidate].rules[rule].fired]


def replay(
    recording: Recording, evaluator: Evaluator, watch: Callable[[Sequence[Any]], Iterable[Any]] = iter, brief: bool = False
) -> Replay:  # fmt: skip
    """Evaluate every candidate of every cycle; `watch` wraps the chunks of work (a progress bar).

    brief: what decided is looked for where a rule is against a candidate, and nowhere else.
    """
    spec = evaluator.spec
    tables, ignored = known_tables(recording, spec)
    cycles = tuple(
        CycleOutcome(
            t,
            {
                name: evaluator.result(judged.about, rated, candidate=name, brief=brief)
                for name, rated in judged.rated.items()
            },
            decision.action,
            None if decision.driven is None else decision.driven.t,
            decision.faults,
        )
        for t, judged, decision in supervised(recording, evaluator, tables, watch)
    )
    truths = tuple(_truths(recording, cycles, evaluator.rules, spec))
    unexpected = tuple(_unexpected(recording, cycles, {truth.kind for truth in truths}, evaluator))
    return Replay(recording, cycles, truths, ignored, unexpected)


def known_tables(recording: Recording, spec: Spec) -> tuple[dict[str, Any], tuple[str, ...]]:
    """The recording's tables that the spec declares; a recording brings all that its car had."""
    short = {name.rpartition(".")[2] for name in spec.tables}
    known = {name: rows for name, rows in recording.tables.items() if name in short}
    return known, tuple(sorted(set(recording.tables) - set(known)))


def kind_of(rule: RuleInfo, spec: Spec) -> str:
    """`dynamic` for a rule that reads moving objects (a set whose elements have a speed), else `static`."""
    for signal, _ in rule.reads:
        info = spec.signals.get(signal)
        if info is not None and info.many and info.field("v") is not None:
            return "dynamic"
    return "static"


def _truths(
    recording: Recording, cycles: Sequence[CycleOutcome], rules: Sequence[RuleInfo], spec: Spec
) -> Iterator[TruthOutcome]:  # fmt: skip
    for kind in TRUTHS:
        truth = recording.ground_truth.get(kind)
        if truth is None or all(value is None for value in truth):
            continue
        names = [rule.name for rule in rules if kind_of(rule, spec) == kind]
        missed, alarms = [], []
        for cycle, safe in zip(cycles, truth):
            unsafe = any(result.rules[name].unsafe for result in cycle.results.values() for name in names)
            if safe is False and not unsafe:
                missed.append(cycle.t)
            if safe is True and unsafe:
                alarms.append(cycle.t)
        yield TruthOutcome(kind, tuple(missed), tuple(alarms), sum(value is not None for value in truth))


def _unexpected(
    recording: Recording, cycles: Sequence[CycleOutcome], declared: set[str], evaluator: Evaluator
) -> Iterator[float]:
    """Times of cycles that are unsafe by rules of a kind without ground truth, or by what is no rule at all (a breach of the input contract,
    a candidate that is missing) although nothing says that they may be."""
    open_ = [rule.name for rule in evaluator.rules if kind_of(rule, evaluator.spec) not in declared]
    for number, cycle in enumerate(cycles):
        by_rule = any(result.rules[name].unsafe for result in cycle.results.values() for name in open_)
        lacking = len(cycle.results) < len(CANDIDATES) or cycle.faults
        by_input = lacking or any(result.faults for result in cycle.results.values())
        may_be = any(recording.ground_truth[kind][number] is not True for kind in declared)
        if by_rule or (by_input and not may_be):
            yield cycle.t


def intervals(times: Sequence[float], all_times: Sequence[float]) -> list[tuple[float, float]]:
    """Runs of consecutive cycles as (first, last) times."""
    wanted = set(times)
    result: list[tuple[float, float]] = []
    open_run: list[float] = []
    for t in [*all_times, None]:
        if t is not None and t in wanted:
            open_run.append(t)
        elif open_run:
            result.append((open_run[0], open_run[-1]))
            open_run = []
    return result
