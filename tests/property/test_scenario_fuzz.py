"""Whatever the bytes of a recording or a declaration, the answer is a recording or a TrackmarshalError."""

from __future__ import annotations

import gzip
import io
import math
import random
import shutil
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from support.length import amount
from trackmarshal import scenarios
from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios import recording_io, saa
from trackmarshal.scenarios.codes import CODES
from trackmarshal.scenarios.faults import declaration as faults
from trackmarshal.scenarios.generate import document, generate
from trackmarshal.scenarios.recording import CANDIDATES, COLUMNS, TRUTHS, Cycle, Recording

SHARED = Path(__file__).parents[3] / "shared" / "data" / "scenarios"
SPECS = Path(__file__).parents[2] / "specs"
PLAN = "[[0,0,-1.5,0,5,0],[1,0,-1.5,0,5,0]]"
SCN = (
    "# bound_l:[[0,5],[50,5]]\n# bound_r:[[0,-5],[50,-5]]\n"
    "time;x;y;heading;curv;vel;acc;ego_traj;ego_traj_em;object_array;safety_dyn;safety_stat\n"
    f'0.0;0;0;-1.5;0;5;0;{PLAN};{PLAN};[["a",[9,1,0,5,4.7,2]]];true;null\n'
    f"0.1;0;0;-1.5;0;5;NaN;{PLAN};{PLAN};[];false;null\n"
)


def archive(method: int) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as packed:
        packed.writestr("scene.scn", SCN)
        packed.writestr("scene.sas", b"\x80\x04N.")
        packed.writestr("scene_ggv.csv", "# v, ax, ay\n0.0, 13.0, 13.0\n")
        packed.writestr("scene_ax_max_machines.csv", "# v, ax\n0.0, 6.0\n4.0, 6.0\n")
    return stream.getvalue()


ARCHIVES = [archive(zipfile.ZIP_STORED), archive(zipfile.ZIP_DEFLATED)]


@st.composite
def mutants(draw: st.DrawFn, originals: list[bytes]) -> bytes:
    """An original with bytes changed, taken out, put in or doubled, and perhaps cut off."""
    data = bytearray(draw(st.sampled_from(originals)))
    for _ in range(draw(st.integers(0, 4))):
        at = draw(st.integers(0, max(0, len(data) - 1)))
        match draw(st.sampled_from(("set", "flip", "out", "in", "double"))):
            case "set":
                data[at : at + 1] = bytes([draw(st.integers(0, 255))])
            case "flip":
                data[at : at + 1] = bytes([data[at] ^ (1 << draw(st.integers(0, 7)))]) if data else b""
            case "out":
                del data[at : at + draw(st.integers(1, 40))]
            case "in":
                tokens = [b"[", b"{", b'"', b";", b"\n", b"-", b"NaN", b"1e999", b"null", b"\xff", b"9" * 30]
                data[at:at] = draw(st.sampled_from(tokens))
            case "double":
                data[at:at] = data[at : at + draw(st.integers(1, 200))]
    if draw(st.booleans()):
        del data[draw(st.integers(0, len(data))) :]
    return bytes(data)


def outcome(read: Any, *arguments: Any) -> Any:
    """What is read, or the TrackmarshalError."""
    try:
        return read(*arguments)
    except TrackmarshalError as error:
        return error


def check(read: Any, *arguments: Any) -> None:
    """A recording whose plans are whole, or an error with a known code."""
    recording = outcome(read, *arguments)
    if isinstance(recording, TrackmarshalError):
        assert recording.code in CODES
        assert str(recording).encode()  # it can be printed
        return
    assert recording.cycles
    for cycle in recording.cycles:
        for plan in cycle.candidates.values():
            assert set(COLUMNS) <= plan.keys()
            assert len({len(column) for column in plan.values()}) == 1


@given(mutants(ARCHIVES))
@settings(max_examples=amount(30, 300), deadline=None)
def test_changed_archives(data: bytes) -> None:
    check(saa.read, data, "x.saa")


@given(mutants([SCN.encode()]))
@settings(max_examples=amount(20, 200), deadline=None)
def test_changed_texts_in_sound_archives(text: bytes) -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed:
        packed.writestr("scene.scn", text)
    check(saa.read, stream.getvalue(), "x.saa")


@pytest.mark.parametrize("whole", ARCHIVES, ids=["stored", "deflated"])
def test_archives_cut_off_anywhere_are_refused(whole: bytes) -> None:
    for end in range(len(whole)):
        with pytest.raises(TrackmarshalError):
            saa.read(whole[:end], "x.saa")


def test_real_archives_cut_off_or_changed() -> None:
    paths = sorted(SHARED.glob("*.saa"))
    if not paths:
        pytest.skip(f"{SHARED} is not there")
    chance = random.Random(20)
    for path in paths:
        whole = path.read_bytes()
        for _ in range(10):
            with pytest.raises(TrackmarshalError):
                saa.read(whole[: chance.randrange(len(whole))], "x.saa")
            data = bytearray(whole)
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
            check(saa.read, bytes(data), "x.saa")


numbers = st.one_of(st.floats(), st.integers(-5, 5).map(float))
finite = st.floats(allow_nan=False, allow_infinity=False)
names = st.text(st.characters(codec="utf-8"), max_size=8)
points = st.lists(st.lists(finite, min_size=2, max_size=2), min_size=2, max_size=4)


@st.composite
def trajectories(draw: st.DrawFn) -> dict[str, list[float]]:
    count = draw(st.integers(1, 4))
    extra = draw(st.lists(names, max_size=1))
    return {name: draw(st.lists(numbers, min_size=count, max_size=count)) for name in (*COLUMNS, *extra)}


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    """Any recording that the format can hold."""
    times = sorted(draw(st.sets(finite, min_size=1, max_size=4)))
    cycles = []
    for t in times:
        ids = draw(st.lists(names, unique=True, max_size=2))
        fields = st.dictionaries(
            names.filter(lambda n: n != "id"), st.one_of(numbers, st.booleans()), max_size=3
        )
        objects = [{"id": i, **draw(fields)} for i in ids]
        there = draw(st.lists(st.sampled_from(CANDIDATES), unique=True, min_size=1))
        ego = draw(st.dictionaries(names, numbers, max_size=3))
        cycles.append(Cycle(t, ego, objects, {name: draw(trajectories()) for name in there}))
    truth = st.lists(st.sampled_from([True, False, None]), min_size=len(times), max_size=len(times)).map(
        tuple
    )
    xs = sorted(draw(st.sets(finite, min_size=1, max_size=3)))
    return Recording(
        name=draw(names),
        source="x",
        cycles=tuple(cycles),
        track={"left": draw(points), "right": draw(points), "closed": draw(st.booleans())},
        params=draw(st.dictionaries(names, finite, max_size=2)),
        tables={name: [[x, 0.5] for x in xs] for name in draw(st.lists(names, max_size=2))},
        ground_truth={name: draw(truth) for name in draw(st.lists(st.sampled_from(TRUTHS), unique=True))},
        obstacles=[
            {"id": name, "x": draw(numbers)} for name in draw(st.lists(names, unique=True, max_size=2))
        ],
        use=tuple(draw(st.lists(names, max_size=2))),
        notes=tuple(draw(st.lists(names, max_size=2))),
    )


def is_whole(value: Any) -> bool:
    """No NaN anywhere: NaN is unequal to itself."""
    if isinstance(value, dict):
        return all(map(is_whole, value.values()))
    if isinstance(value, list | tuple):
        return all(map(is_whole, value))
    return not (isinstance(value, float) and math.isnan(value))


@given(recordings())
@settings(max_examples=amount(17, 100), deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_what_is_encoded_is_decoded(recording: Recording) -> None:
    lines = list(recording_io.encode(recording))
    copy = recording_io.decode("\n".join(lines).encode(), "x")
    assert repr(copy) == repr(recording)
    assert list(recording_io.encode(copy)) == lines
    if is_whole(recording.obstacles) and all(
        is_whole([c.ego, c.objects, c.candidates]) for c in recording.cycles
    ):
        assert copy == recording


SAMPLE = "\n".join(
    recording_io.encode(
        Recording(
            name="sample",
            source="x",
            cycles=tuple(
                Cycle(
                    t,
                    {"x": 0.0, "v": math.nan},
                    [{"id": "a", "x": 1.0}],
                    {"driving": {name: [0.5, 1.5] for name in COLUMNS}},
                )
                for t in (0.0, 0.1)
            ),
            track={"left": [[0.0, 5.0], [9.0, 5.0]], "right": [[0.0, -5.0], [9.0, -5.0]], "closed": False},
            params={"R_min": 11.0},
            ground_truth={"dynamic": (True, None)},
        )
    )
).encode()


@given(mutants([SAMPLE]))
@settings(max_examples=amount(30, 300), deadline=None)
def test_changed_lines(data: bytes) -> None:
    check(recording_io.decode, data, "x.tmrec.jsonl")


@given(
    data=mutants([gzip.compress(SAMPLE, mtime=0), SAMPLE, *ARCHIVES]),
    name=st.sampled_from(["x.gz", "x.saa", "x"]),
)
@settings(
    max_examples=amount(17, 150), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_changed_files(tmp_path: Path, data: bytes, name: str) -> None:
    (tmp_path / name).write_bytes(data)
    check(scenarios.load, tmp_path / name)


DECLARATION = (SPECS / "scenarios" / "free_lap.yaml").read_bytes().replace(b"duration: 10", b"duration: 0.3")
TRACK = (SPECS / "tracks" / "northfield.yaml").read_bytes()


#: Everything that a declaration can say, in few cycles.
CROWDED = (
    DECLARATION.replace(b"d: 0, v: 30}", b"d: -5, v: 20}").replace(b"  moves:", b"  #")
    + b"""
widenings: [{side: right, begin: 500, end: 800, by: 8, taper: 20}]
obstacles: [{id: cone, s: 640, d: 3, length: 1, width: 1}]
limits: {speed: 25, zones: [{s: [600, 700], d: [-9, -4], speed: 15}]}
mistakes: [{begin: 0, end: 0.1, moves: [{begin: 0, end: 2, to: 1}]}, {begin: 0.2, end: 0.3, acceleration: [[0, -3]]}]
pose_error: [[0, 0], [0.3, 4]]
others: [{id: ghost, oncoming: true, start: {s: 700, d: 2, v: 20}, silent: [[0, 0.2]]}]
params: {a_other: 2}
notes: [a note]
"""
)
CROWDED = b"".join(line for line in CROWDED.splitlines(keepends=True) if b"- {begin: " not in line)
FAULTS = (SPECS / "scenarios" / "faults.yaml").read_bytes()
STARTS = [FAULTS[: FAULTS.index(b"  - id:")], *(b"  - id:" + each for each in FAULTS.split(b"  - id:")[1:])]


def test_the_crowded_declaration_is_sound(tmp_path: Path) -> None:
    (tmp_path / "scenarios").mkdir()
    (tmp_path / "tracks").mkdir()
    shutil.copytree(SPECS / "vehicles", tmp_path / "vehicles")
    (tmp_path / "tracks" / "northfield.yaml").write_bytes(TRACK)
    (tmp_path / "scenarios" / "x.yaml").write_bytes(CROWDED)
    recording = generate(tmp_path / "scenarios" / "x.yaml")
    assert False in recording.ground_truth["static"]
    assert recording.obstacles
    assert recording.cycles[0].objects


@given(which=st.sampled_from(STARTS[1:]), data=st.data())
@settings(
    max_examples=amount(17, 150), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_changed_campaigns(tmp_path: Path, which: bytes, data: st.DataObject) -> None:
    text = STARTS[0] + data.draw(mutants([which]))
    (tmp_path / "f.yaml").write_bytes(text)
    found = outcome(faults.load, tmp_path / "f.yaml", "f.yaml")
    assert not isinstance(found, TrackmarshalError) or found.code in CODES


@given(scene=mutants([DECLARATION, CROWDED]), track=mutants([TRACK]), which=st.booleans())
@settings(
    max_examples=amount(10, 60), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_changed_declarations(tmp_path: Path, scene: bytes, track: bytes, which: bool) -> None:
    (tmp_path / "scenarios").mkdir(exist_ok=True)
    (tmp_path / "tracks").mkdir(exist_ok=True)
    shutil.copytree(SPECS / "vehicles", tmp_path / "vehicles", dirs_exist_ok=True)
    (tmp_path / "scenarios" / "x.yaml").write_bytes(scene if which else DECLARATION)
    (tmp_path / "tracks" / "northfield.yaml").write_bytes(TRACK if which else track)
    check(generate, tmp_path / "scenarios" / "x.yaml")


@given(st.binary(max_size=200))
@settings(max_examples=amount(17, 100), deadline=None)
def test_any_bytes(data: bytes) -> None:
    for read in (saa.read, recording_io.decode, document.read):
        found = outcome(read, data, "x")
        assert not isinstance(found, TrackmarshalError) or found.code in CODES
