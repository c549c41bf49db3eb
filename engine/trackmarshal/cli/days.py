"""The day that a project is held against: that of the clock, one that is named, or that of the commit, on which every later run says the same."""

from __future__ import annotations

import argparse
import subprocess
import sys
from datetime import date, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.git import answer, cut, refused
from trackmarshal.cli.output import say
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.trace import Finding

CODES = {
    "T348": (
        "a day that is none",
        "`--day` takes a day, YYYY-MM-DD, or `commit`, the day on which the commit was made that is checked out. There is no such day in the "
        "calendar, or there is no commit: git is missing, the project is in no repository, or nothing is committed yet; or the commit says that it was "
        "made on a day that is yet to come. A commit that says it was made before one that it comes after was not: the latest day of them counts. In a shallow "
        "clone these are not at hand, and a warning says so.",
    ),
}
COMMIT = "commit"
#: So many commits before the one that is checked out are asked for their days, too.
_BEFORE = 2_000


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--day",
        metavar="DAY",
        help="the day that waivers are held against, YYYY-MM-DD, or `commit`: that of the commit (default: today)",
    )


def day(said: str | None, root: Path) -> date:
    """The day that `--day` says of a project in a folder; raises T348."""
    if said is None:
        return date.today()
    text = _of_commit(root) if said == COMMIT else said
    try:
        found = date.fromisoformat(text)
        if found.isoformat() != text:  # the calendar has other notations, which are not meant
            raise ValueError
        return found
    except ValueError:
        raise TrackmarshalError(
            "T348", f"`{said}` is no day", help="such as `2026-01-31`, or `commit`"
        ) from None


def doubts(said: str | None, found: date, root: Path) -> list[Finding]:
    """T348, as a warning, where the day of a commit was found in a shallow clone: one that it comes after may have a later day, and is not there."""
    from trackmarshal.trace.findings import warning

    if said != COMMIT or found >= date.today():
        return []
    if not cut(root):
        return []
    message = f"that the commit was made on {found} is what it says: the history of the clone is cut, and with it the days of what it comes after"
    return [warning("T348", message, None, "`git fetch --unshallow`, or name a day")]


def warn(said: str | None, found: date, root: Path) -> None:
    """Say that beside what a command writes, which has no findings in it."""
    for doubt in doubts(said, found, root):
        say(*str(doubt).split("\n"), file=sys.stderr)


def _of_commit(root: Path) -> str:
    """The day of the checked-out commit, where its committer was: whoever dates it back would have waivers hold that have expired, so that it is
    no earlier than those that it comes after; of them, what a wrong clock says is yet to come is left out."""
    try:
        days = answer(root, "log", f"--max-count={_BEFORE}", "--format=%cs").split()
    except (OSError, subprocess.SubprocessError) as problem:
        why, help_ = refused(problem)
        raise TrackmarshalError(
            "T348",
            f"there is no commit whose day it could be: {why}",
            help=help_ or "name a day, `--day 2026-01-31`",
        ) from None
    latest = (date.today() + timedelta(days=1)).isoformat()  # where the committer was, it may be tomorrow
    if days[0] > latest:
        message = f"the commit says that it was made on {days[0]}, which is yet to come"
        raise TrackmarshalError("T348", message, help="set the clock, and commit again; or name a day")
    return max(one for one in days if one <= latest)


__all__ = ["CODES", "COMMIT", "configure", "day", "doubts", "warn"]
