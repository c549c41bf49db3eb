"""The Supervisor, state by state and fault by fault: docs/supervisor.md, held against what it does."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.cycles import BRAKING, PERIOD, SPEED, cycle
from support.supervised import BACKENDS, Clock, Oracle, made, shipped
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import load, loads
from trackmarshal.runtime.codes import CODES
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import FAULTS, name_of
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.machine import NEXT, STATES
from trackmarshal.runtime.program import Judged
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.supervision import supervisor

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "supervisor.md").read_text("utf-8")
FRICTION = {("driving", "friction")}


class Run:
    """A Supervisor that gets one cycle after the other."""

    def __init__(self, limits: Limits | None = None) -> None:
        self.supervisor, self.oracle, self.clock = made(limits)
        self.number = -1

    def step(self, unsafe: set[tuple[str, str]] | None = None, change: Callable[[Cycle], Any] = lambda c: c, at: float | None = None) -> Decision:  # fmt: skip
        """One cycle on; `change` hands in something else, `at` puts the car elsewhere, as fast as it is there when it brakes from 0 m."""
        self.number += 1
        self.clock.now = self.number * PERIOD
        self.oracle.unsafe = unsafe or set()
        v = SPEED if at is None else math.sqrt(max(0.0, SPEED**2 - 2.0 * BRAKING * at))
        return self.supervisor.step(change(cycle(self.number, at=at, v=v)))

    def braked(self, since: int) -> float:
        """Where the car is now if it has driven the emergency trajectory of a cycle."""
        t = min((self.number + 1 - since) * PERIOD, SPEED / BRAKING)
        return SPEED * since * PERIOD + SPEED * t - BRAKING * t**2 / 2


def names(decision: Decision) -> list[str]:
    return [name_of(fault) for fault in decision.faults]


# States -------------------------------------------------------------------------------------------------------


@pytest.mark.verifies("S-1-B-10")
def test_a_safe_cycle_is_driven() -> None:
    decision = Run().step()
    assert (decision.state, decision.action, decision.safe, decision.reasons) == ("drive", "drive", True, ())
    assert decision.driven is not None
    assert (decision.driven.candidate, decision.driven.number, decision.driven.t) == ("driving", 0, 0.0)
    assert decision.samples is not None
    assert np.array_equal(decision.samples["x"], cycle(0).driving["x"])
    assert decision.fallback is not None
    assert decision.fallback.candidate == "emergency"
    assert decision.valid_until == pytest.approx(0.15)


@pytest.mark.verifies("S-1-B-6")
def test_without_any_safe_cycle_nothing_is_driven_and_the_state_has_a_name() -> None:
    run = Run()
    for _ in range(3):
        decision = run.step({("emergency", "friction")})
        assert (decision.state, decision.action, decision.lost) == (
            "no_emergency_yet",
            "no_safe_trajectory",
            "none_stored",
        )
        assert (decision.driven, decision.samples, decision.fallback) == (None, None, None)
    assert run.step().state == "drive"


@pytest.mark.parametrize("candidate", ["driving", "emergency"])
@pytest.mark.verifies("S-1-B-5", "S-1-B-6")
def test_an_unsafe_candidate_gives_way_to_the_stored_emergency_trajectory(candidate: str) -> None:
    run = Run()
    run.step()
    decision = run.step({(candidate, "friction")})
    assert (decision.state, decision.safe, decision.lost) == ("previous_emergency", False, "")
    assert decision.driven is not None
    assert (decision.driven.candidate, decision.driven.number) == ("emergency", 0)
    violation = decision.violations[0]
    assert (violation.rule, violation.candidate, violation.requirements, violation.verdict, violation.margin, violation.unit) == (
        "friction", candidate, ("S-1-A-4",), "violated", -1.0, "N",
    )  # fmt: skip
    assert decision.reasons == (f"{candidate}: friction violated, margin -1 N (S-1-A-4)",)


@pytest.mark.verifies("S-1-B-6")
def test_the_stored_trajectory_advances_with_time() -> None:
    run = Run()
    run.step()
    stored = cycle(0).emergency
    for _ in range(5):
        decision = run.step(FRICTION, at=run.braked(0))
        assert decision.samples is not None
        samples = decision.samples
        now = run.clock.now
        assert samples["t"][0] <= now + 1e-9
        assert samples["t"][1] > now
        assert list(samples["x"]) == list(stored["x"])[-len(samples["x"]) :]


@pytest.mark.verifies("S-1-B-6")
def test_it_expires_at_its_end_and_is_dropped_for_good() -> None:
    run = Run()
    run.step()
    decision = run.step(FRICTION, at=run.braked(0))
    while decision.state == "previous_emergency":
        decision = run.step(FRICTION, at=run.braked(0))
    assert (decision.state, decision.lost, decision.driven) == ("no_safe_trajectory", "expired", None)
    assert run.number == pytest.approx(SPEED / BRAKING / PERIOD, abs=1)
    assert run.step(FRICTION, at=run.braked(0)).lost == "none_stored"
    decision = run.step(at=run.braked(0))
    assert (decision.state, decision.lost) == ("drive", "")


@pytest.mark.parametrize(
    ("away", "turned"), [(1.6, 0.0), (-1.6, 0.0), (0.0, 0.36), (0.0, -0.36), (0.0, math.pi)]
)
@pytest.mark.verifies("S-1-B-6")
def test_a_car_that_left_it_does_not_take_it_up_again(away: float, turned: float) -> None:
    run = Run()
    run.step()

    def elsewhere(given: Cycle) -> Cycle:
        ego = given.signals["ego"]
        moved = {**ego, "y": away, "heading": turned}
        return replace(given, signals={**given.signals, "ego": moved})

    decision = run.step(FRICTION, elsewhere, run.braked(0))
    assert (decision.state, decision.lost) == ("no_safe_trajectory", "apart")
    assert run.step(FRICTION, at=run.braked(0)).state == "no_safe_trajectory"


@pytest.mark.parametrize(
    ("away", "turned"), [(1.4, 0.0), (-1.4, 0.0), (0.0, 0.34), (0.0, -0.34), (1.4, 2.0 * math.pi - 0.34)]
)
@pytest.mark.verifies("S-1-B-6")
def test_a_car_that_is_only_just_on_it_drives_it(away: float, turned: float) -> None:
    run = Run()
    run.step()

    def moved(given: Cycle) -> Cycle:
        ego = {**given.signals["ego"], "y": away, "heading": turned}
        return replace(given, signals={**given.signals, "ego": ego})

    assert run.step(FRICTION, moved, run.braked(0)).state == "previous_emergency"


@pytest.mark.parametrize(
    ("further", "faster", "lost"),
    [(0.0, 0.0, ""), (5.4, 0.0, ""), (5.6, 0.0, "apart"), (-5.4, 0.0, ""), (-5.6, 0.0, "apart"), (0.0, 4.9, ""), (0.0, 5.1, "too_fast"), (0.0, -9.0, ""),
     (3.9, 3.9, ""), (9.0, 9.0, "apart")],
)  # fmt: skip
@pytest.mark.verifies("S-1-B-6")
def test_along_the_path_and_in_speed(further: float, faster: float, lost: str) -> None:
    """A car that is 4 m from where it is due is on the path; 1.5 m more count as beside it. Slower is no harm."""
    run = Run()
    run.step()
    for _ in range(9):
        run.step(FRICTION, at=run.braked(0))

    def moved(given: Cycle) -> Cycle:
        ego = given.signals["ego"]
        x = ego["x"] + further
        v = math.sqrt(max(0.0, SPEED**2 - 2.0 * BRAKING * x)) + faster
        return replace(given, signals={**given.signals, "ego": {**ego, "x": x, "v": v}})

    assert run.step(FRICTION, moved, run.braked(0)).lost == lost


def test_whole_turns_of_the_heading_make_no_difference() -> None:
    run = Run()
    run.step()

    def turned(given: Cycle) -> Cycle:
        ego = given.signals["ego"]
        return replace(given, signals={**given.signals, "ego": {**ego, "heading": 4 * math.pi}})

    assert run.step(FRICTION, turned, run.braked(0)).state == "previous_emergency"


BEND = """module bend
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
rule slow "It is slow" for all p in plan require p.v <= 30 m/s
"""


def in_the_bend(way: float, turn: float, out: float = 0.0) -> tuple[float, float, float]:
    """Where a car is that has driven so far along a circle of 20 m: x, y, and its heading, which is pi after 10 m where nothing is turned."""
    angle = math.pi / 2.0 + (way - 10.0) / 20.0 + turn
    radius = 20.0 + out
    return radius * math.cos(angle), radius * math.sin(angle), math.remainder(angle + math.pi / 2.0, math.tau)


@BACKENDS
@pytest.mark.parametrize("turn", [0.0, math.pi / 2.0])
@pytest.mark.verifies("S-1-B-6")
def test_a_stored_trajectory_in_a_bend(turn: float, backend: str) -> None:
    """Braked at 2.5 m/s^2 from 10 m/s, over 20 m: a second later the car is after 8.75 m, at 7.5 m/s, between two samples. Headings go the shorter
    way round from one to the next, and how far the car is counts along the way, in whatever direction."""
    times = [0.4 * i for i in range(11)]
    places = [in_the_bend(10.0 * t - 1.25 * t**2, turn) for t in times]
    x, y, heading = (list(column) for column in zip(*places))
    plan = {"t": times, "x": x, "y": y, "heading": heading, "v": [10.0 - 2.5 * t for t in times]}
    spec = loads(BEND)
    for further, out, turned, v, lost in (
        (0.0, 0.0, 0.0, 7.5, ""), (0.0, 0.0, -math.tau, 7.5, ""), (0.0, 1.4, 0.3, 7.5, ""), (0.0, -1.4, -0.3, 7.5, ""),
        (0.0, 1.6, 0.0, 7.5, "apart"), (0.0, -1.6, 0.0, 7.5, "apart"), (0.0, 0.0, 0.4, 7.5, "apart"), (0.0, 0.0, -0.4, 7.5, "apart"),
        (0.0, 0.0, math.pi, 7.5, "apart"), (0.0, 0.0, 0.0, 12.3, ""), (0.0, 0.0, 0.0, 12.7, "too_fast"),
        (4.9, 0.0, 0.0, 6.0, ""), (-4.9, 0.0, 0.0, 6.0, ""), (6.0, 0.0, 0.0, 6.0, "apart"), (-6.0, 0.0, 0.0, 6.0, "apart"),
    ):  # fmt: skip
        clock = Clock()
        asked = supervisor(spec, backend=backend, limits={"budget": 60.0}, clock=clock)
        ego = {"x": x[0], "y": y[0], "heading": heading[0], "v": 10.0}
        assert asked.step(Cycle(0, 0.0, plan, plan, {"ego": ego})).safe
        px, py, pointing = in_the_bend(8.75 + further, turn, out)
        clock.now, ego = 1.0, {"x": px, "y": py, "heading": pointing + turned, "v": v}
        decision = asked.step(Cycle(1, 1.0, plan, plan, {"ego": ego}))
        assert (names(decision), decision.lost) == (["late"], lost), (further, out, turned, v)


def test_the_pose_is_held_against_the_time_it_was_taken_at() -> None:
    """A pose half a second old, of a car that stands 5 m further on by now."""
    limits = Limits(apart=0.0)
    run = Run(limits)
    for _ in range(1):
        run.step()
    for _ in range(5):
        run.step(FRICTION, at=run.braked(0))

    def old(given: Cycle) -> Cycle:
        return replace(given, signals={**given.signals, "ego": {**given.signals["ego"], "age": 0.4}})

    then = SPEED * 0.2 - BRAKING * 0.2**2 / 2
    assert run.step(FRICTION, old, then).state == "previous_emergency"
    assert run.step(FRICTION, at=then).lost == "apart"


@pytest.mark.verifies("S-1-B-6")
def test_without_a_pose_it_is_driven_for_a_while_only() -> None:
    run = Run()
    run.step()
    states = [run.step(change=lambda c: None).state for _ in range(7)]
    assert states == ["previous_emergency"] * 5 + ["no_safe_trajectory"] * 2
    run = Run()
    run.step()
    decisions = [run.step(change=lambda c: None) for _ in range(7)]
    assert [d.lost for d in decisions] == [""] * 5 + ["unconfirmed", "none_stored"]


@pytest.mark.verifies("S-1-B-6")
def test_a_pose_counts_from_when_it_was_taken() -> None:
    """The car was last seen where a pose of 0.35 s ago has it: 0.5 s after that, and not after the pose has come, nothing is driven any more."""
    run = Run()
    run.step()

    def old(given: Cycle) -> Cycle:
        return replace(given, signals={**given.signals, "ego": {**given.signals["ego"], "age": 0.35}})

    for number in range(1, 6):
        then = max(0.0, number * PERIOD - 0.35)
        decision = run.step(FRICTION, old, SPEED * then - BRAKING * then**2 / 2)
        assert decision.state == "previous_emergency"
    assert [run.step(change=lambda c: None).lost for _ in range(2)] == ["", "unconfirmed"]


@pytest.mark.verifies("S-1-B-6")
def test_a_safe_cycle_replaces_what_is_stored() -> None:
    run = Run()
    for _ in range(4):
        run.step()
    decision = run.step(FRICTION)
    assert decision.driven is not None
    assert decision.driven.number == 3


def test_what_is_stored_does_not_change_with_the_callers_arrays() -> None:
    run = Run()
    mine = cycle(0)
    decision = run.step(change=lambda c: mine)
    before = mine.emergency["x"].copy()
    for column in (*mine.emergency.values(), *mine.driving.values()):
        column += 1000.0
    assert decision.fallback is not None
    assert np.array_equal(decision.fallback.samples(0.0)["x"], before)
    with pytest.raises(ValueError, match="read-only"):
        decision.fallback.matrix[0, 0] = 1.0


# Time ---------------------------------------------------------------------------------------------------------


@pytest.mark.verifies("S-1-B-6")
def test_a_missing_cycle_is_answered_with_the_stored_trajectory() -> None:
    run = Run()
    run.step()
    decision = run.step(change=lambda c: None)
    assert (decision.state, names(decision), decision.number) == (
        "previous_emergency",
        ["missing_cycle"],
        None,
    )


@pytest.mark.parametrize(
    ("change", "fault", "field"),
    [
        (lambda c: replace(c, number=c.number - 1), "repeated", "number"),
        (lambda c: replace(c, t=c.t - PERIOD), "repeated", "t"),
        (lambda c: replace(c, number=c.number - 2), "out_of_order", "number"),
        (lambda c: replace(c, t=c.t - 2 * PERIOD), "out_of_order", "t"),
        (lambda c: replace(c, number=c.number + 1), "skipped", "number"),
        (lambda c: replace(c, t=c.t + 0.02), "early", "t"),
    ],
)
@pytest.mark.verifies("S-1-B-9")
def test_order(change: Callable[[Cycle], Cycle], fault: str, field: str) -> None:
    run = Run()
    for _ in range(3):
        run.step()
    decision = run.step(change=change)
    assert (decision.state, decision.safe) == ("previous_emergency", False)
    assert [(name_of(f), f.signal, f.field) for f in decision.faults] == [(fault, "cycle", field)]
    run.step()  # a wrong number costs one more
    assert run.step().state == "drive"


@BACKENDS
@pytest.mark.parametrize("wrong", [None, "1", True, 2**63])
@pytest.mark.verifies("S-1-B-9")
def test_a_number_that_is_none_does_not_wipe_out_the_one_before(wrong: Any, backend: str) -> None:
    """A cycle with the number of one that was driven is repeated, whatever came between the two."""
    now = 0.0
    asked = supervisor(shipped(), backend=backend, limits={"budget": 60.0}, clock=lambda: now)
    assert asked.step(cycle(0)).safe
    now = PERIOD
    assert not asked.step(replace(cycle(1), number=wrong)).safe
    now = 2 * PERIOD
    decision = asked.step(replace(cycle(2), number=0))
    assert (decision.safe, names(decision)) == (False, ["repeated"])


@pytest.mark.verifies("S-1-B-9")
def test_a_gap_is_late_and_skipped_once() -> None:
    run = Run()
    run.step()
    run.number += 1
    assert names(run.step()) == ["late", "skipped"]
    assert run.step().state == "drive"


def first(candidate: str, field: str, by: float, place: int = 0) -> Callable[[Cycle], Cycle]:
    """A candidate whose sample of a place, the first one, has another number in a field."""

    def changed(given: Cycle) -> Cycle:
        columns = {name: column.copy() for name, column in getattr(given, candidate).items()}
        columns[field][place] += by
        return (
            replace(given, driving=columns) if candidate == "driving" else replace(given, emergency=columns)
        )

    return changed


def both(one: Callable[[Cycle], Cycle], other: Callable[[Cycle], Cycle]) -> Callable[[Cycle], Cycle]:
    return lambda given: other(one(given))


def stamped(t: float) -> Callable[[Cycle], Cycle]:
    return lambda given: replace(given, t=t)


@pytest.mark.parametrize(
    ("change", "now", "fault"),
    [
        (stamped(0.0009), 0.0009, "repeated"), (stamped(0.0011), 0.0011, ""),
        (stamped(0.149), 0.149, ""), (stamped(0.151), 0.151, "late"),
        (stamped(0.1), 0.199, ""), (stamped(0.1), 0.201, "stale"),
        (stamped(0.1), 0.0901, ""), (stamped(0.1), 0.0899, "early"),
        (first("emergency", "x", 0.099), 0.1, ""), (first("emergency", "x", -0.101), 0.1, "starts_elsewhere"),
        (first("driving", "y", 0.099), 0.1, ""), (first("driving", "y", 0.101), 0.1, "starts_elsewhere"),
        (both(first("driving", "x", 0.07), first("driving", "y", 0.07)), 0.1, ""),
        (both(first("driving", "x", 0.08), first("driving", "y", -0.07)), 0.1, "starts_elsewhere"),
        (first("driving", "heading", 0.049), 0.1, ""), (first("driving", "heading", -0.051), 0.1, "starts_elsewhere"),
        (first("emergency", "heading", 2.0 * math.pi + 0.049), 0.1, ""), (first("emergency", "heading", 2.0 * math.pi - 0.051), 0.1, "starts_elsewhere"),
        (first("emergency", "v", 0.49), 0.1, ""), (first("emergency", "v", -0.51), 0.1, "starts_elsewhere"),
        (first("emergency", "v", 0.0099, -1), 0.1, ""), (first("emergency", "v", 0.0101, -1), 0.1, "not_at_rest"),
        (first("emergency", "v", -0.0099, -1), 0.1, ""), (first("emergency", "v", -0.0101, -1), 0.1, "not_at_rest"),
    ],
)  # fmt: skip
@pytest.mark.verifies("S-1-B-9")
def test_up_to_each_limit_and_no_further(change: Callable[[Cycle], Cycle], now: float, fault: str) -> None:
    """A little within each of them, and a little beyond."""
    run = Run()
    run.step()
    run.clock.now = now
    decision = run.supervisor.step(change(cycle(1)))
    assert (names(decision), decision.safe) == ([fault] * bool(fault), not fault)


@pytest.mark.parametrize(
    ("field", "low", "high"),
    [("heading", -1000.0, 1000.0), ("kappa", -1.0, 1.0), ("v", -10.0, 150.0), ("a", -100.0, 50.0)],
)
@pytest.mark.verifies("S-1-B-9")
def test_both_ends_of_a_range_are_in_it_and_nothing_beyond(field: str, low: float, high: float) -> None:
    for end, beyond in ((low, -math.inf), (high, math.inf)):
        for value, fault in ((end, []), (math.nextafter(end, beyond), ["out_of_range"])):
            given = cycle(0)
            given.driving[field][7] = value
            decision = made()[0].step(given)
            assert (names(decision), decision.safe) == (fault, not fault), value


@pytest.mark.verifies("S-1-B-9")
def test_an_old_cycle_is_stale() -> None:
    run = Run()
    run.step()
    run.number += 1
    run.clock.ticks = [PERIOD + 0.11]
    decision = run.supervisor.step(cycle(1))
    assert names(decision) == ["stale"]


@pytest.mark.verifies("S-1-B-2", "S-1-B-4")
def test_a_late_verdict_is_unsafe() -> None:
    run = Run()
    run.step()
    run.clock.ticks = [PERIOD, PERIOD + 0.051]
    decision = run.supervisor.step(cycle(1))
    assert (decision.state, names(decision), decision.finished) == (
        "previous_emergency",
        ["overrun"],
        PERIOD + 0.051,
    )
    run = Run()
    run.step()
    run.clock.ticks = [PERIOD, PERIOD + 0.05 - 1e-9]
    assert run.supervisor.step(cycle(1)).state == "drive"


@pytest.mark.verifies("S-1-B-4")
@pytest.mark.parametrize(
    "ticks", [[math.nan], [RuntimeError("stopped")], [-1.0], [math.inf], [None], [0.1, 0.05], [0.1, math.nan]]
)
def test_a_wrong_clock_is_unsafe(ticks: list[Any]) -> None:
    run = Run()
    run.step()
    run.clock.now = 0.1
    run.clock.ticks = ticks
    decision = run.supervisor.step(cycle(1))
    assert "bad_clock" in names(decision)
    assert decision.safe is False
    assert decision.state in ("previous_emergency", "no_safe_trajectory")
    if len(ticks) == 1:
        assert decision.lost == "unconfirmed"


# Integrity ----------------------------------------------------------------------------------------------------


def _raise(error: BaseException) -> Any:
    raise error


def _odd(verdicts: Any, margins: Any = None) -> Callable[[Frame], Any]:
    def act(frame: Frame) -> Any:
        count = len(verdicts) if margins is None and isinstance(verdicts, bytes) else 0
        one = Oracle().rated(verdicts, [1.0] * count if margins is None else margins)
        return Judged(frame, {"driving": one, "emergency": one})

    return act


RULES = len(Oracle().rules)


@pytest.mark.verifies("S-1-B-4")
@pytest.mark.parametrize(
    ("act", "fault"),
    [
        (lambda frame: _raise(ValueError("broken")), "judge_failed"),
        (lambda frame: _raise(MemoryError()), "judge_failed"),
        (lambda frame: _raise(RecursionError()), "judge_failed"),
        (lambda frame: None, "incomplete"),
        (lambda frame: Judged(frame, {"driving": None, "emergency": None}), "incomplete"),  # type: ignore[dict-item]
        (lambda frame: Judged(frame, {}), "incomplete"),
        (lambda frame: _odd(bytes(RULES))(frame)._replace(about=Frame()), "incomplete"),
        (lambda frame: _odd(bytes(RULES))(frame)._replace(about=replace(frame)), "incomplete"),
        (lambda frame: (True, True), "incomplete"),
        (_odd(bytes(RULES - 1)), "incomplete"),
        (_odd(bytes(RULES + 1)), "incomplete"),
        (_odd(b""), "incomplete"),
        (_odd(bytes([5] * RULES)), "incomplete"),
        (_odd([0] * RULES, [1.0] * RULES), "incomplete"),
        (_odd(bytes(RULES), [1.0]), "incomplete"),
        (_odd(bytes(RULES), 7), "internal"),
    ],
)
def test_a_judge_that_fails_is_unsafe(act: Callable[[Frame], Any], fault: str) -> None:
    run = Run()
    run.step()
    run.oracle.act = act
    decision = run.step()
    assert (decision.state, names(decision)) == ("previous_emergency", [fault])
    run.oracle.act = None
    assert run.step().state == "drive"


@pytest.mark.parametrize("code", [1, 2])
@pytest.mark.verifies("S-1-B-5")
def test_violated_and_undefined_are_unsafe(code: int) -> None:
    for place in range(RULES):
        run = Run()
        run.step()
        verdicts = bytes(code if i == place else 0 for i in range(RULES))
        rated = run.oracle.rated
        run.oracle.act = lambda frame, v=verdicts, rated=rated: Judged(
            frame, {"driving": rated(v, [1.0] * RULES), "emergency": rated(bytes(RULES), [1.0] * RULES)}
        )
        decision = run.step()
        assert (decision.state, [v.rule for v in decision.violations]) == (
            "previous_emergency",
            [run.oracle.rules[place].name],
        )


@pytest.mark.verifies("S-1-B-10")
def test_inactive_and_open_make_nothing_unsafe() -> None:
    """What is open is decided in a later cycle, which it makes unsafe if it turns out violated."""
    for code in (3, 4):
        run = Run()
        rated = run.oracle.rated(bytes([code] * RULES), [1.0] * RULES)
        run.oracle.act = lambda frame, rated=rated: Judged(frame, {"driving": rated, "emergency": rated})
        assert run.step().safe


@pytest.mark.verifies("S-1-B-10")
def test_inactive_is_safe() -> None:
    run = Run()
    run.oracle.act = _odd(bytes([3] * RULES))
    assert run.step().state == "drive"


@pytest.mark.verifies("S-1-B-4")
def test_a_failure_of_its_own_is_unsafe(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Run()
    run.step()
    with monkeypatch.context() as patch:
        patch.setattr(run.supervisor.door, "admit", lambda *a: _raise(KeyError("x")))
        decision = run.step()
    assert (decision.state, names(decision)) == ("previous_emergency", ["internal"])
    with monkeypatch.context() as patch:
        patch.setattr("trackmarshal.runtime.supervisor.advance", lambda *a: _raise(KeyError("x")))
        decision = run.step()
    assert (decision.state, decision.driven, names(decision)) == (
        "no_safe_trajectory",
        None,
        ["late", "skipped", "incomplete"],
    )
    assert run.step().state == "drive"


@pytest.mark.parametrize(
    "given",
    [7, "cycle", {}, [], object(), Cycle, Cycle.__new__(Cycle), Cycle(None, None, None, None, None), np.zeros(3),
     type("T", (float,), {"__float__": lambda self: 1 / 0})(1.0)],
)  # fmt: skip
@pytest.mark.verifies("S-1-B-9")
def test_anything_at_all_is_a_decision(given: Any) -> None:
    run = Run()
    run.step()
    decision = run.step(change=lambda c: given)
    assert decision.state == "previous_emergency"
    assert decision.faults


@pytest.mark.verifies("S-1-B-9")
def test_hostile_values_inside_a_cycle() -> None:
    class Hostile(dict):  # type: ignore[type-arg]
        def __getitem__(self, *args: Any) -> Any:
            raise SystemError

    class Number(float):
        def __float__(self) -> float:
            raise ZeroDivisionError

    run = Run()
    run.step()
    for change in (
        lambda c: replace(c, driving=Hostile(c.driving)),
        lambda c: replace(c, signals={**c.signals, "ego": Hostile(c.signals["ego"])}),
        lambda c: replace(c, signals=Hostile(c.signals)),
        lambda c: replace(c, t=Number(c.t + 1.0)),
        lambda c: replace(c, signals={**c.signals, "ego": {**c.signals["ego"], "x": Number(math.nan)}}),
    ):
        decision = run.step(change=change, at=run.braked(0))
        assert decision.safe is False
        assert decision.faults


@pytest.mark.verifies("S-1-B-9")
def test_the_judge_is_not_asked_about_a_cycle_that_breaks_the_contract() -> None:
    run = Run()
    run.step(change=lambda c: replace(c, driving=None))
    assert run.oracle.asked == 0


# Setting up ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("budget", -1.0),
        ("apart", math.nan),
        ("samples", 1),
        ("samples", 5.0),
        ("blind", "1"),
        pytest.param(
            "longest_gap", 10**400, id="beyond all doubles"
        ),  # it cannot be added to a time: steps raised
        ("border", 2**31),  # generated C took another number for it
    ],
)
def test_limits_that_are_none(name: str, value: Any) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        Limits(**{name: value})
    assert caught.value.code == "E481"
    assert f"`{name}`" in caught.value.message


@pytest.mark.parametrize(
    "text",
    [
        "signal plan : state { v: m/s }\nrule r\n  require plan.v > 0 m/s\n",
        "signal plan : trajectory { t: s increasing, v: km/h }\nrule r\n  for all p in plan\n  require p.v > 0 m/s\n",
        "signal ego : series { t: s increasing, x: m }\nrule r\n  for all p in ego\n  require p.x > 0 m\n",
        "signal driving : set of object { x: m }\nrule r\n  for all o in driving\n  require o.x > 0 m\n",
    ],
)
def test_a_spec_that_declares_the_signals_otherwise(text: str, tmp_path: Path) -> None:
    path = tmp_path / "other.spec"
    path.write_text("module other\n" + text, encoding="utf-8")
    spec = load([path])
    oracle = Oracle()
    oracle.rules = spec.rules
    with pytest.raises(TrackmarshalError) as caught:
        Supervisor(spec, oracle, clock=Clock())
    assert (caught.value.code, caught.value.file, caught.value.line) == ("E482", str(path), 2)
    assert (
        "driving" not in text
        or caught.value.message == "`driving` is declared as a set of object, not as a trajectory"
    )


def test_what_it_reads_itself_is_demanded_whatever_the_spec_says_of_it() -> None:
    """Where a trajectory is, how it goes on, and that its times do, it relies on also where no rule asks."""
    spec = loads(
        "module m\nsignal plan : trajectory { t: s, v: m/s }\nrule slow for all p in plan require p.v <= 30 m/s\n"
    )
    still = [0.0] * 3
    plan = {"t": [0.0, 1.0, 1.0], "x": [0.0, 1.0, 1.0], "y": still, "heading": still, "v": [2.0, 0.0, 0.0]}
    short = {name: column for name, column in plan.items() if name not in ("y", "heading")}
    ego = {"x": 0.0, "y": 0.0}
    decision = supervisor(spec, clock=lambda: 0.0).step(Cycle(0, 0.0, plan, short, {"ego": ego}))
    assert {(name_of(f), f.signal, f.field, f.index) for f in decision.faults} == {
        ("not_increasing", "driving", "t", 2), ("missing", "emergency", "y", None), ("missing", "emergency", "heading", None),
        ("missing", "ego", "heading", None),
    }  # fmt: skip
    assert not decision.safe


# The page ----------------------------------------------------------------------------------------------------


def test_the_page_lists_every_fault_with_its_code() -> None:
    listed = dict(re.findall(r"^\| `(\w+)` \| (D\d+) \|", PAGE, re.MULTILINE))
    assert {**listed, "none_stored": "D241"} == FAULTS
    assert set(FAULTS.values()) <= set(CODES)


def test_the_page_lists_every_limit_with_its_default() -> None:
    section = PAGE.partition("\n## Limits\n")[2].partition("\n## ")[0]
    listed: dict[str, float] = {}
    for called, said in re.findall(r"^\| (`.+?`) \| ([0-9].*?) \|", section, re.MULTILINE):
        numbers = [float(one.split()[0]) for one in said.split(", ")]
        listed |= dict(zip(re.findall(r"`(\w+)`", called), numbers, strict=True))
    assert listed == asdict(Limits())


def test_the_page_shows_the_table_of_states() -> None:
    rows = re.findall(r"^\| `(\w+)` \| (.+?) \| (.+?) \| (.+?) \| (.+?) \|$", PAGE, re.MULTILINE)
    table = {
        (row[0], what): cell.strip("`")
        for row in rows
        for what, cell in zip(("safe", "holds", "lost", "none"), row[1:])
        if cell != "-"
    }
    assert table == NEXT
    assert tuple(row[0] for row in rows) == STATES


def test_the_shipped_contract_reads_what_it_should() -> None:
    contract = made()[0].door.contract
    assert [signal.name for signal in contract.signals] == ["ego", "objects", "obstacles", "track"]
    assert shipped().signals["plan"].name == "plan"
