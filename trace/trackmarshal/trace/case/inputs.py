"""All that the document is made of: what `trace` knows, and what the engine says of each rule for readers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from trackmarshal.records import RunSummary, SpecItem, SpecTest, TestResult
from trackmarshal.trace.gsn.case import Case
from trackmarshal.trace.matrix import Matrix
from trackmarshal.trace.model import Project


@dataclass(frozen=True)
class Inputs:
    """Nothing in it is of the machine or the hour, so equal inputs make equal documents.

    sheets: by rule or assumption, what `trackmarshal show RULE --format json` says. commit: of the project, `+` behind it where files differ from
    it, "" where there is none. hashes: sha256 by path of the files of `requirements/`. faults: rows of `trackmarshal.trace.fault_rows`.
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
    draw: bool = True  #: whether the argument is drawn, which takes the extra `gsn`


__all__ = ["Inputs"]
