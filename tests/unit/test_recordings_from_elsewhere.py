"""Recordings come from elsewhere: what they name is not simply opened or written, what they say not simply printed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from support.project import run_command
from support.shared import REPOSITORY
from trackmarshal.library import LIBRARY

RECORDING = REPOSITORY / "specs" / "scenarios" / "free_lap.tmrec.jsonl"
SPEC = """module small
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
param v_max : m/s = 100 m/s
rule fast "Not too fast"
  for all p in plan
  require p.v <= v_max
"""
CAR = "module car\nparam v_max : m/s = 90 m/s\n"
SECRET = "root:x:0:0:super secret\n"
V_MODEL = "document: v-model\ntitle: small\nproject:\n  name: small\n  specs: [specs]\n  default_spec: specs/small.spec\n"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project with a spec, a car and a folder of recordings; beside it, what is none of its business."""
    root = tmp_path / "project"
    for folder in ("requirements", "specs/cars", "recordings/near"):
        (root / folder).mkdir(parents=True)
    (root / "requirements" / "v-model.yaml").write_text(V_MODEL)
    (root / "specs" / "small.spec").write_text(SPEC)
    (root / "specs" / "cars" / "car.spec").write_text(CAR)
    (root / "recordings" / "near" / "own.spec").write_text(CAR.replace("car", "own"))
    (root / "notes.txt").write_text(SECRET)
    (tmp_path / "outside.spec").write_text(CAR.replace("car", "outside"))
    (tmp_path / "secret").write_text(SECRET)
    (tmp_path / "secret.spec").write_text(SECRET)
    (root / "specs" / "link.spec").symlink_to(tmp_path / "secret")
    (root / "specs" / "notes.spec").symlink_to(root / "notes.txt")
    (root / "specs" / "cars" / "away").symlink_to(tmp_path)
    (root / "specs" / "same.spec").symlink_to("cars/car.spec")
    monkeypatch.chdir(root)
    return root


def write(place: str, **head: Any) -> str:
    first, *cycles = RECORDING.read_text("utf-8").splitlines()
    made = {**json.loads(first), "use": [], "params": {}, "tables": {}, **head}
    Path(place).write_text("\n".join([json.dumps(made), *cycles[:2]]) + "\n", "utf-8")
    return place


INSIDE = ["specs/cars/car.spec", "../../specs/cars/car.spec", "own.spec", "./own.spec", "specs/same.spec"]
OUTSIDE = [
    "{outside}/secret.spec", "{outside}/project/specs/cars/car.spec", "../../../secret.spec", "../secret.spec",
    "../../../outside.spec", "../outside.spec", "specs/../../secret.spec",
    "specs/link.spec", "specs/notes.spec", "specs/cars/away/outside.spec", "../../specs/link.spec",
    "notes.txt", "../../notes.txt", "", ".", "..", "specs", "/etc/passwd", "own.spec\x00", "/dev/stdin",
]  # fmt: skip


@pytest.mark.parametrize("name", INSIDE)
@pytest.mark.parametrize("verb", ["replay", "explain"])
def test_a_recording_may_name_specs_of_its_project(name: str, verb: str, project: Path) -> None:
    path = write("recordings/near/run.tmrec.jsonl", use=[name])
    more = ("--rule", "fast", "--at", "0") if verb == "explain" else ()
    status, _, err = run_command(verb, path, "--spec", "specs/small.spec", *more)
    assert (status, err) == (0, "")


@pytest.mark.parametrize(
    "name", ["vehicles.devbot", "vehicles.none", "supervisor.assumptions", "vehicles.spec"]
)
def test_a_recording_may_name_a_shipped_vehicle_by_its_module(name: str, project: Path) -> None:
    """Also in a project that has only the package, and no path of it; no other module, and a file is a file."""
    small = Path("specs/small.spec")
    small.write_text(small.read_text().replace("param v_max : m/s = 100 m/s", "use vehicles.devbot"))
    Path("vehicles.spec").write_text("module vehicles\nparam v_max : m/s = 1 m/s\n")
    path = write("recordings/near/run.tmrec.jsonl", use=[name])
    status, _, err = run_command("replay", path, "--spec", "specs/small.spec")
    expected = {"vehicles.devbot": (0, ""), "vehicles.spec": (1, "")}.get(name, (2, "error[E432]"))
    assert (status, err.partition(":")[0]) == expected


def test_a_shipped_module_of_which_the_project_has_another_one_is_not_guessed(project: Path) -> None:
    """A rule's `use` of it is the project's own, and the recording's was the shipped one: of a car as long as ours, 4.7 m were judged."""
    small = Path("specs/small.spec")
    small.write_text(small.read_text().replace("param v_max : m/s = 100 m/s", "use vehicles.devbot"))
    own = Path("specs/vehicles/devbot.spec")
    own.parent.mkdir(exist_ok=True)
    own.write_bytes((LIBRARY / "vehicles" / "devbot.spec").read_bytes())
    path = write("recordings/near/run.tmrec.jsonl", use=["vehicles.devbot"])
    assert run_command("replay", path, "--spec", "specs/small.spec")[0] == 0  # a copy is no other one
    own.write_text(own.read_text("utf-8").replace("= 4.7 m", "= 3.1 m"), "utf-8")
    status, _, err = run_command("replay", path, "--spec", "specs/small.spec")
    assert (status, err.partition(":")[0]) == (2, "error[E432]")
    assert "`specs/vehicles/devbot.spec`" in err
    path = write("recordings/near/run.tmrec.jsonl", use=["specs/vehicles/devbot.spec"])
    assert run_command("replay", path, "--spec", "specs/small.spec")[0] == 0


@pytest.mark.parametrize("name", OUTSIDE)
@pytest.mark.parametrize("verb", ["replay", "explain"])
def test_a_recording_may_name_nothing_else(name: str, verb: str, project: Path) -> None:
    path = write("recordings/near/run.tmrec.jsonl", use=[name.replace("{outside}", str(project.parent))])
    more = ("--rule", "fast", "--at", "0") if verb == "explain" else ()
    status, out, err = run_command(verb, path, "--spec", "specs/small.spec", *more)
    assert status == 2
    assert "error[E432]" in err, err
    assert path in err
    assert "help: " in err
    for text in (out, err):
        assert "secret\n" not in text
        assert "root:" not in text


def test_without_a_project_its_folder_is_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "here").mkdir()
    (tmp_path / "small.spec").write_text(SPEC)
    (tmp_path / "car.spec").write_text(CAR)
    (tmp_path / "here" / "car.spec").write_text(CAR)
    for name, status in (("car.spec", 0), ("../car.spec", 2), (str(tmp_path / "here" / "car.spec"), 2)):
        path = write("here/run.tmrec.jsonl", use=[name])
        found, _, err = run_command("replay", path, "--spec", "small.spec")
        assert found == status, err
        assert status == 0 or "error[E432]" in err


def test_a_shipped_recording_is_used_from_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It names the track of its own project, wherever the command is called."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.spec").write_text(
        SPEC + "line start_line = (0 m, 0 m) (1 m, 0 m)\nzone pit_lane = polygon (0 m, 0 m) (1 m, 0 m) (1 m, 1 m)\n"
        + "".join(f"param {n} : {u} = 1 {u}\n" for n, u in (("length", "m"), ("width", "m"), ("R_min", "m"), ("b_max", "m/s^2"), ("g", "m/s^2"), ("drag", "kg/m")))
        + "param mu : 1 = 1\nparam drive_factor : 1 = 1\n"
    )  # fmt: skip
    status, _, err = run_command("replay", str(RECORDING), "--spec", "small.spec", "--quiet")
    assert (status, err) == (0, "")


@pytest.mark.parametrize(
    "track", ["{outside}/secret", "../secret", "../../secret", "{outside}/track.yaml", "/etc/passwd"]
)
def test_a_declaration_does_not_open_any_file_either(track: str, project: Path) -> None:
    text = (REPOSITORY / "specs" / "scenarios" / "free_lap.yaml").read_text("utf-8")
    given = "../tracks/northfield.yaml"
    assert given in text
    path = Path("recordings/near/run.yaml")
    path.write_text(text.replace(given, track.replace("{outside}", str(project.parent))), "utf-8")
    status, out, err = run_command("replay", str(path), "--spec", "specs/small.spec")
    assert status == 2
    assert "error[D151]" in err
    assert "root:" not in out + err


# Names of files ------------------------------------------------------------------------------------------------

NAMES = [
    "../evil",
    "/tmp/evil",
    "a/b",
    "..",
    ".",
    "",
    " ",
    ".hidden",
    "a\nb",
    "a\x1b[31mb",
    "a\x00b",
    "a\\b",
    "x" * 300,
]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_stays_in_the_folder(name: str, project: Path) -> None:
    path = write("run.tmrec.jsonl", name=name)
    before = {file for file in project.parent.rglob("*") if "out" not in file.parts}
    status, out, err = run_command("replay", path, "--spec", "specs/small.spec", "--out", "out/here")
    assert status == 2
    assert "error[E433]" in err
    assert out == ""
    assert {file for file in project.parent.rglob("*") if "out" not in file.parts} == before
    assert not list(project.glob("out/**/*.json*"))


def test_one_run_is_not_written_over_another(project: Path) -> None:
    paths = [write("a.tmrec.jsonl", name="same"), write("b.tmrec.jsonl", name="Same")]
    status, _, err = run_command("replay", *paths, "--spec", "specs/small.spec", "--out", "out/here")
    assert status == 2
    assert "error[E433]" in err
    assert "b.tmrec.jsonl" in err
    status, _, _ = run_command("replay", paths[0], "--spec", "specs/small.spec", "--out", "out/here")
    assert status == 0
    assert {file.name for file in (project / "out" / "here").iterdir()} == {"same.jsonl", "same.run.json"}


def test_what_is_no_record_of_a_run_is_not_exported(project: Path) -> None:
    path = write("run.tmrec.jsonl")
    status, out, err = run_command("replay", path, "--spec", "specs/small.spec", "--mcap", "run.mcap")
    assert (status, out) == (2, "")
    assert "error[E434]" in err
    assert "record=" in err
    assert not Path("run.mcap").exists()


# Text on a terminal --------------------------------------------------------------------------------------------

ACTS = "\x1b[2J\x1b[31m\x07\r\x9b5m\u202eevil\nground truth, static: inside"


def test_a_name_cannot_act_on_the_terminal(project: Path) -> None:
    path = write("run.tmrec.jsonl", name=ACTS, tables={ACTS: [[0, 1]]}, extra={"tables": [ACTS]})
    for arguments in (
        ("replay", path, "--spec", "specs/small.spec"),
        ("replay", path, "--spec", "specs/small.spec", "--format", "jsonl"),
        ("explain", path, "--spec", "specs/small.spec", "--rule", "fast", "--at", "0"),
    ):
        _, out, err = run_command(*arguments)
        for text in (out, err):
            assert not set(text) & set("\x1b\x07\r\x9b\u202e")
            assert "\nground truth, static: inside\n" not in text
        assert r"\x1b[31m" in out or r"\u001b[31m" in out


def test_ids_and_messages_cannot_either(project: Path) -> None:
    case = {
        "id": ACTS,
        "signals": {"plan": {"t": [0, 1], "x": [0, 1], "y": [0, 0], "heading": [0, 0], "v": [1, 1]}},
    }
    wrong = {**case, "id": ACTS + "2", "params": {ACTS: 1}}
    Path("cases.jsonl").write_text(json.dumps(case) + "\n" + json.dumps(wrong) + "\n")
    for format_ in ("text", "jsonl"):
        _, out, err = run_command("eval", "specs/small.spec", "--data", "cases.jsonl", "--format", format_)
        for text in (out, err):
            assert not set(text) & set("\x1b\x07\r\x9b\u202e")
            assert "\nground truth, static: inside\n" not in text
        if format_ == "jsonl":
            assert [json.loads(line)["id"] for line in out.splitlines()] == [ACTS, ACTS + "2"]


def test_file_names_and_titles_of_requirements_cannot_either(project: Path) -> None:
    (project / "specs" / "odd\x1b[31m.spec").write_text("module odd\nrule odd require 1 < 2 m\n")
    (project / "requirements" / "more.yaml").write_text(
        'document: requirements\nrequirements:\n  - id: R-1\n    title: "\\e[31mevil"\n    statement: The car shall stop.\n'
        "    rationale: x\n    status: approved\n    asil: D\n"
    )
    for arguments in (
        ("check",),
        ("test",),
        ("fmt",),
        ("trace", "--as-is"),
        ("trace", "--as-is", "--format", "github"),
    ):
        _, out, err = run_command(*arguments)
        assert "\x1b" not in out + err, arguments
