"""What a cycle does not have, and the spec's default stands for, is not in its record either: nobody measured it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from trackmarshal.runtime.record.arrow import layout_of
from trackmarshal.runtime.record.reading import Run, read
from trackmarshal.scenarios.inputs import defaulted
from trackmarshal.supervision import box_of, rerun

SPEC = """module defaults
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, grip: 1 default 1 }
signal ego : state { x: m, y: m, heading: rad, age: s default 0 s }
signal objects : set of object { x: m, age: s default 0 s }
signal wind : state { v: m/s default 3 m/s }

rule grips "Grips"
  for all p in plan
  require p.grip >= 0.9

rule fresh "Fresh"
  require ego.age <= 0.5 s and wind.v <= 9 m/s

rule seen "Seen"
  for all o in objects
  require o.age <= 0.5 s
"""
READERS = {"plan.grip": ("grips",), "ego.age": ("fresh",), "objects.age": ("seen",)}


def given(number: int, **changes: Any) -> tm.Cycle:
    """A cycle with all of it, but for what is None."""
    plan = {
        "t": np.array([0.0, 1.0]),
        "grip": np.ones(2),
        **{name: np.zeros(2) for name in ("x", "y", "heading", "v")},
    }
    parts: dict[str, Any] = {
        "plan": plan,
        "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "age": 0.0},
        "objects": {"id": ["a", "b"], "x": np.array([50.0, 60.0]), "age": np.zeros(2)},
        "wind": {"v": 3.0},
    }
    for name, field in changes.items():
        del parts[name][field]
    signals = {name: part for name, part in parts.items() if name != "plan"}
    return tm.Cycle(number, 0.1 * number, parts["plan"], dict(parts["plan"]), signals)


def driven(path: Path, cycles: list[tm.Cycle], text: str = SPEC) -> Run:
    now = [0.0]
    live = tm.supervisor(tm.loads(text), limits={"budget": 1e9}, clock=lambda: now[0], record=path)
    for now[0], one in zip((0.1 * place for place in range(len(cycles))), cycles):
        assert live.step(one).safe
    live.close()
    return read(path.read_bytes(), str(path))


@pytest.mark.parametrize("name", READERS)
def test_a_default_is_told_of_a_record_as_of_a_recording(name: str, tmp_path: Path) -> None:
    """It stood in the columns of the record as if it had been sent, and no assumption that rests on it was told (T249)."""
    signal, field = name.split(".")
    cycles = [given(number, **({signal: field} if number % 2 else {})) for number in range(6)]
    run, spec = driven(tmp_path / "run.arrows", cycles), tm.loads(SPEC)
    assert [found for _, found in rerun(run, box_of(run, spec))] == [[]] * 6
    recording = tm.load_recording(tmp_path / "run.arrows")
    assert defaulted(recording, spec, spec.rules) == {name: READERS[name]}


def test_a_record_of_all_has_no_default(tmp_path: Path) -> None:
    run, spec = driven(tmp_path / "run.arrows", [given(number) for number in range(4)]), tm.loads(SPEC)
    assert [found for _, found in rerun(run, box_of(run, spec))] == [[]] * 4
    assert defaulted(tm.load_recording(tmp_path / "run.arrows"), spec, spec.rules) == {}


def test_another_default_is_judged_of_a_record_too(tmp_path: Path) -> None:
    """What was left out is what the spec at hand says, in a signal that has nothing else, too."""
    run = driven(tmp_path / "run.arrows", [given(number, wind="v", plan="grip") for number in range(4)])
    for was, now in (
        ("v: m/s default 3 m/s", "v: m/s default 10 m/s"),
        ("grip: 1 default 1", "grip: 1 default 0.5"),
    ):
        again = [decision.safe for decision, _ in rerun(run, box_of(run, tm.loads(SPEC.replace(was, now))))]
        assert again == [False] * 4


def test_elements_of_which_only_some_have_a_field(tmp_path: Path) -> None:
    cycles = [given(number) for number in range(3)]
    for one in cycles:
        one.signals["objects"] = [{"id": "a", "x": 50.0, "age": 0.1}, {"id": "b", "x": 60.0}]
    cycles[2].signals["objects"] = [{"id": "a", "x": 50.0}, {"id": "b", "x": 60.0}]
    as_given = [one.signals["objects"] for one in cycles[:2]]
    run, spec = driven(tmp_path / "run.arrows", cycles), tm.loads(SPEC)
    assert [found for _, found in rerun(run, box_of(run, spec))] == [[]] * 3
    assert defaulted(tm.load_recording(tmp_path / "run.arrows"), spec, spec.rules) == {
        "objects.age": ("seen",)
    }
    assert [one.cycle.signals["objects"] for one in run.cycles[:2]] == as_given


def test_elements_of_which_only_some_have_a_field_are_in_columns(tmp_path: Path) -> None:
    """As all of the cycle is: as it came in, it took a thousand times as long, with the borders in it."""
    cycles = [given(number) for number in range(5)]
    for one in cycles:
        one.signals["objects"] = [
            {"id": "a", "x": 5.0, "r": 1.0},
            {"x": 6.0, "age": 0.1},
            {"x": 7.0, "r": 3.0},
        ]
    near = 'rule near "Near"\n  for all o in objects\n  require o.r <= 3 m\n'
    text = SPEC.replace("object { x: m,", "object { x: m, r: m default 2 m,") + near
    path, spec = tmp_path / "run.arrows", tm.loads(text)
    run = driven(path, cycles, text)
    found = layout_of(path.read_bytes())
    assert found is not None
    names = [name for name, _ in found[0].columns]
    rows = [dict(zip(names, row.values, strict=True)) for row in found[0].rows(path.read_bytes())]
    said = [(row["raw"], json.loads(row["left_out"])) for row in rows if row["state"]]
    assert said == [("", [["objects.r", [1]], ["objects.age", [0, 2]]])] * 5
    assert [list(row["objects.r"]) for row in rows if row["state"]] == [[1.0, 2.0, 3.0]] * 5
    assert [found for _, found in rerun(run, box_of(run, spec))] == [[]] * 5
    wider = tm.loads(text.replace("default 2 m", "default 4 m"))
    assert [decision.safe for decision, _ in rerun(run, box_of(run, wider))] == [False] * 5


ROAD: dict[str, Any] = {"left": [[-9.0, 9.0], [9.0, 9.0]], "right": [[-9.0, -9.0], [9.0, -9.0]]}
TRACK = "signal track : corridor { left: polyline, right: polyline }\n"
READ = 'rule inside "Inside"\n  for all p in plan\n  require footprint(p, 4 m, 2 m) inside track\n'
#: Of fields that are no SI, all cycles are kept as they came in.
IN_KMH = ("wind : state { v: m/s default 3 m/s }", "wind : state { v: km/h default 3 km/h }")


@pytest.mark.parametrize("more", [{}, {"name": None, "closed": False}, {"name": "here"}])
@pytest.mark.parametrize("read", ["", READ], ids=["none reads it", "read"])
def test_a_cycle_that_is_kept_as_it_came_in_has_no_other_track(
    read: str, more: dict[str, Any], tmp_path: Path
) -> None:
    """As one with an id that has no JSON; columns had another word for the same track, and all that followed was left out."""
    cycles = [given(number) for number in range(3)]
    for one in cycles:
        one.signals["track"] = {**ROAD, **more}
    cycles[1].signals["objects"]["id"] = ["a", "\ud800"]
    driven(tmp_path / "run.arrows", cycles, SPEC + TRACK + read)
    recording = tm.load_recording(tmp_path / "run.arrows")
    assert (len(recording.cycles), recording.notes) == (3, ())
    assert (recording.track["left"], recording.track.get("name")) == (
        ROAD["left"] if read else [],
        more.get("name"),
    )


@pytest.mark.parametrize("change", [{"closed": True}, {"name": "there"}, {"left": [[-9.0, 8.0], [9.0, 8.0]]}])
def test_another_track_is_one_also_of_cycles_that_are_kept_as_they_came_in(
    change: dict[str, Any], tmp_path: Path
) -> None:
    cycles = [given(number) for number in range(3)]
    for one in cycles:
        one.signals["track"] = ROAD if one.number < 2 else {**ROAD, **change}
    driven(tmp_path / "run.arrows", cycles, SPEC.replace(*IN_KMH).replace("9 m/s", "9 km/h") + TRACK)
    recording = tm.load_recording(tmp_path / "run.arrows")
    assert (len(recording.cycles), recording.notes[0]) == (
        2,
        "the track changes at 0.2 s; what follows is left out",
    )


@pytest.mark.parametrize("track", [None, []])
def test_a_track_that_is_none_is_no_error_where_no_rule_reads_borders(track: Any, tmp_path: Path) -> None:
    cycles = [given(number) for number in range(2)]
    for one in cycles:
        one.signals["track"] = track
    driven(tmp_path / "run.arrows", cycles, SPEC.replace(*IN_KMH).replace("9 m/s", "9 km/h") + TRACK)
    assert tm.load_recording(tmp_path / "run.arrows").track == {"left": [], "right": [], "closed": False}


def test_readers_of_the_table_find_the_default_in_its_column(tmp_path: Path) -> None:
    """Whoever reads columns without this program has what was judged, and beside it that nobody sent it."""
    path = tmp_path / "run.arrows"
    driven(path, [given(number, ego="age") for number in range(4)])
    data = path.read_bytes()
    found = layout_of(data)
    assert found is not None
    layout = found[0]
    names = [name for name, _ in layout.columns]
    rows = [dict(zip(names, row.values, strict=True)) for row in layout.rows(data)]
    assert [(row["left_out"], row["ego.age"]) for row in rows if row["state"]] == [('["ego.age"]', 0.0)] * 4
