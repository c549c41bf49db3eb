"""Paths in reports for whoever reviews a change: from the root of the repository, of which a project may be a folder."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from trackmarshal.errors import TrackmarshalError

CODES = {
    "T346": (
        "paths relative to nothing",
        "`--relative-to` names a folder from which the paths of a report count. It has to exist, and a format has to have such paths: "
        "those that code review reads do.",
    ),
}
#: What code review reads, where paths count from the root of the repository unless another folder is named.
IN_REVIEW = ("sarif", "github", "junit")


def configure_relative(parser: argparse.ArgumentParser) -> None:
    """`--relative-to`: from where paths in a report count."""
    parser.add_argument(
        "--relative-to",
        metavar="DIR",
        help=f"the folder that paths in the report are relative to (for {', '.join(IN_REVIEW)} default: the root of the git repository, if any)",
    )


def shown_from(
    args: argparse.Namespace, project: Path | None, formats: tuple[str, ...] = IN_REVIEW
) -> Callable[[str], str] | None:
    """What makes paths of reports, which count from the project, count from where `--relative-to` says; None: nothing is to be done.

    Raises T346 for a folder that is none, and for another format than `formats`.
    """
    base = (project or Path.cwd()).resolve()
    if args.relative_to is not None:
        if args.format not in formats:
            message = f"the format {args.format} has no paths that could be relative to a folder"
            raise TrackmarshalError("T346", message, help=f"formats that have: {', '.join(formats)}")
        target = Path(args.relative_to).resolve()
        if not target.is_dir():
            message = f"there is no folder {args.relative_to}"
            raise TrackmarshalError("T346", message, help="name the root of the repository")
    elif args.format in IN_REVIEW:
        target = repository(base) or base
    else:
        return None
    return None if target == base else lambda path: _moved(path, base, target)


def repository(folder: Path) -> Path | None:
    """The root of the git repository that a folder is in, or None; the folder need not be there yet."""
    return next((one for one in (folder, *folder.parents) if (one / ".git").exists()), None)


def _moved(path: str, base: Path, target: Path) -> str:
    """A path from another folder; what is no file here (a shipped spec, a text without a file) is called as it was."""
    whole = Path(os.path.normpath(base / path))
    return Path(os.path.relpath(whole, target)).as_posix() if whole.exists() else path
