"""The detection envelope of the paper's section V-D for two vehicles in one lane, in closed form: what ground truth is held against."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Envelope:
    """Earliest and latest time, s; None for never."""

    earliest: float | None
    latest: float | None

    @property
    def inverted(self) -> bool:
        """The latest time lies before the earliest."""
        return self.earliest is not None and self.latest is not None and self.latest < self.earliest

    def truth(self, t: float) -> bool | None:
        """What the verdict at time t has to be: True safe, False unsafe, None free."""
        if self.latest is not None and t >= self.latest:
            return False
        if self.earliest is not None and t >= self.earliest and not self.inverted:
            return None
        return True


def same_lane(gap: float, v: float, u: float, b: float) -> Envelope:
    """The envelope of two vehicles at constant speeds in one lane, in closed form.

    gap: bumper to bumper at t = 0, m. v: speed of the car under test, m/s. u: the other's along the lane, negative
    where it comes towards it. b: maximum deceleration, m/s^2. Times may lie before 0. Raises ValueError for numbers
    that mean nothing (b <= 0, v < 0, not finite).
    """
    if not all(map(math.isfinite, (gap, v, u, b))) or b <= 0.0 or v < 0.0:
        raise ValueError(f"no envelope for gap={gap}, v={v}, u={u}, b={b}")
    braking = v * v / (2.0 * b)
    closing = v - u
    if closing <= 0.0:  # it drives away: what is not inside now never was later
        return Envelope(0.0 if gap <= braking else None, None)
    critical = closing * closing / (2.0 * b) if u >= 0.0 else braking - u * v / b
    return Envelope((gap - braking) / closing, (gap - critical) / closing)
