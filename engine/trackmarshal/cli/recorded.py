"""In which commits the lines of a file stand, as version control knows it: who wrote them, when, and whether the commit is signed."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

from trackmarshal.trace.case.inputs import Recorded

#: What git calls the commit of lines that are in none yet.
_NONE = "0" * 40


def recorded(root: Path, places: Mapping[str, tuple[str, int]]) -> dict[str, Recorded]:
    """By name, the commit of the line at a place (path from the project, line from 1); empty where git knows none of it.

    Whether a commit carries a signature is a part of it, the same on every machine; whose it is and whether it is good, `git verify-commit` says
    with the keys of whoever asks.
    """
    found: dict[str, Recorded] = {}
    signed: dict[str, bool] = {}
    for file in sorted({file for file, _ in places.values()}):
        lines = _blame(root, file)
        for name, (of, line) in places.items():
            if of != file or line not in lines:
                continue
            commit, author, day = lines[line]
            if commit == _NONE:
                found[name] = Recorded("", "", "", False)
                continue
            if commit not in signed:
                signed[commit] = _signed(root, commit)
            found[name] = Recorded(commit, author, day, signed[commit])
    return found


def _blame(root: Path, file: str) -> dict[int, tuple[str, str, str]]:
    """By line: commit, author, and the author's day."""
    said = _git(root, "blame", "--line-porcelain", "--", file)
    found: dict[int, tuple[str, str, str]] = {}
    commit, line, author, seconds, zone = "", 0, "", 0, "+0000"
    for text in said.split("\n"):
        word, _, rest = text.partition(" ")
        if text.startswith("\t"):
            found[line] = commit, author, _day(seconds, zone)
        elif len(word) == 40 and rest:
            commit, line = word, int(rest.split()[1])
        elif word == "author":
            author = rest
        elif word == "author-time":
            seconds = int(rest)
        elif word == "author-tz":
            zone = rest
    return found


def _day(seconds: int, zone: str) -> str:
    """The day on which an author wrote, where the author was."""
    minutes = int(zone[1:3]) * 60 + int(zone[3:5])
    there = timezone(timedelta(minutes=-minutes if zone.startswith("-") else minutes))
    return datetime.fromtimestamp(seconds, UTC).astimezone(there).date().isoformat()


def _signed(root: Path, commit: str) -> bool:
    """Whether the head of a commit has a signature."""
    head = _git(root, "cat-file", "commit", commit).partition("\n\n")[0]
    return any(line.startswith(("gpgsig ", "gpgsig-sha256 ")) for line in head.split("\n"))


def _git(root: Path, *arguments: str) -> str:
    """What git says; "" where it is not there or refuses."""
    command: Iterable[str] = ["git", "-C", str(root), *arguments]
    try:
        done = subprocess.run(list(command), capture_output=True, check=False)
    except OSError:
        return ""
    return done.stdout.decode("utf-8", "replace") if done.returncode == 0 else ""


__all__ = ["recorded"]
