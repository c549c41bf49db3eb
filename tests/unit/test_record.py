"""The record of a run: what was appended is read again, to the bit, wherever the file was cut off."""

from __future__ import annotations

import json
import math
import os
import random
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import PERIOD, cycle, mutate
from support.length import amount
from support.supervised import Clock, Oracle, made, shipped
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.record import Record
from trackmarshal.runtime.record.arrow import END, FLOAT, FLOATS, INT, TEXT, TEXTS, Layout, layout_of
from trackmarshal.runtime.record.decided import Difference
from trackmarshal.runtime.record.reading import Run, is_record, read
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.supervision import rerun


def recorded(
    path: Path, steps: list[tuple[Any, set[tuple[str, str]], list[Any]]], limits: Limits | None = None, close: bool = True
) -> list[Decision]:  # fmt: skip
    """A run of (cycle, unsafe rules, clock's readings) into a file."""
    supervisor, oracle, clock = made(limits)
    supervisor.recorder = Record(path, supervisor.door.contract, supervisor.limits, oracle.identity)
    decisions = []
    for given, oracle.unsafe, ticks in steps:
        clock.ticks = list(ticks)
        decisions.append(supervisor.step(given))
        assert supervisor.record_error == ""
    if close:
        supervisor.close()
    return decisions


def again(path: Path, steps: list[Any]) -> tuple[Run, list[Difference]]:
    """The record run again with a judge that says the same."""
    run = read(path.read_bytes(), str(path))

    class Same(Oracle):
        def judge(self, memory: Any, frame: Any) -> Any:
            self.unsafe = unsafe.pop(0)
            return super().judge(memory, frame)

    class Box:
        def running(self, limits: Limits, clock: Any) -> Supervisor:
            return Supervisor(shipped(), Same(), limits, clock)

    # The judge is asked about cycles without faults only.
    unsafe = [one[1] for one, kept in zip(steps, run.cycles) if kept.value("verdicts.driving")]
    found = [d for _, differing in rerun(run, cast(Any, Box())) for d in differing]
    return run, found


def plain(count: int) -> list[tuple[Any, set[tuple[str, str]], list[Any]]]:
    """Cycles in time, every third one unsafe."""
    return [
        (cycle(i), {("driving", "friction")} if i % 3 == 2 else set(), [i * PERIOD, i * PERIOD + 0.001])
        for i in range(count)
    ]


def test_cycles_and_decisions_come_back(tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    steps = plain(7)
    decisions = recorded(path, steps)
    run, found = again(path, steps)
    assert found == []
    assert (run.ended, run.rest, run.identity, run.limits) == (True, 0, Oracle.identity, Limits())
    for (given, _, ticks), kept, decision in zip(steps, run.cycles, decisions, strict=True):
        assert kept.readings == tuple(ticks)
        assert (kept.cycle.number, kept.cycle.t) == (given.number, given.t)
        for name, column in given.emergency.items():
            assert kept.cycle.emergency[name].tobytes() == column.tobytes()
        assert kept.cycle.signals["ego"] == given.signals["ego"]
        assert kept.cycle.signals["objects"]["id"] == given.signals["objects"]["id"]
        for side, points in given.signals["track"].items():
            assert np.array_equal(kept.cycle.signals["track"][side], points)
        assert (kept.value("state"), kept.value("lost")) == (decision.state, decision.lost)
        if decision.violations:
            assert json.loads(kept.value("violations"))[0]["rule"] == "friction"


@pytest.mark.verifies("S-1-B-1")
def test_broken_cycles_of_every_kind_run_again_the_same(tmp_path: Path) -> None:
    rng = random.Random(5)
    steps = plain(400)
    for i in range(1, len(steps), 2):
        given, unsafe, ticks = steps[i]
        steps[i] = (mutate(rng, given)[0], unsafe, ticks)
    odd: list[Any] = [
        None,
        7,
        object(),
        [],
        {1: 2, "$": 3},
        Cycle(1, math.nan, {1: 2}, (1, [2]), {"$": "nan"}),
    ]
    steps += [(thing, set(), [41.0 + i]) for i, thing in enumerate(odd)]
    steps += [(cycle(600), set(), [60.0, value]) for value in (60.04, 61.0, math.nan, -1.0)]
    path = tmp_path / "run.arrows"
    recorded(path, steps)
    run, found = again(path, steps)
    assert len(run.cycles) == len(steps)
    assert found == []


def test_an_id_that_is_no_text(tmp_path: Path) -> None:
    steps = plain(3)
    given = steps[1][0]
    objects = {**given.signals["objects"], "id": ["\ud800", "o"]}
    steps[1] = (replace(given, signals={**given.signals, "objects": objects}), set(), steps[1][2])
    path = tmp_path / "run.arrows"
    decisions = recorded(path, steps)
    assert decisions[1].state == "drive"
    run, found = again(path, steps)
    assert found == []
    assert run.cycles[1].cycle.signals["objects"]["id"] == ["\ud800", "o"]


def test_a_border_that_changes_is_kept_when_it_changes(tmp_path: Path) -> None:
    steps = plain(6)
    for i in (3, 4, 5):
        given = steps[i][0]
        track = {**given.signals["track"], "left": given.signals["track"]["left"] + [0.0, 1.0]}
        steps[i] = (replace(given, signals={**given.signals, "track": track}), *steps[i][1:])
    broken = replace(steps[4][0], driving=None)
    steps[4] = (broken, set(), steps[4][2])
    path = tmp_path / "run.arrows"
    recorded(path, steps)
    run, found = again(path, steps)
    assert found == []
    assert [float(kept.cycle.signals["track"]["left"][0][1]) for kept in run.cycles] == [6.0] * 3 + [7.0] * 3


def small(path: Path, count: int) -> bytes:
    """The bytes of a record of few columns: one rule, two samples a trajectory, one step on a straight."""
    supervisor, oracle, clock = made(rules=["speed_limit"])
    supervisor.recorder = Record(path, supervisor.door.contract, supervisor.limits, oracle.identity)
    for number in range(count):
        clock.now = number * PERIOD
        given = cycle(number)
        ends: dict[str, Any] = {
            name: {n: c[[0, -1]] for n, c in getattr(given, name).items()}
            for name in ("driving", "emergency")
        }
        assert supervisor.step(replace(given, **ends)).state == "drive"
    return path.read_bytes()


def test_cut_off_anywhere(tmp_path: Path) -> None:
    whole = small(tmp_path / "run.arrows", 3)
    found = layout_of(whole)
    assert found is not None
    ends = [len(found[0].schema), *(row.end for row in found[0].rows(whole))]
    assert len(ends) == 4
    assert ends[-1] == len(whole)
    near = {end + k for end in ends for k in range(-amount(12, 70), amount(13, 71))}
    for cut in sorted(near & set(range(len(whole))) | set(range(0, len(whole), amount(20, 7)))):
        if cut < ends[0]:
            with pytest.raises(TrackmarshalError) as caught:
                read(whole[:cut], "cut")
            assert caught.value.code == "D161"
            continue
        run = read(whole[:cut], "cut")
        complete = sum(end <= cut for end in ends[1:])
        assert len(run.cycles) == complete
        assert run.rest == cut - ends[complete]
        assert not run.ended


def test_any_changed_byte_of_a_cycle_is_noticed(tmp_path: Path) -> None:
    whole = bytearray(small(tmp_path / "run.arrows", 2))
    found = layout_of(bytes(whole))
    assert found is not None
    begin = len(found[0].schema)
    rng = random.Random(3)
    for at in range(begin, len(whole), amount(10, 3)):
        bit = 1 << rng.randrange(8)
        whole[at] ^= bit
        run = read(bytes(whole), "changed")
        assert len(run.cycles) < 2
        whole[at] ^= bit


def test_any_changed_byte_of_the_head_is_an_error(tmp_path: Path) -> None:
    whole = bytearray(small(tmp_path / "run.arrows", 1))
    found = layout_of(bytes(whole))
    assert found is not None
    for at in range(0, len(found[0].schema), amount(10, 3)):
        whole[at] ^= 0x20
        try:
            run = read(bytes(whole), "changed")
        except TrackmarshalError as error:
            assert error.code in ("D161", "D162")
        else:  # another number or name in the head, and the same file otherwise
            assert len(run.cycles) <= 1
        whole[at] ^= 0x20


def test_no_record_at_all() -> None:
    for data in (
        b"",
        b"\xff\xff\xff\xff",
        b"\xff\xff\xff\xff\x10\x00\x00\x00" + bytes(16),
        END,
        b"PK\x03\x04",
    ):
        assert is_record(data) == data.startswith(b"\xff\xff\xff\xff")
        with pytest.raises(TrackmarshalError) as caught:
            read(data, "x")
        assert caught.value.code == "D161"
    with pytest.raises(TrackmarshalError) as caught:
        read(Layout([("n", INT)], {"format": "other", "version": 1}).schema, "x")
    assert caught.value.code == "D162"


@pytest.mark.parametrize(
    "identity", [[], None, {"rules": 5}, {"rules": [1]}, {"params": []}, {"backend": None}, {"tables": "x"}]
)
def test_a_head_that_describes_no_judge(identity: Any, tmp_path: Path) -> None:
    whole = small(tmp_path / "run.arrows", 1)
    found = layout_of(whole)
    assert found is not None
    head = {**found[1], "identity": identity}
    del head["columns"]
    with pytest.raises(TrackmarshalError) as caught:
        read(Layout(found[0].columns, head).schema, "x")
    assert caught.value.code == "D162"


def test_numbers_of_numpy_among_the_values_in_force(tmp_path: Path) -> None:
    """They were taken without a record, and with one there was a TypeError of JSON."""
    spec = tm.loads(
        "module own\nsignal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
        "signal ego : state { x: m, y: m, heading: rad }\nparam most : m/s = 30 m/s\n"
        "table slow(x: m) -> m/s = linear clamp | 0 m: 5 m/s | 9 m: 6 m/s |\n"
        "rule limited\n  for all p in plan\n  require p.v <= min(most, slow(p.x))\n"
    )
    for number, most in enumerate((np.float32(20), np.int64(20), np.array(20))):
        path = tmp_path / f"{number}.arrows"
        tables = {"slow": np.array([[0.0, 5.0], [8.0, 7.0]])}
        tm.supervisor(spec, record=path, params={"most": most}, tables=tables).close()  # type: ignore[dict-item]
        identity = read(path.read_bytes(), "run").identity
        assert (identity["params"], identity["tables"]) == (
            {"most": 20.0},
            {"slow": [[0.0, 5.0], [8.0, 7.0]]},
        )


def test_a_file_that_is_there_is_not_touched(tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    path.write_bytes(b"mine")
    supervisor, oracle, _ = made()
    for place in (path, tmp_path / "none" / "run.arrows", tmp_path):
        with pytest.raises(TrackmarshalError) as caught:
            Record(place, supervisor.door.contract, supervisor.limits, oracle.identity)
        assert caught.value.code == "E483"
    assert path.read_bytes() == b"mine"


@pytest.mark.parametrize("name", ["run.mcap", "run.jsonl", "run.json", "run.CSV", "run.saa", "run.arrows.gz"])
def test_a_name_with_the_ending_of_another_format(name: str, tmp_path: Path) -> None:
    with pytest.raises(TrackmarshalError, match=r"a stream of Arrow, and no [.]") as caught:
        tm.supervisor(shipped(), ["speed_limit"], record=tmp_path / name)
    assert caught.value.code == "E483"
    assert "its ending is .arrows: `run.arrows`" in str(caught.value)
    assert ("--mcap FILE" in str(caught.value)) == (name == "run.mcap")
    assert not list(tmp_path.iterdir())


def test_a_record_that_fails_leaves_the_decision(tmp_path: Path) -> None:
    class Full:
        def append(self, *args: object) -> None:
            raise OSError(28, "No space left on device")

        def stopped(self) -> None: ...

        def restored(self, lines: object) -> None: ...

        def close(self) -> None: ...

    supervisor, _, clock = made()
    supervisor.recorder = Full()
    clock.now = 0.0
    assert supervisor.step(cycle(0)).state == "drive"
    assert supervisor.record_error == "OSError: [Errno 28] No space left on device"


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_a_supervisor_that_is_closed_says_why_it_keeps_no_record(backend: str, tmp_path: Path) -> None:
    """It decides on; that it was closed is no matter of files."""
    path, now = tmp_path / "run.arrows", 0.0
    supervisor = tm.supervisor(
        shipped(), ["friction"], backend, {"budget": 1e9}, lambda: now, record=path, snapshots=0
    )
    for number in range(3):
        now = number * PERIOD
        assert supervisor.step(cycle(number)).safe
        supervisor.close()
        assert supervisor.record_error == ("OSError: [Errno 9] the record is closed" if number else "")
    run = read(path.read_bytes(), "run")
    assert (len(run.cycles), run.ended, run.damage) == (1, True, "")


def test_a_difference_is_found(tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    steps = plain(6)
    recorded(path, steps)
    run = read(path.read_bytes(), "x")

    class Box:
        def running(self, limits: Limits, clock: Any) -> Supervisor:
            return Supervisor(shipped(), Oracle(), limits, clock)

    found = [d for _, differing in rerun(run, cast(Any, Box())) for d in differing]
    assert {(d.place, d.column) for d in found} >= {
        (2, "state"),
        (2, "safe"),
        (5, "verdicts.driving"),
        (5, "margins.driving"),
    }
    assert all(d.place in (2, 5) for d in found)


def test_other_tools_read_the_format() -> None:
    pyarrow = pytest.importorskip(
        "pyarrow", reason="an independent reader of the format; `pip install pyarrow`"
    )
    columns = [("n", INT), ("f", FLOAT), ("s", TEXT), ("l", FLOATS), ("ids", TEXTS)]
    layout = Layout(columns, {"format": "x", "odd": "\u00e4\u20ac"})
    rows: list[tuple[Any, ...]] = [
        (1, 2.5, "h\u00e4\u00df\U0001f600", np.array([1.0, math.inf, -0.0]), ["a", "bc", ""]),
        (-(2**63), -math.inf, "", np.zeros(0), []),
        (3, 5e-324, "x" * 9, np.arange(50.0), ["\u00fc"]),
    ]
    data = layout.schema + b"".join(layout.batch(row) for row in rows)
    for end in (b"", END):
        with pyarrow.ipc.open_stream(data + end) as reader:
            table = reader.read_all()
        table.validate(full=True)
        assert table.schema.names == ["crc32", *(name for name, _ in columns)]
        for row, read_row in zip(rows, table.to_pylist(), strict=True):
            assert [read_row[name] for name, _ in columns] == [
                value.tolist() if isinstance(value, np.ndarray) else value for value in row
            ]
        assert json.loads(table.schema.metadata[b"trackmarshal"])["odd"] == "\u00e4\u20ac"


def test_other_tools_read_a_record(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip(
        "pyarrow", reason="an independent reader of the format; `pip install pyarrow`"
    )
    path = tmp_path / "run.arrows"
    steps = plain(4)
    recorded(path, steps)
    with pyarrow.ipc.open_stream(path.read_bytes()) as reader:
        table = reader.read_all()
    table.validate(full=True)
    # The last row says after how many cycles it was closed.
    assert table["state"].to_pylist() == ["drive", "drive", "previous_emergency", "drive", ""]
    assert table["row"].to_pylist() == [0, 1, 2, 3, 4]
    assert table["number"][4].as_py() == 4
    assert table["driving.v"][1].as_py() == steps[1][0].driving["v"].tolist()
    assert table["objects.id"][0].as_py() == ["o0", "o1"]


def test_the_clock_of_a_record_is_that_of_the_run(tmp_path: Path) -> None:
    """Time that the run itself took counts again: a verdict that was late stays late."""
    path = tmp_path / "run.arrows"
    steps: list[Any] = [
        (cycle(0), set(), [0.0, 0.01]),
        (cycle(1), set(), [0.1, 0.16]),
        (cycle(2), set(), [0.2, 0.24]),
    ]
    decisions = recorded(path, steps)
    assert [d.state for d in decisions] == ["drive", "previous_emergency", "drive"]
    assert again(path, steps)[1] == []
    assert isinstance(Clock()(), float)


def test_foxglove_reads_an_export(tmp_path: Path) -> None:
    from mcap.reader import make_reader

    from trackmarshal.scenarios import foxglove

    path = tmp_path / "run.arrows"
    steps = plain(6)
    steps[3] = (None, set(), steps[3][2][:1])
    decisions = recorded(path, steps)
    foxglove.write(read(path.read_bytes(), "run"), decisions, tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        messages = [
            (channel.topic, schema.name, message.log_time, json.loads(message.data))
            for schema, channel, message in make_reader(file).iter_messages(log_time_order=False)
            if schema is not None
        ]
    told = [data for topic, _, _, data in messages if topic == "/decision"]
    assert [data["state"] for data in told] == [d.state for d in decisions]
    assert [time for topic, _, time, _ in messages if topic == "/decision"] == [
        round(one[2][0] * 1e9) for one in steps
    ]
    scenes = [
        data for topic, name, _, data in messages if topic == "/scene" and name == "foxglove.SceneUpdate"
    ]
    named = [{entity["id"]: entity for entity in scene["entities"]} for scene in scenes]
    assert ["track" in by_name for by_name in named] == [True, True, True, False, False, True]
    # Of what is driven while no cycle passes the door, the last of it is not left standing.
    colours = [[line["color"]["g"] for line in by_name["driven"]["lines"]] for by_name in named]
    assert colours == [[0.7], [0.7], [0.1], [0.1], [0.1], [0.1]]
    by_name = named[0]
    assert by_name.keys() == {"track", "driving", "emergency", "driven", "ego", "objects", "obstacles"}
    assert len(by_name["objects"]["cubes"]) == 2
    assert len(by_name["driven"]["lines"][0]["points"]) == 30


@pytest.mark.parametrize(
    ("fields", "boxes"),
    [
        (
            "x: m, y: m, heading: deg, length: m, width: m, braking: bool",
            1,
        ),  # its cycles are kept as they came
        ("x: m, y: m, heading: rad, length: m, width: m", 1),
        ("x: m, y: m", 0),  # of no known size
    ],
)
def test_foxglove_reads_an_export_of_what_specs_of_others_declare(
    tmp_path: Path, fields: str, boxes: int
) -> None:
    from mcap.reader import make_reader

    from trackmarshal.scenarios import foxglove

    spec = tm.loads(
        "module own\nsignal track : corridor\nsignal plan : trajectory { t: s increasing, x: m, y: m }\n"
        f"signal objects : set of object {{ {fields} }}\n"
        "rule apart\n  for all o in objects\n  require o.x >= 0 m\n"
        "rule inside\n  for all p in plan\n  require offset(p, track) <= 9 m\n"
    )
    path, clock = tmp_path / "run.arrows", Clock()
    supervisor = tm.supervisor(spec, backend="reference", record=path, clock=clock)
    other = {"id": "a", "x": 900.0, "y": 0.0, "heading": 90.0, "length": 4.0, "width": 2.0, "braking": True}
    known = {name: value for name, value in other.items() if name == "id" or f"{name}: " in fields}
    borders = {"left": tm.line([(0, 5), (99, 5)]), "right": tm.line([(0, -5), (99, -5)])}
    plan = {"t": [0.0, 0.2], "x": [1.0, 3.0], "y": [0.0] * 2, "heading": [0.0] * 2, "v": [10.0] * 2}
    still = {"t": [0.0, 0.2], "x": [1.0, 2.0], "y": [0.0] * 2, "heading": [0.0] * 2, "v": [10.0, 0.0]}
    ego = {"x": 1.0, "y": 0.0, "heading": 0.0}
    decision = supervisor.step(Cycle(0, 0.0, plan, still, {"ego": ego, "objects": [known], "track": borders}))
    assert not decision.faults
    foxglove.write(read(path.read_bytes(), "run"), [decision], tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        messages = {
            channel.topic: json.loads(message.data)
            for _, channel, message in make_reader(file).iter_messages()
        }
    by_name = {entity["id"]: entity for entity in messages["/scene"]["entities"]}
    assert len(by_name["track"]["lines"]) == 2
    assert len(by_name["objects"]["cubes"]) == boxes
    if "deg" in fields:
        turn = by_name["objects"]["cubes"][0]["pose"]["orientation"]
        assert turn["z"] == pytest.approx(math.sin(math.pi / 4))
        assert messages["/cycle"]["objects"] == [known]
        assert messages["/cycle"]["track"]["left"] == borders["left"].points.tolist()


def test_without_the_package_an_export_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    from trackmarshal.scenarios import foxglove

    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    path = tmp_path / "run.arrows"
    with pytest.raises(TrackmarshalError) as caught:
        foxglove.write(read(small(path, 1), "run"), [], tmp_path / "run.mcap")
    assert caught.value.code == "E484"
    assert not (tmp_path / "run.mcap").exists()


@pytest.mark.parametrize("short", [0, 100])
@pytest.mark.parametrize("then", ["on", "closed"])
def test_a_full_disk_costs_the_cycles_that_did_not_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, short: int, then: str
) -> None:
    """The file stays readable, says how many are missing, and borders that came meanwhile are in the next row."""
    path = tmp_path / "run.arrows"
    supervisor, oracle, clock = made()
    supervisor.recorder = Record(path, supervisor.door.contract, supervisor.limits, oracle.identity)
    write = os.write

    def full(file: int, data: Any) -> int:
        if short and len(data) > short:
            return write(file, bytes(data)[:short])
        raise OSError(28, "No space left on device")

    for number in range(6 if then == "on" else 4):
        clock.now = number * PERIOD
        given = cycle(number)
        if number >= 2:
            track = {**given.signals["track"], "left": given.signals["track"]["left"] + [0.0, 1.0]}
            given = replace(given, signals={**given.signals, "track": track})
        with monkeypatch.context() as patch:
            if number in (2, 3):
                patch.setattr(os, "write", full)
            assert supervisor.step(given).state == "drive"
        if number in (2, 3):
            assert "No space left" in supervisor.record_error
    supervisor.close()
    run = read(path.read_bytes(), "x")
    assert (run.ended, run.rest, run.missed) == (True, 0, 2)
    assert [kept.cycle.number for kept in run.cycles] == ([0, 1, 4, 5] if then == "on" else [0, 1])
    left = [float(kept.cycle.signals["track"]["left"][0][1]) for kept in run.cycles]
    assert left == ([6.0, 6.0, 7.0, 7.0] if then == "on" else [6.0, 6.0])


def test_an_export_has_what_was_decided_in_the_run(tmp_path: Path) -> None:
    """Also where its cycles came to something else when they were run again, as by another spec: nothing is drawn as driven that was not."""
    from mcap.reader import make_reader

    from trackmarshal.scenarios import foxglove

    rule = ("driving", "friction")
    kept = recorded(tmp_path / "run.arrows", plain(4))
    again = recorded(
        tmp_path / "again.arrows",
        [(given, {rule} if n != 1 else set(), ticks) for n, (given, _, ticks) in enumerate(plain(4))],
    )
    assert [d.state for d in kept] == ["drive", "drive", "previous_emergency", "drive"]
    assert [d.state for d in again] == [
        "no_emergency_yet",
        "drive",
        "previous_emergency",
        "previous_emergency",
    ]
    foxglove.write(read((tmp_path / "run.arrows").read_bytes(), "run"), again, tmp_path / "run.mcap")
    with (tmp_path / "run.mcap").open("rb") as file:
        told = [
            (channel.topic, json.loads(message.data))
            for _, channel, message in make_reader(file).iter_messages()
        ]
    decided = [data for topic, data in told if topic == "/decision"]
    assert [(data["state"], data["driven_number"]) for data in decided] == [
        (d.state, d.driven.number) for d in kept if d.driven is not None
    ]
    drawn = [
        one["lines"]
        for topic, data in told
        if topic == "/scene"
        for one in data["entities"]
        if one["id"] == "driven"
    ]
    assert [len(lines) for lines in drawn] == [0, 1, 1, 0]


def test_what_a_disk_does_not_confirm_is_not_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a record that waits for the disk in every cycle: the row was there, and the next one had its place once more."""
    path = tmp_path / "run.arrows"
    supervisor, oracle, clock = made()
    supervisor.recorder = Record(
        path, supervisor.door.contract, supervisor.limits, oracle.identity, sync=True
    )

    def fail(file: int) -> None:
        raise OSError(5, "Input/output error")

    for number in range(4):
        clock.now = number * PERIOD
        with monkeypatch.context() as patch:
            if number == 2:
                patch.setattr(os, "fsync", fail)
            assert supervisor.step(cycle(number)).state == "drive"
    assert "Input/output error" in supervisor.record_error
    supervisor.close()
    run = read(path.read_bytes(), "x")
    assert [kept.cycle.number for kept in run.cycles] == [0, 1, 3]
    assert (run.missed, run.damage, run.ended) == (1, "", True)
