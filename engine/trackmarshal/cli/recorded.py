"""In which commits records of a document stand, as version control knows it: who wrote them, when, and whether the commit is signed."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from typing import Any

from trackmarshal.cli.git import asking, cut, surroundings
from trackmarshal.trace.case.inputs import Recorded

#: What git calls the commit of lines that are in none yet.
_NONE = "0" * 40
#: The name may be empty, and a zone of any length, in what was imported from elsewhere.
_AUTHOR = re.compile(r"^author (.*?) ?<.*> (-?[0-9]+) ([+-][0-9]+)$", re.MULTILINE)
#: Minutes of a day, of which a zone has less.
_DAY = 24 * 60
_ENCODING = re.compile(rb"^encoding ([^\n]+)$", re.MULTILINE)


def recorded(root: Path, places: Mapping[str, tuple[str, int]]) -> dict[str, Recorded]:
    """By name, the last commit that changed any line of the record whose id stands at a place (path from the project, line from 1); empty where git
    knows none of it, or some of it is in none, or in one before those that a shallow clone has.

    Whether a commit carries a signature is a part of it, the same on every machine; whose it is and whether it is good, `git verify-commit` says
    with the keys of whoever asks.
    """
    found: dict[str, Recorded] = {}
    try:
        older = cut(root)
    except (OSError, subprocess.SubprocessError):
        return found
    for file in sorted({file for file, _ in places.values()}):
        lines = _blame(root, file)
        records = _records(root / file) if lines else {}
        for name, (of, line) in places.items():
            if of != file or line not in lines:
                continue
            first, last = records.get(line, (line, line))
            commits = {lines[n] for n in range(first, last + 1) if n in lines}
            unknown = _NONE in commits or commits & older
            found[name] = Recorded("", "", "", False) if unknown else _last(root, sorted(commits))
    return found


def _blame(root: Path, file: str) -> dict[int, str]:
    """By line the commit; none is passed over, whatever is configured."""
    said = _git(root, "blame", "--ignore-revs-file=", "--line-porcelain", "--", file)
    head = re.compile(r"^([0-9a-f]{40}|[0-9a-f]{64}) [0-9]+ ([0-9]+)(?: [0-9]+)?$", re.MULTILINE)
    return {int(match[2]): match[1] for match in head.finditer(said)}


def _records(path: Path) -> dict[int, tuple[int, int]]:
    """By line of its `id`, the first and the last line of every record in a document."""
    import yaml

    try:
        tree = yaml.compose(path.read_text("utf-8-sig"), Loader=yaml.CSafeLoader)
    except (OSError, ValueError, yaml.YAMLError):
        return {}
    found: dict[int, tuple[int, int]] = {}
    waiting: list[Any] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                waiting.append(value)
                if key.value == "id":
                    found[value.start_mark.line + 1] = (node.start_mark.line + 1, _end(node))
        elif isinstance(node, yaml.SequenceNode):
            waiting += node.value
    return found


def _end(node: Any) -> int:
    """The last line of a node; behind what ends with a line, the mark is at the start of the next."""
    parts = (
        [part for pair in node.value for part in (pair if isinstance(pair, tuple) else (pair,))]
        if not isinstance(node.value, str)
        else []
    )
    if parts:
        return max(map(_end, parts))
    return int(node.end_mark.line + (node.end_mark.column > 0 or node.end_mark.line == node.start_mark.line))


def _last(root: Path, commits: list[str]) -> Recorded:
    """The commit that comes after the others, with its author as it says: no file of a project gives authors other names."""
    last = commits[0]
    if len(commits) > 1:
        last = _git(root, "rev-list", "--topo-order", "--max-count=1", *commits).strip() or last
    head = _head(root, last)
    author = _AUTHOR.search(head)
    if author is None:
        return Recorded("", "", "", False)
    signed = any(line.startswith(("gpgsig ", "gpgsig-sha256 ")) for line in head.split("\n"))
    return Recorded(last, author[1], _day(int(author[2]), author[3]), signed)


def _head(root: Path, commit: str) -> str:
    """What a commit says before its message, in the encoding that it names."""
    head = _bytes(root, "cat-file", "commit", commit).partition(b"\n\n")[0]
    named = _ENCODING.search(head)
    try:
        return head.decode("utf-8" if named is None else named[1].decode("ascii"))
    except (ValueError, LookupError):
        return head.decode("utf-8", "replace")


def _day(seconds: int, zone: str) -> str:
    """The day on which an author wrote, where the author was; the time as git has it where it is on no day, and in UTC where the zone is none."""
    minutes = int(zone[1:-2] or 0) * 60 + int(zone[-2:])
    there = (
        timedelta(minutes=-minutes if zone.startswith("-") else minutes) if minutes < _DAY else timedelta()
    )
    try:
        return datetime.fromtimestamp(seconds, UTC).astimezone(timezone(there)).date().isoformat()
    except (ValueError, OverflowError, OSError):
        return f"@{seconds}"


def _git(root: Path, *arguments: str) -> str:
    """What git says of what is recorded, and of nothing that stands in its place here; "" where it is not there or refuses."""
    return _bytes(root, *arguments).decode("utf-8", "replace")


def _bytes(root: Path, *arguments: str) -> bytes:
    """The same, as it stands there."""
    try:
        done = subprocess.run(asking(root, *arguments), capture_output=True, check=False, env=surroundings())
    except OSError:
        return b""
    return done.stdout if done.returncode == 0 else b""


__all__ = ["recorded"]
