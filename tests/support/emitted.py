"""What `compile --target c --cycles` writes for the shipped rules and scenarios."""

from __future__ import annotations

import argparse
from pathlib import Path

from support.shared import REPOSITORY, SUPERVISOR
from trackmarshal.cli import compile as verb
from trackmarshal.scenarios.recording import Recording

SCENARIOS = sorted((REPOSITORY / "specs" / "scenarios").glob("*.tmrec.jsonl*"))


def name_of(recording: Path) -> str:
    return recording.name.partition(".")[0]


def emit(folder: Path, *more: str, recordings: list[Path] | None = None, spec: Path = SUPERVISOR) -> Path:
    """The shipped Supervisor with all shipped scenarios, or others, written to a folder."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--project")
    parser.add_argument("--quiet", action="store_true")
    verb.configure(parser)
    given = SCENARIOS if recordings is None else recordings
    words = [str(spec), "--out", str(folder), "--quiet", *more]
    for path in given:
        words += ["--cycles", str(path)]
    assert verb.run(parser.parse_args(words)) == 0
    return folder


def tables_of(recording: Recording, known: set[str]) -> dict[str, list[list[float]]]:
    """The tables of a recording that a spec declares."""
    return {name: rows for name, rows in recording.tables.items() if name in known}
