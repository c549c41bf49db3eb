"""This project assessed with few scenarios and without faults: the pages that an assessor opens, in a fraction of the time."""

from __future__ import annotations

import json
from pathlib import Path

import yaml

from support.project import command, copy_project

#: Runs in which friction decides, and in which nothing does.
SCENARIOS = ("overreach", "free_lap")


def assessed(folder: Path) -> tuple[Path, Path]:
    """The project, and the folder of its pages."""
    project = copy_project(folder / "project")
    path = project / "requirements" / "v-model.yaml"
    model = yaml.safe_load(path.read_text("utf-8"))
    settings = model["project"]
    settings["scenarios"] = [
        one for one in settings["scenarios"] if any(name in one["path"] for name in SCENARIOS)
    ]
    assert len(settings["scenarios"]) == len(SCENARIOS)
    del settings["campaigns"]
    path.write_text(json.dumps(model, default=str), "utf-8")  # JSON is YAML
    pages = folder / "pages"
    status, _, err = command(project, "assess", "--out", str(pages), "--quiet")
    assert status in (0, 1), err  # 1: what was left out is missing now
    return project, pages
