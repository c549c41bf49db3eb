"""A unit or an axis that is wrong shows in how places change from cycle to cycle, where rules about one cycle see nothing."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import cycle
from pathlib import Path

import pytest

import trackmarshal as tm
from support.supervised import ROOT
from trackmarshal.cli.main import main
from trackmarshal.scenarios import recording_io
from trackmarshal.scenarios.motion import contradictions
from trackmarshal.scenarios.recording import Cycle, Recording

SHIPPED = sorted((ROOT / "specs" / "scenarios").glob("*.tmrec.jsonl*"))


@cache
def cut_in() -> Recording:
    return tm.load_recording(ROOT / "specs" / "scenarios" / "cut_in.tmrec.jsonl")


def changed(change: Callable[[Cycle], Cycle]) -> Recording:
    return replace(cut_in(), cycles=tuple(change(cycle) for cycle in cut_in().cycles))


def others(field: str, value: Callable[[float], float]) -> Callable[[Cycle], Cycle]:
    def change(cycle: Cycle) -> Cycle:
        return replace(cycle, objects=[{**each, field: value(each[field])} for each in cycle.objects])

    return change


CHANGES: dict[str, tuple[Callable[[Cycle], Cycle], str]] = {
    "stamps in ms": (lambda c: replace(c, t=1000.0 * c.t), "the car: from cycle to cycle, 0.001 times as far"),
    "stamps in ns": (lambda c: replace(c, t=1e9 * c.t), "other vehicles: from cycle to cycle, 1e-09 times"),
    "others in km/h": (others("v", lambda v: 3.6 * v), "other vehicles: from cycle to cycle, 0.28 times"),
    "others in mph": (others("v", lambda v: v / 0.44704), "other vehicles: from cycle to cycle, 0.45 times"),
    "others in degrees": (others("heading", math.degrees), "other vehicles: headings are"),
    "others drive backwards": (others("v", lambda v: -v), "other vehicles: headings are 3.1 rad off"),
    "the car from north": (
        lambda c: replace(c, ego={**c.ego, "heading": math.pi / 2 - c.ego["heading"]}),
        "the car: headings are",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_what_contradicts_the_places_is_said(name: str) -> None:
    change, said = CHANGES[name]
    found = contradictions(changed(change))
    assert any(words.startswith(said) for words in found), found


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.name)
def test_nothing_is_said_of_what_fits(path: Path) -> None:
    assert contradictions(tm.load_recording(path)) == []


def test_nothing_is_said_of_a_car_that_drives_along_minus_x() -> None:
    """From cycle to cycle, noise takes its heading over pi and back; its way leads where both point, and not half way round between them."""
    noise = cycle([0.01, -0.01])
    cycles = [
        replace(each, t=0.1 * k, ego={"x": -2.0 * k, "y": 0.0, "heading": math.remainder(math.pi + off, math.tau), "v": 20.0})
        for k, (each, off) in enumerate(zip(cut_in().cycles[:20], noise))
    ]  # fmt: skip
    assert contradictions(replace(cut_in(), cycles=tuple(cycles))) == []


def test_nothing_is_said_where_nothing_can_be() -> None:
    """Of who stands, of missing numbers, and of too few steps."""
    assert contradictions(changed(lambda c: replace(c, ego={**c.ego, "v": 0.0, "heading": math.nan}))) == []
    swaying = [
        replace(each, t=0.1 * k, ego={"x": 0.0, "y": 0.05 * (k % 2), "heading": 0.0, "v": 0.0})
        for k, each in enumerate(cut_in().cycles[:20])
    ]
    assert (
        contradictions(replace(cut_in(), cycles=tuple(swaying))) == []
    )  # noise of who stands leads anywhere
    few = changed(CHANGES["stamps in ms"][0])
    assert contradictions(replace(few, cycles=few.cycles[:5])) == []


def test_replay_says_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each cycle by itself is as safe as before: a lap in ms was replayed without a word."""
    path = tmp_path / "ms.tmrec.jsonl"
    made = changed(CHANGES["stamps in ms"][0])
    recording_io.write(replace(made, cycles=made.cycles[:8], ground_truth={}, use=()), path)
    args = ["replay", str(path), "--spec", str(ROOT / "specs" / "supervisor"), "--rule", "speed_limit"]
    assert main([*args, "--project", str(ROOT)]) == 0
    assert "are stamps in s, places in m, speeds in m/s?" in capsys.readouterr().err
    assert main([*args, "--project", str(ROOT), "--quiet"]) == 0
    assert capsys.readouterr().err == ""
