"""What the planner offers in a cycle: mostly what is driven next, and something else where a mistake is declared."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios.generate.candidates import (
    Braking,
    Plan,
    Steps,
    braked,
    driving,
    emergency,
    path_curvature,
)
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.generate.motion import Motion, Move, Profile
from trackmarshal.scenarios.recording import CANDIDATES

#: A car that moves sideways faster than this, m/s, cannot begin another move.
STEADY = 1e-9


class Mistake(NamedTuple):
    """In the cycles from begin to end, s, the planner plans otherwise than is driven; times count from the cycle.

    With moves, it leaves the path that is driven: they begin at the car's place. Without, it keeps the path. With an
    acceleration (rows of s, m/s^2), it drives its own speeds; without, those that are driven. With a deceleration, m/s^2, its
    emergency trajectory brakes with at most that.
    """

    begin: float
    end: float
    acceleration: list[list[float]] | None
    moves: list[Move] | None
    deceleration: float | None
    item: Item

    def is_made(self, t: float, step: float) -> bool:
        """In the cycle at t; cycles are `step` apart, s."""
        slack = 1e-6 * step
        return self.begin - slack <= t <= self.end + slack


class _Offer(NamedTuple):
    """What the trajectories of the cycle at t are laid out by, however many samples are taken of them: a motion, from `begin` of its time on, the
    speeds of their own where they are not its, and how they brake; `steps` once that is known."""

    t: float
    motion: Motion
    begin: float
    own: Profile | None
    braking: Braking
    kappa: Callable[[float], float]
    steps: Steps | None = None


class Planner:
    """Driving and emergency trajectories along a motion, with mistakes; `step` is how far apart the cycles are, s."""

    def __init__(
        self, motion: Motion, horizon: float, braking: Braking, mistakes: list[Mistake], step: float
    ) -> None:
        self._motion = motion
        self._horizon = horizon
        self._braking = braking
        self._mistakes = mistakes
        self._step = step
        self._kappa = path_curvature(motion)
        #: Of the last cycle that was asked for: a cycle is laid out twice, as it is told and finer.
        self._offered: _Offer | None = None

    def mistake(self, t: float) -> Mistake | None:
        """The mistake that the planner makes in the cycle at t."""
        return next((m for m in self._mistakes if m.is_made(t, self._step)), None)

    def plans(self, t: float, points: int, emergency_points: int) -> dict[str, Plan]:
        """Both candidates of the cycle at t; raises D152 for what cannot be laid out at all."""
        if self._offered is None or self._offered.t != t:
            self._offered = self._offer(t)
        made = self._offered
        braking = made.braking._replace(points=emergency_points)
        drive = driving(made.motion, made.begin, points, self._horizon, made.own)
        if made.steps is None:
            made = self._offered = made._replace(steps=braked(made.motion, made.begin, braking, made.kappa))
        stop = emergency(made.motion, made.begin, braking, made.kappa, made.steps)
        return dict(zip(CANDIDATES, (drive, stop)))

    def _offer(self, t: float) -> _Offer:
        """What is offered in the cycle at t, with the mistake that is made in it."""
        mistake = self.mistake(t)
        braking = self._braking
        if mistake is not None and mistake.deceleration is not None:
            braking = braking._replace(deceleration=mistake.deceleration)
        if mistake is None:
            return _Offer(t, self._motion, t, None, braking, self._kappa)
        if mistake.moves is None:
            return _Offer(t, self._motion, t, self._profile(mistake, t), braking, self._kappa)
        motion = self._astray(mistake, mistake.moves, t)
        return _Offer(t, motion, 0.0, None, braking, path_curvature(motion))

    def _profile(self, mistake: Mistake, t: float) -> Profile:
        """The speeds that are planned at t."""
        v = self._motion.profile.at(t)[1]
        if mistake.acceleration is not None:
            return Profile(v, mistake.acceleration)
        return self._motion.profile.after(t)

    def _astray(self, mistake: Mistake, moves: list[Move], t: float) -> Motion:
        """The motion that is planned at t on a path of its own, long enough to brake on."""
        state = self._motion.at(t)
        if abs(state.d_rate) > STEADY:
            message = f"the planner cannot leave the path at t = {t:.2f} s, in the middle of a move"
            raise TrackmarshalError("D152", message, help="begin the mistake before the move or after it")
        stopping = 2.0 * state.v / self._braking.deceleration
        end = max(self._horizon, math.ceil(stopping))
        return Motion(self._motion.road, self._profile(mistake, t), moves, (state.s, state.d), end)
