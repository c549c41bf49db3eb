"""Records of the car and of others: which fields they have, and in which convention."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from trackmarshal.integration import evidence
from trackmarshal.integration.found import Array, Found
from trackmarshal.integration.mapping import SPEEDS, TIMES, Column, heading_column, unit_of
from trackmarshal.integration.names import likeness


def by_names(names: list[str], fields: tuple[str, ...], plan: Mapping[str, Column]) -> dict[str, str]:
    """Field -> the name that is most like it, each name once. What a column of the plan is called, so is the field of a record, whatever else is like it."""
    called = {
        field: c.column for field, c in plan.items() if not c.column.isdigit()
    }  # a place in a row is no name
    ranked = sorted(
        (
            (-2.0 if called.get(f) == n else -likeness(n, f), i, n, f)
            for f in fields
            for i, n in enumerate(names)
        ),
        key=lambda one: one[:2],
    )
    found: dict[str, str] = {}
    for score, _, name, field in ranked:
        if -score >= 0.6 and field not in found and name not in found.values():
            found[field] = name
    return found


def stamp(cycles: list[Found]) -> Column | None:
    """The number of the cycle itself that counts its time, in a unit in which cycles are 1 ms to 10 s apart."""
    first = cycles[0].records.get("", {})
    ranked = []
    for name in first:
        values = np.array([one.records.get("", {}).get(name, math.nan) for one in cycles])
        if len(values) < 2 or not np.all(np.diff(values) > 0):
            continue
        step = float(np.median(np.diff(values)))
        unit = next((unit for unit, per in TIMES.items() if 1e-3 <= step / per <= 10.0), None)
        counts = bool(np.all(values == np.round(values)) and step == 1.0)  # the number of the cycle
        if unit is not None:
            ranked.append((likeness(name, "t") - counts, name, unit, step))
    if not ranked or max(ranked)[0] < 0.0:
        return None
    _, name, unit, step = max(ranked)
    return Column("t", name, unit, TIMES[unit], said=f"it counts on by {step:g} a cycle")


def ego(
    cycles: list[Found],
    starts: list[tuple[float, float] | None],
    way: Array,
    plan: Mapping[str, Column],
) -> tuple[str, dict[str, Column]] | None:
    """The record that is where plans begin, with its fields; `starts` are the first places of the driving trajectories, `way` their directions, `plan` their columns."""
    ranked: list[tuple[float, str, dict[str, str]]] = []
    for path in dict.fromkeys(path for one in cycles for path in one.records):  # of equals, the first
        named = by_names(
            list(next(c.records[path] for c in cycles if path in c.records)),
            ("x", "y", "heading", "v"),
            plan,
        )
        if "x" not in named or "y" not in named:
            continue
        apart = [
            math.hypot(record[named["x"]] - begin[0], record[named["y"]] - begin[1])
            for one, begin in zip(cycles, starts)
            if begin is not None
            and (record := one.records.get(path))
            and named["x"] in record
            and named["y"] in record
        ]
        if apart:
            near = 1.0 / (1.0 + float(np.median(apart)) / 5.0)
            ranked.append((near + likeness(path.rpartition(".")[2] or "ego", "ego") / 2, path, named))
    if not ranked:
        return None
    _, path, named = max(ranked, key=lambda one: one[0])
    fields = {f: Column(f, named[f], "m", said="called so") for f in ("x", "y")}
    if "heading" in named:
        values = np.array([one.records.get(path, {}).get(named["heading"], math.nan) for one in cycles])
        fields["heading"] = heading_column(
            named["heading"], evidence.turned(values, way), "the plan's beginning"
        )
    if "v" in named:
        fields["v"] = Column("v", named["v"], "m/s", said="called so")
    return path, fields


def speed_unit(values: Array, speeds: Array, column: Column, what: str = "the plan's beginning") -> Column:
    """The speed of a record against that of what it should be, m/s."""
    moving = np.isfinite(values) & np.isfinite(speeds) & (np.abs(speeds) > 2.0)
    r = evidence.ratio([values[moving]], [speeds[moving]])
    unit = unit_of(r.factor, SPEEDS) if r.sure > 0.3 else None
    if unit is None:
        return column
    return Column("v", column.column, unit, SPEEDS[unit], said=f"{r.factor:.4g} times the speed of {what}")


def placed(cycles: list[Found], plan: Mapping[str, Column]) -> dict[str, dict[str, str]]:
    """The sets of what has a place, and which of its fields is called like which, in the order of the cycles."""
    found: dict[str, dict[str, str]] = {}
    for path in dict.fromkeys(path for one in cycles for path in one.sets):
        first = next((item for one in cycles for item in one.sets.get(path, ())), {})
        fields = ("id", "x", "y", "heading", "v", "length", "width", "age")
        named = by_names([str(n) for n in first], fields, plan)
        if "x" in named and "y" in named:
            found[path] = named
    return found


def objects(
    cycles: list[Found], times: list[float], plan: Mapping[str, Column]
) -> tuple[str, dict[str, Column]] | None:
    """The set of other vehicles, with its fields: by names, and by how each moves from cycle to cycle."""
    ranked = [
        (likeness(path.rpartition(".")[2], "objects"), path, named)
        for path, named in placed(cycles, plan).items()
        if "v" in named
    ]
    if not ranked:
        return None
    _, path, named = max(ranked, key=lambda one: one[0])
    units = {"heading": "rad", "v": "m/s", "age": "s", "id": ""}
    fields = {f: Column(f, name, units.get(f, "m"), said="called so") for f, name in named.items()}
    moved = _moved(cycles, times, path, named)
    if "heading" in named and len(moved["heading"]) >= 3:
        r = evidence.turned(moved["heading"], moved["direction"])
        fields["heading"] = heading_column(named["heading"], r, "their motion")
    if len(moved["v"]) >= 3:
        fields["v"] = speed_unit(moved["v"], moved["speed"], fields["v"], "their motion")
    return path, fields


def obstacles(
    cycles: list[Found], taken: str | None, plan: Mapping[str, Column]
) -> tuple[str, dict[str, Column]] | None:
    """The set of what stands still, by its name and those of its fields."""
    for path in dict.fromkeys(path for one in cycles for path in one.sets):
        if path == taken or likeness(path.rpartition(".")[2], "obstacles") < 0.8:
            continue
        items = [item for one in cycles for item in one.sets.get(path, ())]
        named = by_names([str(n) for n in items[0]], ("id", "x", "y", "heading", "length", "width"), plan)
        if "x" in named and "y" in named:
            units = {"heading": "rad", "id": ""}
            fields = {f: Column(f, name, units.get(f, "m"), said="called so") for f, name in named.items()}
            if "heading" in named:  # nothing of what stands shows its convention
                fields["heading"] = heading_column(named["heading"], None, "")
            return path, fields
    return None


def _moved(cycles: list[Found], times: list[float], path: str, named: dict[str, str]) -> dict[str, Array]:
    """Of objects that moved more than 0.5 m from one cycle to the next: direction and speed of that, and what they say of it."""
    found: dict[str, list[float]] = {"direction": [], "speed": [], "heading": [], "v": []}
    before: dict[str, tuple[float, dict[str, Any]]] = {}
    for one, t in zip(cycles, times):
        for place, item in enumerate(one.sets.get(path, ())):
            key = repr(item.get(named.get("id", ""), place))  # which may be a list, or a record, as in ROS
            last = before.get(key)
            before[key] = (t, item)
            if last is None or not t > last[0]:
                continue
            try:
                dx, dy = (float(item[named[f]]) - float(last[1][named[f]]) for f in ("x", "y"))
                said = [float(item.get(named.get(f, ""), math.nan)) for f in ("heading", "v")]
            except (KeyError, TypeError, ValueError, OverflowError):
                continue
            if math.hypot(dx, dy) > 0.5:
                found["direction"].append(math.atan2(dy, dx))
                found["speed"].append(math.hypot(dx, dy) / (t - last[0]))
                found["heading"].append(said[0])
                found["v"].append(said[1])
    return {name: np.array(values) for name, values in found.items()}
