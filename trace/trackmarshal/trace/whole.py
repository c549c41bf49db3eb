"""A project as a whole: its matrix, what fails the gate, the acceptance of what there is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from datetime import date
from pathlib import Path

from trackmarshal.errors import TrackmarshalError
from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.runs import RunSummary
from trackmarshal.records.specs import SpecItem, SpecPart, SpecTest
from trackmarshal.records.tests import TestResult
from trackmarshal.trace import backing as _backing
from trackmarshal.trace import baseline as _baseline
from trackmarshal.trace import files as _files
from trackmarshal.trace import outside as _outside
from trackmarshal.trace import reading
from trackmarshal.trace import requirements as _requirements
from trackmarshal.trace.baseline import Tell
from trackmarshal.trace.collector import no_collection
from trackmarshal.trace.findings import Finding
from trackmarshal.trace.graph.building import build as _build_graph
from trackmarshal.trace.matrix import Matrix, assemble
from trackmarshal.trace.model import Project
from trackmarshal.trace.spec import Spec
from trackmarshal.trace.values import Placed


def build(
    project_root: Path,
    spec_items: Sequence[SpecItem],
    spec_tests: Sequence[SpecTest],
    test_results: Iterable[TestResult] = (),
    runs: Iterable[RunSummary] = (),
    today: date | None = None,
    *,
    engine: str = "",
    run_inputs: Mapping[str, Mapping[str, str]] | None = None,
    findings: Iterable[Finding] = (),
    fault_cases: Iterable[FaultCase] = (),
    fault_results: Iterable[FaultResult] = (),
    parts: Iterable[SpecPart] = (),
    tell: Tell | None = None,
) -> Matrix:
    """The matrix of a project.

    Results and runs that are not given count as not run. `today` (default: the clock's day) decides which waivers
    hold. Test results are stale where their inputs are not those of their rule and test, and of `engine`; runs where theirs are not those of
    `run_inputs`, by scenario what it is replayed with. Faults carry their own. `findings` are those of reading the results.
    `tell` says of rules that changed since the baseline whether they got weaker, or stronger.
    What is wrong with the project becomes findings of the matrix; nothing is raised for it.
    """
    found = list(findings)
    with no_collection():
        project = _requirements.load(project_root, found)
        items = _backing.backed(project, spec_items, found)
        spec = Spec(
            items, spec_tests, test_results, runs, engine, run_inputs, fault_cases, fault_results, parts
        )  # fmt: skip
        hashes = {
            **_files.sources(project_root, project, spec.runs.values()),
            **_files.hashes(project_root, project, spec.items),
        }
        baseline = _baseline.load(project_root, project, found)
        around = _outside.load(project_root, project, spec.items, found)
        return assemble(
            project,
            spec,
            hashes,
            baseline,
            today=today or date.today(),
            found=found,
            around=around,
            tell=tell,
        )


def gate(matrix: Matrix) -> list[Finding]:
    """What fails the gate: every finding of level error; empty when it passes."""
    return [finding for finding in matrix.findings if finding.level == "error"]


def load(project_root: Path) -> tuple[Project, tuple[Finding, ...]]:
    """The documents of a project, its settings among them, and what is wrong with reading them."""
    found: list[Finding] = []
    return _requirements.load(project_root, found), tuple(found)


def requirement_ids(project_root: Path) -> tuple[Placed, ...]:
    """The ids that a spec may name in `satisfies`, each with its place."""
    return reading.demanded(project_root, [])


def accept_baseline(
    project_root: Path,
    spec_items: Sequence[SpecItem],
    spec_tests: Sequence[SpecTest],
    fault_cases: Sequence[FaultCase] = (),
    parts: Sequence[SpecPart] = (),
    run_inputs: Mapping[str, Mapping[str, str]] | None = None,
    *,
    by: str = "",
    reason: str = "",
    today: date | None = None,
    tell: Tell | None = None,
    engine: str = "",
) -> tuple[Path, list[str]]:
    """Write down what there is now as accepted; returns the baseline's path, and what became weaker by that.

    engine: the one that makes the evidence now, which the acceptance keeps.
    Raises what reading found wrong, and T378 where something became weaker and `by` or `reason` does not say by whom, or why.
    """
    project, found = load(project_root)
    for finding in found:
        file, line = (finding.place.file, finding.place.line) if finding.place else (None, None)
        raise TrackmarshalError(
            finding.code, finding.message, file=file, line=line, help="mend this before accepting a baseline"
        )
    items = _backing.backed(project, spec_items, [])
    spec = Spec(items, spec_tests, (), (), run_inputs=run_inputs, fault_cases=fault_cases, parts=parts)
    hashes = _files.hashes(project_root, project, spec.items)
    around = _outside.load(project_root, project, spec.items, [])
    now = _baseline.content(project, spec, hashes, _build_graph(project, spec, hashes, around), around)
    there = _baseline.reported(project, around)
    return _baseline.accept(
        project_root, project, now, by, reason, today or date.today(), tell, engine, there
    )
