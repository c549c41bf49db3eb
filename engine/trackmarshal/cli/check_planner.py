"""Hold a planner's cycles against the input contract, and say in words what does not fit.

trackmarshal check-planner cycles.jsonl --adapter adapter.py

Takes a recording, or JSON Lines with one object a cycle, with columns of any names. What they stand for is found by their names and by their
numbers: which column is the derivative of which, which follows the direction of travel in which convention. --adapter writes the suggested
mapping as Python. The exit status is 1 when something does not fit as it is.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from trackmarshal.cli.options import configure_with
from trackmarshal.cli.output import dump, say
from trackmarshal.cli.project import find_project, optional_project


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("cycles", metavar="FILE", help="a recording, or JSON Lines with one object a cycle")
    parser.add_argument("--spec", metavar="SPEC", help="spec file or folder (default: the project's)")
    parser.add_argument(
        "--most", type=int, default=100, metavar="N", help="how many cycles are looked at (default: 100)"
    )
    parser.add_argument(
        "--driving",
        metavar="PATH",
        help="where the driving trajectory is in a cycle, such as `plans.nominal`",
    )
    parser.add_argument("--emergency", metavar="PATH", help="the same of the emergency trajectory")
    parser.add_argument(
        "--adapter", metavar="FILE", help="write the suggested mapping as Python (a new file)"
    )
    parser.add_argument("--format", choices=("text", "json"), default="text")
    configure_with(parser)


def run(args: argparse.Namespace) -> int:
    from trackmarshal.cli.replay import default_spec
    from trackmarshal.evaluation import load
    from trackmarshal.integration.planner import check_planner
    from trackmarshal.start.writing import refuse_present

    if args.adapter:  # what somebody has looked over is not written over
        refuse_present(Path(), [args.adapter])
    spec_path = Path(args.spec) if args.spec else default_spec(find_project(args))
    spec = load([spec_path], [Path(path) for path in args.settings], optional_project(args))
    report = check_planner(args.cycles, spec, args.most, args.driving, args.emergency)
    if args.adapter:
        with open(args.adapter, "x", encoding="utf-8") as file:
            file.write(report.adapter)
    if args.format == "json":
        print(dump(report.as_json()))
    else:
        say(*report.lines())
        if args.adapter and not args.quiet:
            say(f"the adapter is in {args.adapter}: look it over")
    return 0 if report.fits else 1
