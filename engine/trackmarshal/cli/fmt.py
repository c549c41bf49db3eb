"""Lay out spec files in the one layout. Comments stay; nothing else of the meaning changes.

With --check nothing is written, and files that would change are named.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from trackmarshal.cli.output import print_problem, say
from trackmarshal.cli.project import find_project, spec_folders
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import write_whole


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "paths", nargs="*", metavar="PATH", help="spec files or folders (default: the project's specs)"
    )
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when a file would change")


def run(args: argparse.Namespace) -> int:
    from trackmarshal.diagnostics.base import Diagnostics
    from trackmarshal.semantics.modules import spec_files
    from trackmarshal.source import read
    from trackmarshal.syntax.format import format_text

    paths = [Path(p) for p in args.paths] or spec_folders(find_project(args))
    status, changed, seen = 0, 0, 0
    for path in (file for given in paths for file in spec_files(given)):
        seen += 1
        try:
            text = format_text(read(path, _shown(path)))
        except TrackmarshalError as error:
            print_problem(error)
            status = max(status, 1 if isinstance(error, Diagnostics) else 2)
            continue
        if text.encode() == path.read_bytes():
            continue
        changed += 1
        if args.check:
            say(f"would lay out {_shown(path)}")
            status = max(status, 1)
        else:
            write_whole(path, text.encode())
            if not args.quiet:
                say(f"laid out {_shown(path)}")
    if not args.quiet and not changed and not status:
        print(f"{seen} file{'' if seen == 1 else 's'}, nothing to change", file=sys.stderr)
    return status


def _shown(path: Path) -> str:
    """As it is called from here, where it lies below: the project's own folders are whole paths."""
    here = Path.cwd()
    return str(path.relative_to(here) if path.is_relative_to(here) else path)
