"""The README's rule: one edit of one file, and it appears in check, replay and matrix."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from support.project import command, copy_project
from support.shared import REPOSITORY

README = (REPOSITORY / "README.md").read_text("utf-8")


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project with the README's rule added to the file that the README names."""
    root = copy_project(tmp_path_factory.mktemp("readme") / "project")
    rule = re.search(r"```\n(rule start_speed .*?)```", README, re.DOTALL)
    file = re.search(r"add this to `([^`]+)`", README)
    assert rule is not None
    assert file is not None
    path = root / file.group(1)
    path.write_text(path.read_text("utf-8") + "\n" + rule.group(1), encoding="utf-8")
    return root


def test_check_knows_it(project: Path) -> None:
    before = command(REPOSITORY, "check")[1]
    status, after, _ = command(project, "check")
    assert status == 0
    count = int(re.search(r"(\d+) rules", before)[1])  # type: ignore[index]
    assert f"{count + 1} rules" in after


def test_replay_shows_when_it_fires(project: Path) -> None:
    recording = str(project / "specs" / "scenarios" / "cut_in.tmrec.jsonl")
    _, lines, _ = command(project, "replay", recording, "--format", "jsonl")
    verdicts = [json.loads(line)["rules"]["start_speed"]["verdict"] for line in lines.splitlines()]
    assert "violated" in verdicts  # the scenario starts at the line, at 34 m/s
    assert "inactive" in verdicts  # and leaves it behind


def test_matrix_lists_it_under_its_requirement_and_asks_for_tests(project: Path) -> None:
    _, text, _ = command(project, "trace", "--format", "json", "--as-is")
    matrix = json.loads(text)
    row = next(r for r in matrix["requirements"] if r["id"] == "RR-1")
    assert "start_speed" in json.dumps(row["stages"]["S-2-B"])
    assert any("start_speed" in f["message"] and f["level"] == "error" for f in matrix["findings"])
