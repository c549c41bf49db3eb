"""docs/exchange.md word for word: its commands, its file, what becomes of it."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest

from trackmarshal.cli.main import main

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
