"""A cycle with a place for everything that a caller may hand in, and an example of every kind of object of docs/supervisor.md."""

from __future__ import annotations

import array
import collections
import copy
import decimal
import enum
import fractions
import itertools
import re
import tempfile
import types
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from trackmarshal.evaluation import load
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.door.lines import line

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "supervisor.md").read_text("utf-8")
TEXT = """
module types
signal plan : trajectory {
  t: s increasing in [0, 100], x: m, y: m, heading: rad, v: m/s in [-10, 150], grip: % in [0, 150] default 100 %, ready: bool
}
signal ego : state { x: m, y: m, heading: rad, age: s in [0, 1] default 0 s }
signal car : state { gap: ms in [0, 500], load: kg default 100 kg, on: bool }
signal objects : set of object { x: m, w: km/h in [-180, 180], age: s in [0, 10] default 0 s, seen: bool }
signal track : corridor { left: polyline, right: polyline }
signal border : polyline
event wet

rule speed "Speed, by grip"
  for all p in plan
  require p.v * p.grip <= 60 m/s and p.ready

rule sum "What the car says of itself"
  require ego.x + car.gap * 1 m/s + car.load * 1 m/kg + ego.age * 1 m/s <= 1000 m and car.on

rule apart "Away from what is seen"
  for all o in objects
  for all p in plan
  require abs(o.x - p.x) + abs(o.w) * o.age >= 1 m and o.seen

rule on_track "On the track"
  for all p in plan
  require swept_hull(p, 2 m, 1 m) inside track

rule near "Near the border"
  for all p in plan
  require distance_to(p, border) <= 50 m

rule dry "Dry"
  require not wet
"""
#: The same in SI, of numbers alone: what is read in one go where it is arrays and floats.
_PLAIN = {
    "% in [0, 150] default 100 %": "1 in [0, 150] default 100", ", ready: bool": "", ", seen: bool": "", ", on: bool": "", "km/h": "m/s",
    "gap: ms": "gap: s", " and p.ready": "", " and car.on": "", " and o.seen": "", "<= 60 m/s": "<= 6000 m/s",
}  # fmt: skip
FLAGS = ("ready", "seen", "on")
VARIANTS = ("lists", "arrays")
LIMITS = Limits(
    samples=8, elements=4, border=8, longest_gap=1e9, oldest=1e9, clock_tolerance=1e9, budget=1e9, apart=1e9, beside=1e9, turned=1e9, overspeed=1e9, blind=1e9
)  # fmt: skip


@cache
def spec(variant: str = "lists") -> Spec:
    """The spec; for `arrays`, the one in SI without Booleans."""
    text = TEXT
    for old, new in _PLAIN.items() if variant == "arrays" else ():
        assert old in text, old
        text = text.replace(old, new)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "types.spec"
        path.write_text(text, encoding="utf-8")
        return load([path])


def cycle(number: int, t: float, variant: str = "lists") -> Cycle:
    """A flawless and safe cycle of plain lists and dicts of Python's own numbers: small and whole, every type holds them.

    For `arrays` without Booleans, and to be handed through `arrayed`.
    """
    driving = {
        "t": [0.0, 1.0, 2.0], "x": [0.0, 1.0, 2.0], "y": [0.0, 0.0, 1.0], "heading": [0.0, 0.0, 1.0], "v": [1.0, 1.0, 0.0],
        "ready": [True, True, True],
    }  # fmt: skip
    signals: dict[str, Any] = {
        "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "age": 0.0},
        "car": {"gap": 3.0, "load": 5.0, "on": True},
        "objects": {
            "id": ["a", "b"],
            "x": [50.0, 60.0],
            "w": [3.0, 4.0],
            "age": [1.0, 2.0],
            "seen": [True, True],
        },
        "track": {"left": [[0.0, 9.0], [99.0, 9.0]], "right": [[0.0, 0.0], [99.0, 0.0]], "closed": False},
        "border": [[0.0, 0.0], [9.0, 9.0]],
        "wet": False,
    }
    if variant == "arrays":
        for held in (driving, signals["car"], signals["objects"]):
            for name in FLAGS:
                held.pop(name, None)
    for name in ("left", "right"):
        signals["track"][name] = [
            [x - 50.0, y if name == "left" else -9.0] for x, y in signals["track"][name]
        ]
    return Cycle(number, t, driving, copy.deepcopy(driving), signals)


# Places ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Place:
    """Where something stands: `holds` is the sort of what belongs there; `at` is how to get there, `told` what a fault there names.

    With a number right behind `objects`, these are records.
    """

    name: str
    holds: str
    at: tuple[Any, ...]
    told: tuple[str, str]


def _place(name: str, holds: str, *at: Any, told: tuple[str, str] | None = None) -> Place:
    names = [step for step in at if isinstance(step, str) and step != "signals"]
    return Place(name, holds, at, told or ((*names, "")[0], (*names, "", "")[1]))


#: By the words of the page.
PLACES = (
    _place("stamp", "number", "t", told=("cycle", "t")),
    _place("cycle number", "number", "number", told=("cycle", "number")),
    _place("number", "number", "driving", "v", 1),
    _place("number", "number", "emergency", "grip", 1),
    _place("number", "number", "signals", "ego", "x"),
    _place("number", "number", "signals", "car", "gap"),
    _place("number", "number", "signals", "objects", "w", 0),
    _place("number", "number", "signals", "objects", 0, "w", told=("objects", "w")),
    _place("coordinate", "number", "signals", "track", "left", 0, 1),
    _place("coordinate", "number", "signals", "border", 1, 0, told=("border", "")),
    _place("Boolean", "Boolean", "driving", "ready", 2),
    _place("Boolean", "Boolean", "signals", "car", "on"),
    _place("Boolean", "Boolean", "signals", "objects", "seen", 1),
    _place("Boolean", "Boolean", "signals", "objects", 1, "seen"),
    _place("event", "Boolean", "signals", "wet"),
    _place("`closed`", "Boolean", "signals", "track", "closed"),
    _place("id", "id", "signals", "objects", "id", 0),
    _place("numbers", "numbers", "driving", "x"),
    _place("numbers", "numbers", "emergency", "grip"),
    _place("numbers", "numbers", "signals", "objects", "x"),
    _place("Booleans", "Booleans", "emergency", "ready"),
    _place("Booleans", "Booleans", "signals", "objects", "seen"),
    _place("ids", "ids", "signals", "objects", "id"),
    _place("fields", "fields", "driving"),
    _place("fields", "fields", "signals", "ego"),
    _place("fields", "fields", "signals", "car"),
    _place("record", "fields", "signals", "objects", 1, told=("objects", "")),
    _place("fields", "fields", "signals", "track"),
    _place("fields", "fields", "signals", told=("signals", "")),
    _place("set", "set", "signals", "objects"),
    _place("line", "points", "signals", "border"),
    _place("line", "points", "signals", "track", "right"),
    _place("point", "numbers", "signals", "border", 1, told=("border", "")),
    _place("point", "numbers", "signals", "track", "left", 1),
)  # fmt: skip


def arrayed(given: Cycle) -> Cycle:
    """With arrays for lists of floats, as most cycles come."""

    def columns(held: Any) -> Any:
        if type(held) is not dict:
            return held
        return {
            name: np.array(c) if type(c) is list and set(map(type, c)) <= {float} else c
            for name, c in held.items()
        }

    signals = given.signals
    if type(signals) is dict and "objects" in signals:
        signals = {**signals, "objects": columns(signals["objects"])}
    return replace(given, driving=columns(given.driving), emergency=columns(given.emergency), signals=signals)


def places(variant: str) -> list[Place]:
    """The places that its cycles have."""
    return [place for place in PLACES if variant == "lists" or not {*FLAGS} & {*place.at}]


def complete(given: Cycle) -> Cycle:
    """With every place there: the column that may be left to its default too."""
    return replace(given, emergency={**given.emergency, "grip": [100.0, 100.0, 100.0]})


def records(given: Cycle) -> Cycle:
    """With records for objects."""
    columns = given.signals["objects"]
    listed = [{name: column[i] for name, column in columns.items()} for i in range(2)]
    return replace(given, signals={**given.signals, "objects": listed})


def based(given: Cycle, place: Place) -> Cycle:
    """The cycle in the form in which it has the place."""
    of_records = "objects" in place.at and type((*place.at, "")[2]) is int
    return records(given) if of_records and isinstance(given.signals["objects"], dict) else given


def content(given: Cycle, place: Place) -> Any:
    """What stands at a place, in Python's own numbers, lists and dicts."""
    found: Any = based(given, place)
    for step in place.at:
        found = getattr(found, step) if isinstance(found, Cycle) else found[step]
    return found


def put(given: Cycle, place: Place, value: Any) -> Cycle:
    """A copy of the cycle with something else at a place."""
    return replaced(copy.deepcopy(based(given, place)), place, value)


def replaced(given: Cycle, place: Place, value: Any) -> Cycle:
    """The cycle with something else at a place, in the dicts and lists that it has."""
    if len(place.at) == 1:
        return replace(given, **{place.at[0]: value})
    holder = getattr(given, place.at[0])
    for step in place.at[1:-1]:
        holder = holder[step]
    holder[place.at[-1]] = value
    return given


# The page ---------------------------------------------------------------------------------------------------------


def table() -> dict[str, tuple[set[str], dict[str, str]]]:
    """By what it is: the places where it is taken, and by place the fault where it is another one than `wrong_type`."""
    section = PAGE.split("## What a cycle may be made of")[1].split("\n## ")[0]
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in section.splitlines()
        if line[:1] == "|"
    ]
    assert rows[0] == ["what it is", "taken as", "refused as"]
    found = {}
    for what, taken, refused in rows[2:]:
        faults: dict[str, str] = {}
        for part in filter(None, map(str.strip, refused.split(";"))):
            match = re.fullmatch(r"`(\w+)`: (.+)", part)
            assert match is not None, part
            faults |= dict.fromkeys(match[2].split(", "), match[1])
        assert what not in found, what
        found[what] = set(filter(None, taken.split(", "))), faults
    return found


# Examples ---------------------------------------------------------------------------------------------------------

Make = Callable[[Any], Any]


@dataclass(frozen=True)
class Example:
    """An object of some content: `holds` are the sorts of content that it can have, `otherwise` is one where it can't have a place's."""

    make: Make
    holds: tuple[str, ...] = ()
    otherwise: Any = None

    def of(self, given: Cycle, place: Place) -> Any:
        """It in the place's stead: of the content that stands there, where it can have that."""
        if place.holds == "set" and "records" in self.holds:
            return self.make(content(records(given), place))
        fits = place.holds in self.holds or (place.holds == "set" and "fields" in self.holds)
        return self.make(content(given, place) if fits else self.otherwise)


class Metres(float):
    """A float of a class of one's own, which says of itself what it is not."""

    def __float__(self) -> float:
        return 77.0

    def __repr__(self) -> str:
        return "77.0"


class Count(int):
    def __int__(self) -> int:
        return 77

    def __repr__(self) -> str:
        return "77"


class Word(str):
    __slots__ = ()


class Rows(list[Any]):
    """A list that says something else when it is asked."""

    def __iter__(self) -> Iterator[Any]:
        return iter([77.0] * len(self))


class Row(tuple[Any, ...]):
    __slots__ = ()


class Dict(dict[str, Any]):
    pass


class Fields(Mapping[str, Any]):
    def __init__(self, given: Mapping[str, Any]) -> None:
        self._given = dict(given)

    def __getitem__(self, key: str) -> Any:
        return self._given[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._given)

    def __len__(self) -> int:
        return len(self._given)


class Array(np.ndarray[Any, Any]):
    pass


def _named(values: Sequence[Any]) -> Any:
    return collections.namedtuple("Named", [f"f{i}" for i in range(len(values))])(*values)


def _enumerated(value: Any) -> Any:
    of = enum.IntEnum("Of", {"one": int(value)})  # type: ignore[misc]
    return of(int(value))


def _memmap(values: Any) -> Any:
    array_ = np.asarray(values)
    with tempfile.TemporaryFile() as file:
        made = np.memmap(file, dtype=array_.dtype, mode="w+", shape=array_.shape)
        made[:] = array_
    return made


def _strided(values: Any) -> Any:
    array_ = np.asarray(values, dtype=np.float64)
    wide = np.full(tuple(3 * n for n in array_.shape), 77.0)
    view = wide[tuple(slice(None, None, -3) for _ in array_.shape)]
    view[...] = array_
    return view


def _read_only(values: Any) -> Any:
    made = np.array(values, dtype=np.float64)
    made.flags.writeable = False
    return made


def _boxed(values: Any) -> Any:
    made = np.empty(len(values), dtype=object)
    made[:] = values if not isinstance(values[0], list) else [list(v) for v in values]
    return made


def _mask(values: Any) -> Any:
    made = np.ma.array(values)
    made[(1,) * made.ndim] = np.ma.masked
    return made


def _matrix(values: Any) -> Any:
    with warnings.catch_warnings(action="ignore"):
        return np.asmatrix(values)


def _structured(values: Any) -> Any:
    rows = [tuple(v) if isinstance(v, list) else (v, v) for v in values]
    return np.array(rows, dtype=[("y", "f8"), ("x", "f8")])


@dataclass
class Attributes:
    """Fields by attribute, of which a door knows nothing."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0


_NUMBER = ("number", "id")
_SEQUENCE = ("numbers", "Booleans", "ids", "records", "points")


def of_no_unit(number: int) -> np.timedelta64:
    """A duration that does not say in what, of which numpy itself warns since 2.5."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        return np.timedelta64(number)


def _n(make: Make) -> Example:
    """Of a number."""
    return Example(lambda v: make(v if isinstance(v, int | float) else 3.0), _NUMBER, 3.0)


def _c(make: Make, *more: str) -> Example:
    """Of numbers, points and ids that are numbers."""
    return Example(lambda v: make(_numbered(v)), ("numbers", "points", "ids", *more), [0.0, 1.0, 2.0])


def _same(value: Any) -> Any:
    return value


def _numbered(values: Any) -> Any:
    return [float(i) for i in range(len(values))] if isinstance(values[0], str) else values


def _s(make: Make) -> Example:
    return Example(make, _SEQUENCE, [0.0, 1.0, 2.0])


def _m(make: Make) -> Example:
    return Example(make, ("fields",), {"a": 1.0})


def _o(make: Make) -> Example:
    """Of anything."""
    return Example(make)


#: Examples by the first column of the page; every one of them is held against what the page says of it.
EXAMPLES: dict[str, tuple[Example, ...]] = {
    "`float`, or a class derived from it": (_n(float), _n(Metres)),
    "`int`, or a class derived from it": (_n(int), _n(Count), _n(_enumerated)),
    "`numpy.float16` to `float64`, `longdouble`": (_n(np.float16), _n(np.float32), _n(np.float64), _n(np.longdouble)),
    "`numpy.int8` to `int64`, `uint8` to `uint64`": tuple(
        _n(kind) for kind in (np.int8, np.int16, np.int32, np.int64, np.uint8, np.uint16, np.uint32, np.uint64)
    ),
    "array without axes, of a real number": (_n(lambda v: np.array(float(v))), _n(lambda v: np.array(v, dtype=">f4"))),
    "array without axes, of a whole number": (_n(lambda v: np.array(int(v))), _n(lambda v: np.array(v, dtype=np.uint8))),
    "`bool`": (Example(bool, ("Boolean",), True),),
    "`numpy.bool_`": (Example(np.bool_, ("Boolean",), True),),
    "array without axes, of a Boolean": (Example(lambda v: np.array(bool(v)), ("Boolean",), True),),
    "`str`, or a class derived from it": tuple(
        Example(make, ("id",), "3") for make in (str, Word, np.str_)
    ),
    "NaN, infinity": tuple(
        _o(lambda _, v=value: v)  # type: ignore[misc]
        for value in (float("nan"), float("inf"), -np.inf, np.float32("nan"), np.array(np.inf), np.longdouble("inf"))
    ),
    "a number that no `float` holds": (
        _o(lambda _: 10**400), _o(lambda _: -(10**400)), _o(lambda _: Count(10**400)),
    ),
    "`None`": (_o(lambda _: None),),
    "`decimal.Decimal`, `fractions.Fraction`, `complex`": (
        _n(decimal.Decimal), _n(fractions.Fraction), _n(complex), _n(np.complex128), _n(lambda v: np.array(complex(v))),
    ),
    "`bytes`, `bytearray`, `memoryview`": (
        _o(lambda _: b"abc"), _o(lambda _: bytearray(8)), _o(lambda _: memoryview(bytes(24)).cast("d")), _o(lambda _: np.bytes_(b"3")),
    ),
    "`numpy.timedelta64`, `datetime64`, and those of `datetime`": (
        _n(lambda v: of_no_unit(int(v))), _n(lambda v: np.timedelta64(int(v), "ns")), _n(lambda v: np.timedelta64(int(v), "s")),
        _n(lambda v: np.datetime64(int(v), "ns")), _n(lambda v: np.array(int(v), dtype="m8[ns]")),
        _o(lambda _: __import__("datetime").timedelta(seconds=3)),
    ),
    "`numpy.ma.masked`, `numpy.void`": (_o(lambda _: np.ma.masked), _o(lambda _: np.zeros(1, dtype="f8,f8")[0])),
    "`list`, or a class derived from it": (_s(list), _s(Rows)),
    "`tuple`, or a class derived from it (named ones too)": (_s(tuple), _s(Row), _s(_named)),
    "array of real numbers: of any size, byte order, strides, writable or not": (
        _c(lambda v: np.array(v, dtype=np.float64)), _c(lambda v: np.array(v, dtype=np.float32)),
        _c(lambda v: np.array(v, dtype=np.longdouble)), _c(lambda v: np.array(v, dtype=">f8")), _c(_strided), _c(_read_only),
        _c(lambda v: np.array(v, dtype=np.float64, order="F")), _c(lambda v: np.frombuffer(np.array(v).tobytes()).reshape(np.shape(v))),
    ),
    "array of whole numbers": tuple(
        _c(lambda v, d=kind: np.array(v).astype(d))  # type: ignore[misc]
        for kind in ("i1", "i2", "i4", "i8", ">i4")
    ),
    "array of Booleans": (Example(np.array, ("Booleans",), [True, False, True]),),
    "array of texts": (Example(lambda v: np.array(list(map(str, v))), ("ids",), ["1", "2", "3"]),),
    "array of objects": (Example(_boxed, ("numbers", "Booleans", "ids", "points"), [0.0, 1.0, 2.0]),),
    "masked array of numbers, of which none is masked": (
        Example(np.ma.array, ("numbers", "points"), [0.0, 1.0, 2.0]),
        Example(lambda v: np.ma.array(v, mask=np.zeros(np.shape(v), dtype=bool)), ("numbers", "points"), [0.0, 1.0, 2.0]),
        Example(lambda v: np.ma.array(np.array(v).astype(int)), ("numbers", "points"), [0.0, 1.0, 2.0]),
    ),
    "masked array of numbers, of which one is masked": (
        Example(_mask, ("numbers", "points"), [0.0, 1.0, 2.0]),
        Example(lambda v: _mask(np.array(v).astype(int)), ("numbers", "points"), [0.0, 1.0, 2.0]),
    ),
    "masked array of Booleans, of which none is masked": (Example(np.ma.array, ("Booleans",), [True, False, True]),),
    "masked array of Booleans, of which one is masked": (Example(_mask, ("Booleans",), [True, False, True]),),
    "`numpy.memmap` of numbers": (Example(_memmap, ("numbers", "points"), [0.0, 1.0, 2.0]),),
    "`numpy.memmap` of Booleans": (Example(_memmap, ("Booleans",), [True, False, True]),),
    "array of complex numbers, times, dates, bytes, or with fields": (
        _c(lambda v: np.array(v, dtype=complex)), _c(lambda v: np.array(v).astype(int).astype("m8[ns]")),
        _c(lambda v: np.array(v).astype(int).astype("M8[ns]")), _c(lambda v: np.array(v).astype("S4")), _c(_structured),
        _c(lambda v: _structured(v).view(np.recarray)),
    ),
    "array with an axis too many": (
        Example(lambda v: np.array(v)[..., None], ("numbers", "points", "ids", "Booleans"), [[0.0, 1.0]]),
        Example(lambda v: np.array([v]), ("numbers", "points", "ids", "Booleans"), [[0.0, 1.0]]),
    ),
    "`numpy.matrix`, and other classes derived from `numpy.ndarray`": (
        _c(lambda v: np.array(v).view(Array), "Booleans"), _c(lambda v: np.array(v).view(np.recarray), "Booleans"),
        _c(_matrix, "Booleans"),
    ),
    "`array.array`, `range`, `collections.deque`, `set`, views of a `dict`": (
        Example(lambda v: array.array("d", v), ("numbers",), [0.0, 1.0, 2.0]), Example(lambda v: range(len(v)), ("numbers", "ids"), [0.0, 1.0, 2.0]),
        _s(collections.deque), Example(set, ("numbers", "Booleans", "ids"), [0.0, 1.0, 2.0]),
        Example(frozenset, ("numbers", "Booleans", "ids"), [0.0, 1.0, 2.0]), _s(lambda v: dict(enumerate(v)).values()),
    ),
    "generators and other iterators": (_s(iter), _s(lambda v: (x for x in v)), _s(lambda v: map(_same, v)), _s(itertools.chain)),
    "`dict`, or a class derived from it": (
        _m(dict), _m(Dict), _m(collections.OrderedDict), _m(lambda v: collections.defaultdict(float, v)), _m(collections.Counter),
    ),
    "any other `collections.abc.Mapping`": (
        _m(types.MappingProxyType), _m(collections.UserDict), _m(collections.ChainMap), _m(Fields),
    ),
    "`runtime.lines.Line`": (Example(line, ("points",), [[0.0, 0.0], [1.0, 1.0]]),),
    "anything else": (
        _o(lambda _: object()), _o(lambda _: float), _o(lambda _: len), _o(lambda _: Attributes()), _o(lambda _: ...),
        _o(lambda _: NotImplemented), _o(lambda _: Cycle(0, 0.0, {}, {}, {})), _o(lambda _: np), _o(lambda _: np.dtype("f8")),
        _o(lambda _: slice(3)), _o(lambda _: lambda: 3.0),
    ),
}  # fmt: skip
