"""The layer below: follows what the Supervisor decided, and knows what to do where nothing was decided, or nothing can be driven.

- `drive` and `previous_emergency`: the trajectory of the decision.
- No decision by the last one's `valid_until`: that one's fallback.
- `no_safe_trajectory`: the last fallback that it was given, which is where the road was last known to be free: on its path, braking.
- No pose that it believes for `BLIND`: the last fallback from before; what is planned from such poses is not followed.
- Never anything to fall back to: it brakes, wheels straight.

Where the car is, it takes from the localisation as long as that agrees with its own wheels and yaw rate; a pose that jumps is not
believed, and it reckons on by itself. Steering after Kapania and Gerdes, Design of a feedback-feedforward steering controller for
accurate path tracking and stability at the limits of handling, Vehicle System Dynamics 53 (2015): feedforward of the path's
curvature, feedback of the offset of a point ahead, with the sideslip of steady cornering taken off the heading error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from closed_loop.car import Build

Columns = dict[str, list[float]]

#: How far a pose may be from where the car reckons to be, m, rad; for how long it drives on what is planned without believing any, s.
BELIEVED, TURNED, BLIND = 1.0, 0.2, 0.3
#: How much of the difference to a pose that is believed is made good every `period`.
BELIEF = 0.1
AHEAD = 8.0
STIFF = 0.10
SPEED = 10.0
#: The most that is asked of the tyres, m/s^2.
HARDEST = 14.0
HOLD = -4.0


@dataclass(frozen=True)
class Sensed:
    """A pose as the localisation gives it; any of it may be NaN."""

    x: float
    y: float
    heading: float
    v: float
    age: float = 0.0


@dataclass(frozen=True)
class Given:
    """A decision as it reaches this layer. driven, fallback: columns, or None."""

    state: str
    driven: Columns | None
    fallback: Columns | None
    valid_until: float


class Executing:
    """Follows decisions. `act` is called every `period` s."""

    def __init__(self, build: Build, x: float, y: float, heading: float) -> None:
        self.build = build
        self.x, self.y, self.heading = x, y, heading
        self.given: Given | None = None
        self.path: Columns | None = None
        self.doing = "hold"
        self._distrusted = 0.0
        self._last_fallback: Columns | None = None
        self._segment = 0

    def take(self, given: Given) -> None:
        """A decision has come."""
        self.given = given
        if given.fallback is not None and not self._distrusted:
            self._last_fallback = given.fallback

    def locate(self, sensed: Sensed, speed: float, drift: float, yaw: float, seconds: float) -> None:
        """Where the car is: by its own wheels and gyroscope, put right by the localisation where that agrees.

        speed, drift: along and across the car, m/s; yaw: rad/s; seconds since the last time.
        """
        middle = self.heading + yaw * seconds / 2
        self.x += seconds * (speed * math.cos(middle) - drift * math.sin(middle))
        self.y += seconds * (speed * math.sin(middle) + drift * math.cos(middle))
        self.heading += yaw * seconds
        apart = math.hypot(sensed.x - self.x, sensed.y - self.y)
        turned = (
            abs(math.remainder(sensed.heading - self.heading, math.tau))
            if math.isfinite(sensed.heading)
            else math.inf
        )
        if apart <= BELIEVED and turned <= TURNED:  # NaN is not believed
            self.x += BELIEF * (sensed.x - self.x)
            self.y += BELIEF * (sensed.y - self.y)
            self.heading += BELIEF * math.remainder(sensed.heading - self.heading, math.tau)
            self._distrusted = 0.0
        else:
            self._distrusted += seconds

    def act(self, now: float, speed: float) -> tuple[float, float]:
        """Steering, rad, and pull, m/s^2."""
        wanted, self.doing = self._wanted(now)
        if wanted is not self.path:
            self.path, self._segment = wanted, 0
        if wanted is None:
            return 0.0, -HARDEST
        return self._follow(wanted, speed)

    def _wanted(self, now: float) -> tuple[Columns | None, str]:
        given = self.given
        if given is None:
            return None, "hold"
        if self._distrusted > BLIND:
            return self._last_fallback, "lost"
        if now > given.valid_until:
            return self._last_fallback, "fallback"
        if given.driven is not None:
            return given.driven, given.state
        return self._last_fallback, "last_fallback"

    def _follow(self, path: Columns, speed: float) -> tuple[float, float]:
        station, offset = self._project(path)
        heading, kappa, v, a = (_at(path, name, station) for name in ("heading", "kappa", "v", "a"))
        b = self.build
        if station >= path["s"][-1] or (v < 0.2 and a <= 0.0):
            return math.atan(b.base * kappa), HOLD if speed < 1.0 else -HARDEST
        # feedforward where the steering will be once it has moved
        soon = _at(path, "kappa", station + speed * b.steer_lag * 2)
        slip = _slip(b, speed**2 * kappa)
        sideslip = b.rear * kappa - slip[1]
        error = math.remainder(self.heading + sideslip - heading, math.tau)
        steering = (
            math.atan(b.base * soon)
            + slip[0]
            - slip[1]
            - STIFF
            * min(1.0, 8.0 / max(speed, 1.0))
            * (min(max(offset, -1.5), 1.5) + AHEAD * math.sin(error))
        )
        lag = b.brake_lag if a < 0.0 else b.drive_lag
        due = _at(path, "a", station + speed * lag)
        pull = due + SPEED * (v - speed) + b.drag * speed**2 / b.mass
        return steering, min(max(pull, -HARDEST), 6.0)

    def _project(self, path: Columns) -> tuple[float, float]:
        """Station of the nearest place, and the offset to the left of it; the search goes on from the last one."""
        xs, ys = path["x"], path["y"]
        best, found = math.inf, (0.0, 0.0)
        for i in range(max(self._segment - 2, 0), len(xs) - 1):
            dx, dy = xs[i + 1] - xs[i], ys[i + 1] - ys[i]
            square = dx * dx + dy * dy
            if square == 0.0:
                continue
            share = ((self.x - xs[i]) * dx + (self.y - ys[i]) * dy) / square
            held = min(max(share, 0.0), 1.0)
            ox, oy = self.x - xs[i] - held * dx, self.y - ys[i] - held * dy
            apart = math.hypot(ox, oy)
            if apart < best:
                way = path["s"][i + 1] - path["s"][i]
                best, found = apart, (path["s"][i] + held * way, (dx * oy - dy * ox) / math.sqrt(square))
                self._segment = i
            elif apart > best + 20.0:
                break
        return found


def _slip(b: Build, lateral: float) -> tuple[float, float]:
    """Slip angles of the axles in steady cornering, rad; lateral in m/s^2. Loads as at rest."""
    found = []
    for stiffness, share in zip(b.stiffness, (b.rear / b.base, b.front / b.base)):
        grip = b.mu * b.mass * 9.81 * share
        stiff = stiffness * math.sin(2.0 * math.atan(b.mass * 9.81 * share / b.stiffest)) / (b.shape * grip)
        used = min(max(b.mass * share * lateral / grip, -0.95), 0.95)
        found.append(math.tan(math.asin(used) / b.shape) / stiff)
    return found[0], found[1]


def _at(path: Columns, name: str, station: float) -> float:
    s, column = path["s"], path[name]
    if station <= s[0]:
        return column[0]
    for i in range(len(s) - 1):
        if station <= s[i + 1]:
            way = s[i + 1] - s[i]
            share = (station - s[i]) / way if way > 0.0 else 1.0
            if name == "heading":
                return column[i] + share * math.remainder(column[i + 1] - column[i], math.tau)
            if name == "v":
                return math.sqrt(max(column[i] ** 2 + share * (column[i + 1] ** 2 - column[i] ** 2), 0.0))
            if name == "a":  # constant between samples, as the planner means it
                return column[i]
            return column[i] + share * (column[i + 1] - column[i])
    return column[-1]
