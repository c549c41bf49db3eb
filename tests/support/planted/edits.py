"""What is done to a project: each edit is made once, as data, and done to as many copies as one likes."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

from support.project import command

Edit = Callable[[Path], None]
#: The day on which faults are planted, unless they say another one: waivers hold, reviews are made.
TODAY = date(2026, 6, 2)
STORE = "out/results/evidence.jsonl"
BASELINE = "requirements/baseline.json"
#: Of whoever commits in a test.
AUTHOR = (
    "-c",
    "user.name=Dana Driver",
    "-c",
    "user.email=dana@shuttle.example",
    "-c",
    "commit.gpgsign=false",
)


@dataclass(frozen=True)
class Fault:
    """An edit, and the one cause that is found of it: its code and its subject ("": it is about a file).

    rerun: somebody made hashes again by hand, which `--rerun` finds. status: of `trace --gate`.
    """

    name: str
    edit: Edit
    code: str
    subject: str = ""
    rerun: bool = False
    status: int = 1
    today: date = TODAY


@dataclass(frozen=True)
class Harmless:
    """An edit of which nothing follows."""

    name: str
    edit: Edit


def swap(file: str, old: str, new: str) -> Edit:
    """Replace a text that occurs exactly once."""

    def edit(root: Path) -> None:
        text = (root / file).read_text("utf-8")
        assert text.count(old) == 1, f"{old!r} occurs {text.count(old)} times in {file}"
        (root / file).write_text(text.replace(old, new), "utf-8")

    return edit


def each(file: str, old: str, new: str) -> Edit:
    """Replace a text wherever it occurs."""

    def edit(root: Path) -> None:
        text = (root / file).read_text("utf-8")
        assert old in text, f"{old!r} does not occur in {file}"
        (root / file).write_text(text.replace(old, new), "utf-8")

    return edit


def cut(file: str, begin: str, end: str) -> Edit:
    """Take out what stands from one text, which occurs once, to the next occurrence of another, or to the end if that is ""."""

    def edit(root: Path) -> None:
        text = (root / file).read_text("utf-8")
        assert text.count(begin) == 1, f"{begin!r} occurs {text.count(begin)} times in {file}"
        start = text.index(begin)
        stop = text.index(end, start + len(begin)) if end else len(text)
        (root / file).write_text(text[:start] + text[stop:], "utf-8")

    return edit


def add(file: str, text: str) -> Edit:
    """Write a text at the end of a file, which need not be there."""

    def edit(root: Path) -> None:
        (root / file).parent.mkdir(parents=True, exist_ok=True)
        with (root / file).open("a", encoding="utf-8") as stream:
            stream.write(text)

    return edit


def put(file: str, data: bytes) -> Edit:
    """Make a file these bytes."""

    def edit(root: Path) -> None:
        (root / file).parent.mkdir(parents=True, exist_ok=True)
        (root / file).write_bytes(data)

    return edit


def remade(file: str, change: Callable[[bytes], bytes]) -> Edit:
    """Make a file's bytes other ones."""

    def edit(root: Path) -> None:
        before = (root / file).read_bytes()
        after = change(before)
        assert after != before, f"{file} is the same"
        (root / file).write_bytes(after)

    return edit


def gone(*names: str) -> Edit:
    """Remove files and folders."""

    def edit(root: Path) -> None:
        for name in names:
            path = root / name
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()

    return edit


def moved(old: str, new: str) -> Edit:
    """Give a file another name."""

    def edit(root: Path) -> None:
        (root / new).parent.mkdir(parents=True, exist_ok=True)
        (root / old).rename(root / new)

    return edit


def copied(old: str, new: str) -> Edit:
    """The same file a second time."""

    def edit(root: Path) -> None:
        shutil.copyfile(root / old, root / new)

    return edit


def all_of(*edits: Edit) -> Edit:
    """One edit after the other."""

    def edit(root: Path) -> None:
        for one in edits:
            one(root)

    return edit


def agreed(edit: Edit) -> Edit:
    """An edit that a person accepted by name."""

    def both(root: Path) -> None:
        edit(root)
        who = ("--by", "Sam Safety", "--reason", "it is not needed", "--day", TODAY.isoformat())
        status, _, err = command(root, "trace", "--accept-baseline", *who)
        assert status == 0, err

    return both


def git(*words: str) -> Edit:
    """`git ...` in the project's folder."""

    def edit(root: Path) -> None:
        run_git(root, *words)

    return edit


def run_git(root: Path, *words: str) -> str:
    done = subprocess.run(
        ["git", "-C", str(root), *AUTHOR, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def committed(message: str) -> Edit:
    """Commit whatever was changed."""
    return git("commit", "-qam", message)


def entry(kind: str, subject: str, change: Callable[[dict[str, Any]], None], rehash: bool) -> Edit:
    """Change the last entry of a subject in the evidence store; with `rehash`, so that nobody sees it on the line."""

    def edit(root: Path) -> None:
        lines = (root / STORE).read_text("utf-8").splitlines()
        number = max(
            n
            for n, line in enumerate(lines)
            if (said := json.loads(line))["kind"] == kind and said["subject"] == subject
        )
        said = json.loads(lines[number])
        id_ = said.pop("id")
        before = json.dumps(said, sort_keys=True)
        change(said)
        assert json.dumps(said, sort_keys=True) != before
        rest = json.dumps(said, ensure_ascii=False, sort_keys=True)[1:]
        lines[number] = f'{{"id": "{hashlib.sha256(rest.encode()).hexdigest() if rehash else id_}", {rest}'
        (root / STORE).write_text("\n".join(lines) + "\n", "utf-8")

    return edit


def accepted(change: Callable[[dict[str, Any]], None], rehash: bool) -> Edit:
    """Change what the baseline holds; with `rehash`, so that its last acceptance seems to be of that."""

    def edit(root: Path) -> None:
        held = json.loads((root / BASELINE).read_text("utf-8"))
        before = json.dumps(held, sort_keys=True)
        change(held)
        assert json.dumps(held, sort_keys=True) != before
        if rehash:
            said = json.dumps(held["content"], sort_keys=True, ensure_ascii=False)
            held["acceptances"][-1]["after"] = hashlib.sha256(said.encode()).hexdigest()
        (root / BASELINE).write_text(json.dumps(held, indent=1, ensure_ascii=False) + "\n", "utf-8")

    return edit
