"""Cycles for the Supervisor's door: two candidates on a ring, what they have in common, and what breaks the contract of a spec."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmarshal.ir.spec import FieldType, Spec

Breach = tuple[str, str, str, int | None]


@dataclass
class Cycle:
    """One cycle, in SI: candidates as columns, the rest by signal."""

    number: int
    t: float
    now: float
    driving: dict[str, Any]
    emergency: dict[str, Any]
    signals: dict[str, Any]


def ring(radius: float, count: int = 120) -> list[tuple[float, float]]:
    """Points of a circle around the origin."""
    angles = [2 * math.pi * i / count for i in range(count)]
    return [(radius * math.cos(a), radius * math.sin(a)) for a in angles]


def candidate(r: random.Random, start: float, v: float, braking: float) -> dict[str, Any]:
    """50 samples along a circle of 100 m radius; comes to a stop where it brakes."""
    t = np.arange(50) * 0.1 + r.choice([0.0, 5.0])
    since = t - t[0]
    speed = np.maximum(v - braking * since, 0.0)
    stop = np.minimum(since, v / braking if braking else math.inf)
    way = v * stop - braking * stop**2 / 2
    angle = (start + way) / 100.0
    return {
        "t": t, "s": way, "x": 100 * np.cos(angle), "y": 100 * np.sin(angle), "heading": angle + math.pi / 2,
        "kappa": np.full(50, 0.01), "v": speed, "a": np.where(speed > 0, -braking, 0.0), "grip": np.ones(50),
    }  # fmt: skip


def cycle(r: random.Random, number: int, t: float = 100.0) -> Cycle:
    """A cycle that keeps the contract of the shipped interface."""
    start, v = r.uniform(0, 600), r.uniform(5, 40)
    angle = start / 100
    ego = {
        "x": 100 * math.cos(angle),
        "y": 100 * math.sin(angle),
        "heading": angle + math.pi / 2,
        "v": v,
        "age": 0.02,
    }
    places = angle + np.array([r.uniform(0.1, 5) for _ in range(r.randint(0, 4))])
    count = len(places)
    objects = {"x": 102 * np.cos(places), "y": 102 * np.sin(places), "heading": places + math.pi / 2, "v": np.full(count, 20.0),
               "length": np.full(count, 4.7), "width": np.full(count, 2.0), "age": np.full(count, 0.05)}  # fmt: skip
    cones = r.randint(0, 2)
    obstacles = {"x": np.full(cones, 120.0), "y": np.arange(cones) * 3.0, "heading": np.zeros(cones), "length": np.full(cones, 0.5),
                 "width": np.full(cones, 0.5)}  # fmt: skip
    signals: dict[str, Any] = {"ego": ego, "objects": objects, "obstacles": obstacles}
    return Cycle(
        number, t, t + 0.03, candidate(r, start, v, 0.0), candidate(r, start, v, max(v / 4.5, 3.0)), signals
    )


def mutate(r: random.Random, given: Cycle) -> None:
    """Spoil one thing, or nearly: some of what comes out still keeps the contract."""
    wild = [math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, -0.0, 0.0, 1e12, 2.0, -1.0]
    side = r.choice([given.driving, given.emergency])
    sets = [side, given.signals["objects"], given.signals["obstacles"]]
    kind = r.randrange(12)
    if kind <= 3:
        columns = r.choice(sets)
        name = r.choice(list(columns))
        if len(columns[name]):
            columns[name] = columns[name].copy()
            columns[name][r.randrange(len(columns[name]))] = r.choice(wild)
    elif kind == 4:
        given.signals["ego"][r.choice(list(given.signals["ego"]))] = r.choice([*wild, None, "fast", True])
    elif kind == 5:
        side["t"] = r.choice(
            [side["t"][::-1], np.full(50, 1.0), np.sort(np.random.default_rng(1).normal(size=50))]
        )
    elif kind == 6:
        columns = r.choice(sets)
        name = r.choice(list(columns))
        columns[name] = r.choice(
            [columns[name][:-1], np.append(columns[name], 1.0), None, "no", columns[name].tolist()]
        )
    elif kind == 7:
        n = r.choice([0, 1, 2, 33, 65])
        columns = r.choice(sets)
        columns.update(
            {name: np.resize(column, n) if len(column) else np.ones(n) for name, column in columns.items()}
        )
    elif kind == 8:
        del (columns := r.choice([*sets, given.signals, given.signals["ego"]]))[r.choice(list(columns))]
    elif kind == 9:
        given.emergency[r.choice("xyv")] = given.emergency["x"] + r.choice([0.05, 0.2, 1e200])
    elif kind == 10:
        given.emergency["heading"] = given.emergency["heading"] + r.choice([2 * math.pi, 0.04, 0.1, math.pi])
    else:
        given.number += r.choice([0, 0, -1, 1])
        given.t += r.choice([0.0, -0.1, -0.2, 0.2, math.nan, math.inf])
        given.now += r.choice([0.0, 0.2, -0.2])


def breaches(
    spec: Spec, given: Cycle, last: Cycle | None, samples: int = 128, elements: int = 32
) -> set[Breach]:
    """Everything that breaks the contract in a cycle, the first index of each kind in each field; slow and plain."""
    found: set[Breach] = set()
    _stamp(given, last, found)
    for label, columns in (("driving", given.driving), ("emergency", given.emergency)):
        _columns(label, spec.signals["plan"].fields_, columns, samples, 2, found)
    for name in ("objects", "obstacles"):
        _columns(name, spec.signals[name].fields_, given.signals.get(name), elements, 0, found)
    ego = given.signals.get("ego")
    if ego is None:
        found.add(("missing", "ego", "", None))
    else:
        for info in spec.signals["ego"].fields_:
            if info.name not in ego and info.default is None:
                found.add(("missing", "ego", info.name, None))
            elif info.name in ego:
                value = math.nan if ego[info.name] is None else ego[info.name]
                if isinstance(value, (str, bool)):
                    found.add(("wrong_type", "ego", info.name, None))
                else:
                    _number(value, info, ("ego", info.name, None), found)
    if not any(signal in ("driving", "emergency") for _, signal, _, _ in found):
        _pair(given, found)
    return found


def _stamp(given: Cycle, last: Cycle | None, found: set[Breach]) -> None:
    if last is not None and given.number != last.number + 1:
        kind = (
            "repeated"
            if given.number == last.number
            else "skipped"
            if given.number > last.number
            else "out_of_order"
        )
        found.add((kind, "cycle", "number", None))
    if not math.isfinite(given.t):
        found.add(("not_finite", "cycle", "t", None))
        return
    if last is not None and given.t <= last.t + 1e-3:
        found.add(("repeated" if given.t >= last.t - 1e-3 else "out_of_order", "cycle", "t", None))
    if given.t - given.now > 0.01:
        found.add(("early", "cycle", "t", None))
    if given.now - given.t > 0.1:
        found.add(("stale", "cycle", "t", None))
    if last is not None and given.t - last.t > 0.15:
        found.add(("late", "cycle", "t", None))


def _columns(
    label: str, fields: tuple[FieldType, ...], given: Any, most: int, least: int, found: set[Breach]
) -> None:
    if given is None:
        found.add(("missing", label, "", None))
        return
    lengths: dict[str, int] = {}
    for info in fields:
        column = given.get(info.name)
        if column is None:
            if info.default is None or info.name in given:
                found.add(("missing", label, info.name, None))
            continue
        if isinstance(column, str):
            found.add(("wrong_type", label, info.name, None))
            continue
        lengths[info.name] = len(column)
        if len(column) > most:
            found.add(("over_capacity", label, "", most))
        for index, value in enumerate(column):
            if _number(value, info, (label, info.name, index), found):
                break
        if info.increasing:
            later = next((i for i in range(1, len(column)) if not column[i - 1] < column[i]), None)
            if later is not None:
                found.add(("not_increasing", label, info.name, later))
    if len(set(lengths.values())) > 1:
        counts = sorted(set(lengths.values()))
        found |= {("wrong_length", label, name, index) for name in lengths for index in counts}
    if lengths and min(lengths.values()) < least:
        found.add(("too_short", label, "", None))


def _number(value: float, info: FieldType, place: tuple[str, str, int | None], found: set[Breach]) -> bool:
    low = -math.inf if info.lower is None else info.lower
    high = math.inf if info.upper is None else info.upper
    if math.isfinite(value) and low <= value <= high:
        return False
    found.add(("out_of_range" if math.isfinite(value) else "not_finite", *place))
    return True


def _pair(given: Cycle, found: set[Breach]) -> None:
    d, e = given.driving, given.emergency
    if math.hypot(d["x"][0] - e["x"][0], d["y"][0] - e["y"][0]) > 0.1:
        found |= {("starts_elsewhere", "emergency", name, 0) for name in "xy"}
    if abs(math.remainder(d["heading"][0] - e["heading"][0], 2 * math.pi)) > 0.05:
        found.add(("starts_elsewhere", "emergency", "heading", 0))
    if abs(d["v"][0] - e["v"][0]) > 0.5:
        found.add(("starts_elsewhere", "emergency", "v", 0))
    if abs(e["v"][-1]) > 0.01:
        found.add(("not_at_rest", "emergency", "v", len(e["v"]) - 1))
