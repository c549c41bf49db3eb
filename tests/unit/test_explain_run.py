"""`explain` of rules over the run: which cycles, which comparison, which numbers; and of a rule that does not apply, what left it nothing."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from support.project import run_command
from trackmarshal.backends.over_run.history import History
from trackmarshal.backends.over_run.keeping import past
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.explaining.trail import Trail

SPEC = """module town

signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { x: m, y: m, heading: rad, v: m/s }
event emergency "the candidate is the emergency trajectory"

param near : m = 12 m
define gap(o: moving) -> m = abs(o.x - ego.x)

state mood : { calm, hasty } starts calm
  becomes hasty from calm when ego.v > 24 m/s
    remember pace = ego.v
  becomes calm from hasty when ego.v < 12 m/s

state met : { no, final yes } for each o in objects starts no
  becomes yes from no when o.x < 999 m
    remember first = o.x

rule apart "Of two, the farther one began farther away"
  for all   o in objects
  for all   q in objects where q.x > o.x
  require   gap(o) + 0.5 * met(q).first <= gap(q) - met(o).first

rule brake "After 20 m/s, the car is below 15 m/s within half a second"
  whenever  rising(ego.v > 20 m/s)
  within    0.5 s
  require   ego.v <= 15 m/s

rule grace "Whoever came near has 0.3 s"
  for all   o in objects where o.v > 1 m/s
  except    once[0 s, 0.3 s] falling(gap(o) >= near) "it has only just come so near"
  require   gap(o) >= near

rule steady "No jump in the last second"
  require   historically[0 s, 1 s] ego.v <= 23 m/s

rule kept "Held since the last slow cycle"
  require   ego.v <= 22 m/s since ego.v <= 18 m/s

rule seldom "Fast in two cycles at most"
  require   count(ego.v > 20 m/s, last: 1 s) <= 2

rule in_state "Never hasty"
  require   mood is calm

rule pace "What is remembered"
  whenever  mood is hasty
  require   mood.pace <= 20 m/s

rule before "Slower than 3 m/s the cycle before"
  require   previous ego.v <= 3 m/s

rule slow "Only in an emergency"
  whenever  emergency
  require   once plan.last.v <= 1 m/s
"""
#: The car's speed in each cycle of 0.1 s; the other car comes nearer by 2 m in each.
SPEEDS = [15, 16, 17, 21, 22, 23, 24, 25, 19, 18, 17, 16]


@pytest.fixture
def explain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    monkeypatch.chdir(tmp_path)
    Path("town.spec").write_text(SPEC)
    lines: list[dict[str, Any]] = [
        {"format": "trackmarshal-recording", "version": 1, "name": "made",
         "track": {"left": [[-99, 5], [999, 5]], "right": [[-99, -5], [999, -5]]}}
    ]  # fmt: skip
    for k, v in enumerate(SPEEDS):
        flat = {name: [0.0] * 2 for name in ("y", "heading", "kappa", "a")}
        plan = {"t": [0.0, 1.0], "x": [0.0, 25.0], "v": [float(v), float(v)], **flat}
        stop = {"t": [0.0, 4.0], "x": [0.0, 25.0], "v": [float(v), 0.0], **flat}
        size = {"y": 9.0, "heading": 0.0, "length": 4.0, "width": 2.0}
        others = [{"id": "red", "x": 20.0 - 2 * k, "v": 3.0, **size}]
        others += [{"id": "parked", "x": 300.0, "v": 0.0, **size}]
        ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": float(v)}
        candidates = {"driving": plan, "emergency": stop}
        lines.append({"t": round(0.1 * k, 1), "ego": ego, "objects": others, "candidates": candidates})
    Path("run.tmrec.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))

    def run(rule: str, at: float, candidate: str = "driving") -> str:
        status, out, err = run_command(
            "explain", "run.tmrec.jsonl", "--spec", "town.spec", "--rule", rule, "--at", f"{at:g}", "--candidate", candidate
        )  # fmt: skip
        assert status == 0, err
        return out

    return run


def test_a_deadline_names_the_cycle_it_is_about_and_the_one_that_came_nearest(
    explain: Callable[..., str],
) -> None:
    out = explain("brake", 0.8)
    assert "violated, margin -4 m/s" in out
    assert "about the cycle at 0.8 s: inactive" in out
    assert "about the cycle at 0.3 s: violated, margin -4 m/s" in out
    assert "the same in all 6 cycles from 0.3 s to 0.8 s, nearest to its limit at 0.8 s" in out
    assert "ego.v <= 15 m/s" in out
    assert "left side = 19 m/s" in out
    assert "ego.v = 19" in out


def test_what_is_open_says_so(explain: Callable[..., str]) -> None:
    out = explain("brake", 0.5)
    assert "about the cycle at 0.5 s: inactive" in out
    assert "whenever rising(ego.v > 20 m/s): does not hold" in out
    assert "violated" not in out


def test_an_element_left_out_is_named_with_the_reason(explain: Callable[..., str]) -> None:
    out = explain("grace", 0.6)
    assert "inactive" in out
    assert "red: left out, it has only just come so near" in out
    assert "parked: its `where` does not hold" in out


def test_what_definitions_came_to(explain: Callable[..., str]) -> None:
    out = explain("grace", 0.9)
    assert "decided at o = red" in out
    assert "gap = 2" in out
    assert "town.near = 12" in out


def test_of_several_numbers_that_go_by_one_name_each_is_told(explain: Callable[..., str]) -> None:
    """`gap` and `town.met.first` were told once, of one object, and nothing said of which."""
    out = explain("apart", 0.2).splitlines()
    assert [line.strip() for line in out if "gap" in line or "first =" in line] == [
        "by town.spec:23:13: gap(o) + 0.5 * met(q).first <= gap(q) - met(o).first",
        "gap(o) = 16 m",
        "gap(q) = 300 m",
        "town.met[0].first = 20 m",
        "town.met[1].first = 300 m",
    ]


@pytest.mark.parametrize(
    ("rule", "at", "expected"),
    [
        ("steady", 1.1, ["historically[0 s, 1 s] ego.v <= 23 m/s: by the cycle at 0.7 s", "ego.v = 25"]),
        ("steady", 0.2, ["the same in all 3 cycles from 0 s to 0.2 s, nearest to its limit at 0.2 s", "ego.v = 17"]),
        ("kept", 0.4, ["since ego.v <= 18 m/s: by the cycle at 0.4 s", "ego.v <= 22 m/s", "ego.v = 22"]),
        ("kept", 0.6, ["by the cycle at 0.6 s", "ego.v = 24"]),
        ("seldom", 0.6, ["4 (0.3 s, 0.4 s, 0.5 s, 0.6 s), to be compared with 2"]),
        ("in_state", 0.9, ["mood at 0.9 s: hasty for 0.2 s"]),
        ("pace", 0.9, ["mood.pace = 25", "left side = 25 m/s"]),
        ("before", 0.0, ["previous ego.v <= 3 m/s: there is no such cycle"]),
        ("before", 0.1, ["previous ego.v <= 3 m/s: by the cycle at 0 s", "ego.v = 15"]),
        ("slow", 0.3, ["whenever emergency: does not hold"]),
    ],
)  # fmt: skip
def test_each_operator(explain: Callable[..., str], rule: str, at: float, expected: list[str]) -> None:
    out = explain(rule, at)
    for text in expected:
        assert text in out, out


@pytest.mark.acceptance  # some of them every day
def test_every_rule_at_every_cycle_says_something(explain: Callable[..., str]) -> None:
    for rule in ("brake", "grace", "steady", "kept", "seldom", "in_state", "pace", "before", "slow"):
        for k in range(1, len(SPEEDS), 5):
            for candidate in ("driving", "emergency"):
                assert f"{rule}: " in explain(rule, 0.1 * k, candidate)


@pytest.mark.parametrize(
    ("quantifier", "objects", "verdict", "element"),
    [
        ("for all", [(-9.0, None), (-1.0, True)], "violated", "b"),
        ("exists", [(9.0, None), (1.0, True)], "satisfied", "b"),
        ("for all", [(3.0, None), (-3.0, None)], "undefined", "b"),
        ("exists", [(-3.0, None), (3.0, None)], "undefined", "b"),
    ],
)
def test_who_may_be_in_range_decides_only_where_that_is_enough(
    quantifier: str, objects: list[tuple[float, bool | None]], verdict: str, element: str
) -> None:
    """As without a memory: `tests/unit/test_witness.py`."""
    evaluator = Evaluator(
        loads(
            "module m\nsignal objects : set of object { v: m/s, near: bool }\n"
            f'rule f "" {quantifier} o in objects where o.near require once o.v > 0 m/s\n'
        )
    )
    given = [{"id": name, "v": v, "near": near} for name, (v, near) in zip("ab", objects)]
    history = History([past(evaluator.spec, evaluator.read({"t": 0.0, "signals": {"objects": given}}), 0)])
    formula = evaluator.rules[0].formula
    assert formula is not None
    assert history.value(formula, 0, {}).value.verdict == verdict
    trail = Trail(history)
    assert trail.find(formula, 0, {}) is not None
    assert trail.binders == {"o": element}


def told(formula: str, *speeds: tuple[float, float, float]) -> tuple[str, list[str]]:
    """The verdict of a formula about the last of some cycles, of their stamps and two speeds, and what is said of its operators."""
    rule = f'rule f "" require {formula}\n'
    evaluator = Evaluator(loads("module m\nsignal ego : state { v: m/s, w: m/s }\n" + rule))
    read = (evaluator.read({"t": t, "signals": {"ego": {"v": v, "w": w}}}) for t, v, w in speeds)
    history = History([past(evaluator.spec, frame, 0) for frame in read])
    made = evaluator.rules[0].formula
    assert made is not None
    trail, last = Trail(history), len(speeds) - 1
    trail.find(made, last, {})
    return history.value(made, last, {}).value.verdict, trail.said


#: In the cycle at 1 s, w / v is 0 / 0, which is undefined.
CYCLES = (0.0, 5.0, 1.0), (1.0, 0.0, 0.0), (2.0, 5.0, 1.0)


def test_what_comes_before_a_cycle_that_may_start_a_count_anew_counts_perhaps() -> None:
    counted = "count(ego.v >= 0 m/s, reset: ego.w / ego.v > 1) <= 2"
    said = f"{counted}: 2 (1 s, 2 s, and perhaps in 1 more), to be compared with 2"
    assert told(counted, *CYCLES) == ("undefined", [said])


@pytest.mark.parametrize(
    ("formula", "verdict", "said"),
    [
        ("once[0 s, 9 s] ego.w / ego.v > 1", "undefined", "by the cycle at 1 s"),
        ("historically[0 s, 9 s] ego.w / ego.v < 1", "undefined", "by the cycle at 1 s"),
        (
            "once[0 s, 9 s] ego.v > 5 m/s",
            "violated",
            "the same in all 3 cycles from 0 s to 2 s, nearest to its limit at 2 s",
        ),
        ("once[0 s, 9 s] ego.v > 4 m/s", "satisfied", "by the cycle at 2 s"),
    ],
)
def test_one_cycle_without_a_value_is_not_all_of_them(formula: str, verdict: str, said: str) -> None:
    assert told(formula, *CYCLES) == (verdict, [f"{formula}: {said}"])
