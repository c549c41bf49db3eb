"""The same run in another place, turned, in a mirror, at another time, with other names: rules that remember say the same of it.

For the rules of a Supervisor, `acceptance/test_no_place_is_special.py` does that.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from trackmarshal.evaluation import Evaluator
from trackmarshal.scenarios.recording import Cycle, Recording

SPECS = Path(__file__).resolve().parents[2] / "specs"
RULES = ("one_move", "no_overtaking_under_yellow", "gives_back", "leaves_room")
Record = dict[str, Any]


@cache
def evaluator(backend: str) -> Evaluator:
    spec = tm.load(str(SPECS / "rulebooks" / "racing.spec"), [str(SPECS / "tracks" / "northfield.spec")])
    return Evaluator(spec, list(RULES), backend)


@cache
def recorded(name: str) -> Recording:
    path = SPECS / "scenarios" / "racing" / f"{name}.tmrec.jsonl.gz"
    return replace(tm.load_recording(str(path)), ground_truth={}, judged={}, use=())


def said(recording: Recording, backend: str) -> list[tuple[str, float]]:
    """Of every rule and candidate in every cycle, what it says."""
    run = tm.replay(recording, evaluator(backend))
    found = [one for rule in RULES for name in run.candidates for one in run.said(name, rule)]
    return [(one.verdict, one.margin) for one in found if one is not None]


def each(recording: Recording, change: Callable[[Cycle], Cycle]) -> Recording:
    return replace(recording, cycles=tuple(map(change, recording.cycles)))


def moved(recording: Recording, turn: float, x: float, y: float, mirrored: bool, turns: int) -> Recording:
    """About the x axis first, then turned, rad, then moved, m; headings by any number of whole turns up to `turns` more."""
    side, c, s = (-1.0 if mirrored else 1.0), math.cos(turn), math.sin(turn)
    rounds = random.Random(1)

    def place(px: float, py: float) -> tuple[float, float]:
        return px * c - side * py * s + x, px * s + side * py * c + y

    def heading(angle: float) -> float:
        return side * angle + turn + math.tau * rounds.randint(-turns, turns)

    def one(given: Record) -> Record:
        px, py = place(given["x"], given["y"])
        return {**given, "x": px, "y": py, "heading": heading(given["heading"])}

    def columns(given: Record) -> Record:
        places = [place(px, py) for px, py in zip(given["x"], given["y"])]
        return {
            **given,
            "x": [px for px, _ in places],
            "y": [py for _, py in places],
            "heading": [heading(angle) for angle in given["heading"]],
            "kappa": [side * each for each in given["kappa"]],
        }

    def cycle(given: Cycle) -> Cycle:
        candidates = {name: columns(plan) for name, plan in given.candidates.items()}
        objects = [one(other) for other in given.objects]
        return replace(given, ego=one(given.ego), objects=objects, candidates=candidates)

    left, right = ([place(*point) for point in recording.track[name]] for name in ("left", "right"))
    borders = {"left": right, "right": left} if mirrored else {"left": left, "right": right}
    return replace(each(recording, cycle), track={**recording.track, **borders})


def reordered(recording: Recording) -> Recording:
    """With others beside them that are the same cars again, under other names, in front of them."""

    def cycle(given: Cycle) -> Cycle:
        again = [{**other, "id": f"twin of {other['id']}"} for other in reversed(given.objects)]
        return replace(given, objects=again + [{**other, "id": f"9{other['id']}"} for other in given.objects])

    return each(recording, cycle)


WAYS: dict[str, Callable[[Recording], Recording]] = {
    "turned": lambda run: moved(run, 2.3, 5e4, -3e4, False, 0),
    "surveyed, in a mirror": lambda run: moved(run, -1.1, 691234.5, 5334567.8, True, 0),
    "by whole turns": lambda run: moved(run, 0.0, 0.0, 0.0, False, 3),
    # Whole seconds of which a double has all digits: windows are the same to the nanosecond.
    "later": lambda run: each(run, lambda cycle: replace(cycle, t=cycle.t + 4096.0)),
    "before 0 s": lambda run: each(run, lambda cycle: replace(cycle, t=cycle.t - 4096.0)),
    "twins": reordered,
}


@pytest.mark.parametrize(
    ("name", "ways"),
    [
        ("yellow_flag", ["surveyed, in a mirror"]),
        ("second_move", ["by whole turns", "before 0 s", "twins"]),
        ("squeezed", ["turned", "later"]),
    ],
)
def test_racing_rules(name: str, ways: list[str]) -> None:
    run = recorded(name)
    before = said(run, "numpy")
    assert Counter(verdict for verdict, _ in before)["violated"] > 0
    for way in ways:
        after = said(WAYS[way](run), "numpy")
        assert len(after) == len(before), way
        for one, other in zip(before, after):
            assert one[1] == pytest.approx(other[1], rel=1e-6, abs=1e-5, nan_ok=True), way
            assert one[0] == other[0] or abs(one[1]) < 1e-5, way
