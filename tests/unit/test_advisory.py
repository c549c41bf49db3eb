"""Advisory rules: they are judged and shown as all others, and make nothing unsafe."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.pairs import Pair
from trackmarshal.backends.c import build
from trackmarshal.backends.c.source import generate
from trackmarshal.cli.main import main
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.program import Judged, Rated
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.supervision import supervisor

NEEDS_COMPILER = pytest.mark.skipif(build.compiler() is None, reason="no C compiler")
SIGNALS = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s in [-10, 150] }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { x: m, y: m }
"""
DECIDES = "rule decides\n  for all p in plan\n  require p.v <= 50 m/s\n"
WARNS = "rule warns\n  severity advisory\n  for all p in plan\n  require p.v <= 20 m/s\n"
HINTS = "rule hints\n  severity advisory\n  require count(o in objects where o.x > 0 m) <= 1\n"


def cycle(number: int, fastest: float, objects: tuple[float, ...] = ()) -> Cycle:
    """The car drives on along the x axis at 10 m/s; both candidates are as fast as this at their second sample."""
    x = float(number)
    plan = {
        "t": [0.0, 1.0, 2.0, 4.0], "x": [x, x + 10.0, x + 20.0, x + 25.0], "y": [0.0] * 4, "heading": [0.0] * 4,
        "v": [10.0, fastest, 5.0, 0.0],
    }  # fmt: skip
    given: dict[str, Any] = {
        "ego": {"x": x, "y": 0.0, "heading": 0.0, "v": 10.0},
        "objects": {"x": list(objects), "y": [0.0] * len(objects)},
    }
    return Cycle(number, number / 10, plan, dict(plan), given)


def told(decision: Any) -> tuple[bool, list[tuple[str, str, str]], list[tuple[str, str, str]]]:
    return decision.safe, *(
        [(one.rule, one.candidate, one.verdict) for one in listed]
        for listed in (decision.violations, decision.advisories)
    )


def both(rule: str, verdict: str) -> list[tuple[str, str, str]]:
    return [(rule, candidate, verdict) for candidate in ("driving", "emergency")]


@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_the_supervisor_drives_on_and_says_so(backend: str) -> None:
    made = supervisor(loads(SIGNALS + WARNS + DECIDES + HINTS), None, backend, clock=lambda: now)
    now = 0.0
    assert told(made.step(cycle(0, 15.0))) == (True, [], [])
    now = 0.1
    assert told(made.step(cycle(1, 30.0))) == (True, [], both("warns", "violated"))
    now = 0.2
    assert told(made.step(cycle(2, 60.0))) == (False, both("decides", "violated"), both("warns", "violated"))
    now = 0.3
    assert made.step(cycle(3, 15.0, (1.0, 2.0))).advisories[0].margin == -1.0


@NEEDS_COMPILER
def test_generated_c_decides_as_python_does() -> None:
    pair = Pair(Evaluator(loads(SIGNALS + WARNS + DECIDES + HINTS)))
    for number, (fastest, objects) in enumerate(
        [(15.0, ()), (30.0, ()), (60.0, ()), (15.0, (1.0, 2.0)), (30.0, (1.0,)), (math.nan, ())]
    ):
        given = cycle(number, fastest, objects)
        decision = pair.step(given, number / 10, number / 10)
        assert decision.safe == (fastest < 50.0)
        assert ("warns" in {one.rule for one in decision.advisories}) == (fastest > 20.0)


def test_the_c_says_which_they_are() -> None:
    spec = loads(SIGNALS + WARNS + DECIDES + HINTS)
    made = generate(spec, spec.rules, doored=True)
    assert "tm_advisory[TM_RULES] = {\n  true, false, true,\n};" in made.source


def test_a_case_is_safe_by_what_decides() -> None:
    evaluator = Evaluator(loads(SIGNALS + WARNS + DECIDES))
    case = {"plan": {"t": [0, 1], "x": [0, 1], "y": [0, 0], "heading": [0, 0], "v": [30.0, 30.0]}}
    (result,) = evaluator.evaluate([evaluator.read({"signals": case})])
    assert result.safe
    assert [(one.fired, one.unsafe, one.advisory) for one in result.rules.values()] == [
        (True, False, True), (False, False, False),
    ]  # fmt: skip
    batch = evaluator.batch({"plan": {k: np.array([v, v], dtype=float) for k, v in case["plan"].items()}})
    assert batch.safe.tolist() == [True, True]


@pytest.mark.parametrize("backend", ["reference", "numpy", pytest.param("c", marks=NEEDS_COMPILER)])
def test_a_run_is_safe_by_what_decides(backend: str) -> None:
    """Of advisory rules that remember, along a course and over the run, too."""
    remembering = """module m
signal ego : state { v: m/s }
signal plan : trajectory { t: s increasing, v: m/s }
course path = ego for 2 s then plan
rule decides
  require ego.v <= 50 m/s
rule warns
  severity advisory
  require not once[0 s, 1 s] ego.v > 20 m/s
rule hints
  severity advisory
  along path as c
  require historically c.v <= 20 m/s
"""
    evaluator = Evaluator(loads(remembering), None, backend)
    run = evaluator.over_run()
    for t, fastest in enumerate((10.0, 30.0, 60.0)):
        case = {"ego": {"v": fastest}, "plan": {"t": [0, 1], "v": [fastest, fastest]}}
        result = run.step(evaluator.read({"t": float(t), "signals": case}))
        assert result.safe == (fastest < 50.0)
        assert [one.advisory for one in result.rules.values()] == [False, True, True]
        assert [one.fired for one in result.rules.values()] == [
            fastest > 50.0,
            fastest > 20.0,
            fastest > 20.0,
        ]


def test_nothing_is_safe_by_advisory_rules_alone() -> None:
    spec = loads(SIGNALS + WARNS)
    evaluator = Evaluator(spec)
    case = {"plan": {"t": [0, 1], "x": [0, 1], "y": [0, 0], "heading": [0, 0], "v": [3.0, 3.0]}}
    (result,) = evaluator.evaluate([evaluator.read({"signals": case})])
    assert result.rules["warns"].verdict == "satisfied"
    assert not result.safe
    assert not Rated(b"\0", [1.0], lambda number, series: result.rules["warns"], frozenset([0])).safe
    with pytest.raises(TrackmarshalError, match="are advisory"):
        supervisor(spec)


def test_a_judge_cannot_call_a_rule_advisory() -> None:
    """What decides is what the spec says, whatever comes with the verdicts."""
    made = supervisor(loads(SIGNALS + DECIDES), None, "numpy", clock=lambda: 0.0)
    assert isinstance(made, Supervisor)
    honest = made.program

    class Lenient:
        def __getattr__(self, name: str) -> Any:
            return getattr(honest, name)

        def judge(self, memory: Any, frame: Any) -> Judged:
            judged = honest.judge(memory, frame)
            return judged._replace(
                rated={name: one._replace(advisory=frozenset([0])) for name, one in judged.rated.items()}
            )

    made.program = Lenient()
    decision = made.step(cycle(0, 60.0))
    assert not decision.safe
    assert [fault.field for fault in decision.faults] == ["judge"]


def test_eval_shows_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "m.spec").write_text(SIGNALS + WARNS + DECIDES, "utf-8")
    case = (
        '{"signals": {"plan": {"t": [0, 1], "x": [0, 1], "y": [0, 0], "heading": [0, 0], "v": [30, 30]}}}\n'
    )
    (tmp_path / "cases.jsonl").write_text(case, "utf-8")
    asked = ["eval", str(tmp_path / "m.spec"), "--data", str(tmp_path / "cases.jsonl")]
    assert main([*asked, "--format", "jsonl"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["safe"]
    assert [rule.get("advisory", False) for rule in told["rules"].values()] == [True, False]
    assert main(asked) == 0
    assert "warns (advisory)" in capsys.readouterr().out
