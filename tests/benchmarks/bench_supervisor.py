"""The Supervisor's own part of a step, and whole steps: the door, the state machine and the record, then with the numpy evaluator.

Medians of CPU seconds. A cycle has two trajectories of 50 points, 3 objects and borders of 2 x 1500 points, as numpy arrays; all rules.
"""

from __future__ import annotations

import itertools
import math
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from operator import getitem
from pathlib import Path
from typing import Any

import numpy as np
from measuring import emptied, median, memory

from trackmarshal.evaluation import load
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.door.door import Door
from trackmarshal.runtime.door.lines import line
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import NOTHING, Judged, Memory, Program, Rated
from trackmarshal.runtime.record import Record
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.runtime.verdict import About

ROOT = Path(__file__).resolve().parents[2]
PERIOD, RADIUS = 0.1, 600.0
STEP = "Supervisor: step with C"
#: Samples of a trajectory: what a planner on a grid of 2.5 m sends at most over 10 s.
FEW, MANY = 50, 115
#: A planner has had all caches since the last step, and has written the candidates last: docs/supervisor.md.
PLANNED = f"{STEP}, caches emptied, then the cycle made"
EMPTIED = f"{STEP}, caches emptied, the cycle too"
LIMITS = {
    STEP: 40e-6,
    f"{STEP}, {MANY} points": 60e-6,
    f"{PLANNED}, to hot (ratio)": 2.5,
    f"{EMPTIED}, to hot (ratio)": 2.5,
    "Supervisor: what the record adds to a step": 50e-6,
}


def measure() -> dict[str, float]:
    """CPU seconds by name."""
    from trackmarshal.evaluation import Evaluator

    spec = load([ROOT / "specs" / "supervisor"])
    program = Evaluator(spec).program
    result = {"Supervisor: the door": _door(Supervisor(spec, program).door)}
    result["Supervisor: step without the judge"] = _steps(
        lambda clock: Supervisor(spec, _Safe(program), clock=clock)
    )
    with tempfile.TemporaryDirectory() as folder:
        numbers = itertools.count()

        def recorded(clock: Callable[[], float]) -> Supervisor:
            made = Supervisor(spec, _Safe(program), clock=clock)
            made.recorder = Record(
                Path(folder) / f"{next(numbers)}.arrows", made.contract, made.limits, program.identity
            )
            return made

        result["Supervisor: step without the judge, recorded"] = _steps(recorded)
    result |= _with_c(spec)
    result["Supervisor: step with numpy"] = _steps(
        lambda clock: Supervisor(spec, program, Limits(budget=math.inf), clock), steps=20
    )
    return result


def _with_c(spec: Spec) -> dict[str, float]:
    """Whole steps with the Supervisor in generated C; nothing where there is no compiler."""
    from trackmarshal.backends.c.build import compiler

    if compiler() is None:
        return {}
    count = int(os.environ.get("TRACKMARSHAL_STEPS", "20000"))
    frozen = Driven(spec, frozen=True)
    spent, grown = frozen.run(count)
    middle, late = np.quantile(spent, [0.5, 0.999])
    with tempfile.TemporaryDirectory() as folder:
        one, other = Driven(spec, frozen=True), Driven(spec, frozen=True, record=Path(folder) / "run.arrows")
        plain, kept = [], []
        for _ in range(20):  # by turns: a slow spell of the machine falls on both
            plain.append(one.run(200)[0])
            kept.append(other.run(200)[0])
        recorded = float(np.median(kept) - np.median(plain))
    planned = emptied(lambda: frozen.timed(anew(frozen.following())))
    cold = emptied(lambda: frozen.timed(frozen.following()))
    return {
        STEP: float(middle),
        f"{STEP}, {MANY} points": float(np.median(Driven(spec, frozen=True, points=MANY).run(4000)[0])),
        f"{STEP}, borders as arrays that are compared": float(
            np.median(Driven(spec, frozen=False).run(2000)[0])
        ),
        f"{STEP}, slowest thousandth of {count}, to its median (ratio)": float(late / middle),
        f"{STEP}, growth over {count} steps, memory": float(grown),
        PLANNED: planned,
        f"{PLANNED}, to hot (ratio)": planned / float(middle),
        EMPTIED: cold,
        f"{EMPTIED}, to hot (ratio)": cold / float(middle),
        "Supervisor: what the record adds to a step": recorded,
    }


class Driven:
    """A Supervisor in C that is given one cycle after the other. frozen: borders that nobody can change, as `tm.line` makes them."""

    def __init__(self, spec: Spec, frozen: bool, record: Path | None = None, points: int = FEW) -> None:
        from trackmarshal.supervision import supervisor

        self._now = [0.0]
        # A built-in function, as time.monotonic is.
        clock: Any = partial(getitem, self._now, 0)
        self._supervisor = supervisor(spec, backend="c", clock=clock, record=record)
        self._given = cycles(frozen, points)
        self.run(2000)

    def run(self, steps: int) -> tuple[Any, int]:
        """CPU seconds of so many steps, and by how much memory has grown over them."""
        spent = np.ones(steps)  # in memory before the first step
        before = memory()
        for number in range(steps):
            spent[number] = self.timed(self.following())
        return spent, memory() - before

    def following(self) -> Cycle:
        """The next cycle."""
        return next(self._given)

    def timed(self, cycle: Cycle) -> float:
        """CPU seconds of the step of a cycle."""
        self._now[0] = cycle.t
        time.process_time_ns()  # what times the step is in the caches before it
        begin = time.process_time_ns()
        decision = self._supervisor.step(cycle)
        spent = (time.process_time_ns() - begin) / 1e9
        assert decision.safe, decision.reasons
        return spent


def anew(cycle: Cycle) -> Cycle:
    """The same with dicts and arrays that are just made, but for the borders: as it comes from a planner and a tracker."""

    def copied(given: Any) -> Any:
        if isinstance(given, np.ndarray):
            return given.copy()
        return {name: copied(one) for name, one in given.items()} if isinstance(given, dict) else given

    signals = {name: one if name == "track" else copied(one) for name, one in cycle.signals.items()}
    return Cycle(cycle.number, cycle.t, copied(cycle.driving), copied(cycle.emergency), signals)


class _Safe:
    """Says at once that all is well."""

    def __init__(self, program: Program) -> None:
        self.spec, self.rules, self.identity = program.spec, program.rules, program.identity
        margins = [1.0] * len(self.rules)
        self._said = Rated(bytes(len(self.rules)), margins, lambda number, series: _never(number))

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        return Judged(frame, dict.fromkeys(frame.candidates, self._said))

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        return [self.judge(NOTHING, frame) for frame in frames]

    def start(self) -> Memory:
        return NOTHING

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        return memory

    def missed(self, memory: Memory, cycles: int = 1) -> Memory:
        return memory

    def end(self, memory: Memory) -> dict[str, tuple[About, ...]]:
        return {}


def _never(number: int) -> Any:
    raise AssertionError(f"nobody asks why of rule {number}")


def plan(braking: float, n: int = FEW) -> dict[str, Any]:
    """Samples on a circle, at 40 m/s, 0.1 s apart; one that brakes ends at rest."""
    t = np.linspace(0.0, 40.0 / braking if braking else 0.1 * (n - 1), n)
    s = 40.0 * t - braking * t**2 / 2
    v = 40.0 - braking * t
    v[-1] = 0.0 if braking else 40.0
    angle = 1 / 6 + s / RADIUS
    return {
        "t": t, "s": s, "x": RADIUS * np.cos(angle), "y": RADIUS * np.sin(angle), "heading": angle + math.pi / 2,
        "kappa": np.full(n, 1 / RADIUS), "v": v, "a": np.full(n, -braking), "grip": np.ones(n),
    }  # fmt: skip


def cycles(frozen: bool = False, points: int = FEW) -> Iterator[Cycle]:
    """The same situation again and again, in order."""
    driving, emergency = plan(0.0, points), plan(9.0, points)
    ahead = 1 / 6 + np.array([60.0, 90.0, -40.0]) / RADIUS

    def border(radius: float, phase: float) -> Any:
        """A winding ring. (A circle would be a border of its own kind: everything on the track is equally far from it.)"""
        ring = np.linspace(0.0, 2 * math.pi, 1500, endpoint=False)
        return (radius + 3 * np.sin(60 * ring + phase))[:, None] * np.column_stack(
            [np.cos(ring), np.sin(ring)]
        )

    signals = {
        "ego": {"x": driving["x"][0], "y": driving["y"][0], "heading": driving["heading"][0], "v": 40.0, "age": 0.0},
        "objects": {
            "id": ["a", "b", "c"], "x": 602.0 * np.cos(ahead), "y": 602.0 * np.sin(ahead), "heading": ahead + math.pi / 2,
            "v": np.full(3, 45.0), "length": np.full(3, 4.7), "width": np.full(3, 2.0), "age": np.zeros(3),
        },
        "obstacles": {name: np.zeros(0) for name in ("x", "y", "heading", "length", "width")},
        "track": {"left": border(593.0, 0.0), "right": border(607.0, 1.0), "closed": True},
    }  # fmt: skip
    if frozen:
        track: Any = signals["track"]
        signals["track"] = {**track, "left": line(track["left"]), "right": line(track["right"])}
    for number in itertools.count():
        yield Cycle(number, number * PERIOD, driving, emergency, signals)


def _door(door: Door, count: int = 500) -> float:
    given = cycles()

    def many() -> None:
        for cycle in itertools.islice(given, count):
            assert not door.admit(0, cycle, cycle.t).faults

    return median(many, 9) / count


def _steps(make: Callable[[Callable[[], float]], Supervisor], steps: int = 500) -> float:
    now = [0.0]
    supervisor = make(lambda: now[0])
    given = cycles()

    def many() -> None:
        for cycle in itertools.islice(given, steps):
            now[0] = cycle.t
            decision = supervisor.step(cycle)
            assert decision.safe, decision.reasons

    return median(many, 9) / steps


if __name__ == "__main__":
    for name, value in measure().items():
        print(f"{value * 1e6:12.1f} us  {name}")
