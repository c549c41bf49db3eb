"""What an error code means, or why a rule said what it said in one cycle of a recording, with the numbers.

trackmarshal explain E301
trackmarshal explain run.tmrec.jsonl --rule friction --at 2.6
"""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.giving import choose_given, refuse_given, with_given
from trackmarshal.cli.options import configure_with
from trackmarshal.cli.output import say
from trackmarshal.cli.project import find_project, optional_project
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.scenarios.recording import Recording

CODES = {
    "E441": ("unknown code", "`explain` takes a code as messages show it: a letter and three digits, such as E301."),
    "E442": ("what to explain is not clear", "To explain a verdict, name the rule and the time: `explain RECORDING --rule R --at T`. T is the time of a cycle."),
}  # fmt: skip


_CODES_HELP = (
    "E and W are about specs and commands, D about data, T about traceability; docs/errors.md lists all"
)


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", metavar="CODE|RECORDING", help="an error code, or a recording")
    parser.add_argument("--rule", metavar="R")
    parser.add_argument("--at", metavar="T", type=float, help="time of the cycle in s")
    parser.add_argument("--candidate", choices=("driving", "emergency"), help="default: both")
    parser.add_argument(
        "--spec",
        action="append",
        metavar="SPEC",
        help="spec file or folder (repeatable; default: the project's)",
    )
    configure_with(parser)
    choose_given(parser)


def run(args: argparse.Namespace) -> int:
    if re.fullmatch(r"[A-Za-z]\d{3}", args.what) and not Path(args.what).exists():
        return _code(args.what.upper())
    if args.rule is None or args.at is None:
        raise TrackmarshalError(
            "E442",
            f"`{args.what}` is no code",
            help="a code is a letter and three digits, such as E301; for a recording, add --rule R --at T",
        )
    return _verdict(args)


def _code(code: str) -> int:
    from trackmarshal.cli.catalogue import catalogue
    from trackmarshal.diagnostics.base import close_matches

    known = catalogue()
    if code not in known:
        raise TrackmarshalError(
            "E441", f"there is no code {code}", help=close_matches(code, known) or _CODES_HELP
        )
    title, text = known[code]
    print(f"{code}: {title}\n")
    print(textwrap.fill(text, 88))
    return 0


def _verdict(args: argparse.Namespace) -> int:
    from trackmarshal.cli.record import is_record
    from trackmarshal.cli.replay import default_spec, evaluator_for, overruled
    from trackmarshal.ir.spec import remembers
    from trackmarshal.scenarios import load
    from trackmarshal.scenarios.fields import other_spec
    from trackmarshal.scenarios.overrides import known_tables
    from trackmarshal.units import in_full, moment

    if is_record(args.what):
        refuse_given(args, args.what)
    spec_path, *more = map(Path, args.spec) if args.spec else [default_spec(find_project(args))]
    settings = [Path(p) for p in args.settings]
    recording = overruled(load(args.what), spec_path, settings, more)
    recording = with_given(recording, args.given, args.because)
    project = optional_project(args)
    evaluator = evaluator_for(recording, spec_path, settings, project, [args.rule], "reference", more=more)
    other = other_spec(recording, evaluator)
    if other and not args.quiet:
        say(f"note: {recording.name}: {other}", file=sys.stderr)
    # What is not known of a run may be why its own verdict was another one.
    for note in recording.notes if recording.of_run is not None and not args.quiet else ():
        say(f"note: {recording.name}: {note}", file=sys.stderr)
    place, cycle = min(enumerate(recording.cycles), key=lambda entry: abs(entry[1].t - args.at))
    if not abs(cycle.t - args.at) <= 1e-6:  # NaN too
        raise TrackmarshalError(
            "E442",
            f"no cycle at t = {in_full(args.at, 's')}",
            help=f"the nearest is at {in_full(cycle.t, 's')}",
        )
    candidates = [args.candidate] if args.candidate else list(cycle.candidates)
    for candidate in candidates:
        recording.signals(cycle, candidate)  # refuses a candidate that is not there
    tables, _ = known_tables(recording, evaluator.spec)
    if remembers(evaluator.rules[0]):
        # What was driven, which the others decide on too, is part of what is remembered.
        every = evaluator_for(recording, spec_path, settings, project, None, "numpy", more=more)
        found = _over_run(recording, every, tables, place, candidates, args.rule)
    else:
        found = _alone(recording, evaluator, tables, place, candidates)
    for candidate, lines in found:
        say(f"{recording.name}, t = {moment(cycle.t)} s, {candidate}", *lines)
    return 0


def _alone(
    recording: Recording, evaluator: Evaluator, tables: Mapping[str, Any], place: int, candidates: Sequence[str]
) -> Iterator[tuple[str, list[str]]]:  # fmt: skip
    from trackmarshal.backends.reference.evaluator import Reference
    from trackmarshal.backends.results import outcome, rule_result
    from trackmarshal.explaining.telling import told
    from trackmarshal.scenarios.supervised import frame_at

    frame, rule = frame_at(recording, evaluator, tables, place), evaluator.rules[0]
    for candidate in candidates:
        case = frame.of(candidate)
        values = Reference(evaluator.spec, case)
        result = rule_result(rule, case, values, outcome(rule, case, values)[:2])
        yield candidate, told(rule, result, values)


def _over_run(
    recording: Recording, evaluator: Evaluator, tables: Mapping[str, Any], place: int, candidates: Sequence[str], name: str
) -> Iterator[tuple[str, list[str]]]:  # fmt: skip
    from trackmarshal.backends.over_run.history import History
    from trackmarshal.backends.over_run.keeping import past
    from trackmarshal.explaining.course import along_course
    from trackmarshal.explaining.telling import told, told_over_run
    from trackmarshal.scenarios.supervised import run_until

    judged, before, missing = run_until(recording, evaluator, tables, place)
    number = [rule.name for rule in evaluator.rules].index(name)
    rule = evaluator.rules[number]
    for candidate in candidates:
        this = past(evaluator.spec, judged.about.of(candidate), missing)
        result = judged.rated[candidate].explain(number, False)
        if rule.course is not None:
            yield candidate, told(rule, result, along_course(rule, [*before, this]))
        else:
            yield candidate, told_over_run(rule, result, History([*before, this]))
