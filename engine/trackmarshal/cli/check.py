"""Parse specs, resolve names, check dimensions, links to requirements and tests. Every error, in one run."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.output import coloured, count
from trackmarshal.cli.places import configure_relative, shown_from
from trackmarshal.cli.project import find_project, optional_project, spec_folders
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.diagnostics.base import Diagnostic
    from trackmarshal.semantics.compile import Compiled

#: Findings of requirement files that say: nothing of this file is known.
UNREADABLE = {*(f"T{number}" for number in range(101, 112)), "T113"}
FORMATS = ("text", "json", "sarif", "github")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "paths", nargs="*", metavar="PATH", help="spec files or folders (default: the project's specs)"
    )
    parser.add_argument("--format", choices=FORMATS, default="text")
    configure_relative(parser)


def run(args: argparse.Namespace) -> int:
    from trackmarshal.cli.collecting import seldom

    with seldom():
        return _checked(args)


def _checked(args: argparse.Namespace) -> int:
    from trackmarshal.semantics.compile import compile_paths

    project = optional_project(args)
    where = shown_from(args, project, ("json", "sarif", "github"))
    paths = [Path(p) for p in args.paths] or spec_folders(find_project(args))
    compiled = compile_paths(paths, project)
    found = examine(compiled, project)
    print_findings(found, args.format, where)
    errors = sum(getattr(f, "level", "error") == "error" for f in found)
    if args.format == "text" and not args.quiet:
        rules = len(compiled.spec.rules)
        warnings = len(found) - errors
        what = f"{count(len(compiled.order), 'module')}, {count(rules, 'rule or assumption', 'rules and assumptions')}"
        summary = f"{what}: {count(errors, 'error')}, {count(warnings, 'warning')}"
        print(summary, file=sys.stderr if found else sys.stdout)
    if any(isinstance(f, TrackmarshalError) for f in found):  # something could not be read at all
        return 2
    return 1 if errors else 0


def examine(compiled: Compiled, project: Path | None) -> list[Diagnostic | TrackmarshalError]:
    """What can be said against some specs: by the compiler, the constraints, the tests and the links to requirements.

    Files that cannot be read come first, then everything in the order of places.
    """
    from trackmarshal.testing.cases import prepare

    found = [*compiled.found, *prepare(compiled)[1], *unconstrained(compiled)]
    unreadable: list[TrackmarshalError] = []
    if project is not None:
        known, unreadable = demanded(project)
        if not unreadable:  # else it is not known what is demanded
            found += unknown_requirements(compiled, project, known)
    unreadable += unlimited(compiled)
    in_order = sorted(found, key=lambda d: (d.span.file.path, d.span.start, d.code))
    return [*compiled.failures, *unreadable, *in_order]


def unlimited(compiled: Compiled) -> list[TrackmarshalError]:
    """What is wrong with the limits that the specs declare for a Supervisor."""
    from trackmarshal.runtime.cycle import Limits

    try:
        Limits.of(compiled.spec)
    except TrackmarshalError as error:
        return [error]
    return []


def unconstrained(compiled: Compiled) -> list[Diagnostic]:
    """Constraints that the parameters' own values break; those on values with errors of their own are left out."""
    from trackmarshal.ir import nodes as ir
    from trackmarshal.semantics.errors.declarations import Unconstrained

    spec = compiled.spec
    if not spec.constraints:
        return []
    from trackmarshal.backends.reference.evaluator import Reference
    from trackmarshal.runtime.frame import Frame
    from trackmarshal.units import in_full

    values = Reference(spec, Frame())
    found: list[Diagnostic] = []
    for constraint in spec.constraints:
        if not spec.declares(constraint.formula):
            continue
        nodes = list(ir.below(constraint.formula))
        params = dict.fromkeys(node.name for node in nodes if isinstance(node, ir.Param))
        tables = any(isinstance(node, ir.Lookup | ir.GridLookup) for node in nodes)
        if values.truth(constraint.formula, {}).verdict != "satisfied":
            infos = [spec.params[name] for name in params]
            shown = ", ".join(f"{i.name.rpartition('.')[2]} = {in_full(i.value, i.unit)}" for i in infos)
            found.append(
                Unconstrained(
                    constraint.span.head,
                    shown or ("a table breaks it" if tables else "its own numbers break it"),
                    constraint.because or "change a value, or the constraint",
                )
            )
    return found


def demanded(project: Path) -> tuple[set[str], list[TrackmarshalError]]:
    """The ids of the project's requirements, and the files of which it is not known what they demand."""
    from trackmarshal.trace import reading
    from trackmarshal.trace.findings import Finding

    found: list[Finding] = []
    known = set(map(str, reading.demanded(project, found)))
    return known, [
        TrackmarshalError(
            f.code,
            f.message,
            file=f.place and f.place.file,
            line=(f.place and f.place.line) or None,
            help=f.help or None,
        )
        for f in found
        if f.code in UNREADABLE
    ]


def unknown_requirements(
    compiled: Compiled, project: Path, known: set[str] | None = None
) -> list[Diagnostic]:
    """`satisfies` clauses that name no requirement of the project; `known` are its ids, where they were read already.

    What shipped rules satisfy where they come from need not be a requirement of the project that uses them.
    """
    from trackmarshal.diagnostics.base import close_matches
    from trackmarshal.semantics.errors.rules import UnknownRequirement
    from trackmarshal.semantics.modules import from_library
    from trackmarshal.syntax import ast

    known = demanded(project)[0] if known is None else known
    modules = [compiled.library.modules[name] for name in compiled.order]
    items = [item for module in modules if not from_library(module, project) for item in module.tree.items]
    return [
        UnknownRequirement(
            name.span,
            name.name,
            close_matches(name.name, known) or "requirements are declared in requirements/*.yaml",
        )
        for item in items
        if isinstance(item, (ast.Rule, ast.Assume))
        for clause in item.clauses
        if isinstance(clause, ast.Satisfies)
        for name in clause.ids
        if name.name not in known
    ]


def print_findings(found: list[Any], format_: str, where: Callable[[str], str] | None = None) -> None:
    """Print findings in a format, with paths as `where` has them; machine formats go to standard output even when there are none."""
    if format_ == "text":
        from trackmarshal.diagnostics.text import render

        if found:
            print(render(found, colour=coloured()), file=sys.stderr)
    elif format_ == "json":
        from trackmarshal.diagnostics.json import render as render_json

        print(render_json(found, where), end="")
    elif format_ == "sarif":
        from trackmarshal.cli.catalogue import catalogue
        from trackmarshal.diagnostics.sarif import render as render_sarif

        print(render_sarif(found, catalogue(), where), end="")
    elif format_ == "github":
        from trackmarshal.diagnostics.github import render as render_github

        if found:
            print(render_github(found, where), end="")
    else:
        raise AssertionError(f"unknown format {format_}")
