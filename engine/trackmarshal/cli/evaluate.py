"""Evaluate rules of a spec on given data: one case a line of JSON in, one result a line out, in order.

  trackmarshal eval specs/supervisor --data cases.jsonl --rule friction --format jsonl
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.output import dump, number, rule_json, table
from trackmarshal.cli.project import optional_project
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.runtime.case import Case
    from trackmarshal.runtime.verdict import CaseResult

#: The longest line of data that is read, in characters.
MAX_LINE = 400_000_000

CODES = {
    "D101": ("a line that is not JSON", "Data is JSON Lines: one JSON object a line, UTF-8."),
    "D102": ("the data cannot be read", "The file of `--data` does not exist or cannot be read; `-` reads standard input."),
}


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("spec", metavar="SPEC", help="a .spec file, or a folder of them")
    parser.add_argument("--data", required=True, metavar="FILE", help="JSON Lines, one case a line; - for standard input")
    parser.add_argument("--rule", action="append", metavar="R", help="a rule to evaluate (repeatable; default: all)")
    parser.add_argument("--with", dest="settings", action="append", default=[], metavar="FILE", help="a configuration module (a vehicle, a track)")
    parser.add_argument("--backend", choices=("numpy", "reference"), default="numpy")
    parser.add_argument("--series", action="store_true", help="for rules along a timeline: the value at every sample")
    parser.add_argument("--format", choices=("text", "jsonl"), default="text")


def run(args: argparse.Namespace) -> int:
    from trackmarshal.evaluation import CHUNK, Evaluator, load

    spec = load([Path(args.spec)], [Path(p) for p in args.settings], optional_project(args))
    evaluator = Evaluator(spec, args.rule, args.backend)
    status = 0
    pending: list[tuple[object, Case | TrackmarshalError]] = []
    for item in _cases(args.data, evaluator):
        pending.append(item)
        if len(pending) == CHUNK:
            status = max(status, _flush(pending, evaluator, args))
            pending = []
    return max(status, _flush(pending, evaluator, args))


def _cases(path: str, evaluator: Evaluator) -> Iterator[tuple[object, Case | TrackmarshalError]]:
    """Every line's id and case, or what is wrong with the line."""
    for line_number, line in enumerate(_lines(path), start=1):
        if not line.strip():
            continue
        identity: object = None
        try:
            raw = _parse(line, line_number)
            identity = raw.get("id") if isinstance(raw, dict) else None
            yield identity, evaluator.read(raw)
        except TrackmarshalError as error:
            error.line = error.line or line_number
            yield identity if identity is not None else line_number, error


def _parse(line: bytes, number_: int) -> Any:
    try:
        return json.loads(line.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise TrackmarshalError("D101", f"line {number_} is not UTF-8", line=number_) from error
    except RecursionError as error:
        raise TrackmarshalError("D101", f"line {number_} is nested too deeply", line=number_) from error
    except ValueError as error:
        raise TrackmarshalError("D101", f"line {number_}: {error}", line=number_) from error


def _lines(path: str) -> Iterator[bytes]:
    try:
        stream = sys.stdin.buffer if path == "-" else Path(path).open("rb")  # noqa: SIM115 - standard input stays open
    except OSError as error:
        raise TrackmarshalError("D102", error.strerror or str(error), file=path) from error
    with stream:
        while line := stream.readline(MAX_LINE):
            yield line


def _flush(pending: list[tuple[object, Case | TrackmarshalError]], evaluator: Evaluator, args: argparse.Namespace) -> int:
    """Evaluate and print a chunk; 2 when a line could not be read, else 0."""
    cases = [case for _, case in pending if not isinstance(case, TrackmarshalError)]
    results = iter(evaluator.evaluate(cases, args.series))
    status = 0
    for identity, case in pending:
        if isinstance(case, TrackmarshalError):
            status = 2
            print(_error_line(identity, case, args.format))
        else:
            broken = evaluator.broken_constraints(case) if case.params else []
            show = _json_line if args.format == "jsonl" else _text
            print(show(next(results), broken))
    return status


def _error_line(identity: object, error: TrackmarshalError, format_: str) -> str:
    if format_ == "jsonl":
        return dump({"id": identity, "error": {"code": error.code, "message": error.message}})
    return f"case {identity}: error[{error.code}]: {error.message}"


def _json_line(result: CaseResult, broken: list[str]) -> str:
    line: dict[str, Any] = {"id": result.id, "safe": result.safe, "rules": {n: rule_json(r) for n, r in result.rules.items()}}
    if result.faults:
        line["faults"] = list(result.faults)
    if broken:
        line["constraints"] = broken
    return dump(line)


def _text(result: CaseResult, broken: list[str]) -> str:
    rows = []
    for name, rule in result.rules.items():
        where = ", ".join(f"{k}={v}" for k, v in rule.witness.binders.items()) if rule.witness else rule.reason
        span = str(rule.witness.span) if rule.witness and rule.witness.span else ""
        shown = number(rule.margin)
        rows.append([name, rule.verdict, f"{shown:.6g}" if isinstance(shown, float) else shown, rule.unit, where, span])
    lines = [f"case {result.id}: {'safe' if result.safe else 'UNSAFE'}", table(rows, ["rule", "verdict", "margin", "unit", "at", "decided by"])]
    lines += [f"input: {fault}" for fault in result.faults] + [f"constraint: {text}" for text in broken]
    return "\n".join(lines)
