"""A recording, a cycle, a case and a module of places name their track: places of another one are refused, not applied."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import PERIOD, cycle
from support.shared import shared
from support.supervised import BACKENDS, ROOT, shipped
from trackmarshal.cli.main import main
from trackmarshal.ir.spec import Spec, track_of
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.record.reading import read
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.recording_io import write
from trackmarshal.supervision import box_of, rerun

NORTHFIELD = ROOT / "specs" / "tracks" / "northfield.spec"
FREE_LAP = ROOT / "specs" / "scenarios" / "free_lap.tmrec.jsonl"


@pytest.fixture(scope="module")
def northfield() -> Spec:
    return tm.load(ROOT / "specs" / "supervisor", [NORTHFIELD])


@pytest.fixture(scope="module")
def lap() -> Recording:
    recording = tm.load_recording(FREE_LAP)
    return replace(recording, cycles=recording.cycles[:3], ground_truth={})


def named(name: Any, number: int = 0) -> tm.Cycle:
    given = cycle(number)
    return replace(given, signals={**given.signals, "track": {**given.signals["track"], "name": name}})


@pytest.mark.parametrize(
    ("module", "track"),
    [
        ("tracks.modena", "modena"),
        ("tracks.de.berlin", "berlin"),
        ("tracks", ""),
        ("my.tracks.modena", ""),
        ("places", ""),
    ],
)
def test_a_module_names_its_track(module: str, track: str) -> None:
    assert track_of(module) == track


def test_a_shipped_recording_names_its_track(lap: Recording) -> None:
    assert lap.track["name"] == "northfield"


def test_replay_refuses_places_of_another_track(lap: Recording, northfield: Spec) -> None:
    with pytest.raises(tm.TrackmarshalError, match="`northfield`, but `pit_lane` is on `modena`") as caught:
        tm.replay(lap, tm.Evaluator(shipped()))
    assert (caught.value.code, caught.value.file) == ("D146", str(FREE_LAP))
    assert len(tm.replay(lap, tm.Evaluator(northfield)).cycles) == 3
    # Rules that read no place do not mind.
    assert len(tm.replay(lap, tm.Evaluator(shipped(), ["friction"])).cycles) == 3


def test_the_command_refuses_it_too(
    lap: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "lap.tmrec.jsonl"
    write(replace(lap, use=()), path)
    arguments = ["--project", str(ROOT), "replay", str(path), "--quiet"]
    assert main(arguments) == 2
    assert "error[D146]" in capsys.readouterr().err
    assert main([*arguments, "--with", str(NORTHFIELD)]) == 0


def test_what_names_no_track_is_said(
    lap: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    track = {name: value for name, value in lap.track.items() if name != "name"}
    path = tmp_path / "lap.tmrec.jsonl"
    write(replace(lap, use=(), track=track), path)
    assert main(["--project", str(ROOT), "replay", str(path)]) in (0, 1)
    assert "it names no track; taken is that it is on `modena`" in capsys.readouterr().err


@pytest.mark.parametrize("backend", ["numpy", "c"])
@pytest.mark.parametrize(
    ("name", "faults"), [("modena", []), ("monteblanco", ["wrong_track"]), (7, ["wrong_type"]), (None, [])]
)
def test_a_cycle_names_its_track(backend: str, name: Any, faults: list[str]) -> None:
    made = tm.supervisor(
        shipped(), ["zone_speed_limit", "static_collision"], backend, {"budget": 1e9}, lambda: 0.0
    )
    decision = made.step(named(name))
    assert [name_of(fault) for fault in decision.faults] == faults
    assert all((fault.signal, fault.field) == ("track", "name") for fault in decision.faults)


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_where_no_rule_reads_the_borders_too(backend: str) -> None:
    made = tm.supervisor(shipped(), ["zone_speed_limit"], backend, {"budget": 1e9}, lambda: 0.0)
    assert [name_of(fault) for fault in made.step(named("monteblanco")).faults] == ["wrong_track"]


@BACKENDS
@pytest.mark.parametrize(
    ("rules", "names", "wrong"),
    [
        (["friction"], ["modena", 7, "monteblanco", b"modena", None], [1, 3]),
        (["zone_speed_limit"], ["modena", 7, "monteblanco", "modena", None], [1, 2]),
    ],
)
def test_a_name_that_changes_in_the_middle_of_a_run(
    backend: str, rules: list[str], names: list[Any], wrong: list[int]
) -> None:
    """Borders that no rule reads came as arrays, and what the track was called behind the first cycle went unnoticed in C."""
    now = 0.0
    made = tm.supervisor(shipped(), rules, backend, {"budget": 1e9}, lambda: now)
    for number, name in enumerate(names):
        now = number * PERIOD
        decision = made.step(named(name, number))
        assert [(one.signal, one.field) for one in decision.faults] == [("track", "name")] * (number in wrong)
        assert decision.safe == (number not in wrong)


def test_a_case_that_brings_its_own_places() -> None:
    evaluator = tm.Evaluator(shipped(), ["zone_speed_limit"])
    columns = {name: list(map(float, column)) for name, column in cycle(0).driving.items()}
    signals = {"plan": columns, "track": {"name": "monteblanco", "left": [], "right": []}}
    (fault,) = evaluator.case({"signals": signals}).faults
    assert fault == "D230 track.name: the track is `monteblanco`, but `pit_lane` is on `modena`"
    places = {"pit_lane": [[0, 100], [10, 100], [10, 110]]}
    assert evaluator.case({"signals": signals, "places": places}).faults == ()


def test_arrays_of_cases_and_of_runs_name_their_track() -> None:
    """They were judged by the places of another one without a word."""
    evaluator = tm.Evaluator(shipped(), ["zone_speed_limit"])
    columns = {name: np.array([column] * 3, dtype=float) for name, column in cycle(0).driving.items()}
    stamps = np.arange(3) * 100_000_000
    for name, safe in (("modena", True), ("monteblanco", False), (None, True)):
        shared: dict[str, Any] = {"track": {"name": name, "left": [], "right": []}}
        batch = evaluator.batch({"plan": columns}, shared)
        assert batch.safe.tolist() == [safe] * 3
        assert ("`pit_lane` is on `modena`" in str(batch.case(0).faults)) != safe
        assert evaluator.whole_run().step(stamps, {"plan": columns}, shared).safe.tolist() == [safe] * 3
    shared = {"track": {"name": "monteblanco", "left": [], "right": []}}
    places = {"pit_lane": [[0, 100], [10, 100], [10, 110]]}
    assert evaluator.batch({"plan": columns}, shared, places=places).safe.all()
    with pytest.raises(tm.TrackmarshalError, match="the name of a track is a text"):
        evaluator.batch({"plan": columns}, {"track": {"name": 7, "left": [], "right": []}})


def test_the_recordings_of_a_real_planner() -> None:
    """Berlin with Modena's pit lane, once the recording says where it is; as it is, it names no track."""
    recording = tm.load_recording(shared("data", "planner", "berlin.tmrec.jsonl.gz"))
    recording = replace(recording, cycles=recording.cycles[:2])
    evaluator = tm.Evaluator(shipped())
    assert len(tm.replay(recording, evaluator).cycles) == 2
    with pytest.raises(tm.TrackmarshalError, match="the track is `berlin`"):
        tm.replay(replace(recording, track={**recording.track, "name": "berlin"}), evaluator)


def test_the_recordings_of_the_papers_authors_are_on_modena() -> None:
    recording = tm.load_recording(shared("data", "scenarios", "modena_T1_valid.saa"))
    recording = replace(recording, cycles=recording.cycles[:2], track={**recording.track, "name": "modena"})
    assert len(tm.replay(recording, tm.Evaluator(shipped())).cycles) == 2


@pytest.mark.parametrize("rules", [["zone_speed_limit", "static_collision"], ["zone_speed_limit"]])
def test_the_record_of_a_run_names_its_track(rules: list[str], tmp_path: Path, northfield: Spec) -> None:
    """It lost the name, so that a run on one track was judged by the places of another."""
    path, now = tmp_path / "run.arrows", [0.0]
    live = tm.supervisor(shipped(), rules, "numpy", {"budget": 1e9}, lambda: now[0], path)
    for number in range(4):  # of some that are alike, rows are made by what differs
        now[0] = number * PERIOD
        given = cycle(number)
        track = {**given.signals["track"], "name": None if number == 0 else "modena"}
        assert live.step(replace(given, signals={**given.signals, "track": track})).faults == ()
    live.close()
    run = read(path.read_bytes(), str(path))
    tracks = [one.cycle.signals.get("track", {}) for one in run.cycles]
    assert [track.get("name") for track in tracks] == [None, "modena", "modena", "modena"]
    again = [(decision.faults, found) for decision, found in rerun(run, box_of(run, shipped()))]
    assert again == [((), [])] * 4
    elsewhere = [decision.faults for decision, _ in rerun(run, box_of(run, northfield))]
    assert [[name_of(fault) for fault in faults] for faults in elsewhere] == [[], *[["wrong_track"]] * 3]


def test_what_counts_as_a_recording_names_the_track_of_its_run(tmp_path: Path, northfield: Spec) -> None:
    path = tmp_path / "run.arrows"
    live = tm.supervisor(shipped(), ["zone_speed_limit"], "numpy", {"budget": 1e9}, lambda: 0.0, path)
    live.step(named("modena"))
    live.close()
    recording = tm.load_recording(path)
    assert recording.track == {"left": [], "right": [], "closed": False, "name": "modena"}
    assert len(tm.replay(recording, tm.Evaluator(shipped(), ["zone_speed_limit"])).cycles) == 1
    with pytest.raises(tm.TrackmarshalError, match="D146"):
        tm.replay(recording, tm.Evaluator(northfield, ["zone_speed_limit"]))


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_a_later_cycle_names_another_track(backend: str) -> None:
    """Where no rule reads the borders, C took the others for the one that it had read before."""
    now = [0.0]
    made = tm.supervisor(shipped(), ["zone_speed_limit"], backend, {"budget": 1e9}, lambda: now[0])
    found = []
    for number, name in enumerate([*["modena"] * 4, "monteblanco", None, "modena"]):
        now[0] = number * PERIOD
        found += [[name_of(fault) for fault in made.step(named(name, number)).faults]]
    assert found == [[], [], [], [], ["wrong_track"], [], []]


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_the_name_of_a_track_is_a_text_whatever_rules_read(backend: str) -> None:
    """Where none reads a place it went unnoticed, and a record kept such cycles as JSON, whole."""
    for rules in (["friction"], ["static_collision"]):
        made = tm.supervisor(shipped(), rules, backend, {"budget": 1e9}, lambda: 0.0)
        (fault,) = made.step(named(7)).faults
        assert (name_of(fault), fault.signal, fault.field) == ("wrong_type", "track", "name")


def test_an_empty_name_in_a_record_is_a_name(tmp_path: Path) -> None:
    """It counted as none, so that places of another track were taken for those of the run."""
    yard, path, now = tmp_path / "yard.spec", tmp_path / "run.arrows", [0.0]
    yard.write_text(NORTHFIELD.read_text().replace("module tracks.northfield", "module yard"))
    live = tm.supervisor(
        tm.load(ROOT / "specs" / "supervisor", [yard]),
        ["zone_speed_limit"],
        limits={"budget": 1e9},
        clock=lambda: now[0],
        record=path,
    )
    for number, name in enumerate([*[""] * 4, None, "yard"]):
        now[0] = number * PERIOD
        assert live.step(named(name, number)).faults == ()
    live.close()
    run = read(path.read_bytes(), str(path))
    assert [one.cycle.signals.get("track", {}).get("name") for one in run.cycles] == [*[""] * 4, None, "yard"]
    found = [decision.faults for decision, _ in rerun(run, box_of(run, shipped()))]
    assert [[name_of(fault) for fault in faults] for faults in found] == [
        *[["wrong_track"]] * 4,
        [],
        ["wrong_track"],
    ]
    with pytest.raises(tm.TrackmarshalError, match="D146"):
        tm.replay(tm.load_recording(path), tm.Evaluator(shipped(), ["zone_speed_limit"]))
