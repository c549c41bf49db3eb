"""A version of a project, as far as meaning goes: what its documents say, what the engine says of its specs, the hashes of its files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from trackmarshal.files import digest, read_regular
from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.runs import RunSummary
from trackmarshal.records.specs import SpecItem, SpecPart, SpecTest
from trackmarshal.records.tests import TestResult
from trackmarshal.trace import backing, files, outside, requirements
from trackmarshal.trace import baseline as baselines
from trackmarshal.trace.findings import Finding
from trackmarshal.trace.graph.building import build
from trackmarshal.trace.graph.graph import Graph
from trackmarshal.trace.matrix import UNUSABLE
from trackmarshal.trace.model import Project
from trackmarshal.trace.spec import Spec


@dataclass(frozen=True, slots=True)
class Version:
    """A project at one time. content: what its baseline would hold; code: sha256 of source files that say what they implement.

    wrong: why its specs, or its documents, do not say all that they are to say; what they lack is not known then.
    """

    project: Project
    spec: Spec
    graph: Graph
    content: baselines.Content
    hashes: files.Hashes
    code: Mapping[str, str]
    wrong: tuple[Finding, ...]

    def engine(self, otherwise: Version) -> str:
        """The engine that made the evidence of this version; that of another one where it is not known."""
        return self.spec.engine or otherwise.spec.engine


def version(
    root: Path,
    items: Iterable[SpecItem],
    tests: Iterable[SpecTest],
    fault_cases: Iterable[FaultCase],
    parts: Iterable[SpecPart],
    run_inputs: Mapping[str, Mapping[str, str]],
    *,
    engine: str,
    results: Iterable[TestResult] = (),
    runs: Iterable[RunSummary] = (),
    fault_results: Iterable[FaultResult] = (),
    findings: Iterable[Finding] = (),
) -> Version:
    """A project's version. `engine` makes its evidence, or made it (empty: not known); `findings` are those of compiling its specs; results are those that are there."""
    found: list[Finding] = []
    project = requirements.load(root, found)
    spec = Spec(
        backing.backed(project, items, []),
        tests,
        results,
        runs,
        engine,
        run_inputs,
        fault_cases,
        fault_results,
        parts,
    )
    hashes = files.hashes(root, project, spec.items)
    around = outside.load(root, project, spec.items, [])
    code = {marker.place.file: _hash(root / marker.place.file) for marker in around.markers}
    wrong = [
        *(one for one in findings if one.level == "error"),
        *(one for one in found if one.code in UNUSABLE),
    ]
    graph = build(project, spec, hashes, around)
    return Version(
        project,
        spec,
        graph,
        baselines.content(project, spec, hashes, graph, around),
        hashes,
        code,
        tuple(wrong),
    )


def _hash(path: Path) -> str:
    return digest(read_regular(path))
