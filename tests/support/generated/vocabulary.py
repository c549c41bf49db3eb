"""What generated specs are made of: dimensions and their units, signals of every kind, what a module declares."""

from __future__ import annotations

from dataclasses import dataclass, field

#: Exponents of metre and second.
Dimension = tuple[int, int]

NUMBER: Dimension = (0, 0)
LENGTH: Dimension = (1, 0)
TIME: Dimension = (0, 1)
SPEED: Dimension = (1, -1)
ACCELERATION: Dimension = (1, -2)
CURVATURE: Dimension = (-1, 0)

#: Units that numbers are written in, the SI unit first.
UNITS: dict[Dimension, tuple[str, ...]] = {
    NUMBER: ("1", "rad", "%", "deg"),
    LENGTH: ("m", "km", "cm", "mm"),
    TIME: ("s", "ms", "min"),
    SPEED: ("m/s", "km/h"),
    ACCELERATION: ("m/s^2", "cm/s^2"),
    CURVATURE: ("1/m", "1/km"),
    (0, -1): ("1/s", "Hz"),
    (2, 0): ("m^2", "cm^2"),
    (2, -2): ("m^2/s^2",),
    (0, 2): ("s^2",),
}

#: Dimensions that most numbers have, so that tables, parameters and definitions find uses.
COMMON = (NUMBER, LENGTH, SPEED, TIME)

#: What the shapes of a definition's parameters let it read.
SHAPES: dict[str, dict[str, Dimension]] = {
    "point": {"x": LENGTH, "y": LENGTH},
    "pose": {"x": LENGTH, "y": LENGTH, "heading": NUMBER},
    "moving": {"x": LENGTH, "y": LENGTH, "heading": NUMBER, "v": SPEED},
    "body": {"x": LENGTH, "y": LENGTH, "heading": NUMBER, "length": LENGTH, "width": LENGTH},
    "vehicle": {"x": LENGTH, "y": LENGTH, "heading": NUMBER, "v": SPEED, "length": LENGTH, "width": LENGTH},
}

_POSE: dict[str, Dimension | None] = {"x": LENGTH, "y": LENGTH, "heading": NUMBER}
_BOX: dict[str, Dimension | None] = {"v": SPEED, "length": LENGTH, "width": LENGTH}

#: Signals with their kinds and fields: a dimension, or None for a Boolean field.
SIGNALS: dict[str, tuple[str, dict[str, Dimension | None]]] = {
    "plan": ("trajectory", {"t": TIME, **_POSE, "kappa": CURVATURE, "v": SPEED, "a": ACCELERATION, "ok": None}),
    "trace": ("series", {"t": TIME, "u": NUMBER, "w": LENGTH, "hot": None}),
    "objects": ("set of object", {**_POSE, **_BOX, "age": TIME, "seen": None}),
    "cones": ("set of object", {"x": LENGTH, "y": LENGTH, "n": NUMBER}),
    "ego": ("state", {**_POSE, **_BOX, "n": NUMBER, "awake": None}),
}  # fmt: skip
TIMELINES = ("plan", "trace")
SETS = ("objects", "cones")

#: Numbers of specs and of inputs come from here, so that they meet: ties, boundaries, opposite zeros.
PLAIN = (0.0, 1.0, 2.0, 0.5, -1.0, -0.5, 3.0, 10.0, -2.0, 0.1, 0.3, 7.25, -0.0, 100.0, 1e-9)
#: Numbers at the edges of what a double holds.
HUGE = (1e308, -1e308, 5e-324, -5e-324, 1e-310, 1e154, -1e154, 9007199254740993.0)


@dataclass(frozen=True)
class FieldInfo:
    """A field as declared; no dimension: a Boolean. Range and default are in the unit."""

    dimension: Dimension | None
    unit: str
    increasing: bool = False
    range: tuple[float, float] | None = None
    default: float | None = None


@dataclass(frozen=True)
class SignalInfo:
    kind: str
    fields: dict[str, FieldInfo]

    def dimensions(self) -> dict[str, Dimension | None]:
        return {name: info.dimension for name, info in self.fields.items()}


@dataclass(frozen=True)
class ParamInfo:
    dimension: Dimension
    unit: str
    low: float | None
    high: float | None


@dataclass(frozen=True)
class TableInfo:
    argument: Dimension
    result: Dimension
    rows: int


@dataclass(frozen=True)
class DefineInfo:
    """A definition: (name, dimension or shape) of its parameters, and its result, None for a predicate."""

    parameters: tuple[tuple[str, Dimension | str], ...]
    result: Dimension | None
    temporal: bool


@dataclass
class World:
    """What a module declares, by name."""

    signals: dict[str, SignalInfo] = field(default_factory=dict)
    events: list[str] = field(default_factory=list)
    params: dict[str, ParamInfo] = field(default_factory=dict)
    tables: dict[str, TableInfo] = field(default_factory=dict)
    zones: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    #: Whether there is a track (a corridor) and a fence (a polyline).
    road: bool = False
    defines: dict[str, DefineInfo] = field(default_factory=dict)


def spelled(value: float) -> str:
    """A number that is not negative, as the language writes it."""
    text = repr(value)
    return text.removesuffix(".0") if text.endswith(".0") else text
