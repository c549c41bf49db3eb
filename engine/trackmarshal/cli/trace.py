"""The traceability matrix: which requirement is covered at which stage of the V-model, by which rule, test and run.

Tests are run, and scenarios and faults whose results are missing or stale, before the matrix is made; `--as-is` reads the results
that are there. With --gate, the exit status is 1 when something that v-model.yaml demands is not covered.
"""

from __future__ import annotations

import argparse
import sys

from trackmarshal.cli.output import say
from trackmarshal.cli.project import find_project

FORMATS = ("text", "json", "csv", "md", "html", "sarif", "github")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--format", choices=FORMATS, default="text")
    parser.add_argument("--gate", action="store_true", help="exit 1 when a gap is neither covered nor waived")
    parser.add_argument("--as-is", action="store_true", help="run nothing; read the results that are there")
    parser.add_argument(
        "--accept-baseline", action="store_true", help="write the present tests of each rule to the baseline"
    )


def run(args: argparse.Namespace) -> int:
    from trackmarshal import trace
    from trackmarshal.cli.assessment import assess

    root = find_project(args)
    found = assess(root, run=not args.as_is, quiet=args.quiet)
    if args.accept_baseline:
        target = trace.accept_baseline(root, found.items, found.tests, found.fault_cases)
        say(f"wrote {target}", file=sys.stderr)
    matrix = found.matrix()
    made = trace.render(matrix, args.format)
    if args.format in ("text", "github"):
        say(*made.removesuffix("\n").split("\n"))
    else:
        print(made, end="")
    gaps = trace.gate(matrix) if args.gate else []
    if args.gate and args.format == "text" and not args.quiet:
        print(f"gate: {len(gaps)} gaps" if gaps else "gate: passed", file=sys.stderr)
    if matrix.unusable:
        return 2
    return 1 if gaps else 0
