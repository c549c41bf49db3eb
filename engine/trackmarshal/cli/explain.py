"""What an error code means, or why a rule said what it said in one cycle of a recording, with the numbers.

trackmarshal explain E301
trackmarshal explain run.tmrec.jsonl --rule friction --at 2.6
"""

from __future__ import annotations

import argparse
import math
import re
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.options import configure_with
from trackmarshal.cli.output import say
from trackmarshal.cli.project import find_project, optional_project
from trackmarshal.errors import TrackmarshalError
from trackmarshal.units import beside

if TYPE_CHECKING:
    from trackmarshal.backends.reference.evaluator import Reference
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.ir import nodes as ir
    from trackmarshal.ir.spec import Spec
    from trackmarshal.runtime.verdict import RuleResult

CODES = {
    "E441": ("unknown code", "`explain` takes a code as messages show it: a letter and three digits, such as E301."),
    "E442": ("what to explain is not clear", "To explain a verdict, name the rule and the time: `explain RECORDING --rule R --at T`. T is the time of a cycle."),
}  # fmt: skip


_CODES_HELP = "E0xx to E4xx are about specs, D about data, T about traceability; docs/errors.md lists all"


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("what", metavar="CODE|RECORDING", help="an error code, or a recording")
    parser.add_argument("--rule", metavar="R")
    parser.add_argument("--at", metavar="T", type=float, help="time of the cycle in s")
    parser.add_argument("--candidate", choices=("driving", "emergency"), help="default: both")
    parser.add_argument("--spec", metavar="SPEC", help="spec file or folder (default: the project's)")
    configure_with(parser)


def run(args: argparse.Namespace) -> int:
    if re.fullmatch(r"[A-Za-z]\d{3}", args.what) and not Path(args.what).exists():
        return _code(args.what.upper())
    if args.rule is None or args.at is None:
        raise TrackmarshalError(
            "E442", f"`{args.what}` is no code", help="for a recording, add --rule R --at T"
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
    from trackmarshal.backends.reference.evaluator import Reference
    from trackmarshal.backends.results import outcome, rule_result
    from trackmarshal.cli.replay import default_spec, evaluator_for, overruled
    from trackmarshal.scenarios import load
    from trackmarshal.scenarios.replay import known_tables
    from trackmarshal.scenarios.supervised import frame_at

    spec_path = Path(args.spec) if args.spec else default_spec(find_project(args))
    settings = [Path(p) for p in args.settings]
    recording = overruled(load(args.what), spec_path, settings)
    evaluator = evaluator_for(
        recording,
        spec_path,
        settings,
        optional_project(args),
        [args.rule],
        "reference",
    )
    place, cycle = min(enumerate(recording.cycles), key=lambda entry: abs(entry[1].t - args.at))
    if not abs(cycle.t - args.at) <= 1e-6:  # NaN too
        raise TrackmarshalError(
            "E442", f"no cycle at t = {args.at:g} s", help=f"the nearest is at {cycle.t:g} s"
        )
    tables, _ = known_tables(recording, evaluator.spec)
    frame = frame_at(recording, evaluator, tables, place)
    for candidate in [args.candidate] if args.candidate else list(cycle.candidates):
        recording.signals(cycle, candidate)  # refuses a candidate that is not there
        case = frame.of(candidate)
        values = Reference(evaluator.spec, case)
        rule = evaluator.rules[0]
        result = rule_result(rule, case, values, outcome(rule, case, values)[:2])
        say(*_told(evaluator, result, values, f"{recording.name}, t = {cycle.t:g} s, {candidate}"))
    return 0


def _told(evaluator: Evaluator, result: RuleResult, values: Reference, heading: str) -> list[str]:
    """The verdict, the rule's text, the deciding comparison and every number in it."""
    from trackmarshal.backends.witness import Descent

    rule = evaluator.rules[0]
    lines = [
        heading,
        f"{rule.name}: {rule.title}",
        f"  {result.verdict}, margin {beside(result.margin, result.unit, result.shown, 9)}",
    ]
    lines.append(
        f"  satisfies {', '.join(name for name, _ in rule.satisfies) or 'nothing'}; declared at {rule.span}"
    )
    if result.reason:
        lines.append(f"  {result.reason}")
    descent = Descent(values)
    witness = (
        None if rule.formula is None or values.frame.unusable(rule.reads) else descent.find(rule.formula)
    )
    if witness is None or descent.decisive is None:
        return lines
    node, env = descent.decisive
    if witness.binders:
        lines.append(
            "  decided at " + ", ".join(f"{name} = {index}" for name, index in witness.binders.items())
        )
    if witness.span is not None:
        lines.append(f"  by {witness.span}: {' '.join(witness.span.text.split())}")
    lines += [f"    {text} = {shown}" for text, shown in _numbers(node, env, values)]
    return lines


def _numbers(node: ir.Formula, env: dict[int, int], values: Reference) -> list[tuple[str, str]]:
    """Both sides of a comparison, and each input, parameter and table value in them."""
    from trackmarshal.ir import nodes as ir

    rows: list[tuple[str, str]] = []
    if isinstance(node, ir.Compare) and node.op != "is":
        _, left, right = node.written
        for name, side in (("left side", left), ("right side", right)):
            rows.append((name, beside(values.number(side, env), node.unit, node.shown, 9)))
    if isinstance(node, ir.SweptInside | ir.SweptClear):
        rows.append(("swept", _way(node, env, values)))
    leaves: dict[str, float] = {}
    members: dict[str, str] = {}
    for part in ir.below(node):
        if isinstance(part, ir.Column | ir.Scalar | ir.Sample):
            signal, name = _input(part, env)
            leaves[name] = values.number(part, env)
            members[name] = _member(values.spec, signal, part.field, leaves[name])
        elif isinstance(part, ir.Param):
            leaves[part.name] = values.number(part, env)
        elif isinstance(part, ir.Lookup):
            leaves[f"{part.table}({_figure(values.number(part.argument, env))})"] = values.number(part, env)
        elif isinstance(part, ir.Along):
            ends = (part.start, part.end) if isinstance(part, ir.StationGap) else (part.x, part.y)
            inside = ", ".join(_figure(values.number(end, env)) for end in ends)
            leaves[f"{part.spoken} along {part.line.name} of ({inside})"] = values.number(part, env)
    return rows + [(name, members.get(name) or _figure(value)) for name, value in sorted(leaves.items())]


def _input(part: ir.Column | ir.Scalar | ir.Sample, env: dict[int, int]) -> tuple[str, str]:
    """The signal of an input, and what the input is called."""
    from trackmarshal.ir import nodes as ir

    if isinstance(part, ir.Column):
        signal = part.axis.signal
        return signal, f"{signal}[{max(0, env[part.axis.level] + part.offset)}].{part.field}"
    if isinstance(part, ir.Sample):
        return part.signal, f"{part.signal}.{'first' if part.index == 0 else 'last'}.{part.field}"
    return part.signal, f"{part.signal}.{part.field}"


def _member(spec: Spec, signal: str, field: str, value: float) -> str:
    """The name of the member that a number is the place of; empty for any other number."""
    info = spec.signals[signal].field(field)
    members = () if info is None or info.enumeration is None else info.enumeration.members
    return next((name for place, name in enumerate(members) if place == value), "")


def _way(node: ir.SweptInside | ir.SweptClear, env: dict[int, int], values: Reference) -> str:
    """What is taken for swept: straight, or along a curve, and what is added to that."""
    if not node.bend:
        return "the footprint" if node.start == node.end else "the straight hull of two footprints"
    curve = values.curve(node, env)
    if curve is None:
        return "along a curve of which a number is missing"
    pieces = len(curve.poses) - 1
    return f"along a curve, in {pieces} piece{'s' * (pieces > 1)}, and {_figure(curve.more)} m around {'them' if pieces > 1 else 'it'}"


def _figure(value: float) -> str:
    return f"{value:.9g}" if math.isfinite(value) else str(value)
