"""The project's requirements for another tool (docs/exchange.md).

trackmarshal export requirements --format reqif --out requirements.reqif
"""

from __future__ import annotations

import argparse
import os
import sys
from datetime import UTC, datetime
from pathlib import Path

from trackmarshal.cli.output import count, say, write_out
from trackmarshal.cli.project import find_project

#: What stands near the beginning of whatever was exported, by format.
_MARKS = {"reqif": b"<REQ-IF", "needs": b'"current_version"', "csv": b"document_title"}


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", choices=("requirements",), help="what is exported")
    parser.add_argument(
        "--format", choices=("reqif", "needs", "csv"), help="default: what the name after --out ends with"
    )
    parser.add_argument("--out", metavar="FILE", help="write it there (default: standard output)")


def run(args: argparse.Namespace) -> int:
    """Write the requirements; 2 where something is wrong with them, and then nothing is written."""
    from trackmarshal.trace import exchange, load

    if args.format is None and args.out is None:
        raise exchange.Refused(
            "T360",
            "nothing says what format is to be written",
            "",
            help="say it with `--format`, or name a file with `--out`",
        )
    format = args.format or exchange.format_of(Path(args.out))
    root = find_project(args)
    project, found = load(root)
    documents = exchange.of_project(root, [])
    problems = [*(one for one in found if one.level == "error"), *exchange.check(documents)]
    for problem in problems:
        say(*str(problem).split("\n"), file=sys.stderr)
    if problems:
        return 2
    data = exchange.export(documents, format, project.name, _created())
    if args.out is None:
        sys.stdout.buffer.write(data)
        return 0
    write_out(args.out, data, _MARKS[format], f"list of requirements as {format}")
    if not args.quiet:
        say(
            f"{args.out}: {count(sum(len(document.requirements) for document in documents), 'requirement')}",
            file=sys.stderr,
        )
    return 0


def _created() -> datetime:
    """Now, or what SOURCE_DATE_EPOCH says, so that the same requirements can be the same file; raises T366 for what is no time."""
    from trackmarshal.trace.exchange import Refused

    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    if not given:
        return datetime.now(UTC).replace(microsecond=0)
    try:
        if not (given.isascii() and given.isdigit()):
            raise ValueError(given)
        return datetime.fromtimestamp(int(given), UTC)
    except (ValueError, OverflowError, OSError) as error:
        help_ = "give whole seconds since 1970, as `git log -1 --format=%ct` prints them, or leave it out"
        raise Refused("T366", f"SOURCE_DATE_EPOCH is {given!r}, which is no time", "", help=help_) from error
