"""What the pages of an assessment show beside the matrix: its checks, and a record of every run; kept in the user's cache from one
assessment to the next.

They are used again where everything that was read from the project is as it was, and tests came to the same.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trackmarshal import cache
from trackmarshal.records.tests import TestResult


@dataclass(frozen=True, slots=True)
class ShownRun:
    """The record of a scenario's run, and whether the run is as it was declared to be."""

    scenario: str
    met: bool
    record: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Shown:
    """How many modules were read, their fingerprint, rules whose boundary lacks a test, and the runs."""

    modules: int
    fingerprint: str
    uncovered: list[str]
    runs: list[ShownRun]


def kept(root: Path, state: str, results: Iterable[TestResult]) -> Shown | None:
    """What was kept of a project in this state, with tests that came to the same; None where there is nothing, or it was changed."""
    path = cache.of_project("shown", root)
    if path is None or not state:
        return None
    said = cache.kept(path)
    try:
        if said["key"] != key(state, results):
            return None
        runs = [ShownRun(**run) for run in said["runs"]]
        return Shown(said["modules"], said["fingerprint"], said["uncovered"], runs)
    except (KeyError, TypeError):
        return None


def keep(root: Path, state: str, results: Iterable[TestResult], shown: Shown) -> None:
    """Keep it for the next assessment, if it is known what it was made from."""
    path = cache.of_project("shown", root)
    if path is not None and state:
        runs = [{"scenario": run.scenario, "met": run.met, "record": run.record} for run in shown.runs]
        said = {
            "key": key(state, results),
            "modules": shown.modules,
            "fingerprint": shown.fingerprint,
            "uncovered": shown.uncovered,
        }
        cache.keep(path, {**said, "runs": runs})


def key(state: str, results: Iterable[TestResult]) -> str:
    """One hash of all that is shown: of what it is made from."""
    said = sorted([result.rule, result.title, result.outcome, result.unmoved] for result in results)
    return hashlib.sha256(json.dumps([state, said]).encode()).hexdigest()
