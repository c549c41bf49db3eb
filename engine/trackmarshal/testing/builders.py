"""Signals for tests in specs: trajectories and corridors from a few numbers.

Every builder takes keyword arguments in SI units and returns plain data. A trajectory has the columns t, s, x, y,
heading, kappa, v, a, exact and consistent with each other: positions lie on the curve, dv/dt is a, ds/dt is |v|. A
negative speed drives backwards. A corridor has left, right (lists of [x, y]) and closed; its centre line goes
through (x, y) with the given heading, and where it is open it begins `before` m behind that place, so that a vehicle
at the default place stands on it as a whole. BUILDERS describes all of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios.curve import Pose, advance

Columns = dict[str, list[float]]
Corridor = dict[str, Any]

CODES: dict[str, tuple[str, str]] = {
    "E451": (
        "a builder argument out of range",
        "Builders of test signals take finite numbers: lengths, widths and durations above zero, radii other than zero "
        "(negative turns right), whole numbers of points from 1 to 100000 (from 2 where the ends differ in meaning).",
    ),
    "E452": (
        "builder arguments that do not fit together",
        "An arc has a length or an angle, not both; a trajectory moves (stationary() is for those that don't) and does "
        "not come to rest before its length is driven (braking() ends at rest); a bend is wider than half the track.",
    ),
}  # fmt: skip

MAX_POINTS = 100_000
#: Bounds on the magnitude of arguments, so that nothing overflows.
LARGEST = 1e9
SMALLEST = 1e-9
#: A clothoid turns at most by this angle, rad: more is a slip in a unit.
MAX_TURN = 1000.0


def line(
    *,
    v: float,
    length: float = 49.0,
    points: float = 50,
    a: float = 0.0,
    x: float = 0.0,
    y: float = 0.0,
    heading: float = 0.0,
) -> Columns:
    """A straight trajectory from speed v with acceleration a, samples equally far apart."""
    return _drive(_Curve((x, y, heading), 0.0, 0.0), v, a, _above("length", length), _count(points, 1))


def arc(
    *,
    radius: float,
    v: float,
    length: float | None = None,
    angle: float | None = None,
    points: float = 50,
    a: float = 0.0,
    x: float = 0.0,
    y: float = 0.0,
    heading: float = 0.0,
) -> Columns:
    """A circular trajectory; radius > 0 turns left, < 0 right; kappa is 1/radius. Length 49 m if none is given."""
    curve = _Curve((x, y, heading), _kappa(radius), 0.0)
    return _drive(curve, v, a, _arc_length(radius, length, angle, 49.0), _count(points, 1))


def clothoid(
    *,
    kappa0: float,
    kappa1: float,
    v: float,
    length: float = 49.0,
    points: float = 50,
    a: float = 0.0,
    x: float = 0.0,
    y: float = 0.0,
    heading: float = 0.0,
) -> Columns:
    """A trajectory whose curvature goes linearly from kappa0 to kappa1."""
    _finite(kappa0=kappa0, kappa1=kappa1)
    length = _above("length", length)
    if 0.5 * (abs(kappa0) + abs(kappa1)) * length > MAX_TURN:
        raise _misfit(f"it turns by more than {MAX_TURN:g} rad", "curvatures are in 1/m, the length in m")
    curve = _Curve((x, y, heading), kappa0, (kappa1 - kappa0) / length)
    columns = _drive(curve, v, a, length, _count(points, 1))
    if len(columns["kappa"]) > 1:
        columns["kappa"][-1] = float(kappa1)  # not off by a rounding
    return columns


def constant_speed(
    *,
    v: float,
    duration: float = 4.9,
    points: float = 50,
    x: float = 0.0,
    y: float = 0.0,
    heading: float = 0.0,
) -> Columns:
    """A straight trajectory at speed v for a time, samples equally long apart."""
    _finite(v=v)
    duration = _above("duration", duration)
    length = abs(v) * duration
    if length == 0.0:
        raise _misfit("v is 0: nothing moves", "stationary(...) stands still")
    return _drive(_Curve((x, y, heading), 0.0, 0.0), v, 0.0, length, _count(points, 1))


def braking(
    *,
    v: float,
    a: float,
    radius: float | None = None,
    points: float = 50,
    x: float = 0.0,
    y: float = 0.0,
    heading: float = 0.0,
) -> Columns:
    """A trajectory that brakes from v at the constant deceleration a (a positive magnitude) and ends exactly at rest.

    Samples are equally long apart; straight, or on an arc where a radius is given.
    """
    v, a = _above("v", v), _above("a", a)
    count = _count(points, 2)
    _finite(x=x, y=y, heading=heading)
    curve = _Curve((x, y, heading), 0.0 if radius is None else _kappa(radius), 0.0)
    share = [i / (count - 1) for i in range(count)]
    s = [v * v / (2.0 * a) * r * (2.0 - r) for r in share]
    t = [v / a * r for r in share]
    return _columns(curve, 1.0, _Motion(t, s, [v * (1.0 - r) for r in share], -a))


def stationary(
    *, duration: float = 4.9, points: float = 50, x: float = 0.0, y: float = 0.0, heading: float = 0.0
) -> Columns:
    """A trajectory that stands still for a time."""
    count = _count(points, 1)
    _finite(x=x, y=y, heading=heading)
    step = _above("duration", duration) / max(1, count - 1)
    motion = _Motion([i * step for i in range(count)], [0.0] * count, [0.0] * count, 0.0)
    return _columns(_Curve((x, y, heading), 0.0, 0.0), 1.0, motion)


def straight_track(
    *,
    length: float = 150.0,
    width: float = 10.0,
    before: float = 50.0,
    x: float = 0.0,
    y: float = 0.0,
    heading: float = 0.0,
) -> Corridor:
    """A straight corridor from `before` m behind (x, y) to `length` m ahead of it."""
    ends = [-_above("before", before), _above("length", length)]
    return _corridor(_Curve((x, y, heading), 0.0, 0.0), ends, width, closed=False)


def arc_track(
    *,
    radius: float,
    width: float = 10.0,
    length: float | None = None,
    angle: float | None = None,
    before: float = 20.0,
    points: float = 200,
    x: float = 0.0,
    y: float = 0.0,
    heading: float = 0.0,
) -> Corridor:
    """A circular corridor, borders as polygons with their corners on the circles. Length 100 m if none is given."""
    curve = _Curve((x, y, heading), _kappa(radius), 0.0)
    ahead, behind = _arc_length(radius, length, angle, 100.0), _above("before", before)
    if ahead + behind >= 2.0 * math.pi * abs(radius):
        raise _misfit("the arc overlaps itself", "ring_track(...) goes round and is closed")
    count = _count(points, 2)
    stations = [-behind + (ahead + behind) * i / (count - 1) for i in range(count)]
    return _corridor(curve, stations, width, closed=False)


def ring_track(
    *,
    radius: float,
    width: float = 10.0,
    points: float = 400,
    x: float = 0.0,
    y: float = 0.0,
    heading: float = 0.0,
) -> Corridor:
    """A closed circular corridor; the first point of a border is not repeated at its end."""
    curve = _Curve((x, y, heading), _kappa(radius), 0.0)
    count = _count(points, 3)
    stations = [2.0 * math.pi * abs(radius) * i / count for i in range(count)]
    return _corridor(curve, stations, width, closed=True)


class Parameter(NamedTuple):
    """A builder's parameter: its unit ("1" for counts), and its default or None; without default it may be optional."""

    unit: str
    default: float | None
    required: bool


class Builder(NamedTuple):
    """A builder as the spec compiler sees it; `builds` is the kind of signal: "trajectory" or "corridor"."""

    name: str
    builds: str
    parameters: dict[str, Parameter]
    build: Callable[..., dict[str, Any]]
    doc: str


_UNITS = {
    "v": "m/s", "a": "m/s^2", "length": "m", "width": "m", "before": "m", "radius": "m", "x": "m", "y": "m",
    "heading": "rad", "angle": "rad", "kappa0": "1/m", "kappa1": "1/m", "duration": "s", "points": "1",
}  # fmt: skip


def _describe(builds: str, build: Callable[..., dict[str, Any]]) -> Builder:
    """Read the parameters off the signature (all are keywords), so that they are said once."""
    function: Any = build
    defaults = function.__kwdefaults__
    names = function.__code__.co_varnames[: function.__code__.co_kwonlyargcount]
    parameters = {name: Parameter(_UNITS[name], defaults.get(name), name not in defaults) for name in names}
    return Builder(function.__name__, builds, parameters, build, (function.__doc__ or "").strip())


#: All builders by the name that specs use.
BUILDERS: dict[str, Builder] = {
    builder.name: builder
    for builder in (
        *(_describe("trajectory", f) for f in (line, arc, clothoid, constant_speed, braking, stationary)),
        *(_describe("corridor", f) for f in (straight_track, arc_track, ring_track)),
    )
}


#: What was built, by builder and arguments; no more than this is kept.
_BUILT: dict[tuple[str, str], dict[str, Any]] = {}
_MOST_BUILT = 512


def built(builder: Builder, arguments: Mapping[str, float]) -> dict[str, Any]:
    """What a builder makes of arguments, once of the same ones: most tests of a rule stand on the same track. Its lists are the caller's own, and
    nobody changes the points in them. Raises what the builder does."""
    key = builder.name, repr(sorted(arguments.items()))
    made = _BUILT.get(key)
    if made is None:
        if len(_BUILT) == _MOST_BUILT:
            _BUILT.clear()
        made = _BUILT[key] = builder.build(**arguments)
    return {name: list(part) if isinstance(part, list) else part for name, part in made.items()}


class _Curve(NamedTuple):
    start: Pose
    kappa: float
    sharpness: float

    def at(self, s: float) -> Pose:
        return advance(self.start, self.kappa, self.sharpness, s)


class _Motion(NamedTuple):
    t: list[float]
    s: list[float]
    v: list[float]
    a: float


def _drive(curve: _Curve, v: float, a: float, length: float, count: int) -> Columns:
    """Columns along a curve at constant acceleration, samples equally far apart: v_i^2 = v^2 + 2 a s_i."""
    _finite(v=v, a=a, x=curve.start[0], y=curve.start[1], heading=curve.start[2])
    direction = math.copysign(1.0, v if v != 0.0 else a)
    s = [length * i / max(1, count - 1) for i in range(count)]
    speeds = []
    for station in s:
        square = v * v + 2.0 * a * direction * station
        if -1e-12 * v * v <= square < 0.0:
            square = 0.0  # at rest but for rounding
        if square < 0.0:
            stop = v * v / (2.0 * abs(a))
            raise _misfit(
                f"it comes to rest after {stop:.6g} m of {length:.6g} m", "braking(...) ends at rest"
            )
        speeds.append(direction * math.sqrt(square) if a != 0.0 else float(v))
    if v == 0.0 and a == 0.0:
        raise _misfit("v and a are 0: nothing moves", "stationary(...) stands still")
    t = [0.0, *(2.0 * station / (abs(v) + abs(speed)) for station, speed in zip(s[1:], speeds[1:]))]
    return _columns(curve, direction, _Motion(t, s, speeds, float(a)))


def _columns(curve: _Curve, direction: float, motion: _Motion) -> Columns:
    poses = [curve.at(direction * station) for station in motion.s]
    return {
        "t": motion.t,
        "s": motion.s,
        "x": [x for x, _, _ in poses],
        "y": [y for _, y, _ in poses],
        "heading": [heading for _, _, heading in poses],
        "kappa": [curve.kappa + curve.sharpness * direction * station for station in motion.s],
        "v": motion.v,
        "a": [motion.a] * len(motion.s),
    }


def _corridor(curve: _Curve, stations: list[float], width: float, *, closed: bool) -> Corridor:
    _finite(x=curve.start[0], y=curve.start[1], heading=curve.start[2])
    half = 0.5 * _above("width", width)
    if abs(curve.kappa) * half >= 1.0:
        raise _misfit("the radius is not larger than half the width", "widen the bend or narrow the track")
    poses = [curve.at(s) for s in stations]
    sides = {
        side: [[x - d * math.sin(h), y + d * math.cos(h)] for x, y, h in poses]
        for side, d in (("left", half), ("right", -half))
    }
    return {**sides, "closed": closed}


def _finite(**arguments: float) -> None:
    for name, value in arguments.items():
        if not abs(value) <= LARGEST:
            help_ = f"give a finite number, at most {LARGEST:g} in magnitude"
            raise TrackmarshalError("E451", f"{name} is {value:g}", help=help_)


def _above(name: str, value: float) -> float:
    """The value, finite and above zero."""
    _finite(**{name: value})
    if value < SMALLEST:
        raise TrackmarshalError("E451", f"{name} is {value:g}", help=f"{name} has to be above 0")
    return float(value)


def _count(points: float, least: int) -> int:
    _finite(points=points)
    if points != int(points) or not least <= points <= MAX_POINTS:
        help_ = f"give a whole number from {least} to {MAX_POINTS}"
        raise TrackmarshalError("E451", f"points is {points:g}", help=help_)
    return int(points)


def _kappa(radius: float) -> float:
    _finite(radius=radius)
    if abs(radius) < SMALLEST:
        raise TrackmarshalError("E451", f"radius is {radius:g}", help="radius > 0 turns left, < 0 right")
    return 1.0 / radius


def _arc_length(radius: float, length: float | None, angle: float | None, default: float) -> float:
    if length is not None and angle is not None:
        raise _misfit("length and angle are both given", "give one of them")
    if angle is not None:
        return _above("angle", angle) * abs(radius)
    return default if length is None else _above("length", length)


def _misfit(message: str, help: str) -> TrackmarshalError:
    return TrackmarshalError("E452", message, help=help)
