"""What a vehicle can do, and whether a generated motion stays within it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios.generate.knots import linear
from trackmarshal.scenarios.generate.motion import State
from trackmarshal.scenarios.generate.road import Road
from trackmarshal.scenarios.recording import Columns

#: Roundings of the generated numbers are no violations.
TOLERANCE = 1e-6
GRAVITY = 9.81


@dataclass(frozen=True, slots=True)
class Vehicle:
    """length, width, turn_radius in m; brake (largest deceleration) and grip (of the tyres, in every direction) in m/s^2.

    drive: rows of speed m/s and largest acceleration at the wheels m/s^2, linear between them, constant beyond their ends. drag: deceleration by
    drag over the square of the speed, 1/m. own_params, own_tables: what a recording overrides, in the declared units, in place of what the
    shipped specs' vehicles are made of. spec: path of the spec that it is read from, relative to the declaration; empty: of none.
    """

    length: float
    width: float
    turn_radius: float
    brake: float
    grip: float
    drive: list[list[float]]
    own_params: dict[str, float] | None = None
    own_tables: dict[str, list[list[float]]] | None = None
    drag: float = 0.0
    spec: str = ""

    @property
    def stopping(self) -> float:
        """What it surely brakes with on a straight road, m/s^2: what brakes and tyres both do. The help of drag is left out."""
        return min(self.brake, self.grip)

    @property
    def params(self) -> dict[str, float]:
        """What a recording of this vehicle overrides in the parameters of the shipped specs' vehicles.

        Its limits hold as they are: no share of the drive beyond the table's, no drag.
        """
        if self.own_params is not None:
            return self.own_params
        return {
            "length": self.length,
            "width": self.width,
            "R_min": self.turn_radius,
            "b_max": self.brake,
            "mu": self.grip / GRAVITY,
            "g": GRAVITY,
            "drag": 0.0,
            "drive_factor": 1.0,
        }

    @property
    def tables(self) -> dict[str, list[list[float]]]:
        """What it overrides in their tables."""
        return {"ax_max": self.drive} if self.own_tables is None else self.own_tables

    @property
    def in_si(self) -> set[tuple[str, str]]:
        """Of these, what is in SI, and not in the units that a spec declares: (`params` or `tables`, name)."""
        params = {("params", name) for name in self.params} if self.own_params is None else set()
        return params | ({("tables", name) for name in self.tables} if self.own_tables is None else set())

    def extents(self, tilt: float) -> tuple[float, float]:
        """Half the extents along and across the road of the rectangle that is turned by `tilt`, m."""
        cos, sin = abs(math.cos(tilt)), abs(math.sin(tilt))
        return (self.length * cos + self.width * sin) / 2.0, (self.length * sin + self.width * cos) / 2.0

    def demands(self, v: float, a: float, kappa: float) -> tuple[tuple[str, float, float], ...]:
        """What one sample asks of the vehicle, and what the vehicle can do: friction, turn radius, drive and brakes.

        Tyres and drive also push against drag, so theirs count with it.
        """
        pushed = a + self.drag * v * v
        return (
            ("total acceleration", math.hypot(pushed, v * v * kappa), self.grip),
            ("curvature", abs(kappa), 1.0 / self.turn_radius),
            ("acceleration", pushed, linear(self.drive, v)),
            ("deceleration", -a, self.brake),
        )

    def check(self, who: str, v: float, a: float, kappa: float) -> None:
        """Raises D152 where one sample asks for more than the vehicle can do."""
        for what, value, limit in self.demands(v, a, kappa):
            if value > limit + TOLERANCE:
                message = f"{who}: {what} {value:.3f} beyond the vehicle's {limit:.3f} at {v:.1f} m/s"
                raise TrackmarshalError("D152", message, help="drive slower or smoother")

    def check_plan(self, who: str, plan: Columns) -> None:
        """All samples of a trajectory; raises D152."""
        for v, a, kappa in zip(plan["v"], plan["a"], plan["kappa"]):
            self.check(who, v, a, kappa)

    def check_state(self, who: str, state: State, road: Road) -> None:
        """One state of a motion, and that the whole vehicle is on the road; raises D152."""
        self.check(who, state.v, state.a, state.kappa)
        _, side = self.extents(state.tilt)
        right, left = road.edges(state.s)
        if state.d - side < right or state.d + side > left:
            message = f"{who}: leaves the road at s = {state.s:.1f} m, d = {state.d:.2f} m"
            raise TrackmarshalError("D152", message, help="keep |d| smaller, or widen the road")
