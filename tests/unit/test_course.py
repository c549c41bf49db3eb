"""Courses: in a Supervisor, in an inline test, in `explain`, saved and restored; and at which sample a rule is judged."""

from __future__ import annotations

import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.project import run_command
from trackmarshal.backends.c.build import compiler
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.scenarios import load
from trackmarshal.scenarios.supervised import supervised
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
BACKENDS = ("reference", "numpy", "c")


class Rig:
    def __init__(self, backend: str, rules: str = SPEC, rate: int = 50) -> None:
        self.now, self.number, self.at = 0.0, -1, 0.0
        limits = Limits(rate=rate, longest_gap=10.0)
        self.supervisor: Any = supervisor(loads(rules), None, backend, limits, lambda: self.now)

    def step(self, v: float, planned: float = 30.0, after: float = 0.1) -> Any:
        self.now, self.number = round(self.now + after, 9), self.number + 1
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


@pytest.mark.parametrize("backend", BACKENDS)
def test_lived_and_planned_count_together_for_each_candidate(backend: str) -> None:
    rig = Rig(backend)
    assert _verdicts(rig.step(20.0)) == {"driving": ["satisfied"], "emergency": ["satisfied"]}
    assert _verdicts(rig.step(21.0)) == {"driving": ["violated"], "emergency": ["satisfied"]}
    for _ in range(10):  # a second later, the fast cycle still counts
        assert _verdicts(rig.step(20.0)) == {"driving": ["violated"], "emergency": ["satisfied"]}
    assert _verdicts(rig.step(20.0)) == {"driving": ["satisfied"], "emergency": ["satisfied"]}


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_gap_is_an_undefined_sample(backend: str) -> None:
    rig = Rig(backend)
    rig.step(20.0)
    rig.missed()
    assert rig.step(20.0).faults  # a number is missing: refused, too
    # The gap ends where the next cycle begins: 0.9 s after that it is still in the window, and a second after it no more.
    found = [_verdicts(rig.step(20.0))["driving"] for _ in range(12)]
    assert found == [["undefined"]] * 10 + [["satisfied"]] * 2


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_gap_is_in_a_window_ahead_that_lies_within_it(backend: str) -> None:
    """Nothing is known from 0.3 s to 0.6 s, and the windows, ahead of what was driven 0.4 s ago, are from 0.35 s to 0.38 s, and from 0.45 s to 0.48 s."""
    rule = 'rule later "x"\n  along driven as c\n  require once[0.4 s, 0.4 s] (always[0.15 s, 0.18 s] c.v <= 20 m/s)\n'
    rig = Rig(backend, SPEC.partition("rule")[0] + rule)
    for _ in range(3):
        rig.step(20.0)
    rig.missed()
    assert rig.step(20.0).faults
    assert [_verdicts(rig.step(20.0))["driving"] for _ in range(2)] == [["undefined"]] * 2


@pytest.mark.parametrize("backend", BACKENDS)
def test_of_no_cycle_there_is_no_gap_and_no_past(backend: str) -> None:
    rig = Rig(backend)
    rig.missed()
    assert _verdicts(rig.step(20.0)) == {"driving": ["satisfied"], "emergency": ["satisfied"]}


@pytest.mark.parametrize("backend", BACKENDS)
def test_each_sample_that_is_due_after_now_is_planned(backend: str) -> None:
    """Of two within a nanosecond none is left out; what is due now but for rounding is the sample that is now."""
    spec = loads(
        SPEC + 'rule slow "x" along driven as c require always c.v <= 50 m/s\n'
        'rule few "x" along driven as c at last require count(c.v > -1 m/s) == 3\n'
    )
    evaluator = Evaluator(spec, backend=backend)
    plan = {**_plan(0.0, 0.0), "t": [1e-17, 1.0, 1.0 + 2e-10], "v": [0.0, 0.0, 99.0]}
    signals = {"ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 0.0}, "plan": plan}
    said = evaluator.over_run().step(evaluator.read({"t": 0.0, "signals": signals})).rules
    assert (said["slow"].verdict, said["slow"].margin) == ("violated", -49.0)
    assert said["few"].verdict == "satisfied"


@pytest.mark.parametrize("backend", BACKENDS)
def test_of_a_plan_that_was_over_before_now_or_is_due_nobody_knows_when_nothing_is_known(
    backend: str,
) -> None:
    """None of its samples is due: what it says would be asked of no rule. One that ends now is not over."""
    spec = loads(
        SPEC + 'rule slow "x" along driven as c require always c.v <= 50 m/s\n'
        'rule timed "x" along driven as c require c.t == 0 s\n'
        'rule other "x" along driven as c require once ego.v <= 50 m/s\n'
    )
    evaluator = Evaluator(spec, backend=backend)
    found = []
    for last in (-0.1, 1e300, -1e-17, 0.5):
        plan = {**_plan(0.0, 0.0), "t": [-2.0, -1.0, last], "v": [99.0, 99.0, 0.0]}
        signals = {"ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 0.0}, "plan": plan}
        found.append(evaluator.over_run().step(evaluator.read({"t": 0.0, "signals": signals})))
    for rule in ("slow", "timed"):
        assert [one.rules[rule].verdict for one in found] == ["undefined"] * 2 + ["satisfied"] * 2
    assert [one.rules["other"].verdict for one in found] == ["satisfied"] * 4
    assert [one.safe for one in found] == [False, False, True, True]


def _said(run: Any, evaluator: Evaluator, t: float, v: float) -> tuple[str, float]:
    signals = {"ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": v}, "plan": _plan(v, 30.0)}
    result = run.step(evaluator.read({"t": t, "signals": signals})).rules["calm"]
    return result.verdict, result.margin


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_saved_and_restored(backend: str) -> None:
    evaluator = Evaluator(loads(SPEC), backend=backend)
    run = evaluator.over_run()
    _said(run, evaluator, 0.0, 21.0)
    run.missed()
    _said(run, evaluator, 0.2, math.inf)
    _said(run, evaluator, 0.3, 20.5)
    saved = run.save()
    later = evaluator.over_run(saved)
    for t in (0.4, 1.3, 1.5):
        assert repr(_said(later, evaluator, t, 20.0)) == repr(_said(run, evaluator, t, 20.0))
    assert any('"driven"' in line for line in saved) == (backend == "numpy")
    other = Evaluator(loads(SPEC.replace("for 2 s", "for 3 s")), backend=backend)
    with pytest.raises(TrackmarshalError, match="D164"):
        other.over_run(saved)


#: As SPEC; of more windows than one.
SHORT = (
    SPEC
    + """
rule short "What lies half a second back is still known"
  along     driven as c
  require   historically[0 s, 0.5 s] c.v <= 20 m/s
"""
)


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_more_cycles_than_there_is_room_for() -> None:
    """Room for 8 cycles: of what was before them nothing is known, and only rules that ask for it are undefined."""
    rig = Rig("c", SHORT, rate=2)
    found = [_both(rig.step(20.0)) for _ in range(15)]
    assert found[:9] == [("satisfied", "satisfied")] * 9
    assert found[9:] == [("undefined", "satisfied")] * 6
    slow = [_both(rig.step(20.0, after=0.2)) for _ in range(4)]
    assert slow == [("undefined", "satisfied")] * 2 + [("satisfied", "satisfied")] * 2


def _both(decision: Any) -> tuple[str, str]:
    """What `calm` and `short` say of the driving trajectory, whose speed is too much afterwards."""
    rated = decision.judged.rated["driving"]
    return rated.explain(0, False).verdict, rated.explain(1, False).verdict


#: What asks for times that lie wholly among cycles for which there was no room, for counts, and for what was just before.
ASKING = {
    "earlier": "historically[1 s, 1.5 s] c.v <= 20 m/s",
    "never": "not once[0.6 s, 2 s] c.v > 20 m/s",
    "since_then": "c.v <= 22 m/s since[0.5 s, 2 s] c.v > 24 m/s",
    "few": "count(c.v > 20 m/s, last: 1.8 s) <= 2",
    "some": "count(c.v > 20 m/s, last: 1 s) >= 1",
    "two": "count(c.v > 20 m/s, last: 1.8 s) == 2",
    "other": "count(c.v < 15 m/s, last: 1.8 s) != 1",
    "anew": "count(c.v > 20 m/s, reset: c.v < 15 m/s) <= 1",
    "before": "not (previous c.v > 20 m/s)",
}


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_of_more_cycles_than_there_is_room_for_nothing_else_is_said() -> None:
    """At ten times the rate, for seconds: what C is sure of is what the reference says, which knows every cycle. What it had no room for is
    undefined from the first of these cycles to the last, also to a window that no other cycle is in."""
    rules = SPEC + "".join(
        f'rule {name} "x"\n  along driven as c\n  require {one}\n' for name, one in ASKING.items()
    )
    crowded, reference = Rig("c", rules, rate=2), Rig("reference", rules)
    said: dict[str, Counter[tuple[str, str]]] = {name: Counter() for name in ("calm", *ASKING)}
    for number in range(90):
        v = 25.0 if number % 29 in (7, 8, 11) else 10.0 if number % 29 == 9 else 18.0
        decisions = [rig.step(v, 10.0, after=0.05) for rig in (crowded, reference)]
        assert not any(decision.faults for decision in decisions)
        found, wanted = (decision.judged.rated["driving"] for decision in decisions)
        for place, name in enumerate(said):
            one, other = (rated.explain(place, False).verdict for rated in (found, wanted))
            assert one in (other, "undefined"), (number, name)
            said[name][one, other] += 1
    for name, many in said.items():
        assert {other for _, other in many} == {"satisfied", "violated"}, (
            name
        )  # so that there is something to be unsure of
        assert name == "before" or ("undefined", "violated") in many, name


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_rules_by_themselves_say_that_there_is_no_room() -> None:
    with pytest.raises(TrackmarshalError, match="more than 256 MiB") as caught:
        Evaluator(loads(SPEC.replace("for 2 s", "for 360000 s")), backend="c").over_run()
    assert caught.value.code == "E473"
    evaluator = Evaluator(loads(SPEC.replace("for 2 s", "for 0.01 s")), backend="c")
    run = evaluator.over_run()
    for number in range(14):
        _said(run, evaluator, number / 1e5, 20.0)
    with pytest.raises(TrackmarshalError, match="cycles a second") as caught:
        _said(run, evaluator, 14 / 1e5, 20.0)
    assert caught.value.code == "E473"


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_cases_by_themselves_have_no_margins_along_a_course(backend: str) -> None:
    evaluator = Evaluator(loads(SPEC), backend=backend)
    plan = {name: np.array([column, column]) for name, column in _plan(20.0, 30.0).items()}
    ego = {"x": np.zeros(2), "y": np.zeros(2), "heading": np.zeros(2), "v": np.array([20.0, 21.0])}
    batch = evaluator.batch({"ego": ego, "plan": plan})
    assert [batch.case(number).rules["calm"].verdict for number in range(2)] == ["satisfied", "violated"]
    with pytest.raises(TrackmarshalError, match="E406"):
        batch.samples("calm")
    beside = SPEC + 'rule slow "x"\n  along plan as p\n  require p.v <= 25 m/s\n'
    both = Evaluator(loads(beside), backend=backend).batch({"ego": ego, "plan": plan})
    assert both.samples("slow").tolist() == [[5.0, -5.0, -5.0]] * 2


@pytest.mark.parametrize("backend", BACKENDS)
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


def _recorded() -> None:
    """Four cycles in `made.tmrec.jsonl`, the first one at 22 m/s."""
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


def test_explain_names_samples_from_now(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.spec").write_text(SPEC)
    _recorded()
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


@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_a_replay_knows_what_was_driven(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, backend: str
) -> None:
    """What is evaluated ahead for many cycles at once is without the course, which takes a decision after the other: 22 m/s stay within the second."""
    monkeypatch.chdir(tmp_path)
    _recorded()
    evaluator = Evaluator(loads(SPEC), backend=backend)
    rated = [judged.rated["driving"] for _, judged, _ in supervised(load("made.tmrec.jsonl"), evaluator, {})]
    assert [(VERDICTS[one.verdicts[0]], one.margins[0]) for one in rated] == [("violated", -2.0)] * 4


@pytest.mark.parametrize("backend", BACKENDS)
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


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_names_that_generated_c_has_itself() -> None:
    fields = "begin: m, end: m, missing: bool, now: m, count: m, first: m"
    text = (
        f"module m\nsignal ego : state {{ {fields} }}\nsignal plan : trajectory {{ t: s increasing, {fields} }}\n"
        + "".join(f"course {name} = ego for 1 s then plan\n" for name in ("x", "x_at", "lived", "double"))
        + "".join(
            f'rule r_{name} ""\n  along {name} as c\n  require once c.begin + c.end + c.now + c.count + c.first > c.t * 1 m/s or c.missing\n'
            for name in ("x", "x_at", "lived", "double")
        )
    )
    evaluator = Evaluator(loads(text), backend="c")
    values = {"begin": 1.0, "end": 1.0, "now": 1.0, "count": 1.0, "first": 1.0, "missing": False}
    plan = {"t": [0.0, 1.0], **{name: [value] * 2 for name, value in values.items()}}
    result = evaluator.over_run().step(evaluator.read({"t": 0.0, "signals": {"ego": values, "plan": plan}}))
    assert {rule.verdict for rule in result.rules.values()} == {"satisfied"}
