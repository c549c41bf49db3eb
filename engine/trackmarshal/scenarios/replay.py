"""A recording through the rules: verdicts of both candidates in every cycle, what is driven, and the ground truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import Fault
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.machine import DRIVE, NO_SAFE_TRAJECTORY, PREVIOUS_EMERGENCY
from trackmarshal.runtime.verdict import CaseResult, RuleResult, Said
from trackmarshal.scenarios.labels import Label, judged_by, known, labels
from trackmarshal.scenarios.overrides import known_tables
from trackmarshal.scenarios.recording import CANDIDATES, TRUTHS, Recording, only
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
    #: What the rules saw, and what was decided of it; None where the replay does not keep it.
    seen: tuple[Frame, Decision] | None = field(default=None, compare=False, repr=False)
    #: Where it keeps it: by candidate what looks for what decided a rule, by the rule's number.
    explain: Mapping[str, Callable[[int, bool], RuleResult]] = field(
        default_factory=dict, compare=False, repr=False
    )
    #: What was looked for already, by candidate and rule: the record of a run and what is told of it ask for the same.
    _found: dict[tuple[str, int], RuleResult] = field(default_factory=dict, compare=False, repr=False)

    def whole(self, candidate: str, number: int, rule: str) -> RuleResult:
        """The result of a rule with what decided it."""
        found = self._found.get((candidate, number))
        if found is None:
            look, said = self.explain.get(candidate), self.results[candidate].rules[rule]
            if look is None or said.witness is not None:
                return said
            found = self._found[candidate, number] = look(number, False)
        return found

    @property
    def safe(self) -> bool:
        """Both candidates are there, and safe, and the Supervisor's door has nothing against them; one that is missing cannot
        be driven."""
        there = len(self.results) == len(CANDIDATES) and not self.faults
        return there and all(result.safe for result in self.results.values())


@dataclass(frozen=True, slots=True)
class TruthOutcome:
    """Verdicts of one kind of rules, or of one rule, against the recording's ground truth."""

    kind: str
    #: Times at which the truth says safe (unsafe) and the rules say otherwise.
    missed: tuple[float, ...]
    false_alarms: tuple[float, ...]
    judged: int
    #: The rules that it judges, of those that were evaluated.
    rules: tuple[str, ...] = ()
    #: Of every cycle, whether they were against what it judges.
    unsafe: tuple[bool, ...] = ()

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
    #: Rules of which the recording's ground truth was not meant: nobody declared one, and the generator does not know them.
    uncovered: tuple[str, ...] = ()
    #: What `said` found, by candidate and rule: summary, record and what is told of a run ask for the same.
    _said: dict[tuple[str, str], list[Said | None]] = field(
        default_factory=dict, init=False, compare=False, repr=False
    )

    def said(self, candidate: str, rule: str) -> Sequence[Said | None]:
        """Verdict and margin of a rule about a candidate in every cycle; None where it is not there."""
        found = self._said.get((candidate, rule))
        if found is None:
            cases = (cycle.results.get(candidate) for cycle in self.cycles)
            found = [None if case is None else case.said(rule) for case in cases]
            self._said[candidate, rule] = found
        return found

    @property
    def candidates(self) -> list[str]:
        """Those that are there in a cycle."""
        return list(dict.fromkeys(name for cycle in self.cycles for name in cycle.results))

    @property
    def met(self) -> bool:
        """Whether the run is as it was declared to be, and safe where nothing was declared."""
        return not self.unexpected and all(truth.inside for truth in self.truths)

    @property
    def fired(self) -> bool:
        return not all(cycle.safe for cycle in self.cycles)

    def unsafe_times(self, candidate: str, rule: str) -> list[float]:
        """When a rule made a candidate unsafe, or would have, were it not advisory.

        Raises TrackmarshalError D144 and E401 for a candidate and a rule that there is not: it would be unsafe at no time.
        """
        if candidate not in (*CANDIDATES, *self.candidates):
            there = " and ".join(self.candidates)
            raise TrackmarshalError(
                "D144", f"the run has no candidate `{candidate!s:.40}`", help=f"there: {there}"
            )
        known = {name for cycle in self.cycles for result in cycle.results.values() for name in result.rules}
        if rule not in known:
            help_ = close_matches(str(rule), known) or ", ".join(sorted(known))
            raise TrackmarshalError("E401", f"the run has no rule `{rule!s:.40}`", help=help_)
        return [c.t for c in self.cycles if candidate in c.results and c.results[candidate].rules[rule].fired]


def replay(
    recording: Recording, evaluator: Evaluator, watch: Callable[[Sequence[Any]], Iterable[Any]] = iter, brief: bool = False,
    keep: bool = False,
) -> Replay:  # fmt: skip
    """Evaluate every candidate of every cycle; `watch` wraps the chunks of work (a progress bar). Raises D255 and D256.

    brief: what decided is looked for where a rule is against a candidate, and nowhere else. keep: what was seen and computed in each cycle
    is kept, for whoever explains it, or asks for the `whole`.
    """
    if not isinstance(recording, Recording):
        raise wrong_type("a recording is what `load_recording` returns", recording)
    if not isinstance(evaluator, Evaluator):
        raise wrong_type("an evaluator is an `Evaluator` of a spec", evaluator)
    if not callable(watch):
        raise wrong_type("`watch` is a function", watch)
    spec = evaluator.spec
    _check_labels(recording, spec)
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
            (judged.about, decision) if keep else None,
            {name: rated.explain for name, rated in judged.rated.items()} if keep else {},
        )
        for t, judged, decision in supervised(recording, evaluator, tables, watch)
    )
    against = _against(recording, cycles, evaluator, tables)
    truths = tuple(_truths(recording, cycles, evaluator, against))
    declared = {truth.kind for truth in truths} | _kinds(recording)
    unexpected = tuple(_unexpected(recording, cycles, declared, evaluator, against))
    uncovered = tuple(_uncovered(recording, evaluator, declared))
    return Replay(recording, cycles, truths, ignored, unexpected, uncovered)


#: By the name of a truth about one rule, the candidates that the rule was against in each cycle.
Against = Mapping[str, Sequence[frozenset[str]]]


def _truths(
    recording: Recording, cycles: Sequence[CycleOutcome], evaluator: Evaluator, against: Against
) -> Iterator[TruthOutcome]:
    """What the rules said against each ground truth that says anything of a rule that was evaluated, or asks for one: what is to be safe is so
    without any rule, and that shows nothing."""
    judges = {rule.name: judged_by(rule, evaluator.spec, recording) for rule in evaluator.rules}
    by_name = bool(labels(recording) or recording.judged)
    for kind, truth in recording.ground_truth.items():
        names = [name for name, by in judges.items() if kind in by]
        if _is_open(truth) or (not names and (by_name or False not in truth)):
            continue
        if kind in against:
            unsafe = [bool(found) for found in against[kind]]
        else:
            unsafe = [
                any(one.unsafe and one.rule in names for one in _said_against(cycle)) for cycle in cycles
            ]
        times = [cycle.t for cycle in cycles]
        missed = tuple(t for t, safe, found in zip(times, truth, unsafe) if safe is False and not found)
        alarms = tuple(t for t, safe, found in zip(times, truth, unsafe) if safe is True and found)
        judged = sum(value is not None for value in truth)
        yield TruthOutcome(kind, missed, alarms, judged, tuple(names), tuple(unsafe))


def _kinds(recording: Recording) -> set[str]:
    """The kinds that speak of the run, also where none of their rules is asked: of the input contract, and of what the other kind leaves out.
    Where single rules are spoken of by name, those speak."""
    if labels(recording) or recording.judged:
        return set()
    return {kind for kind, truth in recording.ground_truth.items() if not _is_open(truth)}


def _is_open(truth: Iterable[bool | None]) -> bool:
    """Whether a ground truth says nothing."""
    return all(value is None for value in truth)


def _against(
    recording: Recording, cycles: Sequence[CycleOutcome], evaluator: Evaluator, tables: Mapping[str, Any]
) -> Against:
    """Of each truth about one rule; about one object, the rule is asked as if it were the only one."""
    chosen = {rule.name for rule in evaluator.rules}
    found = {}
    for name, label in labels(recording).items():
        if label.rule not in chosen:
            continue
        results: Iterable[Mapping[str, CaseResult]] = (cycle.results for cycle in cycles)
        if label.object:
            there = replace(recording, cycles=tuple(only(cycle, label.object) for cycle in recording.cycles))
            results = _results(
                there, Evaluator(evaluator.spec, [label.rule], evaluator.asked, evaluator.declared), tables
            )
        of = [label.candidate] if label.candidate else list(CANDIDATES)
        found[name] = [
            frozenset(each for each in of if each in there and there[each].rules[label.rule].fired)
            for there in results
        ]
    return found


def _results(
    recording: Recording, evaluator: Evaluator, tables: Mapping[str, Any]
) -> Iterator[Mapping[str, CaseResult]]:
    """The results of every cycle's candidates."""
    for _, judged, _ in supervised(recording, evaluator, tables):
        yield {
            name: evaluator.result(judged.about, rated, candidate=name, brief=True)
            for name, rated in judged.rated.items()
        }


def _unexpected(
    recording: Recording, cycles: Sequence[CycleOutcome], declared: set[str], evaluator: Evaluator, against: Against
) -> Iterator[float]:  # fmt: skip
    """Times of cycles that are unsafe by what no ground truth speaks of, or by what is no rule at all (a breach of the input contract,
    a candidate that is missing) although nothing says that they may be.

    No ground truth speaks of a rule that has none, and of one that is against another candidate, or by another object, than its own are about.
    """
    open_ = {
        rule.name
        for rule in evaluator.rules
        if declared.isdisjoint(judged_by(rule, evaluator.spec, recording))
    }
    own: dict[str, list[tuple[str, Label]]] = {}
    for name, label in labels(recording).items():
        if name in declared:
            own.setdefault(label.rule, []).append((name, label))
    kinds = [recording.ground_truth[kind] for kind in declared & set(TRUTHS)]
    for number, cycle in enumerate(cycles):
        by_rule = any(one.unsafe and one.rule in open_ for one in _said_against(cycle))
        by_rule = by_rule or any(
            result.rules[rule].unsafe
            and not any(
                candidate in against[name][number]
                or (not label.object and label.candidate in ("", candidate))
                for name, label in named
            )
            for rule, named in own.items()
            for candidate, result in cycle.results.items()
        )
        lacking = len(cycle.results) < len(CANDIDATES) or cycle.faults
        by_input = lacking or any(result.faults for result in cycle.results.values())
        may_be = any(truth[number] is not True for truth in kinds)
        if by_rule or (by_input and not may_be):
            yield cycle.t


def _said_against(cycle: CycleOutcome) -> Iterator[RuleResult]:
    """What rules are against in a cycle, whichever candidate it is."""
    for result in cycle.results.values():
        yield from result.against


def _uncovered(recording: Recording, evaluator: Evaluator, declared: set[str]) -> Iterator[str]:
    """Rules of which no ground truth was declared, where there is any: not by name, and the generator does not know them either."""
    for rule in evaluator.rules if declared else ():
        by = judged_by(rule, evaluator.spec, recording)
        named = rule.name in recording.judged or any(name not in TRUTHS for name in by)
        if declared.isdisjoint(by) or not (named or known(rule)):
            yield rule.name


def _check_labels(recording: Recording, spec: Spec) -> None:
    """Raise D256 for a truth about a rule that the spec does not have, and D255 for one about an object or a candidate that no cycle has."""
    names = [rule.name for rule in spec.rules]
    for name in (*(each.rule for each in labels(recording).values()), *recording.judged):
        if name not in names:
            help_ = "name its spec with --spec, or under `with` in v-model.yaml"
            raise TrackmarshalError(
                "D256",
                f"there is a ground truth of `{name}`, and the spec has no such rule",
                file=recording.source,
                help=f"{close_matches(name, names)} {help_}".strip(),
            )
    objects = {each["id"] for cycle in recording.cycles for each in cycle.objects}
    candidates = {name for cycle in recording.cycles for name in cycle.candidates}
    for label in labels(recording).values():
        for about, there in ((label.object, objects), (label.candidate, candidates)):
            if about and about not in there:
                raise TrackmarshalError(
                    "D255",
                    f"there is a ground truth `{label}`, and no cycle has `{about}`",
                    file=recording.source,
                    help=close_matches(about, there) or f"there: {', '.join(sorted(there)) or 'none'}",
                )


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
