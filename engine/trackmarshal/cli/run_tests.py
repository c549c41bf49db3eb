"""Run the tests written in specs, with both evaluators in Python (the reference and numpy), and say which sides of each rule's boundary they cover.

A rule is covered when tests stand on both sides of its boundary and exactly on it, as many as the project asks for (`tests_per_rule`). One stands on it that expects a margin of about 0, and fails
where the rule's limits are moved a little, both ways.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli import tests_shown
from trackmarshal.cli.output import coloured, say, table, write
from trackmarshal.cli.places import configure_relative, shown_from
from trackmarshal.cli.project import find_project, optional_project, spec_folders
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.cli.tests_shown import Where
    from trackmarshal.diagnostics.base import Diagnostic
    from trackmarshal.testing.boundary import Distances
    from trackmarshal.testing.run import Coverage, Outcome


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "paths", nargs="*", metavar="PATH", help="spec files or folders (default: the project's specs)"
    )
    parser.add_argument("--format", choices=("text", "json", "github", "junit"), default="text")
    configure_relative(parser)


def run(args: argparse.Namespace) -> int:
    from trackmarshal.cli.check import unconstrained
    from trackmarshal.diagnostics.base import Diagnostics
    from trackmarshal.diagnostics.text import render
    from trackmarshal.meaning import fingerprint_of_test
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.testing.cases import prepare
    from trackmarshal.testing.run import coverage, run_tests

    project = optional_project(args)
    where = shown_from(args, project, ("json", "github", "junit"))
    paths = [Path(p) for p in args.paths] or spec_folders(find_project(args))
    compiled = compile_paths(paths, project)
    try:
        compiled.raise_errors()
    except TrackmarshalError as error:
        wrong = error.items if isinstance(error, Diagnostics) else [error]
        _print([], [], wrong, args.format, where)  # what is empty is no report to those who read it
        raise
    tests, found = prepare(compiled)
    found = [*found, *unconstrained(compiled)]
    if found:
        print(render(found, colour=coloured()), file=sys.stderr)
    distances, needs = _asked(project)
    outcomes = list(run_tests(compiled.spec, tests, distances=distances))
    unmoved = {(o.test.rule.name, o.test.title): o.unmoved for o in outcomes}
    failed = {(o.test.rule.name, o.test.title) for o in outcomes if o.outcome != "passed"}
    covered = coverage(compiled.spec, tests, unmoved, distances, failed, needs, fingerprint_of_test)
    bad = [o for o in outcomes if o.outcome != "passed"]
    partial = [c for c in covered if not c.complete]
    if not _print(outcomes, covered, found, args.format, where):
        for outcome in bad:
            say(
                f"{outcome.outcome}: {outcome.test.span}: {outcome.test.rule.name}: {outcome.test.title}",
                f"  {outcome.message}",
            )
        rows = [
            [
                c.rule.name,
                str(c.tests),
                *(_mark(c, side) for side in ("satisfied", "violated", "boundary")),
            ]
            for c in partial
        ]
        if rows:
            say(
                "rules whose boundary is not covered:",
                *table(rows, ["rule", "tests", "inside", "outside", "on it"]),
                *(f"{c.rule.name}: {why}" for c in partial for why in c.beside),
            )
        print(
            f"{len(outcomes) - len(bad)} passed, {len(bad)} failed; {len(covered) - len(partial)} of {len(covered)} rules covered"
        )
    return 1 if bad or found or partial else 0


def _print(outcomes: Sequence[Outcome], covered: Sequence[Coverage], found: Sequence[Diagnostic | TrackmarshalError], format_: str, where: Where) -> bool:  # fmt: skip
    """The report in one of the formats for machines; whether it is one."""
    match format_:
        case "json":
            print(tests_shown.as_json(outcomes, covered, found, where))
        case "github":
            print(tests_shown.as_github(outcomes, covered, found, where), end="")
        case "junit":
            write(tests_shown.as_junit(outcomes, covered, found, where))
        case _:
            return False
    return True


def _asked(project: Path | None) -> tuple[Distances, Iterable[tuple[str, int]]]:
    """How far limits are moved, and how many tests each rule has at least, by side: as the project says, if there is one."""
    from trackmarshal.cli.sources import distances
    from trackmarshal.testing.boundary import Distances
    from trackmarshal.testing.run import ONE_EACH
    from trackmarshal.trace import requirements

    if project is None:
        return Distances(), ONE_EACH
    said = requirements.load(project, [])
    return distances(said), said.tests_per_rule


def _mark(covered: Coverage, side: str) -> str:
    """Whether a side has its tests; none where nothing is asked of it, or the rule has no such side."""
    if getattr(covered, side):
        return "yes"
    return "NO" if side in dict(covered.lacking) else "n/a"
