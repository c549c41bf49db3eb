"""Arrays, and runs of cycles: what the door says of one cycle it says of many, and what rules ask for is there or refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads

STAMPS = np.array([0, 100]) * 10**6
SEEN = """module m
signal objects : set of object { v: m/s }
rule slow "slow"
  for all o in objects
  require once[0 s, 1 s] o.v <= 1 m/s
"""
ROAD = """module m
signal ego : state { x: m, y: m }
signal lanes : set of lane { left: polyline, right: polyline }
rule on "on"
  for all l in lanes
  require distance_to(ego, l) <= 1 m
"""
BODY = """module m
signal plan : trajectory { t: s increasing, s: m, x: m, y: m, heading: rad, kappa: 1/m, v: m/s, a: m/s^2 }
signal track : corridor { left: polyline, right: polyline }
rule inside "inside"
  require once[0 s, 1 s] (for all p in plan: swept_footprint(p, 4 m, 2 m) inside track)
"""
PATH = """module m
signal ego : state { x: m, y: m }
signal plan : trajectory { t: s increasing, x: m, y: m }
rule near "near"
  require DEMAND
"""
LANES = [{"left": [[0, 1], [5, 1]], "right": [[0, -1], [5, -1]]}]


@pytest.mark.parametrize(("ids", "safe"), [(None, False), (["a", "b"], True)])
def test_who_is_not_named_is_not_known_again(ids: list[str] | None, safe: bool) -> None:
    """In arrays as in cycles: each of both was slow once, if they are the same."""
    speeds = np.array([[0.0, 5.0], [5.0, 0.0]])
    named = {} if ids is None else {"id": ids}
    evaluator = Evaluator(loads(SEEN))
    whole = evaluator.whole_run().step(STAMPS, {"objects": {"v": speeds, **named}})
    run = evaluator.over_run()
    for stamp, row in zip(STAMPS, speeds):
        result = run.step(evaluator.read({"t": stamp / 1e9, "signals": {"objects": {"v": row, **named}}}))
    assert bool(whole.safe[-1]) == result.safe == safe
    assert str(whole.verdicts["slow"][-1]) == result.rules["slow"].verdict


def test_lanes_are_shared_by_arrays() -> None:
    evaluator = Evaluator(loads(ROAD))
    ego = {"x": np.array([0.0, 1.0]), "y": np.array([0.0, 3.0])}
    for said in (
        evaluator.batch({"ego": ego}, {"lanes": LANES}),
        evaluator.whole_run().step(STAMPS, {"ego": ego}, {"lanes": LANES}),
    ):
        assert said.margins["on"].tolist() == [1.0, -2.0]


@pytest.mark.parametrize(
    "demand",
    ["station(ego, plan) <= 1 m", "offset(ego, plan) <= 1 m", "ego in stretch(path(plan), 0 m, 1 m)"],
)
def test_paths_of_arrays(demand: str) -> None:
    evaluator = Evaluator(loads(PATH.replace("DEMAND", demand)))
    plan = {"t": [[0.0, 1.0]] * 2, "x": [[0.0, 5.0]] * 2, "y": [[0.0, 0.0], [3.0, 3.0]]}
    ego = {"x": [2.0, 0.5], "y": [0.0, 3.0]}
    each = [
        evaluator.case({"signals": {name: {f: column[k] for f, column in of.items()} for name, of in (("plan", plan), ("ego", ego))}}).rules["near"].margin
        for k in (0, 1)
    ]  # fmt: skip
    arrays: dict[str, Any] = {
        name: {field: np.array(column) for field, column in of.items()}
        for name, of in (("plan", plan), ("ego", ego))
    }
    assert evaluator.whole_run().step(STAMPS, arrays).margins["near"].tolist() == each


@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_a_cycle_without_the_curvature_that_is_followed_is_refused(backend: str) -> None:
    evaluator = Evaluator(loads(BODY), None, backend)
    zeros = [0.0, 0.0]
    plan = {
        "t": [0.0, 1.0],
        "s": [0.0, 5.0],
        "x": [0.0, 5.0],
        "y": zeros,
        "heading": zeros,
        "v": [5.0, 5.0],
        "a": zeros,
    }
    track = {"left": [[-9, 5], [99, 5]], "right": [[-9, -5], [99, -5]]}
    run = evaluator.over_run()
    with pytest.raises(TrackmarshalError, match=r"plan\.kappa"):
        run.step(evaluator.read({"t": 0.0, "signals": {"plan": plan, "track": track}}))


@pytest.mark.parametrize(
    "demand", ["eventually[0 s, 1e300 s] ego.x <= 1 m", "count(ego.x <= 1 m, last: 1e300 s) <= 2"]
)
def test_no_time_is_as_long(demand: str) -> None:
    with pytest.raises(TrackmarshalError, match="no time is as long"):
        loads(PATH.replace("DEMAND", demand))
