"""What follows from other columns: arc length, time, direction and curvature of a path, acceleration."""

from __future__ import annotations

import math
from itertools import pairwise

from trackmarshal.errors import TrackmarshalError
from trackmarshal.trajectories.columns import Lists

#: At or below this speed, in m/s, a sample stands still. Recordings write exact zeros.
REST_SPEED = 1e-6
#: Time from one sample to the next while standing still, in s: speeds and distances say nothing about it there.
REST_STEP = 0.1


def arc_length(x: list[float], y: list[float]) -> list[float]:
    """Cumulative length of the polygon through the samples, m, from 0."""
    s = [0.0]
    for i in range(len(x) - 1):
        s.append(s[i] + math.hypot(x[i + 1] - x[i], y[i + 1] - y[i]))
    return s


def time_along(s: list[float], v: list[float]) -> list[float]:
    """Times in s, from 0, at constant acceleration between samples: dt = 2 ds / (|v0| + |v1|).

    REST_STEP where both samples stand still. Two samples in one place with speed get one time: what is wrong there
    is left for the input contract to report.
    """
    t = [0.0]
    for i in range(len(s) - 1):
        speed = abs(v[i]) + abs(v[i + 1])
        t.append(t[i] + (REST_STEP if speed <= 2.0 * REST_SPEED else 2.0 * (s[i + 1] - s[i]) / speed))
    return t


def acceleration_along(s: list[float], v: list[float]) -> list[float]:
    """Accelerations, m/s^2, each of the step that follows its sample: (v1^2 - v0^2) / (2 ds); 0 at the last, and where nothing moves."""
    a = []
    for i in range(len(s) - 1):
        ds = s[i + 1] - s[i]
        a.append((v[i + 1] * abs(v[i + 1]) - v[i] * abs(v[i])) / (2.0 * ds) if ds != 0.0 else 0.0)
    return [*a, 0.0]


def direction_along(x: list[float], y: list[float]) -> list[float]:
    """Direction of travel at each sample, rad from +x, counter-clockwise: tangent of the circle through a sample and its neighbours.

    At the ends, that of the circle through the nearest three. Where samples stand in one place, the direction of the last that moved,
    or of the first that moves. Raises D192 where nothing moves.
    """
    places, at = _apart(x, y)
    if len(places) < 2:
        raise TrackmarshalError(
            "D192", "`heading` cannot be computed: all samples are in one place", help="give the heading"
        )
    chords = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(places)]
    lengths = [math.dist(a, b) for a, b in pairwise(places)]
    turns = [wrap(b - a) for a, b in pairwise(chords)]
    found = []
    for i in range(len(places)):
        if not turns:
            found.append(chords[0])
        elif i == 0:
            found.append(wrap(chords[0] - turns[0] * lengths[0] / (lengths[0] + lengths[1])))
        elif i == len(places) - 1:
            found.append(wrap(chords[-1] + turns[-1] * lengths[-1] / (lengths[-2] + lengths[-1])))
        else:
            share = lengths[i - 1] / (lengths[i - 1] + lengths[i])
            found.append(wrap(chords[i - 1] + turns[i - 1] * share))
    return [found[place] for place in at]


def curvature_along(x: list[float], y: list[float]) -> list[float]:
    """Curvature at each sample, 1/m, positive to the left: of the circle through it and its neighbours (Menger).

    At the ends, that of the neighbour; 0 where there are fewer than three places.
    """
    places, at = _apart(x, y)
    inner = []
    for (ax, ay), (bx, by), (cx, cy) in zip(places, places[1:], places[2:]):
        cross = (bx - ax) * (cy - by) - (by - ay) * (cx - bx)
        sides = math.hypot(bx - ax, by - ay) * math.hypot(cx - bx, cy - by) * math.hypot(cx - ax, cy - ay)
        inner.append(2.0 * cross / sides if sides > 0.0 else math.nan)  # there and back: no circle
    found = [inner[0], *inner, inner[-1]] if inner else [0.0] * len(places)
    return [found[place] for place in at]


def completed(columns: Lists) -> Lists:
    """Columns with x, y and v, completed by s, t, heading, kappa and a where they are missing.

    A car that reverses points against its direction of travel, and what is to the left of the one is to the right of the other. Raises D192 where it
    drives both ways, and the path does not say where it points.
    """
    if not {"heading", "kappa"} <= columns.keys() and _both_ways(columns):
        raise TrackmarshalError(
            "D192",
            "where the car points does not follow from `x` and `y`: it drives ahead and backwards, and the path turns back",
            help="give `heading` and `kappa`, or complete what is driven ahead and what is driven backwards apart",
        )
    s = columns["s"] if "s" in columns else arc_length(columns["x"], columns["y"])
    made: Lists = {"t": columns["t"] if "t" in columns else time_along(s, columns["v"]), "s": s}
    back = reverses(columns["v"])
    if "heading" not in columns:
        made["heading"] = direction_along(columns["x"], columns["y"])
        if back:
            made["heading"] = [wrap(angle + math.pi) for angle in made["heading"]]
    if "kappa" not in columns:
        made["kappa"] = curvature_along(columns["x"], columns["y"])
        if back:
            made["kappa"] = [0.0 - value for value in made["kappa"]]
    if "a" not in columns:
        made["a"] = acceleration_along(s, columns["v"])
    return {**made, **columns}


def reverses(v: list[float]) -> bool:
    """Whether a trajectory leads backwards: in some sample, and in none ahead."""
    return any(speed < -REST_SPEED for speed in v) and not any(speed > REST_SPEED for speed in v)


def _both_ways(columns: Lists) -> bool:
    """Whether a trajectory leads ahead and backwards. Not by its speeds alone, of which some may be just below 0 at rest: its path turns back, too.
    Of a speed that is unknown, nothing follows."""
    v = columns["v"]
    if not (any(speed < -REST_SPEED for speed in v) and any(speed > REST_SPEED for speed in v)):
        return False
    places, _ = _apart(columns["x"], columns["y"])
    return any(
        (bx - ax) * (cx - bx) + (by - ay) * (cy - by) < 0.0
        for (ax, ay), (bx, by), (cx, cy) in zip(places, places[1:], places[2:])
    )


def wrap(angle: float) -> float:
    """The same angle in (-pi, pi]; NaN stays NaN."""
    wrapped = math.remainder(angle, math.tau) if math.isfinite(angle) else math.nan
    return math.pi if wrapped <= -math.pi else wrapped


def _apart(x: list[float], y: list[float]) -> tuple[list[tuple[float, float]], list[int]]:
    """Places that follow one another without repetition, and for each sample which of them it is in."""
    places: list[tuple[float, float]] = []
    at = []
    for place in zip(x, y):
        if not places or place != places[-1]:
            places.append(place)
        at.append(len(places) - 1)
    return places, at
