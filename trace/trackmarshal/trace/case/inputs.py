"""All that the document is made of: what `trace` knows, and what the engine says of each rule for readers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from trackmarshal.records.runs import RunSummary
from trackmarshal.records.specs import SpecItem, SpecTest
from trackmarshal.records.tests import TestResult
from trackmarshal.trace.case.loop import Loop
from trackmarshal.trace.gsn.case import Case
from trackmarshal.trace.matrix import Matrix
from trackmarshal.trace.model import Project


class Recorded(NamedTuple):
    """The commit in which a record was last changed; commit: "" for one that is in none that is known here; signed: whether the commit carries a signature."""

    commit: str
    author: str
    day: str
    signed: bool


@dataclass(frozen=True)
class Inputs:
    """Nothing in it is of the machine or the hour, so equal inputs make equal documents.

    sheets: by rule or assumption, what `trackmarshal show RULE --format json` says. commit: of the project, `+` behind it where files differ from
    it, "" where there is none. hashes: sha256 by path of the files of `requirements/`. faults: rows of `trackmarshal.trace.fault_rows`. drawings: by rule or
    assumption, what `trackmarshal.reading.drawing` says of it, and its `sha`.
    """

    matrix: Matrix
    argument: Case
    project: Project
    items: Sequence[SpecItem]
    tests: Sequence[SpecTest]
    results: Sequence[TestResult]
    runs: Sequence[RunSummary]
    faults: Sequence[Mapping[str, str]]
    sheets: Mapping[str, Mapping[str, Any]]
    commit: str
    tool: str
    engine: str  #: the version with a hash of the sources that read and evaluate rules
    specs: str  #: fingerprint of all specs
    hashes: Mapping[str, str] = field(default_factory=dict)
    drawings: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    loop: Loop | None = None  #: kept results of runs in a closed loop
    recorded: Mapping[str, Recorded] = field(default_factory=dict)  #: by review, the commit that it stands in
    asked: str = (
        ""  #: words or templates that were asked for in place of the project's, as options of the command
    )
    lacking: bool = (
        False  #: whether evidence is missing or stale, so that running it may come to another document
    )
    draw: bool = True  #: whether the argument is drawn, which takes the extra `gsn`


__all__ = ["Inputs", "Recorded"]
