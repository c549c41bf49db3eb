"""Run a Supervisor as a process of its own: generated C that takes cycles, and gives decisions, over shared memory or datagrams.

trackmarshal serve specs/supervisor --with specs/tracks/northfield.spec --shm supervisor --describe messages.json

It is compiled once for its content; then this process becomes it, and runs until it is told to end. docs/process.md describes messages
and clients.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from trackmarshal.cli.options import choose_limits, choose_rules, limits_of
from trackmarshal.cli.output import write_out
from trackmarshal.cli.project import optional_project
from trackmarshal.errors import TrackmarshalError

#: As many other ports as process.c has room for (MOST_LISTENERS).
MOST_LISTENERS = 8


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("spec", metavar="SPEC", help="a .spec file, or a folder of them")
    choose_rules(parser, "supervise by")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--shm", metavar="NAME", help="over shared memory of this name; with a slash, a path")
    where.add_argument("--udp", metavar="PORT", type=int, help="over datagrams to this port of this machine")
    where.add_argument("--build", action="store_true", help="only compile it, and print the program's path")
    parser.add_argument(
        "--to", action="append", default=[], type=int, metavar="PORT",
        help=f"a port that decisions go to as well, for whoever executes them (datagrams; repeatable, {MOST_LISTENERS} at most)",
    )  # fmt: skip
    parser.add_argument(
        "--wait", choices=("sleep", "poll", "spin"), default="sleep",
        help="what it does between cycles: sleep until it is woken, look every 50 us, or keep a processor busy with looking",
    )  # fmt: skip
    parser.add_argument(
        "--simulated",
        action="store_true",
        help="its clock is that of the messages: for simulations, never in a vehicle",
    )
    parser.add_argument(
        "--describe", metavar="FILE", help="write the description of its messages (JSON), which clients read"
    )
    choose_limits(parser)


def run(args: argparse.Namespace) -> int:
    from trackmarshal.backends.c.process.description import text_of
    from trackmarshal.backends.c.supervised.contract import unfit
    from trackmarshal.evaluation import Evaluator, broken_constraints, load
    from trackmarshal.process.serving import build

    if args.to and args.udp is None:
        raise TrackmarshalError(
            "E477", "--to is for datagrams", help="in shared memory anybody may read decisions"
        )
    for port in [*args.to, *([args.udp] if args.udp is not None else [])]:
        if not 1 <= port <= 65_535:
            raise TrackmarshalError("E477", f"{port} is no port", help="1 to 65535")
    if args.udp in args.to:
        raise TrackmarshalError(
            "E477", f"cycles come to port {args.udp}, and decisions would, too", help="another port for --to"
        )
    if len(args.to) > MOST_LISTENERS:
        raise TrackmarshalError(
            "E477",
            f"decisions would go to {len(args.to)} other ports, and there is room for {MOST_LISTENERS}",
            help="let one of those who hear them pass them on",
        )
    spec = load([Path(args.spec)], [Path(path) for path in args.settings], optional_project(args))
    broken = broken_constraints(spec)
    if broken:
        raise TrackmarshalError(
            "E403", broken[0], help="change the parameters in the spec or the configuration"
        )
    why = unfit(spec)
    if why:
        raise TrackmarshalError("E477", f"no Supervisor can be made of this spec: {why}", help="see E482")
    built = build(spec, Evaluator(spec, args.rule, "reference").rules, limits_of(args, spec))
    if args.describe:
        said = text_of(built.layout.said).encode()
        write_out(args.describe, said, b'"trackmarshal-messages"', "description of messages")
    if args.build:
        print(built.path)
        return 0
    if args.simulated and not args.quiet:
        print("note: in simulated time, which no vehicle drives in", file=sys.stderr)
    command = built.command(shm=args.shm, udp=args.udp, to=args.to, wait=args.wait, simulated=args.simulated)
    sys.stdout.flush()
    os.execv(command[0], command)  # never returns
