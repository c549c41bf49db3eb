"""Enumerations where specs and data are read, laid out, tested, recorded and explained."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator

import trackmarshal as tm
from support import typed
from trackmarshal import scenarios
from trackmarshal.backends.c.build import compiler
from trackmarshal.cli.main import main
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.evaluation import Evaluator, load, loads
from trackmarshal.process.messages import Entry, LinkError
from trackmarshal.runtime import declared
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.record.reading import read
from trackmarshal.scenarios import recording_io
from trackmarshal.scenarios.recording import Cycle as RecordedCycle
from trackmarshal.scenarios.recording import Recording
from trackmarshal.source import of_text
from trackmarshal.supervision import box_of, rerun, supervisor
from trackmarshal.syntax.format import format_text

SPEC = """module m
enum flag { green, yellow, red }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, lane: flag default green }
signal ego : state { x: m, y: m, heading: rad, seen: flag default red, lit: bool default true }
signal objects : set of object { x: m, seen: flag default yellow, braking: bool default false }
rule seen "what the car sees" require ego.seen is green or ego.lit
rule lanes "on green" for all p in plan require p.lane is green
rule others "nobody sees red" for all o in objects where not o.braking require not o.seen is red
"""


def test_the_layout_is_one() -> None:
    loose = 'enum   flag\n  "x" {green,\nyellow,}\nsignal r : state {f:flag default yellow,b:bool default false}\n'
    laid = 'enum flag "x" { green, yellow }\nsignal r : state { f: flag default yellow, b: bool default false }\n'
    assert format_text(of_text(f"module m\n\n{loose}")) == f"module m\n\n{laid}"


def test_comments_between_members_and_branches_stay() -> None:
    text = (
        "module m\n\nenum flag {\n  green,\n  -- slow\n  yellow,\n}\n\nsignal r : state { f: flag, v: m/s }\n"
    )
    assert "-- slow" in format_text(of_text(text))
    rule = text + 'rule a "x" require r.v <= case r.f { green: 3 m/s, -- fast\n yellow: 2 m/s }\n'
    assert "-- fast" in format_text(of_text(rule))


@pytest.mark.parametrize(
    "rule", ["require race.flag is lamp.flag", "require green(race)"], ids=["asked for", "by a shape"]
)
def test_two_of_one_name_are_told_apart_by_their_modules(tmp_path: Path, rule: str) -> None:
    (tmp_path / "one.spec").write_text(
        "module one\nenum flag { green, red }\nsignal race : state { flag: flag }\n"
    )
    (tmp_path / "two.spec").write_text(
        "module two\nenum flag { red, green }\nsignal lamp : state { flag: flag }\nshape lit = { flag: flag }\n"
        "predicate green(o: lit) = o.flag is green\n"
    )
    path = tmp_path / "main.spec"
    path.write_text(f'module main\nuse one\nuse two\nrule a "x" {rule}\n')
    with pytest.raises(Diagnostics) as failed:
        load([path], [], tmp_path)
    assert "`one.flag`" in str(failed.value)
    assert "`two.flag`" in str(failed.value)


def test_a_word_of_the_language_is_no_member() -> None:
    with pytest.raises(Diagnostics, match="E101"):
        loads("module m\nenum flag { green, case }\n")


def test_modules_share_one_declaration(tmp_path: Path) -> None:
    (tmp_path / "a.spec").write_text(
        "module a\nenum flag { green, red }\nsignal race : state { flag: flag }\n"
    )
    (tmp_path / "b.spec").write_text(
        'module b\nuse a\nsignal race : state { flag: flag }\nrule r "" require race.flag is red\n'
    )
    spec = tm.load([tmp_path])
    field = spec.signals["race"].field("flag")
    assert field is not None
    assert field.enumeration is not None
    assert (field.enumeration.name, field.enumeration.members) == ("a.flag", ("green", "red"))
    (tmp_path / "c.spec").write_text("module c\nuse b\nsignal other : state { flag: flag }\n")
    with pytest.raises(Diagnostics, match="E106"):
        tm.load([tmp_path / "c.spec"])


def test_tests_of_specs_give_members_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "m.spec").write_text(
        SPEC
        + """
test seen "green" given ego = { x: 0 m, seen: green, lit: false } expect satisfied
test seen "red, by default" given ego = { x: 0 m, lit: false } expect violated
test seen "lit, by default" given ego = { x: 0 m } expect satisfied
test seen "missing" given ego = { x: 0 m, seen: nan, lit: false } expect undefined
test lanes "one sample changed"
  given plan = { t: [0 s, 1 s], lane: [green, green] } with lane[1] = yellow
  expect violated, at p = 1
test lanes "a column that was left out, changed" given plan = { t: [0 s, 1 s] } with lane = red expect violated
test lanes "left out" given plan = { t: [0 s, 1 s] } expect satisfied
test others "by default" given objects = [{ x: 0 m }, { x: 1 m, seen: red, braking: true }] expect satisfied
test others "red" given objects = [{ x: 0 m }, { x: 1 m, seen: red }] expect violated, at o = "1"
"""
    )
    status = main(["test", str(tmp_path / "m.spec"), "--quiet"])
    assert (status, capsys.readouterr().err) == (0, "")


# Booleans that are left out -------------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_defaults_of_booleans(backend: str) -> None:
    evaluator = Evaluator(loads(SPEC), ["seen", "others"], backend)

    def safe(ego: Any, objects: Any) -> Any:
        frame = evaluator.read({"signals": {"ego": ego, "objects": objects}})
        (result,) = evaluator.evaluate([frame])
        return [rule.verdict for rule in result.rules.values()], [name_of(fault) for fault in frame.faults]

    red = {"x": 0, "seen": "red"}
    assert safe({}, [red]) == (["satisfied", "violated"], [])
    assert safe({"lit": False}, [{**red, "braking": True}]) == (["violated", "inactive"], [])
    assert safe({"lit": None}, [{**red, "braking": None}]) == (
        ["undefined", "undefined"],
        ["not_finite", "not_finite"],
    )
    assert safe({}, [{**red, "braking": True}, red]) == (["satisfied", "violated"], [])
    assert safe({}, {"x": [0, 0], "seen": ["red", "red"], "braking": [True, True]}) == (
        ["satisfied", "inactive"],
        [],
    )
    assert safe({}, {"x": [0, 0], "seen": ["red", "green"]}) == (["satisfied", "violated"], [])
    assert safe({}, []) == (["satisfied", "inactive"], [])


# Recordings and records -------------------------------------------------------------------------------------------


def recording(**more: Any) -> Recording:
    plan: dict[str, Any] = {
        "t": [0.0, 0.1],
        "s": [0.0, 1.0],
        **{n: [0.0, 0.0] for n in ("x", "y", "heading", "kappa", "v", "a")},
    }
    ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 0.0, "seen": "green", "lit": False, **more}
    cycle = RecordedCycle(
        0.0,
        ego,
        [{"id": "a", "x": 1.0, "seen": "yellow"}],
        {"driving": plan | {"lane": ["green", "red"]}, "emergency": plan},
    )
    return Recording(
        "r",
        "r.tmrec.jsonl",
        (cycle,),
        {"left": [[0.0, 1.0], [1.0, 1.0]], "right": [[0.0, -1.0], [1.0, -1.0]], "closed": False},
    )


def test_recordings_have_members_by_name(tmp_path: Path) -> None:
    path = tmp_path / "r.tmrec.jsonl"
    recording_io.write(recording(), path)
    assert scenarios.load(path) == recording()
    schema = json.loads(Path(recording_io.__file__).with_name("recording.schema.json").read_text("utf-8"))
    lines = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
    assert [list(Draft202012Validator(schema).iter_errors(line)) for line in lines] == [[], []]
    for name in ("x", "v"):
        wrong = {**lines[1], "ego": {**lines[1]["ego"], name: "green"}}
        assert list(Draft202012Validator(schema).iter_errors(wrong))
        path.write_text("\n".join(map(json.dumps, (lines[0], wrong))), "utf-8")
        with pytest.raises(tm.TrackmarshalError, match=f"ego.{name}"):
            scenarios.load(path)


def test_explain_shows_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, spec = tmp_path / "r.tmrec.jsonl", tmp_path / "m.spec"
    recording_io.write(recording(), path)
    spec.write_text(SPEC)
    assert main(["explain", str(path), "--rule", "lanes", "--at", "0", "--spec", str(spec), "--quiet"]) in (
        0,
        1,
    )
    assert "plan[1].lane = red" in capsys.readouterr().out


def cycle(number: int, **ego: Any) -> Cycle:
    plan = {"t": np.array([0.0, 1.0]), **{name: np.zeros(2) for name in ("x", "y", "heading", "v")}}
    signals = {
        "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, **ego},
        "objects": {"x": np.zeros(2), "seen": np.array(["green", "yellow"])},
    }
    return Cycle(number, float(number), plan, dict(plan), signals)


def test_a_record_is_replayed_with_members(tmp_path: Path) -> None:
    path, now = tmp_path / "run.arrow", [0.0]
    spec = loads(SPEC)
    live = supervisor(spec, limits=typed.LIMITS, clock=lambda: now[0], record=path)
    given = [
        cycle(0, seen="green"),
        cycle(1, seen=np.str_("red"), lit=False),
        cycle(2, seen="yelow"),
        cycle(3, seen=1),
        cycle(4),
    ]
    given[3].signals["objects"]["seen"] = np.array(["green", "grey"])
    decisions = []
    for now[0], one in enumerate(given):
        decisions.append(live.step(one))
    live.close()
    assert [decision.safe for decision in decisions] == [True, False, False, False, True]
    run = read(path.read_bytes(), str(path))
    again = list(rerun(run, box_of(run, spec)))
    assert [(decision.safe, found) for decision, found in again] == [
        (decision.safe, []) for decision in decisions
    ]
    assert [[name_of(f) for f in decision.faults] for decision in decisions] == [
        [],
        [],
        ["no_member"],
        ["no_member"],
        [],
    ]


#: The same members in other places, and one more.
WIDER = SPEC.replace("green, yellow, red", "grey, red, yellow, green")
#: Of fields that are no SI, cycles are kept as they came in.
IN_KMH = ("v: m/s, lane", "v: m/s, w: km/h default 0 km/h, lane")


def driven(path: Path, text: str, given: list[Cycle]) -> list[bool]:
    """What a Supervisor says of cycles, and keeps."""
    now = [0.0]
    live = supervisor(loads(text), limits=typed.LIMITS, clock=lambda: now[0], record=path)
    safe = []
    for now[0], one in enumerate(given):
        safe.append(live.step(one).safe)
    live.close()
    return safe


def of_places(number: int, **ego: Any) -> Cycle:
    """A cycle with members as a planner in C has them: numbers, of each kind."""
    one = cycle(number, **ego)
    one.driving["lane"] = np.zeros(2, dtype=np.uint8)
    one.signals["objects"] = {"x": np.zeros(2), "seen": [0, np.float32(1)]}
    return one


@pytest.mark.parametrize("text", [SPEC, SPEC.replace(*IN_KMH)])
def test_a_record_has_members_that_another_enumeration_puts_elsewhere(tmp_path: Path, text: str) -> None:
    path = tmp_path / "run.arrows"
    given = [
        of_places(0, seen=0, lit=False),
        of_places(1, seen=2, lit=False),
        of_places(2, seen=np.int8(1), lit=False),
        of_places(3, seen=0, lit=False),
        of_places(4, seen=0, lit=False),
    ]
    given[3].driving["lane"] = [0, 2]
    given[4].signals["objects"] = [{"x": 0.0, "seen": 1}, {"x": 0.0, "seen": 2}]
    safe = driven(path, text, given)
    assert safe == [True, False, False, False, False]
    run = read(path.read_bytes(), str(path))
    for other in (text, text.replace("green, yellow, red", "grey, red, yellow, green")):
        assert [decision.safe for decision, _ in rerun(run, box_of(run, loads(other)))] == safe
        outcome = tm.replay(tm.load_recording(path), tm.Evaluator(loads(other)))
        assert [all(one.safe for one in outcome.results.values()) for outcome in outcome.cycles] == safe
    same = [found for _, found in rerun(run, box_of(run, loads(text)))]
    assert same == [[]] * 5
    gone = text.replace("green, yellow, red", "green, red").replace("default yellow", "default green")
    for decision, _ in rerun(run, box_of(run, loads(gone))):
        assert {name_of(fault) for fault in decision.faults} == {"no_member"}


def test_members_that_nobody_read_are_known_later(tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    text = SPEC.replace(*IN_KMH)
    given = [of_places(0, seen=2, lit=False, w=0.0)]
    given[0].signals["more"] = {"flags": 1}
    more = "enum other {{ {} }}\nsignal more : state {{ flags: other }}\n"
    driven(path, text.replace("\nrule seen", "\n" + more.format("a, b") + "rule seen"), given)
    run = read(path.read_bytes(), str(path))
    assert type(run.cycles[0].cycle) is Cycle
    assert run.cycles[0].cycle.signals["more"] == {"flags": "b"}


@pytest.mark.parametrize("text", [SPEC, SPEC.replace(*IN_KMH)])
@pytest.mark.parametrize(
    "seen", [3, -1, 0.5, True, "3", [0], {"a": 0}, np.zeros(1), np.array(2), math.nan, None, 2**70]
)
def test_what_is_no_place_of_a_member_is_refused_again_in_the_same_words(
    tmp_path: Path, seen: Any, text: str
) -> None:
    path = tmp_path / "run.arrows"
    given = [cycle(number) for number in range(5)]
    given[0].signals["ego"]["seen"] = seen
    given[1].driving["lane"] = seen
    given[2].driving["lane"] = [0, seen]
    given[3].signals["objects"] = {"x": [0.0, 1.0], "seen": np.ma.masked_array([0, 1], [True, False])}
    given[4].signals["objects"] = [{"x": 0.0, "seen": seen}, {"x": 0.0, "seen": 0}]
    driven(path, text, given)
    run = read(path.read_bytes(), str(path))
    assert [found for _, found in rerun(run, box_of(run, loads(text)))] == [[]] * 5


def test_places_of_members_that_nobody_named_are_not_guessed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Records of before: their heads do not say what their numbers stand for."""
    monkeypatch.setattr(declared, "listed_members", lambda spec: None)
    path, spec = tmp_path / "run.arrows", tmp_path / "m.spec"
    driven(path, SPEC, [cycle(0, seen="red")])
    spec.write_text(SPEC)
    run = read(path.read_bytes(), str(path))
    with pytest.raises(tm.TrackmarshalError, match=r"D162.*plan.lane"):
        box_of(run, loads(SPEC))
    with pytest.raises(tm.TrackmarshalError, match="D162"):
        tm.replay(tm.load_recording(path), tm.Evaluator(loads(SPEC)))
    of = ["--spec", str(spec), "--quiet"]
    for verb in (
        ["replay", str(path), *of],
        ["explain", str(path), "--rule", "lanes", "--at", "0", *of],
        ["compile", str(spec), "--target", "c", "--out", str(tmp_path / "c"), "--cycles", str(path)],
    ):
        assert main(verb) == 2, verb
        assert "D162" in capsys.readouterr().err, verb


# Messages ---------------------------------------------------------------------------------------------------------


def test_messages_have_places() -> None:
    column = Entry("objects.seen", 0, "f64", 8, True, None, ("green", "yellow"))
    one = Entry("ego.seen", 0, "f64", 1, False, 0.0, ("green", "yellow"))
    assert column.places(["yellow", "green", 1.0]) == [1.0, 0.0, 1.0]
    assert column.places([1.0, 0.0]) == [1.0, 0.0]
    assert one.places("yellow") == 1.0
    assert math.isnan(column.places(["green", None])[1])
    assert Entry("ego.x", 0, "f64", 1, False, None).places(3.0) == 3.0
    for entry, value in ((column, ["green", "grey"]), (one, "grey")):
        with pytest.raises(LinkError, match="is none of green, yellow: 'grey'"):
            entry.places(value)


@pytest.mark.parametrize("backend", ["reference", "numpy", *(["c"] if compiler() else [])])
@pytest.mark.parametrize("last", ["red", "else"])
@pytest.mark.parametrize("place", [1.5, -1, 3, 99, 2**70])
def test_the_place_of_no_member_has_no_number(place: float, last: str, backend: str) -> None:
    """By the verdict of the rule alone, too, which is all that there is where no door looks first."""
    text = f"""module m
enum flag {{ green, yellow, red }}
signal ego : state {{ flag: flag, v: m/s }}
rule limit "x"
  require ego.v <= case ego.flag {{ green: 10 m/s, yellow: 5 m/s, {last}: 100 m/s }}
"""
    evaluator = Evaluator(loads(text), backend=backend)
    for given, verdict in ((place, "undefined"), (2, "satisfied"), ("red", "satisfied")):
        (result,) = evaluator.evaluate([evaluator.read({"signals": {"ego": {"flag": given, "v": 50.0}}})])
        assert result.rules["limit"].verdict == verdict
        assert result.safe is (verdict == "satisfied")
