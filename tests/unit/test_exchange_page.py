"""docs/exchange.md word for word: its commands, its file, what becomes of it."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path
from typing import Any

import pytest

from trackmarshal.cli.main import main
from trackmarshal.trace.exchange.content import FIELDS, LISTS

ROOT = Path(__file__).parents[2]


def test_the_page_about_exchange(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (ROOT / "docs" / "exchange.md").read_text("utf-8")
    shutil.copytree(ROOT / "requirements", tmp_path / "requirements")
    monkeypatch.chdir(tmp_path)
    (given,) = re.findall(r"```csv\n(.*?)```", page, re.DOTALL)
    Path("doors.csv").write_text(given, encoding="utf-8")
    commands = [
        line for block in re.findall(r"```sh\n(.*?)```", page, re.DOTALL) for line in block.splitlines()
    ]
    assert len(commands) == 4
    for command in commands:
        assert main(shlex.split(command)[1:]) == 0, command
    (made,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    assert Path("requirements/doors.yaml").read_text("utf-8") == made
    assert {path.name for path in tmp_path.iterdir()} == {
        "requirements",
        "requirements.reqif",
        "needs.json",
        "requirements.csv",
        "doors.csv",
    }


def test_what_a_project_of_sphinx_needs_declares() -> None:
    """Each field but those that every need has, lists as lists: sphinx-needs 9.1 leaves out requirements with a list that is not declared as one."""
    page = (ROOT / "docs" / "exchange.md").read_text("utf-8")
    (conf,) = re.findall(r"```py\n(.*?)```", page, re.DOTALL)
    said: dict[str, Any] = {}
    exec(conf, said)
    fields = said["needs_fields"]
    assert {*fields, *said["needs_links"], "id", "title", "statement", "status"} == set(FIELDS)
    assert {name for name, how in fields.items() if "schema" in how} | {"refines"} == LISTS
    assert all(re.match(said["needs_id_regex"] + "$", id_) for id_ in ("RR-1", "S-1-A-4", "FSR-1-P"))
