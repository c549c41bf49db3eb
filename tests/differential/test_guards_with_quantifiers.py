"""A state machine whose guard quantifies over the set of a rule's own variables: against plain Python, with three evaluators.

What was read of the machine at the depth of one variable was taken for bound by the guard's quantifier, whose variable has the same depth: a clean
check, and then a KeyError, a ValueError and a failed assertion.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import pytest

from support.supervised import BACKENDS
from trackmarshal.evaluation import Evaluator, loads

SPEC = """module a
signal objects : set of object {{ x: m, y: m }}
state m : {{ lo, hi }} for each o in objects starts lo
  becomes hi from lo when o.x * o.x > 4 m^2 and (exists b in objects: b.x > 3 m)
  becomes lo from hi when o.x < 1 m
{before}rule r "r"
  for all c0 in objects
{let}  for all c1 in objects
  require {demand}
"""
LET = "  let high = m(c0) is hi\n"
#: Read at the depth of the first variable: by a `let`, or by an earlier rule.
READ = {
    "let": ("", LET, "high"),
    "earlier rule": ('rule before "b"\n  for all c0 in objects\n  require m(c0) is hi\n', "", "m(c0) is hi"),
}
#: What is demanded of a pair, and whether that holds in the last of some cycles of (the one is high, the other one is below).
DEMANDS: dict[str, Callable[[list[tuple[bool, bool]]], bool]] = {
    "once ({high} and c1.y < 1 m)": lambda cycles: any(high and low for high, low in cycles),
    "{high} and once c1.y < 1 m": lambda cycles: cycles[-1][0] and any(low for _, low in cycles),
    "count({high} and c1.y < 1 m) <= 2": lambda cycles: sum(high and low for high, low in cycles) <= 2,
}


def told(cycles: list[list[tuple[float, float]]], holds: Callable[[list[tuple[bool, bool]]], bool]) -> list[str]:  # fmt: skip
    """The verdict of each cycle; of each object, x and y."""
    count = len(cycles[0])
    high = [False] * count
    seen: dict[tuple[int, int], list[tuple[bool, bool]]] = {
        (i, k): [] for i in range(count) for k in range(count)
    }
    verdicts = []
    for cycle in cycles:
        some = any(x > 3 for x, _ in cycle)
        high = [
            (x >= 1 if was else x > 2 and some) for was, (x, _) in zip(high, cycle, strict=True)
        ]  # fmt: skip
        for (i, k), pair in seen.items():
            pair.append((high[i], cycle[k][1] < 1))
        verdicts.append("satisfied" if all(map(holds, seen.values())) else "violated")
    return verdicts


@BACKENDS
@pytest.mark.parametrize("read", READ)
@pytest.mark.parametrize("demand", DEMANDS)
def test_it_is_what_plain_python_says(demand: str, read: str, backend: str) -> None:
    before, let, high = READ[read]
    spec = loads(SPEC.format(before=before, let=let, demand=demand.format(high=high)))
    evaluator, seen = Evaluator(spec, ["r"], backend), set()
    for seed in range(12):
        draw = random.Random(seed)
        cycles = [
            [(draw.choice([0.5, 1.5, 2.5, 4.0]), draw.choice([0.0, 0.0, 9.0])) for _ in range(2)]
            for _ in range(6)
        ]
        run, found = evaluator.over_run(), []
        for k, cycle in enumerate(cycles):
            objects: Any = [{"id": i, "x": x, "y": y} for i, (x, y) in enumerate(cycle)]
            case = {"t": 0.1 * k, "signals": {"objects": objects}}
            found.append(run.step(evaluator.read(case)).rules["r"].verdict)
        assert found == told(cycles, DEMANDS[demand]), seed
        seen |= set(found)
    assert seen == {"satisfied", "violated"}
