"""The declared runs: planner, car and Supervisor in the loop, and a fault in each."""

from __future__ import annotations

import json
import os

import pytest

from closed_loop import places
from closed_loop.campaign import collect, run_all, supervise
from closed_loop.condition import KINDS, Condition, declared, every
from closed_loop.link import PlannerProcess
from closed_loop.loop import Run
from closed_loop.origin import alike, key, origins
from closed_loop.result import CONTACT, OFF, result
from closed_loop.road import Road
from closed_loop.supervising import InProcess

pytestmark = pytest.mark.acceptance

#: What the Supervisor cannot know, or does not live to say: the layer below stops the car.
BELOW = ("L-03", "T-05")
#: Of the kinds of faults, what is declared holds 24.
ONE_MORE = next(condition for condition in every() if condition.fault == "T-05")
DECLARED = [*declared(), ONE_MORE]


@pytest.fixture(scope="module", autouse=True)
def _shared() -> None:
    if not places.race_line("modena").exists():
        pytest.skip("race lines and the planner's configuration are shared beside the repository")


def test_no_declared_fault_ends_badly() -> None:
    folder = places.RUNS / key(origins())
    run_all(DECLARED, folder, jobs=min(2, os.cpu_count() or 1))
    runs = collect(DECLARED, folder)
    bad = [
        run["name"]
        for run in runs
        if run["outcome"] in (OFF, CONTACT) and (run["approved_clearance"] or 0.0) >= 0.0
    ]
    assert bad == []
    silent = [run["name"] for run in runs if run["reaction"] is None and run["fault"] not in BELOW]
    assert silent == []
    assert all(run["below"] is not None for run in runs if run["fault"] in BELOW)
    if places.RESULTS.exists():
        kept = json.loads(places.RESULTS.read_bytes())
        if alike(kept["origin"]) == alike(origins()):
            by_name = {run["name"]: run for run in kept["runs"]}
            assert runs == [by_name[run["name"]] for run in runs]


def test_each_kind_of_fault_that_breaks_no_assumption_is_in_a_run() -> None:
    assert {condition.fault for condition in DECLARED} == {
        kind.id for kind in KINDS if kind.id != "none" and not kind.beyond
    }


@pytest.mark.parametrize("fault", ["none", "P-06", "T-02"])
def test_a_run_comes_out_the_same_again_and_with_the_supervisor_in_this_process(fault: str) -> None:
    condition, road = Condition(fault, "modena", True, "fast"), Road.of("modena")
    with PlannerProcess("modena") as planner:
        runs = [
            result(condition, Run(condition, road, planner, made).go(), road)
            for made in (supervise, supervise, lambda road: InProcess(road.signal))
        ]
    assert runs[0] == runs[1]
    assert runs[0] == runs[2]
    if fault != "none":
        assert runs[0]["reaction"] is not None
        return
    assert runs[0]["outcome"] == "drives_on"
    assert runs[0]["unsafe_before"] == 0
    assert runs[0]["reaction"] is None
