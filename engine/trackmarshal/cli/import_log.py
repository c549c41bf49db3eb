"""A vehicle's log as a recording, by a declared mapping (docs/field.md), and what the rules say of it, with causes.

trackmarshal import log drive.csv --map map.yaml --out drive.tmrec.jsonl.gz

Without FILE, the log that the mapping names. The exit status is 1 where something fires that is neither noise nor a gap of the map.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.output import progress, say, table
from trackmarshal.cli.project import find_project, from_project, optional_project
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import other_there
from trackmarshal.records.runs import DriveFacts, LeastMargin, RuleFacts, RunSummary

if TYPE_CHECKING:
    from trackmarshal.scenarios.field.build import Drive
    from trackmarshal.scenarios.field.judged import Judgement
    from trackmarshal.scenarios.field.report import Report

CODES = {
    "E435": (
        "a run that cannot be kept as evidence",
        "`--keep` keeps the run that the mapping declares, of the whole spec of the project: what is kept with other times, rules or values would say "
        "of itself that it is that run. What is kept also has to be the run of a project.",
    ),
}  # fmt: skip


def run(args: argparse.Namespace) -> int:
    from trackmarshal.scenarios.field import mapping as mappings
    from trackmarshal.scenarios.field.build import build
    from trackmarshal.scenarios.recording_io import moved, write

    _may_keep(args)
    for option, time in (("--from", args.begin), ("--to", args.end)):
        if time is not None and not 0.0 <= time <= mappings.LATEST:  # NaN too
            args.refuse(f"{option} is a time from 0 to {mappings.LATEST:g} s, not {time:g}")
    mapping = mappings.read(Path(args.map))
    if args.begin is not None:
        mapping = replace(mapping, begin=args.begin)
    if args.end is not None:
        mapping = replace(mapping, end=args.end)
    drive = build(mapping, Path(args.file) if args.file else None)
    if args.out:
        write(moved(drive.recording, Path(args.map), Path(args.out)), args.out)
        if not args.quiet:
            say(f"{args.out}: {len(drive.recording.cycles)} cycles", file=sys.stderr)
    return 0 if args.no_report else _report(args, drive)


def _may_keep(args: argparse.Namespace) -> None:
    """Raise E435 where what would be kept is not the run that the mapping declares."""
    if not args.keep:
        return
    if other_there(Path(args.keep), b'"holds": "runs"'):
        raise TrackmarshalError(
            "E435", "is there already, and is no run that was kept", file=args.keep, help="choose another name with `--keep`"
        )  # fmt: skip
    named = {
        "--from": args.begin is not None, "--to": args.end is not None, "--no-report": args.no_report, "--spec": args.spec is not None,
        "--rule": bool(args.rule), "--with": bool(args.settings), "FILE": args.file is not None,
    }  # fmt: skip
    other = [name for name, given in named.items() if given]
    if other:
        message = f"`--keep` keeps the run that the mapping declares, not one with {' and '.join(other)}"
        raise TrackmarshalError(
            "E435", message, file=args.map, help="write it into the mapping, or leave it out"
        )


def _report(args: argparse.Namespace, drive: Drive) -> int:
    from trackmarshal.cli.evidence import keep
    from trackmarshal.cli.replay import default_spec, evaluator_for
    from trackmarshal.scenarios.field import report as reports
    from trackmarshal.scenarios.field.build import as_it_is
    from trackmarshal.scenarios.field.causes import MAP, NOISE
    from trackmarshal.scenarios.field.judged import judge
    from trackmarshal.scenarios.field.limits import limits

    project = optional_project(args)
    spec_path = Path(args.spec) if args.spec else default_spec(find_project(args))
    settings = [Path(name) for name in args.settings]
    evaluator = evaluator_for(drive.recording, spec_path, settings, project, args.rule, "numpy")
    judged = judge(
        drive.recording, evaluator, lambda chunks: progress(chunks, drive.recording.name, args.quiet)
    )
    logged = None
    if drive.smoother:
        raw = as_it_is(drive)
        logged = raw, judge(raw.recording, evaluator)
    made = reports.report(drive, judged, logged, limits(judged) if args.limits else None)
    if args.format == "json":
        print(json.dumps(reports.data(made), ensure_ascii=True, allow_nan=False))
    else:
        say(*reports.text(made, table))
    if args.keep:
        keep(Path(args.keep), "runs", [_summary(made, judged, find_project(args))])
        if not args.quiet:
            say(f"{args.keep}: the run is kept as evidence", file=sys.stderr)
    return int(any(one.cause not in (MAP, NOISE) for one in made.firings))


def _summary(made: Report, judged: Judgement, root: Path) -> RunSummary:
    """The run as evidence: what every rule said, how near it came to firing, and all that it was made from, by paths from the project."""
    import numpy as np

    from trackmarshal.cli.evidence import file_hash, now, run_inputs
    from trackmarshal.runtime.verdict import VERDICTS
    from trackmarshal.scenarios.inputs import defaulted
    from trackmarshal.scenarios.overrides import overrides
    from trackmarshal.scenarios.recording import CANDIDATES

    drive, unsafe, spec = made.drive, judged.unsafe, judged.evaluator.spec
    inputs = run_inputs(judged.evaluator, None)
    facts = []
    for number, rule in enumerate(judged.evaluator.rules):
        counts = {
            name: {VERDICTS[code]: int(count) for code, count in zip(*np.unique(judged.codes[:, place, number], return_counts=True))}
            for place, name in enumerate(CANDIDATES)
        }  # fmt: skip
        violated = np.flatnonzero((judged.codes[:, :, number] == VERDICTS.index("violated")).any(axis=1))
        first = float(judged.times[violated[0]]) if len(violated) else None
        facts.append(RuleFacts(rule.name, inputs[f"rule {rule.name}"], counts, first))
    source = drive.mapping.path
    made_from = {from_project(root, path): digest for path, digest in drive.sources.items()}
    return RunSummary(
        from_project(root, source), file_hash(source), judged.evaluator.spec.fingerprint, len(judged.times), tuple(facts), {},
        bool(unsafe.any()) or bool(judged.faults), now(), dict(sorted(made_from.items())), inputs=inputs,
        overrides=tuple(map(str, overrides(drive.recording, spec))),
        defaults={name: ", ".join(rules) for name, rules in defaulted(drive.recording, spec, judged.evaluator.rules).items()},
        drive=_driven(made),
    )  # fmt: skip


def _driven(made: Report) -> DriveFacts:
    """What the drive was and how near rules came to firing, rounded to what a reader can use; firings that the map is the cause of are left out."""
    from trackmarshal.scenarios.field.causes import MAP

    least = (
        LeastMargin(one.rule, one.candidate, float(f"{one.margin:.6g}"), one.said, round(one.t, 3))
        for one in made.margins
        if math.isfinite(one.margin)
    )
    firings = Counter(one.rule for one in made.firings if one.cause != MAP)
    return DriveFacts(round(made.hours, 6), round(made.km, 6), dict(sorted(firings.items())), tuple(least))
