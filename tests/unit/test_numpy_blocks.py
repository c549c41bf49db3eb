"""What only a guard asks for: numpy works it out where the guard may hold anywhere in a batch, and otherwise not; nothing shows whether it did."""

from __future__ import annotations

import itertools
import math
from typing import Any
from unittest import mock

import pytest

from support.agreement import compiled, differences, read, results
from trackmarshal.backends.numpy import logic, places
from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import Spec

SIGNALS = """
module blocks
signal plan : trajectory { t: s increasing, x: m, y: m, v: m/s }
signal objects : set of object { x: m, y: m, v: m/s }
signal ego : state { x: m, y: m }
signal track : corridor { left: polyline, right: polyline }
event go "now and then"
"""
ALL = """
rule beside "of those who drive, at every sample"
  for all o in objects where o.v > 1 m/s
  for all p in plan where p.v >= 1 m/s
  require abs(offset(p, track) - offset(o, track)) + sqrt(p.x / 1 m) * 1 m >= 2 m
"""
SOME = """
rule beside "of those who drive, one"
  exists p in plan where p.v > 1 m/s
  require abs(offset(p, track)) + sqrt(p.x / 1 m) * 1 m <= 2 m
"""
NOW = """
rule beside "only now and then"
  whenever go
  for all p in plan
  require abs(offset(p, track)) + sqrt(p.x / 1 m) * 1 m <= 4 m
"""
EITHER = """
rule beside "parts whose zeros say different things"
  for all p in plan where p.v > 1 m/s
  require abs(offset(p, track)) + sqrt(p.x / 1 m) * 1 m < 4 m or p.y > 3 m and p.x >= 1 m
"""
TRACK = {"left": [[-99, 2], [99, 2]], "right": [[-99, -2], [99, -2]]}


def case(
    speeds: list[Any], driven: float | None = 2.0, go: bool | None = False, x: float = 0.0
) -> dict[str, Any]:
    plan = {"t": [0.0, 1.0, 2.0], "x": [x, x + 2.0, x + 4.0], "y": [0.0, 0.5, 1.0], "v": [driven] * 3}
    objects = [{"x": 5.0 * k, "y": 1.0 - k, "v": v} for k, v in enumerate(speeds)]
    return {
        "signals": {"plan": plan, "objects": objects, "ego": {"x": 0.0, "y": 0.0}, "track": TRACK, "go": go}
    }


def calls(spec: Spec, raw: list[dict[str, Any]]) -> int:
    """How often points are projected for a batch, of which numpy says what the reference does."""
    program, frames = NumpyProgram(spec, spec.rules), read(spec, raw)
    with mock.patch.dict(program._varying.__globals__, project=mock.Mock(side_effect=places.project)) as made:
        program.run(frames)
        count: int = made["project"].call_count
    for one, expected in zip(results(spec, frames, "numpy"), results(spec, frames, "reference"), strict=True):
        assert not differences(one, expected)
    return count


@pytest.mark.parametrize(
    ("rule", "raw", "count"),
    [
        (ALL, [case([])], 0),
        (ALL, [case([0.0, 1.0])], 0),
        (ALL, [case([0.0]), case([]), case([1.0, -7.0])], 0),
        (ALL, [case([0.0]), case([]), case([1.0, 1.5])], 1),
        (ALL, [case([None])], 1),  # nobody knows whether it drives: it may
        (ALL, [case([math.nan, 0.0], x=-9.0)], 1),
        (ALL, [case([0.0], x=-9.0)], 0),  # the root of what is below 0 is undefined, and nobody asks for it
        (ALL, [case([3.0], x=-9.0)], 1),
        (SOME, [case([], 1.0), case([], 0.0)], 0),
        (SOME, [case([], 1.0), case([], 2.0)], 1),
        (SOME, [case([], None)], 1),
        (SOME, [case([], 1.0, x=math.nan)], 0),
        (NOW, [case([]), case([], x=math.nan)], 0),
        (NOW, [case([]), case([], go=True)], 1),
        (NOW, [case([]), case([], go=None)], 1),
        (EITHER, [case([], 1.0), case([], 0.0, x=math.nan)], 0),
        (EITHER, [case([], 1.0), case([], 3.0)], 1),
    ],
)  # fmt: skip
def test_it_is_worked_out_where_the_guard_may_hold(rule: str, raw: list[dict[str, Any]], count: int) -> None:
    assert calls(compiled(SIGNALS + rule), raw) == count


@pytest.mark.parametrize("rule", [ALL, SOME, NOW, EITHER])
@pytest.mark.parametrize(
    "raw", [[case([0.0], 1.0)], [case([0.0], 1.0), case([3.0, None], 2.0, True), case([], None, None)]]
)
def test_whoever_asks_for_what_was_not_worked_out_gets_it(rule: str, raw: list[dict[str, Any]]) -> None:
    """Every formula of a block, of every object and sample."""
    spec = compiled(SIGNALS + rule)
    program, frames = NumpyProgram(spec, spec.rules), read(spec, raw)
    run, told = program.run(frames), 0
    assert program.code.partly
    for index, frame in enumerate(frames):
        view, reference = CaseView(run, index), Reference(spec, frame)
        for node in program.code.partly:
            assert isinstance(node, ir.Formula)
            bound = {each.axis.level for each in ir.below(node) if isinstance(each, ir.Quantify)}
            axes = {
                axis.level: axis
                for axis in ir.below(node)
                if isinstance(axis, ir.Axis) and axis.level not in bound
            }
            for at in itertools.product(*(range(view.count(axis)) for axis in axes.values())):
                env = dict(zip(axes, at))
                assert repr(view.truth(node, env)) == repr(reference.truth(node, env))
                told += 1
    assert told


def test_what_others_ask_for_too_is_worked_out_whatever_holds() -> None:
    """The same point under a guard and without one; under two guards it is where either holds."""
    under = "abs(offset(p, track)) + sqrt(p.x / 1 m) * 1 m"
    spec = compiled(SIGNALS + f"""
rule fast "of those that are fast"
  for all p in plan where p.v > 5 m/s
  require {under} <= 2 m
rule slow "of those that are slow"
  for all p in plan where p.v < 1 m/s
  require {under} <= 3 m
""")  # fmt: skip
    assert [calls(spec, [case([], v)]) for v in (0.0, 3.0, 9.0)] == [1, 0, 1]
    spec = compiled(SIGNALS + ALL + """
rule any "of all"
  for all p in plan
  require offset(p, track) - offset(ego, track) <= 3 m
""")  # fmt: skip
    assert [calls(spec, [case([v])]) for v in (0.0, 9.0)] == [
        1,
        2,
    ]  # the others' points are only known in the block


@pytest.mark.parametrize(
    "before", ["", 'rule before "of others"\n  require plan.last.x * 2 + plan.last.y * 2 <= 9 m\n']
)
@pytest.mark.parametrize("driven", [0.0, 9.0])
def test_points_that_a_block_asks_for_first_stand_before_it(before: str, driven: float) -> None:
    """A number of a point is asked for under a guard, then another one of it and those of other points whatever holds."""
    spec = compiled(SIGNALS + before + """
rule fast "of those that are fast"
  for all p in plan where p.v > 5 m/s
  require station(p, track) + sqrt(p.x / 1 m) * 1 m + p.y <= 2 m
rule any "of all"
  for all p in plan
  for all o in objects
  require offset(p, track) - offset(ego, track) - offset(o, track) * 2 <= 1.25 m
""")  # fmt: skip
    raw = case([3.0, 3.0], driven)
    raw["signals"]["ego"] = {"x": 3.0, "y": -1.5}
    assert calls(spec, [raw]) == 1


SEVERAL = """
rule slow "of those who hardly drive, and where the next sample is"
  for all o in objects where o.v < 1 m/s
  for all consecutive p, q in plan
  require abs(offset(q, track) - offset(p, track)) + sqrt(p.x / 1 m) * 1 m + (p.y - o.y) >= 1 m
rule fast "of those who drive"
  for all o in objects where o.v > 2 m/s
  for all consecutive p, q in plan
  require offset(p, track) - o.x / 4 <= sqrt(p.x / 1 m) * 1 m + station(q, track) / 9
rule far "of those who are far ahead"
  for all o in objects where o.x > 8 m
  for all consecutive p, q in plan
  require offset(q, track) - station(q, track) * 2 + sqrt(p.x / 1 m) * 1 m <= o.y
"""


@pytest.mark.parametrize(
    ("speeds", "any_"),
    [([], False), ([1.5], False), ([0.5], True), ([3.0], True), ([0.5, 3.0], True), ([3.0, 0.5, 1.5], True)],
)
def test_what_several_blocks_ask_for_is_worked_out_in_each(speeds: list[float], any_: bool) -> None:
    """And nowhere else: the offset of a sample is asked for by two rules, and by three, each under a guard of its own."""
    spec = compiled(SIGNALS + SEVERAL)
    assert (calls(spec, [case(speeds, x=1.0)]) > 0) == any_
    # With others in one batch; of a root of what is negative nothing is known.
    calls(spec, [case([]), case(speeds, x=-1.0), case([1.5]), case([0.0, 5.0, 0.0]), case(speeds)])


def test_a_guard_within_a_block_belongs_to_it() -> None:
    spec = compiled(SIGNALS + """
rule paired "pairs of those who drive"
  for all o in objects where o.v > 1 m/s
  for all q in objects where q.v - o.v > sqrt(o.x / 1 m) * 1 m/s
  require abs(offset(q, track) - offset(o, track)) >= 1 m
""")  # fmt: skip
    assert [calls(spec, [case(speeds)]) > 0 for speeds in ([0.0, 0.0], [0.5, 9.0], [2.0, 9.0], [2.0, None])] == [
        False, True, True, True
    ]  # fmt: skip


def test_of_no_booleans_none_is_true_and_all_are() -> None:
    flags = [logic.TRUE[None][:0], logic.TRUE, logic.FALSE]
    assert [logic.nowhere(each) for each in (*flags, None)] == [True, False, True, False]
    assert [logic.full(each) for each in flags] == [True, True, False]


@pytest.mark.parametrize("sample", ["first", "last"])
@pytest.mark.parametrize("count", [1, 2, 7])
def test_a_sample_beside_nothing_with_elements_is_one_number_of_each_case(sample: str, count: int) -> None:
    """As a column of a table, verdicts of seven cases were seven by seven; ends of trajectories of different lengths are their own."""
    spec = compiled(f"""{SIGNALS}
rule ends "nothing but a sample"
  require plan.{sample}.v <= 3 m/s
rule apart "two of its numbers"
  require plan.{sample}.x - plan.{sample}.y <= 4 m and plan.{sample}.v >= ego.x / 1 s
""")
    cases = [case([], driven=float(n), x=float(n)) for n in range(count)]
    for n, each in enumerate(cases):
        plan = each["signals"]["plan"]
        plan["v"][-1] = 5.0 - n
        if n % 2:
            each["signals"]["plan"] = {name: column[:2] for name, column in plan.items()}
    frames = read(spec, cases)
    found = results(spec, frames, "numpy")
    for one, wanted in zip(found, results(spec, frames, "reference"), strict=True):
        assert not differences(one, wanted)
    assert len(found) == count
    assert {one.rules["ends"].verdict for one in found} <= {"satisfied", "violated"}
