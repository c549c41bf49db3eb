"""Cycles for the Supervisor: a car that follows a straight road at constant speed, and one change of a cycle at a time.

A change (`MUTATIONS`) breaks the input contract in a way that it knows: it says which fault the door has to name, and where.
Any door can be held against it.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trackmarshal.runtime.cycle import Cycle

#: Time between cycles, speed, braking; SI.
PERIOD, SPEED, BRAKING = 0.1, 20.0, 8.0
COLUMNS = ("t", "s", "x", "y", "heading", "kappa", "v", "a")
OBJECT = ("x", "y", "heading", "v", "length", "width")
OBSTACLE = ("x", "y", "heading", "length", "width")


def plan(start: float, braking: float, samples: int = 30, step: float = 0.1) -> dict[str, Any]:
    """Columns of a trajectory along the x axis; one that brakes ends at rest."""
    if braking:
        step = SPEED / braking / (samples - 1)
    t = np.arange(samples) * step
    s = SPEED * t - braking * t**2 / 2
    v = SPEED - braking * t
    if braking:
        v[-1] = 0.0
    zero = np.zeros(samples)
    return {
        "t": t, "s": s, "x": start + s, "y": zero, "heading": zero.copy(), "kappa": zero.copy(), "v": v,
        "a": np.full(samples, -braking),
    }  # fmt: skip


_TRACK = {
    "left": np.array([[float(x), 6.0] for x in range(-50, 2000, 10)]),
    "right": np.array([[float(x), -6.0] for x in range(-50, 2000, 10)]),
}


def cycle(
    number: int, objects: int = 2, obstacles: int = 1, at: float | None = None, v: float = SPEED
) -> Cycle:
    """A flawless, safe cycle, stamped number * PERIOD; `at`: where the car is, m; `v`: how fast it is, m/s."""
    start = SPEED * number * PERIOD if at is None else at
    others = np.arange(objects) * 60.0 + start + 150.0
    things = np.arange(obstacles) * 10.0 + start + 300.0
    signals = {
        "ego": {"x": start, "y": 0.0, "heading": 0.0, "v": v, "age": 0.0},
        "objects": {
            "id": [f"o{i}" for i in range(objects)], "x": others, "y": np.full(objects, 3.0), "heading": np.zeros(objects),
            "v": np.full(objects, 25.0), "length": np.full(objects, 4.5), "width": np.full(objects, 2.0),
        },
        "obstacles": {
            "id": [f"c{i}" for i in range(obstacles)], "x": things, "y": np.full(obstacles, 8.0), "heading": np.zeros(obstacles),
            "length": np.full(obstacles, 0.4), "width": np.full(obstacles, 0.4),
        },
        "track": dict(_TRACK),
    }  # fmt: skip
    return Cycle(number, number * PERIOD, plan(start, 0.0), plan(start, BRAKING), signals)


@dataclass(frozen=True)
class Expected:
    """What the door has to say: one of these faults, at this signal and field (`fields`: one of them)."""

    faults: tuple[str, ...]
    signal: str
    fields: tuple[str, ...]
    index: int | None = None


Mutation = Callable[[random.Random, Cycle], tuple[Cycle, Expected]]

#: What is no number at all, and what is no finite one.
JUNK: tuple[Any, ...] = (
    "7", b"7", [], {}, object(), True, 1j, (1.0,), float, "nan",
)  # fmt: skip
NOT_FINITE = (math.nan, math.inf, -math.inf, None, 10**400, -(10**400))
HUGE = (1e300, -1e300, 1.7e308, 1e11, -1e11)


def mutate(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    """A cycle that breaks the contract, and what the door has to say of it."""
    return rng.choice(MUTATIONS)(rng, given)


def _candidate(rng: random.Random) -> str:
    return rng.choice(("driving", "emergency"))


def _with(given: Cycle, where: str, value: Any) -> Cycle:
    """A candidate or a signal in place of another."""
    if where in ("driving", "emergency"):
        return replace(given, **{where: value})
    return replace(given, signals={**given.signals, where: value})


def _at(given: Cycle, where: str) -> Any:
    return getattr(given, where) if where in ("driving", "emergency") else given.signals[where]


def _table(rng: random.Random) -> tuple[str, tuple[str, ...]]:
    """A signal of columns, and those of its columns that are always there."""
    return rng.choice(
        [("driving", COLUMNS), ("emergency", COLUMNS), ("objects", OBJECT), ("obstacles", OBSTACLE)]
    )


def drop_column(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where, columns = _table(rng)
    field = rng.choice(columns)
    table = dict(_at(given, where))
    if rng.random() < 0.5:
        del table[field]
    else:
        table[field] = None
    return _with(given, where, table), Expected(("missing",), where, (field,))


def drop_signal(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where = rng.choice(("driving", "emergency", "ego", "objects", "obstacles", "track"))
    return _with(given, where, None), Expected(("missing",), where, ("",))


def junk_signal(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where = rng.choice(("driving", "emergency", "ego", "track", "signals", "obstacles"))
    junk = rng.choice([7, "plan", [1.0], np.zeros(3), object(), {1, 2}, b"x"])
    if where == "signals":
        return replace(given, signals=junk), Expected(("wrong_type",), "signals", ("",))
    return _with(given, where, junk), Expected(("wrong_type",), where, ("",))


def junk_column(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where, columns = _table(rng)
    field = rng.choice(columns)
    junk = rng.choice(
        ["abc", 7, {}, object(), np.zeros((3, 2)), np.array(["a", "b"]), np.zeros(3, dtype=complex), range(3), iter([])]
    )  # fmt: skip
    return _with(given, where, {**_at(given, where), field: junk}), Expected(("wrong_type",), where, (field,))


def _values(table: dict[str, Any], field: str) -> list[Any]:
    values: list[Any] = np.asarray(table[field], dtype=float).tolist()
    return values


def not_finite(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where, columns = _table(rng)
    field = rng.choice(columns)
    values = _values(_at(given, where), field)
    index = rng.randrange(len(values))
    if rng.random() < 0.5:
        values[index] = rng.choice(NOT_FINITE)
        column: Any = values
    else:
        values[index] = rng.choice((math.nan, math.inf, -math.inf))
        column = np.array(values)
    expected = Expected(("not_finite",), where, (field,), index)
    return _with(given, where, {**_at(given, where), field: column}), expected


def junk_value(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where, columns = _table(rng)
    field = rng.choice(columns)
    values = _values(_at(given, where), field)
    index = rng.randrange(len(values))
    values[index] = rng.choice(JUNK)
    expected = Expected(("wrong_type",), where, (field,), index)
    return _with(given, where, {**_at(given, where), field: values}), expected


#: Fields with a declared range, and values outside of it.
_RANGES = {
    "driving": {"heading": 1001.0, "kappa": 1.01, "v": 150.5, "a": 51.0, "t": 1.1e10, "grip": 1.6},
    "emergency": {"heading": -1001.0, "kappa": -1.01, "v": -10.5, "a": -101.0, "t": -1.1e10, "grip": -0.1},
    "objects": {"heading": 1001.0, "v": 151.0, "length": 0.05, "width": 10.5, "age": 11.0},
    "obstacles": {"heading": -1001.0, "length": 101.0, "width": 0.001},
}


def out_of_range(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where = rng.choice(tuple(_RANGES))
    field = rng.choice(tuple(_RANGES[where]))
    table = _at(given, where)
    values = _values(table, field) if field in table else [0.5] * len(table["x"])
    index = rng.randrange(len(values))
    values[index] = rng.choice(
        [_RANGES[where][field], math.copysign(rng.choice(HUGE), _RANGES[where][field])]
    )
    if field in ("length", "width", "age"):
        values[index] = _RANGES[where][field]
    column: Any = np.array(values) if rng.random() < 0.5 else values
    expected = Expected(("out_of_range",), where, (field,), index)
    return _with(given, where, {**table, field: column}), expected


def reversed_time(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where = _candidate(rng)
    table = dict(_at(given, where))
    t = table["t"].copy()
    index = rng.randrange(1, len(t))
    kind = rng.randrange(3)
    if kind == 0:
        t = t[::-1].copy()
        index = 1
    elif kind == 1:
        t[index] = t[index - 1]
    else:
        t[index] = t[index - 1] - rng.choice((5e-324, 1e-9, 3.0))  # the smallest one changes nothing
    table["t"] = t
    return _with(given, where, table), Expected(("not_increasing",), where, ("t",), index)


def wrong_length(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where, columns = _table(rng)
    table = dict(_at(given, where))
    field = rng.choice(columns)
    values = table[field]
    table[field] = values[:-1] if rng.random() < 0.5 else np.append(values, values[-1:])
    if len(values) == 1 and len(table[field]) == 0 and where == "driving":
        raise AssertionError("a trajectory has more samples")
    return _with(given, where, table), Expected(("wrong_length",), where, (field,))


def too_short(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    where = _candidate(rng)
    n = rng.randrange(2)
    table = {name: column[:n] for name, column in _at(given, where).items()}
    return _with(given, where, table), Expected(("too_short",), where, ("",))


def over_capacity(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    """One more than the capacities of default limits."""
    where, _ = _table(rng)
    n = 129 if where in ("driving", "emergency") else 33
    if where in ("driving", "emergency"):
        grown: Any = plan(float(given.driving["x"][0]), BRAKING if where == "emergency" else 0.0, n)
    else:
        own = _at(given, where)
        grown = {name: np.resize(column, n) for name, column in own.items() if name != "id"}
        grown["id"] = list(range(n))
        if rng.random() < 0.5:
            grown = [{**dict.fromkeys(own, 1.0), "id": i} for i in range(n)]
    return _with(given, where, grown), Expected(("over_capacity",), where, ("",), n - 1)


def duplicate(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    own = given.signals["objects"]
    objects = {name: np.append(column, column[-1:]) for name, column in own.items() if name != "id"}
    ids = [*own["id"], own["id"][-1]]
    return _with(given, "objects", {**objects, "id": ids}), Expected(
        ("duplicate",), "objects", ("id",), len(own["id"])
    )


def junk_id(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    own = given.signals["objects"]
    index = rng.randrange(len(own["id"]))
    ids = [*own["id"]]
    ids[index] = rng.choice([None, [], 2**70, b"o", object(), True])
    return _with(given, "objects", {**own, "id": ids}), Expected(("wrong_type",), "objects", ("id",), index)


def ego(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    own = dict(given.signals["ego"])
    field = rng.choice(("x", "y", "heading", "v"))
    kind = rng.randrange(4)
    if kind == 0:
        del own[field]
        fault = "missing"
    elif kind == 1:
        own[field] = rng.choice(NOT_FINITE)
        fault = "not_finite"
    elif kind == 2:
        own[field] = rng.choice(("7", [], {}, True, 1j, object()))
        fault = "wrong_type"
    else:
        field = rng.choice(("heading", "v", "age"))
        own[field] = rng.choice((1e9, -1e9, 1e300))
        fault = "out_of_range"
    return _with(given, "ego", own), Expected((fault,), "ego", (field,))


def border(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    track = dict(given.signals["track"])
    side = rng.choice(("left", "right"))
    points = track[side].copy()
    index: int | None = rng.randrange(len(points))
    kind = rng.randrange(6)
    if kind == 0:
        points[index, rng.randrange(2)] = rng.choice((math.nan, math.inf, -math.inf))
        fault = "not_finite"
        track[side] = points if rng.random() < 0.5 else points.tolist()
    elif kind == 1:
        track[side], fault, index = points[: rng.randrange(2)], "bad_border", None
    elif kind == 2:
        track[side], fault, index = np.zeros((2049, 2)), "over_capacity", 2048
    elif kind == 3:
        listed: list[Any] = points.tolist()
        assert index is not None
        listed[index] = rng.choice([None, 7, "ab", [1.0], [1.0, 2.0, 3.0], [1.0, "2"], {}, [True, False]])
        track[side], fault = listed, "wrong_type"
    elif kind == 4:
        track[side], fault, index = None, "missing", None
    else:
        junk = rng.choice(["left", 7, {}, np.zeros(4), np.zeros((3, 3)), object()])
        track[side], fault, index = junk, "wrong_type", None
    return _with(given, "track", track), Expected((fault,), "track", (side,), index)


def numbering(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    """A number that is not one more than the one before."""
    number = given.number
    wrong, fault = rng.choice(
        [(number - 1, "repeated"), (number - 2, "out_of_order"), (-1, "out_of_order"), (number + 1, "skipped"),
         (number + 10**6, "skipped"), (2**70, "out_of_range"), ("7", "wrong_type"), (7.0, "wrong_type"), (None, "missing"),
         (True, "wrong_type")]
    )  # fmt: skip
    return replace(given, number=wrong), Expected((fault,), "cycle", ("number",))


def stamp(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    """A stamp that is wrong; the clock is taken to show the true one."""
    t = given.t
    wrong: Any
    wrong, fault = rng.choice(
        [(t - PERIOD, "repeated"), (t - 5 * PERIOD, "out_of_order"), (-1e300, "out_of_order"), (t + 1.0, "early"),
         (1e300, "early"), (math.nan, "not_finite"), (math.inf, "not_finite"), (None, "missing"), ("7", "wrong_type"),
         ([], "wrong_type"), (True, "wrong_type")]
    )  # fmt: skip
    if fault == "repeated":
        wrong = (given.number - 1) * PERIOD
    return replace(given, t=wrong), Expected((fault,), "cycle", ("t",))


def starts_elsewhere(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    table = dict(given.emergency)
    field, by = rng.choice([("x", 0.2), ("x", -1e9), ("y", -0.2), ("y", 1e9), ("heading", 0.06), ("heading", -3.0), ("v", 0.6), ("v", -8.0)])  # fmt: skip
    column = table[field].copy()
    column[0] += by
    return _with(given, "emergency", {**table, field: column}), Expected(
        ("starts_elsewhere",), "emergency", (field,), 0
    )


def not_at_rest(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    table = dict(given.emergency)
    v = table["v"].copy()
    v[-1] = rng.choice((0.011, -0.011, 20.0, -5.0))
    return _with(given, "emergency", {**table, "v": v}), Expected(
        ("not_at_rest",), "emergency", ("v",), len(v) - 1
    )


def no_record(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    """Objects as records, one of which is none or lacks a field."""
    own = given.signals["objects"]
    count = len(own["id"])
    records: list[Any] = [
        {n: (c[i] if n == "id" else float(c[i])) for n, c in own.items()} for i in range(count)
    ]
    index = rng.randrange(count)
    if rng.random() < 0.5:
        records[index] = rng.choice([None, 7, "o", []])
        return _with(given, "objects", records), Expected(("wrong_type",), "objects", ("",), index)
    field = rng.choice(OBJECT)
    del records[index][field]
    return _with(given, "objects", records), Expected(("missing",), "objects", (field,), index)


def misspelt(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    """A name that nothing declares: of a signal, or of a field next to the one that is meant."""
    where = rng.choice(("driving", "emergency", "ego", "objects", "obstacles", "track", "signals"))
    if where == "signals":
        name = rng.choice(("Ego", "object", "plan", "zzz", "ego "))
        return replace(given, signals={**given.signals, name: given.signals["ego"]}), Expected(
            ("unknown",), where, (name,)
        )
    own = _at(given, where)
    name = rng.choice([name for name in own if name != "id"])
    wrong = rng.choice((name.upper(), name + "_", "x1", f"{name} "))
    return _with(given, where, {**own, wrong: own[name]}), Expected(("unknown",), where, (wrong,))


def wrong_track(rng: random.Random, given: Cycle) -> tuple[Cycle, Expected]:
    """Borders of a track that the places of the shipped rules are not on."""
    name = rng.choice(("Modena", "monteblanco", ""))
    track = {**given.signals["track"], "name": name}
    return _with(given, "track", track), Expected(("wrong_track",), "track", ("name",))


MUTATIONS: tuple[Mutation, ...] = (
    misspelt, drop_column, drop_signal, junk_signal, junk_column, not_finite, junk_value, out_of_range, reversed_time, wrong_length,
    too_short, over_capacity, duplicate, junk_id, ego, border, numbering, stamp, starts_elsewhere, not_at_rest, no_record,
    wrong_track,
)  # fmt: skip
