"""The campaign is what it says: enough faults, each of which does something, and kept results that are whole."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections import Counter
from typing import Any

import pytest

from closed_loop import places
from closed_loop.adapter import times
from closed_loop.condition import FAULTS, PLACES, declared, every
from closed_loop.executing import Sensed
from closed_loop.fault import PLANNER, SUPERVISOR
from closed_loop.faults_planner import accelerations
from closed_loop.message import Columns, Message
from closed_loop.origin import alike, origins
from closed_loop.report import PAGE, page
from closed_loop.test_executing import bend
from closed_loop.test_outside import ring
from closed_loop.traffic import World


def message(number: int) -> Message:
    s = number * 2.0
    driving, emergency = bend(200.0, 20.0, 0.0, 200.0), bend(200.0, 20.0, -8.0, 25.0)
    emergency["v"][-1] = 0.0
    for plan in (driving, emergency):
        plan["t"] = times(plan["s"], plan["v"])
    ego = Sensed(s, 0.0, 0.0, 20.0)
    return Message(
        number, 0.1 * number, 0.1 * number + 0.06, driving, emergency, ego, ({"id": "a", "x": 50.0 + s},)
    )


def test_there_are_enough_faults_and_runs() -> None:
    inside = [kind for kind in FAULTS.values() if kind.id != "none" and not kind.beyond]
    assert len(inside) >= 25
    assert {kind.group for kind in inside} == {"planner", "pose", "objects", "timing"}
    runs = [run for run in every() if run.fault in {kind.id for kind in inside}]
    assert len(runs) >= 300
    assert len({run.name for run in every()}) == len(list(every()))
    assert set(Counter((run.track, run.traffic, run.place) for run in runs).values()) == {len(inside)}


def test_the_declared_runs_are_spread() -> None:
    runs = declared()
    assert len(runs) == len({run.fault for run in runs}) == 24
    assert {run.track for run in runs} == set(PLACES)
    assert Counter(run.traffic for run in runs) == {True: 12, False: 12}
    assert Counter(run.place for run in runs) == {"slow": 8, "middle": 8, "fast": 8}


@pytest.mark.parametrize("name", [name for name in FAULTS if name != "none"])
def test_every_fault_does_something(name: str) -> None:
    fault, past = FAULTS[name](), [message(i) for i in range(20)]
    poses = [Sensed(0.2 * i, 0.0, 0.0, 20.0) for i in range(300)]
    world = World(ring(), [], 10.0, 20.0, 40.0)
    new = dataclasses.replace(message(20), driving=bend(190.0, 20.0, 0.0, 200.0))
    new.driving["t"] = times(new.driving["s"], new.driving["v"])
    changed = [
        bool(fault.begins(world)),
        any(fault.sensed(who, 0.5, poses) != poses[-1] for who in (PLANNER, SUPERVISOR)),
        fault.seen(SUPERVISOR, 0.5, new.objects or ()) != new.objects,
        fault.sent(0.5, new, past) != [new],
        not fault.alive(0.5),
    ]
    assert changed.count(True) == 1, changed


@pytest.mark.parametrize("name", ["P-02", "P-05", "P-06", "P-08"])
def test_columns_that_are_changed_still_agree(name: str) -> None:
    (sent,) = FAULTS[name]().sent(0.5, message(20), [message(i) for i in range(20)])
    for plan in (sent.driving, sent.emergency):
        check(plan)


def check(plan: Columns) -> None:
    chords = [math.dist(p, q) for p, q in zip(zip(plan["x"], plan["y"]), zip(plan["x"][1:], plan["y"][1:]))]
    ways = [q - p for p, q in zip(plan["s"], plan["s"][1:])]
    assert ways == pytest.approx(chords, rel=0.01)
    assert plan["t"] == pytest.approx(times(plan["s"], plan["v"]))
    assert plan["a"][:-1] == pytest.approx(accelerations(plan["s"], plan["v"])[:-1], abs=1e-6)


@pytest.mark.skipif(not places.RESULTS.exists(), reason="no results are kept yet")
def test_kept_results_are_whole_and_on_the_page() -> None:
    text = places.RESULTS.read_bytes()
    kept = json.loads(text)
    assert [run["name"] for run in kept["runs"]] == [run.name for run in sorted(every())]
    assert PAGE.read_text(encoding="utf-8") == page(kept, hashlib.sha256(text).hexdigest())


@pytest.mark.skipif(
    not places.race_line("modena").exists(), reason="race lines are shared beside the repository"
)
def test_kept_results_are_those_of_the_rules_loop_and_planner_of_now() -> None:
    """They are evidence: whoever changes what they were made from runs them again (`make closed-loop`)."""
    kept = json.loads(places.RESULTS.read_bytes())["origin"]
    assert alike(kept) == alike(origins())
    assert alike({**kept, "rules": "others"}) != alike(kept)


def test_the_page_counts_what_ended_badly() -> None:
    runs: list[dict[str, Any]] = []
    for run in every():
        kind = FAULTS[run.fault]
        runs.append(
            {"name": run.name, "fault": run.fault, "beyond": kind.beyond, "reaction": None, "below": None, "contact": "",
             "outcome": "drives_on", "clearance": 0.5, "gap": None, "approved_clearance": 0.4, "unsafe_before": 0}
        )  # fmt: skip
    runs[5] |= {"outcome": "off_road", "clearance": -0.25}
    runs[7] |= {"reaction": {"after": 0.1, "found": ["late"]}, "unsafe_before": 2}
    text = page({"runs": runs, "origin": {"rules": "abc"}}, "def")
    assert f"- {runs[5]['name']}: 0.25 m off the road" in text
    assert "of these 1 left the road" in text
    assert "0.10 to 0.10 (1 of 12) | late 1" in text
    assert "In 1 runs a cycle was unsafe" in text
