"""Courses: in a Supervisor, in an inline test, in `explain`, saved and restored; and at which sample a rule is judged."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.project import run_command
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.supervision import supervisor
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests

SPEC = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
course driven = ego for 2 s then plan

rule calm "Within a second of having been fast, it is slow"
  along     driven as c
  require   historically[0 s, 1 s] c.v <= 20 m/s or eventually[0 s, 1 s] c.v <= 5 m/s
"""
PYTHON = ("reference", "numpy")


class Rig:
    def __init__(self, backend: str, rules: str = SPEC) -> None:
        self.now, self.number, self.at = 0.0, -1, 0.0
        self.supervisor: Any = supervisor(loads(rules), None, backend, Limits(), lambda: self.now)

    def step(self, v: float, planned: float = 30.0) -> Any:
        self.now, self.number = round(self.now + 0.1, 9), self.number + 1
        ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": v}
        return self.supervisor.step(
            Cycle(self.number, self.now, _plan(v, planned), _plan(v, 0.0), {"ego": ego})
        )

    def missed(self) -> None:
        self.now, self.number = round(self.now + 0.1, 9), self.number + 1
        self.supervisor.step(None)


def _plan(v: float, then: float) -> dict[str, list[float]]:
    return {"t": [0.0, 1.0, 2.0], "x": [0.0] * 3, "y": [0.0] * 3, "heading": [0.0] * 3, "v": [v, then, then]}


def _verdicts(decision: Any) -> dict[str, list[str]]:
    return {
        name: [rated.explain(place, False).verdict for place in range(len(rated.verdicts))]
        for name, rated in decision.judged.rated.items()
    }


@pytest.mark.parametrize("backend", PYTHON)
def test_lived_and_planned_count_together_for_each_candidate(backend: str) -> None:
    rig = Rig(backend)
    assert _verdicts(rig.step(20.0)) == {"driving": ["satisfied"], "emergency": ["satisfied"]}
    assert _verdicts(rig.step(21.0)) == {"driving": ["violated"], "emergency": ["satisfied"]}
    for _ in range(10):  # a second later, the fast cycle still counts
        assert _verdicts(rig.step(20.0)) == {"driving": ["violated"], "emergency": ["satisfied"]}
    assert _verdicts(rig.step(20.0)) == {"driving": ["satisfied"], "emergency": ["satisfied"]}


@pytest.mark.parametrize("backend", PYTHON)
def test_a_gap_is_an_undefined_sample(backend: str) -> None:
    rig = Rig(backend)
    rig.step(20.0)
    rig.missed()
    assert rig.step(20.0).faults  # a number is missing: refused, too
    # The gap ends where the next cycle begins: 0.9 s after that it is still in the window, and a second after it no more.
    found = [_verdicts(rig.step(20.0))["driving"] for _ in range(12)]
    assert found == [["undefined"]] * 10 + [["satisfied"]] * 2


@pytest.mark.parametrize("backend", PYTHON)
def test_of_no_cycle_there_is_no_gap_and_no_past(backend: str) -> None:
    rig = Rig(backend)
    rig.missed()
    assert _verdicts(rig.step(20.0)) == {"driving": ["satisfied"], "emergency": ["satisfied"]}


def _said(run: Any, evaluator: Evaluator, t: float, v: float) -> tuple[str, float]:
    signals = {"ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": v}, "plan": _plan(v, 30.0)}
    result = run.step(evaluator.read({"t": t, "signals": signals})).rules["calm"]
    return result.verdict, result.margin


def test_saved_and_restored() -> None:
    evaluator = Evaluator(loads(SPEC), backend="numpy")
    run = evaluator.over_run()
    _said(run, evaluator, 0.0, 21.0)
    run.missed()
    _said(run, evaluator, 0.2, math.inf)
    _said(run, evaluator, 0.3, 20.5)
    saved = run.save()
    later = evaluator.over_run(saved)
    for t in (0.4, 1.3, 1.5):
        assert repr(_said(later, evaluator, t, 20.0)) == repr(_said(run, evaluator, t, 20.0))
    assert any('"driven"' in line for line in saved)
    other = Evaluator(loads(SPEC.replace("for 2 s", "for 3 s")), backend="numpy")
    with pytest.raises(TrackmarshalError, match="D164"):
        other.over_run(saved)


def test_generated_c_refuses_it_and_auto_takes_numpy() -> None:
    with pytest.raises(TrackmarshalError, match="E470"):
        Evaluator(loads(SPEC), backend="c").over_run()
    assert Evaluator(loads(SPEC), backend="auto").program.identity["backend"] == "numpy"


def test_cases_by_themselves_have_no_margins_along_a_course() -> None:
    evaluator = Evaluator(loads(SPEC), backend="numpy")
    plan = {name: np.array([column, column]) for name, column in _plan(20.0, 30.0).items()}
    ego = {"x": np.zeros(2), "y": np.zeros(2), "heading": np.zeros(2), "v": np.array([20.0, 21.0])}
    batch = evaluator.batch({"ego": ego, "plan": plan})
    assert [batch.case(number).rules["calm"].verdict for number in range(2)] == ["satisfied", "violated"]
    with pytest.raises(TrackmarshalError, match="E406"):
        batch.samples("calm")


@pytest.mark.parametrize("backend", PYTHON)
@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        ({}, "satisfied"),
        ({"plan": None}, "undefined"),
        ({"ego": None}, "undefined"),
        ({"ego": {"x": 0.0, "y": 0.0, "heading": 0.0}}, "undefined"),
        ({"plan": {**_plan(20.0, 20.0), "t": [0.0, 2.0, 1.0]}}, "undefined"),
        ({"plan": {**_plan(20.0, 20.0), "t": [0.0, math.nan, 2.0]}}, "undefined"),
        ({"plan": {**_plan(20.0, 20.0), "t": [0.0, 1.0]}}, "undefined"),
        ({"plan": {name: column for name, column in _plan(20.0, 20.0).items() if name != "v"}}, "undefined"),
        # What was is enough here, whatever is planned.
        ({"plan": {**_plan(20.0, 20.0), "v": [20.0, math.nan, 20.0]}}, "satisfied"),
    ],
)
def test_what_is_broken_is_undefined_and_a_gap_for_the_next_cycle(
    backend: str, change: dict[str, Any], verdict: str
) -> None:
    evaluator = Evaluator(loads(SPEC), backend=backend)
    run = evaluator.over_run()
    assert _said(run, evaluator, 0.0, 19.0)[0] == "satisfied"
    signals = {"ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 20.0}, "plan": _plan(20.0, 20.0), **change}
    kept = {name: given for name, given in signals.items() if given is not None}
    assert run.step(evaluator.read({"t": 0.1, "signals": kept})).rules["calm"].verdict == verdict
    assert _said(run, evaluator, 0.2, 19.0)[0] == ("undefined" if change else "satisfied")


def test_inline_tests(tmp_path: Path) -> None:
    text = (
        SPEC
        + """
test calm "fast a second ago, and not slow in time"
  given  ego = { x: 0 m, y: 0 m, heading: 0 rad, v: 25 m/s }
  given  plan = line(v: 10 m/s)
  after  1 s
  given  ego = { x: 0 m, y: 0 m, heading: 0 rad, v: 10 m/s }
  expect violated, margin -5 m/s

test calm "longer ago"
  given  ego = { x: 0 m, y: 0 m, heading: 0 rad, v: 25 m/s }
  given  plan = line(v: 10 m/s)
  after  1.001 s
  given  ego = { x: 0 m, y: 0 m, heading: 0 rad, v: 10 m/s }
  expect satisfied, margin 10 m/s
"""
    )
    from trackmarshal.semantics.compile import compile_text

    compiled = compile_text(text)
    compiled.raise_errors()
    tests, found = prepare(compiled)
    assert found == []
    assert [(o.outcome, o.message) for o in run_tests(compiled.spec, tests)] == [("passed", "")] * 2


def test_explain_names_samples_from_now(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.spec").write_text(SPEC)
    lines: list[dict[str, Any]] = [
        {"format": "trackmarshal-recording", "version": 1, "name": "made",
         "track": {"left": [[-99, 5], [999, 5]], "right": [[-99, -5], [999, -5]]}}
    ]  # fmt: skip
    for k, v in enumerate([22.0, 20.0, 19.0, 18.0]):
        more = {"kappa": [0.0] * 3, "a": [0.0] * 3}
        lines.append(
            {
                "t": k / 10, "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": v},
                "candidates": {"driving": {**_plan(v, 30.0), **more}, "emergency": {**_plan(v, 0.0), **more}},
                "objects": [],
            }
        )  # fmt: skip
    Path("made.tmrec.jsonl").write_text("\n".join(map(json.dumps, lines)) + "\n")
    status, out, err = run_command(
        "explain",
        "made.tmrec.jsonl",
        "--spec",
        "m.spec",
        "--rule",
        "calm",
        "--at",
        "0.3",
        "--candidate",
        "driving",
    )
    assert status == 0, err
    assert "violated, margin -2 m/s" in out
    assert "decided at c = -3" in out
    assert "driven[-3].v = 22" in out


@pytest.mark.parametrize("backend", [*PYTHON, "c"])
@pytest.mark.parametrize(("place", "margin"), [("", 4.0), (" at first", 4.0), (" at last", -2.0)])
def test_where_a_rule_is_judged(backend: str, place: str, margin: float) -> None:
    text = (
        "module m\nsignal plan : trajectory { t: s increasing, v: m/s }\n"
        f'rule f ""\n  along plan as p{place}\n  require once[0 s, 1 s] p.v >= 10 m/s\n'
        f'rule g ""\n  along plan as p{place}\n  whenever p.v > 9 m/s\n  require p.v < 99 m/s\n'
    )
    evaluator = Evaluator(loads(text), backend=backend)
    short = {"t": [0.0, 1.0], "v": [14.0, 3.0]}
    plans = [{"t": [0.0, 1.0, 2.0, 3.0], "v": [14.0, 20.0, 8.0, 7.0]}, short]
    found = [evaluator.case({"signals": {"plan": plan}}) for plan in plans]
    assert found[0].rules["f"].margin == margin
    assert found[1].rules["f"].margin == 4.0
    assert [one.rules["g"].verdict for one in found] == ["inactive" if margin < 0 else "satisfied"] * 2
    witness = found[0].rules["f"].witness
    assert witness is not None
    assert witness.binders == {"p": 2 if margin < 0 else 0}
