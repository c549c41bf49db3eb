"""Margins are shown in the unit in which the limit is written, with SI beside it; machine formats keep SI."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from support.project import run_command
from support.report_runs import cycle, evaluator, recording
from trackmarshal.evaluation import BACKENDS, load
from trackmarshal.scenarios.replay import replay
from trackmarshal.scenarios.run_record import run_record
from trackmarshal.trace.report.reading import read_run
from trackmarshal.trace.report.words import measured
from trackmarshal.units import beside, written

HEAD = """module small
signal ego : state { x: m, v: m/s, limit: km/h, turn: rad, share: 1 }
param v_max : km/h = 72 km/h
param v_si : m/s = 20 m/s
param v_pit : m/s = 72 km/h
param v_low : m/s = -3.6 km/h
param v_made : m/s = 2 * 36 km/h
param plain : 1 = 2
table drive(v: m/s) -> m/s^2 = linear clamp | 0 km/h: 12960 km/h^2 | 36 km/h: 12960 km/h^2 |
table grip(v: m/s) -> km/h^2 = linear clamp | 0 m/s: 12960 km/h^2 |
define slow(v: m/s) -> m/s = v - 36 km/h
define town -> km/h = 50 km/h
predicate fine(v: m/s, limit: m/s) = v <= limit
"""

#: A condition, the unit in which it is written, and its margin for v = 30 m/s.
CONDITIONS = [
    ("ego.v <= 72 km/h", "km/h", "-36 km/h"),
    ("ego.v <= 20 m/s", "m/s", "-10 m/s"),
    ("72 km/h >= ego.v", "km/h", "-36 km/h"),
    ("ego.v <= v_max", "km/h", "-36 km/h"),
    ("ego.v <= v_si", "m/s", "-10 m/s"),
    ("ego.v <= v_pit", "km/h", "-36 km/h"),  # of a value in km/h
    ("ego.v <= v_low", "km/h", "-111.6 km/h"),
    ("ego.v <= v_made", "m/s", "-10 m/s"),  # declared so
    ("ego.v / 10 s <= drive(ego.v)", "km/h^2", "-25920 km/h^2"),
    ("ego.v <= 1.5 * v_max", "km/h", "0 km/h"),
    ("ego.v <= v_max * plain / 4", "km/h", "-72 km/h"),
    ("ego.v <= -(-72 km/h)", "km/h", "-36 km/h"),
    ("ego.v <= v_max + 18 km/h", "km/h", "-18 km/h"),
    ("ego.v <= min(v_max, 90 km/h)", "km/h", "-36 km/h"),
    ("ego.v <= if ego.x > 0 m then 72 km/h else 36 km/h", "km/h", "-72 km/h"),
    ("ego.v <= ego.limit", "km/h", "-8 km/h"),  # declared so
    ("ego.v - 36 km/h <= ego.limit", "km/h", "28 km/h"),
    ("ego.v in [0 km/h, 72 km/h]", "km/h", "-36 km/h"),
    ("slow(ego.v) <= 36 km/h", "km/h", "-36 km/h"),
    ("ego.v <= town", "km/h", "-58 km/h"),
    ("fine(ego.v, 72 km/h)", "km/h", "-36 km/h"),
    ("ego.v <= v_si + 36 km/h", "", "0 m/s"),  # in two units: in SI
    ("ego.v * 1 s <= 20 m", "m", "-10 m"),
    ("ego.v * 1 h <= 72 km", "km", "-36 km"),
    ("ego.v^2 <= (72 km/h)^2", "", "-500 m^2/s^2"),
    ("ego.v / 10 s <= grip(ego.v)", "km/h^2", "-25920 km/h^2"),
    ("abs(ego.turn) <= 30 deg", "deg", "-60 deg"),
    ("abs(ego.turn) <= 0.5", "", "-1.071"),
    ("ego.share <= 20 %", "%", "-30 %"),
    ("ego.share <= 0.2", "", "-0.3"),
]
VALUES = {"x": 0.0, "v": 30.0, "limit": 100.0, "turn": math.pi / 2, "share": 0.5}


def close(text: str, wanted: str) -> bool:
    number, _, unit = text.partition(" ")
    expected, _, other = wanted.partition(" ")
    return unit == other and math.isclose(float(number), float(expected), rel_tol=1e-3, abs_tol=1e-9)


@pytest.mark.parametrize(
    "backend", [name for name in BACKENDS if name != "auto"]
)  # which is one of the others
def test_the_written_unit_comes_from_the_limit(
    backend: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    rules = "".join(f"rule r{i} require {text}\n" for i, (text, _, _) in enumerate(CONDITIONS))
    Path("small.spec").write_text(HEAD + rules)
    Path("case.jsonl").write_text(json.dumps({"signals": {"ego": VALUES}}) + "\n")
    status, out, err = run_command(
        "eval", "small.spec", "--data", "case.jsonl", "--backend", backend, "--format", "jsonl"
    )
    assert status == 1, err
    found = json.loads(out)["rules"]
    spec = load("small.spec")
    for i, (text, unit, shown) in enumerate(CONDITIONS):
        result = found[f"r{i}"]
        assert close(result["shown"], shown), (text, result)
        assert close(result["decides"]["shown"], shown), (text, result)
        # Machine formats keep SI, to the bit.
        si = spec.rule(f"r{i}")
        assert si is not None
        assert result["unit"] == si.unit
        assert "km/h" not in result["unit"]
        if unit:
            assert close(written(result["margin"], "?", unit), shown), text
        else:
            assert close(written(result["margin"], result["unit"]), shown), text


def test_two_units_in_one_rule_are_each_shown_in_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("small.spec").write_text(HEAD + "rule both require ego.v <= 72 km/h and ego.v >= 40 m/s\n")
    for v, shown in ((30.0, "-36 km/h"), (10.0, "-30 m/s")):
        Path("case.jsonl").write_text(json.dumps({"signals": {"ego": {**VALUES, "v": v}}}) + "\n")
        _, out, _ = run_command("eval", "small.spec", "--data", "case.jsonl", "--format", "jsonl")
        assert json.loads(out)["rules"]["both"]["shown"] == shown


def test_the_unit_changes_no_fingerprint_but_by_what_is_written(tmp_path: Path) -> None:
    """The unit in which a parameter is written says how margins are shown, not what the rule means."""
    rule = "rule fast require ego.v <= v_max\n"
    (tmp_path / "a.spec").write_text(HEAD + rule)
    (tmp_path / "b.spec").write_text(
        HEAD.replace("param v_max : km/h = 72 km/h", "param v_max : m/s = 20 m/s") + rule
    )
    a, b = (load(tmp_path / name).rule("fast") for name in ("a.spec", "b.spec"))
    assert a is not None
    assert b is not None
    assert a.fingerprint == b.fingerprint


def test_what_is_shown() -> None:
    assert written(-3.4444444, "m/s", "km/h") == "-12.4 km/h"
    assert beside(-3.4444444, "m/s", "km/h") == "-12.4 km/h (-3.444 m/s)"
    assert beside(-3.4444444, "m/s", "m/s") == "-3.444 m/s"
    assert beside(-3.4444444, "m/s") == "-3.444 m/s"
    assert beside(math.radians(-5), "1", "deg") == "-5 deg (-0.08727)"
    assert beside(0.25, "1") == "0.25"
    assert beside(math.inf, "m/s", "km/h") == "inf km/h"
    assert written(math.nan, "m/s", "km/h") == "nan km/h"


# In text -----------------------------------------------------------------------------------------------------------

PLAN = """module town
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
rule fast "Not too fast"
  for all p in plan
  require p.v <= 72 km/h

test fast "a wrong margin"
  given plan = line(v: 25 m/s, length: 10 m)
  expect violated, margin about -5 m/s within 1 km/h

test fast "a wrong verdict"
  given plan = line(v: 25 m/s, length: 10 m)
  expect satisfied
"""
SHOWN, SI = "-18 km/h", "-5 m/s"


@pytest.fixture
def town(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("town.spec").write_text(PLAN)
    columns = {
        "t": [0.0, 1.0],
        "x": [0.0, 25.0],
        "y": [0.0] * 2,
        "heading": [0.0] * 2,
        "kappa": [0.0] * 2,
        "v": [25.0] * 2,
        "a": [0.0] * 2,
    }
    head = {
        "format": "trackmarshal-recording",
        "version": 1,
        "name": "made",
        "track": {"left": [[-9, 5], [99, 5]], "right": [[-9, -5], [99, -5]]},
    }
    stop = {**columns, "t": [0.0, 4.0], "v": [20.0, 0.0]}
    made = {
        "t": 0.0,
        "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 25.0},
        "objects": [],
        "candidates": {"driving": columns, "emergency": stop},
    }
    Path("run.tmrec.jsonl").write_text(json.dumps(head) + "\n" + json.dumps(made) + "\n")
    declared = {name: columns[name] for name in ("t", "x", "y", "heading", "v")}
    case = {"id": 1, "signals": {"plan": declared}}
    Path("case.jsonl").write_text(json.dumps(case) + "\n")


@pytest.mark.parametrize(
    "arguments",
    [
        ("eval", "town.spec", "--data", "case.jsonl"),
        ("replay", "run.tmrec.jsonl", "--spec", "town.spec"),
        ("explain", "run.tmrec.jsonl", "--spec", "town.spec", "--rule", "fast", "--at", "0", "--candidate", "driving"),
        ("test", "town.spec"),
    ],
    ids=lambda arguments: arguments[0],
)  # fmt: skip
def test_text_shows_both(arguments: tuple[str, ...], town: None) -> None:
    _, out, err = run_command(*arguments)
    assert SHOWN in out, out + err
    assert SI in out


def test_sides_of_a_comparison_are_in_it_too(town: None) -> None:
    arguments = ("--spec", "town.spec", "--rule", "fast", "--at", "0", "--candidate", "driving")
    out = run_command("explain", "run.tmrec.jsonl", *arguments)[1]
    assert "left side = 90 km/h (25 m/s)" in out
    assert "right side = 72 km/h (20 m/s)" in out


def test_lines_of_replay_have_both(town: None) -> None:
    out = run_command("replay", "run.tmrec.jsonl", "--spec", "town.spec", "--format", "jsonl")[1]
    rule = json.loads(out.splitlines()[0])["rules"]["fast"]
    assert (rule["margin"], rule["unit"], rule["shown"]) == (-5.0, "m/s", "-18 km/h")


def test_reports_draw_the_written_unit(tmp_path: Path) -> None:
    spec = PLAN.split("test fast", maxsplit=1)[0].replace("module town", "module small")
    rules = evaluator(tmp_path, spec)
    run = replay(recording([cycle(0.0, 0.0, v=25.0), cycle(0.1, 2.0, v=30.0)]), rules)
    record = json.loads(json.dumps(run_record(run, rules), allow_nan=False))
    (entry,) = record["rules"]
    assert (entry["unit"], entry["shown"]) == ("m/s", "km/h")
    assert entry["candidates"]["driving"]["margin"] == [-5.0, -10.0]  # SI, to the bit
    (rule,) = read_run(record).rules
    assert rule.unit == "km/h"
    assert rule.lanes["driving"].margin == pytest.approx([-18.0, -36.0])
    worst = entry["candidates"]["driving"]["firings"][0]["worst"]
    assert measured(worst) == "−36 km/h (−10 m/s)"
    assert measured(worst, False) == "−36 km/h"
    for moment in (entry, worst):  # a record of an older version
        moment.pop("shown")
    (old,) = read_run(record).rules
    assert (old.unit, old.lanes["driving"].margin) == ("m/s", [-5.0, -10.0])
    assert measured(worst) == "−10 m/s"
