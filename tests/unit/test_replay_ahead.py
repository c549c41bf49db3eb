"""What is evaluated ahead of a replay, and what is taken from what was judged, changes nothing: decisions, verdicts, margins, what is said of cycles."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from support.length import at_length
from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.over_run import program
from trackmarshal.backends.over_run.streaming import Streaming
from trackmarshal.cli.replay import evaluator_for
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.scenarios import load
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.supervised import supervised

ROOT = Path(__file__).resolve().parents[2]
RULES = [
    "one_move",
    "no_overtaking_under_yellow",
    "gives_back",
    "leaves_room",
    "speed_limit",
    "obstacle_collision",
]
RACING = ROOT / "specs" / "scenarios" / "racing"


@cache
def recorded(name: str) -> Recording:
    """Some cycles of a shipped recording, in which the door refuses two, and a candidate is missing."""
    found = load(str(RACING / f"{name}.tmrec.jsonl.gz"))
    cycles = list(found.cycles[40:75] if name == "yellow_flag" else found.cycles[:30])
    cycles[7] = replace(cycles[7], ego={**cycles[7].ego, "v": 1e9})
    cycles[8] = replace(cycles[8], candidates={"driving": cycles[8].candidates["driving"]})
    cycles[20] = replace(cycles[20], ego={})
    return replace(found, cycles=tuple(cycles), ground_truth={})


def outcome(name: str, backend: str) -> list[Any]:
    recording = recorded(name)
    evaluator = evaluator_for(recording, ROOT / "specs" / "rulebooks", [], ROOT, RULES, backend)
    found = []
    for t, judged, decision in supervised(recording, evaluator, {}):
        said = {
            candidate: (
                rated.verdicts,
                [float(margin).hex() for margin in rated.margins],
                [repr(rated.explain(place, False)) for place in range(len(rated.verdicts))],
            )
            for candidate, rated in judged.rated.items()
        }
        plan = decision.driven and (decision.driven.candidate, decision.driven.t)
        found.append((t, said, decision.action, plan, decision.faults, decision.violations))
    return found


@pytest.mark.parametrize(
    ("name", "backend"),
    [
        at_length("squeezed", "reference"),
        ("yellow_flag", "numpy"),
        at_length("squeezed", "numpy"),
        at_length("yellow_flag", "reference"),
    ],
)
def test_ahead_and_in_step(name: str, backend: str) -> None:
    ahead = outcome(name, backend)
    with (
        mock.patch.object(program.Remembering, "ahead", return_value=None),
        mock.patch.object(program, "drives_on", return_value=False),
        mock.patch.object(Streaming, "shares", False),
        mock.patch.object(Streaming, "_present", lambda _, state, now: state.cells.at(now)),
    ):
        in_step = outcome(name, backend)
    assert [strip(one) for one in ahead] == [strip(one) for one in in_step]
    assert {one[2] for one in ahead} >= {"drive", "previous_emergency"}
    verdicts = {VERDICTS[code] for one in ahead for said in one[1].values() for code in said[0]}
    assert "satisfied" in verdicts
    assert sum(bool(one[4]) for one in ahead) == 3


@pytest.mark.parametrize("name", ["squeezed", "yellow_flag"])
def test_what_a_fallback_drives_on_is_evaluated_at_once(name: str) -> None:
    evaluated = NumpyProgram.outcomes
    said, batches = [], []
    for guessed in (0, 7):
        batches.append(list[int]())

        def outcomes(self: NumpyProgram, frames: Any, sizes: list[int] = batches[-1]) -> Any:
            sizes.append(len(frames))
            return evaluated(self, frames)

        with (
            mock.patch.object(program, "_GUESSED", guessed),
            mock.patch.object(NumpyProgram, "outcomes", outcomes),
        ):
            said.append([strip(one) for one in outcome(name, "numpy")])
    assert said[0] == said[1]
    one_by_one, at_once = batches
    assert set(one_by_one[1:]) == {1}
    assert 2 * len(at_once[1:]) <= len(one_by_one[1:])


def strip(one: tuple[Any, ...]) -> tuple[Any, ...]:
    """Without what only compares by identity."""
    *rest, violations = one
    return (*rest, [(v.rule, v.candidate, v.verdict, float(v.margin).hex()) for v in violations])
