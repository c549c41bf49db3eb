"""A copy of the shipped project that a test may edit, and the command run on it."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
from functools import cache
from pathlib import Path

from support.schemas import hold
from support.shared import REPOSITORY
from trackmarshal.cli.main import main

#: What makes the project: specs, requirements, and the documents that they name.
PARTS = ("specs", "requirements", "docs")


def copy_project(target: Path) -> Path:
    """A project of its own, without results."""
    for part in PARTS:
        shutil.copytree(REPOSITORY / part, target / part)
    for name in _named_in_tests():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(REPOSITORY / name, target / name)
    (target / "engine").symlink_to(REPOSITORY / "engine")  # source code that says what it implements
    return target


@cache
def _named_in_tests() -> tuple[str, ...]:
    """The files of tests that documents of the project name as evidence or as kept results."""
    texts = (
        (REPOSITORY / "requirements" / name).read_text("utf-8") for name in ("tools.yaml", "v-model.yaml")
    )
    return tuple(sorted(set(re.findall(r"(?<!/)\btests/[\w/]+\.(?:py|json)\b", "\n".join(texts)))))


def command(project: Path, *arguments: str) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of `trackmarshal ... --project PROJECT`."""
    return run_command(*arguments, "--project", str(project))


def run_command(*arguments: str) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of `trackmarshal ...`, in this process. What is for machines is held against its schema."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main([*arguments])
    hold(arguments, out.getvalue())
    return status, out.getvalue(), err.getvalue()
