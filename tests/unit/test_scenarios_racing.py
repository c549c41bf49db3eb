"""The duels of `rulebooks.racing`: their recordings, and what of the rules their ground truth would notice."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from support.length import at_length, shared_out
from support.shared import REPOSITORY
from trackmarshal import scenarios
from trackmarshal.cli.replay import Known, evaluator_for
from trackmarshal.scenarios.generate import generate
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.replay import replay

FOLDER = REPOSITORY / "specs" / "scenarios" / "racing"
NAMES = ("second_move", "yellow_flag", "squeezed")
RULES = ["one_move", "no_overtaking_under_yellow", "gives_back", "leaves_room"]


@cache
def kept(name: str) -> Recording:
    """What is stored of a duel; nobody here changes it."""
    return scenarios.load(FOLDER / f"{name}.tmrec.jsonl.gz")


@pytest.fixture(scope="module")
def known() -> Known:
    return Known()


@pytest.mark.parametrize(
    ("name", "params", "missed", "alarms"),
    [
        at_length("second_move", {}, "", ""),  # every day with all rules: tests/acceptance/test_scenarios.py
        # Nobody is near enough to be defended against; whoever was, is so from the first move on that is called one.
        ("second_move", {"reach": 10.0}, "rule one_move for red", ""),
        ("second_move", {"shift": 5.0}, "rule one_move for red", ""),
        at_length("yellow_flag", {}, "", ""),
        ("yellow_flag", {"give_back": 4.0}, "", "rule gives_back for green"),
        ("yellow_flag", {"give_back": 6.0}, "rule gives_back for green", ""),
        at_length("squeezed", {}, "", ""),
        (
            "squeezed",
            {"room": 1.0},
            "",
            "",
        ),  # 10 % of a width more or less is not what the planner gets wrong
        ("squeezed", {"corner": 2.0}, "rule leaves_room of driving for blue", ""),
        ("squeezed", {"overlap": 0.99}, "rule leaves_room of driving for blue", ""),
    ],
)
def test_the_ground_truth_notices_other_rules(
    name: str, params: dict[str, float], missed: str, alarms: str, known: Known
) -> None:
    recording = kept(name)
    recording = replace(recording, params={**recording.params, **params})
    spec, more = REPOSITORY / "specs" / "supervisor", [REPOSITORY / "specs" / "rulebooks"]
    evaluator = evaluator_for(recording, spec, [], REPOSITORY, RULES, "numpy", FOLDER, more, known)
    outcome = replay(recording, evaluator, brief=True)
    assert [truth.kind for truth in outcome.truths if truth.missed] == ([missed] if missed else [])
    assert [truth.kind for truth in outcome.truths if truth.false_alarms] == ([alarms] if alarms else [])
    assert not outcome.uncovered


@pytest.mark.parametrize("name", shared_out(NAMES, 3))
def test_the_duels_are_what_their_declarations_generate(name: str) -> None:
    made = generate(os.fspath(FOLDER / f"{name}.yaml"))
    stored = kept(name)
    assert made.ground_truth == stored.ground_truth
    assert made.always == stored.always
    assert [c.t for c in made.cycles] == [c.t for c in stored.cycles]
    assert _same([c.ego for c in made.cycles], [c.ego for c in stored.cycles])
    assert _same([c.candidates for c in made.cycles], [c.candidates for c in stored.cycles])
    assert _same([(c.objects, c.more) for c in made.cycles], [(c.objects, c.more) for c in stored.cycles])


def _same(one: Any, other: Any) -> bool:
    """Equal but for the last digits of numbers, which the platforms' sines may round differently."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[k], other[k]) for k in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(_same(a, b) for a, b in zip(one, other))
    return abs(one - other) <= 2e-6 if isinstance(one, float) else bool(one == other)
