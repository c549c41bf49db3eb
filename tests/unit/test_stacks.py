"""Plain floats that are read together are what the signals' own readers make of them, case by case."""

from __future__ import annotations

import random
import struct
from collections.abc import Sequence
from typing import Any
from unittest import mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.agreement import compiled
from support.generated import RandomChoices, subject
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.door.stacks import Stacks, floats, numbers
from trackmarshal.runtime.frame import Frame


@given(
    st.integers(0, 5).flatmap(lambda n: st.lists(st.lists(st.lists(st.floats(), min_size=n, max_size=n)))),
    st.booleans(),
)
def test_floats_keep_every_bit(cases: list[list[list[float]]], tuples: bool) -> None:
    count = next((len(row) for rows in cases for row in rows), 0)
    data = [floats([tuple(row) for row in rows] if tuples else rows, count) for rows in cases]
    assert None not in data
    flat = [value for rows in cases for row in rows for value in row]
    found = numbers([one for one in data if one is not None], count)
    assert found.tobytes() == struct.pack(f"{len(flat)}d", *flat)


class Derived(float):
    pass


OTHERS = [
    1, 2**31, 2**40, -(2**62), True, None, "1.25", "g" * 9, b"12345678", np.float64(1.0), np.float32(1.0), Derived(1.0),
    (1.0,), [1.0], [], {}, 1j, object(), Ellipsis, (2**31, None),
]  # fmt: skip


@given(st.lists(st.sampled_from([*OTHERS, 1.0, -0.0]), min_size=1, max_size=12), st.integers(1, 3))
def test_nothing_else_is_a_float(values: list[Any], rows: int) -> None:
    count = len(values)
    other = [0.5] * count
    for place in range(rows):
        data = floats([values if row == place else other for row in range(rows)], count)
        assert (data is None) == any(type(value) is not float for value in values)


@given(
    st.lists(st.lists(st.sampled_from([*OTHERS, 1.0]), max_size=9), min_size=1, max_size=3), st.integers(0, 9)
)
def test_rows_of_another_length_are_none(rows: list[list[Any]], count: int) -> None:
    fits = all(len(row) == count and all(type(value) is float for value in row) for row in rows)
    assert (floats(rows, count) is not None) == fits


def test_bytes_of_a_number_are_no_mark() -> None:
    """Rows of 3 and 1 that have as many bytes as two rows of 2, and a float's mark where one would be."""
    marked = struct.unpack("<d", b"gggggggg")[0]
    assert floats([[1.0, 1.0, marked], [1.0]], 2) is None
    assert floats([[1.0, 1.0], [marked, 1.0]], 2) is not None


SPEC = """
module made
signal plan : trajectory { t: s increasing, x: m, v: km/h in [-50 m/s, 90 m/s], grip: 1 default 1, note: 1 }
signal objects : set of object { x: m, heading: deg, v: m/s default 2 m/s, age: ms default 0 s, other: 1 }
signal ego : state { x: m, v: km/h default 3 m/s }
rule one "all"
  for all p in plan
  for all o in objects
  require p.t + p.v * 1 s^2/m <= 10 s * p.grip and o.x + p.x >= 1 m and o.heading <= 3 rad and o.v + ego.v >= 0 m/s and o.age <= 1 s and ego.x >= 0 m
"""


def seen(frames: list[Frame]) -> list[Any]:
    """All that was read, bit by bit."""
    return [
        (
            {
                n: (
                    c.values.tobytes(),
                    c.values.shape,
                    c.ids,
                    c.absent,
                    c.flags is not None and c.flags.tolist(),
                )
                for n, c in frame.columns.items()
            },
            list(frame.columns),
            list(map(str, frame.faults)),
        )
        for frame in frames
    ]


def reading(spec: Spec, raw: Sequence[Any]) -> Any:
    try:
        return seen(Evaluator(spec).read_all(raw))
    except TrackmarshalError as error:
        return str(error)


def check(spec: Spec, raw: Sequence[Any]) -> tuple[Any, int]:
    """What is read, and how many signals of cases were taken together: all others are read by the readers of signals."""
    took, take = [0], Stacks.take

    def counted(self: Stacks, one: Any, place: int) -> bool:
        taken = take(self, one, place)
        took[0] += taken
        return taken

    with mock.patch.object(Stacks, "take", counted):
        found = reading(spec, raw)
    with mock.patch.object(Stacks, "take", return_value=False):
        assert found == reading(spec, raw)
    return found, took[0]


def value(r: random.Random) -> Any:
    if r.random() < 0.01:
        return r.choice([1, None, float("nan"), float("inf"), True, np.float64(2.0), "x", Derived(1.0)])
    return r.choice([0.0, -0.0, 1.5, 40.0, 1e30, r.uniform(-90, 90)])


def column(r: random.Random, count: int) -> Any:
    values = [value(r) for _ in range(count)]
    kind = r.random()
    if kind < 0.05:
        return tuple(values)
    if kind < 0.1 and {float}.issuperset(map(type, values)):
        kinds: list[Any] = [np.float64, np.float32, ">f8"]
        return np.array(values, dtype=r.choice(kinds))
    return values


def some(r: random.Random, needed: list[str], more: list[str]) -> list[str]:
    names = [n for n in needed if r.random() < 0.98] + [n for n in more if r.random() < 0.5]
    r.shuffle(names)
    return names + (["unknown"] if r.random() < 0.01 else [])


def drawn(r: random.Random) -> dict[str, Any]:
    count = r.choice((3, 3, 3, 3, 2, 1, 0))
    names = some(r, ["t", "x", "v"], ["grip", "note"])
    plan: Any = {name: column(r, count if r.random() < 0.99 else 2) for name in names}
    if r.random() < 0.8:
        plan["t"] = [0.5 * k for k in range(count)]
    if r.random() < 0.3:
        axes = (count, 1) if r.random() < 0.1 else (count,)
        plan = {name: np.arange(1.0 * count).reshape(axes) for name in names}
    size = r.choice((2, 2, 2, 0, 1))
    names = some(r, ["x", "heading"], ["v", "age", "other", "id"])
    ids = [r.choice(("a", "a", "b", 1, None)) if r.random() < 0.5 else f"o{k}" for k in range(size)]
    objects: Any = [
        {n: ids[k] if n == "id" else value(r) for n in (names if r.random() < 0.98 else names[1:])}
        for k in range(size)
    ]
    if r.random() < 0.3:
        objects = {n: ids if n == "id" else column(r, size) for n in names}
    ego = {name: value(r) for name in some(r, ["x"], ["v"])}
    signals: dict[str, Any] = {"plan": plan, "objects": objects, "ego": ego}
    for name in signals:
        if r.random() < 0.01:
            signals[name] = r.choice([None, 1, [], {}, [1], "plan"])
    return {"signals": signals}


def test_cases_read_together_are_what_the_readers_of_their_signals_make_of_them() -> None:
    spec, r = compiled(SPEC), random.Random(4)
    refused = read = taken = 0
    for _ in range(300):
        raw = [drawn(r) for _ in range(r.choice((1, 1, 2, 7)))]
        found, took = check(spec, raw)
        if isinstance(found, str):
            refused += 1
        else:
            read, taken = read + 3 * len(raw), taken + took
    assert refused > 20
    assert read > 600
    assert read / 2 < taken < read


@pytest.mark.parametrize("seed", range(20))
def test_generated_cases_too(seed: int) -> None:
    made = subject(RandomChoices(seed), geometry=True)
    spec = compiled(made.text)
    check(spec, made.cases)
    for one in made.cases:
        check(spec, [one])


def test_data_that_is_made_in_the_same_memory() -> None:
    """Each case is read before the next is asked for."""
    spec = compiled(SPEC)
    plan = {name: np.array([0.0, 1.0]) for name in ("t", "x", "v")}
    signals: dict[str, Any] = {"plan": plan, "objects": [{"x": 0.0, "heading": 0.0}], "ego": {"x": 0.0}}

    def given() -> Any:
        for k in range(5):
            plan["x"][:] = signals["objects"][0]["x"] = signals["ego"]["x"] = float(k)
            yield {"signals": signals}

    frames = Evaluator(spec).read_all(given())
    for name in ("plan", "objects", "ego"):
        assert [frame.columns[name].column("x")[0] for frame in frames] == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_cases_that_are_refused_leave_nothing_behind() -> None:
    spec = compiled(SPEC)
    evaluator = Evaluator(spec)
    good: dict[str, Any] = {
        "signals": {
            "plan": {"t": [0.0, 1.0], "x": [1.0, 2.0], "v": [3.0, 4.0]},
            "objects": [],
            "ego": {"x": 1.0},
        }
    }
    for broken in (1, {"signals": {"plan": {"x": "text"}}}):
        with pytest.raises(TrackmarshalError):
            evaluator.read_all([good, good, broken])
        assert seen(evaluator.read_all([good])) == seen(Evaluator(spec).read_all([good]))


def test_names_that_differ_again_and_again() -> None:
    """What is remembered of names does not grow with them."""
    reader = Evaluator(compiled(SPEC)).reader
    for k in range(300):
        with pytest.raises(TrackmarshalError):
            reader.read({"signals": {"ego": {"x": 0.0, f"x{k}": 0.0}}})
    assert all(len(stacks._layouts) <= 64 for stacks in reader._stacks.values())
