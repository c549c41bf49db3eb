"""Parse specs, resolve names, check dimensions, links to requirements and tests. Every error, in one run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.project import find_project, optional_project

if TYPE_CHECKING:
    from trackmarshal.diagnostics.base import Diagnostic
    from trackmarshal.errors import TrackmarshalError
    from trackmarshal.semantics.compile import Compiled

FORMATS = ("text", "json", "sarif", "github")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paths", nargs="*", metavar="PATH", help="spec files or folders (default: the project's specs)")
    parser.add_argument("--format", choices=FORMATS, default="text")


def run(args: argparse.Namespace) -> int:
    from trackmarshal.semantics.compile import compile_paths

    project = optional_project(args)
    paths = [Path(p) for p in args.paths] or [find_project(args) / "specs"]
    compiled = compile_paths(paths, project)
    found: list[Diagnostic | TrackmarshalError] = [*compiled.failures, *findings(compiled, project)]
    print_findings(found, args.format)
    errors = sum(getattr(f, "level", "error") == "error" for f in found)
    if args.format == "text" and not args.quiet:
        rules = len(compiled.spec.rules)
        warnings = len(found) - errors
        summary = f"{len(compiled.order)} modules, {rules} rules and assumptions: {errors} errors, {warnings} warnings"
        print(summary, file=sys.stderr if found else sys.stdout)
    if compiled.failures:
        return 2
    return 1 if errors else 0


def findings(compiled: Compiled, project: Path | None) -> list[Diagnostic]:
    """What the compiler, the tests and the links to requirements have against some specs."""
    from trackmarshal.testing.cases import prepare

    found = list(compiled.found)
    found += prepare(compiled)[1]
    if project is not None:
        found += unknown_requirements(compiled, project)
    return found


def unknown_requirements(compiled: Compiled, project: Path) -> list[Diagnostic]:
    """`satisfies` clauses that name no requirement of the project."""
    from trackmarshal.diagnostics.base import close_matches
    from trackmarshal.semantics.errors import UnknownRequirement
    from trackmarshal.trace import requirements

    known = {str(name) for name in requirements.ids(project)}
    return [
        UnknownRequirement(span, name, close_matches(name, known))
        for rule in compiled.spec.rules
        for name, span in rule.satisfies
        if name not in known
    ]


def print_findings(found: list[Any], format_: str) -> None:
    """Print findings in a format; machine formats go to standard output even when there are none."""
    if format_ == "text":
        from trackmarshal.diagnostics.text import render

        if found:
            print(render(found, colour=sys.stderr.isatty()), file=sys.stderr)
    elif format_ == "json":
        from trackmarshal.diagnostics.json import render as render_json

        print(render_json(found))
    elif format_ == "sarif":
        from trackmarshal.cli.catalogue import catalogue
        from trackmarshal.diagnostics.sarif import render as render_sarif

        print(render_sarif(found, catalogue()))
    elif format_ == "github":
        from trackmarshal.diagnostics.github import render as render_github

        if found:
            print(render_github(found))
    else:
        raise AssertionError(f"unknown format {format_}")
