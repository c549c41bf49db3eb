"""A small project that is green from the start: a contract, a rule with its tests, why it is there, and a scenario in which it fires."""

from __future__ import annotations

import json
from pathlib import Path

from trackmarshal.start.writing import render, write_new

#: What runs the gate on GitHub, from the root of the repository.
WORKFLOW = ".github/workflows/trackmarshal.yml"
#: Where each file of a new project comes from. Those that end in .j2 name the project, or where it is.
FILES = {
    "README.md": "project/README.md.j2",
    ".gitignore": "project/gitignore",
    WORKFLOW: "project/workflow.yml.j2",
    "requirements/requirements.yaml": "project/requirements.yaml",
    "requirements/v-model.yaml": "project/v-model.yaml.j2",
    "specs/signals.spec": "project/signals.spec",
    "specs/speed.spec": "project/speed.spec",
    "specs/supervisor/limits.spec": "project/limits.spec",
    "specs/scenarios/too_fast.yaml": "project/too_fast.yaml",
    "specs/tracks/straight.yaml": "project/straight.yaml",
}

#: What `trace --accept-baseline` writes of it.
BASELINE = "requirements/baseline.json"


def init(root: Path, folder: str = "") -> list[Path]:
    """Write a new project into a folder, which is made if need be; its files. Raises E412 where one of them is there.

    folder: the project's in its repository, where it is not the repository itself: the workflow runs there.
    """
    title = "".join(char if char.isprintable() else "?" for char in root.resolve().name).strip() or "project"
    name = json.dumps(title)  # in YAML, too, a text whatever characters it has
    return write_new(
        root,
        {path: render(template, name=name, title=title, folder=folder) for path, template in FILES.items()},
    )
