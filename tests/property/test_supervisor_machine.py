"""Whatever happens in whatever order: the Supervisor never drives what it must not, and forgets nothing.

The machine below keeps a model of its own, of facts alone: which cycles were safe, where the car was, what time it is.
"""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from support.cycles import BRAKING, PERIOD, SPEED, cycle, mutate
from support.supervised import made
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.machine import (
    DRIVE,
    NEXT,
    NO_EMERGENCY_YET,
    NO_SAFE_TRAJECTORY,
    PREVIOUS_EMERGENCY,
    STATES,
)

pytestmark = pytest.mark.verifies("S-1-B-1", "S-1-B-6")

#: How long an emergency trajectory of the model's cycles lasts.
STOP = SPEED / BRAKING


class Driving(RuleBasedStateMachine):
    """A car that follows the decisions, or does not."""

    @initialize(blind=st.sampled_from([0.0, 0.3, 0.5, math.inf]))
    def start(self, blind: float) -> None:
        self.limits = Limits(blind=blind)
        self.supervisor, self.oracle, self.clock = made(self.limits)
        self.number = 0
        self.decision: Decision | None = None
        #: Number of the cycle whose emergency trajectory counts, and where it starts; None: none was safe, or it is lost.
        self.stored: tuple[int, float] | None = None
        self.seen = -math.inf
        self.ever = False
        self.position, self.speed = 0.0, SPEED
        self.history: list[tuple[Any, list[Any]]] = []

    def _step(self, given_cycle: Cycle | None, ticks: list[float] | None = None) -> Decision:
        self.clock.now = self.number * PERIOD
        self.clock.ticks = list(ticks or ())
        self.history.append((given_cycle, [self.clock.now, *self.clock.ticks]))
        self.decision = self.supervisor.step(given_cycle)
        self.number += 1
        return self.decision

    def _model(self, safe: bool, pose: tuple[float, float] | None) -> str:
        """What has to be driven; pose: x and y of the car, where known."""
        now = (self.number - 1) * PERIOD
        if safe:
            self.stored, self.seen, self.ever = (self.number - 1, self.position), now, True
            return DRIVE
        if self.stored is None:
            return NO_SAFE_TRAJECTORY if self.ever else NO_EMERGENCY_YET
        number, x = self.stored
        since = now - number * PERIOD
        good = now <= number * PERIOD + STOP  # to the bit: what is a rounding later is over
        if good and pose is not None:
            planned = x + SPEED * since - BRAKING * since**2 / 2
            # Between samples the model is exact and the Supervisor straight: a centimetre apart at most.
            first = max(x, planned - self.limits.apart)
            last = min(x + SPEED * STOP / 2, planned + self.limits.apart)
            nearest = min(max(pose[0], first), last)
            good = math.hypot(pose[0] - nearest, pose[1]) <= self.limits.beside
            fast = math.sqrt(max(0.0, SPEED**2 - 2 * BRAKING * (nearest - x)))
            good = good and self.speed <= fast + self.limits.overspeed
            self.seen = now
        good = good and now - self.seen <= self.limits.blind
        if not good:
            self.stored = None
            return NO_SAFE_TRAJECTORY
        return PREVIOUS_EMERGENCY

    def _follow(self, lapse: float = 0.0) -> None:
        """The car drives what was decided until the next cycle."""
        if self.decision is not None and self.decision.driven is not None:
            plan = self.decision.driven
            now = min(self.number * PERIOD, plan.end)
            self.position, self.speed = (
                float(np.interp(now, plan.due, plan.columns.column(name))) for name in ("x", "v")
            )
        self.position += lapse

    def _next(self) -> Cycle:
        return cycle(self.number, at=self.position, v=self.speed)

    @rule()
    def safe_cycle(self) -> None:
        self._follow()
        self.oracle.unsafe = set()
        in_order = self._in_order()
        decision = self._step(self._next())
        assert decision.state == self._model(in_order, (self.position, 0.0))

    @rule(candidate=st.sampled_from(["driving", "emergency"]), which=st.integers(0, 1000))
    def unsafe_cycle(self, candidate: str, which: int) -> None:
        self._follow()
        rules = self.oracle.rules
        self.oracle.unsafe = {(candidate, rules[which % len(rules)].name)}
        decision = self._step(self._next())
        assert decision.state == self._model(False, (self.position, 0.0))

    @rule()
    def missing_cycle(self) -> None:
        self._follow()
        decision = self._step(None)
        assert decision.state == self._model(False, None)

    @rule(more=st.sampled_from([-3.0, 3.0, 8.0]))
    def car_is_faster(self, more: float) -> None:
        """The car is where it should be, at another speed, and the cycle unsafe."""
        self._follow()
        self.speed += more
        self.oracle.unsafe = {("driving", "friction")}
        decision = self._step(self._next())
        assert decision.state == self._model(False, (self.position, 0.0))

    @rule(lapse=st.sampled_from([-50.0, -7.0, -3.0, 3.0, 7.0, 50.0]))
    def car_leaves(self, lapse: float) -> None:
        """The car is elsewhere, and the cycle unsafe."""
        self._follow(lapse)
        self.oracle.unsafe = {("driving", "friction")}
        decision = self._step(self._next())
        assert decision.state == self._model(False, (self.position, 0.0))

    @rule(seed=st.integers(0, 2**32))
    def broken_cycle(self, seed: int) -> None:
        """The contract is broken somewhere; what is known of the pose is the Supervisor's to say."""
        self._follow()
        self.oracle.unsafe = set()
        asked = self.oracle.asked
        rng = random.Random(seed)
        bad, expected = mutate(rng, self._next())
        while expected.signal == "cycle":  # another number or stamp may be right after what came before
            bad, expected = mutate(rng, self._next())
        decision = self._step(bad)
        assert decision.faults
        assert decision.safe is False
        assert self.oracle.asked == asked
        known = self._model(False, (self.position, 0.0) if self._pose_known(decision) else None)
        assert decision.state == known

    @rule(late=st.floats(0.0501, 10.0))
    def late_verdict(self, late: float) -> None:
        self._follow()
        self.oracle.unsafe = set()
        now = self.number * PERIOD
        decision = self._step(self._next(), [now, now + late])
        assert decision.safe is False
        assert decision.state == self._model(False, (self.position, 0.0))
        self.supervisor._last = now  # the model's time goes on from here

    def _in_order(self) -> bool:
        """Whether a flawless cycle now continues the last one that the door took for in order."""
        door = self.supervisor.door
        number, stamp = door._number, door._stamp
        if number is None or stamp is None:
            return True
        return (
            number == self.number - 1
            and PERIOD * 0.5 < self.number * PERIOD - stamp <= self.limits.longest_gap
        )

    @staticmethod
    def _pose_known(decision: Decision) -> bool:
        """A stamp that is late or stale is in order all the same."""
        return not any(
            f.signal in ("ego", "signals")
            or ((f.signal, f.field) == ("cycle", "t") and name_of(f) not in ("late", "stale"))
            for f in decision.faults
        )

    @invariant()
    def says_one_thing(self) -> None:
        decision = getattr(self, "decision", None)
        if decision is None:
            return
        assert decision.state in STATES
        assert decision.safe == (decision.state == DRIVE)
        assert decision.safe == (not decision.faults and not decision.violations)
        assert (decision.driven is not None) == (decision.state in (DRIVE, PREVIOUS_EMERGENCY))
        assert bool(decision.lost) == (decision.driven is None)
        assert bool(decision.reasons) != decision.safe
        if decision.driven is not None:
            assert decision.driven.candidate == ("driving" if decision.state == DRIVE else "emergency")
            assert decision.driven.due[0] <= decision.now <= decision.driven.end
            samples = decision.samples
            assert samples is not None
            assert all(len(column) for column in samples.values())

    def teardown(self) -> None:
        """The same inputs at the same times give the same decisions."""
        if self.decision is None or any(len(ticks) > 1 for _, ticks in self.history) or self.oracle.unsafe:
            return
        again, oracle, clock = made(self.limits)
        other, second, third = made(self.limits)
        for given_cycle, ticks in self.history:
            clock.now = third.now = ticks[0]
            oracle.unsafe = second.unsafe = set()
            a, b = again.step(given_cycle), other.step(given_cycle)
            assert (a.state, a.reasons, a.number, a.lost) == (b.state, b.reasons, b.number, b.lost)


TestDriving = Driving.TestCase
TestDriving.settings = settings(deadline=None, stateful_step_count=40)


@given(st.sampled_from(STATES), st.lists(st.sampled_from(["safe", "holds", "lost", "none"]), max_size=30))
def test_every_way_through_the_table(state: str, inputs: list[str]) -> None:
    """Only a safe cycle leads to driving, and what is lost comes back by a safe cycle alone."""
    stored = state in (DRIVE, PREVIOUS_EMERGENCY)
    for what in inputs:
        if (state, what) not in NEXT:
            assert what == "none" if stored else what in ("holds", "lost")
            continue
        state = NEXT[state, what]
        stored = what in ("safe", "holds")
        assert (state == DRIVE) == (what == "safe")
        assert (state in (DRIVE, PREVIOUS_EMERGENCY)) == stored
