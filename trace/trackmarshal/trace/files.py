"""Files of the project that evidence refers to, by their hashes, and the results folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from trackmarshal import records
from trackmarshal.errors import TrackmarshalError
from trackmarshal.records import FaultResult, RunSummary, SpecItem, TestResult
from trackmarshal.trace import sections
from trackmarshal.trace.findings import Finding, Place, error
from trackmarshal.trace.model import Entry, Project
from trackmarshal.trace.spec import Spec, item_place
from trackmarshal.trace.values import Placed

#: sha256 by path; None where there is no such file.
Hashes = Mapping[str, str | None]


def hashes(root: Path, project: Project, items: Iterable[SpecItem]) -> Hashes:
    """The hashes of all files that evidence, scenarios, campaigns, assumptions and design name, and of sections about requirements."""
    paths = {str(e.path) for e in project.evidence} | {str(s.path) for s in project.scenarios}
    paths |= {str(s.kept) for s in project.scenarios if s.kept} | set(map(str, project.campaigns))
    paths |= {str(path) for _, path in _written_down(project)}
    paths |= {str(project.closed_loop)} if project.closed_loop else set()
    paths |= {str(project.case_words)} if project.case_words else set()
    paths |= {item.evidence for item in items if item.evidence}
    found = {path: sha256(root, path) for path in sorted(paths)}
    if project.case_templates:
        found[str(project.case_templates)] = _folder(root, str(project.case_templates))
    return {**found, **sections.hashes(root, project)}


def _folder(root: Path, folder: str) -> str | None:
    """One sha256 of all files below a folder, with their names; None where there is none."""
    base = root / folder
    files = sorted(path.relative_to(base).as_posix() for path in base.rglob("*") if path.is_file())
    said = json.dumps([(name, sha256(root, f"{folder}/{name}")) for name in files])
    return hashlib.sha256(said.encode()).hexdigest() if files else None


def _written_down(project: Project) -> Iterator[tuple[Entry, Placed]]:
    """The files in which analyses, reviews and design elements are written down."""
    for entry in project.entries:
        for kind, path in entry.links:
            if kind == "backed_by":
                yield entry, path


def sources(root: Path, project: Project, runs: Iterable[RunSummary]) -> Hashes:
    """The hashes of what kept runs were made from, also out of the project: logs that are not part of it are there named by path."""
    kept = {str(scenario.path) for scenario in project.scenarios if scenario.kept}
    return {
        path: sha256(root, path, outside=True)
        for run in runs
        if run.scenario in kept
        for path in run.made_from
    }


def sha256(root: Path, path: str, outside: bool = False) -> str | None:
    """The sha256 of a file, None where there is none; `outside`: it may be out of the project."""
    try:
        whole = (root / path).resolve()
        if not (outside or whole.is_relative_to(root.resolve())) or not whole.is_file():
            return None
        with whole.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, ValueError):
        return None


def check(project: Project, spec: Spec, found: Hashes) -> Iterator[Finding]:
    """Evidence that is not there, or is not what was reviewed (T250 to T252)."""
    for entry in project.evidence:
        actual = found.get(entry.path)
        if actual is None:
            yield error(
                "T250",
                f"the evidence `{entry.path}` is not there",
                entry.path.place,
                "write it, or strike the entry",
                entry.path,
            )
        elif entry.sha256 and actual != entry.sha256:
            message = f"the evidence `{entry.path}` has changed since it was reviewed"
            help_ = f"review it again, then set `sha256: {actual}`"
            yield error("T251", message, entry.path.place, help_, entry.path)
    for made, path in _written_down(project):
        if found.get(path) is None:
            message = f"the document `{path}` of the {made.kind} `{made.id}` is not there"
            yield error("T250", message, path.place, "write it, or strike the entry", path)
    for item in spec.by_name.values():
        if item.kind == "assume" and item.evidence and found.get(item.evidence) is None:
            message = f"the evidence `{item.evidence}` of the assumption `{item.name}` is not there"
            yield error(
                "T252", message, item_place(item), "write it; paths are relative to the project", item.name
            )


@dataclass(frozen=True, slots=True)
class Results:
    """What a results folder holds: the newest result of every test, the newest run of every scenario, of every fault."""

    test_results: tuple[TestResult, ...] = ()
    runs: tuple[RunSummary, ...] = ()
    findings: tuple[Finding, ...] = ()
    fault_results: tuple[FaultResult, ...] = ()


def load_results(root: Path, folder: str = "out/results") -> Results:
    """Read `folder/*.json` of a project; files that cannot be read are findings (T290) and count for nothing."""
    tests: dict[tuple[str, str], TestResult] = {}
    runs: dict[str, RunSummary] = {}
    faults: dict[tuple[str, str], FaultResult] = {}
    found: list[Finding] = []
    read: list[tuple[str, str, records.ResultsFile]] = []
    for path in sorted((root / folder).glob("*.json")):
        shown = f"{folder}/{path.name}"
        try:
            file = records.load(path, shown)
            read.append((file.created, shown, file))
        except TrackmarshalError as problem:
            found.append(
                error(problem.code, problem.message, Place(shown, problem.line or 0), problem.help or "")
            )
    for _, _, file in sorted(read, key=lambda entry: entry[:2]):  # the newest last
        for item in file.items:
            if isinstance(item, TestResult):
                tests[item.rule, item.title] = item
            elif isinstance(item, RunSummary):
                runs[item.scenario] = item
            elif isinstance(item, FaultResult):
                faults[item.campaign, item.id] = item
    return Results(tuple(tests.values()), tuple(runs.values()), tuple(found), tuple(faults.values()))
