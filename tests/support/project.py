"""A copy of the shipped project that a test may edit, and the command run on it."""

from __future__ import annotations

import contextlib
import io
import shutil
from pathlib import Path

from support.shared import REPOSITORY
from trackmarshal.cli.main import main

#: What makes the project: specs, requirements, and the documents that they name.
PARTS = ("specs", "requirements", "docs")


def copy_project(target: Path) -> Path:
    """A project of its own, without results."""
    for part in PARTS:
        shutil.copytree(REPOSITORY / part, target / part)
    (target / "engine").symlink_to(REPOSITORY / "engine")  # source code that says what it implements
    return target


def command(project: Path, *arguments: str) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of `trackmarshal ... --project PROJECT`."""
    return run_command(*arguments, "--project", str(project))


def run_command(*arguments: str) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of `trackmarshal ...`, in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main([*arguments])
    return status, out.getvalue(), err.getvalue()
