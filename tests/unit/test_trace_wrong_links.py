"""A link of a spec that leads nowhere is one finding of the matrix, whoever finds it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

from support.project import command

WRONG = Path(__file__).parents[1] / "golden" / "semantics" / "unknown_requirement"


def test_a_link_that_leads_nowhere_is_reported_once(tmp_path: Path) -> None:
    """The rule in line 5 is in the matrix, which misses its requirement; the one in line 7 has an error and is not."""
    project = tmp_path / "project"
    shutil.copytree(WRONG, project)
    status, out, _ = command(project, "trace", "--as-is", "--format", "json", "--gate")
    assert status == 1
    findings = json.loads(out)["findings"]
    links = [
        (found["code"], found["span"])
        for found in findings
        if found["code"] in ("E206", "T201", "T203", "T210")
    ]
    assert sorted(links) == [
        ("E206", "specs/main.spec:8:22"), ("E206", "specs/main.spec:8:30"), ("T201", "specs/main.spec:6:13")
    ]  # fmt: skip
