"""What `compile --target c --cycles` writes for the shipped rules and scenarios."""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path
from unittest import mock

from support.shared import REPOSITORY, SUPERVISOR
from trackmarshal.cli import compile as verb

SCENARIOS = sorted((REPOSITORY / "specs" / "scenarios").glob("*.tmrec.jsonl*"))


def name_of(recording: Path) -> str:
    return recording.name.partition(".")[0]


def emit(
    folder: Path,
    *more: str,
    recordings: list[Path] | None = None,
    spec: Path = SUPERVISOR,
    stack: bool = False,
    root: Path | None = None,
) -> Path:
    """The shipped Supervisor with all shipped scenarios, or others, written to a folder.

    stack: whether the report says how much of it is taken, for which gcc compiles all once more.
    root: what places in a spec of no project are told from, so that the same rules elsewhere are the same program.
    """
    parser = argparse.ArgumentParser()
    parser.add_argument("--project")
    parser.add_argument("--quiet", action="store_true")
    verb.configure(parser)
    given = SCENARIOS if recordings is None else recordings
    words = [str(spec), "--out", str(folder), "--quiet", *more]
    for path in given:
        words += ["--cycles", str(path)]
    untaken = mock.patch("trackmarshal.backends.c.report.stack", return_value=None)
    told = mock.patch.object(verb, "optional_project", return_value=root)
    with contextlib.nullcontext() if stack else untaken, contextlib.nullcontext() if root is None else told:
        assert verb.run(parser.parse_args(words)) == 0
    return folder
