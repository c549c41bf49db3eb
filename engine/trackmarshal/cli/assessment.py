"""A project's specs, tests and scenario runs, brought up to date: what `trace` and `assess` have in common."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli import evidence
from trackmarshal.records import RunSummary, SpecItem, SpecTest, TestResult

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.scenarios.replay import Replay
    from trackmarshal.semantics.compile import Compiled
    from trackmarshal.testing.cases import PreparedTest
    from trackmarshal.trace.model import Project


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


def read_specs(root: Path) -> tuple[Project, Compiled, list[PreparedTest]]:
    """The project's settings, specs and tests; raises what is wrong with the specs."""
    from trackmarshal.diagnostics.base import Diagnostics
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.testing.cases import prepare
    from trackmarshal.trace import requirements

    project = requirements.load(root, [])
    compiled = compile_paths([root / str(path) for path in project.specs] or [root / "specs"], root)
    compiled.raise_errors()
    prepared, found = prepare(compiled)
    if found:
        raise Diagnostics(found)
    return project, compiled, prepared


def assess(root: Path, *, run: bool, everything: bool = False, quiet: bool = True) -> Assessment:
    """Read a project and its results; with `run`, first run the tests, and the scenarios whose results are missing or stale.

    `everything` runs all scenarios again. Results are kept in the project's results folder.
    """
    project, compiled, prepared = read_specs(root)
    folder = root / project.results
    items, tests = evidence.spec_items(compiled.spec.rules), evidence.spec_tests(prepared)
    replays: list[tuple[RunSummary, Any, Any]] = []
    if run:
        from trackmarshal.testing.run import run_tests

        results = evidence.test_results(run_tests(compiled.spec, prepared), compiled.spec)
        evidence.keep(folder / evidence.TESTS, "test_results", results)
        runs, replays = _run_scenarios(root, project, folder, everything, quiet)
        evidence.keep(folder / evidence.RUNS, "runs", runs)
    else:
        results = evidence.kept(folder / evidence.TESTS, "test_results")
        runs = evidence.kept(folder / evidence.RUNS, "runs")
    return Assessment(root, project, compiled, items, tests, results, runs, replays, prepared)


def _run_scenarios(
    root: Path, project: Project, folder: Path, everything: bool, quiet: bool
) -> tuple[list[RunSummary], list[tuple[RunSummary, Any, Any]]]:
    from trackmarshal.cli.replay import evaluator_for, run_one
    from trackmarshal.scenarios import load

    known = {run.scenario: run for run in evidence.kept(folder / evidence.RUNS, "runs")}
    runs, replays = [], []
    for scenario in project.scenarios:
        shown = str(scenario.path)
        path = root / shown
        if not path.is_file():
            continue  # the matrix reports it
        recording = load(path, shown)
        recording_hash = evidence.file_hash(path)
        evaluator = evaluator_for(recording, root / project.default_spec, [], root, None, "numpy", path.parent)
        old = known.get(shown)
        fresh = old is not None and old.source_hash == recording_hash and old.spec_fingerprint == evaluator.spec.fingerprint
        if old is not None and fresh and not everything:
            runs.append(old)
            continue
        outcome = run_one(recording, evaluator, quiet)
        summary = evidence.run_summary(outcome, evaluator, shown, recording_hash)
        runs.append(summary)
        replays.append((summary, outcome, evaluator))
    return runs, replays
