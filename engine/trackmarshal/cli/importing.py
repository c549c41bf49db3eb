"""What others have, taken over: a vehicle's log as a recording (docs/field.md), or requirements of another tool (docs/exchange.md).

trackmarshal import log drive.csv --map map.yaml --out drive.tmrec.jsonl.gz
trackmarshal import requirements door.reqif --out requirements/door.yaml

Of a log, the exit status is 1 where something fires that is neither noise nor a gap of the map; without FILE, it is the one that the mapping names.
"""

from __future__ import annotations

import argparse

from trackmarshal.cli import import_log, import_requirements
from trackmarshal.cli.options import choose_rules

#: Options that one of both has, by the name under which they are read.
_OF_LOG = {
    "map": "--map", "begin": "--from", "end": "--to", "no_report": "--no-report", "limits": "--limits", "keep": "--keep",
    "spec": "--spec", "rule": "--rule", "settings": "--with",
}  # fmt: skip
#: Those that say something of the report.
_OF_REPORT = ("limits", "spec", "rule", "settings")
_OF_REQUIREMENTS = {"force": "--force", "fields": "--field", "defaults": "--default"}


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", choices=("log", "requirements"), help="what is imported")
    parser.add_argument(
        "file", nargs="?", metavar="FILE", help="the log, CSV (also .gz) or MCAP; or the requirements"
    )
    parser.add_argument(
        "--out",
        metavar="FILE",
        help="write the recording (.tmrec.jsonl, also .gz), or the requirements (.yaml; a folder where there are several lists)",
    )
    parser.add_argument(
        "--format",
        choices=("text", "json", "reqif", "needs", "csv"),
        help="of a log's report: text or json; of requirements: what FILE holds",
    )
    log = parser.add_argument_group("log")
    log.add_argument("--map", metavar="MAP", help="the mapping: columns, units, conventions, track, vehicle")
    log.add_argument(
        "--from", dest="begin", type=float, metavar="S", help="from here on, s; default: the mapping's"
    )
    log.add_argument("--to", dest="end", type=float, metavar="S")
    log.add_argument("--no-report", action="store_true", help="only make the recording")
    log.add_argument(
        "--limits",
        action="store_true",
        help="also search at which values of their parameters rules would have fired first",
    )
    log.add_argument("--keep", metavar="FILE", help="keep the run as evidence for the traceability matrix")
    log.add_argument("--spec", metavar="SPEC", help="spec file or folder (default: the project's)")
    choose_rules(parser, "evaluate")
    requirements = parser.add_argument_group("requirements")
    requirements.add_argument("--force", action="store_true", help="write over what is there")
    requirements.add_argument(
        "--field",
        dest="fields",
        action="append",
        default=[],
        metavar="FIELD=NAME",
        help="what the other tool calls a field, such as statement=Text",
    )
    requirements.add_argument(
        "--default",
        dest="defaults",
        action="append",
        default=[],
        metavar="FIELD=TEXT",
        help="what a field is where the other tool does not say it, such as asil=QM",
    )
    parser.set_defaults(refuse=parser.error)


def run(args: argparse.Namespace) -> int:
    log = args.what == "log"
    for name, option in (_OF_REQUIREMENTS if log else _OF_LOG).items():
        if getattr(args, name) not in (None, False, []):
            args.refuse(f"`import {args.what}` has no such option: {option}")
    if args.format is not None and (args.format in ("text", "json")) != log:
        args.refuse(f"`import {args.what}` has no format `{args.format}`")
    if log:
        if not args.map:
            args.refuse("the following arguments are required: --map")
        if args.no_report and not args.keep:  # which refuses it itself
            _refuse_unheard(args)
        args.format = args.format or "text"
        return import_log.run(args)
    if not args.file:
        args.refuse("the following arguments are required: FILE")
    return import_requirements.run(args)


def _refuse_unheard(args: argparse.Namespace) -> None:
    """Without a report, there is nothing of which an option of the report could say something, and nothing at all where no recording is written."""
    given = [_OF_LOG[name] for name in _OF_REPORT if getattr(args, name)]
    given += ["--format json"] if args.format == "json" else []
    if given:
        args.refuse(f"`--no-report` makes no report, which {' and '.join(given)} would be of")
    if not args.out:
        args.refuse("`--no-report` only makes the recording: say with --out where it goes")
