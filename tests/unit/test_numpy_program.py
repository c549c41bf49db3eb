"""Batches of the numpy evaluator: padding, sharing, overrides, and what is computed once for all."""

from __future__ import annotations

import math
import random
from typing import Any
from unittest import mock

import numpy as np
import pytest

from support.agreement import compiled, differences, read, results, same
from support.length import at_length
from trackmarshal.backends.numpy import places
from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.geometry import Polyline
from trackmarshal.runtime.verdict import VERDICTS

SPEC = """
module made
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m default 0, v: m/s }
signal objects : set of object { x: m, y: m, heading: rad, length: m, width: m }
signal track : corridor { left: polyline, right: polyline }
signal ego : state { x: m, y: m }
param limit : m/s = 3 m/s
param zero : 1 = 0
table most(v: m/s) -> m/s = linear clamp | 0 m/s: 5 m/s | 10 m/s: 5 m/s |
rule slow "limits"
  for all p in plan
  require p.v <= min(limit + 1 m/s, most(p.v))
rule clear "boxes"
  for all o in objects
  for all p in plan
  require swept_footprint(p, 2 m, 1 m) clear_of footprint(o)
rule near "the centre"
  require distance_to(ego, track) <= 1 m and abs(offset(ego, track)) <= 1 m
rule inverse "of zeros"
  require min(1 / zero, 5) < 4
"""


@pytest.fixture(scope="module")
def spec() -> Spec:
    return compiled(SPEC)


def case(speeds: list[Any], objects: int = 0, track: Any = None, **overrides: Any) -> dict[str, Any]:
    count = len(speeds)
    columns = {
        "t": [float(k) for k in range(count)],
        "x": [3.0 * k for k in range(count)],
        "y": [0.0] * count,
    }
    boxes = [{"x": 3.0, "y": 4.0 + k, "heading": 0.1, "length": 2.0, "width": 1.0} for k in range(objects)]
    track = track or {"left": [[0, 2], [9, 2]], "right": [[0, -2], [9, -2]]}
    plan = {**columns, "heading": [0.07 * k for k in range(count)], "v": speeds}
    return {
        "signals": {"plan": plan, "objects": boxes, "track": track, "ego": {"x": 4.0, "y": 0.5}}
    } | overrides


def agreed(spec: Spec, raw: list[dict[str, Any]]) -> list[dict[str, tuple[str, float]]]:
    """Verdicts and margins of a batch, which the reference and each case by itself confirm."""
    cases = read(spec, raw)
    batch = results(spec, cases, "numpy")
    for one, expected, alone in zip(batch, results(spec, cases, "reference"), cases, strict=True):
        assert not differences(one, expected)
        assert not differences(one, results(spec, [alone], "numpy")[0])
    return [{name: (rule.verdict, rule.margin) for name, rule in one.rules.items()} for one in batch]


def test_cases_of_all_lengths(spec: Spec) -> None:
    found = agreed(
        spec, [case([1.0, 2.0]), case([1.0, 4.5, 2.0, 3.0], 3), case([4.0, 0.0, 1.0], 1), case([1.0, 2.0], 2)]
    )
    assert [one["slow"] for one in found] == [
        ("satisfied", 2.0),
        ("violated", -0.5),
        ("satisfied", 0.0),
        ("satisfied", 2.0),
    ]
    assert [one["clear"][0] for one in found] == ["inactive", "satisfied", "satisfied", "satisfied"]


def test_a_batch_without_any_object(spec: Spec) -> None:
    assert [one["clear"][0] for one in agreed(spec, [case([1.0, 2.0]), case([1.0, 2.0, 3.0])])] == [
        "inactive",
        "inactive",
    ]


def test_overrides_of_some_cases_and_of_all(spec: Spec) -> None:
    mixed = [
        case([3.5, 3.5], params={"limit": 1.0}),
        case([3.5, 3.5]),
        case([3.5, 3.5], tables={"most": [[0, 2.0]]}),
    ]
    assert [one["slow"] for one in agreed(spec, mixed)] == [
        ("violated", -1.5),
        ("satisfied", 0.5),
        ("violated", -1.5),
    ]
    same = [case([3.5, 3.5], params={"limit": 1.0}, tables={"most": [[0, 1.0], [5, 1.0]]}) for _ in range(3)]
    assert [one["slow"] for one in agreed(spec, same)] == [("violated", -2.5)] * 3
    assert [one["slow"] for one in agreed(spec, [case([3.5, 3.5])])] == [("satisfied", 0.5)], (
        "nothing of them stays"
    )


def test_opposite_zeros_are_not_one_parameter(spec: Spec) -> None:
    """1 / 0.0 and 1 / -0.0 lie at opposite ends."""
    found = agreed(spec, [case([1.0, 1.0], params={"zero": 0.0}), case([1.0, 1.0], params={"zero": -0.0})])
    assert [one["inverse"][0] for one in found] == ["violated", "undefined"]


def test_a_closed_track_with_borders_of_unequally_many_points(spec: Spec) -> None:
    def ring(radius: float, count: int) -> list[list[float]]:
        angles = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
        return [[radius * float(np.cos(a)) + 4.0 - 10.0, radius * float(np.sin(a))] for a in angles]

    closed = {"left": ring(8.0, 40), "right": ring(12.0, 57), "closed": True}
    found = agreed(spec, [case([1.0, 2.0], track=closed), case([1.0, 2.0])])
    assert [one["near"][0] for one in found] == ["satisfied", "satisfied"]


def test_what_no_case_changes_is_computed_before(spec: Spec) -> None:
    program = NumpyProgram(spec, spec.rules)
    cases = read(spec, [case([1.0, 2.0])])
    assert "b.param('made.limit')" in "".join(program.code.writing.fixed)
    assert not any("b.param" in line for line in program.code.writing.varying)
    codes, margins = program.run(cases).verdicts
    assert (VERDICTS[codes[0, 0]], margins[0, 0]) == ("satisfied", 2.0)


def test_verdicts_of_a_run_are_those_of_its_results(spec: Spec) -> None:
    evaluator = Evaluator(spec)
    raw = [
        case([1.0, 2.0]),
        case([9.0, 2.0], 2),
        case([1.0, None], 1),
        case([1.0, 2.0], track={"left": None, "right": None}),
    ]
    cases = [evaluator.read(one) for one in raw]
    codes, margins = NumpyProgram(spec, evaluator.rules).run(cases).verdicts
    for place, rule in enumerate(evaluator.rules):
        expected = [result.rules[rule.name] for result in evaluator.evaluate(cases)]
        assert [VERDICTS[code] for code in codes[place]] == [one.verdict for one in expected]
        np.testing.assert_array_equal(margins[place], [one.margin for one in expected])


@pytest.mark.parametrize("swept", ["swept_footprint", "swept_hull"])
def test_all_margins_of_footprints_are_there_for_who_asks(swept: str) -> None:
    """A batch works out only the least margin along each trajectory; whoever asks for others gets the true ones."""
    spec = compiled(
        f"""
module made
signal plan : trajectory {{ t: s increasing, x: m, y: m, heading: rad, kappa: 1/m default 0 }}
signal track : corridor {{ left: polyline, right: polyline }}
rule inside "on the track"
  for all p in plan
  require {swept}(p, 4 m, 2 m) inside track
"""
    )
    track = {"left": [[-9, 6], [99, 4]], "right": [[-9, -6], [99, -6]]}
    raw = []
    for k in range(30):
        x = [2.0 * j for j in range(20 + k % 3)]
        plan = {"t": x, "x": x, "y": [0.1 * k - 0.01 * k * at for at in x], "heading": [0.02 * k] * len(x)}
        raw.append({"signals": {"plan": plan, "track": track}})
    agreed(spec, raw)
    cases = read(spec, raw)
    (rule,) = spec.rules
    formula = rule.formula
    assert isinstance(formula, ir.Quantify)
    run = NumpyProgram(spec, spec.rules).run(cases)
    skipped = 0
    for index, one in enumerate(cases):
        sides = CaseView(run, index).sides(formula.body, formula.axis, {})
        alone = CaseView(NumpyProgram(spec, spec.rules).run([one]), 0)
        assert sides == alone.sides(formula.body, formula.axis, {})
        for at, margin in enumerate(sides.worst):
            assert CaseView(run, index).truth(formula.body, {0: at}).margin == margin
            skipped += run.of(formula.body).worst.margin[index, at] != margin
    assert skipped > 100


#: What stands above a demand on footprints, and beside it: of any two of these, every day has each pair.
GUARDS, WHERES = ("whenever go", ""), ("where abs(o.v) <= 1 m/s", "")
BESIDES = ("{}", "p.x > 9 m or {}", "{} or p.x > 9 m", "p.x < 99 m and {}")
COMBINED = [
    (guard, where, beside) if (i + j + k) % 2 == 0 else at_length(guard, where, beside)
    for i, guard in enumerate(GUARDS)
    for j, where in enumerate(WHERES)
    for k, beside in enumerate(BESIDES)
]


@pytest.mark.parametrize(("guard", "where", "beside"), COMBINED)
def test_what_is_clear_of_others_is_worked_out_where_it_is_asked(guard: str, where: str, beside: str) -> None:
    """Where no guard above it holds, vehicles are not held against each other; whoever asks gets the true margins."""
    spec = compiled(
        f"""
module made
event go
signal plan : trajectory {{ t: s increasing, x: m, y: m, heading: rad, kappa: 1/m default 0 }}
signal objects : set of object {{ x: m, y: m, heading: rad, length: m, width: m, v: m/s }}
rule apart "of those that stand"
  {guard}
  for all o in objects {where}
  for all p in plan
  require {beside.format("swept_footprint(p, 4 m, 2 m) clear_of footprint(o)")}
"""
    )
    raw = []
    for k in range(24):
        x = [2.0 * j for j in range(3 + k % 3)]
        plan = {
            "t": x,
            "x": x,
            "y": [0.1 * k] * len(x),
            "heading": [0.02 * k] * len(x),
            "kappa": [0.01 * (k % 4)] * len(x),
        }
        speeds = [0.0, 5.0, None, math.inf, 1.0] if k % 5 else [5.0, 9.0]
        boxes = [
            {
                "x": 3.0 + 2.0 * j,
                "y": 2.0 - 0.3 * k,
                "heading": None if j == k % 7 else 0.1,
                "length": 4.0,
                "width": 2.0,
                "v": v,
            }
            for j, v in enumerate(speeds[: k % 6])
        ]
        raw.append({"signals": {"plan": plan, "objects": boxes, "go": None if k % 8 == 1 else k % 3 != 0}})
    verdicts = {verdict for one in agreed(spec, raw) for verdict, _ in one.values()}
    assert verdicts >= {"satisfied", "violated", "inactive"}
    cases = read(spec, raw)
    (rule,) = spec.rules
    formula = rule.formula
    while not isinstance(formula, (ir.SweptClear, ir.Connective)):
        assert isinstance(formula, (ir.Guarded, ir.Quantify))
        formula, above = formula.body, formula
    assert isinstance(above, ir.Quantify)
    if isinstance(formula, ir.Connective):
        formula = formula.left if isinstance(formula.left, ir.SweptClear) else formula.right
    assert isinstance(formula, ir.SweptClear)
    run = NumpyProgram(spec, spec.rules).run(cases)
    left_out = 0
    for index, one in enumerate(cases):
        alone = CaseView(NumpyProgram(spec, spec.rules).run([one]), 0)
        for o in range(one.count("objects")):
            sides = CaseView(run, index).sides(formula, above.axis, {0: o})
            assert repr(sides) == repr(alone.sides(formula, above.axis, {0: o}))
            left_out += run.of(formula).worst.margin[index, o, 0] != sides.worst[0]
    # What stands behind it in an `or` is not known yet.
    assert (left_out > 0) == bool(guard or where or not beside.startswith("{} or"))


@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-7, 2e-6, 0.5])
def test_footprints_that_touch_are_settled_where_only_the_least_margin_is_worked_out(apart: float) -> None:
    """Many trajectories at once, some of which touch the border, stand at it, or end at it, as a lattice has it."""
    spec = compiled(
        """
module made
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m default 0 }
zone z = polygon (-4 m, -4 m) (40 m, -4 m) (40 m, 4 m) (-4 m, 4 m)
rule inside "in the zone"
  for all p in plan
  require swept_footprint(p, 4 m, 2 m) inside z
"""
    )
    raw = []
    turns = (0.0, -0.0, math.pi / 2, -math.pi / 2, math.pi, -math.pi, 2 * math.pi)
    for k in range(42):
        heading, count = turns[k % 7], 12 + k % 3
        side = 1.0 if k % 7 in (0, 1, 4, 5, 6) else 2.0
        sign = 1.0 if k % 2 else -1.0
        near = sign * (4.0 - side - apart)
        match k % 4:
            case 0:  # along the border
                x, y = [3.0 + 0.5 * j for j in range(count)], [near] * count
            case 1:  # standing at it
                x, y = [5.5] * count, [near] * count
            case 2:  # ending at it
                x, y = [5.5] * count, [near * j / (count - 1) for j in range(count)]
            case _:  # turning on the spot
                x, y = [5.5] * count, [near] * count
        plan = {"t": [0.1 * j for j in range(count)], "x": x, "y": y}
        headings = [heading if k % 4 < 3 else turns[(k + j) % 7] for j in range(count)]
        raw.append({"signals": {"plan": plan | {"heading": headings}}})
    (rule,) = spec.rules
    cases = read(spec, raw)
    run = NumpyProgram(spec, spec.rules).run(cases)
    assert len(cases) == len(raw)
    codes, margins = run.verdicts
    wanted = [result.rules["inside"] for result in results(spec, cases, "reference")]
    touching = 0
    for index, one in enumerate(wanted):
        alone_codes, alone = NumpyProgram(spec, spec.rules).run([cases[index]]).verdicts
        assert VERDICTS[codes[0, index]] == VERDICTS[alone_codes[0, 0]] == one.verdict
        assert same(margins[0, index], alone[0, 0])
        touching += abs(one.margin) <= 1e-6
        if abs(one.margin) <= 1e-6:
            assert same(margins[0, index], one.margin)
            formula = rule.formula
            assert isinstance(formula, ir.Quantify)
            sides = CaseView(run, index).sides(formula.body, formula.axis, {})
            assert min(sides.worst) == one.margin
    assert touching >= 20 or apart > 1e-6


@pytest.mark.parametrize("t", [[0.0, math.nan, 0.2, 0.3], [0.0, 0.3, 0.2, 0.1], [math.inf] * 4])
def test_times_of_a_signal_that_lacks_a_field_are_not_relied_on(t: list[float]) -> None:
    """What breaks the structure of a signal keeps its times from being checked: they may be anything."""
    spec = compiled(
        """
module made
signal plan : trajectory { t: s increasing, x: m, kappa: 1/m }
rule before "made up"
  along plan as p
  require historically[0.1 s, 0.2 s] (p.x <= 3 m)
rule held "made up"
  along plan as p
  require (p.x <= 3 m) until[0.1 s, 0.2 s] (p.x >= 3 m)
rule bent "made up"
  for all p in plan
  require p.kappa <= 3 1/m
"""
    )
    cases = read(
        spec,
        [{"signals": {"plan": {"t": t, "x": [0.0] * 4}}}, {"signals": {"plan": {"t": [0.0], "x": [0.0]}}}],
    )
    assert len(cases) == 2
    for wanted, found in zip(results(spec, cases, "reference"), results(spec, cases, "numpy"), strict=True):
        assert {result.verdict for result in found.rules.values()} == {"undefined"}
        assert differences(wanted, found) == []


def test_cases_that_see_what_the_one_before_saw() -> None:
    """Projections are made once for cases in a row whose points are the same."""
    spec = compiled("""
module made
signal objects : set of object { x: m, y: m }
signal track : corridor { left: polyline, right: polyline }
signal ego : state { x: m, y: m }
rule side "on which side"
  for all o in objects
  require offset(o, track) >= 2 * offset(ego, track)
rule ahead "how far"
  for all o in objects
  require station(o, track) - station(ego, track) >= 1 m
""")
    track = {"left": [[0, 2], [5, 4], [9, 2]], "right": [[0, -2], [5, -4], [9, -2]]}
    points = [0.0, -0.0, 0.0, 4.0, 4.0, None, None, 7.5, 7.5, 7.5]
    raw = [
        {"signals": {"ego": {"x": x, "y": y}, "objects": [{"x": a, "y": y}, {"x": 5.0, "y": 9.0}][:count], "track": track}}
        for count in (1, 2)
        for a in points
        for x in (4.0, 0.0)
        for y in (1.25, 0.0, -0.0)
        for _ in range(2)
    ]  # fmt: skip
    assert len(raw) > places.FEW_CASES
    assert len({repr(one) for one in agreed(spec, raw)}) > 5
    with mock.patch.object(Polyline, "project", autospec=True, side_effect=Polyline.project) as projected:
        results(spec, read(spec, raw[:120]), "numpy")
    assert projected.call_args.args[1].size < 120 * 2 * 0.75, (
        "those that are like the one before are left out"
    )


def test_points_that_cases_share_are_projected_once() -> None:
    """Some points of a case are those of the case before, others are not; the two zeros are two points."""
    spec = compiled("""
module shared
signal ego : state { x: m, y: m }
signal objects : set of object { x: m, y: m }
signal track : corridor { left: polyline, right: polyline }
rule apart "beside others"
  for all o in objects
  require station(o, track) + offset(o, track) - offset(ego, track) >= 1 m
""")
    track = {"left": [[-9, 2], [0, 2], [9, 3]], "right": [[-9, -2], [0, -2], [9, -1]]}
    draw, raw, points = random.Random(3), [], []
    for k in range(40):
        zero = draw.choice([0.0, -0.0])
        points.append([(float(k // 2), 0.5), (zero, 1.0), (4.0, float(k // 7) / 4.0)])
        ego, *others = ({"x": x, "y": y} for x, y in points[-1])
        raw.append({"signals": {"ego": ego, "objects": others, "track": track}})
    differ = 3 + sum(repr(a) != repr(b) for now, last in zip(points[1:], points) for a, b in zip(now, last))
    cases, given = read(spec, raw), []
    whole = Polyline.project

    def project(self: Polyline, x: Any, y: Any) -> Any:
        given.append(np.size(x))
        return whole(self, x, y)

    with mock.patch.object(Polyline, "project", project):
        batch = results(spec, cases, "numpy")
    assert given == [differ]
    assert differ < 80
    for one, alone, expected in zip(batch, cases, results(spec, cases, "reference"), strict=True):
        assert not differences(one, expected)
        assert not differences(one, results(spec, [alone], "numpy")[0])


@pytest.mark.parametrize("together", [1, 2, 3, 5, 6, 500])
def test_cases_are_rated_in_order_however_many_at_once(
    spec: Spec, together: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = read(spec, [case([float(k), 1.0], k % 3) for k in range(6)])
    program = NumpyProgram(spec, spec.rules)
    whole = [(one.verdicts, list(one.margins)) for one in program.run(given).rated()]
    monkeypatch.setattr("trackmarshal.backends.numpy.program.TOGETHER", together)
    found = program.rate_all(given)
    assert [(one.verdicts, list(one.margins)) for one in found] == whole
    (slow,) = (place for place, rule in enumerate(program.rules) if rule.name == "slow")
    assert [one.explain(slow, False).margin for one in found] == [4.0 - max(float(k), 1.0) for k in range(6)]
    assert program.rate_all([]) == []
