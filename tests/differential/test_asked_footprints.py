"""Footprints of which numpy works out those that may count: verdicts, margins, witnesses and series are those of the reference."""

from __future__ import annotations

import itertools
import math
import random
from pathlib import Path
from typing import Any

import pytest

from trackmarshal.backends.numpy import places
from trackmarshal.backends.numpy.code import Code
from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.evaluation import Evaluator, load
from trackmarshal.ir import nodes as ir

SPECS = Path(__file__).parents[2] / "specs" / "supervisor"
RULES = ["static_collision", "obstacle_collision", "fallback_collision", "fallback_oncoming", "contact"]
RADIUS, BORDER, POINTS = 300.0, 60, 12


def border(radius: float) -> list[list[float]]:
    angles = [2.0 * math.pi * k / BORDER for k in range(BORDER)]
    return [[radius * math.cos(a), radius * math.sin(a)] for a in angles]


TRACK = {"left": border(RADIUS - 8.0), "right": border(RADIUS + 8.0), "closed": True}


def plan(draw: random.Random, angle: float) -> dict[str, list[float]]:
    step, drift = draw.choice([0.0, 0.5, 2.0]), draw.uniform(-0.2, 0.2)
    at = [angle + k * step / RADIUS for k in range(draw.randint(2, POINTS))]
    away = [RADIUS + drift * k for k in range(len(at))]
    columns = {
        "t": [0.1 * k for k in range(len(at))],
        "s": [step * k for k in range(len(at))],
        "x": [r * math.cos(a) for r, a in zip(away, at)],
        "y": [r * math.sin(a) for r, a in zip(away, at)],
        "heading": [math.remainder(a + math.pi / 2, 2.0 * math.pi) for a in at],
        "kappa": [1.0 / RADIUS] * len(at),
        "v": [10.0 * step] * len(at),
        "a": [0.0] * len(at),
    }
    if draw.random() < 0.15:
        columns[draw.choice(["x", "heading", "kappa"])][draw.randrange(len(at))] = math.nan
    return columns


def box(draw: random.Random, angle: float) -> dict[str, float]:
    at, away = angle + draw.uniform(-10.0, 40.0) / RADIUS, RADIUS + draw.uniform(-7.0, 7.0)
    made = {
        "x": away * math.cos(at), "y": away * math.sin(at), "heading": draw.uniform(-3.0, 3.0),
        "length": draw.choice([0.2, 1.0, 4.7]), "width": draw.choice([0.2, 2.0]),
    }  # fmt: skip
    if draw.random() < 0.1:
        made[draw.choice(["x", "heading", "length"])] = math.nan
    return made


def cases(draw: random.Random, count: int) -> list[dict[str, Any]]:
    made = []
    for number in range(count):
        angle = draw.uniform(0.0, 6.0)
        objects = [
            {"id": f"o{k}", "v": draw.choice([0.0, -0.4, 20.0, 20.0, math.nan]), **box(draw, angle)}
            for k in range(draw.randint(0, 4))
        ]
        driven = plan(draw, angle)
        signals = {
            "plan": driven, "emergency": draw.choice([True, True, False, None]), "objects": objects, "track": TRACK,
            "obstacles": [box(draw, angle) for _ in range(draw.randint(0, 3))],
            "ego": {name: driven[name][0] for name in ("x", "y", "heading", "v")},
        }  # fmt: skip
        made.append({"id": str(number), "signals": signals})
    return made


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("count", "bounded", "asked"), [(1, 0, 4), (3, 8, 0), (3, 0, 4), (9, 0, 2)])
def test_as_the_reference(
    count: int, bounded: int, asked: int, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By one case and by several; with and without bounds; where cases are asked alone, and where all are asked at once."""
    monkeypatch.setattr(places, "BOUNDED", bounded)
    monkeypatch.setattr(places, "ASKED", asked)
    monkeypatch.setattr(places, "FEW_FOOTPRINTS", bounded)
    spec = load([SPECS])
    given = cases(random.Random(100 * seed + count), count)
    numpy, reference = (Evaluator(spec, RULES, backend) for backend in ("numpy", "reference"))
    pairs = zip(*(one.judge_all(one.read_all(given)) for one in (numpy, reference)))
    for found, expected in pairs:
        found, expected = found.rated[""], expected.rated[""]
        assert found.verdicts == expected.verdicts
        assert list(map(repr, map(float, found.margins))) == list(map(repr, map(float, expected.margins)))
        for rule in range(len(RULES)):
            for series in (False, True):
                assert repr(found.explain(rule, series)) == repr(expected.explain(rule, series))


@pytest.mark.parametrize("asked", [0, 2, 100])
def test_whoever_asks_for_what_was_left_out_gets_it(asked: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every formula on the way to a rule, of every object and every sample."""
    monkeypatch.setattr(places, "BOUNDED", 0)
    monkeypatch.setattr(places, "ASKED", asked)
    evaluator = Evaluator(load([SPECS]), RULES)
    program = evaluator.program
    assert isinstance(program, NumpyProgram)
    frames = evaluator.read_all(cases(random.Random(5), 6))
    run = program.run(frames)
    assert len(program.code.partly) >= 5
    told = 0
    for index, frame in enumerate(frames):
        view, reference = CaseView(run, index), Reference(evaluator.spec, frame)
        for node in program.code.partly:
            assert isinstance(node, ir.Formula)
            levels = {axis.level: axis for axis in ir.below(node) if isinstance(axis, ir.Axis)}
            bound = {each.axis.level for each in ir.below(node) if isinstance(each, ir.Quantify)}
            free = sorted(level for level in levels if level not in bound)
            for places_ in itertools.product(*(range(view.count(levels[level])) for level in free)):
                env = dict(zip(free, places_))
                found, expected = view.truth(node, env), reference.truth(node, env)
                for side, other in ((found.worst, expected.worst), (found.best, expected.best)):
                    assert side.sat == other.sat
                    # Corners that lie on one line are a matter of rounding.
                    assert side.margin == pytest.approx(other.margin, abs=1e-12, rel=1e-12)
                told += 1
    assert told > 100


def test_rules_that_ask_of_the_same_footprints_each_leave_out_their_own() -> None:
    """Two shipped rules hold the same bodies against the same vehicles, of which each asks of some: with one variable for both, all were worked out."""
    spec = load([SPECS])
    rules = [spec.rule(name) for name in ("driving_collision", "fallback_collision")]
    formulas = [rule.formula for rule in rules if rule is not None and rule.formula is not None]
    assert len(Code(formulas, [])._asked_of) == 2
