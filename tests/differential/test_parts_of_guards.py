"""A `where` of several parts, of which generated C asks one that takes long only where those before it may hold: what it says is the same.

Parts are true, false and undefined (a root of less than zero, nothing by nothing) in all orders, in loops and in loops within loops.
"""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import pytest

from trackmarshal.evaluation import Evaluator, loads

SPEC = """module a
signal plan : trajectory {{ t: s increasing, x: m, y: m, v: m/s }}
signal boxes : set of object {{ x: m, y: m, length: m }}
rule one "one loop"
  for all b in boxes where {box}
  require b.length < 3 m
rule two "a loop in a loop"
  for all b in boxes where {box}
  for all p in plan where {sample}
  require p.y + sqrt(abs(b.length) * 1 m) < 3 m
rule some "that there is one"
  require exists b in boxes: (exists p in plan where {sample}: (p.y < b.y and {box}))
rule except_it "what is left out"
  for all b in boxes
  except  {box}  "made up"
  require hypot(b.x, b.y) < 3 m
"""
#: Cheap and long, of a box and of a sample with it; the roots have no value below zero.
OF_BOX = ("b.x > 0 m", "sqrt(b.y * 1 m) <= 1 m", "not (sin(b.x / 1 m) > 0.5 and b.length > 1 m)")
OF_SAMPLE = (
    "p.v >= 1 m/s",
    "sqrt((p.x - b.x) * (p.x + b.y)) <= 2 m",
    "(p.x / b.x < 2 or hypot(p.x, b.y) < 1 m)",
)
NUMBERS = (-1.0, 0.0, 1.0, 2.5)


def cases() -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = []
    for number, (x, y, length) in enumerate(product(NUMBERS, NUMBERS, (0.5, 4.0))):
        other = NUMBERS[number % 3]
        boxes = [{"x": x, "y": y, "length": length}, {"x": other, "y": -x, "length": 4.5 - length}]
        plan = {
            "t": [0.0, 0.1, 0.2],
            "x": [y, 1.0, -x],
            "y": [0.0, x, 2.9],
            "v": [1.0, float(number % 2), 2.0],
        }
        found.append({"signals": {"plan": plan, "boxes": boxes[: 1 + number % 2]}})
    return found


@pytest.mark.parametrize("turn", range(3))
@pytest.mark.parametrize("few", [2, 3])
def test_all_evaluators_say_the_same(turn: int, few: int) -> None:
    parts = [(each[turn:] + each[:turn])[:few] for each in (OF_BOX, OF_SAMPLE)]
    spec = loads(SPEC.format(box=" and ".join(parts[0]), sample=" and ".join(parts[1])))
    told = {}
    for backend in ("reference", "numpy", "c"):
        evaluator = Evaluator(spec, backend=backend)
        told[backend] = [
            [(one.verdict, None if math.isnan(one.margin) else one.margin) for one in result.rules.values()]
            for result in evaluator.evaluate(evaluator.read_all(cases()))
        ]  # fmt: skip
    assert told["numpy"] == told["reference"]
    assert told["c"] == told["reference"]
    seen = {verdict for case in told["c"] for verdict, _ in case}
    assert seen >= {"satisfied", "violated", "inactive"}
    assert "undefined" in seen or OF_BOX[1] not in parts[0]
