"""What asks state machines for numbers comes to the same for many cycles at once, for one at a time, and by definition."""

from __future__ import annotations

import math

import pytest

from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import leaves, recalled, recalls

SPEC = """module m
signal plan : trajectory { t: s increasing, x: m, y: m }
signal objects : set of object { x: m, y: m, v: m/s }
state near : { no, yes } for each o in objects starts no
  becomes yes from no when o.x > 0 m
    remember entry = o.v
  becomes no from yes when o.x < -1 m
rule f "" for all o in objects where near(o) is yes for all p in plan where p.x > o.x
  require (if near(o).entry > 0 m/s then p.y else sqrt(p.y * 1 m) * near(o).entry / (1 m/s)) >= o.y / 4
"""


def _recalling(spec: object) -> ir.Formula:
    stack: list[ir.Formula] = [spec.rules[0].formula]  # type: ignore[attr-defined]
    found = []
    while stack:
        node = stack.pop()
        if recalls(node):
            found.append(node)
        else:
            stack += [child for child in ir.operands(node) if isinstance(child, ir.Formula)]
    (one,) = found
    return one


@pytest.mark.parametrize(
    "values", [[1.0], [3.0, -2.0, 0.0, math.nan], [0.5 * k - 2.0 for k in range(9)] + [math.nan, math.inf]]
)
def test_as_the_reference(values: list[float]) -> None:
    spec = loads(SPEC)
    evaluator = Evaluator(spec)
    frames = []
    for k in range(11):
        count, samples = k % 3 + 1, k % 4 + 2
        plan = {
            "t": [0.1 * i for i in range(samples)],
            "x": [math.sin(7 * k + i) * 3 for i in range(samples)],
            "y": [math.cos(5 * k + 2 * i) * 3 for i in range(samples)],
        }
        objects = [
            {"id": f"o{i}", "x": math.sin(3 * k + i), "y": 4 * math.cos(k + i), "v": float(i)}
            for i in range(count)
        ]
        frames.append(evaluator.read({"id": k, "t": 0.1 * k, "signals": {"plan": plan, "objects": objects}}))
    node = _recalling(spec)
    (kept,) = recalled(node)
    (level,) = {
        part.level for part in ir.below(node) if isinstance(part, ir.Axis) and part.signal == "objects"
    }
    run = NumpyProgram(spec, [], tuple(leaves(spec.rules[0].formula))).run(frames)  # type: ignore[arg-type]
    seen = set()
    for index, frame in enumerate(frames):
        for value in values[index % len(values) :] + values[: index % len(values)]:
            for place in range(frame.count("objects")):
                wanted = Reference(spec, frame).recalled(node, {level: place}, {kept: value})
                found = CaseView(run, index).recalled(node, {level: place}, {kept: value})
                assert repr(found) == repr(wanted)
                seen.add(wanted.verdict)
    assert seen >= {"satisfied", "violated"}
    assert ("undefined" in seen) == any(not v > 0 for v in values)


OF_THE_RUN_ALONE = """module m
signal ego : state { x: m, v: m/s }
signal objects : set of object { x: m }
state near : { no, final yes } for each o in objects starts no
  becomes yes from no when o.x - ego.x < 10 m
    remember entry = ego.v
rule f "" for all o in objects where near(o) is yes
  require ego.v <= near(o).entry - 1 m/s
"""


@pytest.mark.parametrize("size", [1, 3])
def test_what_asks_for_nothing_else_of_the_element_has_a_value_of_it(size: int) -> None:
    spec = loads(OF_THE_RUN_ALONE)
    node = _recalling(spec)
    (kept,) = recalled(node)
    objects = [{"id": "a", "x": 5.0}, {"id": "b", "x": 50.0}]
    frames = [
        Evaluator(spec).read(
            {"id": k, "t": 0.1 * k, "signals": {"ego": {"x": 0.0, "v": 4.0 + k}, "objects": objects}}
        )
        for k in range(size)
    ]
    run = NumpyProgram(spec, [], tuple(leaves(spec.rules[0].formula))).run(frames)  # type: ignore[arg-type]
    for index, frame in enumerate(frames):
        for place in range(2):
            wanted = Reference(spec, frame).recalled(node, {0: place}, {kept: 6.0})
            assert repr(CaseView(run, index).recalled(node, {0: place}, {kept: 6.0})) == repr(wanted)
