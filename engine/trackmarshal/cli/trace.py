"""The traceability matrix: which requirement is covered at which stage of the V-model, by which rule, test and run.

Tests, scenarios and faults that the evidence store has no result of, from the same inputs, are run before the matrix is made; `--as-is`
reads what is there, and `--rerun` runs everything again and tells what comes out differently.
With --gate, the exit status is 1 when any finding is an error, such as that something is not covered which v-model.yaml demands.

With --from and --to, it says over which links one thing leads to another (`trace --from S-1-A-4 --to test`); with --impact REV, what an edit
means for the evidence.
"""

from __future__ import annotations

import argparse
import sys

from trackmarshal.cli import against, asking, days, impact
from trackmarshal.cli.beside import page_beside
from trackmarshal.cli.output import say, told, write
from trackmarshal.cli.places import configure_relative, shown_from
from trackmarshal.cli.project import find_project
from trackmarshal.errors import TrackmarshalError

FORMATS = ("text", "json", "csv", "md", "markdown", "html", "sarif", "github", "junit")


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--format", choices=FORMATS, default="text")
    configure_relative(parser)
    asking.configure(parser)
    impact.configure(parser)
    against.configure(parser)
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--gate",
        action="store_true",
        help="exit 1 when any finding is an error, such as a gap that nobody waived",
    )
    what.add_argument(
        "--accept-baseline",
        action="store_true",
        help="write down what there is now as accepted, in the baseline",
    )
    parser.add_argument(
        "--by", metavar="NAME", default="", help="with --accept-baseline: who accepts what became weaker"
    )
    parser.add_argument(
        "--reason", metavar="TEXT", default="", help="with --accept-baseline: why that is accepted"
    )
    parser.add_argument("--verbose", action="store_true", help="list what follows from each finding, too")
    days.configure(parser)
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--as-is", action="store_true", help="run nothing; read the evidence that is there")
    how.add_argument(
        "--rerun",
        action="store_true",
        help="run everything again, and compare it with the evidence that is there",
    )


def run(args: argparse.Namespace) -> int:
    from trackmarshal.trace.collector import no_collection

    if args.as_is or asking.asks(args):  # nothing is run, so nothing but records is made
        with no_collection():
            return _run(args)
    return _run(args)


def _run(args: argparse.Namespace) -> int:
    from trackmarshal import trace
    from trackmarshal.cli.assessment import assess
    from trackmarshal.meaning import tool

    root = find_project(args)
    if args.format == "markdown":
        args.format = "md"
    if (args.by or args.reason) and not args.accept_baseline:
        option = "--by" if args.by else "--reason"
        raise TrackmarshalError(
            "T378", f"`{option}` is of an acceptance, and nothing is accepted", help="add `--accept-baseline`"
        )
    if asking.asks(args):
        if args.impact is not None:
            return impact.answer(root, args)
        today = days.day(args.day, root)
        days.warn(args.day, today, root)
        return asking.answer(assess(root, run=False, quiet=args.quiet).matrix(today), args)
    if args.against is not None and args.format != "html":
        raise TrackmarshalError(
            "T364", f"`--against` shows nothing as {args.format}", help="add `--format html`"
        )
    where = shown_from(args, root)
    today = days.day(args.day, root)
    found = assess(root, run=not args.as_is, again=args.rerun, quiet=args.quiet)
    found.store_found += days.doubts(args.day, today, root)
    if args.accept_baseline:
        said = found.facts
        for wrong in said.findings:
            # A file of specs that is not read says nothing, and what it said is not even missed by name.
            if wrong.code.startswith(("E0", "E1")):
                why = f"a spec cannot be read, so that no baseline is accepted: {wrong.message}"
                raise TrackmarshalError(
                    wrong.code, why, help="mend them first; `trackmarshal check` shows where"
                )
        for wrong in found.store_found:
            if wrong.code == "T296":
                raise TrackmarshalError(
                    wrong.code, f"no baseline is accepted: {wrong.message}", help=wrong.help
                )
        target, weaker = trace.accept_baseline(
            root, said.items, said.tests, said.fault_cases, said.parts, said.run_inputs, by=args.by, reason=args.reason,
            today=today, tell=found.weakening(), engine=tool(),
        )  # fmt: skip
        say(f"wrote {target}", *(f"accepted by {args.by}: {change}" for change in weaker), file=sys.stderr)
    matrix = found.matrix(today)
    beside = page_beside(found, matrix, args.against) if args.format == "html" else None
    made = trace.render(matrix, args.format, where=where, verbose=args.verbose, beside=beside)
    if args.format in ("text", "github"):
        say(*made.removesuffix("\n").split("\n"))
    else:
        write(made)
    gaps = trace.gate(matrix) if args.gate else []
    if args.gate and args.format == "text" and not args.quiet:
        print(f"gate: {told(gaps, matrix)}" if gaps else "gate: passed", file=sys.stderr)
    if matrix.unusable:
        return 2
    return 1 if gaps else 0
