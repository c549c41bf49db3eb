"""One rule for readers: its spec, its formula, in words, and its C function, with the parameters in force.

trackmarshal show friction
trackmarshal show friction --as formula --expand
trackmarshal show friction --format html --out friction.html
trackmarshal show friction --solve v
trackmarshal show friction --draw --out friction.svg
trackmarshal show friction --draw --over p.a --against v > friction.svg

Without --as: the spec, the formula and the words; as html and json, the C function too. What a formula calls is listed below it, or written out in
its place (--expand). With --solve, up to which value of a number the rule holds. With --draw, the boundary of what the rule requires as an SVG
picture, with its tests and, in a project, all that was recorded.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.options import configure_with
from trackmarshal.cli.output import dump, plain, write, write_out
from trackmarshal.cli.project import find_project, optional_project, spec_folders
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.ir.spec import RuleInfo, Spec
    from trackmarshal.reading.sheet import Sheet
    from trackmarshal.testing.cases import PreparedTest

FORMS = ("spec", "formula", "english", "c")
#: What tells a file of such a kind, and what it is called. A text has nothing that would tell it from a spec.
_MARKS = {
    "svg": (b"<svg", "picture"), "html": (b"<!doctype html>", "page"), "json": (b'{"rule": ', "rule as JSON"), "text": (None, ""),
}  # fmt: skip
#: Forms that speak of a rule's condition, which an assumption without a monitor has none of.
_OF_CONDITIONS = ("formula", "english", "c")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rule", metavar="RULE", help="a rule, or an assumption")
    parser.add_argument(
        "--as",
        dest="forms",
        action="append",
        choices=FORMS,
        help="a form (repeatable; default: all, in text without C)",
    )
    parser.add_argument("--expand", action="store_true", help="write definitions out in the formula")
    parser.add_argument(
        "--solve",
        action="append",
        default=[],
        metavar="V",
        help="a number to solve for: a field or a parameter (repeatable)",
    )
    parser.add_argument(
        "--draw", action="store_true", help="the boundary as an SVG picture, and nothing else"
    )
    parser.add_argument(
        "--over",
        metavar="X",
        help="of a drawing: the input to the right (default: one of the two most telling)",
    )
    parser.add_argument("--against", metavar="Y", help="of a drawing: the input up")
    parser.add_argument("--out", metavar="FILE", help="where it is written (default: standard output)")
    parser.add_argument("--format", choices=("text", "html", "json"), default="text")
    parser.add_argument(
        "--json", action="store_const", const="json", dest="format", help="the same as --format json"
    )
    parser.add_argument("--spec", metavar="SPEC", help="spec file or folder (default: all of the project)")
    configure_with(parser)
    parser.set_defaults(refuse=parser.error)


def run(args: argparse.Namespace) -> int:
    from trackmarshal.evaluation import load

    drawn = args.draw or args.over or args.against
    if drawn and (args.forms or args.solve or args.expand or args.format != "text"):
        args.refuse("a drawing is a picture and nothing else: leave out --as, --expand, --solve and --format")
    project = optional_project(args)
    paths = [Path(args.spec)] if args.spec is not None else spec_folders(find_project(args))
    settings = [Path(one) for one in args.settings]
    spec = load(paths, settings, project)
    declared = load(paths, [], project) if settings else spec
    rule = _rule(args.rule, spec)
    if drawn:
        return _draw(rule, spec, declared, paths, project, args)
    forms = args.forms or ([] if args.solve else _all(rule, args.format))
    tests = _tests(paths, project) if args.solve else ()
    sheet = _sheet(rule, spec, declared, forms, tests, args)
    match args.format:
        case "text":
            from trackmarshal.reading.text import lines

            single = bool(args.forms or args.solve) and len(forms) + bool(sheet.limits) == 1
            said = "\n".join(plain(line) for line in lines(sheet, single=single))
        case "html":
            from trackmarshal.reading.html import page

            said = "\n".join(plain(line) for line in page([sheet]).splitlines())
        case "json":
            from trackmarshal.reading.data import data

            said = dump(data(sheet))
        case _:
            raise AssertionError(f"unknown format {args.format}")
    _put(args, f"{said}\n")
    return 0


def _put(args: argparse.Namespace, said: str, kind: str = "") -> None:
    """Print what was asked for, or write it to `--out`; raises E412 where something else is there."""
    form = kind or args.format
    if args.out is not None:
        write_out(args.out, said.encode(), *_MARKS[form])
    elif form == "text":
        print(said, end="")
    else:
        write(said)


def _draw(
    rule: RuleInfo,
    spec: Spec,
    declared: Spec,
    paths: Sequence[Path],
    project: Path | None,
    args: argparse.Namespace,
) -> int:
    """Write the picture; raises E493, and E494 where there is none. Of specs that are named, nobody knows what was recorded with them."""
    from trackmarshal.cli.drawing import of_project
    from trackmarshal.reading.drawing.making import drawings
    from trackmarshal.trace.case.words.language import english
    from trackmarshal.trace.report.svg.boundary import picture

    recorded, distances = ([], None) if args.spec is not None or project is None else of_project(project)
    tests = _tests(paths, project)
    ((_, drawing),) = drawings([rule], spec, tests, recorded, distances, args.over, args.against, declared)
    if "none" in drawing:
        reason = english()[f"drawing.none.{drawing['none']}"].partition(": ")[2].rstrip(".")
        raise TrackmarshalError(
            "E494", f"`{rule.name}` has no drawing: {reason}", file=str(rule.span.file.path), line=rule.span.line,
            help=f"trackmarshal show {rule.name} --as formula",
        )  # fmt: skip
    _put(args, picture(drawing, english(), "boundary").svg + "\n", "svg")
    return 0


def _all(rule: RuleInfo, format_: str) -> Sequence[str]:
    if rule.typed is None:
        return ("spec",)
    return FORMS[:3] if format_ == "text" else FORMS


def _rule(name: str, spec: Spec) -> RuleInfo:
    from trackmarshal.diagnostics.base import close_matches

    rule = spec.rule(name)
    if rule is None:
        known = [one.name for one in spec.rules]
        help_ = close_matches(name, known) or ", ".join(known) or "it has none"
        raise TrackmarshalError("E401", f"the spec has no rule `{name}`", help=help_)
    return rule


def _sheet(
    rule: RuleInfo,
    spec: Spec,
    declared: Spec,
    forms: Sequence[str],
    tests: Sequence[PreparedTest],
    args: argparse.Namespace,
) -> Sheet:
    from trackmarshal.reading.rule import read
    from trackmarshal.reading.sheet import Sheet, spec_text
    from trackmarshal.reading.solving import solve
    from trackmarshal.reading.telling import tell
    from trackmarshal.reading.words.english import ENGLISH

    missing = [form for form in forms if form in _OF_CONDITIONS]
    if rule.typed is None and (missing or args.solve):
        raise TrackmarshalError(
            "E404", f"`{rule.name}` has no condition to show", file=str(rule.span.file.path), line=rule.span.line,
            help="add a `monitor` to the assumption, or show it --as spec",
        )  # fmt: skip
    return Sheet(
        rule, ENGLISH,
        spec_text(rule) if "spec" in forms else None,
        read(rule, spec, declared, args.expand) if "formula" in forms else None,
        tell(rule, spec, ENGLISH) if "english" in forms else None,
        _c(rule, spec, bool(args.forms)) if "c" in forms else None,
        tuple(limit for name in args.solve for limit in solve(rule, spec, tests, name, ENGLISH)),
    )  # fmt: skip


def _c(rule: RuleInfo, spec: Spec, asked: bool) -> str:
    """The C function of a rule; where none can be had and nobody asked for it by name, why that is so."""
    from trackmarshal.backends.c.source import generate

    try:
        source = generate(spec, [rule], "supervisor")
    except TrackmarshalError as error:
        if asked:
            raise
        return f"/* {error.message} [{error.code}] */"
    return next(code.text for code in source.rules if code.rule.name == rule.name).rstrip()


def _tests(paths: Sequence[Path], project: Path | None) -> Sequence[PreparedTest]:
    """The tests of the specs: where a rule is not solved, its boundary is looked for in their inputs."""
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.testing.cases import prepare

    return prepare(compile_paths(paths, project))[0]
