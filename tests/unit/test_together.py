"""Cases that are read together: which values count as floats, and when an array still says what the columns say."""

from __future__ import annotations

import random
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from trackmarshal.runtime.cases import AT_ONCE
from trackmarshal.runtime.together import floats

from support.agreement import compiled, differences, results
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec

SPEC = """
module together
signal plan : trajectory { t: s increasing, x: m, v: m/s in [-50 m/s, 90 m/s], grip: 1 default 1 }
signal objects : set of object { x: m, v: m/s }
rule slow "limits"
  for all p in plan
  require p.v <= 10 m/s * p.grip
rule apart "objects"
  for all o in objects
  for all p in plan
  require abs(o.x - p.x) >= 1 m
"""


@pytest.fixture(scope="module")
def spec() -> Spec:
    return compiled(SPEC)


def case(*speeds: float, objects: int = 0, **more: Any) -> dict[str, Any]:
    count = len(speeds)
    plan: dict[str, Any] = {
        "t": [0.1 * k for k in range(count)],
        "x": [2.5 * k for k in range(count)],
        "v": list(speeds),
    }
    others = [{"x": 4.0 + 3.0 * k, "v": 1.0} for k in range(objects)]
    return {"signals": {"plan": plan | more, "objects": others}}


@given(st.lists(st.floats()))
def test_floats_keep_every_bit(values: list[Any]) -> None:
    found = floats(values)
    assert found is not None
    assert found.tobytes() == struct.pack(f"{len(values)}d", *values)


class Subclass(float):
    pass


OTHERS = [
    1,
    True,
    None,
    "1.0",
    b"12345678",
    np.float64(1.0),
    np.float32(1.0),
    Subclass(1.0),
    (1.0,),
    [1.0],
    1j,
    object(),
]


@given(st.lists(st.floats(), max_size=4), st.sampled_from(OTHERS), st.lists(st.floats(), max_size=4))
def test_nothing_else_is_a_float(before: list[Any], other: object, after: list[Any]) -> None:
    assert floats([*before, other, *after]) is None


@given(st.lists(st.sampled_from([*OTHERS, 1.0]), min_size=1, max_size=12))
def test_mixtures_are_not_either(values: list[Any]) -> None:
    assert (floats(values) is None) == any(type(value) is not float for value in values)


def test_a_column_put_in_after_reading_counts(spec: Spec) -> None:
    evaluator = Evaluator(spec)
    cases = evaluator.read_all([case(1.0, 2.0), case(3.0, 4.0)])
    assert [r.rules["slow"].margin for r in evaluator.evaluate(cases)] == [8.0, 6.0]
    cases[1].columns["plan"]["v"] = (3.0, 11.0)
    assert [r.rules["slow"].verdict for r in evaluator.evaluate(cases)] == ["satisfied", "violated"]
    cases[1].columns["plan"]["v"] = (3.0, float("nan"))
    assert [r.rules["slow"].verdict for r in evaluator.evaluate(cases)] == ["satisfied", "undefined"]


def test_what_was_read_together_may_be_evaluated_in_any_order(spec: Spec) -> None:
    draw = random.Random(5)
    raw = [
        case(
            *(draw.uniform(0.0, 12.0) for _ in range(draw.choice((2, 3)) if block else 3)),
            objects=draw.choice((0, 2)),
            **({"grip": [1.0] * 3} if not block and draw.random() < 0.3 else {}),
        )
        for block in range(3)
        for _ in range(AT_ONCE)
    ]
    cases = Evaluator(spec).read_all(raw)
    expected = results(spec, cases, "reference")
    orders = [
        list(range(len(cases))),
        list(range(AT_ONCE)),
        list(range(5, len(cases))),
        [0, 0, 1],
        [1, 0],
        [7],
    ]
    for _ in range(4):
        orders.append(draw.sample(range(len(cases)), len(cases) - 3))
    for order in orders:
        found = results(spec, [cases[k] for k in order], "numpy")
        for one, k in zip(found, order, strict=True):
            assert not differences(one, expected[k])


def test_arrays_are_taken_and_not_stacked_again(spec: Spec) -> None:
    """As long as nothing has changed; the array is the one that reading made."""
    evaluator = Evaluator(spec)
    cases = evaluator.read_all([case(1.0, 2.0), case(3.0, 4.0)])
    together = cases[0].together
    assert together is not None
    assert together is cases[1].together
    table = evaluator.program.run(cases).batch.table("plan", "v")
    assert table.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert not table.flags.writeable
    cases[0].columns["plan"]["v"] = (1.0, 2.0)  # equal, but who knows
    assert evaluator.program.run(cases).batch.table("plan", "v").flags.writeable


def test_candidates_that_share_their_objects(spec: Spec) -> None:
    """The objects are read once; what one case makes of them is its own."""
    evaluator = Evaluator(spec)
    first, second = case(1.0, 2.0, objects=2), case(3.0, 4.0)
    second["signals"]["objects"] = first["signals"]["objects"]
    cases = evaluator.read_all([first, second])
    assert repr(cases) == repr([evaluator.read(first), evaluator.read(second)])
    assert cases[0].columns["objects"] is not cases[1].columns["objects"]
    assert cases[0].names["objects"] is not cases[1].names["objects"]
    first["signals"]["objects"][1]["x"] = 0.5
    changed = [
        result.rules["apart"].margin for result in evaluator.evaluate(evaluator.read_all([first, second]))
    ]
    assert changed == [-0.5, -0.5] != [result.rules["apart"].margin for result in evaluator.evaluate(cases)]


def test_one_list_in_two_sets() -> None:
    spec = compiled("""
module two
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad }
signal near : set of object { x: m, v: m/s }
signal far : set of object { x: m default 0 m, w: m }
rule apart "both"
  for all n in near
  for all f in far
  require n.x - f.w >= 1 m and n.v >= 0 m/s and f.x >= 0 m
""")
    shared = [{"x": 3.0, "v": 1.0, "w": 1.0}]
    evaluator = Evaluator(spec)
    raw = {"signals": {"near": shared, "far": shared}}
    cases = evaluator.read_all([raw, raw])
    assert repr(cases) == repr([evaluator.reader.read(raw)] * 2)
    assert [result.rules["apart"].margin for result in evaluator.evaluate(cases)] == [1.0, 1.0]
