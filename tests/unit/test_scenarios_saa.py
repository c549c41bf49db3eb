"""ScenarioArchitect archives: what is read, and what is refused, with code, part and line."""

from __future__ import annotations

import io
import math
import struct
import zipfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from support.archives import HEADER, archive, row, scn
from trackmarshal import scenarios
from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios import content, saa
from trackmarshal.scenarios.recording import COLUMNS, Recording

SHARED = Path(__file__).parents[3] / "shared" / "data" / "scenarios"
NAMES = ("modena_T1_cutin_collision", "modena_T1_infeasible", "modena_T1_valid")


def read(text: str | bytes, **others: str) -> Recording:
    return saa.read(archive(text, **others), "scene.saa")


def test_conventions_are_converted() -> None:
    recording = read(scn())
    cycle = recording.cycles[0]
    assert recording.name == "scene"
    assert cycle.ego == {"x": 0.0, "y": 0.0, "heading": 0.0, "kappa": 0.0, "v": 10.0, "a": 0.5, "age": 0.0}
    assert cycle.candidates["driving"]["s"] == [0.0, 2.0, 4.0, 6.0]
    assert cycle.candidates["driving"]["t"] == pytest.approx([0.0, 0.2, 0.4, 0.6])
    (other,) = cycle.objects
    assert other["heading"] == pytest.approx(math.pi / 2.0)  # 0 along +y there
    assert {**other, "heading": 0.0} == {
        "id": "veh_2", "x": 30.0, "y": 1.0, "heading": 0.0, "v": 8.0, "length": 4.7, "width": 2.8, "age": 0.0,
    }  # fmt: skip
    assert recording.track == {
        "left": [[0.0, 5.0], [50.0, 5.0]],
        "right": [[0.0, -5.0], [50.0, -5.0]],
        "closed": False,
    }


def test_ground_truth_has_three_values() -> None:
    recording = read(
        scn(row(), row(0.1, safety_dyn="false", safety_stat="true"), row(0.2, safety_dyn="null"))
    )
    assert recording.ground_truth == {"dynamic": (True, False, None), "static": (None, True, None)}


def test_the_path_beyond_rest_is_dropped_and_counted() -> None:
    recording = read(scn())
    assert [cycle.candidates["emergency"]["v"] for cycle in recording.cycles] == [[10.0, 5.0, 0.0]] * 2
    assert recording.notes == ("emergency: 2 samples after the first at rest were dropped",)


def test_older_files_have_no_ground_truth() -> None:
    header = HEADER.rsplit(";", 2)[0]
    recording = read(scn(row().rsplit(";", 2)[0], header=header))
    assert recording.ground_truth == {}


def test_unknown_columns_are_noted_and_not_read() -> None:
    recording = read(scn(row() + ";{never read", header=HEADER + ";mood"))
    assert "column `mood` is not known here and was not read" in recording.notes


def test_tables() -> None:
    recording = read(
        scn(),
        ax_max_machines="# v, ax\n0.0, 6.0\n40.0, 5.7\n",
        ggv="# v, ax, ay\n0.0, 13.0, 12.0\n36.0, 11, 14\n",
    )
    assert recording.tables == {"ax_max": [[0.0, 6.0], [40.0, 5.7]], "grip": [[0.0, 12.0], [36.0, 11.0]]}


def test_what_its_makers_allow_is_an_override_with_a_reason() -> None:
    """115 % of what is physically there, and of nothing that is not."""
    recording = read(
        scn(), ax_max_machines="# v, ax\n0.0, 6.0\n", ggv="# v, ax, ay\n0.0, 13.0, 12.0\n36.0, 11, 14\n"
    )
    assert recording.params == {"mu": pytest.approx(1.15 * 11.0 / 9.81), "drive_factor": 1.15}
    assert "115 % of the archive's grip, 11 m/s^2" in recording.because["mu"]
    assert "115 %" in recording.because["drive_factor"]
    assert read(scn()).params == {}


def test_what_the_format_does_not_have_is_given_with_a_reason() -> None:
    recording = read(scn(), ggv="# v, ax, ay\n0.0, 13.0, 12.0\n")
    assert recording.given == {"ego.age": 0.0, "plan.grip": 1.0}
    assert all(recording.because[name].startswith("simulated: ") for name in recording.given)
    assert {tuple(plan["grip"]) for c in recording.cycles for plan in c.candidates.values()} == {
        (1.0,) * 3,
        (1.0,) * 4,
    }
    # Without a table of grip nobody knows what the road is like.
    assert "plan.grip" not in read(scn()).given
    assert all("grip" not in plan for c in read(scn()).cycles for plan in c.candidates.values())


@pytest.mark.parametrize("text", ["NaN", "Infinity", "-Infinity", "1e999"])
def test_numbers_that_are_not_finite_stay_undefined(text: str) -> None:
    plan = f"[[0, 0, 0, {text}, 10, 0], [2, 0, 0, 0, 10, 0]]"
    recording = read(scn(row(vel=text, ego_traj=plan)))
    assert math.isnan(recording.cycles[0].ego["v"])
    assert math.isnan(recording.cycles[0].candidates["driving"]["kappa"][0])


def test_signals_share_the_track() -> None:
    recording = read(scn())
    first = recording.signals(recording.cycles[0], "driving")
    second = recording.signals(recording.cycles[1], "emergency")
    assert first["track"] is second["track"] is recording.track
    assert (first["emergency"], second["emergency"]) == (False, True)
    assert first["plan"] is recording.cycles[0].candidates["driving"]
    with pytest.raises(TrackmarshalError) as caught:
        recording.signals(recording.cycles[0], "dreaming")
    assert caught.value.code == "D144"


#: text of the .scn, code, line, a part of the message
BAD_TEXTS: dict[str, tuple[str | bytes, str, int | None, str]] = {
    "empty": ("", "D126", 1, "empty"),
    "latin 1": (scn().replace("veh_2", "größe").encode("latin-1"), "D126", 4, "UTF-8"),
    "no border": (scn().replace("bound_r", "bound_x"), "D127", None, "bound_r"),
    "border twice": ("# bound_l:[[0, 99], [50, 99]]\n" + scn(), "D127", 2, "more than one comment line `# bound_l"),
    "border of one point": (scn(left="[[0, 0]]"), "D128", 1, "two or more"),
    "border with NaN": (scn(left="[[0, 0], [NaN, 1]]"), "D128", 1, "NaN"),
    "border without end": (scn(left="[[0, 0], [1e999, 1]]"), "D128", 1, "finite"),
    "border of triples": (scn(left="[[0, 0, 0], [1, 0, 0]]"), "D128", 1, "bound_l"),
    "no header": ("# bound_l:[[0,1],[2,1]]\n# bound_r:[[0,0],[2,0]]\n", "D127", None, "header"),
    "missing columns": (scn(header=HEADER.replace("ego_traj_em", "other")), "D127", 3, "ego_traj_em"),
    "column twice": (scn(row() + ";1", header=HEADER + ";x"), "D127", 3, "twice"),
    "no cycles": (scn("\r\n"), "D130", None, "no cycles"),
    "short row": (scn(row(), row(0.1).rsplit(";", 1)[0]), "D127", 5, "11 cells"),
    "bad JSON": (scn(row(ego_traj="[[0, 0")), "D128", 4, "ego_traj"),
    "deep JSON": (scn(row(object_array="[" * 100_000)), "D128", 4, "too deeply"),
    "digits without end": (scn(row(vel="1" * 5000)), "D128", 4, "vel"),
    "text for a number": (scn(row(vel='"fast"')), "D128", 4, "'fast'"),
    "true for a number": (scn(row(x="true")), "D128", 4, "truth value"),
    "seven columns": (scn(row(ego_traj="[[0, 0, 0, 0, 1, 0, 0]]")), "D129", 4, "6 numbers"),
    "no samples": (scn(row(ego_traj_em="[]")), "D129", 4, "ego_traj_em"),
    "plan is no list": (scn(row(ego_traj="7")), "D129", 4, "a list is expected"),
    "short object": (scn(row(object_array='[["a", [1, 2, 3]]]')), "D128", 4, "object_array"),
    "nameless object": (scn(row(object_array="[[3, [1, 2, 3, 4, 5, 6]]]")), "D128", 4, "object_array"),
    "object twice": (
        scn(row(object_array='[["a", [1, 2, 3, 4, 5, 6]], ["a", [1, 2, 3, 4, 5, 6]]]')),
        "D128", 4, "twice",
    ),
    "name twice": (scn(row(object_array='{"a": 1, "a": 2}')), "D128", 4, "twice"),
    "truth is a number": (scn(row(safety_dyn="1")), "D128", 4, "safety_dyn"),
    "time is NaN": (scn(row(time="NaN")), "D130", 4, "finite"),
    "time stands still": (scn(row(), row(0.0)), "D130", 5, "does not come after"),
    "time goes back": (scn(row(0.2), row(0.1)), "D130", 5, "does not come after"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_TEXTS)
def test_bad_texts_are_refused(name: str) -> None:
    text, code, line, part = BAD_TEXTS[name]
    with pytest.raises(TrackmarshalError) as caught:
        read(text)
    error = caught.value
    assert (error.code, error.line) == (code, line), str(error)
    assert part in error.message
    assert error.file == "scene.saa!scene.scn"
    assert error.help


def test_all_faults_of_a_file_are_counted() -> None:
    with pytest.raises(TrackmarshalError) as caught:
        read(scn(row(vel="x"), row(0.1), row(0.2, x="y"), row(0.3, ego_traj="[]")))
    assert caught.value.line == 4
    assert caught.value.message.endswith("(and 2 more, lines 6, 7)")


@pytest.mark.parametrize(
    ("table", "line", "part"),
    [
        ("0.0, 6.0\n4.0\n", 2, "no row of 2"),
        ("0.0, 6.0\nfast, 6.0\n", 2, "fast"),
        ("0.0, nan\n", 1, "finite"),
        ("4.0, 6.0\n0.0, 6.0\n", 2, "does not come after"),
        ("# nothing\n", None, "no rows"),
    ],
)
def test_bad_tables_are_refused(table: str, line: int | None, part: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        read(scn(), ax_max_machines=table)
    assert (caught.value.code, caught.value.line) == ("D131", line)
    assert part in caught.value.message


def packed(*members: tuple[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as zipped:
        for name, data in members:
            zipped.writestr(name, data)
    return stream.getvalue()


def damaged(change: Callable[[bytearray, int], None]) -> bytes:
    """An archive whose one stored part, found by its first bytes, is changed."""
    text = scn().encode()
    data = bytearray(packed(("scene.scn", text), method=zipfile.ZIP_STORED))
    change(data, data.index(text[:20]))
    return bytes(data)


def flip(data: bytearray, at: int) -> None:
    data[at + 30] ^= 1


def encrypt(data: bytearray, _at: int) -> None:
    directory = data.index(b"PK\x01\x02")
    struct.pack_into("<H", data, 6, 1)
    struct.pack_into("<H", data, directory + 8, 1)


def lie(data: bytearray, _at: int) -> None:
    """Declare a smaller size than the part has."""
    struct.pack_into("<I", data, data.index(b"PK\x01\x02") + 24, 10)


def boast(data: bytearray, _at: int) -> None:
    """Declare a larger size than the part has."""
    at = data.index(b"PK\x01\x02") + 24
    struct.pack_into("<I", data, at, struct.unpack_from("<I", data, at)[0] + 9)


TEXT = scn().encode()
BAD_ARCHIVES: dict[str, tuple[bytes, str]] = {
    "no ZIP": (b"time;x;y", "D122"),
    "nothing": (b"", "D122"),
    "cut off": (packed(("scene.scn", TEXT))[:-30], "D122"),
    "two in one": (packed(("scene.scn", scn(row(9.0)).encode())) + packed(("scene.scn", TEXT)), "D122"),
    "one bit changed": (damaged(flip), "D122"),
    "a size that is not true": (damaged(lie), "D122"),
    "a size that is not reached": (damaged(boast), "D122"),
    "encrypted": (damaged(encrypt), "D125"),
    "LZMA": (packed(("scene.scn", TEXT), method=zipfile.ZIP_LZMA), "D125"),
    "no .scn": (packed(("scene.txt", TEXT)), "D123"),
    "two .scn": (packed(("a.scn", TEXT), ("b.SCN", TEXT)), "D123"),
    "two tables": (packed(("a.scn", TEXT), ("a_ggv.csv", b"0,1,1"), ("b_ggv.csv", b"0,1,1")), "D123"),
    "climbs out": (packed(("../scene.scn", TEXT)), "D123"),
    "absolute": (packed(("/scene.scn", TEXT)), "D123"),
    "a drive": (packed(("C:\\scene.scn", TEXT)), "D123"),
    "a bomb": (packed(("scene.scn", b"0" * 5_000_000)), "D124"),
    "a bomb beside": (packed(("scene.scn", TEXT), ("x.sas", b"0" * 5_000_000)), "D124"),
    "too many parts": (packed(("scene.scn", TEXT), *((f"{i}.txt", b"") for i in range(1001))), "D124"),
}


@pytest.mark.parametrize("name", BAD_ARCHIVES)
def test_bad_archives_are_refused(name: str) -> None:
    data, code = BAD_ARCHIVES[name]
    with pytest.raises(TrackmarshalError) as caught:
        saa.read(data, "scene.saa")
    assert caught.value.code == code, str(caught.value)
    assert caught.value.file == "scene.saa"
    assert caught.value.help


def test_the_limit_that_is_named_is_the_one_of_what_is_counted() -> None:
    for name, limit in (("a bomb", "1000000"), ("too many parts", "1000")):
        with pytest.raises(TrackmarshalError, match=rf"the limit is {limit}\n") as caught:
            saa.read(BAD_ARCHIVES[name][0], "scene.saa")
        assert caught.value.code == "D124"


def test_declared_sizes_are_limited() -> None:
    data = bytearray(packed(("scene.scn", TEXT), method=zipfile.ZIP_STORED))
    directory = data.index(b"PK\x01\x02")
    struct.pack_into("<II", data, directory + 20, 3_000_000_000, 3_000_000_000)
    with pytest.raises(TrackmarshalError) as caught:
        saa.read(bytes(data), "scene.saa")
    assert caught.value.code == "D124"


def test_declared_sizes_are_limited_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many parts that each are small enough are as much as one that is not."""
    data = packed(("scene.scn", TEXT), ("a.sas", b"x" * len(TEXT)), ("b.sas", b"y" * len(TEXT)))
    monkeypatch.setattr(content, "MAX_BYTES", 3 * len(TEXT))
    assert saa.read(data, "scene.saa").name == "scene"
    monkeypatch.setattr(content, "MAX_BYTES", 3 * len(TEXT) - 1)
    with pytest.raises(TrackmarshalError, match=f"the parts unpack to {3 * len(TEXT)} bytes") as caught:
        saa.read(data, "scene.saa")
    assert caught.value.code == "D124"


def test_the_pickle_is_never_opened() -> None:
    # Unreadable bytes and a wrong checksum: whoever opens this part fails.
    data = bytearray(
        packed(("scene.scn", TEXT), ("scene.sas", b"\x80\x04 a pickle"), method=zipfile.ZIP_STORED)
    )
    data[data.index(b" a pickle")] ^= 0xFF
    assert len(saa.read(bytes(data), "scene.saa").cycles) == 2


def test_ballast_of_other_packers_is_passed_over() -> None:
    data = packed(("folder/", b""), ("folder/inner.scn", TEXT), ("__MACOSX/folder/._inner.scn", b"\x00\x05"))
    assert saa.read(data, "renamed.saa").name == "inner"


@pytest.mark.parametrize("name", NAMES)
class TestRecordings:
    """The recordings of the paper's authors, where they are at hand."""

    @pytest.fixture
    def recording(self, name: str) -> Recording:
        path = SHARED / f"{name}.saa"
        if not path.exists():
            pytest.skip(f"{path} is not there")
        return scenarios.load(path)

    def test_size(self, recording: Recording, name: str) -> None:
        cycles, points = {"modena_T1_cutin_collision": (106, 101)}.get(name, (0, 84))
        cycles = cycles or {"modena_T1_infeasible": 74, "modena_T1_valid": 100}[name]
        assert len(recording.cycles) == cycles
        assert len(recording.track["left"]) == len(recording.track["right"]) == points
        assert set(recording.tables) == {"ax_max", "grip"}
        assert recording.tables["ax_max"][0] == [0.0, 6.0]
        assert all(
            set(plan) == {*COLUMNS, "grip"} for c in recording.cycles for plan in c.candidates.values()
        )

    def test_heading_is_the_direction_of_travel(self, recording: Recording, name: str) -> None:
        for plan in plans(recording):
            for i in range(len(plan["t"]) - 1):
                dx, dy = plan["x"][i + 1] - plan["x"][i], plan["y"][i + 1] - plan["y"][i]
                turn = math.remainder(plan["heading"][i + 1] - plan["heading"][i], math.tau)
                off = math.remainder(math.atan2(dy, dx) - plan["heading"][i] - turn / 2.0, math.tau)
                assert abs(off) < 0.035

    def test_curvature_is_positive_to_the_left(self, recording: Recording, name: str) -> None:
        for plan in plans(recording):
            for i in range(len(plan["t"]) - 1):
                turn = math.remainder(plan["heading"][i + 1] - plan["heading"][i], math.tau)
                mean = (plan["kappa"][i] + plan["kappa"][i + 1]) / 2.0
                assert turn / (plan["s"][i + 1] - plan["s"][i]) == pytest.approx(mean, abs=0.003)

    def test_left_border_is_on_the_left(self, recording: Recording, name: str) -> None:
        ego = recording.cycles[0].ego
        (x0, y0), (x1, y1) = recording.track["left"][0], recording.track["right"][0]
        assert math.cos(ego["heading"]) * (y0 - y1) - math.sin(ego["heading"]) * (x0 - x1) > 5.0

    def test_trajectories_begin_at_the_ego_pose(self, recording: Recording, name: str) -> None:
        for cycle in recording.cycles:
            for plan in cycle.candidates.values():
                for column in ("x", "y", "heading", "kappa", "v"):
                    assert plan[column][0] == cycle.ego[column]

    def test_times_increase_and_driving_samples_are_a_tenth_apart(
        self, recording: Recording, name: str
    ) -> None:
        for plan in plans(recording):
            assert all(b > a for a, b in zip(plan["t"], plan["t"][1:]))
        for cycle in recording.cycles:
            t = cycle.candidates["driving"]["t"]
            assert len(t) == 30
            assert all(0.08 < b - a < 0.11 for a, b in pairwise(t))

    def test_emergency_ends_at_rest(self, recording: Recording, name: str) -> None:
        moving = [cycle.t for cycle in recording.cycles if cycle.candidates["emergency"]["v"][-1] != 0.0]
        expected = [2.3 + 0.1 * i for i in range(15)] if name == "modena_T1_infeasible" else []
        assert moving == pytest.approx(expected)

    def test_ground_truth(self, recording: Recording, name: str) -> None:
        if name != "modena_T1_cutin_collision":
            assert recording.ground_truth == {}
            return
        dynamic, static = recording.ground_truth["dynamic"], recording.ground_truth["static"]
        assert [t for t in range(106) if dynamic[t] is False] == list(range(64, 74))
        assert [t for t in range(106) if static[t] is True] == list(range(34, 58))

    def test_own_format_holds_all_of_it(self, recording: Recording, name: str, tmp_path: Path) -> None:
        from trackmarshal.scenarios import recording_io

        recording_io.write(recording, tmp_path / "copy.tmrec.jsonl.gz")
        copy = scenarios.load(tmp_path / "copy.tmrec.jsonl.gz")
        assert copy == recording
        assert repr(copy.cycles) == repr(recording.cycles)


def plans(recording: Recording) -> list[dict[str, Any]]:
    return [plan for cycle in recording.cycles for plan in cycle.candidates.values()]
