"""`trackmarshal replay` of a run's record: the same decisions, or which ones are not."""

from __future__ import annotations

import gzip
import json
import math
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import PERIOD, SPEED, cycle
from support.schemas import hold
from support.supervised import ROOT, shipped
from trackmarshal.cli.main import main
from trackmarshal.cli.record import told
from trackmarshal.cli.replay import overruled, summary
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.record.arrow import END, layout_of
from trackmarshal.runtime.record.decided import Difference
from trackmarshal.runtime.record.reading import read
from trackmarshal.scenarios import content
from trackmarshal.scenarios.faults.campaign import Bench
from trackmarshal.scenarios.faults.declaration import Campaign, Fault
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.run_record import run_record
from trackmarshal.scenarios.supervised import run_until

#: Five cycles of a small spec, the third missing, with snapshots after two and four; written when rows did not say their places yet.
OLD = Path(__file__).parent / "version_2.arrows.gz"


@pytest.fixture
def record(recorded: bytes, tmp_path: Path) -> Path:
    """A file of its own."""
    path = tmp_path / "run.arrows"
    path.write_bytes(recorded)
    return path


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Five cycles on a straight: the third is missing, in the fifth the driving trajectory is too fast."""
    path = tmp_path_factory.mktemp("recorded") / "run.arrows"
    now = 0.0
    supervisor = tm.supervisor(
        shipped(),
        ["speed_limit", "ends_at_rest"],
        clock=lambda: now,
        record=path,
        params={"v_max": 30.0},
    )
    for number in range(5):
        now = number * PERIOD
        given = cycle(number) if number != 2 else None
        if given is not None and number == 4:
            given.driving["v"][9] = 3 * SPEED
        supervisor.step(given)
    supervisor.close()
    assert supervisor.record_error == ""
    return path.read_bytes()


def replay(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    status = main(["replay", *arguments, "--project", str(ROOT)])
    said = capsys.readouterr()
    hold(["replay", *arguments], said.out)
    return status, said.out, said.err


def test_same_decisions(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = replay(capsys, str(record))
    assert (status, err) == (0, "")
    assert out == f"{record}: 5 cycles, 2 drive, 3 previous_emergency\nsame decisions, bit for bit\n"


def test_a_record_may_be_larger_than_a_recording(
    record: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 50 cycles a second and 30 samples, that of seven minutes was refused, and the help was to split it, which nobody can."""
    monkeypatch.setattr(content, "MAX_BYTES", 1000)
    assert replay(capsys, str(record))[0] == 0
    assert main(["explain", str(record), "--rule", "friction", "--at", "0", "--project", str(ROOT)]) == 2
    err = capsys.readouterr().err  # there, its cycles count as a recording
    assert "bytes, the limit is 1000\n" in err
    assert "help: begin a new record" in err
    monkeypatch.setattr(content, "MAX_RECORD", 1000)
    status, _, err = replay(capsys, str(record))
    assert status == 2
    assert "bytes, the limit is 1000" in err
    assert "help: begin a new record" in err


def test_nothing_is_given_to_a_record_where_it_is_explained_either(
    record: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`replay` refuses it: of what the Supervisor had not, numbers would be explained that the run did not rest on."""
    asked = ["explain", str(record), "--rule", "friction", "--at", "0", "--project", str(ROOT)]
    given = ["--given", "objects.age=0.1", "--because", "wet"]
    assert main(asked) == 0
    for more in (given, given[2:]):
        assert main([*asked, *more]) == 2
        err = capsys.readouterr().err
        assert "error[E437]: a record of a run has the inputs of that run" in err, err


def test_one_record_makes_one_file_for_foxglove(
    record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second one took the place of the first, without a word."""
    (tmp_path / "other.arrows").write_bytes(record.read_bytes())
    mcap = tmp_path / "run.mcap"
    status, out, err = replay(capsys, str(record), str(tmp_path / "other.arrows"), "--mcap", str(mcap))
    assert (status, out) == (2, "")
    assert "error[E434]: `--mcap` makes one file of one record, and 2 are to be replayed" in err
    assert not mcap.exists()


def test_another_backend_decides_the_same(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert replay(capsys, str(record), "--backend", "reference")[0] == 0


def test_single_rules_are_refused(record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """All were run all the same, and one that there is not had decided the same, bit for bit. As a recording, its cycles are run with those."""
    for rule in ("speed_limit", "nosuch"):
        status, out, err = replay(capsys, str(record), "--rule", rule)
        assert (status, out, "error[E437]" in err) == (2, "", True), err
    assert replay(capsys, str(record), "--rule", "speed_limit", "--out", str(tmp_path / "out"))[0] == 1
    assert replay(capsys, str(record), "--rule", "nosuch", "--out", str(tmp_path / "out"))[0] == 2


def test_lines(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = replay(capsys, str(record), "--format", "jsonl")
    lines = [json.loads(line) for line in out.splitlines()]
    assert status == 0
    assert [(line["candidate"], line["decision"], line["decision_from"], line["same"]) for line in lines[:6]] == [
        ("driving", "drive", 0.0, True), ("emergency", "drive", 0.0, True), ("driving", "drive", 0.1, True), ("emergency", "drive", 0.1, True),
        ("driving", "previous_emergency", 0.1, True), ("emergency", "previous_emergency", 0.1, True),
    ]  # fmt: skip
    assert lines[4]["cycle_faults"] == ["missing_cycle D221 cycle: "]
    assert lines[4]["rules"] == {}
    assert set(lines[0]["rules"]) == {"speed_limit", "ends_at_rest"}


def test_cut_off_in_the_last_cycle(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = record.read_bytes()
    found = layout_of(whole)
    assert found is not None
    *_, last, _ = (row.end for row in found[0].rows(whole))  # and the row that says that the record is closed
    record.write_bytes(whole[: last - 100])
    status, out, _ = replay(capsys, str(record))
    assert status == 0
    assert "4 cycles" in out
    assert "not closed" in out


@pytest.mark.parametrize(
    "forged", ["first", "last", "middle", "twice", "all after the second", "end", "changed", "longer"]
)
def test_a_record_that_is_not_what_was_written(
    record: Path, capsys: pytest.CaptureFixture[str], forged: str
) -> None:
    """Whole rows that are gone or stand twice, the last one, which closes it, and a changed byte in the middle: each is noticed."""
    whole = record.read_bytes()
    found = layout_of(whole)
    assert found is not None
    ends = [len(found[0].schema), *(row.end for row in found[0].rows(whole))]
    rows = [whole[begin:end] for begin, end in zip(ends, ends[1:])]
    changed = bytearray(rows[1])
    changed[-9] ^= 1
    longer = bytearray(rows[1])
    longer[longer.index(struct.pack("<q", len(rows[1]) - len(found[0]._template))) + 2] ^= 1
    kept = {
        "first": rows[1:],
        "last": [*rows[:-2], rows[-1]],
        "middle": [*rows[:2], *rows[3:]],
        "twice": [*rows[:2], *rows[1:]],
        "all after the second": rows[:2],
        "end": rows[:-1],
        "changed": [rows[0], bytes(changed), *rows[2:]],
        "longer": [rows[0], bytes(longer), *rows[2:]],
    }[forged]
    record.write_bytes(whole[: ends[0]] + b"".join(kept) + END)
    run = read(record.read_bytes(), "forged")
    assert run.damage
    status, out, _ = replay(capsys, str(record), "--quiet")
    assert status == 1
    assert run.damage in out
    assert "same decisions" not in out
    assert run.damage in replay(capsys, str(record), "--format", "jsonl")[2]


def taken_apart(data: bytes) -> tuple[bytes, list[bytes]]:
    """The head of a record and its rows, as bytes."""
    found = layout_of(data)
    assert found is not None
    ends = [len(found[0].schema), *(row.end for row in found[0].rows(data))]
    return data[: ends[0]], [data[begin:end] for begin, end in zip(ends, ends[1:])]


@pytest.mark.parametrize("gone", [(0,), (0, 1), (0, 1, 2, 3), (2,), (1, 2), (3,)])
def test_rows_that_are_gone_from_a_record_that_was_never_closed(
    record: Path, capsys: pytest.CaptureFixture[str], gone: tuple[int, ...]
) -> None:
    head, rows = taken_apart(record.read_bytes())
    kept = [row for place, row in enumerate(rows[:-1]) if place not in gone]
    record.write_bytes(head + b"".join(kept))
    run = read(record.read_bytes(), "cut")
    assert not run.ended
    assert len(run.cycles) == 5 - len(gone)
    assert f"where row {gone[0]} should be" in run.damage
    status, out, _ = replay(capsys, str(record))
    assert status == 1
    assert "not closed" in out
    assert run.damage in out
    assert run.damage in tm.load_recording(record).notes


def test_a_record_that_was_never_closed_and_lacks_its_end_is_whole_before(record: Path) -> None:
    """A killed run leaves this: nothing tells it from one that ended there."""
    head, rows = taken_apart(record.read_bytes())
    for count in range(len(rows)):
        assert read(head + b"".join(rows[:count]), "cut").damage == ""


def test_no_snapshot_is_taken_for_one_of_other_cycles_where_rows_are_gone(tmp_path: Path) -> None:
    path, now = tmp_path / "run.arrows", 0.0
    spec = shipped()
    supervisor = tm.supervisor(spec, ["speed_limit"], clock=lambda: now, record=path, snapshots=2)
    for number in range(6):
        now = number * PERIOD
        supervisor.step(cycle(number))
    head, rows = taken_apart(path.read_bytes())
    assert [one.after for one in read(path.read_bytes(), "whole").snapshots] == [2, 4]
    run = read(head + b"".join(rows[1:]), "cut")
    assert "where row 0 should be" in run.damage
    assert run.snapshots == ()


def test_a_border_that_came_in_a_row_that_is_gone(tmp_path: Path) -> None:
    path, now = tmp_path / "run.arrows", 0.0
    spec = shipped()
    supervisor = tm.supervisor(spec, ["static_collision"], clock=lambda: now, record=path)
    for number in range(3):
        now = number * PERIOD
        supervisor.step(cycle(number))
    head, rows = taken_apart(path.read_bytes())
    with pytest.raises(TrackmarshalError) as caught:
        read(head + b"".join(rows[1:]), "cut")
    assert caught.value.code == "D162"
    assert "where row 0 should be" in (caught.value.help or "")


def test_records_of_version_2_are_read() -> None:
    data = gzip.decompress(OLD.read_bytes())
    run = read(data, "old")
    assert (run.ended, run.rest, run.missed, run.damage) == (True, 0, 0, "")
    assert [one.after for one in run.snapshots] == [2, 4]
    assert [one.value("state") for one in run.cycles] == [
        "drive", "drive", "previous_emergency", "no_safe_trajectory", "drive",
    ]  # fmt: skip
    assert [None if one.cycle is None else one.cycle.signals["ego"]["v"] for one in run.cycles] == [
        10.0, 11.0, None, 13.0, 14.0,
    ]  # fmt: skip
    assert [one.readings[0] for one in run.cycles] == [0.0, 0.1, 0.2, 0.3, 0.4]
    head, rows = taken_apart(data)
    closed = read(head + b"".join([*rows[:-2], rows[-1]]) + END, "old")
    assert "closed after 5" in closed.damage


def test_cut_off_in_the_head(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record.write_bytes(record.read_bytes()[:300])
    status, _, err = replay(capsys, str(record))
    assert status == 2
    assert "D161" in err


def test_another_spec_is_noted_and_its_differences_shown(
    record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "specs" / "supervisor" / "conduct.spec").read_text("utf-8")
    folder = tmp_path / "supervisor"
    folder.mkdir()
    for path in (ROOT / "specs" / "supervisor").glob("*.spec"):
        (folder / path.name).write_bytes(path.read_bytes())
    (folder / "conduct.spec").write_text(
        text.replace("p.v <= min(v_event, v_max)", "p.v <= 2 * v_max"), "utf-8"
    )
    for name in ("tracks", "vehicles"):
        (tmp_path / name).symlink_to(ROOT / "specs" / name)
    status, out, err = replay(capsys, str(record), "--spec", str(folder))
    assert status == 1
    assert "another spec was in force" in err
    assert ", margin of speed_limit of driving: recorded " in out


def test_whatever_reads_a_record_says_that_another_spec_was_in_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`explain`, `diff` and pages of runs took its cycles for those of a run under the spec at hand."""
    told = "another spec was in force than the one given here; its decisions may differ"
    own, other, recording = tmp_path / "bare.spec", tmp_path / "other.spec", tmp_path / "run.arrows"
    spec, held, _ = of_bare_cycles(tmp_path, "for all p in plan require p.v <= 50 m/s", [0, 1, 2])
    other.write_text(own.read_text().replace("50 m/s", "49 m/s"))
    (rule,) = spec.rules
    for path, times in ((own, 0), (other, 1)):
        loaded = tm.load(path)
        for verb in (
            ["replay", str(recording), "--spec", str(path)],
            ["explain", str(recording), "--rule", rule.name, "--at", "0", "--spec", str(path)],
            ["diff", str(path), str(path), "--on", str(recording)],
            [
                "compile",
                str(path),
                "--target",
                "c",
                "--out",
                str(tmp_path / path.stem),
                "--cycles",
                str(recording),
            ],
        ):
            main(verb)
            assert capsys.readouterr().err.count(told) == times, verb
        evaluator = tm.Evaluator(loaded)
        assert run_record(tm.replay(held, evaluator), evaluator)["notes"].count(told) == times
    for sides in ((own, other), (other, own)):
        main(["diff", *map(str, sides), "--on", str(recording)])
        assert told not in capsys.readouterr().err


def test_a_record_is_a_recording_of_what_passed_the_door(record: Path) -> None:
    recording = tm.load_recording(record)
    assert [c.t for c in recording.cycles] == [0.0, 0.1, 0.4]
    assert recording.notes == (
        "cycles are missing before the one at 0.4 s",
        "2 of 5 cycles of the record are left out",
    )
    assert recording.cycles[1].candidates["driving"]["x"] == cycle(1).driving["x"].tolist()
    assert recording.params == {"v_max": 30.0}


def test_each_cycle_of_a_record_has_the_obstacles_that_stood_there(tmp_path: Path) -> None:
    """What perception finds ahead in a later cycle made that one unsafe, and was replaced by what stood there in the first one."""
    path, now = tmp_path / "run.arrows", 0.0
    supervisor = tm.supervisor(shipped(), ["obstacle_collision"], clock=lambda: now, record=path)
    for number, ahead in enumerate([500.0, 500.0, 30.0, 500.0]):
        now = number * PERIOD
        given = cycle(number)
        things = given.signals["obstacles"]
        things["x"], things["y"] = np.array([ahead]), np.array([0.0])
        supervisor.step(given)
    supervisor.close()
    recording = tm.load_recording(path)
    places = [each["x"] for at in recording.cycles for each in recording.standing(at)]
    assert places == [500.0, 500.0, 30.0, 500.0]
    (note,) = recording.notes
    assert note == "its obstacles are not the same in all cycles; drawn are those of the first one"
    outcome = tm.replay(recording, tm.Evaluator(shipped(), ["obstacle_collision"]))
    assert [each.safe for each in outcome.cycles] == [True, True, False, True]


def of_bare_cycles(
    folder: Path, rule: str, numbers: list[int | None]
) -> tuple[tm.Spec, Recording, list[list[str]]]:
    """A spec of one rule about no track, a record as a recording, and the verdicts of the cycles that are in it; None: nothing came in a step."""
    text = "module bare\nsignal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
    text += f"signal ego : state {{ x: m, y: m, heading: rad, v: m/s }}\nrule only {rule}\n"
    (folder / "bare.spec").write_text(text, encoding="utf-8")
    spec, now = tm.load([folder / "bare.spec"]), 0.0
    supervisor = tm.supervisor(spec, clock=lambda: now, record=folder / "run.arrows")
    said = []
    for number in numbers:
        if number is None:
            now += 0.5 * PERIOD
            supervisor.step(None)
            continue
        given = cycle(number)
        now = given.t
        ego, driving, emergency = (
            {name: each[name] for name in ("t", "x", "y", "heading", "v") if name in each}
            for each in (given.signals["ego"], given.driving, given.emergency)
        )
        decision = supervisor.step(tm.Cycle(number, given.t, driving, emergency, {"ego": ego}))
        if not decision.faults:
            said.append([each.verdict for each in decision.violations])
    supervisor.close()
    return spec, tm.load_recording(folder / "run.arrows"), said


def test_the_worst_of_what_is_undefined_is_that_it_is(tmp_path: Path) -> None:
    """`nan m at 0.3 s` stood there."""
    spec, recording, _ = of_bare_cycles(tmp_path, "require not (previous ego.x > ego.x)", [0, 1, 3, 4])
    evaluator = tm.Evaluator(spec)
    lines = summary(tm.replay(recording, evaluator), evaluator)
    assert sum("undefined at 0.4 s" in line for line in lines) == 2


def test_cycles_that_are_missing_are_missing_to_rules_over_the_run(tmp_path: Path) -> None:
    """The cycles beside a gap were taken for neighbours, and of a step in which nothing came, whose number the next cycle has, nothing was said."""
    steps = [0, 1, 2, 4, 5, 6, None, 7, 8]
    spec, recording, said = of_bare_cycles(tmp_path, "require not (previous ego.x > ego.x)", steps)
    assert [each.missing for each in recording.cycles] == [0, 0, 0, 2, 0, 1, 0]
    assert recording.notes[0] == "cycles are missing before the one at 0.5 s, and before 1 later ones"
    outcome = tm.replay(recording, tm.Evaluator(spec))
    assert [
        [one.verdict for rated in each.results.values() for one in rated.against] for each in outcome.cycles
    ] == said
    assert said[3] == said[5] == ["undefined"] * 2
    explained = [run_until(recording, tm.Evaluator(spec), {}, place) for place in (3, 4)]
    assert [([past.missed for past in before], missing) for _, before, missing in explained] == [
        ([0] * 3, 2),
        ([0] * 3 + [2], 0),
    ]
    fault = Fault("none", "", "", 0.0, 0.8, (), None, "", 1, "")
    found = Bench(recording, tm.Evaluator(spec)).run(Campaign("gaps", "", 0.0, (fault,)), fault)
    assert (found.first, found.last) == (recording.cycles[3].t, recording.cycles[5].t)


def test_a_record_of_rules_about_no_track_is_evidence_too(tmp_path: Path) -> None:
    """Its cycles have no borders: `assess` ended in an internal error (KeyError) where it drew the run."""
    spec, recording, _ = of_bare_cycles(tmp_path, "for all p in plan require p.v <= 50 m/s", [0, 1, 2])
    assert (len(recording.cycles), recording.notes) == (3, ())
    evaluator = tm.Evaluator(spec)
    outcome = tm.replay(recording, evaluator)
    assert outcome.met
    assert run_record(outcome, evaluator)["track"] == {"left": [], "right": [], "closed": False}


#: Speeds in other units than those of the SI, as a display has them: the record then keeps cycles as they came in.
AS_IT_CAME = """module example.shown
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s, shown: km/h }
signal objects : set of object { x: m, y: m }
signal track : corridor { left: polyline, right: polyline }
rule slow "Slow"
  require   ego.shown <= 50 km/h
rule near "Near"
  for all   o in objects
  require   o.x <= 200 m
rule inside "Inside"
  for all   p in plan
  require   footprint(p, 4 m, 2 m) inside track
"""


@pytest.mark.parametrize("form", ["columns", "records", "lines"])
def test_cycles_of_a_record_that_are_kept_as_they_came_in(form: str, tmp_path: Path) -> None:
    """Objects as a list of records were an internal error, and lines, that are read from each row anew, a track that changes."""
    path, now = tmp_path / "run.arrows", 0.0
    sides = {"left": [[-50.0, 6.0], [500.0, 6.0]], "right": [[-50.0, -6.0], [500.0, -6.0]]}
    track = {name: tm.line(points) for name, points in sides.items()} if form == "lines" else sides
    objects = {"x": np.array([90.0, 99.0]), "y": (1.0, 2.0), "id": ["a", 7]}
    records = [{"x": 90.0, "y": np.float64(1.0), "id": "a"}, {"x": 99.0, "y": 2.0, "id": np.int64(7)}]
    plan: dict[str, Any] = {
        "t": np.array([0.0, 1.0]),
        "x": (0.0, 5.0),
        "y": [0.0, 0.0],
        "heading": [0.0, 0.0],
        "v": [0.0, 0.0],
    }
    supervisor = tm.supervisor(tm.loads(AS_IT_CAME), clock=lambda: now, record=path)
    for number in range(3):
        now = number * PERIOD
        ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 0.0, "shown": np.float64(36.0)}
        others = objects if form == "columns" else records
        decision = supervisor.step(
            tm.Cycle(number, now, plan, plan, {"ego": ego, "objects": others, "track": track})
        )
        assert decision.safe, decision
    supervisor.close()
    recording = tm.load_recording(path)
    assert (len(recording.cycles), recording.notes, recording.track) == (3, (), sides)
    assert recording.cycles[2].objects == [{**each, "id": id_} for each, id_ in zip(records, ("a", "7"))]
    assert recording.cycles[2].candidates["driving"] == {name: list(column) for name, column in plan.items()}
    assert all(type(value) is float for value in recording.cycles[2].ego.values())


@pytest.mark.parametrize("name", ["slow", "own.slow"])
def test_a_table_of_a_record_counts_by_both_of_its_names(name: str, tmp_path: Path) -> None:
    """By its whole name it was left out: the spec's own rows judged, and what was unsafe by those in force was safe."""
    path, own, config = tmp_path / "run.arrows", tmp_path / "own.spec", tmp_path / "other.spec"
    table = "table slow(x: m) -> m/s = linear clamp | 0 m: 50 m/s | 9 m: 60 m/s |\n"
    own.write_text(
        "module own\nsignal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
        f"signal ego : state {{ x: m, y: m, heading: rad }}\n{table}"
        "rule limited\n  for all p in plan\n  require p.v <= slow(p.x)\n",
        "utf-8",
    )
    config.write_text(f"module other\n{table}", "utf-8")
    spec = tm.load(own)
    plan = {"t": [0.0, 2.0], "x": [0.0, 8.0], "y": [0.0, 0.0], "heading": [0.0, 0.0], "v": [8.0, 0.0]}
    supervisor = tm.supervisor(spec, tables={name: [[0, 5], [9, 6]]}, clock=lambda: 0.0, record=path)
    ego = {"x": 0.0, "y": 0.0, "heading": 0.0}
    assert not supervisor.step(tm.Cycle(0, 0.0, plan, plan, {"ego": ego})).safe
    supervisor.close()
    recording = tm.load_recording(path)
    outcome = tm.replay(recording, tm.Evaluator(spec))
    assert ([each.safe for each in outcome.cycles], outcome.ignored) == ([False], ())
    assert overruled(recording, own, [config]).tables == {}  # what a person says now counts more


def test_a_record_without_a_cycle_that_passed(tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    supervisor = tm.supervisor(shipped(), ["speed_limit"], record=path)
    supervisor.step(None)
    with pytest.raises(TrackmarshalError) as caught:
        tm.load_recording(path)
    assert caught.value.code == "D130"


@pytest.mark.parametrize(
    ("column", "old", "new", "said"),
    [
        ("verdicts.driving", "siu", "svu", ["b of driving: recorded inactive, now violated"]),
        (
            "margins.emergency",
            np.array([1.0, math.inf, math.nan]),
            [-0.5, math.inf, 2.0],
            [
                "margin of a of emergency: recorded 1.0, now -0.5",
                "margin of c of emergency: recorded nan, now 2.0",
            ],
        ),
        ("verdicts.driving", "", "svu", ["verdicts.driving: recorded '', now 'svu'"]),  # it was not judged
        ("violations", '[{"rule": "c"}, {"rule": "c"}]', "[]", ["violations: recorded c, now nothing"]),
        (
            "violations",
            '[{"rule": "c"}]',
            '[{"rule": "b"}, {"rule": "c"}]',
            ["violations: recorded c, now b, c"],
        ),
        ("state", "drive", "previous_emergency", ["state: recorded 'drive', now 'previous_emergency'"]),
        # What somebody has changed by hand.
        ("verdicts.driving", "sz?", "szu", ["c of driving: recorded ?, now undefined"]),
        ("violations", "{", "[]", ["violations: recorded '{', now '[]'"]),
        ("violations", "[1]", "[]", ["violations: recorded '[1]', now '[]'"]),
        ("violations", "[{}]", "[]", ["violations: recorded '[{}]', now '[]'"]),
    ],
)
def test_a_difference_names_its_rules(column: str, old: Any, new: Any, said: list[str]) -> None:
    """Letters and arrays stood there, cut off where they are long: which rule it was, nobody could tell."""
    assert told(Difference(9, 0.9, column, old, new), ["a", "b", "c"]) == said


@pytest.mark.parametrize("quiet", [[], ["--quiet"]])
def test_what_is_not_known_of_a_run_is_said_where_it_is_explained(
    quiet: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Numbers of a rule that remembers were those of a run that began where this one went on, and of a damaged record those of its front: nothing was said."""
    whole, more, now = tmp_path / "run.arrows", tmp_path / "more.arrows", 0.0
    first, second = (
        tm.supervisor(shipped(), ["speed_limit"], clock=lambda: now, record=path) for path in (whole, more)
    )
    for number, supervisor in enumerate([first, second]):
        now = number * PERIOD
        supervisor.step(cycle(number))
        if supervisor is first:
            second.restore(first.save())
            first.close()
    second.close()
    whole.write_bytes(whole.read_bytes() + more.read_bytes())
    asked = ["--rule", "speed_limit", "--candidate", "driving", "--project", str(ROOT), *quiet]
    for path, at, note in (
        (more, PERIOD, "went on from where"),
        (whole, 0.0, "behind 1 cycles it is damaged"),
    ):
        assert main(["explain", str(path), "--at", str(at), *asked]) == 0
        said = capsys.readouterr()
        assert "speed_limit: " in said.out
        assert (note in said.err) == (not quiet)


def test_a_rule_that_is_gone_is_one_of_the_record(
    record: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of several records that were named, nobody could tell which one asked for it."""
    record.write_bytes(record.read_bytes().replace(b"speed_limit", b"speed_limes"))
    status, _, err = replay(capsys, str(record))
    assert status == 2
    assert "error[E401]: the spec has no rule `speed_limes`" in err
    assert f" --> {record}\n" in err


def test_that_nothing_differs_is_said_of_what_is_left_of_a_record(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of two records in one file, `equal` stood there of the first one, and of the other one nothing."""
    of_bare_cycles(tmp_path, "require ego.v >= 0 m/s", [0, 1])
    record, spec = tmp_path / "run.arrows", str(tmp_path / "bare.spec")
    record.write_bytes(2 * record.read_bytes())
    assert main(["diff", spec, spec, "--on", str(record)]) == 0
    assert "note: run: behind 2 cycles it is damaged" in capsys.readouterr().err


def test_a_packed_record_is_told_to_be_one(record: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`save it as UTF-8` stood there, which destroys it."""
    record.write_bytes(gzip.compress(record.read_bytes()))
    status, _, err = replay(capsys, str(record))
    assert status == 2
    assert "error[D121]: this is the record of a run, packed" in err
    assert "gzip -dc run.arrows" in err
