"""Records of runs for tests of the report: a small spec on recordings made to order."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from trackmarshal.evaluation import Evaluator, load
from trackmarshal.scenarios.recording import Cycle, Recording
from trackmarshal.scenarios.replay import replay
from trackmarshal.scenarios.run_record import run_record

SPEC = """module small

signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { x: m, y: m, heading: rad, v: m/s, length: m, width: m, age: s in [0, 10] default 0 s }
event emergency "the candidate is the emergency trajectory"

param length : m = 5 m in [1, 20]
param width : m = 2 m in [0.5, 5]
param v_max : m/s = 30 m/s in [0, 100]

assume A-FRESH "Objects are fresh"
  satisfies R-1
  owner "perception"
  evidence "docs/fresh.md"
  for all o in objects
  monitor o.age <= 100 ms

assume A-WHO "Somebody else answers"
  satisfies R-1
  owner "race control"

rule near "Keep away from others"
  satisfies R-2
  source "a book"
  for all o in objects
  require abs(o.x - ego.x) > 10 m

rule fast "Not too fast"
  satisfies R-3, R-2
  for all p in plan
  require p.v <= v_max

rule rest "Emergency trajectories end at rest"
  satisfies R-3
  whenever emergency
  require abs(plan.last.v) <= 0.5 m/s

rule root "A rule that can be undefined"
  for all p in plan
  require sqrt((p.x + 50 m) / 1 m) <= 100
"""


#: Rules that speak of places, and a place of which none does.
PLACES = """
zone slow "a strip on the left" = polygon (10 m, 0 m) (300 m, 0 m) (300 m, 6 m) (10 m, 6 m)
zone unused "no rule names it" = polygon (0 m, 0 m) (1 m, 0 m) (1 m, 1 m)
line start "across the road" = (20 m, -6 m) (20 m, 6 m)

rule strip "Slow in the strip"
  for all p in plan where p in zone slow
  require p.v <= 10 m/s

rule begin "Slow at the start"
  for all p in plan where distance_to(p, start) <= 5 m
  require p.v <= 10 m/s
"""


def evaluator(folder: Path, text: str = SPEC) -> Evaluator:
    path = folder / "small.spec"
    path.write_text(text, encoding="utf-8")
    return Evaluator(load([path], [], folder))


def plan(x: float, v: float, end: float, count: int = 20) -> dict[str, list[float]]:
    """A straight trajectory from x on along +x, from speed v to speed end."""
    speeds = [v + (end - v) * i / (count - 1) for i in range(count)]
    return {
        "t": [0.1 * i for i in range(count)], "s": [2.0 * i for i in range(count)], "x": [x + 2.0 * i for i in range(count)],
        "y": [0.0] * count, "heading": [0.0] * count, "kappa": [0.0] * count, "v": speeds, "a": [0.0] * count,
    }  # fmt: skip


def other(name: str, x: float, **fields: Any) -> dict[str, Any]:
    return {
        "id": name,
        "x": x,
        "y": 3.0,
        "heading": 0.1,
        "v": 20.0,
        "length": 4.5,
        "width": 1.8,
        "age": 0.0,
        **fields,
    }


def cycle(t: float, x: float, others: Sequence[dict[str, Any]] = (), v: float = 20.0, **ego: float) -> Cycle:
    return Cycle(
        t,
        {"x": x, "y": 0.0, "heading": 0.0, "v": v, **ego},
        list(others),
        {"driving": plan(x, v, v), "emergency": plan(x, v, 0.0)},
    )


def recording(cycles: Sequence[Cycle], name: str = "run", **fields: Any) -> Recording:
    track = {"left": [[-50.0, 6.0], [500.0, 6.0]], "right": [[-50.0, -6.0], [500.0, -6.0]], "closed": False}
    return Recording(
        **{"name": name, "source": f"{name}.tmrec.jsonl", "cycles": tuple(cycles), "track": track, **fields}
    )


def overtaking(name: str = "run", count: int = 40, **fields: Any) -> Recording:
    """Another car comes from behind, is too near from x = -10 m to 10 m, and goes on."""
    cycles = [cycle(0.1 * i, 2.0 * i, [other("blue", 3.0 * i - 20.0)]) for i in range(count)]
    return recording(cycles, name, **fields)


def record(folder: Path, run: Recording, source_hash: str = "") -> dict[str, Any]:
    """The record of a run, through JSON as a caller might keep it."""
    rules = evaluator(folder)
    made: dict[str, Any] = json.loads(
        json.dumps(run_record(replay(run, rules), rules, source_hash), allow_nan=False)
    )
    return made


def flat(record_: dict[str, Any], rule: str, candidate: str = "driving") -> dict[str, Any]:
    found: dict[str, Any] = next(r for r in record_["rules"] if r["name"] == rule)["candidates"][candidate]
    return found


def large(
    base: Mapping[str, Any], cycles: int, rules: int, margin: Callable[[int, int], float]
) -> dict[str, Any]:
    """A record with many cycles and rules, of the shape of a given one; margin(rule, cycle) decides verdicts."""
    t = [round(0.1 * i, 3) for i in range(cycles)]
    x, y = [2.0 * i for i in range(cycles)], [30.0 * math.sin(i / 60) for i in range(cycles)]
    columns = {"x": x, "y": y, "heading": [0.0] * cycles}
    path = [
        {"x": [x[i] + 3.0 * k for k in range(16)], "y": [y[i] + 0.1 * k for k in range(16)]}
        for i in range(cycles)
    ]
    template = base["rules"][0]
    made = []
    for number in range(rules):
        margins = [margin(number, i) for i in range(cycles)]
        verdict = "".join("v" if m < 0 else "s" for m in margins)
        firings = []
        first: int | None = None
        for i, letter in enumerate(verdict + "s"):
            if letter == "v" and first is None:
                first = i
            elif letter != "v" and first is not None:
                worst = min(range(first, i), key=lambda j: margins[j])
                moment = _moment(worst, t[worst], margins[worst])
                firings.append(
                    {
                        "from": t[first],
                        "to": t[i - 1],
                        "cycles": [first, i - 1],
                        "verdicts": ["violated"],
                        "worst": moment,
                    }
                )
                first = None
        least = min(range(cycles), key=lambda j: margins[j])
        lane = {
            "verdict": verdict,
            "margin": margins,
            "least": _moment(least, t[least], margins[least]),
            "firings": firings,
        }
        names = {"name": f"rule_{number:02}", "requirements": [f"R-{number % 6}"]}
        made.append({**template, **names, "candidates": {"driving": lane, "emergency": lane}})
    size = {"length": [4.5] * cycles, "width": [1.8] * cycles}
    return {
        **base, "scenario": "large", "t": t, "ego": {**columns, "v": [20.0] * cycles},
        "objects": [{"id": f"o{k}", "cycles": list(range(cycles)), **columns, "y": [v + 4.0 * k for v in y], **size} for k in (1, 2, 3)],
        "decision": ["drive"] * cycles, "decision_from": t, "rules": made, "ground_truth": {"static": [None] * cycles}, "truths": [],
        "candidates": {c: {"safe": [True] * cycles, "paths": path, "faults": []} for c in ("driving", "emergency")},
    }  # fmt: skip


def _moment(number: int, t: float, margin: float) -> dict[str, Any]:
    return {
        "cycle": number, "t": t, "verdict": "violated" if margin < 0 else "satisfied", "margin": margin, "unit": "m", "reason": "",
        "where": [{"name": "p", "value": 3, "signal": "plan", "t": 0.3, "x": 1.0, "y": 2.0}],
        "decides": {"margin": margin, "unit": "m"}, "span": "specs/small.spec:12:3", "line": "require p.x > 0 m",
    }  # fmt: skip
