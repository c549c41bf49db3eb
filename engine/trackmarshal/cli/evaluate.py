"""Evaluate rules of a spec on given data: one case a line of JSON in, one result a line out, in order.

The exit status is 1 when a case is not safe, 2 when a line could not be read.

trackmarshal eval specs/supervisor --data cases.jsonl --rule friction --format jsonl

With --run, lines are the cycles of one run, each with its stamp: {"t": 0.1, "signals": {...}}. Rules over the run then remember.
Where windows are open after the last cycle, a last line more says what became of them: {"end": {RULE: [...]}}; no cycle's `safe` has it.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from trackmarshal.cli.options import choose_backend, choose_rules
from trackmarshal.cli.output import about_json, dump, rule_json, say, table
from trackmarshal.cli.project import optional_project, project_of
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import open_regular
from trackmarshal.json_text import named_twice
from trackmarshal.runtime.verdict import UNSAFE, About, decides
from trackmarshal.units import written

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.ir.spec import RuleInfo, Spec
    from trackmarshal.runs import Frames
    from trackmarshal.runtime.frame import Frame
    from trackmarshal.runtime.verdict import CaseResult

#: The number of a line, the id that it has, and its case, or what is wrong with it.
Numbered: TypeAlias = "tuple[int, object, Frame | TrackmarshalError]"

#: The longest line of data that is read, in characters.
MAX_LINE = 400_000_000
_HELP = 'a case is one line, such as {"id": 1, "signals": {"plan": {"t": [0, 0.1], ...}}}'

CODES = {
    "D101": ("a line that is not JSON", "Data is JSON Lines: one JSON object a line, UTF-8."),
    "D206": (
        "a cycle without its time",
        "Rules over the run go by the stamps of its cycles: every line of a run has a `t`, in s, later than the one before.",
    ),
    "E407": (
        "a rule over the run, and cases by themselves",
        "The rule speaks of other cycles than the present one. Cases that are none of a run say nothing about those; what would be evaluated is the first "
        "cycle of a run, again and again.",
    ),
    "D103": (
        "no cases",
        "The data holds no case at all. Nothing was evaluated, so nothing is known to be safe.",
    ),
    "D102": (
        "the data cannot be read",
        "The file of `--data` does not exist or cannot be read; `-` reads standard input.",
    ),
}


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("spec", metavar="SPEC", help="a .spec file, or a folder of them")
    parser.add_argument(
        "--data", required=True, metavar="FILE", help="JSON Lines, one case a line; - for standard input"
    )
    choose_rules(parser, "evaluate")
    choose_backend(parser, "numpy", "default: numpy")
    parser.add_argument(
        "--series", action="store_true", help="for rules along a timeline: the value at every sample"
    )
    parser.add_argument(
        "--run", action="store_true", help="lines are the cycles of one run, each with its stamp `t`"
    )
    parser.add_argument("--format", choices=("text", "jsonl"), default="text")


def run(args: argparse.Namespace) -> int:
    from trackmarshal.evaluation import CHUNK, Evaluator, load

    project = optional_project(args)
    spec = load([Path(args.spec)], [Path(p) for p in args.settings], project)
    within = project if args.project is not None else project_of(Path(args.spec).parent) or project
    evaluator = Evaluator(spec, args.rule, args.backend, lambda: declared_within(spec, within))
    if args.run:
        return _run(evaluator, args)
    refuse_over_run(
        evaluator.rules, "give the cycles of one run with --run, or choose other rules with --rule"
    )
    status = 0
    pending: list[Numbered] = []
    read = 0
    for read, item in enumerate(_numbered(args.data, evaluator), start=1):  # noqa: B007 - counted
        pending.append(item)
        if len(pending) == CHUNK:
            status = max(status, _flush(pending, evaluator, args))
            pending = []
    if read == 0:
        raise TrackmarshalError("D103", "there is no case in the data", file=args.data, help=_HELP)
    return max(status, _flush(pending, evaluator, args))


def refuse_over_run(rules: Iterable[RuleInfo], help_: str) -> None:
    """Raise E407 where a rule speaks of other cycles than the one that a case is."""
    from trackmarshal.ir.spec import remembers

    over = next((rule for rule in rules if remembers(rule)), None)
    if over is not None:
        raise TrackmarshalError(
            "E407", f"`{over.name}` is a rule over the run", file=over.span.file.path, line=over.span.line, help=help_
        )  # fmt: skip


def _run(evaluator: Evaluator, args: argparse.Namespace) -> int:
    """Evaluate and print the cycles of one run, then what was open after the last one."""
    from trackmarshal.evaluation import CHUNK
    from trackmarshal.runs import Frames

    status, read = 0, 0
    pending: list[Numbered] = []
    going = _Cycles(evaluator) if _in_step(evaluator, args.data) else Frames(evaluator)
    many = 1 if isinstance(going, _Cycles) else CHUNK
    for read, item in enumerate(_numbered(args.data, evaluator), start=1):  # noqa: B007 - counted
        pending.append(item)
        if len(pending) == many:
            status = max(status, _flush_run(pending, going, args))
            pending = []
    status = max(status, _flush_run(pending, going, args))
    if read == 0:
        raise TrackmarshalError("D103", "there is no cycle in the data", file=args.data, help=_HELP)
    left = going.end()
    if left:
        say(*_end_lines(left, args.format))
    if any(about.verdict in UNSAFE for each in left.values() for about in each):
        status = max(status, 1)
    return status


def _in_step(evaluator: Evaluator, data: str) -> bool:
    """Whether cycles are evaluated one by one: numpy takes many at once, but not while somebody waits for what is said of each."""
    return data == "-" or evaluator.backend != "numpy" or evaluator.sweeps


class _Cycles:
    """A run cycle by cycle, as `Frames` has it many at a time."""

    def __init__(self, evaluator: Evaluator) -> None:
        self._going = evaluator.over_run()

    def step(
        self, cycles: Sequence[Frame | TrackmarshalError], series: bool = False
    ) -> list[CaseResult | TrackmarshalError]:
        return [self._one(cycle, series) for cycle in cycles]

    def end(self) -> Mapping[str, Sequence[About]]:
        return self._going.end()

    def _one(self, cycle: Frame | TrackmarshalError, series: bool) -> CaseResult | TrackmarshalError:
        try:
            if isinstance(cycle, TrackmarshalError):
                raise cycle
            return self._going.step(cycle, series)
        except TrackmarshalError as error:
            self._going.missed()
            return error


def _flush_run(pending: list[Numbered], going: _Cycles | Frames, args: argparse.Namespace) -> int:
    """Evaluate and print some cycles; 2 when one could not be read, 1 when one is not safe, else 0."""
    status = 0
    for (line, identity, _), result in zip(pending, going.step([case for *_, case in pending], args.series)):
        called = line if identity is None else identity
        if isinstance(result, TrackmarshalError):
            result.file, result.line = result.file or args.data, result.line or line
            status = 2
            say(*_error_lines(called, result, args.format))
        else:
            say(*([_json_line(result)] if args.format == "jsonl" else _text(result, called)))
            status = max(status, 0 if result.safe else 1)
    return status


def _end_lines(left: Mapping[str, Sequence[About]], format_: str) -> list[str]:
    """What is said of the cycles that were open after the last one."""
    if format_ == "jsonl":
        return [dump({"end": {name: [about_json(one) for one in each] for name, each in left.items()}})]
    rows = [
        [name, str(one.cycle), one.verdict, f"{one.margin:.6g}"]
        for name, each in left.items()
        for one in each
    ]
    return ["after the last cycle", *table(rows, ["rule", "cycle", "verdict", "margin"])]


def declared_within(spec: Spec, project: Path | None) -> frozenset[str]:
    """Names that data of a project may have, whichever of its specs declares them."""
    from trackmarshal.cli.replay import project_specs
    from trackmarshal.scenarios.fields import declared_names

    return declared_names([spec, *project_specs(project)])


def read_cases(path: str, evaluator: Evaluator) -> Iterator[tuple[object, Frame | TrackmarshalError]]:
    """Every line's id, or its number where it has none, and its case, or what is wrong with it."""
    for line_number, identity, case in _numbered(path, evaluator):
        yield line_number if identity is None else identity, case


def _numbered(path: str, evaluator: Evaluator) -> Iterator[Numbered]:
    """The same, with the number of the line, and no id where the line has none: its case is called by that number."""
    for line_number, line in enumerate(_lines(path), start=1):
        if not line.strip():
            continue
        identity: object = None
        try:
            raw = _parse(line)
            identity = _identity(raw)
            if identity is None and isinstance(raw, dict):
                raw["id"] = line_number  # what later cycles say of this one calls it so, too
            yield line_number, identity, evaluator.read(raw)
        except TrackmarshalError as error:
            error.file, error.line = path, line_number
            yield line_number, identity, error


def _identity(raw: object) -> object:
    """What a case is called; raises D201 for a name that could not be written back."""
    identity = raw.get("id") if isinstance(raw, dict) else None
    if isinstance(identity, (dict, list)) or (isinstance(identity, float) and not math.isfinite(identity)):
        raise TrackmarshalError(
            "D201", "`id` is a string or a finite number", help="leave it out to have the number of the line"
        )
    return identity


def _parse(line: bytes) -> Any:
    try:
        return json.loads(line.decode("utf-8-sig").rstrip("\r\n"), object_pairs_hook=_object)
    except UnicodeDecodeError as error:
        message = f"byte {line[error.start]:#04x} in column {error.start + 1} is not UTF-8"
        raise TrackmarshalError("D101", message, help="save the data as UTF-8") from error
    except RecursionError as error:
        raise TrackmarshalError(
            "D101", "nested too deeply", help="a case is an object of lists of numbers"
        ) from error
    except json.JSONDecodeError as error:
        raise TrackmarshalError(
            "D101", f"not JSON: {error.msg}, in column {error.pos + 1}", help=_HELP
        ) from error
    except ValueError as error:  # Python refuses whole numbers of thousands of digits
        raise TrackmarshalError("D101", "a number has too many digits", help="write it as 1.5e9") from error


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object; a key that stands twice is refused, since readers disagree on which one counts."""
    result = dict(pairs)
    if len(result) != len(pairs):
        message = f"the key `{named_twice(name for name, _ in pairs)}` stands twice in one object"
        raise TrackmarshalError("D101", message, help="keep one of them")
    return result


def _lines(path: str) -> Iterator[bytes]:
    if path == "-" and sys.stdin is None:
        raise TrackmarshalError(
            "D102", "there is no standard input", file=path, help="name a file with --data"
        )
    try:
        with nullcontext(sys.stdin.buffer) if path == "-" else open_regular(Path(path)) as stream:
            while line := stream.readline(MAX_LINE):
                yield line
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        message = getattr(error, "strerror", None) or str(error)
        raise TrackmarshalError(
            "D102", f"cannot be read: {message}", file=path, help="check the path; - is standard input"
        ) from error


def _flush(
    pending: list[Numbered],
    evaluator: Evaluator,
    args: argparse.Namespace,
) -> int:
    """Evaluate and print a chunk; 2 when a line could not be read, 1 when a case is not safe, else 0."""
    cases = [case for *_, case in pending if not isinstance(case, TrackmarshalError)]
    results = iter(evaluator.evaluate(cases, args.series))
    status = 0
    for line, identity, case in pending:
        called = line if identity is None else identity
        if isinstance(case, TrackmarshalError):
            status = 2
            say(*_error_lines(called, case, args.format))
        else:
            result = next(results)
            say(*([_json_line(result)] if args.format == "jsonl" else _text(result, called)))
            status = max(status, 0 if result.safe else 1)
    return status


def _error_lines(identity: object, error: TrackmarshalError, format_: str) -> list[str]:
    if format_ == "jsonl":
        found = {"code": error.code, "message": error.message, "line": error.line, "help": error.help}
        return [dump({"id": identity, "error": found})]
    lines = [f"case {identity}: error[{error.code}]: {error.message}", f"  --> {error.file}:{error.line}"]
    return [*lines, *([f"  = help: {error.help}"] if error.help else [])]


def _json_line(result: CaseResult) -> str:
    line: dict[str, Any] = {
        "id": result.id,
        "safe": result.safe,
        "rules": {n: rule_json(r) for n, r in result.rules.items()},
    }
    if result.faults:
        line["faults"] = list(result.faults)
    if result.broken:
        line["constraints"] = list(result.broken)
    return dump(line)


def _text(result: CaseResult, identity: object) -> list[str]:
    rows = []
    for name, rule in result.rules.items():
        where = (
            ", ".join(f"{k}={v}" for k, v in rule.witness.binders.items()) if rule.witness else rule.reason
        )
        span = str(rule.witness.span) if rule.witness and rule.witness.span else ""
        margin = written(rule.margin, rule.unit, rule.shown, 6) + decides(rule)
        si = written(rule.margin, rule.unit, "", 6)
        called = f"{name} (advisory)" if rule.advisory else name
        rows.append([called, rule.verdict, margin, "" if margin.startswith(si) else si, where, span])
    lines = [
        f"case {identity}: {'safe' if result.safe else 'UNSAFE'}",
        *table(rows, ["rule", "verdict", "margin", "in SI", "at", "decided by"]),
    ]
    lines += [f"input: {fault}" for fault in result.faults]
    return lines + [f"constraint: {' '.join(text.split())}" for text in result.broken]
