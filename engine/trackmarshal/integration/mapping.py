"""Which column stands for which field, by its name and by its numbers, and how it is converted."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmarshal.integration import evidence
from trackmarshal.integration.evidence import Ratio, Timelines, Turned
from trackmarshal.integration.found import Array
from trackmarshal.integration.names import likeness
from trackmarshal.trajectories.along import wrap

#: Units by how many of them are one in SI.
SPEEDS = {"m/s": 1.0, "km/h": 3.6, "mph": 2.2369362920544, "kn": 1.9438444924406}
TIMES = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
LENGTHS = {"m": 1.0, "cm": 1e2, "mm": 1e3, "km": 1e-3}
ACCELERATIONS = {"m/s^2": 1.0, "g": 1 / 9.81}
CURVATURES = {"1/m": 1.0, "1/km": 1e3}
#: How near a factor has to be to one of a unit, relative.
NEAR = 0.04
#: What is called so much like a field is taken for it where numbers say nothing.
NAMED = 0.8
#: What is said where numbers tell too little.
UNSURE = "; too little turns or changes to be sure of unit, sign and direction"
ZEROS = (("+x", 0.0), ("+y", math.pi / 2), ("-x", math.pi), ("-y", -math.pi / 2))


@dataclass(frozen=True, slots=True)
class Column:
    """A field's column: SI = sign / per * value, of a heading `zero`, `clockwise`, `degrees`. said: why it is taken for it, in words.

    problem: what about its numbers contradicts its name, or the contract; empty where nothing does.
    """

    field: str
    column: str
    unit: str
    per: float = 1.0
    sign: float = 1.0
    zero: str | float = "+x"
    clockwise: bool = False
    degrees: bool = False
    said: str = ""
    problem: str = ""

    @property
    def converted(self) -> bool:
        """Whether values have to be converted."""
        return self.per != 1.0 or self.sign != 1.0 or self.zero != "+x" or self.clockwise or self.degrees

    @property
    def words(self) -> str:
        """The conversion."""
        if self.field == "heading":
            to = self.zero if isinstance(self.zero, str) else f"{self.zero:.4g} rad from +x"
            unit = "degrees" if self.degrees else "rad"
            return f"in {unit}, 0 along {to}, {'clockwise' if self.clockwise else 'counter-clockwise'}"
        if not self.unit:
            return "as it is"
        return f"in {self.unit}" + (", with the other sign" if self.sign < 0 else "")

    def code(self, source: str) -> str:
        """Python that converts."""
        if self.field == "heading":
            given = [f"zero={self.zero!r}"] if self.zero != "+x" else []
            given += ["clockwise=True"] if self.clockwise else []
            given += ["degrees=True"] if self.degrees else []
            return f"tm.heading_from({', '.join([source, *given])})" if given else source
        factor = self.sign / self.per
        return source if factor == 1.0 else f"{source} * {factor!r}"

    def convert(self, values: Any) -> Any:
        """The same, done: an array, or a number."""
        if self.field == "heading":
            begin = dict(ZEROS)[self.zero] if isinstance(self.zero, str) else self.zero
            unit = math.pi / 180 if self.degrees else 1.0
            turned = begin + (-unit if self.clockwise else unit) * np.asarray(values, dtype=np.float64)
            listed = [wrap(float(z)) for z in np.atleast_1d(turned)]
            return np.array(listed) if np.ndim(values) else listed[0]
        factor = self.sign / self.per
        return (
            values if factor == 1.0 else np.asarray(values) * factor if np.ndim(values) else values * factor
        )


def columns(timelines: Timelines) -> dict[str, Column]:
    """The fields of `plan` that timelines of one kind have, as far as names and numbers tell."""
    names = list(timelines[0])
    found: dict[str, Column] = {}
    left = list(names)

    def take(column: Column) -> None:
        found[column.field] = column
        left.remove(column.column)

    pair = _places(timelines, names)
    if pair is None:
        return found
    (x, y), said = pair
    take(Column("x", x, "m", said=said))
    take(Column("y", y, "m", said=said))
    ds = evidence.chords(timelines, x, y)
    for column in _grown(timelines, left, ds):
        take(column)
    for column in _speed(timelines, left, ds):
        take(column)
    heading = _heading(timelines, left, evidence.directions(timelines, x, y))
    if heading is not None:
        take(heading)
    kappa = _curvature(timelines, left, x, y)
    if kappa is not None:
        take(kappa)
    v = found.get("v")
    acceleration = None if v is None else _acceleration(timelines, left, v, ds)
    if acceleration is not None:
        take(acceleration)
    return found


def best(names: Iterable[str], score: Mapping[str, float], least: float = 0.5) -> str | None:
    """The column with the greatest score of at least `least`; the first of equals."""
    ranked = [name for name in names if score[name] >= least]
    return max(ranked, key=score.__getitem__, default=None)


def unit_of(factor: float, units: Mapping[str, float]) -> str | None:
    """The unit of which so many are one in SI."""
    fitting = [name for name, per in units.items() if abs(abs(factor) / per - 1.0) <= NEAR]
    return fitting[0] if fitting else None


def _places(timelines: Timelines, names: list[str]) -> tuple[tuple[str, str], str] | None:
    """x and y: called so, and another column grows by their distances, or is a speed that over a time gives them."""
    ranked: list[tuple[float, tuple[str, str], str]] = []
    some = timelines[:8]
    growing = {name: evidence.grown(some, name) for name in names if _grows(some, name)}
    products = {(v, t): evidence.covered(some, v, t) for t in growing for v in names if v != t}
    for i, p in enumerate(names):
        for q in names[i + 1 :]:
            straight, swapped = (likeness(a, "x") + likeness(b, "y") for a, b in ((p, q), (q, p)))
            x, y = (q, p) if swapped > straight else (p, q)
            ds = evidence.chords(some, x, y)
            if not any((step > evidence.SHORT).sum() > 2 for step in ds):
                continue
            grown = max(
                (
                    (_sure(evidence.as_distances(by, ds), LENGTHS), r)
                    for r, by in growing.items()
                    if r not in (p, q)
                ),
                default=(0.0, ""),
            )
            timed = max(
                (
                    (_sure(evidence.as_distances(way, ds), _PRODUCTS), f"{v} over {t}")
                    for (v, t), way in products.items() if not {v, t} & {p, q}
                ),
                default=(0.0, ""),
            )  # fmt: skip
            named = max(straight, swapped) / 2
            said = f"called so ({named:.0%})" if named > 0.5 else "by their numbers"
            if max(grown, timed)[0] > 0.5:
                said += f"; the distances are those of `{max(grown, timed)[1]}`"
            ranked.append((named + grown[0] + timed[0], (x, y), said))
    ranked.sort(key=lambda one: -one[0])
    return (ranked[0][1], ranked[0][2]) if ranked and ranked[0][0] >= 0.75 else None


#: Units of a speed times a time.
_PRODUCTS = {f"{v} {t}": a * b for v, a in SPEEDS.items() for t, b in TIMES.items()}


def _sure(r: Ratio, units: Mapping[str, float]) -> float:
    """How sure a ratio is, where it is one of a unit."""
    return r.sure if r.factor > 0 and unit_of(r.factor, units) else 0.0


def _grows(timelines: Timelines, name: str) -> bool:
    """Whether a column never goes back, and goes on somewhere."""
    return all(np.all(np.diff(one[name]) >= 0) for one in timelines) and any(
        np.any(np.diff(one[name]) > 0) for one in timelines
    )


def _grown(timelines: Timelines, left: list[str], ds: list[Array]) -> list[Column]:
    """s."""
    ratios = {name: evidence.grows_with(timelines, name, ds) for name in left}
    score = {
        name: likeness(name, "s") / 2
        + (r.sure if unit_of(r.factor, LENGTHS) and r.factor > 0 and _grows(timelines, name) else 0.0)
        for name, r in ratios.items()
    }
    name = best(left, score, 0.7)
    if name is None:
        return []
    unit = unit_of(ratios[name].factor, LENGTHS)
    assert unit is not None
    return [Column("s", name, unit, LENGTHS[unit], said=f"it grows by {_times(ratios[name])} the distance")]


def _speed(timelines: Timelines, left: list[str], ds: list[Array]) -> list[Column]:
    """v and t, which explain each other; one of them by its name alone."""
    ranked: list[tuple[float, str, str, Ratio, str, str]] = []
    for t in [name for name in left if _grows(timelines, name)]:
        for v in [name for name in left if name != t]:
            r = evidence.speed_and_time(timelines, v, t, ds)
            for speed, per_speed in SPEEDS.items():
                for time, per_time in TIMES.items():
                    if r.sure > 0.5 and r.factor > 0 and abs(r.factor / (per_speed * per_time) - 1) <= NEAR:
                        named = (likeness(v, "v") + likeness(t, "t")) / 2
                        ranked.append((r.sure + named, v, t, r, speed, time))
    if ranked:
        _, v, t, r, speed, time = max(ranked, key=lambda one: one[0])
        said = f"`{v}` in {speed} over `{t}` in {time} is the distance, to {r.stray:.1%}"
        return [Column("t", t, time, TIMES[time], said=said), Column("v", v, speed, SPEEDS[speed], said=said)]
    found: list[Column] = []
    for field, unit in (("t", "s"), ("v", "m/s")):
        likely = {name: likeness(name, field) * (field != "t" or _grows(timelines, name)) for name in left}
        name = best([n for n in left if n not in [c.column for c in found]], likely, NAMED)
        if name is not None:
            found.append(Column(field, name, unit, said="called so"))
    if len(found) == 2:
        r = evidence.speed_and_time(timelines, found[1].column, found[0].column, ds)
        problem = (
            f"`{found[1].column}` over `{found[0].column}` is {_times(r)} the distance (stray {r.stray:.0%}): "
            "they do not belong together, in any unit that is known here"
        )
        if r.sure > 0.5 and r.factor < 0:
            problem = (
                f"`{found[1].column}` over `{found[0].column}` is {_times(r)} the distance: it is driven backwards, or a speed ahead is negative; "
                "take cycles that are driven ahead, since a heading, too, is told from the way that is travelled"
            )
        found[1] = Column("v", found[1].column, "m/s", said="called so", problem=problem if r.steps else "")
    return found


def _heading(
    timelines: Timelines, left: list[str], ways: list[tuple[evidence.Steps, Array]]
) -> Column | None:
    turns = {name: evidence.heading(timelines, name, ways) for name in left}
    score = {
        name: likeness(name, "heading") / 2
        + (
            max(0.0, (r.fit - 0.9) * 10)
            if r is not None and (r.told or likeness(name, "heading") > 0.5)
            else 0.0
        )
        for name, r in turns.items()
    }
    name = best(left, score, 0.45)
    if name is None:
        return None
    return heading_column(name, turns[name], "the path")


def heading_column(name: str, r: Turned | None, what: str) -> Column:
    """A heading with the convention that its numbers show."""
    if r is None:
        return Column("heading", name, "rad", said=f"called so{UNSURE}")
    if r.fit < 0.97:
        problem = f"`{name}` does not follow the direction of {what} in any convention (median {r.stray:.2g} rad off the best one)"
        return Column("heading", name, "rad", said="called so", problem=problem)
    zero: str | float = next(
        (called for called, begin in ZEROS if abs(math.remainder(r.begin - begin, math.tau)) < 0.06), r.begin
    )
    unsure = "" if r.told else UNSURE
    return Column(
        "heading", name, "deg" if r.degrees else "rad", zero=zero, clockwise=r.clockwise, degrees=r.degrees,
        said=f"the direction of {what}, to {r.stray:.2g} rad{unsure}",
    )  # fmt: skip


def _curvature(timelines: Timelines, left: list[str], x: str, y: str) -> Column | None:
    ratios = {name: evidence.curvature(timelines, name, x, y) for name in left}
    return _by_ratio("kappa", left, ratios, CURVATURES, "the curvature of the path")


def _acceleration(timelines: Timelines, left: list[str], v: Column, ds: list[Array]) -> Column | None:
    ratios = {
        name: (r := evidence.acceleration(timelines, name, v.column, ds))._replace(factor=r.factor * v.per**2)
        for name in left
    }
    return _by_ratio("a", left, ratios, ACCELERATIONS, "d(v^2) / (2 ds)")


def _by_ratio(
    field: str, left: list[str], ratios: dict[str, Ratio], units: Mapping[str, float], what: str
) -> Column | None:
    """The column that is called so, or is a multiple of what it should be, by a unit and a sign."""

    def fits(r: Ratio) -> float:
        return max(0.0, 1.0 - r.stray / 0.5) if r.steps >= 5 and unit_of(r.factor, units) else 0.0

    score = {name: likeness(name, field) / 2 + fits(r) for name, r in ratios.items()}
    name = best(left, score, 0.4)
    if name is None:
        return None
    r = ratios[name]
    first = next(iter(units))
    unit = unit_of(r.factor, units)
    if fits(r) > 0.3 and unit is not None:
        said = f"{_times(r)} {what}"
        return Column(field, name, unit, units[unit], math.copysign(1.0, r.factor), said=said)
    if r.steps < 5:
        return Column(field, name, first, said=f"called so{UNSURE}")
    if likeness(name, field) < NAMED:
        return None
    problem = f"`{name}` is {_times(r)} {what} (stray {r.stray:.0%}): it is not that, in any unit that is known here"
    return Column(field, name, first, said="called so", problem=problem)


def _times(r: Ratio) -> str:
    return f"{r.factor:.4g} times"
