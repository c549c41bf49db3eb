"""`trace --gate` passes on the shipped project, and fails when a rule, a test of a rule or an interface is taken away."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.project import command, copy_project
from support.shared import REPOSITORY

#: All evidence of the project is made for it. Every day `make gate` does that, and gaps are planted in a small project (test_planted_faults.py).
pytestmark = pytest.mark.acceptance

SPECS = sorted((REPOSITORY / "specs" / "supervisor").glob("*.spec"))
_ITEM = re.compile(r"^(?:(rule|test|assume) ([\w-]+)(?: \"([^\"]*)\")?)", re.MULTILINE)
#: How a finding tells of a test that is gone: of the first of a rule, and of each further one.
_GONE = re.compile(
    r'the test "(?P<title>.*)" of `(?P<rule>.*?)` is gone since the baseline|test (?P<of>.*?): (?P<other>.*) is gone'
)
#: In so many runs every test is taken away once.
PARTS = 10
_START = re.compile(
    r"^(?:module|use|reference|signal|event|param|constrain|table|zone|line|define|predicate|assume|rule|state|rulebook|test)\b",
    re.MULTILINE,
)


def items(kind: str) -> list[tuple[str, str, int]]:
    """(file, name, offset) of every declaration of a kind in the Supervisor's specs."""
    found = []
    for path in SPECS:
        for match in _ITEM.finditer(path.read_text("utf-8")):
            if match.group(1) == kind:
                found.append((path.name, match.group(2), match.start()))
    return found


def without(text: str, start: int) -> str:
    """A spec without the declaration that starts at an offset."""
    following = _START.search(text, start + 1)
    return text[:start] + (text[following.start() :] if following else "")


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy with fresh evidence, on which the gate passes; it passes again when all that the tests changed is restored."""
    root = copy_project(tmp_path_factory.mktemp("gate") / "project")
    status, out, err = command(root, "trace", "--gate")
    assert status == 0, out + err
    yield root
    status, out, err = command(root, "trace", "--gate", "--as-is")
    assert status == 0, out + err


@pytest.fixture
def edited(project: Path) -> Iterator[Path]:
    """The project; what the test changes is restored."""
    kept = {
        path: path.read_bytes()
        for folder in ("specs", "requirements")
        for path in (project / folder).rglob("*")
        if path.is_file()
    }
    yield project
    for path, data in kept.items():
        path.write_bytes(data)


def gate(project: Path) -> int:
    """Exit status of the gate on the evidence that is there; unusable specs would be 2."""
    return command(project, "trace", "--gate", "--as-is")[0]


@pytest.mark.parametrize(("file", "name", "start"), items("rule"))
def test_without_a_rule(edited: Path, file: str, name: str, start: int) -> None:
    """With its tests, which would otherwise not compile, and out of the rulebook."""
    path = edited / "specs" / "supervisor" / file
    text = without(path.read_text("utf-8"), start)
    while True:
        test = next((m for m in _ITEM.finditer(text) if m.group(1) == "test" and m.group(2) == name), None)
        if test is None:
            break
        text = without(text, test.start())
    path.write_text(text, encoding="utf-8")
    (edited / "specs" / "rulebooks" / "supervisor.spec").unlink()
    assert gate(edited) == 1


@pytest.mark.parametrize(("file", "name", "start"), items("rule"))
def test_without_a_rule_that_tests_and_the_rulebook_still_name(
    edited: Path, file: str, name: str, start: int
) -> None:
    path = edited / "specs" / "supervisor" / file
    path.write_text(without(path.read_text("utf-8"), start), encoding="utf-8")
    assert gate(edited) == 1


@pytest.mark.parametrize("part", range(PARTS))
def test_without_tests(edited: Path, part: int) -> None:
    """The baseline knows them all: of those that are gone, each is told by its name."""
    gone, missing = set(), items("test")[part::PARTS]
    for file in {file for file, _, _ in missing}:
        path = edited / "specs" / "supervisor" / file
        text = path.read_text("utf-8")
        for start in sorted((start for where, _, start in missing if where == file), reverse=True):
            found = _ITEM.match(text, start)
            assert found
            gone.add((found.group(2), found.group(3)))
            text = without(text, start)
        path.write_text(text, encoding="utf-8")
    status, out, _ = command(edited, "trace", "--gate", "--as-is", "--format", "json")
    assert status == 1
    told = [finding for finding in json.loads(out)["findings"] if finding["code"] == "T221"]
    texts = [finding["message"] for finding in told] + [
        also["message"] for finding in told for also in finding["also"]
    ]
    assert gone == {
        (match.group("rule") or match.group("of"), match.group("title") or match.group("other"))
        for match in map(_GONE.match, texts)
        if match
    }


@pytest.mark.parametrize(
    "name",
    [
        "AV-SO", "AV-TP", "AV-TI", "AV-RO", "AV-DI", "AV-E",
    ],
)  # fmt: skip
def test_without_an_interface_of_a_requirement(edited: Path, name: str) -> None:
    path = edited / "requirements" / "s-1-a.yaml"
    text = path.read_text("utf-8")
    changed = re.sub(rf"(derived_from: \[[^\]]*?)(?:, {name}\b|\b{name}, |\b{name}\b)", r"\1", text, count=1)
    assert changed != text
    path.write_text(changed, encoding="utf-8")
    assert gate(edited) == 1


def test_without_an_interface_in_the_system_model(edited: Path) -> None:
    path = edited / "requirements" / "system-model.yaml"
    text = path.read_text("utf-8")
    entries = list(re.finditer(r"^  - id: (AV-\w+|AV)\n(?:    .*\n|\n(?=    ))*", text, re.MULTILINE))
    assert entries
    path.write_text(text[: entries[0].start()] + text[entries[0].end() :], encoding="utf-8")
    assert gate(edited) == 1


def test_nothing_is_wrong_with_the_argument(project: Path) -> None:
    status, out, err = command(project, "gsn", "--gate")
    assert status == 0, err
    assert err == "gate: passed\n"
    assert "G-Top: trackmarshal operates safely" in out


def test_a_failing_test_fails_the_gate(edited: Path) -> None:
    """Only it is run; the evidence of before is there for the spec of before. The argument says so up to its top goal."""
    path = edited / "specs" / "supervisor" / "conduct.spec"
    path.write_text(
        path.read_text("utf-8").replace("expect violated", "expect satisfied", 1), encoding="utf-8"
    )
    assert command(edited, "trace", "--gate")[0] == 1
    status, out, err = command(edited, "gsn", "--gate", "--module", "G-Top")
    assert status == 1
    assert "error[T413]" in err
    assert "✗ G-Top" in out
