"""Generate recordings from their declarations: the same declaration gives the same recording, byte for byte.

trackmarshal scenario specs/scenarios/cut_in.yaml --out specs/scenarios/cut_in.tmrec.jsonl
"""

from __future__ import annotations

import argparse
from pathlib import Path

from trackmarshal.cli.output import say
from trackmarshal.errors import TrackmarshalError


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("declaration", metavar="YAML")
    parser.add_argument("--out", metavar="FILE", help="default: the declaration's name with .tmrec.jsonl")


def run(args: argparse.Namespace) -> int:
    from trackmarshal.scenarios.generate import generate
    from trackmarshal.scenarios.recording_io import moved, write

    declaration = Path(args.declaration)
    target = Path(args.out) if args.out else declaration.with_suffix(".tmrec.jsonl")
    recording = generate(declaration)
    if target.exists() and target.samefile(declaration):
        raise TrackmarshalError(
            "D120", "the declaration itself is no place for its recording", file=str(target), help="another FILE, such as one that ends in .tmrec.jsonl"
        )  # fmt: skip
    write(moved(recording, declaration, target), target)
    if not args.quiet:
        say(f"{target}: {len(recording.cycles)} cycles")
    return 0
