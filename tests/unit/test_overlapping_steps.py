"""A step that begins while another one is taken decides nothing, and changes nothing."""

from __future__ import annotations

import ctypes
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any

import pytest

import trackmarshal as tm
from support.cycles import PERIOD, cycle
from support.supervised import shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.calling.quick import Slowly
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import FAULTS
from trackmarshal.runtime.record import Record
from trackmarshal.runtime.record.reading import read
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.supervision import supervisor

IN_C = pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
AT_LENGTH = pytest.param("slowly", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
pytestmark = pytest.mark.parametrize("backend", ["reference", IN_C, AT_LENGTH])
#: About all that comes with a cycle; how many rules there are makes no difference to whose turn it is.
RULES = ("friction", "safe_gap", "obstacle_collision", "static_collision")


class Stopping(Mapping[str, Any]):
    def __getitem__(self, name: str) -> Any:
        raise KeyboardInterrupt

    def __iter__(self) -> Iterator[str]:
        raise KeyboardInterrupt

    def __len__(self) -> int:
        raise KeyboardInterrupt


class Clock:
    """Stands at a time; `asks` runs when it is read for the second time in a step, once."""

    def __init__(self) -> None:
        self.now, self.reads = 0.0, 0
        self.asks: Callable[[], None] | None = None

    def __call__(self) -> float:
        self.reads += 1
        if self.asks is not None and self.reads == 2:
            asks, self.asks = self.asks, None
            asks()
        return self.now


def made(backend: str, clock: Clock, record: Path | None = None) -> Supervisor | CSupervisor:
    own = "c" if backend == "slowly" else backend
    one = supervisor(shipped(), RULES, own, {"budget": 1e3}, clock, record, snapshots=0)
    return quickly_or_not(one, backend)


def quickly_or_not(one: Supervisor | CSupervisor, backend: str) -> Supervisor | CSupervisor:
    if backend == "slowly":
        assert isinstance(one, CSupervisor)
        one._quick = Slowly()
        one.recorder = one.recorder
    return one


def stepped(one: Supervisor | CSupervisor, clock: Clock, number: int) -> Decision:
    clock.now, clock.reads = PERIOD * number, 0
    return one.step(cycle(number))


def refused(decision: Decision) -> None:
    assert (decision.action, decision.safe, decision.driven, decision.fallback) == (
        "no_safe_trajectory",
        False,
        None,
        None,
    )
    assert [(fault.code, fault.field) for fault in decision.faults] == [(FAULTS["incomplete"], "step")]


def test_from_another_thread(backend: str) -> None:
    clock = Clock()
    one = made(backend, clock)
    for number in range(3):  # C knows the cycles by then
        assert stepped(one, clock, number).safe
    inside, over = threading.Event(), threading.Event()
    decisions: list[Decision] = []

    def wait() -> None:
        inside.set()
        assert over.wait(30)

    clock.asks = wait
    other = threading.Thread(target=lambda: decisions.append(stepped(one, clock, 3)))
    other.start()
    assert inside.wait(30)
    try:
        refused(one.step(None))
        refused(one.step(replace(cycle(4), t=99.0)))
    finally:
        over.set()
        other.join()
    assert [(decision.state, decision.number) for decision in decisions] == [("drive", 3)]
    assert stepped(one, clock, 4).safe


def test_from_what_is_handed_in(backend: str, tmp_path: Path) -> None:
    clock = Clock()
    one = made(backend, clock, tmp_path / "run.arrows")
    within: list[Decision] = []

    class Asking(Mapping[str, Any]):
        def __init__(self, given: Mapping[str, Any]) -> None:
            self.given = given

        def __getitem__(self, name: str) -> Any:
            within.append(one.step(cycle(7)))
            return self.given[name]

        def __iter__(self) -> Iterator[str]:
            return iter(self.given)

        def __len__(self) -> int:
            return len(self.given)

    for number in range(3):
        assert stepped(one, clock, number).safe
    clock.asks = lambda: within.append(one.step(cycle(8)))
    assert stepped(one, clock, 3).safe
    clock.now, clock.reads = PERIOD * 4, 0
    asking = cycle(4)
    assert one.step(replace(asking, signals=Asking(asking.signals))).safe
    assert stepped(one, clock, 5).safe
    assert len(within) > 1
    for decision in within:
        refused(decision)
    one.close()
    run = read((tmp_path / "run.arrows").read_bytes(), "run.arrows")
    assert [kept.cycle.number for kept in run.cycles] == list(range(6))


def test_who_was_stopped_in_a_step_takes_the_next_one(backend: str) -> None:
    clock = Clock()
    one = made(backend, clock)
    for number in range(3):
        assert stepped(one, clock, number).safe

    def stop() -> None:
        raise KeyboardInterrupt

    clock.asks = stop
    with pytest.raises(KeyboardInterrupt):
        stepped(one, clock, 3)
    assert [fault.code for fault in one.step(None).faults] == [FAULTS["missing_cycle"]]


def test_who_was_stopped_where_a_step_begins_takes_the_next_one(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by a signal that is seen as soon as it is noted that a step is taken: every step behind it was refused, as one that overlaps with it."""
    clock = Clock()
    one = made(backend, clock)
    for number in range(3):
        assert stepped(one, clock, number).safe
    owner: Any = one if isinstance(one, Supervisor) else one._quick
    if not hasattr(owner, "_looked_at"):
        pytest.skip("C notes it, and sees no signals")

    class Stopped:
        def __enter__(self) -> None:
            pass

        def __exit__(self, *raised: object) -> None:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(owner, "_looked_at", Stopped())
        with pytest.raises(KeyboardInterrupt):
            stepped(one, clock, 3)
    assert stepped(one, clock, 3).safe


def test_who_was_stopped_while_a_cycle_was_read_keeps_what_is_stored(backend: str) -> None:
    clock = Clock()
    one = made(backend, clock)
    for number in range(3):
        assert stepped(one, clock, number).safe
    clock.now, clock.reads = PERIOD * 3, 0
    with pytest.raises(KeyboardInterrupt):
        one.step(replace(cycle(3), signals=Stopping()))
    decision = one.step(None)
    assert (decision.state, [fault.code for fault in decision.faults]) == (
        "previous_emergency",
        [FAULTS["missing_cycle"]],
    )
    assert decision.driven is not None
    assert decision.driven.number == 2


@pytest.mark.parametrize("v", [3.0, 0.0])
def test_a_cycle_in_which_a_step_was_stopped_is_a_gap_to_rules_over_the_run(backend: str, v: float) -> None:
    """It had been read, so that nothing was missing; what was too fast in it was in no window of the next second, which was driven. Nobody knows what
    it was, so that it is no less a gap where it was slow."""
    spec = tm.loads(
        "module small\n"
        "signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
        "signal ego : state { x: m, y: m, heading: rad, v: m/s }\n"
        'rule steady "In the last second, the car was no faster than 2 m/s"\n'
        "  require historically[0 s, 1 s] ego.v <= 2 m/s\n"
    )
    clock = Clock()
    one = quickly_or_not(
        supervisor(spec, backend="c" if backend == "slowly" else backend, clock=clock), backend
    )
    stands = {"t": [0.0, 1.0], **{name: [0.0, 0.0] for name in ("x", "y", "heading", "v")}}

    def step(number: int, v: float) -> Decision:
        clock.now, clock.reads = PERIOD * number, 0
        ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": v}
        return one.step(Cycle(number, clock.now, stands, stands, {"ego": ego}))

    def stop() -> None:
        raise KeyboardInterrupt

    assert [step(number, 0.0).safe for number in range(3)] == [True] * 3
    with pytest.raises(KeyboardInterrupt):
        one.step(Cycle(3, 0.0, stands, stands, Stopping()))  # while it is read, it is none
    assert step(3, 0.0).safe
    clock.asks = stop
    with pytest.raises(KeyboardInterrupt):
        step(4, v)
    assert [(step(number, 0.0).safe, step(number + 1, 0.0).safe) for number in (5, 7, 9)] == [
        (False, False)
    ] * 3
    assert [step(number, 0.0).safe for number in range(11, 16)][-1]


def test_a_cycle_in_which_a_step_was_stopped_is_missing_in_the_record(backend: str, tmp_path: Path) -> None:
    """Nothing of it was there, so that a replay decided the next cycle otherwise (`skipped`), and did not know why. What was not read is none, and what
    stands in the record is there."""
    clock, path = Clock(), tmp_path / "run.arrows"
    one = made(backend, clock, path)
    assert [stepped(one, clock, number).safe for number in range(3)] == [True] * 3

    def stop(*given: Any) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        one.step(replace(cycle(3), signals=Stopping()))
    clock.asks = stop
    with pytest.raises(KeyboardInterrupt):
        stepped(one, clock, 3)
    assert stepped(one, clock, 4).safe
    recorder = one.recorder
    assert isinstance(recorder, Record)

    def append(*given: Any) -> None:
        recorder.append(*given)
        stop()

    one.recorder = SimpleNamespace(append=append, stopped=recorder.stopped, close=recorder.close)
    with pytest.raises(KeyboardInterrupt):
        stepped(one, clock, 5)
    one.recorder = recorder
    assert stepped(one, clock, 6).safe
    one.close()
    run = read(path.read_bytes(), str(path))
    assert [one.cycle.number for one in run.cycles if isinstance(one.cycle, Cycle)] == [0, 1, 2, 4, 5, 6]
    assert (run.missed, run.damage, run.ended) == (1, "", True)


@pytest.mark.parametrize("stops", [[0], [3], [0, 3]])
def test_a_step_is_missing_wherever_it_was_stopped(backend: str, stops: list[int], tmp_path: Path) -> None:
    """Before the first row, and behind the last one."""
    clock, path = Clock(), tmp_path / "run.arrows"
    one = made(backend, clock, path)

    def stop() -> None:
        raise KeyboardInterrupt

    for number in range(4):
        clock.asks = stop if number in stops else None
        if number in stops:
            with pytest.raises(KeyboardInterrupt):
                stepped(one, clock, number)
        else:
            stepped(one, clock, number)
    one.close()
    run = read(path.read_bytes(), str(path))
    assert (len(run.cycles), run.missed, run.damage, run.ended) == (4 - len(stops), len(stops), "", True)


def test_a_recorder_that_knows_of_no_stopped_steps_stops_nobody_else(backend: str, tmp_path: Path) -> None:
    """One of before had `append` and `close`: in place of what the signal's handler has raised, an AttributeError came out of the step."""
    clock = Clock()
    one = made(backend, clock)
    one.recorder = SimpleNamespace(append=lambda *given: None, close=lambda: None)
    assert stepped(one, clock, 0).safe

    def stop() -> None:
        raise KeyboardInterrupt

    clock.asks = stop
    with pytest.raises(KeyboardInterrupt):
        stepped(one, clock, 1)
    assert "stopped" in one.record_error
    assert one.record_error.startswith("AttributeError: ")


def borders() -> dict[str, Any]:
    """Of one road, which nobody can change."""
    return {side: tm.line([(-50.0, y), (2000.0, y)]) for side, y in (("left", 6.0), ("right", -6.0))}


def test_who_was_stopped_by_a_signal_is_not_told_of_another_cycle(backend: str, tmp_path: Path) -> None:
    """The clock runs no code of Python's, so that a signal that comes meanwhile is seen no sooner than the next instruction of the step."""
    raise_, sent, track = getattr(ctypes.CDLL(None), "raise"), ctypes.c_int(0), borders()

    def stop(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    one = quickly_or_not(
        supervisor(
            shipped(), backend="c" if backend == "slowly" else backend, clock=partial(raise_, sent), record=tmp_path / "run.arrows",
            limits={"budget": 1e3, "clock_tolerance": 1e3}, snapshots=0,
        ),
        backend,
    )  # fmt: skip

    def step(number: int) -> Decision:
        given = cycle(number)
        return one.step(replace(given, signals={**given.signals, "track": track}))

    before = signal.signal(signal.SIGUSR1, stop)
    try:
        for number in range(3):  # C knows the cycles by then
            assert step(number).safe
        sent.value = signal.SIGUSR1
        with pytest.raises(KeyboardInterrupt):
            step(3)
        sent.value = 0
        decision = one.step(None)
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert (decision.state, decision.number) == ("previous_emergency", None)
    assert [fault.code for fault in decision.faults] == [FAULTS["missing_cycle"]]
    assert decision.driven is not None
    assert decision.driven.number in (
        2,
        3,
    )  # it was stopped before the cycle was read, or behind all that was to be decided of it


def test_what_was_stopped_while_it_was_read_is_missing(backend: str) -> None:
    """Two cycles are, and in each of them what is counted may have been."""
    spec = tm.loads(
        "module small\n"
        "signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
        "signal ego : state { x: m, y: m, heading: rad, v: m/s }\n"
        'rule seldom "In ten seconds, the car is faster than 2 m/s once"\n'
        "  require count(ego.v > 2 m/s, last: 10 s) <= 1\n"
    )
    clock = Clock()
    one = quickly_or_not(
        supervisor(spec, backend="c" if backend == "slowly" else backend, clock=clock, limits={"longest_gap": 1.0}), backend
    )  # fmt: skip
    stands = {"t": [0.0, 9.0], **{name: [0.0, 0.0] for name in ("x", "y", "heading", "v")}}
    slow = {"ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 0.0}}

    def step(number: int, signals: Any = slow) -> Decision:
        clock.now = PERIOD * number
        return one.step(Cycle(number, clock.now, stands, stands, signals))

    assert [step(number).safe for number in range(3)] == [True] * 3
    with pytest.raises(KeyboardInterrupt):
        step(3, Stopping())
    assert [fault.code for fault in step(4).faults] == [FAULTS["skipped"]]
    after = step(5)
    assert ([fault.code for fault in after.faults], after.safe) == ([], False)
    assert [one.verdict for one in after.violations] == ["undefined"] * 2


def test_who_was_stopped_before_a_cycle_was_decided_goes_on_from_the_one_before(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by a signal that comes just then: when the door has looked at the cycle, or before C is asked."""
    clock = Clock()
    one = made(backend, clock)
    for number in range(3):
        assert stepped(one, clock, number).safe

    def stop(*given: Any) -> None:
        if isinstance(one, Supervisor):
            looked_at(*given)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        if isinstance(one, Supervisor):
            looked_at = one.door.admit
            patch.setattr(one.door, "admit", stop)
        else:
            patch.setattr(one.stepper, "step", stop)
        with pytest.raises(KeyboardInterrupt):
            stepped(one, clock, 3)
    decision = stepped(one, clock, 4)
    assert (decision.state, [fault.code for fault in decision.faults]) == (
        "previous_emergency",
        [FAULTS["late"], FAULTS["skipped"]],
    )
    assert decision.driven is not None
    assert decision.driven.number == 2
    assert stepped(one, clock, 5).safe


def test_what_is_stored_is_driven_from_behind_steps_that_were_stopped_one_after_the_other(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by an alarm that rings in every cycle: the first of them was decided, and the others were not."""
    clock = Clock()
    one = made(backend, clock)
    for number in range(3):
        assert stepped(one, clock, number).safe

    def stop(*given: Any) -> None:
        raise KeyboardInterrupt

    def decide(*given: Any) -> None:
        decided(*given)
        raise KeyboardInterrupt

    in_python = isinstance(one, Supervisor)
    owner, name = (one.program, "commit") if isinstance(one, Supervisor) else (one.stepper, "step")
    decided = getattr(owner, name)
    for number, at, does in ((3, name, decide), (4, "judge" if in_python else name, stop)):
        with monkeypatch.context() as patch:
            patch.setattr(owner, at, does)
            with pytest.raises(KeyboardInterrupt):
                stepped(one, clock, number)
    decision = one.step(None)
    assert (decision.state, decision.fallback) == ("previous_emergency", decision.driven)
    assert decision.driven is not None
    assert decision.driven.number == 3


def test_a_cycle_that_did_not_come_is_missing_once_where_its_step_was_stopped(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rules over the run had been told of it: it was missing twice to a Supervisor in C."""
    spec = tm.loads(
        "module small\n"
        "signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
        "signal ego : state { x: m, y: m, heading: rad, v: m/s }\n"
        'rule seldom "In ten seconds, the car is faster than 2 m/s twice"\n'
        "  require count(ego.v > 2 m/s, last: 10 s) <= 2\n"
    )
    clock = Clock()
    one = quickly_or_not(
        supervisor(spec, backend="c" if backend == "slowly" else backend, clock=clock, limits={"longest_gap": 1.0}), backend
    )  # fmt: skip
    stands = {"t": [0.0, 9.0], **{name: [0.0, 0.0] for name in ("x", "y", "heading", "v")}}
    slow = {"ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 0.0}}

    def step(number: int) -> Decision:
        clock.now = PERIOD * number
        return one.step(Cycle(number, clock.now, stands, stands, slow))

    assert [step(number).safe for number in range(3)] == [True] * 3
    owner, name = (one.program, "missed") if isinstance(one, Supervisor) else (one.stepper, "none_came")
    told, seen = getattr(owner, name), iter([True])

    def stop(*given: Any) -> Any:
        said = told(*given)
        if next(seen, False):
            raise KeyboardInterrupt
        return said

    with monkeypatch.context() as patch:
        patch.setattr(owner, name, stop)
        with pytest.raises(KeyboardInterrupt):
            one.step(None)
    assert [fault.code for fault in step(4).faults] == [FAULTS["skipped"]]
    assert step(5).safe


def test_who_was_stopped_while_another_thread_takes_a_step_changes_nothing(backend: str) -> None:
    """What rules over the run are told after a step that was stopped is told when no other step is taken."""
    if backend == "reference":
        pytest.skip("a step that was refused is told nothing")
    clock = Clock()
    one = made(backend, clock)
    assert isinstance(one, CSupervisor)
    for number in range(3):
        assert stepped(one, clock, number).safe
    inside, over = threading.Event(), threading.Event()
    decisions: list[Decision] = []

    def wait() -> None:
        inside.set()
        assert over.wait(30)

    clock.asks = wait
    other = threading.Thread(target=lambda: decisions.append(stepped(one, clock, 3)))
    other.start()
    assert inside.wait(30)
    try:
        one._gap()
    finally:
        over.set()
        other.join()
    assert [(decision.state, decision.number) for decision in decisions] == [("drive", 3)]
    assert stepped(one, clock, 4).safe


def test_what_was_stored_by_a_step_that_was_stopped_is_driven_from(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by a signal that comes when C, or the state machine, is through with a cycle that is safe, and nobody has been told."""
    clock = Clock()
    one = made(backend, clock)
    for number in range(3):
        assert stepped(one, clock, number).safe

    def stop(*given: Any) -> None:
        decided(*given)
        raise KeyboardInterrupt

    owner, name = (one.program, "commit") if isinstance(one, Supervisor) else (one.stepper, "step")
    decided = getattr(owner, name)
    with monkeypatch.context() as patch:
        patch.setattr(owner, name, stop)
        with pytest.raises(KeyboardInterrupt):
            stepped(one, clock, 3)
    clock.reads = 0
    for again in (one.step(None), one.step(replace(cycle(4), driving=None))):
        assert again.state == "previous_emergency"
        assert again.driven is not None
        assert again.driven is again.fallback
        assert again.driven.number == 3
        assert again.driven.due == pytest.approx([t + 3 * PERIOD for t in cycle(3).emergency["t"]])
        assert again.driven.columns.listed("x") == cycle(3).emergency["x"].tolist()
    assert stepped(one, clock, 4).safe


def test_a_step_that_the_handler_of_a_signal_takes_waits_for_nobody(backend: str) -> None:
    """As of an alarm that says that no cycle came, at whatever line of the step that it interrupts: whom that waits for is itself."""
    clock = Clock()
    one = made(backend, clock)
    codes = {Supervisor.step.__code__, Slowly.step.__code__}
    places: list[int] = []

    def taken_at(place: int) -> None:
        lines = iter(range(100))

        def inside(frame: FrameType, event: str, given: Any) -> Any:
            if event == "line" and next(lines) == place:
                one.step(None)
            return inside

        sys.settrace(lambda frame, event, given: inside if frame.f_code in codes else None)
        try:
            stepped(one, clock, place)
        finally:
            sys.settrace(None)
        places.append(place)

    def all_places() -> None:
        for place in range(8):
            taken_at(place)

    thread = threading.Thread(target=all_places, daemon=True)
    thread.start()
    thread.join(60)
    assert places == list(range(8))
