"""What the matrix page shows beside the matrix: rules for readers, runs, entries of the evidence store, other pages, another baseline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from trackmarshal.records.runs import RunSummary
from trackmarshal.store import Entry
from trackmarshal.trace.baseline import Change


@dataclass(frozen=True, slots=True)
class Compared:
    """What is different between two baselines, and what these are called."""

    before: str
    now: str
    changes: tuple[Change, ...]


@dataclass(frozen=True, slots=True)
class Beside:
    """Whatever of it is not given is not shown, but for what the page says is not there.

    sheets: by rule or assumption, what `trackmarshal show RULE --format json` says. tests: by rule and title, the lines of a test. entries: of the
    evidence store, by kind and subject. pages: by scenario, the address of the run's page. index: the address of the page above.
    drawings: by rule or assumption, where it ceases to be met, as SVG that stands by itself; undrawn: why there is no such picture. clauses: the words of
    kinds of clauses. compared: in place of the difference from the accepted baseline.
    """

    sheets: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    clauses: Mapping[str, str] = field(default_factory=dict)
    drawings: Mapping[str, str] = field(default_factory=dict)
    undrawn: Mapping[str, str] = field(default_factory=dict)
    tests: Mapping[tuple[str, str], str] = field(default_factory=dict)
    runs: Sequence[RunSummary] = ()
    entries: Mapping[tuple[str, str], Entry] = field(default_factory=dict)
    pages: Mapping[str, str] = field(default_factory=dict)
    index: str = ""
    compared: Compared | None = None


__all__ = ["Beside", "Compared"]
