"""The planner in our environment is the planner of the recordings: it plans the same, sample by sample."""

from __future__ import annotations

import gzip
import json
import math
from typing import Any

import pytest

from closed_loop import places
from closed_loop.link import PlannerFailed, PlannerProcess
from closed_loop.loop import PACE
from support.shared import shared

pytestmark = pytest.mark.acceptance

#: Pace of the recordings: the limits themselves, the planner's own emergency trajectory, its example's preferences.
RECORDED = {
    **PACE, "along": 13.0, "across": 13.0, "own_emergency": True, "wanted": ["right", "left", "straight", "follow"],
}  # fmt: skip
CYCLES = 150


def theirs(heading: float) -> float:
    return math.remainder(heading - math.pi / 2, math.tau)


@pytest.mark.parametrize("name", ["modena", "berlin", "modena_cars"])
def test_it_plans_what_was_recorded(name: str) -> None:
    with gzip.open(shared("data", "planner", f"{name}.tmrec.jsonl.gz"), "rt", encoding="utf-8") as lines:
        head, *rows = (json.loads(line) for line in (next(lines) for _ in range(CYCLES + 1)))
    with PlannerProcess(name.split("_", maxsplit=1)[0]) as planner:
        planner.ask("run", pace={**RECORDED, "drive": head["tables"]["ax_max"]})
        ego = rows[0]["ego"]
        planner.ask("start", x=ego["x"], y=ego["y"], heading=theirs(ego["heading"]), v=0.0)
        for row in rows:
            ego = row["ego"]
            objects = [{**o, "heading": theirs(o["heading"])} for o in row["objects"]]
            planned = planner.ask(
                "plan", t=row["t"], ego={**ego, "heading": theirs(ego["heading"])}, objects=objects
            )
            for candidate in ("driving", "emergency"):
                same(planned[candidate], row["candidates"][candidate])
        planner.ask("end")


def same(planned: dict[str, Any], recorded: dict[str, Any]) -> None:
    count = min(len(recorded["v"]), len(planned["v"]))
    if recorded["v"][0] == 0.0 and count == 2:  # standing: recorded as two samples in one place
        count = 1
    for ours, theirs_ in (("s", "s"), ("x", "x"), ("y", "y"), ("v", "v")):
        assert planned[ours][:count] == pytest.approx(recorded[theirs_][:count], abs=1e-6)


def test_a_planner_that_raises_is_told_from_one_that_plans() -> None:
    if not places.race_line("modena").exists():
        pytest.skip("the race lines are shared beside the repository")
    with PlannerProcess("modena") as planner:
        planner.ask("run", pace=PACE)
        with pytest.raises(PlannerFailed):
            planner.ask("plan", t=0.0, ego={}, objects=[])
        planner.ask("end")
        assert planner.ask("run", pace=PACE) == {}
        planner.ask("end")
