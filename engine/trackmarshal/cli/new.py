"""Write the next piece of the project: it passes `check` at once, and has a TODO where its author has to write.

trackmarshal new requirement R-2
trackmarshal new rule keep_left --satisfies R-2
trackmarshal new scenario overtaken
trackmarshal new rulebook order

Nothing that is there is changed.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.output import say
from trackmarshal.cli.project import find_project, spec_folders

if TYPE_CHECKING:
    from trackmarshal.start.pieces import Place

PIECES = ("rule", "requirement", "rulebook", "scenario")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("piece", choices=PIECES)
    parser.add_argument(
        "name", metavar="NAME", help="what it is called; a requirement's is an id such as R-2"
    )
    parser.add_argument(
        "--satisfies", action="append", default=[], metavar="ID",
        help="of a rule: a requirement that it implements (repeatable)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    from trackmarshal.errors import TrackmarshalError
    from trackmarshal.start import pieces

    if args.satisfies and args.piece != "rule":
        raise TrackmarshalError(
            "E413",
            f"a {args.piece} satisfies nothing",
            help="leave out --satisfies: rules name requirements",
        )
    root = find_project(args)
    place = _place(root)
    if args.piece == "rule":
        made = pieces.rule(place, args.name, tuple(dict.fromkeys(args.satisfies)))
    elif args.piece == "requirement":
        made = pieces.requirement(place, args.name)
    elif args.piece == "rulebook":
        made = pieces.rulebook(place, args.name)
    elif args.piece == "scenario":
        made = pieces.scenario(place, args.name)
    else:
        raise AssertionError(f"unknown piece {args.piece}")
    if not args.quiet:
        say(*(f"wrote {path.relative_to(root)}" for path in made.written))
        say(*(f"next: {line}" for line in made.next))
    return 0


def _place(root: Path) -> Place:
    """The project as it is; raises for specs and requirements that have errors, which are there to be mended first."""
    from trackmarshal.cli.check import demanded
    from trackmarshal.semantics.compile import compile_paths
    from trackmarshal.start.pieces import Place
    from trackmarshal.trace import requirements

    project = requirements.load(root, [])
    known, unreadable = demanded(root)
    if unreadable:
        raise unreadable[0]
    specs = spec_folders(root, project)
    compiled = compile_paths(specs, root)
    compiled.raise_errors()
    folder = specs[0] if specs[0].is_dir() else specs[0].parent
    return Place(root, folder, tuple(specs), compiled, frozenset(known))
