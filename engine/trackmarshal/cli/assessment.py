"""A project's specs, tests and scenario runs, brought up to date: what `trace` and `assess` have in common."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli import campaigns, evidence
from trackmarshal.records import FaultCase, FaultResult, RunSummary, SpecItem, SpecTest, TestResult

if TYPE_CHECKING:
    from trackmarshal.diagnostics.base import Diagnostic
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.scenarios.recording import Recording
    from trackmarshal.scenarios.replay import Replay
    from trackmarshal.semantics.compile import Compiled
    from trackmarshal.testing.cases import PreparedTest
    from trackmarshal.trace import Finding, Matrix, Project


@dataclass(slots=True)
class Assessment:
    """Everything that the matrix is made of, and the replays where they were run just now."""

    root: Path
    project: Project
    compiled: Compiled
    items: list[SpecItem]
    tests: list[SpecTest]
    results: list[TestResult]
    runs: list[RunSummary]
    replays: list[tuple[RunSummary, Replay, Evaluator]]
    prepared: list[PreparedTest]
    found: list[Diagnostic]
    #: By scenario, the fingerprint of what it is replayed with now.
    run_fingerprints: dict[str, str]
    fault_cases: list[FaultCase]
    fault_results: list[FaultResult]

    def matrix(self) -> Matrix:
        """The traceability matrix of all this; errors of specs are findings of it."""
        from trackmarshal import trace
        from trackmarshal.cli.check import unknown_requirements

        # Where a rule stands in the matrix, the matrix itself says what is wrong with its links.
        seen = {(item.file, ref.line, ref.column) for item in self.items for ref in item.satisfies}
        loose = (
            link
            for link in unknown_requirements(self.compiled, self.root)
            if (link.span.file.path, link.span.line, link.span.column) not in seen
        )
        wrong = [*self.found, *loose]
        return trace.build(
            self.root, self.items, self.tests, self.results, self.runs, date.today(),
            spec_fingerprint=self.compiled.spec.fingerprint, run_fingerprints=self.run_fingerprints,
            findings=[_finding(item) for item in wrong if item.level == "error"],
            fault_cases=self.fault_cases, fault_results=self.fault_results,
        )  # fmt: skip


def read_specs(root: Path) -> tuple[Project, Compiled, list[PreparedTest], list[Diagnostic]]:
    """The project's settings, specs and tests, and what is wrong with the specs; raises for files that cannot be read.

    A rule with an error is left out, so whatever it was to cover is a gap, beside the error itself.
    """
    from trackmarshal.cli.check import unconstrained
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.testing.cases import prepare
    from trackmarshal.trace import requirements

    project = requirements.load(root, [])
    compiled = compile_paths([root / str(path) for path in project.specs] or [root / "specs"], root)
    if compiled.failures:
        raise compiled.failures[0]
    prepared, found = prepare(compiled)
    return project, compiled, prepared, [*compiled.found, *found, *unconstrained(compiled)]


def assess(root: Path, *, run: bool, everything: bool = False, quiet: bool = True) -> Assessment:
    """Read a project and its results; with `run`, first run the tests, and the scenarios and faults whose results are missing or stale.

    `everything` runs all of them again. Results are kept in the project's results folder.
    """
    project, compiled, prepared, found = read_specs(root)
    folder = root / project.results
    items, tests = _of_project(root, compiled, prepared)
    replays: list[tuple[RunSummary, Any, Any]] = []
    results = evidence.kept(folder / evidence.TESTS, "test_results")
    runs = evidence.kept(folder / evidence.RUNS, "runs")
    broken = any(item.level == "error" for item in found)
    shared: dict[object, Evaluator] = {}
    evaluators = {} if broken else _evaluators(root, project, shared)
    prepared_faults = campaigns.prepare(root, project, broken, shared)
    fault_results = evidence.kept(folder / campaigns.FAULTS, "fault_results")
    if run:
        from trackmarshal.testing.run import run_tests

        claimed = {item.name for item in items}
        own = [test for test in prepared if test.rule.name in claimed]
        results = evidence.test_results(run_tests(compiled.spec, own), compiled.spec)
        evidence.keep(folder / evidence.TESTS, "test_results", results)
        # Specs with errors are not replayed: what would run is not what the project demands.
        runs, replays = (
            ([], []) if broken else _run_scenarios(root, project, runs, evaluators, everything, quiet)
        )
        evidence.keep(folder / evidence.RUNS, "runs", runs)
        fault_results = campaigns.run(prepared_faults, fault_results, everything, quiet)
        evidence.keep(folder / campaigns.FAULTS, "fault_results", fault_results)
    runs = [*(run for run in runs if run.scenario not in _kept(project)), *_kept_runs(root, project)]
    prints = {shown: evaluator.spec.fingerprint for shown, (_, evaluator) in evaluators.items()}
    return Assessment(
        root, project, compiled, items, tests, results, runs, replays, prepared, found, prints,
        campaigns.cases(prepared_faults), fault_results,
    )  # fmt: skip


def _of_project(
    root: Path, compiled: Compiled, prepared: list[PreparedTest]
) -> tuple[list[SpecItem], list[SpecTest]]:
    """What the specs say, as the matrix sees it: all of the project's own, and of the shipped rules that it uses those that satisfy one
    of its requirements, with what they assume. The others are evaluated all the same; nobody answers for them here."""
    from trackmarshal.cli.check import demanded
    from trackmarshal.semantics.modules import from_library

    items, tests = evidence.spec_items(compiled.spec.rules), evidence.spec_tests(prepared)
    modules = [(module.file.path, from_library(module, root)) for module in compiled.library.modules.values()]
    # What is called as a shipped file, and is the project's own, is not dropped for that.
    shipped = {path for path, is_shipped in modules if is_shipped} - {
        path for path, is_shipped in modules if not is_shipped
    }
    if not shipped:
        return items, tests
    known, _ = demanded(root)
    linked = [
        replace(item, satisfies=tuple(ref for ref in item.satisfies if ref.id in known))
        if item.file in shipped
        else item
        for item in items
    ]
    assumed = {
        ref.id for item in linked if item.satisfies or item.file not in shipped for ref in item.assuming
    }
    claimed = [item for item in linked if item.file not in shipped or item.satisfies or item.name in assumed]
    names = {item.name for item in claimed}
    return claimed, [test for test in tests if test.rule in names]


def _evaluators(
    root: Path, project: Project, shared: dict[object, Evaluator]
) -> dict[str, tuple[Recording, Evaluator]]:
    """Every scenario's recording and the rules that it is replayed with; those that are not there are left to the matrix."""
    from trackmarshal.cli.replay import evaluator_for
    from trackmarshal.scenarios import load
    from trackmarshal.scenarios.field.header import header
    from trackmarshal.scenarios.field.mapping import read

    result = {}
    for scenario in project.scenarios:
        shown = str(scenario.path)
        path = root / shown
        if path.is_file():
            # Of a log that need not be here, the mapping alone says what it is evaluated with.
            recording = header(read(path, shown)) if scenario.kept else load(path, shown)
            more = [root / str(spec) for spec in scenario.specs]
            result[shown] = (
                recording,
                evaluator_for(
                    recording, root / project.default_spec, [], root, None, "numpy", path.parent, more, shared
                ),
            )
    return result


def _kept(project: Project) -> dict[str, str]:
    """By scenario, the file that its run is kept in: of logs that need not be part of the project."""
    return {str(scenario.path): str(scenario.kept) for scenario in project.scenarios if scenario.kept}


def _kept_runs(root: Path, project: Project) -> list[RunSummary]:
    found = []
    for shown, file in _kept(project).items():
        found += [run for run in evidence.kept(root / file, "runs") if run.scenario == shown]
    return found


def _run_scenarios(
    root: Path,
    project: Project,
    old: list[RunSummary],
    evaluators: dict[str, tuple[Recording, Evaluator]],
    everything: bool,
    quiet: bool,
) -> tuple[list[RunSummary], list[tuple[RunSummary, Any, Any]]]:
    """Runs of all scenarios: the old ones where they are of the same recording and rules, else new ones."""
    from trackmarshal.cli.replay import run_one

    known = {run.scenario: run for run in old}
    runs, replays = [], []
    for shown, (recording, evaluator) in evaluators.items():
        if shown in _kept(project):
            continue
        digest = evidence.file_hash(root / shown)
        before = known.get(shown)
        fresh = before is not None and (before.source_hash, before.spec_fingerprint) == (
            digest,
            evaluator.spec.fingerprint,
        )
        if before is not None and fresh and not everything:
            runs.append(before)
            continue
        outcome = run_one(recording, evaluator, quiet)
        summary = evidence.run_summary(outcome, evaluator, shown, digest)
        runs.append(summary)
        replays.append((summary, outcome, evaluator))
    return runs, replays


def _finding(item: Diagnostic) -> Finding:
    """A diagnostic of a spec as a finding of the matrix."""
    from trackmarshal.trace import Finding, Place

    span = item.span
    return Finding(
        item.code, item.level, item.message, Place(span.file.path, span.line, span.column), item.help
    )
