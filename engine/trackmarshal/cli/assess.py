"""All of it: check the specs, run their tests and the project's scenarios, collect the evidence, make the matrix and the pages.

Writes a folder with an index page that opens without a network.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal import __version__
from trackmarshal.cli import against, days
from trackmarshal.cli.beside import page_beside
from trackmarshal.cli.drawn import Drawn
from trackmarshal.cli.output import coloured, count, say, told
from trackmarshal.cli.project import find_project
from trackmarshal.cli.shown import Shown, ShownRun, keep, key

if TYPE_CHECKING:
    from trackmarshal.cli.assessment import Assessment
    from trackmarshal.diagnostics.base import Diagnostic


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", metavar="DIR", help="default: out/assess in the project")
    days.configure(parser)
    against.configure(parser)


def run(args: argparse.Namespace) -> int:
    from trackmarshal.cli.collecting import seldom

    with seldom():
        return _assessed(args)


def _assessed(args: argparse.Namespace) -> int:
    from trackmarshal import trace
    from trackmarshal.cli.assessment import assess
    from trackmarshal.cli.evidence import now
    from trackmarshal.trace.backing import backed
    from trackmarshal.trace.report import page_addresses, write_report

    root = find_project(args)
    today = days.day(args.day, root)
    target = Path(args.out) if args.out else root / "out" / "assess"
    made = assess(root, run=True, replays=True, quiet=args.quiet)
    made.store_found += days.doubts(args.day, today, root)
    found: list[Diagnostic] = []
    shown = made.shown
    if shown is None:
        found = _said(made, root)
        shown = _shown(made)
        if not found:  # what is wrong with specs is said each time
            keep(root, made.facts.state, made.results, shown)
    state = made.facts.state
    drawn = Drawn(root, key(state, made.results) if state and not found else "")
    matrix = made.matrix(today)
    target.mkdir(parents=True, exist_ok=True)
    texts = {format_: trace.render(matrix, format_) for format_ in ("json", "csv", "md")}
    # Lone surrogates (from odd paths) have no encoding; no document must fail on them.
    for format_, text in texts.items():
        (target / f"matrix.{format_}").write_bytes(text.encode("utf-8", "replace"))
    summary = json.loads(texts["json"])
    pages = dict(
        zip((run_.scenario for run_ in shown.runs), page_addresses([run_.record for run_ in shown.runs]))
    )
    beside = page_beside(made, matrix, args.against, pages, index="index.html")
    (target / "matrix.html").write_bytes(
        trace.render(matrix, "html", beside=beside).encode("utf-8", "replace")
    )
    failed = [r for r in made.results if r.outcome != "passed"]
    faults = [result for result in made.fault_results if result.outcome != "passed"]
    gaps = trace.gate(matrix)
    titles = {str(scenario.path): str(scenario.title) for scenario in made.project.scenarios if scenario.kept}
    kept = [
        {"path": run_.scenario, "title": titles[run_.scenario], "cycles": run_.cycles, "fired": run_.fired, "day": run_.created[:10]}
        for run_ in made.runs if run_.scenario in titles
    ]  # fmt: skip
    page = write_report(
        target,
        runs=[run_.record for run_ in shown.runs],
        matrix_html="matrix.html",
        matrix_summary=summary,
        missing=summary["findings"],
        checks={"modules": shown.modules, "rules": len(made.facts.items), "errors": sum(d.level == "error" for d in found),
                "warnings": sum(d.level != "error" for d in found), "tests": len(made.results), "failed": len(failed),
                "failures": [{"rule": r.rule, "title": r.title, "message": r.message, "place": f"{r.file}:{r.line}"} for r in failed],
                "uncovered": shown.uncovered,
                "faults": (len(made.fault_results) - len(faults), len(made.fault_results)) if made.fault_results else None},
        meta={"project": made.project.name or root.name, "created": now(), "tool": f"trackmarshal {__version__}",
              "python": platform.python_version(), "spec_fingerprint": shown.fingerprint, "command": "trackmarshal assess"},
        faults=trace.fault_rows(made.facts.fault_cases, made.fault_results),
        drawn=drawn,
        kept=kept,
        backed={item.name: {"evidence": item.evidence, "owner": item.owner} for item in backed(made.project, made.facts.items, [])},
    )  # fmt: skip
    drawn.keep()
    expected = {str(scenario.path): scenario.expect for scenario in made.project.scenarios}
    # Where rules are expected to fire, it is on what the ground truth knows nothing of: whether they did is the matrix's to say.
    judged = [run_ for run_ in made.runs if expected.get(run_.scenario) != "fire"]
    outside = [run_ for run_ in judged if not all(truth.inside for truth in run_.ground_truth.values())]
    met = {run_.scenario: run_.met for run_ in shown.runs}
    unmet = [name for name, is_met in met.items() if expected.get(name) == "ground_truth" and not is_met]
    unlike = sorted({*unmet, *(run_.scenario for run_ in outside)})
    if not args.quiet:
        print(
            f"{len(made.results) - len(failed)} of {len(made.results)} tests passed, {count(len(made.runs) - len(kept), 'scenario')} run{f', {len(kept)} kept' if kept else ''}, "
            f"{len(made.fault_results) - len(faults)} of {len(made.fault_results)} faults found as expected, {told(gaps, matrix)}"
        )
        for run_ in made.runs:
            if run_.uncovered and expected.get(run_.scenario) == "ground_truth":
                say(f"{run_.scenario}: no ground truth was declared of {', '.join(run_.uncovered)}")
        for scenario in unlike:
            say(f"{scenario} is not as its ground truth says")
        say(str(page))
    errors = any(d.level == "error" for d in found)
    if matrix.unusable:
        return 2
    return 1 if failed or gaps or unlike or faults or errors else 0


def _said(made: Assessment, root: Path) -> list[Diagnostic]:
    """What is wrong with the specs, and the user is told."""
    from trackmarshal.cli.check import unknown_requirements
    from trackmarshal.diagnostics.text import render

    found = [*made.sources.found, *unknown_requirements(made.sources.compiled, root)]
    if found:
        print(render(found, colour=coloured()), file=sys.stderr)
    return found


def _shown(made: Assessment) -> Shown:
    """What is shown beside the matrix, made from the specs and the replays."""
    from trackmarshal.explaining.moments import told_moments
    from trackmarshal.meaning import fingerprint_of_test
    from trackmarshal.scenarios.run_record import run_record
    from trackmarshal.testing.run import coverage

    sources = made.sources
    unmoved = {(r.rule, r.title): r.unmoved for r in made.results}
    failed = {(r.rule, r.title) for r in made.results if r.outcome != "passed"}
    covered = coverage(
        sources.compiled.spec,
        sources.prepared,
        unmoved,
        sources.distances,
        failed,
        made.project.tests_per_rule,
        fingerprint_of_test,
    )
    runs = []
    while made.replays:  # what was kept of a run is large, and done with when its record is made
        summary, outcome, evaluator = made.replays.pop(0)
        record = run_record(outcome, evaluator, summary.source_hash)
        told = told_moments(outcome, evaluator)
        runs.append(ShownRun(summary.scenario, outcome.met, {**record, "told": told}))
    uncovered = [c.rule.name for c in covered if not c.complete]
    return Shown(len(sources.compiled.order), sources.compiled.spec.fingerprint, uncovered, runs)
