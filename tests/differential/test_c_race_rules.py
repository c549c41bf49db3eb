"""Rules of a race that need a course, sectors that the data names, and lanes: the Supervisor in generated C decides what the one in Python decides."""

from __future__ import annotations

import json
import random
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from support.pairs import Pair
from support.project import run_command
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.verdict import VERDICTS

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

TEXT = """module race

signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { x: m, y: m, heading: rad, v: m/s }
signal track : corridor { left: polyline, right: polyline }
signal lanes : set of lane { left: polyline, right: polyline }
signal yellow : set of object { from: m, to: m }
param width : m = 2 m in [1 m, 3 m]

course driven = ego for 1.5 s then plan

rule one_move "One change of line, of what was driven and what is planned"
  along     driven as c
  require   always count(rising(offset(c, track) > 1 m), last: 1.5 s) <= 1

rule no_overtaking "Nobody is passed where a yellow flag is shown"
  whenever  exists s in yellow: (ego in stretch(track, s.from, s.to))
  for all   o in objects
  require   not falling(station_gap(track, station(ego, track), station(o, track)) > 0 m)

rule room_at_the_edge "A car's width is left at an edge"
  for all   p in plan
  require   distance_to(p, track.left) >= width and distance_to(p, track.right) >= width

rule in_a_lane "The car keeps to one lane"
  for all   p in plan
  require   count(l in lanes where swept_hull(p, 4 m, 1 m) meets l) == 1
"""
RULES = ("one_move", "no_overtaking", "room_at_the_edge", "in_a_lane")
CYCLES = 60


@cache
def evaluator() -> Evaluator:
    return Evaluator(loads(TEXT))


def line(y: float) -> list[list[float]]:
    return [[-20.0 + 10.0 * k, y] for k in range(12)]


def cycles(seed: int) -> list[dict[str, Any]]:
    """Signals and plan of a car that changes its line now and then, and passes another one."""
    rng, found, y = random.Random(seed), list[dict[str, Any]](), 0.0
    for k in range(CYCLES):
        y, x = rng.choice([y, y, y, y, 0.0, 1.4]), 1.0 * k
        then = rng.choice([y, y, y, 0.0, 1.4, rng.choice([1.4, 4.0, 9.0])])
        plan = {
            "t": [0.0, 0.5, 1.0], "x": [x, x + 5.0, x + 9.0], "y": [y, y, then], "heading": [0.0] * 3, "v": [10.0, 9.0, 0.0],
        }  # fmt: skip
        signals: dict[str, Any] = {
            "ego": {"x": x, "y": y, "heading": 0.0, "v": 10.0},
            "objects": [{"id": "a", "x": 25.0 + 0.2 * k, "y": 3.0, "heading": 0.0, "v": 2.0}],
            "track": {"left": line(5.0), "right": line(-5.0)},
            "lanes": [
                {"left": line(5.0 - 3.0 * n), "right": line(2.0 - 3.0 * n), "id": f"lane{n}"}
                for n in range(3)
            ],
            "yellow": [{"from": 30.0, "to": 60.0}] if seed % 2 else [],
        }
        found.append({"plan": plan, "signals": signals})
    return found


def test_a_supervisor() -> None:
    seen, safe = Counter[tuple[str, str]](), Counter[bool]()
    for seed in range(4):
        pair = Pair(evaluator(), limits=Limits(budget=1e9))
        for k, given in enumerate(cycles(seed)):
            now, plan = 0.1 * k, given["plan"]
            decision = pair.step(
                None if k % 25 == 24 else Cycle(k, now, plan, plan, given["signals"]), now, now
            )
            safe[decision.safe] += 1
            if decision.judged is not None:
                rated = decision.judged.rated["driving"]
                seen.update((name, VERDICTS[code]) for name, code in zip(RULES, rated.verdicts, strict=True))
    assert min(safe[True], safe[False]) > 20
    for name in RULES:
        assert seen[name, "violated"] > 0, name
        assert seen[name, "satisfied"] + seen[name, "inactive"] > 0, name


def test_a_replay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("race.spec").write_text(TEXT, encoding="utf-8")
    first = cycles(1)[0]["signals"]
    lines: list[dict[str, Any]] = [
        {"format": "trackmarshal-recording", "version": 1, "name": "made", "track": first["track"], "signals": {"lanes": first["lanes"]}}
    ]  # fmt: skip
    for k, given in enumerate(cycles(1)):
        plan = {**given["plan"], "kappa": [0.0] * 3, "a": [0.0] * 3}
        signals = {"yellow": given["signals"]["yellow"]}
        lines.append({
            "t": 0.1 * k, "ego": given["signals"]["ego"], "candidates": {"driving": plan, "emergency": plan},
            "objects": [{**each, "length": 4.0, "width": 2.0} for each in given["signals"]["objects"]], "signals": signals,
        })  # fmt: skip
    Path("made.tmrec.jsonl").write_text("\n".join(map(json.dumps, lines)) + "\n", encoding="utf-8")
    said = []
    for backend in ("numpy", "c"):
        status, out, err = run_command(
            "replay", "made.tmrec.jsonl", "--spec", "race.spec", "--format", "jsonl", "--exit-zero", "--backend", backend
        )  # fmt: skip
        assert status == 0, err
        found = [line for line in map(json.loads, out.splitlines()) if "rules" in line]
        said.append([
            {name: (rule["verdict"], rule["margin"]) for name, rule in line["rules"].items()} for line in found
        ])  # fmt: skip
    assert len(said[0]) >= CYCLES
    assert said[0] == said[1]
    assert {line["one_move"][0] for line in said[0]} >= {"satisfied", "violated"}
    assert tm.load([Path("race.spec")]).courses
