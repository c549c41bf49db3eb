"""Questions to the link graph, as `trace` takes them: paths from one thing to another, and numbers."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from trackmarshal.cli.output import say
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.trace import Matrix


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--from", dest="source", metavar="ID|KIND", help="which links lead from here, to --to; runs nothing"
    )
    parser.add_argument(
        "--to", dest="target", metavar="ID|KIND", help="a kind such as `test`, or an id such as `S-1-A-*`"
    )
    parser.add_argument(
        "--statistics", action="store_true", help="how many nodes and links there are; runs nothing"
    )


def asks(args: argparse.Namespace) -> bool:
    """Whether a question is asked, in place of the matrix, that of `--impact` among them; raises T169 for half of one, and beside what a question does not do."""
    if (args.source is None) != (args.target is None):
        raise TrackmarshalError(
            "T169",
            "`--from` and `--to` belong together",
            help="`trackmarshal trace --from requirement --to test`",
        )
    question = args.source is not None or args.statistics
    if not (question or args.impact is not None):
        return False
    for option, given in (
        ("--gate", args.gate), ("--accept-baseline", args.accept_baseline), ("--rerun", args.rerun), ("--impact", question and args.impact is not None),
        ("--against", args.against is not None), ("--day", args.impact is not None and args.day is not None),
    ):  # fmt: skip
        if given:
            raise TrackmarshalError(
                "T169",
                f"`{option}` says nothing beside a question",
                help="run `trackmarshal trace` once for each",
            )
    return True


def answer(matrix: Matrix, args: argparse.Namespace) -> int:
    """Print the answer, and what it lacks since it could not be read; 2 where that is a document, or all rules. Raises T169 for names of nothing, and
    for formats that are no table."""
    from trackmarshal.trace.graph.paths import named, paths
    from trackmarshal.trace.graph.statistics import numbers
    from trackmarshal.trace.render import answers

    if args.format not in answers.FORMATS:
        raise TrackmarshalError(
            "T169",
            f"a question has no answer as {args.format}",
            help="formats are " + ", ".join(answers.FORMATS),
        )
    if args.format == "csv" and args.source is not None and args.statistics:
        raise TrackmarshalError(
            "T169",
            "paths and numbers are two tables, and CSV is one",
            help="ask twice, or for `--format json`",
        )
    for finding in matrix.misread:
        say(*str(finding).split("\n"), file=sys.stderr)
    graph = matrix.graph
    counted = numbers(matrix) if args.statistics else None
    if args.source is not None:
        found = paths(graph, named(graph, args.source), named(graph, args.target))
        made = answers.paths(graph, found, args.format, counted)
    else:
        made = answers.numbers(counted or [], args.format)
    if args.format == "text":
        say(*made.removesuffix("\n").split("\n"))
    else:
        print(made, end="")
    # Of specs with errors there is no rule and no test in the graph: that nothing leads there is no answer.
    broken = any(one.level == "error" and one.code.startswith("E") for one in matrix.misread)
    return 2 if matrix.unusable or broken else 0


__all__ = ["answer", "asks", "configure"]
