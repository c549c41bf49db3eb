"""Cases that are read together: one array holds their numbers, as long as it still says what their columns say."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest

from support.agreement import compiled, differences, results
from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.door.cases import AT_ONCE
from trackmarshal.runtime.frame import Columns, Frame

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


def shown(case: Frame) -> str:
    columns = {signal: ({n: c.listed(n) for n in c.names.rows}, c.ids) for signal, c in case.columns.items()}
    return repr((columns, list(map(str, case.faults))))


def case(*speeds: float, objects: int = 0, **more: Any) -> dict[str, Any]:
    count = len(speeds)
    plan: dict[str, Any] = {
        "t": [0.1 * k for k in range(count)],
        "x": [2.5 * k for k in range(count)],
        "v": list(speeds),
    }
    others = [{"x": 4.0 + 3.0 * k, "v": 1.0} for k in range(objects)]
    return {"signals": {"plan": plan | more, "objects": others}}


def margins(evaluator: Evaluator, cases: list[Frame]) -> list[float]:
    return [result.rules["slow"].margin for result in evaluator.evaluate(cases)]


def put(case: Frame, name: str, column: list[float]) -> None:
    """Another column in a case that was read: what nobody but a test does."""
    found = case.columns["plan"]
    values = found.values.copy()
    values[found.names.rows[name]] = column
    case.columns["plan"] = Columns(found.names, values, found.flags, found.ids)


def test_a_column_put_in_after_reading_counts(spec: Spec) -> None:
    evaluator = Evaluator(spec)
    cases = evaluator.read_all([case(1.0, 2.0), case(3.0, 4.0)])
    assert margins(evaluator, cases) == [8.0, 6.0]
    put(cases[1], "v", [3.0, 11.0])
    assert [r.rules["slow"].verdict for r in evaluator.evaluate(cases)] == ["satisfied", "violated"]
    put(cases[1], "v", [3.0, math.nan])
    assert [r.rules["slow"].verdict for r in evaluator.evaluate(cases)] == ["satisfied", "undefined"]


def test_what_was_read_together_cannot_be_written_to(spec: Spec) -> None:
    for one in Evaluator(spec).read_all([case(1.0, 2.0), case(3.0, 4.0)]):
        with pytest.raises(ValueError, match="read-only"):
            one.columns["plan"].column("v")[0] = 7.0


def test_a_column_of_one_among_many_counts(spec: Spec) -> None:
    """The others are still one array; that one's number is not there."""
    evaluator = Evaluator(spec)
    cases = evaluator.read_all([case(float(k), 2.0) for k in range(5)])
    before = margins(evaluator, cases)
    put(cases[3], "v", [9.5, 2.0])
    assert margins(evaluator, cases) == [*before[:3], 0.5, before[4]]
    assert margins(evaluator, cases[::-1]) == [before[4], 0.5, *before[2::-1]]


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
    """As long as nothing has changed; the array is the one that reading made, of which each column is taken in one piece."""
    evaluator = Evaluator(spec, None, "numpy")
    cases = evaluator.read_all([case(1.0, 2.0), case(3.0, 4.0)])
    stack = cases[0].columns["plan"].stack
    assert stack is not None
    assert cases[1].columns["plan"].stack is stack
    program = evaluator.program
    assert isinstance(program, NumpyProgram)
    batch = program.run(cases).batch
    table = batch.table("plan", "v")
    assert table.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert table.flags.c_contiguous
    assert np.shares_memory(batch._stacked("plan"), stack)
    put(cases[0], "v", [1.0, 2.0])  # equal, but who knows
    assert not np.shares_memory(program.run(cases).batch._stacked("plan"), stack)


def test_cases_of_several_arrays(spec: Spec) -> None:
    """As candidates of cycles are: each was read with its like, and they take turns."""
    evaluator = Evaluator(spec, None, "numpy")
    apart = [evaluator.read_all([case(10.0 * array + k, 2.0 * k) for k in range(6)]) for array in range(3)]
    program = evaluator.program
    assert isinstance(program, NumpyProgram)
    longer = evaluator.read_all([case(90.0 + k, 2.0, 3.0) for k in range(6)])
    assert all(one.columns["plan"].stack is not None for cases in (*apart, longer) for one in cases)
    first, second, third = apart
    turns = [one for pair in zip(first, second) for one in pair]
    for cases in (
        turns, turns[::-1], turns[3:], [*first[:3], *second[3:], *first[3:]], [first[2], first[0], first[3]], [first[0], first[3], first[2]], [first[4], first[4], *second],
        [first[0], second[0]], [first[0], second[0], third[0]], [*turns, third[5]],
        [one for pair in zip(first, longer) for one in pair], [*longer, *first],
    ):  # fmt: skip
        table = program.run(cases).batch.table("plan", "v")
        for row, one in zip(table.tolist(), cases, strict=True):
            own = one.columns["plan"].column("v").tolist()
            assert row[: len(own)] == own


def test_a_flaw_in_one_case_is_not_one_of_its_neighbours(spec: Spec) -> None:
    """What is wrong with one is named in that one, wherever it stands among those that are read together."""
    flawed: list[dict[str, Any]] = [
        case(1.0, math.nan), case(1.0, 91.0), case(2.0, 1.0, t=[0.0, 0.0]), case(1.0, 2.0, grip=[1.0, math.inf]), case(1.0, 2.0, grip=[1.0]),
    ]  # fmt: skip
    alone = [list(map(str, Evaluator(spec).read(one).faults)) for one in flawed]
    assert all(alone)
    for place, one in enumerate(flawed):
        for others in (0, 1, 4):
            raw = [case(1.0, 2.0)] * others + [one] + [case(3.0, 4.0)] * others
            found = [list(map(str, frame.faults)) for frame in Evaluator(spec).read_all(raw)]
            assert found == [[]] * others + [alone[place]] + [[]] * others


def test_candidates_that_share_their_objects(spec: Spec) -> None:
    """The objects are read once; what one case makes of them is its own."""
    evaluator = Evaluator(spec)
    first, second = case(1.0, 2.0, objects=2), case(3.0, 4.0)
    second["signals"]["objects"] = first["signals"]["objects"]
    cases = evaluator.read_all([first, second])
    assert list(map(shown, cases)) == [shown(evaluator.read(first)), shown(evaluator.read(second))]
    assert cases[0].columns["objects"] is not cases[1].columns["objects"]
    first["signals"]["objects"][1]["x"] = 0.5
    changed = [
        result.rules["apart"].margin for result in evaluator.evaluate(evaluator.read_all([first, second]))
    ]
    assert changed == [-0.5, -0.5] != [result.rules["apart"].margin for result in evaluator.evaluate(cases)]


def test_one_list_in_two_sets() -> None:
    spec = compiled("""
module two
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad }
signal near : set of object { x: m, v: m/s, w: m }
signal far : set of object { x: m default 0 m, w: m, v: m/s }
rule apart "both"
  for all n in near
  for all f in far
  require n.x - f.w >= 1 m and n.v >= 0 m/s and f.x >= 0 m
""")
    shared = [{"x": 3.0, "v": 1.0, "w": 1.0}]
    evaluator = Evaluator(spec)
    raw = {"signals": {"near": shared, "far": shared}}
    cases = evaluator.read_all([raw, raw])
    assert list(map(shown, cases)) == [shown(evaluator.reader.read(raw))] * 2
    assert [result.rules["apart"].margin for result in evaluator.evaluate(cases)] == [1.0, 1.0]
