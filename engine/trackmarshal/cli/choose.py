"""Compare candidates of one cycle by a rulebook, and choose one that no other one beats.

trackmarshal choose specs/rulebooks/supervisor.spec candidates.jsonl --rulebook supervisor

Each line of the file is a candidate, a case as `eval` takes it; its `id` is its name, else the number of its line. The exit
status is 0 when the chosen one is safe, 1 when it is not: the best that there is may still violate something. Where a line cannot be read, it is 2, and nothing is chosen.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.evaluate import declared_within, read_cases, refuse_over_run
from trackmarshal.cli.options import choose_backend, choose_rules
from trackmarshal.cli.output import dump, rule_json, say
from trackmarshal.cli.preferring import choice_json, reasons, violations_json, violations_table, why
from trackmarshal.cli.project import optional_project, project_of
from trackmarshal.errors import TrackmarshalError
from trackmarshal.json_text import named_twice

if TYPE_CHECKING:
    from trackmarshal.ir.spec import Spec
    from trackmarshal.rulebooks.choosing import Choice
    from trackmarshal.runtime.verdict import CaseResult


def configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("spec", metavar="SPEC", help="a .spec file, or a folder of them")
    parser.add_argument(
        "cases", metavar="CASES", help="JSON Lines, one candidate a line; - for standard input"
    )
    parser.add_argument("--rulebook", metavar="NAME", help="the rulebook (default: the only one of the spec)")
    choose_rules(parser, "evaluate")
    choose_backend(parser, "numpy", "default: numpy")
    parser.add_argument("--format", choices=("text", "json"), default="text")
    parser.add_argument(
        "--json", action="store_const", const="json", dest="format", help="the same as --format json"
    )


def run(args: argparse.Namespace) -> int:
    from trackmarshal.evaluation import Evaluator, load
    from trackmarshal.rulebooks.candidates import choose
    from trackmarshal.rulebooks.order import rulebook

    project = optional_project(args)
    spec = load([Path(args.spec)], [Path(path) for path in args.settings], project)
    order = rulebook(spec, named(args.rulebook, spec))
    within = project if args.project is not None else project_of(Path(args.spec).parent) or project
    evaluator = Evaluator(spec, args.rule, args.backend, lambda: declared_within(spec, within))
    alone = "candidates are cases by themselves"
    ranked = [rule for rule in spec.rules if rule.name in order.rules]
    refuse_over_run(  # to leave out what the rulebook ranks is refused too
        ranked,
        f"the rulebook ranks it, and {alone}: of a recording, `trackmarshal replay ... --rulebook {order.name}` compares both candidates of each cycle",
    )
    refuse_over_run(evaluator.rules, f"{alone}: choose other rules with --rule")
    names, frames = [], []
    for identity, case in read_cases(args.cases, evaluator):
        if isinstance(case, TrackmarshalError):
            raise case
        names.append(str(identity))
        frames.append(case)
    _check_names(names, args.cases)
    results = list(evaluator.evaluate(frames))
    choice = choose(order, results)
    if args.format == "json":
        print(dump(_json(choice, names, results)))
    else:
        say(*_text(choice, names, results))
    return 0 if results[choice.chosen].safe else 1


def named(name: str | None, spec: Spec) -> str:
    """The rulebook that is asked for, else the only one. Raises E408 where it is not clear which one is meant."""
    if name is not None:
        return name
    names = [book.name for book in spec.rulebooks]
    if len(names) != 1:
        message = "the spec has no rulebook" if not names else "the spec has more than one rulebook"
        raise TrackmarshalError("E408", message, help=f"--rulebook {names[0]}" if names else None)
    return names[0]


def _check_names(names: Sequence[str], file: str) -> None:
    if not names:
        help_ = 'a candidate is one line, such as {"id": "left", "signals": {"plan": {"t": [0, 0.1], ...}}}'
        raise TrackmarshalError("E409", "there is no candidate", file=file, help=help_)
    twice = named_twice(names)
    if twice is not None:
        raise TrackmarshalError(
            "E409", f"two candidates are called `{twice}`", file=file, help="give each an `id` of its own"
        )


def _text(choice: Choice, names: Sequence[str], results: Sequence[CaseResult]) -> list[str]:
    from trackmarshal.rulebooks.candidates import unreliable

    lines = violations_table(choice, names, [result.rules for result in results])
    for name, result in zip(names, results):
        lines += [f"{name}: input: {fault}" for fault in result.faults]
        lines += [f"{name}: constraint: {' '.join(text.split())}" for text in result.broken]
        if unreliable(result):
            lines.append(f"{name}: all rules count as undefined, since what they say cannot be relied on")
    lines += reasons(choice, names)
    safe = "safe" if results[choice.chosen].safe else "UNSAFE"
    return [*lines, f"chosen: {names[choice.chosen]} ({safe}), {why(choice)}"]


def _json(choice: Choice, names: Sequence[str], results: Sequence[CaseResult]) -> dict[str, Any]:
    candidates = []
    for name, violations, result in zip(names, choice.violations, results):
        entry: dict[str, Any] = {
            "id": name, "safe": result.safe, "violations": violations_json(violations),
            "rules": {rule: rule_json(each) for rule, each in result.rules.items()},
        }  # fmt: skip
        if result.faults:
            entry["faults"] = list(result.faults)
        if result.broken:
            entry["constraints"] = list(result.broken)
        candidates.append(entry)
    return {"candidates": candidates, **choice_json(choice, names)}
