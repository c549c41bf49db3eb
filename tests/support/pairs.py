"""Two Supervisors that see the same, one of them generated C: every decision of the one has to be that of the other."""

from __future__ import annotations

import math
import random
import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from typing import Any
from unittest import mock

import numpy as np

import trackmarshal as tm
from support.cycles import PERIOD, cycle, mutate
from trackmarshal.backends.c.step import Stepper
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.door.lines import _made
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.frame import NO_SETTINGS, Frame, Settings
from trackmarshal.runtime.plan import Plan
from trackmarshal.runtime.program import Judged, Memory, Program
from trackmarshal.runtime.supervisor import Supervisor


class Readings:
    """A clock that reads what it is told to; it raises for None."""

    def __init__(self) -> None:
        self.waiting: list[float | None] = []

    def read(self) -> float:
        reading = self.waiting.pop(0)
        if reading is None:
            raise OSError("no time")
        return reading


class Pair:
    """Both Supervisors; `step` compares their decisions and gives that of C."""

    def __init__(
        self, evaluator: Evaluator, settings: Settings = NO_SETTINGS, limits: Limits | None = None
    ) -> None:
        self.clocks = Readings(), Readings()
        spec, rules = evaluator.spec, evaluator.rules
        self.c = CSupervisor(spec, rules, limits, self.clocks[0].read, settings)
        self.python = Supervisor(spec, evaluator.program, limits, self.clocks[1].read, settings)

    def step(self, given: Any, *readings: float | None) -> Decision:
        """One step at these readings of the clock: at the arrival, and when the verdict is there."""
        self.tell(readings)
        return self.compare(self.c.step(given), self.python.step(given))

    def tell(self, readings: tuple[float | None, ...]) -> None:
        """What both clocks read in the step to come."""
        for clock in self.clocks:
            clock.waiting = list(readings)

    def compare(self, mine: Decision, other: Decision) -> Decision:
        """What C decided, if that is what Python did."""
        agree(mine, other)
        assert len(self.clocks[0].waiting) == len(self.clocks[1].waiting)
        self._stored(mine)
        return mine

    def _stored(self, decision: Decision) -> None:
        """What C itself has stored is what its decision says."""
        if decision.fallback is not None:
            matrix, stepper = decision.fallback.matrix, self.c.stepper
            assert isinstance(stepper, Stepper)
            for place, row in enumerate(matrix):
                assert stepper.stored(place)[: len(row)].tobytes() == row.tobytes()


class Abreast:
    """Pairs whose runs go on step by step together, so that numpy judges the cycles of all of them at once: half the time, where no rule
    remembers anything. It prepares a line once for all of them: `lines_once`."""

    def __init__(self, evaluator: Evaluator, runs: int) -> None:
        self._evaluator, self._judged = evaluator, dict[int, Judged]()
        self._pairs = [Pair(evaluator) for _ in range(runs)]
        for pair in self._pairs:
            pair.python.program = _Asked(evaluator.program, self._judged)

    def step(self, steps: Sequence[Step]) -> list[Decision]:
        """One step of each pair, each a cycle with its readings, as `Pair.step`."""
        each = list(zip(self._pairs, steps, strict=True))
        for pair, (_, readings) in each:
            pair.tell(readings)
        mine = [pair.c.step(given) for pair, (given, _) in each]
        begun = [pair.python.open(given) for pair, (given, _) in each]
        asked = [one.admission.frame for one in begun if one.admission is not None and not one.faults]
        self._judged.clear()
        self._judged |= {id(judged.about): judged for judged in self._evaluator.judge_all(asked)}
        other = [pair.python.go_on(opened) for pair, opened in zip(self._pairs, begun)]
        return [pair.compare(*both) for pair, *both in zip(self._pairs, mine, other)]


@contextmanager
def lines_once() -> Iterator[None]:
    """Equal points are one line, whoever reads them."""
    made = lru_cache(64)(lambda content: _made(np.frombuffer(content).reshape(-1, 2)))
    with mock.patch("trackmarshal.runtime.door.lines._made", lambda points: made(points.tobytes())):
        yield


class _Asked:
    """A program that says what was said of a frame before it is asked; all else is that of the program in whose place it is."""

    def __init__(self, program: Program, judged: dict[int, Judged]) -> None:
        self._program, self._judged = program, judged

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        return self._judged[id(frame)]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._program, name)


def agree(mine: Decision, other: Decision) -> None:
    """Everything of a decision is the same; margins but for the last bits, where numpy has functions of its own."""
    assert told(mine) == told(other)
    assert [bits(x) for x in times(mine)] == [bits(x) for x in times(other)]
    assert planned(mine.driven) == planned(other.driven)
    assert planned(mine.fallback) == planned(other.fallback)
    assert (mine.judged is None) == (other.judged is None)
    if mine.judged is not None and other.judged is not None:
        for name, rated in mine.judged.rated.items():
            assert rated.verdicts == other.judged.rated[name].verdicts
            np.testing.assert_allclose(
                rated.margins, other.judged.rated[name].margins, rtol=1e-12, atol=1e-12
            )


def told(decision: Decision) -> tuple[Any, ...]:
    faults = [(name_of(f), f.signal, f.field, f.index, f.message) for f in decision.faults]
    against = [(v.rule, v.requirements, v.candidate, v.verdict, v.unit) for v in decision.violations]
    return decision.number, decision.state, decision.safe, decision.lost, decision.more, faults, against


def times(decision: Decision) -> tuple[float, ...]:
    return decision.t, decision.now, decision.finished, decision.valid_until


def bits(x: float) -> bytes:
    return b"nan" if math.isnan(x) else struct.pack("<d", x)


def planned(plan: Plan | None) -> tuple[Any, ...] | None:
    return (
        None
        if plan is None
        else (plan.candidate, plan.number, bits(plan.t), plan.names, plan.matrix.tobytes())
    )


def declared(given: Cycle, spec: Spec) -> Cycle:
    """A cycle without what the spec does not declare: then it gets as far as the rules."""
    signals = dict(given.signals)
    for name, value in signals.items():
        known = {field.name for field in spec.signals[name].fields_} | {"id", "closed"}
        if isinstance(value, dict):
            signals[name] = {field: own for field, own in value.items() if field in known}
        elif isinstance(value, list):
            signals[name] = [{field: own for field, own in one.items() if field in known} for one in value]
    return replace(given, signals=signals)


# Generated runs --------------------------------------------------------------------------------------------------

Step = tuple[Any, tuple[float | None, ...]]


def generated(seed: int, steps: int = 50) -> Iterator[Step]:
    """A run with faults of every kind: cycles that break the contract or a rule, that come late, twice or not at all, clocks that are
    wrong, a car that leaves its trajectory, borders that change."""
    rng = random.Random(seed)
    number, late, shift = 0, 0.0, 0.0
    rate = rng.choice((0.05, 0.3, 0.8))
    for _ in range(steps):
        given: Any = cycle(number, 1 + rng.randrange(4), 1 + rng.randrange(3))
        arrival: float | None = number * PERIOD + 0.01 + late
        taken: float | None = arrival + rng.choice((0.001, 0.02)) if arrival is not None else None
        if shift:
            given.signals["ego"]["x"] += shift
        if rng.random() < rate:
            event = rng.choice(_EVENTS)
            given, arrival, taken = event(rng, given, arrival, taken)
            shift = rng.choice((0.0, 0.0, 1.0, 30.0)) if event is _leave else 0.0
        yield given, (arrival, taken)
        number += rng.choice((1,) * 60 + (0, 0, 2, 2, 3, 3, 40))
        late = rng.choice((0.0,) * 20 + (0.05, 0.2))


Event = Callable[[random.Random, Cycle, Any, Any], tuple[Any, Any, Any]]


def _broken(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    for _ in range(rng.choice((1, 1, 2, 4))):
        try:
            given = mutate(rng, given)[0]
        except Exception:  # what is changed once may not be there to be changed again
            break
    return given, arrival, taken


def _violating(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    side = rng.choice((given.driving, given.emergency))
    name, value = rng.choice((("a", 30.0), ("kappa", 0.5), ("y", 20.0), ("v", 100.0), ("x", 40.0)))
    side[name] = side[name] + np.linspace(0.0, value, len(side[name]))
    return given, arrival, taken


def _near(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    given.signals["objects"]["x"] = given.signals["objects"]["x"] - rng.uniform(80.0, 160.0)
    return given, arrival, taken


def _none(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    return rng.choice((None, None, 7, {}, "cycle")), arrival, taken


def _clock(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    wrong = rng.choice((math.nan, math.inf, -math.inf, None, arrival - 1.0, 0.0))
    return (given, wrong, taken) if rng.random() < 0.5 else (given, arrival, wrong)


def _slow(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    return given, arrival, arrival + rng.choice((0.05, 0.0500001, 0.08))


def _leave(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    given.signals["ego"]["y"] += rng.choice((0.5, 2.5, -40.0))
    given.signals["ego"]["heading"] += rng.choice((0.0, 0.4, 6.283185307179586))
    given.signals["ego"]["age"] = rng.choice((0.0, 0.05, 0.3))
    given.emergency["v"][-1] = rng.choice((0.0, 1.0))
    return given, arrival, taken


def _border(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    track = {name: given.signals["track"][name].copy() for name in ("left", "right")}
    kind = rng.randrange(5)
    if kind == 0:
        track["left"][:, 1] += rng.choice((-4.0, -0.5, 0.5))
    elif kind == 1:
        track["left"][rng.randrange(len(track["left"])), 1] = -7.0  # the borders cross
    elif kind == 2:
        track["right"] = track["right"][: rng.randrange(3, 60)]
    elif kind == 3:
        track["closed"] = True
    else:
        track = {name: line.tolist() for name, line in track.items()}
    return replace(given, signals={**given.signals, "track": track}), arrival, taken


def _junk(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    class Odd(dict[str, Any]):
        def keys(self) -> Any:
            raise RuntimeError("not today")

    place = rng.choice(("driving", "signals"))
    odd: dict[str, Any] = {place: Odd(getattr(given, place))}
    return replace(given, **odd), arrival, taken


def _misspelt(rng: random.Random, given: Cycle, arrival: Any, taken: Any) -> tuple[Any, Any, Any]:
    place = rng.choice((given.driving, given.signals, given.signals["ego"], given.signals["objects"]))
    place["headnig"] = 1.0
    return given, arrival, taken


_EVENTS: tuple[Event, ...] = (
    _broken, _broken, _broken, _broken, _violating, _near, _none, _clock, _slow, _leave, _leave, _border, _junk, _misspelt,
)  # fmt: skip


def spec_with(*configuration: Any) -> Spec:
    """The shipped rules with configuration modules."""
    from support.shared import SUPERVISOR

    return tm.load([SUPERVISOR], list(configuration))
