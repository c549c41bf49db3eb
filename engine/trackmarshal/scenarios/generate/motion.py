"""Motions on a road: a declared speed profile and lateral moves, turned into poses that fit together exactly.

Speed and acceleration are those of the vehicle along its own path. Its acceleration is linear between the declared
knots, so speed and distance are polynomials; only the place along the road is integrated (Runge-Kutta, fourth order).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from itertools import pairwise
from typing import NamedTuple

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios.generate.knots import linear
from trackmarshal.scenarios.generate.road import Line

#: Step of the integration along the road, s.
STEP = 0.02
#: Motions are forward, and never slower than this, m/s.
SLOWEST = 0.5


class Profile:
    """Speed over time from v0 at t = 0: acceleration linear between knots [t, a], constant beyond their ends."""

    def __init__(self, v0: float, knots: list[list[float]]) -> None:
        inner = [(t, a) for t, a in knots if t > 0.0]
        first = linear(knots, 0.0)
        self._knots = [(0.0, first), *inner]
        self._speeds, self._ways = [v0], [0.0]
        for (t0, a0), (t1, a1) in pairwise(self._knots):
            h = t1 - t0
            self._ways.append(self._ways[-1] + h * (self._speeds[-1] + h * (2.0 * a0 + a1) / 6.0))
            self._speeds.append(self._speeds[-1] + h * (a0 + a1) / 2.0)
        self._times = [t for t, _ in self._knots]

    def at(self, t: float) -> tuple[float, float, float]:
        """Acceleration m/s^2, speed m/s and distance driven m at time t >= 0."""
        i = bisect_right(self._times, t) - 1
        t0, a0 = self._knots[i]
        jerk = 0.0
        if i + 1 < len(self._knots):
            t1, a1 = self._knots[i + 1]
            jerk = (a1 - a0) / (t1 - t0)
        h = t - t0
        a = a0 + jerk * h
        v = self._speeds[i] + h * (a0 + jerk * h / 2.0)
        way = self._ways[i] + h * (self._speeds[i] + h * (a0 / 2.0 + jerk * h / 6.0))
        return a, v, way

    def after(self, t: float) -> Profile:
        """What is left of the profile from time t on, as one that begins there."""
        return Profile(self.at(t)[1], [[time - t, a] for time, a in self._knots])

    def time_at(self, way: float, after: float, before: float) -> float:
        """The time in [after, before] at which the distance is reached: Newton, held in by bisection."""
        low, high = after, before
        t = low
        for _ in range(60):
            _, v, there = self.at(t)
            off = way - there
            if off > 0.0:
                low = t
            else:
                high = t
            step = t + off / v
            if abs(step - t) < 1e-12:
                return min(max(step, after), before)
            t = step if low < step < high else 0.5 * (low + high)
        return t


class Move(NamedTuple):
    """A lateral move from begin to end, s, to the offset `to`, m; smooth in speed and acceleration at both ends."""

    begin: float
    end: float
    to: float


class State(NamedTuple):
    """Where a vehicle is and what it does; `tilt` is its heading against the road's, rad."""

    x: float
    y: float
    heading: float
    kappa: float
    v: float
    a: float
    s: float
    d: float
    s_rate: float
    d_rate: float
    tilt: float


class Motion:
    """A vehicle's motion on a road from t = 0 to `end`. Raises D152 where it is none (standing, off the reference)."""

    def __init__(
        self, road: Line, profile: Profile, moves: list[Move], start: tuple[float, float], end: float
    ) -> None:
        self.road = road
        self.profile = profile
        self.moves = moves
        self.end = end
        self._d0 = start[1]
        self._known: dict[float, State] = {}
        #: At each step, the place along the road, and its rate of change.
        self._s, self._rates = [start[0]], list[float]()
        for i in range(math.ceil(end / STEP) + 1):
            t, s = i * STEP, self._s[-1]
            self._rates.append(self._rate(s, t, self._forward(t)))
            self._s.append(self._advance(i, STEP))

    @property
    def reach(self) -> float:
        """Distance driven until `end`, m."""
        return self.profile.at(self.end)[2]

    def _lateral(self, t: float) -> tuple[float, float, float]:
        """Offset d and its first two derivatives: a quintic from rest to rest for each move."""
        d = self._d0
        for move in self.moves:
            if t >= move.end:
                d = move.to
            elif t > move.begin:
                span = move.end - move.begin
                r = (t - move.begin) / span
                by = move.to - d
                return (
                    d + by * r**3 * (10.0 - 15.0 * r + 6.0 * r * r),
                    by / span * 30.0 * r * r * (1.0 - r) ** 2,
                    by / span**2 * 60.0 * r * (1.0 - r) * (1.0 - 2.0 * r),
                )
        return d, 0.0, 0.0

    def _forward(self, t: float) -> tuple[float, float]:
        """Speed along the road's direction, and offset, at time t."""
        _, v, _ = self.profile.at(t)
        d, d_rate, _ = self._lateral(t)
        if v < SLOWEST or abs(d_rate) >= v:
            message = f"the speed is {v:.2f} m/s at t = {t:.2f} s, {abs(d_rate):.2f} m/s of it sideways"
            raise TrackmarshalError("D152", message, help=f"keep it above {SLOWEST} m/s and forward")
        return math.sqrt(v * v - d_rate * d_rate), d

    def _rate(self, s: float, t: float, forward: tuple[float, float]) -> float:
        """ds/dt at a place s along the road, of what goes forward so at time t."""
        speed, d = forward
        along = 1.0 - d * self.road.curvature(s)
        if along <= 0.0:
            message = f"at t = {t:.2f} s the vehicle is beyond the centre of the bend"
            raise TrackmarshalError("D152", message, help="keep it on the road")
        return speed / along

    def _advance(self, i: int, h: float) -> float:
        """The place along the road a time h behind step i."""
        t, s, k1 = i * STEP, self._s[i], self._rates[i]
        half, whole = t + h / 2.0, t + h
        forward = self._forward(half)
        k2 = self._rate(s + h / 2.0 * k1, half, forward)
        k3 = self._rate(s + h / 2.0 * k2, half, forward)
        k4 = self._rate(s + h * k3, whole, self._forward(whole))
        return s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    def at(self, t: float) -> State:
        """The state at time t in [0, end]: trajectories of cycles that follow each other ask for most times again."""
        found = self._known.get(t)
        if found is None:
            found = self._known[t] = self._at(t)
        return found

    def _at(self, t: float) -> State:
        i = min(int(t / STEP), len(self._s) - 2)
        s = self._advance(i, t - i * STEP)
        a, v, _ = self.profile.at(t)
        d, d_rate, d_second = self._lateral(t)
        x, y, direction = self.road.pose(s)
        kappa = self.road.curvature(s)
        s_rate = self._rate(s, t, self._forward(t))
        # Velocity along and across the road, and their derivatives in the frame that turns with the road.
        along = math.sqrt(v * v - d_rate * d_rate)
        along_second = (v * a - d_rate * d_second) / along - d_rate * kappa * s_rate
        across_second = d_second + along * kappa * s_rate
        tilt = math.atan2(d_rate, along)
        return State(
            x - d * math.sin(direction),
            y + d * math.cos(direction),
            direction + tilt,
            (along * across_second - d_rate * along_second) / v**3,
            v,
            a,
            s,
            d,
            s_rate,
            d_rate,
            tilt,
        )
