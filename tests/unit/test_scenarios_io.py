"""trackmarshal's own format for recordings: what is written is read again, and everything else is refused."""

from __future__ import annotations

import errno
import gzip
import json
import math
import tracemalloc
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from trackmarshal import scenarios
from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios import content, recording_io
from trackmarshal.scenarios.recording import Cycle, Recording

SCHEMA = Path(recording_io.__file__).with_name("recording.schema.json")


def plan(v: float = 10.0) -> dict[str, list[float]]:
    return {
        "t": [0.0, 0.1], "s": [0.0, 1.0], "x": [0.0, 1.0], "y": [0.0, 0.0],
        "heading": [0.0, 0.0], "kappa": [0.0, 0.0], "v": [v, v], "a": [0.0, 0.0],
    }  # fmt: skip


def sample() -> Recording:
    """A recording in which every field is used."""
    ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0, "age": 0.02}
    other = {"id": "Ölspur 1", "x": 30.0, "y": 0.1 + 0.2, "v": -8.0, "braking": True}
    return Recording(
        name="sample",
        source="sample.tmrec.jsonl",
        cycles=(
            Cycle(0.0, ego, [other], {"driving": plan(), "emergency": plan(5.0)}),
            Cycle(
                0.1,
                {**ego, "v": math.pi},
                [],
                {"driving": {**plan(), "mu": [1.0, 0.9]}},
                obstacles=[{"id": "tyre", "x": 7.0}],
            ),
        ),
        track={"left": [[0.0, 5.0], [9.0, 5.0]], "right": [[0.0, -5.0], [9.0, -5.0]], "closed": True},
        params={"R_min": 11.0},
        tables={"ax_max": [[0.0, 6.0], [72.0, 2.5]]},
        ground_truth={"dynamic": (True, None), "static": (False, True)},
        obstacles=[{"id": "cone", "x": 5.0, "y": 4.0, "heading": 0.0, "length": 0.4, "width": 0.4}],
        use=("vehicle.devbot",),
        notes=("by hand",),
        given={"ego.age": 0.02},
        because={"R_min": "another axle", "ego.age": "measured once"},
    )


def lines(recording: Recording | None = None) -> list[dict[str, Any]]:
    return [json.loads(line) for line in recording_io.encode(recording or sample())]


def decode(values: list[dict[str, Any]]) -> Recording:
    return recording_io.decode("\n".join(map(json.dumps, values)).encode(), "x.tmrec.jsonl")


@pytest.mark.parametrize("name", ["copy.tmrec.jsonl", "copy.tmrec.jsonl.gz", "copy.jsonl"])
def test_what_is_written_is_read(tmp_path: Path, name: str) -> None:
    recording_io.write(sample(), tmp_path / name)
    copy = scenarios.load(tmp_path / name)
    assert copy == sample()
    assert repr(copy.cycles) == repr(sample().cycles)
    assert copy.source == str(tmp_path / name)


def test_packed_files_are_the_same_on_every_run(tmp_path: Path) -> None:
    for name in ("a.gz", "b.gz"):
        recording_io.write(sample(), tmp_path / name)
    assert (tmp_path / "a.gz").read_bytes() == (tmp_path / "b.gz").read_bytes()


def test_numbers_that_are_not_finite_are_texts() -> None:
    recording = sample()
    recording.cycles[0].ego["v"] = math.nan
    recording.cycles[0].candidates["driving"]["kappa"][:] = [math.inf, -math.inf]
    (_, line, _) = recording_io.encode(recording)
    assert '"v":"nan"' in line
    assert '"kappa":["inf","-inf"]' in line
    again = recording_io.decode("\n".join(recording_io.encode(recording)).encode(), "x").cycles[0]
    assert math.isnan(again.ego["v"])
    assert again.candidates["driving"]["kappa"] == [math.inf, -math.inf]


def test_null_is_a_missing_number() -> None:
    values = lines()
    values[1]["ego"]["v"] = None
    assert math.isnan(decode(values).cycles[0].ego["v"])


def test_arc_length_is_computed_where_it_is_missing() -> None:
    values = lines()
    del values[1]["candidates"]["driving"]["s"]
    assert decode(values) == sample()


def test_mark_line_ends_and_blank_lines_of_other_systems() -> None:
    text = "\ufeff" + "\r\n\r\n".join(recording_io.encode(sample()))
    assert recording_io.decode(text.encode(), "x") == sample()


def test_the_schema_knows_every_line() -> None:
    validator = Draft202012Validator(json.loads(SCHEMA.read_text()))
    Draft202012Validator.check_schema(validator.schema)
    for line in lines():
        validator.validate(line)


def changed(path: str, value: Any) -> list[dict[str, Any]]:
    """The lines of the sample with one field set (`None` as text: deleted)."""
    values = lines()
    place: Any = values
    *way, last = [int(part) if part.isdigit() else part for part in path.split("/")]
    for part in way:
        place = place[part]
    if value == "gone":
        del place[last]
    else:
        place[last] = value
    return values


#: path to the field, value, a part of the message; refused by the schema too
BAD_FIELDS = [
    ("0/track", "gone", "`track` is missing"),
    ("0/name", 3, "name: 3 stands"),
    ("0/colour", "red", "'colour' is not known"),
    ("0/track/left", [[0, 0]], "track.left"),
    ("0/track/left/0", [0, 0, 0], "3 numbers"),
    ("0/track/left/0", [0, None], "finite"),
    ("0/track/closed", 1, "closed"),
    ("0/params/R_min", "11", "params.R_min"),
    ("0/params", [], "params"),
    ("0/tables/ax_max", [], "ax_max"),
    ("0/obstacles", [{"x": 1}], "obstacles[0].id"),
    ("0/use", "vehicle", "use"),
    ("0/given", [], "given"),
    ("0/given", {"age": 1}, "no field of"),
    ("0/given", {"driving.a": 1}, "no field of"),
    ("0/given/ego.age", "old", "given.ego.age"),
    ("0/because", [], "because"),
    ("0/because/R_min", 1, "because.R_min"),
    ("0/because/R_min", "", "the reason is empty"),
    ("1/t", "gone", "`t` is missing"),
    ("1/t", None, "t: has to be finite"),
    ("1/t", True, "truth value"),
    ("1/ego", 7, "ego"),
    ("1/ego/v", "fast", "ego.v"),
    ("1/ego/v", [1], "a list of 1"),
    ("1/objects", {}, "objects"),
    ("1/objects/0/id", "gone", "objects[0].id"),
    ("1/objects/0/id", 5, "objects[0].id"),
    ("1/objects/0/x", "near", "objects[0].x"),
    ("1/candidates", {}, "there is none"),
    ("1/candidates/dreaming", {}, "'dreaming' is not known"),
    ("1/candidates/driving/v", "gone", "`v` is missing"),
    ("1/candidates/driving/v", 5, "a list is expected"),
    ("1/candidates/driving/v", [1.0, "x"], "candidates.driving.v[1]"),
    ("1/candidates/driving", {name: [] for name in plan()}, "one sample at least"),
    ("1/ground_truth/static", 1, "true, false or null"),
    ("1/ground_truth/moral", True, "'moral' is not known"),
    ("1/extra", 0, "'extra' is not known"),
]
#: the same for what a schema cannot say
BAD_RELATIONS: list[tuple[str, Any, str]] = [
    ("0/tables/ax_max", [[4, 1], [0, 1]], "strictly increasing"),
    ("0/tables/ax_max", [[0, 1], [0, 2]], "strictly increasing"),
    ("0/because/R_min", " ", "the reason is empty"),
    ("1/objects", [{"id": "a"}, {"id": "a"}], "twice"),
    ("1/candidates/driving/v", [1.0], "equally long"),
    ("0/because/ego.age", "gone", "`ego.age` is missing"),
    ("0/because", {"ego.age": "measured once", "mu": "no override"}, "'mu' is not known"),
    ("0/given", {"ego.x": 1}, "part of every cycle"),
]


@pytest.mark.parametrize(("path", "value", "part"), BAD_FIELDS + BAD_RELATIONS)
def test_wrong_fields_are_refused_with_their_path(path: str, value: Any, part: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        decode(changed(path, value))
    assert caught.value.code == "D141"
    assert caught.value.line == int(path[0]) + 1
    assert caught.value.file == "x.tmrec.jsonl"
    assert part in caught.value.message


@pytest.mark.parametrize(("path", "value", "part"), BAD_FIELDS)
def test_the_schema_refuses_them_too(path: str, value: Any, part: str) -> None:
    validator = Draft202012Validator(json.loads(SCHEMA.read_text()))
    assert not validator.is_valid(changed(path, value)[int(path[0])])


HEAD, FIRST, SECOND = recording_io.encode(sample())


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        ("", "D126", 1),
        ("\n \n", "D126", 1),
        (HEAD, "D130", 1),
        (FIRST, "D121", 1),
        ("[1]", "D140", 1),
        ("{", "D140", 1),
        (HEAD.replace('"version":1', '"version":2') + "\n" + FIRST, "D143", 1),
        (HEAD.replace('"version":1', '"version":true') + "\n" + FIRST, "D143", 1),
        (f"{HEAD}\n{FIRST}\n{FIRST}", "D130", 3),
        (f"{HEAD}\n{SECOND}\n{FIRST}", "D130", 3),
        (f"{HEAD}\n{FIRST[:-5]}", "D140", 2),
        (f"{HEAD}\n{FIRST}\n{HEAD}", "D141", 3),
        (HEAD + "\n" + FIRST.replace('"t":0.0', '"t":NaN', 1), "D140", 2),
        (HEAD + "\n" + FIRST.replace('"t":0.0', '"t":1e999', 1), "D141", 2),
        (HEAD + "\n" + FIRST.replace('"t":0.0', '"t":0.0,"t":0.1', 1), "D140", 2),
        (HEAD.replace("sample", "\\ud800") + "\n" + FIRST, "D140", 1),
        (
            HEAD
            + "\n"
            + FIRST.replace(',"ground_truth":{"dynamic":true,"static":false}', "")
            + "\n"
            + SECOND,
            "D141",
            3,
        ),
    ],
)
def test_wrong_lines_are_refused_with_their_number(text: str, code: str, line: int) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        recording_io.decode(text.encode(), "x")
    assert (caught.value.code, caught.value.line) == (code, line), str(caught.value)
    assert caught.value.help


def test_who_gives_a_cycle_twice_is_told_to_take_it_out() -> None:
    """Sorting the cycles, which was all that it said, leaves both."""
    with pytest.raises(TrackmarshalError) as caught:
        recording_io.decode(f"{HEAD}\n{FIRST}\n{FIRST}".encode(), "x")
    assert "take out those given twice" in str(caught.value.help)


@pytest.mark.parametrize("other", ["1e999", "-1e999", "true"])
@pytest.mark.parametrize("place", [0, 1])
def test_one_number_of_a_column_that_is_none(other: str, place: int) -> None:
    """Beside an infinite one of the other sign too, with which it adds up to no infinite one."""
    for beside in ("1.0", "1e999"):
        column = ",".join((other, beside) if place == 0 else (beside, other))
        text = FIRST.replace('"a":[0.0,0.0]', f'"a":[{column}]', 1)
        assert text != FIRST
        with pytest.raises(TrackmarshalError) as caught:
            recording_io.decode(f"{HEAD}\n{text}".encode(), "x")
        assert (caught.value.code, caught.value.line) == ("D141", 2)


def test_numbers_whose_sum_is_none_are_read() -> None:
    text = FIRST.replace('"a":[0.0,0.0]', '"a":[1.7e308,1.7e308]', 1)
    found = recording_io.decode(f"{HEAD}\n{text}".encode(), "x")
    assert found.cycles[0].candidates["driving"]["a"] == [1.7e308, 1.7e308]


@pytest.mark.parametrize("before", ["", HEAD + "\n"])
def test_a_byte_order_mark_within_is_named(before: str) -> None:
    """As where files were joined; the one at the start is taken off."""
    assert recording_io.decode(f"\ufeff{HEAD}\n{FIRST}".encode(), "x").name == "sample"
    with pytest.raises(TrackmarshalError, match="byte order mark") as caught:
        recording_io.decode(f"\ufeff{before}\ufeff{FIRST}".encode(), "x")
    assert caught.value.code == "D140"


def test_what_is_not_utf8_is_refused_with_its_line() -> None:
    with pytest.raises(TrackmarshalError) as caught:
        recording_io.decode(HEAD.encode() + b"\n\xff", "x")
    assert (caught.value.code, caught.value.line) == ("D126", 2)


def test_what_cannot_be_read_again_is_not_written(tmp_path: Path) -> None:
    recording = sample()
    recording.cycles[0].candidates["driving"]["v"].append(1.0)
    with pytest.raises(TrackmarshalError) as caught:
        recording_io.write(recording, tmp_path / "x.tmrec.jsonl")
    assert caught.value.code == "D141"
    assert not (tmp_path / "x.tmrec.jsonl").exists()


def test_a_disk_that_is_full_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut off behind a line, a recording is a shorter one, and nobody sees that it is."""
    path = tmp_path / "x.tmrec.jsonl"
    recording_io.write(sample(), path)
    before = path.read_bytes()
    whole = Path.write_bytes

    def full(self: Path, data: bytes) -> int:
        whole(self, bytes(data[: data.rindex(b"\n", 0, -1) + 1]))
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "write_bytes", full)
        with pytest.raises(TrackmarshalError, match="No space left on device") as caught:
            recording_io.write(replace(sample(), name="another"), path)
    assert (caught.value.code, caught.value.file) == ("D120", str(path))
    assert [(each.name, each.read_bytes()) for each in tmp_path.iterdir()] == [(path.name, before)]


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        recording_io.write(sample(), tmp_path / "nowhere" / "x.tmrec.jsonl")
    assert caught.value.code == "D120"


@pytest.mark.parametrize(
    ("name", "data", "code"),
    [
        ("x.jsonl.gz", gzip.compress("\n".join((HEAD, FIRST)).encode())[:-12], "D142"),
        ("x.jsonl.gz", gzip.compress(HEAD.encode())[:-5] + b"12345", "D142"),
        ("x.jsonl.gz", gzip.compress(b"0" * 20_000_000), "D124"),
        ("x.jsonl.gz", gzip.compress(b"", mtime=0), "D126"),
        ("x.jsonl", b"", "D126"),
        ("x.saa", b"", "D122"),
        ("x.saa", HEAD.encode(), "D122"),
        ("x.sas", b"\x80\x04", "D121"),
        ("x.xml", b"<commonRoad/>", "D121"),
        ("x", b"", "D121"),
    ],
    # Packed data begins with the time: as names of tests, two processes that collect them would have two each.
    ids=["cut off", "damaged", "no end", "packed nothing", "empty", "empty saa", "no zip", "pickle", "xml", "no suffix"],
)  # fmt: skip
def test_other_files_are_refused(tmp_path: Path, name: str, data: bytes, code: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(TrackmarshalError) as caught:
        scenarios.load(tmp_path / name)
    assert caught.value.code == code, str(caught.value)
    assert caught.value.file == str(tmp_path / name)


@pytest.mark.parametrize("name", ["x.tmrec.jsonl", "x.tmrec.jsonl.gz", "x.saa", "x.yaml"])
def test_a_pointer_is_told_from_a_recording_that_is_damaged(tmp_path: Path, name: str) -> None:
    """As a checkout without Git LFS leaves it."""
    (tmp_path / name).write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 12345\n")
    with pytest.raises(TrackmarshalError) as caught:
        scenarios.load(tmp_path / name)
    assert caught.value.code == "D121"
    assert "git lfs pull" in (caught.value.help or "")


def test_content_counts_more_than_the_name(tmp_path: Path) -> None:
    recording_io.write(sample(), tmp_path / "renamed.txt")
    assert scenarios.load(tmp_path / "renamed.txt") == sample()


def test_missing_files_and_folders(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.saa", "nul\0.saa"):
        with pytest.raises(TrackmarshalError) as caught:
            scenarios.load(path)
        assert caught.value.code == "D120"


def test_large_files_are_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(content, "MAX_BYTES", 100)
    (tmp_path / "x.jsonl").write_bytes(b" " * 101)
    with pytest.raises(TrackmarshalError) as caught:
        scenarios.load(tmp_path / "x.jsonl")
    assert caught.value.code == "D124"


def test_what_is_packed_is_as_large_as_what_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """However little it packs: of a packed file of 3 MB, 300 MB would be read."""
    monkeypatch.setattr(content, "MAX_BYTES", 1000)
    data = bytes(range(256)) * 4
    assert content.gunzip(gzip.compress(data[:1000]), "x.gz") == data[:1000]
    with pytest.raises(TrackmarshalError, match="the limit is 1000") as caught:
        content.gunzip(gzip.compress(data[:1001]), "x.gz")
    assert caught.value.code == "D124"


def test_what_packs_too_well_is_told_the_limit_that_it_is_over(tmp_path: Path) -> None:
    """Whoever packs a car that stands, with gzip, has no 200 MB to split: it is read unpacked."""
    packed = tmp_path / "x.jsonl.gz"
    packed.write_bytes(gzip.compress(b" " * 1_000_001))
    with pytest.raises(TrackmarshalError) as caught:
        scenarios.load(packed)
    assert caught.value.message == f"{packed.stat().st_size} bytes unpack to more, the limit is 1000000"
    assert "unpacked" in (caught.value.help or "")


def test_a_car_that_stands_is_read_again_however_well_that_packs(tmp_path: Path) -> None:
    """Of a real log with a stop: `import log` wrote a recording that no verb read."""
    still = {**dict.fromkeys(plan(), [0.0] * 150), "t": [0.1 * k for k in range(150)]}
    cycle = Cycle(
        0.0, {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 0.0}, [], {"driving": still, "emergency": still}
    )
    parked = replace(
        sample(),
        cycles=tuple(replace(cycle, t=0.1 * k) for k in range(120)),
        ground_truth={},
        given={},
        because={},
    )
    for name in ("parked.tmrec.jsonl", "parked.tmrec.jsonl.gz"):
        recording_io.write(parked, tmp_path / name)
    whole = (tmp_path / "parked.tmrec.jsonl").read_bytes()
    assert content.suspicious(len(gzip.compress(whole)), len(whole))
    packed = tmp_path / "parked.tmrec.jsonl.gz"
    assert scenarios.load(packed) == replace(parked, source=str(packed))
    stream = zlib.decompressobj(31)
    assert stream.decompress(packed.read_bytes()) == whole
    assert (stream.eof, stream.unused_data) == (True, b"")  # behind it, some readers take nothing


def test_what_is_too_large_to_be_read_is_not_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(content, "MAX_BYTES", 100)
    with pytest.raises(TrackmarshalError, match="the limit is 100") as caught:
        recording_io.write(sample(), tmp_path / "x.tmrec.jsonl.gz")
    assert caught.value.code == "D124"
    assert not list(tmp_path.iterdir())


def test_millions_of_lines_that_are_wrong_are_counted() -> None:
    """An error of each was kept: a file of 10 MB, or of 100 kB packed, took 2 GB."""
    text = next(recording_io.encode(sample())) + "\n" + "{}\n" * 5_000
    tracemalloc.start()
    with pytest.raises(TrackmarshalError) as caught:
        recording_io.decode(text.encode(), "sample.tmrec.jsonl")
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert caught.value.line == 2
    assert caught.value.message.endswith("(and 4999 more, lines 3, 4, 5, 6, 7, 8, 9, 10, ...)")
    assert most < 300 * 5_000


def test_what_a_recording_uses_is_named_from_where_it_is_written(tmp_path: Path) -> None:
    (tmp_path / "specs" / "scenarios").mkdir(parents=True)
    (tmp_path / "specs" / "event.spec").write_text("module event\n", encoding="utf-8")
    absolute = str(tmp_path / "specs" / "event.spec")
    use = ("../event.spec", "specs/event.spec", absolute, "../\0.spec")
    recording = replace(sample(), use=use)
    declared = tmp_path / "specs" / "scenarios" / "a.yaml"
    assert recording_io.moved(recording, declared, declared.with_name("a.jsonl")) == recording
    there = recording_io.moved(recording, declared, tmp_path / "out" / "a.jsonl")
    assert there.use == ("../specs/event.spec", *use[1:])
    assert replace(there, use=use) == recording
