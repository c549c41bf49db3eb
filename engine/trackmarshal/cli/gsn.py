"""The argument that the project is safe, as goal structure (GSN): made of the link graph and of the evidence that is there; nothing is run.

trackmarshal gsn                             an outline of it
trackmarshal gsn --format svg --out DIR      a picture a module (needs the extra `gsn`)
trackmarshal gsn --format yaml --out DIR     for gsn2x
trackmarshal gsn --gate                      exit 1 where it is not well formed, is challenged, or does not support its top goal
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli import days
from trackmarshal.cli.output import say, write
from trackmarshal.cli.project import find_project
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import write_whole

if TYPE_CHECKING:
    from trackmarshal.trace.gsn.case import Case, Module

#: Formats, and what files of them end with.
ENDINGS = {"text": ".txt", "svg": ".svg", "yaml": ".gsn.yaml", "json": ".json"}


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--format", choices=tuple(ENDINGS), default="text")
    parser.add_argument("--module", metavar="NAME", help="only this one (default: all)")
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="files into this folder, of svg and yaml one a module, and nothing on the standard output",
    )
    parser.add_argument(
        "--gate", action="store_true", help="exit 1 when something is wrong with the argument"
    )
    days.configure(parser)


def run(args: argparse.Namespace) -> int:
    """Show the argument; 1 with --gate where something is wrong with it, 2 where a document cannot be read. Raises T348, T424 to T427."""
    from trackmarshal.cli.assessment import assess
    from trackmarshal.trace.gsn.building import build

    root = find_project(args)
    today = days.day(args.day, root)
    days.warn(args.day, today, root)
    found = assess(root, run=False, quiet=args.quiet)
    matrix = found.matrix(today)
    case = build(matrix, found.project, root)
    made = _rendered(case, _chosen(case, args.module), args)
    if args.out is not None:
        _write(Path(args.out), made, args.quiet)
    elif args.format == "text":
        for text in made.values():
            say(*text.removesuffix("\n").split("\n"))
    else:
        write("".join(made.values()))
    found_wrong = (*matrix.misread, *case.findings)
    for finding in found_wrong:
        say(*str(finding).split("\n"), file=sys.stderr)
    wrong = [finding for finding in found_wrong if finding.level == "error"]
    if args.gate and not args.quiet:
        said = f"{len(wrong)} error{'s' if len(wrong) > 1 else ''}" if wrong else "passed"
        print(f"gate: {said}", file=sys.stderr)
    if matrix.unusable:
        return 2
    return 1 if args.gate and wrong else 0


def _chosen(case: Case, name: str | None) -> list[Module]:
    from trackmarshal.diagnostics.base import close_matches

    if name is None:
        return list(case.modules)
    chosen = [module for module in case.modules if module.name == name]
    if not chosen:
        help_ = close_matches(name, [m.name for m in case.modules]) or "`trackmarshal gsn` names them all"
        raise TrackmarshalError("T426", f"the argument has no module `{name}`", help=help_)
    return chosen


def _rendered(argument: Case, modules: list[Module], args: argparse.Namespace) -> dict[str, str]:
    """Texts by the names of their files."""
    from trackmarshal.trace.case.words.language import english
    from trackmarshal.trace.gsn import gsn2x, outline, records
    from trackmarshal.trace.gsn.picture.svg import pictures
    from trackmarshal.trace.report.pages import page_names

    ending = ENDINGS[args.format]
    stems = page_names([module.name for module in argument.modules])
    files = {module.name: f"{stem}{ending}" for module, stem in zip(argument.modules, stems)}
    if args.out is None and len(modules) > 1 and args.format in ("svg", "yaml"):
        message = f"the argument has {len(modules)} modules, each {'a picture' if args.format == 'svg' else 'a file'} of its own"
        raise TrackmarshalError(
            "T427", message, help="give a folder with `--out`, or one of them with `--module`"
        )
    match args.format:
        case "svg":
            return dict(zip((files[m.name] for m in modules), pictures(argument, modules, files, english())))
        case "yaml":
            return {files[m.name]: gsn2x.render(argument, m) for m in modules}
        case "json":
            return {f"argument{ending}": records.render(argument, modules)}
        case "text":
            return {f"argument{ending}": outline.render(argument, modules)}
        case other:
            raise ValueError(f"unknown format {other!r}")


def _write(folder: Path, made: dict[str, str], quiet: bool) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in made.items():
        write_whole(folder / name, text.encode("utf-8", "replace"))
    if not quiet:
        say(f"{folder}: {len(made)} {'file' if len(made) == 1 else 'files'}", file=sys.stderr)
