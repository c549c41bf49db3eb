"""A car with tyres and actuators that lag: a dynamic single-track model.

Equations: plane motion of the single-track model after Rajamani, Vehicle Dynamics and Control, 2nd ed., Springer 2012, sections 2.3
and 4.1; lateral tyre forces by Pacejka's Magic Formula, Tire and Vehicle Dynamics, 3rd ed., Butterworth-Heinemann 2012, section 4.3.1,
D sin(C arctan(B alpha)), whose stiffness BCD grows less than the load does, c1 sin(2 arctan(Fz / c2)) (the same section), with the
rest of the friction circle where the tyre also pulls or brakes (section 3.2.3, friction ellipse);
load moves between the axles with the acceleration along the car (Rajamani, section 4.1.5). Below `SLOW` slip angles mean nothing:
the car then rolls as the kinematic single-track model has it (Rajamani, section 2.2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

G = 9.81
#: m/s
SLOW = 2.0


@dataclass(frozen=True)
class Build:
    """The car: SI units. Mass, drag and length are those of the car that the planner plans for (ltpl_car.spec).

    width is the body's: the rules' 2.8 m hold 0.4 m a side for what tracking and localisation miss. mu is what the tyres have, of which
    the rules allow 13 / 9.81 = 1.325: friction is underestimated, as assumption A-FRICTION demands. Axles, inertia, lags and stiffness
    are typical of a light race car, not measured.
    """

    mass: float = 1160.0
    inertia: float = 1400.0
    front: float = 1.35
    rear: float = 1.35
    height: float = 0.30
    length: float = 4.7
    width: float = 2.0
    drag: float = 0.854
    mu: float = 1.5
    #: Of the front and the rear axle, N/rad, where the load is `stiffest`, N; wider tyres at the back keep the car stable under braking.
    stiffness: tuple[float, float] = (150e3, 190e3)
    stiffest: float = 7500.0
    shape: float = 1.4
    steer_most: float = 0.40
    steer_rate: float = 0.7
    steer_lag: float = 0.04
    drive_lag: float = 0.08
    brake_lag: float = 0.05

    @property
    def base(self) -> float:
        """Between the axles, m."""
        return self.front + self.rear


@dataclass
class State:
    """x, y: middle of the car, m. heading rad, speeds along and across the car m/s, yaw rate rad/s; steering rad, pull m/s^2 as they are now."""

    x: float
    y: float
    heading: float
    along: float
    across: float = 0.0
    yaw: float = 0.0
    steering: float = 0.0
    pull: float = 0.0

    @property
    def v(self) -> float:
        """Speed, m/s."""
        return math.hypot(self.along, self.across)

    @property
    def standing(self) -> bool:
        """Whether it is at rest."""
        return self.along <= 0.0


class Car:
    """Drives by what is asked of it: a steering angle, rad, and a pull of the tyres along the car, m/s^2 (negative brakes)."""

    def __init__(self, build: Build, state: State, step: float = 0.0025) -> None:
        self.build, self.state, self.step = build, state, step

    def drive(self, steering: float, pull: float, seconds: float) -> None:
        """Drives on for some time."""
        for _ in range(round(seconds / self.step)):
            self._once(steering, pull)

    def _once(self, steering: float, pull: float) -> None:
        b, s, dt = self.build, self.state, self.step
        if s.along <= 0.0 and pull <= 0.0:  # brakes hold
            s.along = s.across = s.yaw = s.pull = 0.0
            return
        change = (min(max(steering, -b.steer_most), b.steer_most) - s.steering) / b.steer_lag
        s.steering += dt * min(max(change, -b.steer_rate), b.steer_rate)
        s.pull += dt * (pull - s.pull) / (b.drive_lag if pull > 0.0 else b.brake_lag)
        if s.along < SLOW:
            self._roll(dt)
            return
        at = (s.x, s.y, s.heading, s.along, s.across, s.yaw)
        k1 = self._rates(at)
        k2 = self._rates(_ahead(at, k1, dt / 2))
        k3 = self._rates(_ahead(at, k2, dt / 2))
        k4 = self._rates(_ahead(at, k3, dt))
        total = [(p + 2 * q + 2 * r + t) / 6 for p, q, r, t in zip(k1, k2, k3, k4)]
        s.x, s.y, s.heading, s.along, s.across, s.yaw = _ahead(at, total, dt)

    def _roll(self, dt: float) -> None:
        b, s = self.build, self.state
        s.along = max(s.along + dt * (s.pull - b.drag * s.along**2 / b.mass), 0.0)
        s.yaw = s.along * math.tan(s.steering) / b.base
        s.across = s.yaw * b.rear
        s.x += dt * (s.along * math.cos(s.heading) - s.across * math.sin(s.heading))
        s.y += dt * (s.along * math.sin(s.heading) + s.across * math.cos(s.heading))
        s.heading += dt * s.yaw

    def _rates(self, at: tuple[float, ...]) -> tuple[float, ...]:
        b, steering = self.build, self.state.steering
        _, _, heading, along, across, yaw = at
        along = max(along, SLOW / 2)  # a stage may fall below what slip angles are made for
        moved = b.mass * self.state.pull * b.height / b.base
        loads = (b.mass * G * b.rear / b.base - moved, b.mass * G * b.front / b.base + moved)
        slips = (
            steering - math.atan2(across + b.front * yaw, along),
            -math.atan2(across - b.rear * yaw, along),
        )
        lengthways, sideways = [], []
        for load, slip, stiffness in zip(loads, slips, b.stiffness):
            grip = b.mu * max(load, 0.0)
            # drive and brakes are shared out as the loads are, so both axles reach their limit together
            wanted = b.mass * self.state.pull * load / (b.mass * G)
            pull = min(max(wanted, -grip), grip)
            rest = math.sqrt(max(1.0 - (pull / grip) ** 2, 0.01)) if grip > 0.0 else 0.0
            lengthways.append(pull)
            stiff = stiffness * math.sin(2.0 * math.atan(load / b.stiffest)) / max(b.shape * grip, 1.0)
            sideways.append(rest * grip * math.sin(b.shape * math.atan(stiff * slip)))
        ahead = lengthways[0] * math.cos(steering) - sideways[0] * math.sin(steering) + lengthways[1]
        left = lengthways[0] * math.sin(steering) + sideways[0] * math.cos(steering)
        return (
            along * math.cos(heading) - across * math.sin(heading),
            along * math.sin(heading) + across * math.cos(heading),
            yaw,
            (ahead - b.drag * along**2) / b.mass + across * yaw,
            (left + sideways[1]) / b.mass - along * yaw,
            (b.front * left - b.rear * sideways[1]) / b.inertia,
        )


def _ahead(at: tuple[float, ...], rates: tuple[float, ...] | list[float], dt: float) -> tuple[float, ...]:
    return tuple(value + dt * rate for value, rate in zip(at, rates))
