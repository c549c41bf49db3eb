"""A record's replay from the middle: from there on the same as the whole replay, whatever rules remember, and wherever the file was cut off."""

from __future__ import annotations

import json
import math
import os
import re
import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from support.length import AT_LENGTH, amount, at_length, shared_out
from support.pairs import generated
from support.remembering import NAMES, remembering, sources
from support.supervised import ROOT
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.saving import MOST_BYTES, words
from trackmarshal.cli.main import main
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import loads
from trackmarshal.ir.spec import Spec, remembers
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.record.decided import decided
from trackmarshal.runtime.record.reading import Run, read
from trackmarshal.runtime.record.snapshots import Snapshot
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.scenarios.supervised import recording_of
from trackmarshal.supervision import box_of, nearest, rerun, supervisor

needs_c = pytest.mark.skipif(compiler() is None, reason="no C compiler")
BACKENDS = ("numpy", at_length("reference"), pytest.param("c", marks=needs_c))
#: Those that save what rules remember.
SAVING = ("numpy", pytest.param("c", marks=needs_c))

RULES = """module m
param most : m/s = 40 m/s
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s in [-10, 150] }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { x: m } capacity 3
event flag
state light : { clear, caution } starts clear
  becomes caution when flag
    remember entry = ego.v
  becomes clear when not flag and once[0.2 s, 1 s] flag
state near : { no, yes } for each o in objects starts no
  becomes yes when o.x - ego.x < 20 m
    remember gap = o.x - ego.x
  becomes no when o.x - ego.x > 25 m
rule braked "" require not once[0.05 s, 0.45 s] (flag and ego.v > most)
rule driven "" require historically[0.02 s, 0.5 s] plan.first.v > 1 m/s
rule since_then "" require flag since[0 s, 2 s] ego.v < most
rule few "" require count(flag, last: 1.5 s) <= 4
rule ever "" require count(rising(flag)) <= 9
rule long "" require time_in(light) <= 0.6 s and light.entry < 60 m/s
rule close "" for all o in objects require near(o) is yes implies (near(o).gap > 12 m and time_in(near(o)) < 2 s)
rule came "" for all o in objects except not previous o.x > ego.x "" require o.x > ego.x - 5 m
rule order "" for all o in objects for all p in objects where o.x > p.x + 6 m require not previous o.x < p.x
rule passed "" for all o in objects for all p in objects require count(o.x < p.x, reset: o.x > p.x + 9 m) <= 3
"""


@cache
def rules() -> Spec:
    return loads(RULES)


def _plan(x: float, v: float) -> dict[str, list[float]]:
    along = [x, x + 10.0, x + 20.0, x + 25.0]
    return {
        "t": [0.0, 1.0, 2.0, 4.0],
        "x": along,
        "y": [0.0] * 4,
        "heading": [0.0] * 4,
        "v": [v, 10.0, 5.0, 0.0],
    }


def straight(number: int) -> Cycle | None:
    """A car that drives on straight; every 23rd cycle does not come, every 31st lacks its speed."""
    t = round((number + 1) / 10, 9)
    v = 10.0 + 45.0 * (number % 17 == 3)
    there = [name for k, name in enumerate("abc") if (number // (4 + k)) % 3]
    signals = {
        "ego": {"x": 10.0 * t, "y": 0.0, "heading": 0.0, "v": v},
        "objects": {
            "id": there,
            "x": [10.0 * t + 10.0 + (7 * number + 3 * k) % 19 for k in range(len(there))],
        },
        "flag": number % 11 in (2, 3, 4),
    }
    if number % 31 == 30:
        del signals["ego"]["v"]  # type: ignore[attr-defined]
    return None if number % 23 == 22 else Cycle(number, t, _plan(10.0 * t, v), _plan(10.0 * t, v), signals)


def recorded(
    path: Path, backend: str, count: int = 120, snapshots: int = 10, close: bool = True, **choice: Any
) -> tuple[Any, list[Any]]:
    """A run of `straight` into a record: the Supervisor, and its decisions."""
    now = 0.0
    made: Any = supervisor(
        rules(),
        None,
        backend,
        Limits(overspeed=1e3, budget=1e9),
        lambda: now,
        record=path,
        snapshots=snapshots,
        **choice,
    )
    decisions = []
    for number in range(count):
        now = round((number + 1) / 10, 9)
        decisions.append(made.step(straight(number)))
        assert (made.record_error, made.recorder.snapshot_error) == ("", "")
    if close:
        made.close()
    return made, decisions


@cache
def _record(count: int, snapshots: int) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        recorded(Path(folder) / "run.arrows", "numpy", count, snapshots)
        return (Path(folder) / "run.arrows").read_bytes()


def record(path: Path, count: int, snapshots: int = 10) -> None:
    """The file of such a run with numpy, for those that only read it: each is made once."""
    path.write_bytes(_record(count, snapshots))


def told(run: Run, spec: Spec, backend: str | None, begin: Snapshot | None) -> list[Any]:
    """By cycle: the decision as it is recorded, and what each rule says of it and of earlier ones."""
    box = box_of(run, spec, backend)
    over = [place for place, rule in enumerate(box.evaluator.rules) if remembers(rule)]
    found = []
    for decision, differing in rerun(run, box, begin):
        about = []
        if decision.judged is not None and not decision.faults:
            for rated in decision.judged.rated.values():
                about += [repr(rated.explain(place, False).about) for place in over]
        found.append((repr(decided(decision)), decision.state, decision.lost, about, repr(differing)))
    return found


def verdicts(made: Any, decisions: list[Any]) -> set[tuple[str, str]]:
    names = [rule.name for rule in (made.rules if hasattr(made, "rules") else made.program.rules)]
    return {
        (name, VERDICTS[code]) for one in decisions if one.judged is not None
        for rated in one.judged.rated.values() for name, code in zip(names, rated.verdicts)
    }  # fmt: skip


@pytest.mark.parametrize("backend", ["numpy", pytest.param("c", marks=[needs_c, pytest.mark.acceptance])])
def test_from_every_cycle(backend: str, tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    said = verdicts(*recorded(path, backend))
    for rule in ("braked", "driven", "since_then", "few", "long", "close", "came"):
        assert {verdict for name, verdict in said if name == rule} >= {"satisfied", "violated"} or rule in (
            "driven",
            "came",
        ), rule
    run, spec = read(path.read_bytes(), "run"), rules()
    assert len(run.snapshots) >= 9
    whole = told(run, spec, None, None)
    assert len(whole) == 120
    assert all(one[-1] == "[]" for one in whole)
    for snapshot in run.snapshots[:: amount(3, 1)]:
        assert told(run, spec, None, snapshot) == whole[snapshot.after :], snapshot.after
    box = box_of(run, spec)
    for place in range(120):
        found, refused = nearest(run, box, place)
        assert refused is None
        assert (0 if found is None else found.after) == max(
            (one.after for one in run.snapshots if one.after <= place), default=0
        )


@pytest.mark.parametrize("recording", SAVING)
@pytest.mark.parametrize("backend", BACKENDS)
def test_with_another_evaluator_than_that_of_the_run(recording: str, backend: str, tmp_path: Path) -> None:
    """It starts at the beginning, and says so; of the reference, with its own too."""
    path = tmp_path / "run.arrows"
    recorded(path, recording, 60)
    run, spec = read(path.read_bytes(), "run"), rules()
    found, refused = nearest(run, box_of(run, spec, backend), 50)
    if backend == recording:
        assert (found is not None, refused) == (True, None)
    else:
        assert found is None
        assert refused is not None
        assert refused.code == ("E486" if backend == "reference" else "D164")


def test_a_record_of_the_reference_has_none(tmp_path: Path) -> None:
    path, now = tmp_path / "run.arrows", 0.0
    made: Any = supervisor(
        rules(), None, "reference", Limits(budget=1e9), lambda: now, record=path, snapshots=5
    )
    for number in range(20):
        now = round((number + 1) / 10, 9)
        made.step(straight(number))
    made.close()
    assert made.record_error == ""
    assert "keeps every cycle" in made.recorder.snapshot_error
    run = read(path.read_bytes(), "run")
    assert (len(run.cycles), run.snapshots) == (20, ())


@pytest.mark.parametrize("backend", SAVING)
def test_other_values_or_rules_take_no_snapshot(backend: str, tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    recorded(path, backend, 40, params={"most": 50.0})
    run, spec = read(path.read_bytes(), "run"), rules()
    assert nearest(run, box_of(run, spec), 39)[0] is not None
    changed = {
        "params": {**run.identity, "params": {"most": 49.0}}, "rules": {**run.identity, "rules": ["braked", "few"]}
    }  # fmt: skip
    for identity in changed.values():
        other = Run(identity, run.limits, run.cycles, True, 0, 0, run.snapshots)
        found, refused = nearest(other, box_of(other, spec), 39)
        assert found is None
        assert refused is not None
        assert refused.code == "D164"
    wider = Run(
        run.identity, Limits(overspeed=1e3, budget=1e9, apart=9.0), run.cycles, True, 0, 0, run.snapshots
    )
    assert nearest(wider, box_of(wider, spec), 39)[0] is None
    others = (
        ("last: 1.5 s", "last: 1.6 s"),
        ("starts clear", "starts caution"),
        ("o.x - ego.x > 25 m", "o.x - ego.x > 26 m"),
    )
    # What a snapshot is of is asked of the spec: every day, a compiler works on one of them.
    for old, new in others[:1] if backend == "c" and not AT_LENGTH else others:
        assert old in RULES
        assert nearest(run, box_of(run, loads(RULES.replace(old, new))), 39)[0] is None


# Runs with faults of every kind ------------------------------------------------------------------------------------------


@cache
def shipped(folder: Path) -> Spec:
    return remembering(folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("specs")


@pytest.mark.parametrize("backend", [at_length("numpy"), SAVING[1]])
@pytest.mark.parametrize("seed", shared_out(range(3), 3))
def test_generated_runs(seed: int, backend: str, folder: Path, tmp_path: Path) -> None:
    """Cycles that are refused, late, twice or missing, clocks that are wrong, trajectories that are left, borders that change."""
    spec, path, ticks = shipped(folder), tmp_path / "run.arrows", list[Any]()
    made: Any = supervisor(spec, None, backend, clock=lambda: ticks.pop(0), record=path, snapshots=4)
    for given, readings in generated(seed):
        ticks[:] = readings
        made.step(given)
    made.close()
    assert (made.record_error, made.recorder.snapshot_error) == ("", "")
    run = read(path.read_bytes(), "run")
    assert len(run.snapshots) >= (
        3 if backend == "c" else 5
    )  # C writes all its memory, a little in each step
    whole = told(run, spec, None, None)
    for snapshot in run.snapshots[1 :: amount(8, 4)]:
        assert told(run, spec, None, snapshot) == whole[snapshot.after :], snapshot.after


@pytest.mark.parametrize("backend", SAVING)
@pytest.mark.parametrize("what", ["unsafe", "twice", "early", "clock"])
def test_all_that_a_supervisor_keeps(what: str, backend: str, tmp_path: Path) -> None:
    """The cycle after the snapshot drives what is stored, comes twice, comes too early, or is read at a clock that goes back."""
    spec = loads(RULES.partition("state light")[0] + 'rule slow "" require plan.first.v <= 11 m/s\n')
    path, now = tmp_path / "run.arrows", 0.0
    made: Any = supervisor(spec, None, backend, {"budget": 1e9}, lambda: now, record=path, snapshots=5)
    decisions = []
    for place in range(8):
        number = place - (what == "twice" and place == 5)
        t = round((number + 1) / 10, 9)
        now = t - (0.3 if what == "clock" and place == 5 else 0.0)
        v = 20.0 if what == "unsafe" and place >= 5 else 10.0
        signals = {
            "ego": {"x": 10.0 * t, "y": 0.0, "heading": 0.0, "v": 10.0},
            "objects": {"id": [], "x": []},
            "flag": False,
        }
        stamp = t - (0.0995 if what == "early" and place == 5 else 0.0)
        decisions.append(made.step(Cycle(number, stamp, _plan(10.0 * t, v), _plan(10.0 * t, v), signals)))
    made.close()
    then = "no_safe_trajectory" if what == "clock" else "previous_emergency"
    assert [one.state for one in decisions[:6]] == ["drive"] * 5 + [then]
    run = read(path.read_bytes(), "run")
    assert run.snapshots[0].after == 5
    assert told(run, spec, None, run.snapshots[0]) == told(run, spec, None, None)[5:]


# The file --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("backend", SAVING)
def test_cut_off_anywhere(backend: str, tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    recorded(path, backend, 45, close=False)
    data, spec = path.read_bytes(), rules()
    whole = read(data, "run")
    known = {one.after: one for one in whole.snapshots}
    box = box_of(whole, spec)
    complete = told(whole, spec, None, None)
    seen = set()
    for cut in range(len(data) // 3, len(data), len(data) // 41):
        run = read(data[:cut], "cut")
        assert all(known[one.after] == one for one in run.snapshots)
        found, refused = nearest(run, box, len(run.cycles))
        assert refused is None
        first = 0 if found is None else found.after
        seen.add(first)
        if cut % 4 == 0:
            assert told(run, spec, None, found) == complete[first : len(run.cycles)]
    assert len(seen) >= 3


def test_a_disk_that_is_full_costs_the_snapshot_and_no_cycle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from trackmarshal.runtime.record import Record

    write, refused = Record._write, []

    def fails(self: Record, data: bytes) -> None:
        if b'{"snapshot":20,' in data:
            refused.append(len(data))
            raise OSError("no room")
        write(self, data)

    monkeypatch.setattr(Record, "_write", fails)
    path = tmp_path / "run.arrows"
    recorded(path, "numpy", 60)
    run = read(path.read_bytes(), "run")
    assert refused
    assert (len(run.cycles), run.missed, run.ended) == (60, 0, True)
    afters = [one.after for one in run.snapshots]
    assert (afters[:2], len(afters) >= 4) == ([10, 30], True)


def test_cycles_that_could_not_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What comes after them is decided from the snapshot as it was in the run, which no replay from the beginning can."""
    from trackmarshal.runtime.record import Record

    write, number = Record._write, [0]

    def fails(self: Record, data: bytes) -> None:
        if 24 <= number[0] < 27:
            raise OSError("no room")
        write(self, data)

    monkeypatch.setattr(Record, "_write", fails)
    path, now = tmp_path / "run.arrows", 0.0
    spec = rules()
    made: Any = supervisor(
        spec, None, "numpy", Limits(overspeed=1e3, budget=1e9), lambda: now, record=path, snapshots=10
    )
    for number[0] in range(60):
        now = round((number[0] + 1) / 10, 9)
        made.step(straight(number[0]))
    made.close()
    run = read(path.read_bytes(), "run")
    assert (len(run.cycles), run.missed) == (57, 3)
    found, _ = nearest(run, box_of(run, spec), 56)
    assert found is not None
    assert [differing for _, differing in rerun(run, box_of(run, spec), found) if differing] == []


def _going_on(path: Path, backend: str, first: int, stop: int, lines: list[str]) -> list[str]:
    """The cycles of `straight` from first to stop into a record, from where another Supervisor was saved; then its lines are those of where it is."""
    now = 0.0
    limits = Limits(overspeed=1e3, budget=1e9)
    made: Any = supervisor(rules(), None, backend, limits, lambda: now, path)
    for number in range(first, stop):
        if number == first + 4 and lines:
            made.restore(lines)
        now = round((number + 1) / 10, 9)
        made.step(straight(number))
    made.close()
    assert (made.record_error, made.recorder.snapshot_error) == ("", "")
    saved: list[str] = made.save()
    return saved


@pytest.mark.parametrize("backend", SAVING)
def test_a_run_that_goes_on_from_another_one(backend: str, tmp_path: Path) -> None:
    """In its record is from where, so that a replay decides the same: here behind four cycles of its own."""
    path, spec = tmp_path / "run.arrows", rules()
    saved = _going_on(tmp_path / "before.arrows", backend, 0, 34, [])
    _going_on(path, backend, 30, 50, saved)
    run = read(path.read_bytes(), "run")
    assert [(one.after, one.restored) for one in run.snapshots] == [(4, True)]
    whole = told(run, spec, None, None)
    assert (len(whole), {one[-1] for one in whole}) == (20, {"[]"})
    found, _ = nearest(run, box_of(run, spec), 10)
    assert told(run, spec, None, found) == whole[4:]
    # What was remembered does matter to it, and nobody who cannot go on from it says that the run was another one.
    assert {one[-1] for one in told(replace(run, snapshots=()), spec, None, None)[4:]} > {"[]"}
    with pytest.raises(TrackmarshalError, match="the run went on from it") as caught:
        told(run, spec, "reference", None)
    assert caught.value.code == "E486"
    noted = "before cycle 4 it went on from where another run had been saved; what rules remembered of that is not known here"
    assert noted in recording_of(path.read_bytes(), "run", "run").notes


def test_what_a_run_goes_on_from_is_written_once_the_disk_takes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cycles whose rows nobody can judge without it do not stand there without it: a replay called them decided otherwise."""
    path, spec, now, full = tmp_path / "run.arrows", rules(), 0.0, False
    saved = _going_on(tmp_path / "before.arrows", "numpy", 0, 34, [])
    made: Any = supervisor(
        spec, None, "numpy", Limits(overspeed=1e3, budget=1e9), lambda: now, record=path, snapshots=0
    )
    real = os.write

    def write(file: int, data: Any) -> int:
        if full:
            raise OSError(28, "No space left on device")
        return real(file, data)

    monkeypatch.setattr(os, "write", write)
    for number in range(30, 50):
        if number == 34:
            full = True
            made.restore(saved)
            assert "No space left" in made.record_error
        if number == 35:
            full = False
        now = round((number + 1) / 10, 9)
        made.step(straight(number))
    made.close()
    run = read(path.read_bytes(), "run")
    assert (run.damage, len(run.cycles), run.missed, list(run.restored)) == ("", 19, 1, [4])
    again = rerun(run, box_of(run, spec))
    assert [differing for _, differing in again if differing and differing[0].place < 4] == []


def test_a_step_saves_a_little(tmp_path: Path) -> None:
    """However much rules remember: no row of a snapshot is larger than so much, and none holds up the cycles."""
    path = tmp_path / "run.arrows"
    recorded(path, "numpy", 120)
    for one in read(path.read_bytes(), "run").snapshots:
        assert all(len(part) < 64_000 for part in one.parts)


# The command -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "m.spec").write_text(RULES, encoding="utf-8")
    return tmp_path


def replay(project: Path, capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    status = main(["replay", str(project / "run.arrows"), "--spec", str(project / "m.spec"), *arguments])
    said = capsys.readouterr()
    return status, said.out, said.err


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_same_lines(backend: str, project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record(project / "run.arrows", 60)
    chosen = ("--format", "jsonl", "--backend", backend)
    status, out, err = replay(project, capsys, *chosen)
    assert (status, err) == (0, "")
    whole = [json.loads(line) for line in out.splitlines()]
    places = {"0": 0, "33": 33, "59": 59, "4.0s": 39, "4.05 s": 40} if backend == "numpy" else {"33": 33}
    for begin, place in places.items():
        status, out, err = replay(project, capsys, *chosen, "--from", begin)
        assert status == 0
        assert [json.loads(line) for line in out.splitlines()] == whole[2 * place :]
        assert ("a snapshot is not used" in err) == (backend != "numpy" and place >= 10)


def test_the_summary(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = project / "run.arrows"
    record(path, 60)
    _, out, _ = replay(project, capsys, "--from", "33")
    lines = out.splitlines()
    assert lines[0].startswith(f"{path}: 27 cycles from cycle 33 on, ")
    assert lines[1:] == ["started at the snapshot after 30 cycles", "same decisions, bit for bit"]
    _, out, _ = replay(project, capsys, "--from", "5")
    assert out.splitlines()[1].startswith("started at the beginning")


def test_a_record_of_no_cycle_shows_nothing(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Cut off in its first row, as where the process was killed at once: there is no decision that could be the same."""
    path = project / "run.arrows"
    record(path, 1)
    data = path.read_bytes()
    length = next(n for n in range(len(data), 0, -500) if not read(data[:n], "run").cycles)
    path.write_bytes(data[:length])
    status, out, _ = replay(project, capsys)
    assert status == 1
    head, last = out.splitlines()
    assert head.startswith(f"{path}: 0 cycles; not closed, ")
    assert last == "no decision is in it: none is shown to be the same"


@pytest.mark.parametrize("begin", ["60", "-1", "1.5", "9 m", "nans", "100s", "", "s"])
def test_no_such_place(begin: str, project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record(project / "run.arrows", 60)
    status, _, err = replay(project, capsys, f"--from={begin}")
    assert status == 2
    assert "E436" in err


def test_beside_what_needs_every_cycle(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record(project / "run.arrows", 30)
    for option in ("--mcap", "--out"):
        status, _, err = replay(project, capsys, "--from", "3", option, str(project / "out"))
        assert status == 2
        assert "E436" in err
    scenario = str(next((ROOT / "specs" / "scenarios").glob("*.tmrec.jsonl")))
    assert main(["replay", scenario, "--from", "3", "--project", str(ROOT)]) == 2
    assert "E436" in capsys.readouterr().err


def test_a_damaged_snapshot_is_said_and_an_earlier_one_used(
    project: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One whose row is whole, and whose content is not what was saved."""
    from trackmarshal.runtime.record import snapshots

    more = snapshots.Snapshots._more

    def broken(self: snapshots.Snapshots, writer: Any) -> str:
        return more(self, writer).replace("held", "heLd") if self._after == 30 else more(self, writer)

    with monkeypatch.context() as patch:
        patch.setattr(snapshots.Snapshots, "_more", broken)
        recorded(project / "run.arrows", "numpy", 60)
    status, out, err = replay(project, capsys, "--from", "33")
    assert status == 0
    assert "D163" in err
    assert "started at the snapshot after 20 cycles" in out


def test_a_record_without_snapshots(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record(project / "run.arrows", 60, snapshots=0)
    status, out, err = replay(project, capsys, "--from", "33")
    assert (status, err) == (0, "")
    assert "started at the beginning" in out


@cache
def on_track(folder: Path) -> Spec:
    return tm.load([sources(folder)], [ROOT / "specs" / "tracks" / "northfield.spec"], folder)


@pytest.mark.parametrize("backend", [at_length("numpy"), SAVING[1]])
@pytest.mark.parametrize("scenario", [at_length("cut_in.tmrec.jsonl"), "late_brakes.tmrec.jsonl.gz"])
def test_shipped_scenarios(
    scenario: str, backend: str, tmp_path_factory: pytest.TempPathFactory, tmp_path: Path
) -> None:
    """The shipped rules, and some that remember; the car of a recording does not follow decisions."""
    recording = tm.load_recording(ROOT / "specs" / "scenarios" / scenario)
    spec, path, now = on_track(tmp_path_factory.getbasetemp()), tmp_path / "run.arrows", 0.0
    wide: dict[str, Any] = dict.fromkeys(
        ("oldest", "budget", "apart", "beside", "turned", "overspeed", "blind", "longest_gap"), math.inf
    )
    limits = replace(Limits.of(spec), **wide)  # none, which is no car's
    made: Any = supervisor(
        spec, None, backend, limits, lambda: now, path, recording.params, recording.tables, snapshots=25
    )
    decisions = []
    for given in tm.cycles(recording):
        now = given.t
        decisions.append(made.step(given))
    made.close()
    assert (made.record_error, made.recorder.snapshot_error) == ("", "")
    assert {rule for rule, _ in verdicts(made, decisions)} >= set(NAMES)
    run = read(path.read_bytes(), "run")
    assert len(run.snapshots) >= 3
    whole = told(run, spec, None, None)
    assert all(one[-1] == "[]" for one in whole)
    for snapshot in run.snapshots[1 :: amount(8, 2)]:
        assert told(run, spec, None, snapshot) == whole[snapshot.after :], snapshot.after


@needs_c
def test_memory_that_is_too_large_to_be_copied(tmp_path: Path) -> None:
    """The record goes on without snapshots, and says why."""
    rules = RULES.partition("state light")[0] + 'rule f "" require not once[0 s, 1 h] flag\n'
    made: Any = supervisor(
        loads(rules),
        None,
        "c",
        {"budget": 1e9, "rate": 50},
        lambda: 0.1,
        tmp_path / "run.arrows",
        snapshots=1,
    )
    made.step(straight(0))
    made.close()
    assert made.record_error == ""
    said = re.search(r"E486.* takes (\d+) KiB, and at most (\d+) are saved", made.recorder.snapshot_error)
    assert said is not None
    assert int(said[1]) > int(said[2]) == MOST_BYTES >> 10
    run = read((tmp_path / "run.arrows").read_bytes(), "run")
    assert (len(run.cycles), run.snapshots) == (1, ())


def test_memory_that_is_only_just_too_large_is_said_to_be_larger() -> None:
    """It was said to take 4 MiB, where at most 4 are saved."""
    with pytest.raises(TrackmarshalError, match="takes 4097 KiB, and at most 4096 are saved"):
        words("program", [(0, MOST_BYTES + 1)], {})
    assert words("program", [(0, MOST_BYTES)], {})


@pytest.mark.parametrize("every", [-1, 1.5, True, None])
def test_no_number_of_cycles(every: Any, tmp_path: Path) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        recorded(tmp_path / "run.arrows", "numpy", 1, snapshots=every)
    assert caught.value.code == "E481"
    assert not (tmp_path / "run.arrows").exists()
