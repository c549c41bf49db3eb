"""All of it: check the specs, run their tests and the project's scenarios, collect the evidence, make the matrix and the pages.

Writes a folder with an index page that opens without a network.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from pathlib import Path

from trackmarshal import __version__
from trackmarshal.cli.output import say
from trackmarshal.cli.project import find_project


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", metavar="DIR", help="default: out/assess in the project")


def run(args: argparse.Namespace) -> int:
    from trackmarshal import trace
    from trackmarshal.cli.assessment import assess
    from trackmarshal.cli.check import unknown_requirements
    from trackmarshal.cli.evidence import now
    from trackmarshal.diagnostics.text import render as render_text
    from trackmarshal.scenarios.run_record import run_record
    from trackmarshal.testing.run import coverage
    from trackmarshal.trace.report import write_report

    root = find_project(args)
    target = Path(args.out) if args.out else root / "out" / "assess"
    made = assess(root, run=True, replays=True, quiet=args.quiet)
    sources = made.sources
    found = [*sources.found, *unknown_requirements(sources.compiled, root)]
    if found:
        print(render_text(found, colour=sys.stderr.isatty()), file=sys.stderr)
    matrix = made.matrix()
    target.mkdir(parents=True, exist_ok=True)
    for format_ in ("html", "json", "csv", "md"):
        (target / f"matrix.{format_}").write_text(trace.render(matrix, format_), encoding="utf-8")
    summary = json.loads(trace.render(matrix, "json"))
    records = [
        run_record(outcome, evaluator, source_hash=summary.source_hash)
        for summary, outcome, evaluator in made.replays
    ]
    failed = [r for r in made.results if r.outcome != "passed"]
    unmoved = {(r.rule, r.title): r.unmoved for r in made.results}
    covered = coverage(sources.compiled.spec, sources.prepared, unmoved, sources.distances)
    uncovered = [c.rule.name for c in covered if not c.complete]
    faults = [result for result in made.fault_results if result.outcome != "passed"]
    gaps = trace.gate(matrix)
    page = write_report(
        target,
        runs=records,
        matrix_html="matrix.html",
        matrix_summary=summary,
        missing=summary["findings"],
        checks={"modules": len(sources.compiled.order), "rules": len(made.facts.items), "errors": sum(d.level == "error" for d in found),
                "warnings": sum(d.level != "error" for d in found), "tests": len(made.results), "failed": len(failed),
                "failures": [{"rule": r.rule, "title": r.title, "message": r.message, "place": f"{r.file}:{r.line}"} for r in failed],
                "uncovered": uncovered,
                "faults": (len(made.fault_results) - len(faults), len(made.fault_results)) if made.fault_results else None},
        meta={"project": made.project.name or root.name, "created": now(), "tool": f"trackmarshal {__version__}",
              "python": platform.python_version(), "spec_fingerprint": sources.compiled.spec.fingerprint, "command": "trackmarshal assess"},
        faults=trace.fault_rows(made.facts.fault_cases, made.fault_results),
    )  # fmt: skip
    expected = {str(scenario.path): scenario.expect for scenario in made.project.scenarios}
    # Where rules are expected to fire, it is on what the ground truth knows nothing of: whether they did is the matrix's to say.
    judged = [run_ for run_ in made.runs if expected.get(run_.scenario) != "fire"]
    outside = [run_ for run_ in judged if not all(truth.inside for truth in run_.ground_truth.values())]
    unmet = [s for s, run_, _ in made.replays if expected.get(s.scenario) == "ground_truth" and not run_.met]
    unlike = sorted({run_.scenario for run_ in (*outside, *unmet)})
    if not args.quiet:
        print(
            f"{len(made.results) - len(failed)} of {len(made.results)} tests passed, {len(made.runs)} scenarios run, "
            f"{len(made.fault_results) - len(faults)} of {len(made.fault_results)} faults found as expected, {len(gaps)} gaps"
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
