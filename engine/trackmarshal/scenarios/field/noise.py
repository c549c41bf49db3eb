"""How noisy a log is, from its own statistics: what consecutive samples differ by that no motion explains."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from trackmarshal.scenarios.field.log import Log

Floats = NDArray[np.float64]

#: Differences over this time tell how fast motion changes; over a single sample, how noisy it is. s
_LONG = 1.0
#: Below this speed, in m/s, a curvature is not told from yaw rate and speed.
MOVING = 3.0


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations of sensors (along and across the heading, m; heading, rad; speed, m/s; yaw rate, rad/s), and how fast the motion
    itself changes: `jerk`, of acceleration, m/s^2 over the root of a second, and `sharpness`, of curvature, 1/m over the root of a second."""

    along: float
    across: float
    heading: float
    speed: float
    yaw_rate: float
    jerk: float
    lateral_jerk: float

    @property
    def place(self) -> float:
        """Of a position, in any direction, m: a jump of the localisation does not know which way the car points."""
        return max(self.along, self.across)

    def named(self) -> dict[str, float]:
        """By name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


def estimate(log: Log) -> Noise | None:
    """The noise of a log while the car moves; None where it does so for less than ten seconds, or not for seconds on end.

    Of white noise, the mean square of successive differences is twice the variance (von Neumann, Kent, Bellinson, Hart: The mean square
    successive difference, Annals of Mathematical Statistics 12(2), 1941), beside what the motion itself changes from sample to sample. The known part
    of that (the speed for the position, the yaw rate for the heading) is taken off; the rest counts as noise, so noise is never taken as too
    small. Jumps are in the mean square as they are. How fast the motion changes follows from the same over a second, less the noise.
    """
    dt = np.diff(log.t)
    moving = (np.abs(log.v[1:]) > MOVING) & (np.abs(log.v[:-1]) > MOVING)
    if dt[moving].sum() < 10 * _LONG:
        return None
    heading = np.unwrap(log.heading)
    middle = 0.5 * (heading[1:] + heading[:-1])
    dx, dy = np.diff(log.x), np.diff(log.y)
    mean_v = 0.5 * (log.v[1:] + log.v[:-1])
    along = dx * np.cos(middle) + dy * np.sin(middle) - mean_v * dt
    across = -dx * np.sin(middle) + dy * np.cos(middle)
    turned = np.diff(heading)
    rate = log.yaw_rate if log.yaw_rate is not None else np.gradient(heading, log.t)
    if log.yaw_rate is not None:
        turned = turned - 0.5 * (rate[1:] + rate[:-1]) * dt
    speed = _deviation(np.diff(log.v)[moving], 2.0)
    heading_noise = _deviation(turned[moving], 2.0)
    place = _deviation(along[moving], 2.0), _deviation(across[moving], 2.0)
    # over a second: interpolated, since logs need not be uniform
    times = np.arange(log.t[0], log.t[-1], float(np.median(dt)))
    lag = max(1, round(_LONG / float(np.median(dt))))
    v = np.interp(times, log.t, log.v)
    lateral = v * np.interp(times, log.t, rate)
    fast = np.abs(v) > MOVING
    thrice = fast[2 * lag :] & fast[lag:-lag] & fast[: -2 * lag]
    twice = _twice(v, lag)[thrice]
    # the second difference of a doubly integrated white noise over T has the variance 2/3 q T^3; of noise, 6 r
    # What adds up over a second is no noise of positions but an offset of the speed, and of the heading.
    starts = np.arange(0, len(along) - lag, lag)
    whole = [slice(i, i + lag) for i in starts if moving[i : i + lag].all()]
    if not whole or not len(twice):
        return None
    offsets = np.array([along[part].sum() / dt[part].sum() for part in whole])
    speed_all = np.hypot(speed, _offset(offsets, place[0]))
    asides = np.array([across[part].sum() / (mean_v[part] * dt[part]).sum() for part in whole])
    heading_all = np.hypot(heading_noise, _offset(asides, place[1] / float(np.mean(np.abs(mean_v[moving])))))
    jerk = max(float(np.mean(twice**2)) - 6.0 * speed**2, 0.0) * 1.5 / _LONG**3
    if log.yaw_rate is None:
        # From sample to sample, a heading turns mostly by its noise: in that, how fast a gentle bend begins would be lost.
        ahead = v[lag:-lag][thrice]
        change = float(np.mean((ahead * _twice(np.interp(times, log.t, heading), lag)[thrice]) ** 2))
        noise_of_turns = 6.0 * float(np.mean(ahead**2)) * heading_noise**2
        lateral_jerk = max(change - noise_of_turns, 0.0) * 1.5 / _LONG**3
    else:
        both = fast[lag:] & fast[:-lag]
        noise_of_lateral = float(np.mean(np.diff(lateral)[fast[1:] & fast[:-1]] ** 2))
        change = float(np.mean((lateral[lag:] - lateral[:-lag])[both] ** 2))
        lateral_jerk = max(change - noise_of_lateral, 0.0) / _LONG
    turns = np.array([turned[part].sum() / dt[part].sum() for part in whole])
    yaw_rate = float(np.hypot(_deviation(np.diff(rate)[moving], 2.0), _offset(turns, heading_noise)))
    return Noise(
        *place, float(heading_all), float(speed_all), yaw_rate, float(np.sqrt(jerk)), float(np.sqrt(lateral_jerk))
    )  # fmt: skip


def _twice(column: Floats, lag: int) -> Floats:
    """Second differences over so many samples."""
    return column[2 * lag :] - 2.0 * column[lag:-lag] + column[: -2 * lag]


def _deviation(differences: Floats, share: float) -> float:
    """The standard deviation of noise of whose samples these are combined; never 0, which would be certainty."""
    return float(np.sqrt(max(float(np.mean(differences**2)) / share, 1e-12)))


def _offset(means: Floats, place: float) -> float:
    """The root mean square of what a second adds up to, less what the noise of the position at both of its ends adds."""
    return float(np.sqrt(max(float(np.mean(means**2)) - 2.0 * (place / _LONG) ** 2, 0.0)))
