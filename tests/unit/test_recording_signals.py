"""Recordings carry any signal that a spec declares, of any kind: rules read it in `replay`, `explain`, faults and C as in operation."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from support.project import run_command
from trackmarshal.backends.c.build import compiler
from trackmarshal.scenarios import load
from trackmarshal.scenarios.recording_io import encode

SPEC = """module town

enum flag { green, yellow, red }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal race : state { flag: flag, lap: 1 default 0 }
signal sectors : set of object { from: m, to: m }
signal wind : series { v: m/s }
signal gate : polyline
event emergency "the candidate is the emergency trajectory"
event rain "it rains"

rule of_a_state "Slow under yellow"
  whenever  race.flag is yellow
  require   ego.v <= 10 m/s

rule of_a_set "Slow in a sector"
  for all   s in sectors where s.from <= ego.x <= s.to
  require   ego.v <= 10 m/s

rule of_a_series "No gusts"
  for all   w in wind
  require   w.v <= 8 m/s

rule of_a_line "Not at the gate"
  require   distance_to(ego, gate) >= 5 m

rule of_an_event "Slow in the rain, and for a second after it"
  whenever  once[0 s, 1 s] rain
  require   ego.v <= 10 m/s
"""
BACKENDS = ["numpy", "reference", *(["c"] if compiler() else [])]
ALWAYS: dict[str, Any] = {
    "gate": [[50.0, -5.0], [50.0, 5.0]],
    "sectors": [],
    "wind": {"v": [1.0, 2.0]},
    "race": {"flag": "green"},
    "rain": False,
}


def lines(*cycles: dict[str, Any], **header: Any) -> str:
    flat = {name: [0.0] * 2 for name in ("y", "heading", "kappa", "a")}
    plan = {"t": [0.0, 1.0], "x": [0.0, 20.0], "v": [20.0, 20.0], **flat}
    stop = {"t": [0.0, 4.0], "x": [0.0, 40.0], "v": [20.0, 0.0], **flat}
    head = {
        "format": "trackmarshal-recording",
        "version": 1,
        "name": "made",
        "track": {"left": [[-9, 5], [99, 5]], "right": [[-9, -5], [99, -5]]},
    }
    made = [
        {
            "t": float(k), "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 20.0}, "objects": [],
            "candidates": {"driving": plan, "emergency": stop}, **cycle,
        }
        for k, cycle in enumerate(cycles)
    ]  # fmt: skip
    return "".join(json.dumps(line) + "\n" for line in [{**head, **header}, *made])


@pytest.fixture(autouse=True)
def town(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("town.spec").write_text(SPEC)


@pytest.mark.parametrize("backend", BACKENDS)
def test_every_kind_is_read(backend: str) -> None:
    changes: list[dict[str, Any]] = [
        {}, {"race": {"flag": "yellow"}}, {"sectors": [{"id": "a", "from": -1.0, "to": 1.0}]}, {"wind": {"v": [9.0]}},
        {"gate": [[3.0, -5.0], [3.0, 5.0]]}, {"rain": True}, {}, {},
    ]  # fmt: skip
    Path("run.tmrec.jsonl").write_text(lines(*({"signals": each} for each in changes), signals=ALWAYS))
    status, out, err = run_command(
        "replay", "run.tmrec.jsonl", "--spec", "town.spec", "--backend", backend, "--format", "jsonl", "--exit-zero"
    )  # fmt: skip
    assert status == 0, err
    violated: dict[float, set[str]] = {}
    for line in map(json.loads, out.splitlines()):
        if line.get("candidate") == "driving":
            assert not line.get("faults"), line
            violated[line["t"]] = {
                name for name, rule in line["rules"].items() if rule["verdict"] == "violated"
            }
    assert violated == {
        0.0: set(), 1.0: {"of_a_state"}, 2.0: {"of_a_set"}, 3.0: {"of_a_series"}, 4.0: {"of_a_line"}, 5.0: {"of_an_event"},
        6.0: {"of_an_event"}, 7.0: set(),
    }  # fmt: skip


def test_explain_reads_them_too() -> None:
    Path("run.tmrec.jsonl").write_text(
        lines({"signals": {"rain": True}}, {"signals": {"race": {"flag": "yellow"}}}, signals=ALWAYS)
    )
    for rule, text in (("of_a_state", "race.flag = yellow"), ("of_an_event", "ego.v = 20")):
        status, out, err = run_command(
            "explain", "run.tmrec.jsonl", "--spec", "town.spec", "--rule", rule, "--at", "1"
        )
        assert status == 0, err
        assert "violated" in out
        assert rule == "of_a_state" or text in out, out


def test_they_are_written_as_they_were_read() -> None:
    Path("run.tmrec.jsonl").write_text(
        lines({"signals": {"rain": True, "wind": {"v": [1.0, "nan"]}}}, {}, signals=ALWAYS)
    )
    made = load("run.tmrec.jsonl")
    Path("again.tmrec.jsonl").write_text("\n".join(encode(made)) + "\n")
    again = load("again.tmrec.jsonl")
    assert list(encode(again)) == list(encode(made))
    assert again.always == ALWAYS
    assert again.cycles[0].more["rain"] is True


@pytest.mark.parametrize(
    ("where", "value", "code", "text"),
    [
        ("cycle", {"rian": True}, "D145", "did you mean `rain`?"),
        ("cycle", {"ego": {}}, "D141", "`ego` has its own place"),
        ("header", {"track": {}}, "D141", "`track` has its own place"),
        ("header", {"emergency": True}, "D141", "`emergency` has its own place"),
        ("cycle", [], "D141", "signals"),
        ("cycle", {"race": {"flag": "yelow"}}, "D237", "did you mean"),
        ("cycle", {"race": {"flags": "yellow"}}, "D", "flags"),
        ("cycle", {"wind": 3.0}, "D", "wind"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said(where: str, value: Any, code: str, text: str) -> None:
    header = {"signals": ALWAYS | value} if where == "header" else {"signals": ALWAYS}
    Path("run.tmrec.jsonl").write_text(lines({"signals": value} if where == "cycle" else {}, **header))
    status, out, err = run_command("replay", "run.tmrec.jsonl", "--spec", "town.spec")
    assert status in (1, 2)
    assert code in out + err
    assert text in out + err, out + err


def test_a_refused_cycle_is_shown_by_each_evaluator() -> None:
    """With rules that remember: it is judged before it becomes a gap."""
    changes: list[dict[str, Any]] = [
        {"rain": True},
        {"wind": 3.0},
        {"race": {"flag": "yelow"}},
        {"rain": True},
        {},
    ]
    Path("run.tmrec.jsonl").write_text(lines(*({"signals": each} for each in changes), signals=ALWAYS))
    said = []
    for backend in BACKENDS:
        arguments = ("--spec", "town.spec", "--backend", backend, "--format", "jsonl", "--exit-zero")
        status, out, err = run_command("replay", "run.tmrec.jsonl", *arguments)
        assert status == 0, err
        cycles = [json.loads(line) for line in out.splitlines() if '"candidate"' in line]
        said.append(
            [
                (c["t"], c["candidate"], {n: (r["verdict"], r["margin"]) for n, r in c["rules"].items()})
                for c in cycles
            ]
        )
    assert len({json.dumps(each) for each in said}) == 1
    verdicts = [rules["of_an_event"][0] for t, candidate, rules in said[0] if candidate == "driving"]
    assert verdicts == ["violated", "violated", "undefined", "violated", "violated"]
