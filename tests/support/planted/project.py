"""The project that faults are planted into: made once, then copied."""

from __future__ import annotations

import json
import re
import shutil
from datetime import date
from pathlib import Path
from typing import Any

from support.planted.edits import TODAY, run_git
from support.project import command

SOURCE = Path(__file__).parents[1] / "shuttle"


def make(folder: Path) -> Path:
    """The shuttle in a git repository of its own, its baseline accepted, its evidence in the store."""
    root = folder / "shuttle"
    shutil.copytree(SOURCE, root)
    run_git(root, "init", "-q", "--template=")  # no files that every copy has and nothing reads
    day = ("--day", TODAY.isoformat())
    who = ("--by", "Sam Safety", "--reason", "the first one")
    status, _, err = command(root, "trace", "--accept-baseline", *who, *day)
    assert status == 0, err
    run_git(root, "add", ".")
    run_git(root, "commit", "-qm", "The shuttle")
    run_git(root, "gc", "-q")  # one file of objects, not a folder for each
    status, out, err = command(root, "trace", "--gate", *day)
    assert status == 0, out + err
    return root


def judged(root: Path, rerun: bool = False, today: date = TODAY) -> tuple[int, list[dict[str, Any]]]:
    """The gate's exit status, and all that is found."""
    more = ("--rerun",) if rerun else ()
    status, out, err = command(root, "trace", "--gate", "--format", "json", "--day", today.isoformat(), *more)
    try:
        return status, json.loads(out)["findings"]
    except ValueError:
        code = re.match(r"error\[([A-Z][0-9]+)\]", err)
        assert code is not None, err
        return status, [{"code": code[1], "level": "error", "subject": None, "cause": None, "message": err}]


def causes(found: list[dict[str, Any]]) -> list[tuple[str, str]]:
    """Code and subject of what stands for itself; notes aside."""
    return [(f["code"], f["subject"] or "") for f in found if f["cause"] is None and f["level"] != "note"]
