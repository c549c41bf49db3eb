"""The project a verb works on: the folder with `requirements/v-model.yaml`, searched upwards as git does."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.trace.model import Project

CODES = {
    "E410": (
        "no project here",
        "A project is a folder with requirements/v-model.yaml. Verbs without a PATH work on the project that the current folder is in; "
        "`--project DIR` names another.",
    ),
    "E411": (
        "the system refuses",
        "A file or a folder cannot be read or written: it is not there, its permissions forbid it, or the disk is full.",
    ),
}
MARKER = Path("requirements") / "v-model.yaml"


def find_project(args: argparse.Namespace) -> Path:
    """The project's folder; raises E410 when there is none."""
    project = optional_project(args)
    if project is None:
        raise TrackmarshalError(
            "E410",
            f"no {MARKER} in {Path.cwd()} or above",
            help="go into a project, or name one with --project DIR",
        )
    return project


def from_project(root: Path, path: Path | str) -> str:
    """A path from the project, with forward slashes, wherever it leads."""
    return Path(os.path.relpath(os.path.abspath(path), root)).as_posix()


def optional_project(args: argparse.Namespace) -> Path | None:
    """The project's folder, or None; a folder named with --project must be one."""
    if args.project is not None:
        root = Path(args.project)
        if not (root / MARKER).is_file():
            raise TrackmarshalError(
                "E410", f"{root} has no {MARKER}", help="--project names a project's folder"
            )
        return root.resolve()
    return project_of(Path.cwd())


def project_of(folder: Path) -> Path | None:
    """The project that a folder is in, or None."""
    here = folder.resolve()
    return next((folder for folder in (here, *here.parents) if (folder / MARKER).is_file()), None)


def spec_folders(project: Path, known: Project | None = None) -> list[Path]:
    """The folders that the project names as its specs: those of which `assess` and `trace` ask for tests. known: its V-model, where that was read.

    Where the V-model cannot be read so far, `specs`; raises what is wrong with it where that is not there either.
    """
    from trackmarshal.trace import requirements
    from trackmarshal.trace.findings import Finding

    wrong: list[Finding] = []
    named = (known or requirements.load(project, wrong)).specs
    usual = project / "specs"
    if not named and not usual.exists():
        if known is not None:
            requirements.load(project, wrong)
        for each in wrong:
            if each.level == "error" and each.place is not None and each.place.file == MARKER.as_posix():
                place = each.place
                raise TrackmarshalError(
                    each.code, each.message, file=place.file, line=place.line, help=each.help
                )
    return [project / str(path) for path in named] or [usual]
