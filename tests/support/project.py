"""A copy of the shipped project that a test may edit, and the command run on it."""

from __future__ import annotations

import contextlib
import io
import shutil
from pathlib import Path

from support.shared import REPOSITORY
from trackmarshal.cli.main import main

#: What makes the project: everything that requirements name.
PARTS = ("specs", "requirements", "docs", "tests", "engine", "README.md", "CONTRIBUTING.md", "pyproject.toml", "Makefile")


def copy_project(target: Path) -> Path:
    """Specs and requirements as copies; the rest, which requirements only point to, as links."""
    target.mkdir()
    for part in PARTS:
        source = REPOSITORY / part
        if part in ("specs", "requirements"):
            shutil.copytree(source, target / part)
        else:
            (target / part).symlink_to(source)
    return target


def command(project: Path, *arguments: str) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of `trackmarshal ... --project PROJECT`."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main([*arguments, "--project", str(project)])
    return status, out.getvalue(), err.getvalue()
