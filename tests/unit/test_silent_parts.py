"""A part of the Supervisor in Python that silently does nothing makes no cycle safe, and is named.

Each part is replaced in turn by one that returns nothing, what it was given, or what it said before. The generated Supervisor is held
to the same in test_c_integrity.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any
from unittest import mock

import pytest

from support.cycles import PERIOD, cycle
from support.supervised import Clock, Oracle, shipped
from trackmarshal.backends import results
from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime import reasons
from trackmarshal.runtime import supervisor as parts
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.door.door import Door
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.machine import NO_SAFE_TRAJECTORY, PREVIOUS_EMERGENCY
from trackmarshal.runtime.program import NOTHING, Judged, Program
from trackmarshal.runtime.supervisor import Supervisor

Part = Callable[..., Any]
#: Ways of doing nothing: given the part, and the arguments that it is asked with.
KINDS = ("nothing", "its input", "an earlier answer")


class Silent:
    """A part that does its work until it is `still`."""

    def __init__(self, part: Part, kind: str, input_: int) -> None:
        self.part, self.kind, self.input = part, kind, input_
        self.still = False
        self.asked = 0
        self.before: Any = None

    def __call__(self, *args: Any) -> Any:
        if not self.still:
            self.before = self.part(*args)
            return self.before
        self.asked += 1
        return {"nothing": None, "its input": args[self.input], "an earlier answer": self.before}[self.kind]


#: Where each part is looked up, by its name in the Supervisor; which of its arguments it works on.
PARTS: dict[str, tuple[Any, str, int]] = {
    "door": (Door, "admit", 2),
    "judge": (Oracle, "judge", 2),
    "watchdog": (parts, "watch", 1),
    "machine": (parts, "advance", 0),
    "violations": (parts, "violations", 2),
}


@contextmanager
def silenced(name: str, kind: str) -> Iterator[Silent]:
    owner, attribute, place = PARTS[name]
    silent = Silent(getattr(owner, attribute), kind, place)

    def replaced(*args: Any) -> Any:  # a function: a method is looked up with the instance that it is of
        return silent(*args)

    with mock.patch.object(owner, attribute, replaced):
        yield silent


class Run:
    def __init__(self, program: Program | None = None) -> None:
        self.clock = Clock()
        self.oracle = Oracle()
        limits = Limits(budget=1e9)
        self.supervisor = Supervisor(shipped(), program or self.oracle, limits, self.clock)
        self.number = -1

    def step(self, change: Callable[[Cycle], Cycle] = lambda c: c) -> Decision:
        self.number += 1
        self.clock.now = self.number * PERIOD
        return self.supervisor.step(change(cycle(self.number)))


def refused(decision: Decision, part: str) -> None:
    assert not decision.safe
    assert decision.state != "drive"
    assert decision.driven is None or decision.driven.candidate == "emergency"
    assert ("incomplete", part) in [(name_of(f), f.field) for f in decision.faults], decision.reasons


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PARTS)
def test_a_part_that_does_nothing(name: str, kind: str) -> None:
    with silenced(name, kind) as silent:
        run = Run()
        assert run.step().safe
        assert run.step().safe
        silent.still = True
        for _ in range(3):
            refused(run.step(), name)
        assert silent.asked >= 3
        silent.still = False
        run.step()  # a door that did not look at cycles finds the next one late
        assert run.step().safe


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PARTS)
def test_a_part_that_does_nothing_from_the_start(name: str, kind: str) -> None:
    with silenced(name, kind) as silent:
        silent.still = True
        run = Run()
        for _ in range(2):
            decision = run.step()
            refused(decision, name)
            assert decision.driven is None


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PARTS)
def test_a_part_that_does_nothing_about_an_unsafe_cycle(name: str, kind: str) -> None:
    """What it said of safe ones before does not count for it."""
    with silenced(name, kind) as silent:
        run = Run()
        assert run.step().safe
        silent.still = True
        run.oracle.unsafe = {("driving", "friction")}
        refused(run.step(), name)


def test_an_answer_for_another_step_is_none() -> None:
    """Whole and of the right type, but of another step."""
    other: dict[str, Callable[[Any], Any]] = {
        "door": lambda said: replace(said, about=said.about + 1),
        "judge": lambda said: Judged(Frame(), said.rated),
        "watchdog": lambda said: replace(said, about=said.about - 1),
        "machine": lambda said: (replace(said[0], about=-1), said[1]),
        "violations": lambda said: replace(said, about=0),
    }
    assert other.keys() == PARTS.keys()
    for name, change in other.items():
        with silenced(name, "nothing") as silent:
            part = silent.part
            silent.part = lambda *args, part=part, change=change: change(part(*args))
            refused(Run().step(), name)


@pytest.mark.parametrize("unsafe", [frozenset(), frozenset({("emergency", "friction")})])
def test_violations_that_are_not_those_of_the_verdicts(unsafe: frozenset[tuple[str, str]]) -> None:
    """A list that was made for this step and is empty where a rule is violated, or names one where none is."""
    run = Run()
    run.oracle.unsafe = {("driving", "friction")}
    judged = run.oracle.judge(NOTHING, Frame())
    listed = reasons.violations(1, reasons.named_rules(run.oracle.rules), judged).violations
    assert len(listed) == 1

    def wrong(about: int, *_: Any) -> reasons.Found:
        return reasons.Found(about, () if unsafe else listed)

    run.oracle.unsafe = set(unsafe)
    with mock.patch.object(parts, "violations", wrong):
        refused(run.step(), "violations")


def test_a_list_of_violations_that_nobody_made_is_no_verdict() -> None:
    """Where who lists them ends before it does, none is there, and nothing says so: what the verdicts say counts."""
    run = Run()
    run.oracle.unsafe = {("driving", "friction")}

    def half(_: Supervisor, opened: Any, admission: Any, judged: Judged, closing: Any) -> None:
        closing.judged, closing.finished = judged, opened.now

    with mock.patch.object(Supervisor, "_rate", half):
        decision = run.step()
    assert (decision.safe, decision.driven, decision.violations) == (False, None, ())


# Single rules ---------------------------------------------------------------------------------------------------

RULES = [rule.name for rule in Oracle().rules]


@pytest.mark.parametrize(
    "missing", ["no code", "an unknown code", "no margin", "another type", "no candidate"]
)
@pytest.mark.parametrize("rule", RULES)
def test_a_rule_without_a_verdict(rule: str, missing: str) -> None:
    run = Run()
    assert run.step().safe
    place = RULES.index(rule)

    def act(frame: Frame) -> Any:
        whole = {name: run.oracle.say(name) for name in ("driving", "emergency")}
        codes, margins = bytearray(whole["driving"].verdicts), list(whole["driving"].margins)
        if missing == "no code":
            del codes[place]
        elif missing == "an unknown code":
            codes[place] = results.NOT_EVALUATED
        elif missing == "no margin":
            del margins[place]
        elif missing == "no candidate":
            return Judged(frame, {"driving": whole["driving"]})
        verdicts = list(codes) if missing == "another type" else bytes(codes)
        return Judged(frame, {**whole, "driving": run.oracle.rated(verdicts, margins)})

    run.oracle.act = act
    refused(run.step(), "judge")


def short(given: Cycle) -> Cycle:
    """Plans of two samples and borders of two points: the reference takes its time."""
    plans = [
        {name: column[:: len(column) - 1] for name, column in plan.items()}
        for plan in (given.driving, given.emergency)
    ]
    track = {"left": [[-50.0, 6.0], [500.0, 6.0]], "right": [[-50.0, -6.0], [500.0, -6.0]]}
    return replace(given, driving=plans[0], emergency=plans[1], signals={**given.signals, "track": track})


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("rule", ["friction", RULES[0]])
def test_a_rule_of_the_reference_that_does_nothing(rule: str, kind: str) -> None:
    chosen = [rule, next(name for name in RULES if name != rule)]
    run = Run(Evaluator(shipped(), chosen, "reference").program)
    part, still = results.outcome, False
    before: list[results.Outcome] = []

    def outcome(info: Any, frame: Any, values: Any) -> Any:
        if info.name != rule or not still:
            before.append(part(info, frame, values))
            return before[-1]
        earlier = next(found for found in before if found.rule is info)
        return {"nothing": None, "its input": frame, "an earlier answer": earlier}[kind]

    with mock.patch.object(results, "outcome", outcome):
        assert run.step(short).safe
        still = True
        refused(run.step(short), "judge")
        still = False
        assert run.step(short).safe


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_of_numpy_without_a_value(rule: str) -> None:
    """Its statements are one function, which gives the margins of all rules at once."""
    program = Evaluator(shipped(), None, "numpy").program
    assert isinstance(program, NumpyProgram)
    run = Run(program)
    part = program._varying
    worst, _ = program.margins[RULES.index(rule)]

    def without(*args: Any) -> Any:
        return tuple(None if place == worst else value for place, value in enumerate(part(*args)))

    with mock.patch.object(program, "_varying", without):
        decision = run.step(short)
    assert not decision.safe
    assert {name_of(fault) for fault in decision.faults} <= {"judge_failed", "incomplete"}
    assert decision.faults


# What follows the decision ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("kept", [None, 7, RuntimeError("lost")])
def test_what_rules_remember_is_not_kept(kept: Any) -> None:
    """The cycle is not safe, and its emergency trajectory is not stored: the one before is."""
    run = Run()
    assert run.step().safe

    def commit(*_: Any) -> Any:
        if isinstance(kept, Exception):
            raise kept
        return kept

    with mock.patch.object(run.oracle, "commit", commit):
        decision = run.step()
    assert not decision.safe
    assert decision.state == PREVIOUS_EMERGENCY
    assert decision.driven is not None
    assert decision.driven.number == 0
    assert [name_of(f) for f in decision.faults] == ["internal"]
    assert run.step().safe
    with mock.patch.object(run.oracle, "commit", commit):
        fresh = Run()
        fresh.oracle.commit = commit  # type: ignore[method-assign, assignment]
        decision = fresh.step()
    assert decision.state in ("no_emergency_yet", NO_SAFE_TRAJECTORY)
    assert decision.driven is None
    assert decision.fallback is None
