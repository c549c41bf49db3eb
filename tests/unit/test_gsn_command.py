"""`trackmarshal gsn`: formats, files, the gate; and what it writes for gsn2x is the argument, read back."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import jsonschema
import pytest
import yaml

from golden.gsn.cases import argued, argument
from golden.trace.cases import HERE
from support.project import command
from trackmarshal.trace.gsn import gsn2x
from trackmarshal.trace.gsn.case import Case
from trackmarshal.trace.gsn.kinds import KINDS
from trackmarshal.trace.gsn.picture import layout


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The warehouse robot, with its results."""
    root = tmp_path_factory.mktemp("warehouse") / "project"
    shutil.copytree(HERE / "warehouse", root)
    command(root, "trace", "--accept-baseline")
    return root


def read_back(folder: Path) -> tuple[dict[str, dict[str, Any]], dict[str, str]]:
    """All elements of the files of a case, as gsn2x reads them, with their modules; ids are unique over all files."""
    elements: dict[str, dict[str, Any]] = {}
    modules: dict[str, str] = {}
    for path in sorted(folder.glob("*.gsn.yaml")):
        data = yaml.safe_load(path.read_text("utf-8"))
        module = data.pop("module")
        assert set(module) == {"name", "brief"}
        for id_, element in data.items():
            assert id_ not in elements, "gsn2x wants ids that are unique over all files"
            elements[id_], modules[id_] = element, module["name"]
    return elements, modules


#: Prefixes as gsn2x documents them; of ids that begin with none of them it wants a `nodeType`.
PREFIXES = (("CSn", "CounterSolution"), ("CG", "CounterGoal"), ("Sn", "Solution"), ("G", "Goal"), ("S", "Strategy"), ("C", "Context"),
            ("A", "Assumption"), ("J", "Justification"))  # fmt: skip


def kind_of(id_: str, element: dict[str, Any]) -> str:
    named = element.get("nodeType") or next(kind for prefix, kind in PREFIXES if id_.startswith(prefix))
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", named).lower()


def same(case: Case, folder: Path) -> None:
    """What was written for gsn2x has the elements, the links, the modules and the marks of the argument."""
    elements, modules = read_back(folder)
    assert modules == {e.id: e.module for e in case.elements.values()}
    assert {i: kind_of(i, e) for i, e in elements.items()} == {e.id: e.kind for e in case.elements.values()}
    assert {i: e["text"] for i, e in elements.items()} == {e.id: e.text for e in case.elements.values()}
    names = (("supportedBy", "supported_by"), ("inContextOf", "in_context_of"), ("challenges", "challenges"))
    links = {(kind, i, target) for i, e in elements.items() for name, kind in names for target in e.get(name, ())}  # fmt: skip
    assert links == {(link.kind, link.source, link.target) for link in case.links}
    assert {i for i, e in elements.items() if e.get("undeveloped")} == {e.id for e in case.elements.values() if e.undeveloped}  # fmt: skip


def write(case: Case, folder: Path) -> None:
    folder.mkdir()
    for number, module in enumerate(case.modules):
        (folder / f"{number}.gsn.yaml").write_text(gsn2x.render(case, module), "utf-8")


def test_gsn2x_read_back(tmp_path: Path) -> None:
    edits = (
        "edit requirements/argument.yaml\n- top: top\n+ defeaters:\n"
        "+   - {id: D-1, challenges: S-1-A-2, text: 'Maps: are \"old\".', owner: Ada Reader, state: upheld}\n"
        "+   - {id: D-2, challenges: RR-1, text: A log., evidence: true, owner: Ada Reader, state: open}\n"
        "+ confidence:\n+   - {id: ACP-1, at: G-Top, to: S-Hazards, text: It was read by two.}\n+ top: top\n"
    )
    _, case = argument(argued(tmp_path / "p", edits))
    write(case, tmp_path / "out")
    same(case, tmp_path / "out")
    elements, _ = read_back(tmp_path / "out")
    assert elements["G-Top"]["acp"] == {"ACP-1": "S-Hazards"}
    assert [i for i, e in elements.items() if e.get("defeated")] == ["G-S-1-A-2"]


def test_every_kind_has_a_type() -> None:
    assert set(gsn2x.TYPES) == set(KINDS)
    assert [(letters, name) for name, letters in gsn2x.TYPES.values()] == list(PREFIXES)
    assert gsn2x.read_off("Claim-1") == "context"
    assert gsn2x.read_off("1") == ""


def test_a_file_for_each_module(robot: Path, tmp_path: Path) -> None:
    made: dict[str, set[str]] = {}
    for format, ending in (("svg", ".svg"), ("yaml", ".gsn.yaml")):
        out = tmp_path / format
        assert command(robot, "gsn", "--format", format, "--out", str(out), "--gate")[0] == 0
        made[format] = {path.name.removesuffix(ending) for path in out.iterdir()}
    assert made["svg"] == made["yaml"]
    assert "G-Top" in made["svg"]
    for path in (tmp_path / "svg").iterdir():
        for link in ElementTree.parse(path).iter("{http://www.w3.org/2000/svg}a"):
            assert (path.parent / str(link.get("href"))).is_file()
    again = tmp_path / "again"
    command(robot, "gsn", "--format", "svg", "--out", str(again))
    for path in again.iterdir():
        assert path.read_bytes() == (tmp_path / "svg" / path.name).read_bytes()


def test_json_has_all_of_it(robot: Path) -> None:
    status, out, _ = command(robot, "gsn", "--format", "json")
    assert status == 0
    data = json.loads(out)
    assert (data["format"], data["version"], data["top"]) == ("trackmarshal-argument", 1, "G-Top")
    ids = {element["id"] for element in data["elements"]}
    assert {link["source"] for link in data["links"]} | {link["target"] for link in data["links"]} == ids
    tests = [one for element in data["elements"] for one in element["evidence"] if one["kind"] == "test"]
    assert len(tests) == 6
    assert all(re.fullmatch("[0-9a-f]{64}", one["sha256"]) for one in tests)
    assert data["findings"] == []
    (one,) = json.loads(command(robot, "gsn", "--format", "json", "--module", "G-Top")[1])["modules"]
    assert one["name"] == "G-Top"


def test_text_names_every_element(robot: Path) -> None:
    text = command(robot, "gsn")[1]
    data = json.loads(command(robot, "gsn", "--format", "json")[1])
    for element in data["elements"]:
        assert f"{element['id']}: " in text


def test_a_failed_test_fails_the_gate(robot: Path, tmp_path: Path) -> None:
    root = tmp_path / "project"
    shutil.copytree(robot, root)
    spec = root / "specs" / "robot.spec"
    text = spec.read_text("utf-8")
    assert text.count("robot.v <= 0.3 m/s") == 1
    spec.write_text(text.replace("robot.v <= 0.3 m/s", "robot.v <= 0.2 m/s"), "utf-8")
    command(root, "trace")  # runs the tests
    status, out, err = command(root, "gsn", "--gate")
    assert status == 1
    assert out.splitlines()[1].strip().startswith("✗ G-Top")
    assert "error[T413]" in err
    assert "error[T419]: the top goal is not supported: G-Top <- " in err
    assert command(root, "gsn")[0] == 0  # it is shown; nothing was asked of it


def test_more_than_one_picture_needs_a_folder(robot: Path) -> None:
    status, out, err = command(robot, "gsn", "--format", "svg")
    assert (status, out) == (2, "")
    assert "error[T427]" in err
    assert command(robot, "gsn", "--format", "svg", "--module", "G-Top")[1].startswith("<?xml")


def test_an_unknown_module(robot: Path) -> None:
    status, _, err = command(robot, "gsn", "--module", "G-Topp")
    assert status == 2
    assert "error[T426]" in err
    assert "`G-Top`" in err


def test_without_the_engine_everything_else_comes(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(layout, "PROGRAM", "no-such-engine")
    status, _, err = command(robot, "gsn", "--format", "svg", "--module", "G-Top")
    assert status == 2
    assert "error[T424]" in err
    assert "pip install 'trackmarshal[gsn]'" in err
    for format in ("text", "json"):
        assert command(robot, "gsn", "--format", format)[0] == 0


def test_the_document_fits_its_schema() -> None:
    from trackmarshal.trace.gsn.document import DEFAULT
    from trackmarshal.trace.schema import text

    jsonschema.validate(yaml.safe_load(DEFAULT.read_text("utf-8")), json.loads(text()))


@pytest.mark.parametrize(
    ("entry", "code"),
    [
        ("templates: [{name: a, element: claim, about: project, id: G-1, text: x}]", "T123"),
        ("templates: [{name: a, element: goal, about: subject, id: G-1, text: x}]", "T123"),
        ("templates: [{name: a, element: goal, about: project, id: G-1}]", "T120"),
        ("templates: [{name: a, element: goal, about: project, id: G-1, text: x, colour: red}]", "T121"),
        ("templates: [{name: A b, element: goal, about: project, id: G-1, text: x}]", "T124"),
        ("defeaters: [{id: D-1, challenges: G-Top, text: x, owner: y, state: closed}]", "T123"),
        ("templates: none", "T122"),
    ],
)
def test_a_document_that_cannot_be_read(robot: Path, entry: str, code: str, tmp_path: Path) -> None:
    root = tmp_path / "project"
    shutil.copytree(robot, root)
    (root / "requirements" / "argument.yaml").write_text(f"document: argument\ntitle: x\n{entry}\n", "utf-8")
    status, _, err = command(root, "gsn", "--gate")
    assert status == 1
    assert "requirements/argument.yaml:3" in err
    assert f"error[{code}]" in err
