"""Logs are read as their mapping says, or refused with file, line, code and help."""

from __future__ import annotations

import gzip
import hashlib
import json
import random
import tracemalloc
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support import field_logs
from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios import content
from trackmarshal.scenarios.field import build, log, mapping

CLEAN = field_logs.straight(30.0, 10.0)


def refused(folder: Path, data: bytes | None = None, declared: str = field_logs.MAP) -> TrackmarshalError:
    """What a log, or its mapping, is refused with."""
    where, file = field_logs.write(folder, CLEAN, declared)
    if data is not None:
        file.write_bytes(data)
    with pytest.raises(TrackmarshalError) as found:
        build.build(mapping.read(where), file)
    assert found.value.file
    assert found.value.help
    return found.value


def test_a_log_becomes_what_was_driven(tmp_path: Path) -> None:
    where, file = field_logs.write(tmp_path, CLEAN)
    made = build.build(mapping.read(where), file)
    first = made.recording.cycles[0]
    assert first.ego == pytest.approx({"x": 0.0, "y": 0.0, "heading": 1.570796, "v": 0.0}, abs=1e-6)
    at_20 = next(cycle for cycle in made.recording.cycles if cycle.t == pytest.approx(20.0))
    driving = at_20.candidates["driving"]
    assert driving["t"] == pytest.approx(np.arange(21) * 0.1)
    assert np.diff(driving["y"]) == pytest.approx(np.full(20, 1.5), abs=0.02)
    assert driving["v"] == pytest.approx(np.full(21, 15.0), abs=0.01)


@pytest.mark.parametrize(
    ("change", "code", "said", "line"),
    [
        (lambda t: "", "D126", "empty", 1),
        (lambda t: "\n \n", "D126", "empty", 1),
        (lambda t: "time,x,y,heading,v,yaw\n", "D126", "no row", 1),
        (lambda t: t.replace("heading", "headin", 1), "D170", "`heading`", 1),
        (lambda t: t.replace("time,x", "x,x", 1), "D170", "no column `time`", 1),
        (lambda t: t.replace("yaw", "v", 1), "D170", "more than one column `v`", 1),
        (lambda t: line(t, 7, "0.5,0,nan,1.57,0,0"), "D171", "'nan' is no finite number", 7),
        (lambda t: line(t, 7, "0.5,0,,1.57,0,0"), "D171", "'' is no finite number", 7),
        (lambda t: line(t, 7, "0.5,0,1e999,1.57,0,0"), "D171", "no finite number", 7),
        (lambda t: line(t, 7, "0.5,0,1_0,1.57,0,0"), "D171", "no finite number", 7),
        (lambda t: line(t, 7, "0.5,0,0"), "D171", "3 cells", 7),
        (lambda t: line(t, 7, "0,5,0,0,1,57,0,0"), "D171", "8 cells", 7),
        (lambda t: line(t, 7, '0.5,0,"0,1.57,0,0'), "D171", "", None),
        (lambda t: line(t, 7, "0.5,0,\0,1.57,0,0"), "D171", "NUL", 7),
        (lambda t: line(t, 7, "0.4,0,0,1.57,0,0"), "D172", "does not come after", 7),
        (lambda t: line(t, 7, "0.0,0,0,1.57,0,0"), "D172", "does not come after", 7),
        (lambda t: "\n".join(t.split("\n")[:100] + t.split("\n")[120:]), "D172", "without a row", 101),
        (lambda t: "\n".join(t.split("\n")[:15]), "D176", "14 rows", None),
        (lambda t: "\n".join(t.split("\n")[:40]), "D177", "less than ten seconds", None),
        (lambda t: "PK\x03\x04" + t, "D174", "neither", None),
        (lambda t: "PAR1" + t, "D174", "Parquet is neither", None),
    ],
)
def test_a_bad_log_is_refused(tmp_path: Path, change: Any, code: str, said: str, line: int | None) -> None:
    error = refused(tmp_path, change(field_logs.text(CLEAN)).encode())
    assert (error.code, error.line) == (code, line) if line is not None else error.code == code
    assert said in error.message


@pytest.mark.parametrize(
    ("change", "help"),
    [
        (lambda t: t.replace(",", ";"), "delimiter: ';'"),
        (lambda t: t.replace(",", "\t"), "delimiter: 'tab'"),
        (lambda t: line(t, 7, "0,5,0,0,1,57,0,0"), "They have a point"),
        (lambda t: line(t, 7, '"0,5",0,0,1.57,0,0'), "numbers have a point: `0.5`"),
        (lambda t: line(t, 7, '0.5,"1,234.5",0,1.57,0,0'), "no sign between thousands: `1234.5`"),
        (lambda t: line(t, 7, "0.5,1'234,0,1.57,0,0"), "no sign between thousands: `1234`"),
        (lambda t: line(t, 7, "0.5,1\u202f234.5,0,1.57,0,0"), "no sign between thousands: `1234.5`"),
        (lambda t: line(t, 7, '0.5,"1,234",0,1.57,0,0'), "`1234`; and a point before decimals: `1.234`"),
    ],
)
def test_what_spreadsheets_write_where_numbers_have_commas(tmp_path: Path, change: Any, help: str) -> None:
    assert help in str(refused(tmp_path, change(field_logs.text(CLEAN)).encode()).help)


def line(text: str, number: int, new: str) -> str:
    lines = text.split("\n")
    lines[number - 1] = new
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("begin", "kind"),
    [
        (b"\x89HDF\r\n\x1a\n", "HDF5"),
        (b"\x28\xb5\x2f\xfd", "zstd"),
        (b"\xfd7zXZ\x00", "xz"),
        (b"BZh9", "bzip2"),
        (b"\x93NUMPY\x01", "numpy"),
        (b"ULog\x01", "ULog"),
        (b"MDF     4.10", "MDF"),
        (b"ARROW1\0\0", "Arrow"),
    ],
)
def test_other_files_are_called_what_they_are(tmp_path: Path, begin: bytes, kind: str) -> None:
    """They were told to be saved as UTF-8, or asked whether they had been cut off."""
    error = refused(tmp_path, begin + b"\0\xff" * 200)
    assert error.code == "D174"
    assert kind in error.message
    assert "CSV" in str(error.help)


def test_a_row_without_a_number_is_in_the_way_whatever_part_is_asked_for(tmp_path: Path) -> None:
    """`from` and `to` were named as the way out, and are none: noise is that of the whole file."""
    declared = field_logs.MAP.replace("time: {rate: 10}", "time: {rate: 10, from: 5}")
    text = line(field_logs.text(CLEAN), 7, "0.5,0,,1.57,0,0")
    error = refused(tmp_path, text.encode(), declared)
    assert error.code == "D171"
    assert "take the row out of the file" in str(error.help)
    where, file = field_logs.write(tmp_path, CLEAN, declared)
    file.write_text("\n".join(row for row in text.split("\n") if ",," not in row), encoding="utf-8")
    assert build.build(mapping.read(where), file).recording.cycles


def test_times_that_have_lost_their_fractions(tmp_path: Path) -> None:
    """As `sec` of a ROS stamp, or 1.7e9 with six digits: no row is one too many, and sorting does not help."""
    error = refused(tmp_path, field_logs.text({**CLEAN, "time": np.floor(CLEAN["time"])}).encode())
    assert error.code == "D172"
    assert "fractions" in str(error.help)


def test_bytes_that_are_no_text(tmp_path: Path) -> None:
    assert refused(tmp_path, b"time,x\n\xff\xfe").code == "D126"
    assert refused(tmp_path, gzip.compress(b"time,x\n" * 100)[:-20]).code == "D142"
    assert refused(tmp_path, b"\x89MCAP0\r\n" + b"\x00" * 40).code == "D170"  # the mapping names no topics


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("v: {column: v, unit: m/s}", "v: {column: v, unit: km/h}", "speed of the positions"),
        (
            "heading: {column: heading, unit: rad",
            "heading: {column: heading, unit: deg",
            "off the direction of travel",
        ),
        ("zero: +x", "zero: +y", "Turned by 270 deg"),
        ("turns: left", "turns: right", "off the direction of travel"),
        ("unit: m}\n  y", "unit: km}\n  y", "the speed column is"),
    ],
)
def test_a_unit_or_a_convention_that_the_log_contradicts(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    declared = field_logs.MAP.replace(old, new)
    if "km}" in new:
        declared = declared.replace("y: {column: y, unit: m}", "y: {column: y, unit: km}")
    error = refused(tmp_path, declared=declared)
    assert error.code == "D173"
    assert said in f"{error.message} {error.help}"


@pytest.mark.parametrize(
    ("old", "new", "code", "number"),
    [
        ("version: 1", "version: 2", "D143", 2),
        ("unit: m/s}", "unit: m}", "D151", 9),
        ("unit: m/s}", "unit: furlong}", "D151", 9),
        ("  v: {column: v, unit: m/s}\n", "", "D151", 5),
        ("zero: +x", "zero: north", "D151", 8),
        ("rate: 10", "rate: 0", "D151", 11),
        ("horizon: 2", "horizon: .nan", "D151", 17),
        ("share: 0.9", "share: 1.5", "D151", 18),
        ("vehicle:", "vehikel:", "D151", None),
        ("column: yaw, unit: rad/s}", "unit: rad/s, column: yaw #2\n    }", "D151", 10),
        ("specs/vehicles/av21.spec", "specs/vehicles/none.spec", "D178", None),
        ("left.csv", "nowhere.csv", "D178", None),
        ("time: {rate: 10}", "time: {rate: 10, from: 29}", "D176", None),
        ("x: 1, y: 2}\n  right", "x: 1, y: 7}\n  right", "D170", 1),
        # What is there twice: a road without a width, a border that is a diagonal, a car that turns as it drives.
        ("left.csv", "right.csv", "D151", 14),
        ("x: 1, y: 2}\n  right", "x: 2, y: 2}\n  right", "D151", 13),
        ("{column: yaw,", "{column: x,", "D151", 10),
    ],
)
def test_a_bad_mapping_is_refused(tmp_path: Path, old: str, new: str, code: str, number: int | None) -> None:
    error = refused(tmp_path, declared=field_logs.MAP.replace(old, new, 1))
    assert error.code == code
    assert number is None or error.line == number


def words(*spans: tuple[float, float, str]) -> str:
    """The mapping with what persons say of firings of one rule: from, to, cause."""
    said = [
        f"  - {{rule: speed_limit, from: {begin}, to: {end}, cause: {cause}, because: seen}}\n"
        for begin, end, cause in spans
    ]
    return f"{field_logs.MAP}findings:\n{''.join(said)}"


@pytest.mark.parametrize("second", [(9, 20), (0, 10), (2, 3)])
def test_persons_who_contradict_each_other(tmp_path: Path, second: tuple[float, float]) -> None:
    """The first of both counted: what somebody had found to be real was put down to the rule, and no word said so."""
    error = refused(tmp_path, declared=words((0, 10, "rule"), (*second, "real")))
    assert (error.code, error.line) == ("D151", 21)
    assert "`rule` and to `real`" in error.message


def test_words_on_firings_one_after_the_other(tmp_path: Path) -> None:
    declared = words((0, 10, "rule"), (10, 20, "real"), (12, 20, "real"))
    where, _ = field_logs.write(tmp_path, CLEAN, declared)
    assert [one.cause for one in mapping.read(where).findings] == ["rule", "real", "real"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("horizon: 2, ", ""),
        ("x: 1, y: 2}", "x: {column: x}, y: 2}"),
        ("plan: {horizon: 2, step: 0.1}", "plan: 2"),
    ],
)
def test_a_mapping_leads_to_the_page_that_is_about_mappings(tmp_path: Path, old: str, new: str) -> None:
    assert refused(tmp_path, declared=field_logs.MAP.replace(old, new, 1)).help == "see docs/field.md"


def test_a_hash_holds_the_mapping_to_its_log(tmp_path: Path) -> None:
    digest = "0" * 64
    declared = field_logs.MAP + f"log: {{path: log.csv, sha256: {digest}}}\n"
    error = refused(tmp_path, declared=declared)
    assert error.code == "D175"
    where, file = field_logs.write(tmp_path, CLEAN, declared)
    file.unlink()
    with pytest.raises(TrackmarshalError) as found:
        build.build(mapping.read(where))
    assert found.value.code == "D178"
    assert "nothing is said about it" in found.value.message


def test_a_log_with_fewer_rows_than_cycles_are_asked_for(tmp_path: Path) -> None:
    """Nothing is made up between them, and nobody is told that it was."""
    columns = field_logs.noisy(field_logs.straight(30.0, 4.0), 1, 0.02, 0.005, 0.05, 0.005)
    where, file = field_logs.write(tmp_path, columns, field_logs.MAP + "noise: {jerk: 1}\n")
    made = build.build(mapping.read(where), file).recording
    assert made.cycles[1].t - made.cycles[0].t == pytest.approx(0.25)
    assert any(
        f"{len(made.cycles)} cycles at 4 Hz, which is all that the log has" in note for note in made.notes
    )


def test_a_checkout_with_other_ends_of_lines_has_the_same_files(tmp_path: Path) -> None:
    """As git has them on Windows: what a run was made from there is what it is made from here, and hashes of texts hold."""
    where, file = field_logs.write(tmp_path, CLEAN)
    borders = [tmp_path / "left.csv", tmp_path / "right.csv"]
    declared = (
        field_logs.MAP + f"log: {{path: log.csv, sha256: {hashlib.sha256(file.read_bytes()).hexdigest()}}}\n"
    )
    for border in borders:
        named = f"path: {border.name}, sha256: {hashlib.sha256(border.read_bytes()).hexdigest()}"
        declared = declared.replace(f"path: {border.name}", named)
    where.write_text(declared, encoding="utf-8")
    here = build.build(mapping.read(where)).sources
    for path in (where, file, *borders):
        path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    assert build.build(mapping.read(where)).sources == here
    borders[0].write_bytes(borders[0].read_bytes().replace(b"-10", b"-11"))
    with pytest.raises(TrackmarshalError) as found:
        build.build(mapping.read(where))
    assert found.value.code == "D175"


@pytest.mark.parametrize("rows", [1, 2, 10])
@pytest.mark.parametrize("at", [0, 3, 6])
def test_rows_are_not_lost_in_a_quotation_that_is_not_closed(tmp_path: Path, rows: int, at: int) -> None:
    """What a driver says at the wheel, in a column that nobody asks for, wherever it stands; a note of two lines is one."""
    cells = [line.split(",") for line in field_logs.text(CLEAN).splitlines()]
    for number, row in enumerate(cells):
        row.insert(at, "" if number else "said")
    where, file = field_logs.write(tmp_path, CLEAN)

    def written() -> None:
        file.write_text("".join(",".join(row) + "\n" for row in cells), encoding="utf-8")

    cells[50][at] = '"1, 2\nby 3, 4"'
    written()
    assert len(log.read(mapping.read(where), file).t) == len(CLEAN["time"])
    cells[100][at], cells[100 + rows][at] = '"box', 'now"'
    written()
    with pytest.raises(TrackmarshalError) as found:
        log.read(mapping.read(where), file)
    assert (found.value.code, found.value.line) == ("D171", 102)
    assert "quotation" in found.value.message


@pytest.mark.parametrize(("at", "note"), [(1, '"box\n12"'), (5, '"gusts, 3\nin all"'), (6, '"to go:\n1, 2"')])
def test_a_note_of_two_lines_may_end_with_a_number(tmp_path: Path, at: int, note: str) -> None:
    """Beside the first column or the last one, that one number was taken for a row."""
    cells = [line.split(",") for line in field_logs.text(CLEAN).splitlines()]
    for number, row in enumerate(cells):
        row.insert(at, "" if number else "said")
    cells[50][at] = note
    where, file = field_logs.write(tmp_path, CLEAN)
    file.write_text("".join(",".join(row) + "\n" for row in cells), encoding="utf-8")
    assert len(log.read(mapping.read(where), file).t) == len(CLEAN["time"])


def test_a_bend_that_takes_all_the_grip_is_no_end_of_the_log(tmp_path: Path) -> None:
    """Nothing brakes there at so small a share: it was said that the log ends, and what came behind was gone."""
    columns = field_logs.noisy(field_logs.ring(90.0, 10.0, 20.0, 10.0), 1, 0.02, 0.005, 0.05, 0.005)
    where, file = field_logs.write(tmp_path, columns, field_logs.MAP.replace("share: 0.9", "share: 0.05"))
    with pytest.raises(TrackmarshalError) as found:
        build.build(mapping.read(where), file)
    assert found.value.code == "D151"
    assert "still moves 60 s later" in found.value.message


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("packed", [False, True])
def test_line_ends_names_and_packing_make_no_difference(tmp_path: Path, end: str, packed: bool) -> None:
    head = ("# temps écoulé", "x", "y", "ψ (rad)", " v ", "Ω")
    decomposed = "e\u0301coule\u0301"  # the same to a reader: é in two code points
    data = b"\xef\xbb\xbf" + field_logs.text(CLEAN, head, end, ";").replace("écoulé", decomposed).encode()
    declared = field_logs.MAP.replace("column: time", "column: temps écoulé").replace(
        "column: heading", "column: ψ (rad)"
    )
    declared = declared.replace("column: yaw", "column: Ω") + 'delimiter: ";"\n'
    where, file = field_logs.write(tmp_path, CLEAN, declared)
    file.write_bytes(gzip.compress(data) if packed else data)
    found = log.read(mapping.read(where), file)
    assert found.v == pytest.approx(CLEAN["v"])


def test_a_speed_of_nothing_fits_no_unit(tmp_path: Path) -> None:
    where, file = field_logs.write(tmp_path, {**CLEAN, "v": 0.0 * CLEAN["v"]}, field_logs.MAP)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(TrackmarshalError) as caught:
            log.read(mapping.read(where), file)
    assert caught.value.message == "the speed column is 0 times the speed of the positions"
    assert caught.value.help == "are the units of time, place and speed right?"


def test_a_log_that_is_too_short_to_compare_is_not_said_to_stand(tmp_path: Path) -> None:
    """Of 30 rows of a car that drives, 18 pairs half a second apart are no contradiction; with one place for all of them they are."""
    short = {name: column[:30] for name, column in field_logs.ring().items()}
    where, file = field_logs.write(tmp_path, short, field_logs.MAP)
    assert len(log.read(mapping.read(where), file).t) == 30
    still = {**short, "x": 0.0 * short["x"], "y": 0.0 * short["y"]}
    where, file = field_logs.write(tmp_path, still, field_logs.MAP)
    with pytest.raises(TrackmarshalError, match="the positions do not move"):
        log.read(mapping.read(where), file)


def test_conventions_and_units(tmp_path: Path) -> None:
    """Heading in degrees from +y to the right, as a compass; km/h; milliseconds from anywhere; the point 1.5 m behind the middle."""
    ring = field_logs.ring()
    other = {
        "time": 1e9 + 1000.0 * ring["time"], "x": ring["x"] - 1.5 * np.cos(ring["heading"]), "y": ring["y"] - 1.5 * np.sin(ring["heading"]),
        "heading": 90.0 - np.degrees(ring["heading"]), "v": 3.6 * ring["v"], "yaw": -np.degrees(ring["yaw"]),
    }  # fmt: skip
    declared = field_logs.MAP.replace("time, unit: s", "time, unit: ms").replace("unit: m/s}", "unit: km/h}")
    declared = declared.replace(
        "unit: rad, zero: +x, turns: left", "unit: deg, zero: +y, turns: right"
    ).replace("rad/s", "deg/s")
    where, file = field_logs.write(tmp_path, other, declared + "pose: {forward: 1.5}\n")
    found = log.read(mapping.read(where), file)
    for name in ("x", "y", "v"):
        assert getattr(found, name) == pytest.approx(ring[name], abs=1e-6)
    assert np.cos(found.heading - ring["heading"]) == pytest.approx(1.0)
    assert found.yaw_rate == pytest.approx(ring["yaw"])
    assert found.t == pytest.approx(ring["time"], abs=1e-6)


def test_borders_are_on_the_sides_that_they_are_called_after(tmp_path: Path) -> None:
    """Exchanged, or all of it in a frame with y to the right of x: nothing fired, and zones of the track were somewhere else."""
    swapped = field_logs.MAP.replace("left.csv", "other.csv").replace("right.csv", "left.csv")
    error = refused(tmp_path, declared=swapped.replace("other.csv", "right.csv"))
    assert error.code == "D173"
    assert "NED" in str(error.help)
    ned = {
        **CLEAN, "x": CLEAN["y"], "y": CLEAN["x"], "heading": np.pi / 2 - CLEAN["heading"], "yaw": -CLEAN["yaw"]
    }  # fmt: skip
    where, file = field_logs.write(tmp_path, ned, field_logs.MAP.replace("x: 1, y: 2", "x: 2, y: 1"))
    with pytest.raises(TrackmarshalError) as found:
        build.build(mapping.read(where), file)
    assert found.value.code == "D173"
    assert "the left border is on the right" in found.value.message


def test_who_drives_the_wrong_way_is_for_a_rule_to_say(tmp_path: Path) -> None:
    """The left border is right of a car that drives against it."""
    where, file = field_logs.write(tmp_path, CLEAN)
    (tmp_path / "left.csv").write_text("10,400\n10,-50\n", encoding="utf-8")
    (tmp_path / "right.csv").write_text("-10,400\n-10,-50\n", encoding="utf-8")
    assert build.build(mapping.read(where), file).recording.cycles


def test_units_that_logs_have_and_specs_do_not(tmp_path: Path) -> None:
    """Stamps of ROS count nanoseconds since 1970; messages named mph, and took none."""
    other = {**CLEAN, "v": CLEAN["v"] / 0.44704}
    rows = field_logs.text(other).split("\n")
    for i, t in enumerate(CLEAN["time"], start=1):
        rows[i] = f"{1_700_000_000_000_000_000 + round(t * 1e9)},{rows[i].partition(',')[2]}"
    declared = field_logs.MAP.replace("time, unit: s", "time, unit: ns").replace("unit: m/s}", "unit: mph}")
    where, file = field_logs.write(tmp_path, other, declared)
    file.write_text("\n".join(rows), encoding="utf-8")
    found = log.read(mapping.read(where), file)
    assert found.t == pytest.approx(CLEAN["time"], abs=1e-6)
    assert found.v == pytest.approx(CLEAN["v"], abs=1e-5)


def of_topics(wheel: str = "/wheel") -> str:
    """A mapping for MCAP, of which `wheel` is the topic of the speed."""
    declared = field_logs.MAP
    for name, way in (
        ("time", "/odom.log_time"),
        ("x", "/odom.pose.0"),
        ("y", "/odom.pose.1"),
        ("heading", "/odom.pose.2"),
        ("v", f"{wheel}.v"),
        ("yaw", "/odom.yaw"),
    ):
        declared = declared.replace(f"column: {name},", f"column: {way},")
    return declared


def test_mcap(tmp_path: Path) -> None:
    """Two topics at other rates; what the slower one said last counts, as long as it is not older than `hold`."""
    writing = pytest.importorskip("mcap.writer", reason="reads MCAP with the package mcap")
    declared = of_topics()
    where, _ = field_logs.write(tmp_path, CLEAN, declared)

    def written(silent: float, encoding: str = "json", until: float = 1.0, again: int = 0) -> Path:
        path = tmp_path / "log.mcap"
        with path.open("wb") as file:
            writer = writing.Writer(file)
            writer.start()
            channels = {topic: writer.register_channel(topic, encoding, 0) for topic in ("/odom", "/wheel")}
            channels["/wheel again"] = writer.register_channel("/wheel", encoding, 0)
            for i, (t, x, y, h, v, yaw) in enumerate(zip(*CLEAN.values())):
                at = round(t * 1e9)
                if i % 2 == 0 and not silent < t < silent + until:
                    wheel = channels["/wheel" if not again or i % again < again // 2 else "/wheel again"]
                    writer.add_message(wheel, at, json.dumps({"v": v}).encode(), at)
                writer.add_message(
                    channels["/odom"], at, json.dumps({"pose": [x, y, h], "yaw": yaw}).encode(), at
                )
            writer.finish()
        return path

    found = log.read(mapping.read(where), written(100.0))
    assert len(found.t) == len(CLEAN["time"])
    assert found.v == pytest.approx(CLEAN["v"], abs=1.5 / 10 + 1e-9)
    assert found.left_out == ""
    late = log.read(mapping.read(where), written(-0.5))  # the wheel comes with the seventh of the other
    assert late.origin == pytest.approx(0.6)
    assert len(late.t) == len(CLEAN["time"]) - 6
    assert late.left_out == "its first 0.600 s, 6 messages of `/odom`, are left out: nothing of `/wheel` yet"
    over = log.read(mapping.read(where), written(20.0, until=100.0))  # the wheel's last message is of 20 s
    assert over.t[-1] == pytest.approx(20.1)
    assert (
        over.left_out
        == "its last 9.800 s, 98 messages of `/odom`, are left out: nothing of `/wheel` any more"
    )
    for silent, encoding, code, said in (
        (10.0, "json", "D171", "nothing of `/wheel`"),
        (100.0, "cdr", "D174", "`cdr`"),
    ):
        with pytest.raises(TrackmarshalError) as error:
            log.read(mapping.read(where), written(silent, encoding))
        assert error.value.code == code
        assert said in error.value.message
    # Who was started again has another channel, and goes on; two by turns are two.
    assert len(log.read(mapping.read(where), written(100.0, again=400)).t) == len(CLEAN["time"])
    with pytest.raises(TrackmarshalError, match=r"D174.*two sources write `/wheel` by turns"):
        log.read(mapping.read(where), written(100.0, again=4))
    for place in ("²", "9" * 5000):
        other = tmp_path / "other"
        other.mkdir(exist_ok=True)
        astray, _ = field_logs.write(other, CLEAN, declared.replace("/odom.pose.0,", f"/odom.pose.{place},"))
        with pytest.raises(TrackmarshalError, match=r"D170.*has no `pose"):
            log.read(mapping.read(astray), written(100.0))
    whole = written(100.0).read_bytes()
    for _ in range(60):
        draw = random.Random(_)
        data = bytearray(whole[: draw.randrange(8, len(whole))] if _ % 2 else whole)
        for _ in range(5):
            data[draw.randrange(8, len(data))] ^= 1 << draw.randrange(8)
        (tmp_path / "log.mcap").write_bytes(data)
        try:
            log.read(mapping.read(where), tmp_path / "log.mcap")
        except TrackmarshalError as refusal:
            assert refusal.code in ("D126", "D170", "D171", "D172", "D173", "D174", "D176")


def drive(writer: Any, rows: range, ballast: int = 0) -> None:
    """Write rows of the clean drive, and as many bytes of no interest."""
    odom, junk = (writer.register_channel(topic, "json", 0) for topic in ("/odom", "/junk"))
    for i in rows:
        t, x, y, h, v, yaw = (column[i] for column in CLEAN.values())
        at = round(t * 1e9)
        writer.add_message(odom, at, json.dumps({"pose": [x, y, h], "v": v, "yaw": yaw}).encode(), at)
    if ballast:
        writer.add_message(junk, 0, bytes(ballast), 0)


@pytest.mark.parametrize("packed", ["LZ4", "ZSTD"])
@pytest.mark.parametrize("lie", [False, True])
def test_mcap_that_unpacks_without_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, packed: str, lie: bool
) -> None:
    """32 kB unpacked to 1 GB. Whether a chunk says how much it holds, or says less, is all the same."""
    writing = pytest.importorskip("mcap.writer", reason="reads MCAP with the package mcap")
    monkeypatch.setattr(content, "MAX_BYTES", 5_000_000)
    where, path = field_logs.write(tmp_path, CLEAN, of_topics("/odom"))
    for ballast in (4_000_000, 20_000_000):
        with path.open("wb") as file:
            writer = writing.Writer(
                file, chunk_size=10**8, compression=writing.CompressionType[packed], enable_crcs=False
            )
            writer.start()
            drive(writer, range(len(CLEAN["time"])), ballast)
            writer.finish()
        if not lie and ballast < content.MAX_BYTES:
            assert len(log.read(mapping.read(where), path).t) == len(CLEAN["time"])
    if lie:  # in the chunk's head: opcode, length, two times, how much it holds
        data = bytearray(path.read_bytes())
        at = data.index(packed.lower().encode()) - 4 - 4 - 8
        assert 20_000_000 < int.from_bytes(data[at : at + 8], "little") < 20_200_000
        data[at : at + 8] = (1_000).to_bytes(8, "little")
        path.write_bytes(data)
    tracemalloc.start()
    with pytest.raises(TrackmarshalError) as error:
        log.read(mapping.read(where), path)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert error.value.code == ("D174" if lie else "D124")
    assert most < 10_000_000


def test_mcap_is_read_whole_whatever_its_index_names(tmp_path: Path) -> None:
    """Messages may stand outside of chunks; of these, and of a chunk that the index does not name, nothing was read, and no word said so."""
    writing = pytest.importorskip("mcap.writer", reason="reads MCAP with the package mcap")
    where, path = field_logs.write(tmp_path, CLEAN, of_topics("/odom"))
    with path.open("wb") as file:
        writer = writing.Writer(file, chunk_size=1 << 30)
        writer.start()
        drive(writer, range(250))
        writer._Writer__finalize_chunk()
        named = len(writer._Writer__chunk_indices)
        drive(writer, range(250, len(CLEAN["time"])))
        writer._Writer__finalize_chunk()
        del writer._Writer__chunk_indices[named:]
        writer.finish()
    assert len(log.read(mapping.read(where), path).t) == len(CLEAN["time"])


def test_mcap_of_two_files_in_one_is_refused(tmp_path: Path) -> None:
    """`cat` makes such a file: the second half of the drive was lost, and no word said so."""
    writing = pytest.importorskip("mcap.writer", reason="reads MCAP with the package mcap")
    where, path = field_logs.write(tmp_path, CLEAN, of_topics("/odom"))
    halves = []
    for rows in (range(250), range(250, len(CLEAN["time"]))):
        with path.open("wb") as file:
            writer = writing.Writer(file)
            writer.start()
            drive(writer, rows)
            writer.finish()
        halves.append(path.read_bytes())
    path.write_bytes(b"".join(halves))
    with pytest.raises(TrackmarshalError, match=rf"D174.*{len(halves[1])} bytes stand behind the end"):
        log.read(mapping.read(where), path)


def test_mcap_with_a_field_twice_in_a_message_is_refused(tmp_path: Path) -> None:
    """Readers take the one or the other: here the last one counted, and a car at 45 m/s drove 15."""
    writing = pytest.importorskip("mcap.writer", reason="reads MCAP with the package mcap")
    where, path = field_logs.write(tmp_path, CLEAN, of_topics("/odom"))
    with path.open("wb") as file:
        writer = writing.Writer(file)
        writer.start()
        odom = writer.register_channel("/odom", "json", 0)
        for t, x, y, h, v, yaw in zip(*CLEAN.values()):
            said = f'{{"pose": [{x}, {y}, {h}], "v": {3 * v}, "yaw": {yaw}, "v": {v}}}'
            writer.add_message(odom, round(t * 1e9), said.encode(), round(t * 1e9))
        writer.finish()
    with pytest.raises(TrackmarshalError, match=r"D171.*message 1: .*`/odom`.*'v' stands twice"):
        log.read(mapping.read(where), path)


def test_mcap_without_an_index_is_held_against_its_checksums(tmp_path: Path) -> None:
    """A digit that was changed on a disk is another number, and passed for what was driven."""
    writing = pytest.importorskip("mcap.writer", reason="reads MCAP with the package mcap")
    where, path = field_logs.write(tmp_path, CLEAN, of_topics("/odom"))
    with path.open("wb") as file:
        writer = writing.Writer(
            file, compression=writing.CompressionType.NONE, index_types=writing.IndexType.NONE
        )
        writer.start()
        drive(writer, range(len(CLEAN["time"])))
        writer.finish()
    whole = path.read_bytes()
    assert len(log.read(mapping.read(where), path).t) == len(CLEAN["time"])
    path.write_bytes(whole.replace(b'"v": 15.0', b'"v": 15.1', 1))
    with pytest.raises(TrackmarshalError, match=r"D174.*crc"):
        log.read(mapping.read(where), path)


def test_seconds_that_are_called_milliseconds(tmp_path: Path) -> None:
    """The log lasts for 30 ms then: that is too short to tell anything, and no reason to declare its noise."""
    error = refused(tmp_path, declared=field_logs.MAP.replace("time, unit: s", "time, unit: ms"))
    assert error.code == "D177"
    assert "unit of time" in str(error.help)


def test_a_stamp_of_two_numbers(tmp_path: Path) -> None:
    """`sec` and `nanosec` of a header are no number together; the time that a message was logged at is one."""
    writing = pytest.importorskip("mcap.writer", reason="reads MCAP with the package mcap")
    declared = field_logs.MAP
    for name in ("time", "x", "y", "heading", "v", "yaw"):
        way = "header.stamp" if name == "time" else name
        declared = declared.replace(f"column: {name},", f"column: /odom.{way},")
    where, path = field_logs.write(tmp_path, CLEAN, declared)
    with path.open("wb") as file:
        writer = writing.Writer(file)
        writer.start()
        channel = writer.register_channel("/odom", "json", 0)
        message = (
            {"header": {"stamp": {"sec": 1, "nanosec": 2}}}
            | dict.fromkeys("xyv", 0)
            | {"heading": 0, "yaw": 0}
        )
        writer.add_message(channel, 0, json.dumps(message).encode(), 0)
        writer.finish()
    with pytest.raises(TrackmarshalError) as error:
        log.read(mapping.read(where), path)
    assert error.value.code == "D171"
    assert "`/odom.log_time`" in str(error.value.help)


def test_changed_bytes_are_read_or_refused(tmp_path: Path) -> None:
    """Never another exception, and never a number that is not finite."""
    where, file = field_logs.write(tmp_path, field_logs.straight(20.0, 5.0))
    whole = file.read_bytes()
    declared = mapping.read(where)
    draw = random.Random(4)
    for _ in range(120):
        data = bytearray(whole)
        for _ in range(draw.randrange(1, 6)):
            place = draw.randrange(len(data))
            match draw.randrange(3):
                case 0:
                    data[place] = draw.randrange(256)
                case 1:
                    del data[place : place + draw.randrange(1, 40)]
                case _:
                    data[place:place] = bytes(
                        draw.choice(b'\n\r",;-e#\xc3\x00 nan') for _ in range(draw.randrange(1, 4))
                    )
        file.write_bytes(data)
        try:
            found = log.read(declared, file)
        except TrackmarshalError as refusal:
            assert refusal.code.startswith("D1")
            assert refusal.help
        else:
            assert all(
                np.isfinite(column).all() for column in (found.t, found.x, found.y, found.heading, found.v)
            )
            assert (np.diff(found.t) > 0).all()


def test_changed_mappings_are_read_or_refused(tmp_path: Path) -> None:
    where, _ = field_logs.write(tmp_path, CLEAN)
    whole = where.read_text(encoding="utf-8")
    draw = random.Random(7)
    for _ in range(120):
        lines = whole.split("\n")
        place = draw.randrange(len(lines))
        match draw.randrange(4):
            case 0:
                del lines[place]
            case 1:
                lines[place] = lines[place].replace(":", "", 1)
            case 2:
                lines[place] = lines[place][: draw.randrange(len(lines[place]) + 1)]
            case _:
                lines[place] += draw.choice([" [", " {", " &a", " é", " 1e400", ": x", "\n- 1"])
        where.write_text("\n".join(lines), encoding="utf-8")
        try:
            mapping.read(where)
        except TrackmarshalError as refusal:
            assert refusal.code.startswith("D1")
            assert refusal.help


def test_a_log_of_reversing_is_one(tmp_path: Path) -> None:
    """Pushed back or parked: the speed is negative, and the direction of travel is where the tail points. It is no heading that is turned."""
    columns = field_logs.straight(40.0)
    columns["y"], columns["v"] = -columns["y"], -columns["v"]
    where, file = field_logs.write(tmp_path, columns)
    made = build.build(mapping.read(where), file)
    at_20 = next(cycle for cycle in made.recording.cycles if cycle.t == pytest.approx(20.0))
    driving, emergency = at_20.candidates["driving"], at_20.candidates["emergency"]
    assert driving["v"] == pytest.approx(np.full(21, -15.0), abs=0.01)
    assert np.diff(driving["s"]) == pytest.approx(np.full(20, 1.5), abs=0.02)
    assert emergency["v"][0] == driving["v"][0]
    assert emergency["y"][-1] < emergency["y"][0] == driving["y"][0]


def test_a_speed_of_the_wrong_sign_is_no_reversing(tmp_path: Path) -> None:
    error = refused(tmp_path, field_logs.text({**CLEAN, "v": -CLEAN["v"]}).encode(), declared=field_logs.MAP)
    assert error.code == "D173"
    assert "a speed of the other sign" in str(error.help)


def test_a_noisy_heading_on_a_straight_turns_nothing(tmp_path: Path) -> None:
    """Of 100 s straight on, the noise of the heading was held against a yaw rate that is none: its unit was said to be wrong."""
    columns = field_logs.noisy(field_logs.straight(100.0, 10.0), 1, 0.02, 0.01, 0.05, 0.002)
    where, file = field_logs.write(tmp_path, columns)
    assert len(log.read(mapping.read(where), file).t) == 1000


@pytest.mark.parametrize("factor", [-1.0, 57.3, 1 / 57.3])
def test_a_yaw_rate_that_is_none_of_a_noisy_heading_is_found(tmp_path: Path, factor: float) -> None:
    columns = field_logs.noisy(field_logs.ring(40.0, 10.0), 1, 0.02, 0.01, 0.05, 0.002)
    where, file = field_logs.write(tmp_path, {**columns, "yaw": factor * columns["yaw"]})
    with pytest.raises(TrackmarshalError, match=r"D173.*the yaw rate is"):
        log.read(mapping.read(where), file)


def straight_and_turned_slowly() -> dict[str, Any]:
    """15 m/s straight on, and a bend of 10 m at 2 m/s: too slow to say anything of noise."""
    t = np.arange(1500) / 25
    v = np.where(t < 30.0, 15.0, np.maximum(15.0 - 3.0 * (t - 30.0), 2.0))
    yaw = np.where(t > 40.0, v / 10.0, 0.0)
    ds = np.concatenate([[0.0], np.diff(t) * 0.5 * (v[1:] + v[:-1])])
    heading = np.concatenate([[0.0], np.cumsum(np.diff(t) * 0.5 * (yaw[1:] + yaw[:-1]))])
    x, y = np.cumsum(ds * np.cos(heading)), np.cumsum(ds * np.sin(heading))
    columns = {"time": t, "x": x, "y": y, "heading": heading, "v": v, "yaw": yaw}
    return field_logs.noisy(columns, 7, 0.01, 0.003, 0.02, 0.002)


def test_noise_that_does_not_explain_the_log_is_refused(tmp_path: Path) -> None:
    """All that is fast is straight, so the bend would be ironed out: trajectories would have headings that the car never had."""
    where, file = field_logs.write(tmp_path, straight_and_turned_slowly())
    with pytest.raises(TrackmarshalError) as found:
        build.build(mapping.read(where), file)
    assert found.value.code == "D177"
    assert "innovations of turning" in found.value.message
    assert "`lateral_jerk`" in str(found.value.help)
    where.write_text(where.read_text() + "noise: {lateral_jerk: 0.3}\n")
    made = build.build(mapping.read(where), file)
    assert np.angle(np.exp(1j * (made.motion.heading - made.log.heading))) == pytest.approx(0.0, abs=0.05)


def test_a_log_of_the_command_line_is_none_that_the_mapping_names(tmp_path: Path) -> None:
    """It was said to be, and that it need not be here."""
    declared = mapping.read(Path(__file__).parents[1] / "field" / "lvms_25s.yaml")
    with pytest.raises(TrackmarshalError) as found:
        build.build(declared, tmp_path / "none.csv")
    assert (found.value.code, found.value.help) == ("D120", "check the path")
