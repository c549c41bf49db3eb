"""`replay` of a record: the cycles of a run through the Supervisor again, at the recorded times, and whether it decides the same."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.output import dump, number, progress, rule_json, say
from trackmarshal.files import read_regular
from trackmarshal.runtime.faults import Fault

if TYPE_CHECKING:
    from trackmarshal.ir.spec import RuleInfo, Spec
    from trackmarshal.runtime.decision import Decision
    from trackmarshal.runtime.record import Difference, Run

#: Differences that the text shows.
SHOWN = 10


def is_record(path: str) -> bool:
    """Whether a file begins as a record of a run does."""
    from trackmarshal.runtime import record

    try:
        return record.is_record(read_regular(Path(path), 4))
    except (OSError, ValueError):
        return False  # said by whoever reads it as a recording


def replay_record(
    path: str, spec: Spec, backend: str | None, format_: str, quiet: bool, mcap: str | None = None
) -> int:
    """Print what became of it; 0 when every decision is the recorded one and none is missing, else 1. Raises D120, D124, D161, D162, E484."""
    from trackmarshal.runtime.record import read
    from trackmarshal.scenarios import content
    from trackmarshal.supervision import box_of, rerun

    run = read(content.read(Path(path), path), path)
    box = box_of(run, spec, backend)
    recorded = run.identity.get("fingerprint")
    if recorded != box.identity["fingerprint"] and not quiet:
        say(
            f"note: {path}: another spec was in force than the one given here; its decisions may differ",
            file=sys.stderr,
        )
    decisions: list[Decision] = []
    found: list[Difference] = []
    steps = rerun(run, box)
    for _ in progress(range(len(run.cycles)), path, quiet):
        decision, differing = next(steps)
        decisions.append(decision)
        found += differing
    if mcap is not None:
        from trackmarshal.scenarios import foxglove

        foxglove.write(run, decisions, mcap)
    if format_ == "jsonl":
        places = {difference.place for difference in found}
        for place, decision in enumerate(decisions):
            for line in _lines(path, decision, box.evaluator.rules, place not in places):
                print(line)
    else:
        say(*_summary(path, run, decisions, found))
    return 1 if found or run.missed else 0


def _summary(path: str, run: Run, decisions: Sequence[Decision], found: Sequence[Difference]) -> list[str]:
    counts = Counter(decision.action for decision in decisions)
    ending = "" if run.ended else f"; not closed, {run.rest} bytes behind the last whole cycle"
    lines = [
        f"{path}: {len(decisions)} cycles, "
        + ", ".join(f"{count} {action}" for action, count in counts.items())
        + ending
    ]
    if run.missed:
        lines.append(f"{run.missed} cycles could not be written; what was decided in them is not known")
    if not found:
        return [*lines, "same decisions, bit for bit"]
    places = {difference.place for difference in found}
    lines.append(f"{len(places)} cycles were decided otherwise:")
    for difference in found[:SHOWN]:
        lines.append(
            f"  cycle {difference.place} at {difference.t:g} s, {difference.column}: recorded {difference.recorded!r:.60}, "
            f"now {difference.now!r:.60}"
        )
    return [*lines, *(["  ..."] if len(found) > SHOWN else [])]


def _lines(path: str, decision: Decision, rules: Sequence[RuleInfo], same: bool) -> list[str]:
    """One line a candidate, as for other recordings, and whether the decision is the recorded one."""
    from trackmarshal.runtime.cycle import DRIVING, EMERGENCY

    lines = []
    for candidate in (DRIVING, EMERGENCY):
        rated = None if decision.judged is None else decision.judged.rated[candidate]
        entry: dict[str, Any] = {
            "scenario": path,
            "t": number(decision.t),
            "candidate": candidate,
            "safe": rated is not None and not decision.faults and rated.safe,
            "rules": {}
            if rated is None
            else {rule.name: rule_json(rated.explain(i, False)) for i, rule in enumerate(rules)},
            "decision": decision.action,
            "decision_from": None if decision.driven is None else decision.driven.t,
            "same": same,
        }  # fmt: skip
        if decision.faults:
            entry["cycle_faults"] = faults_json(decision.faults)
        lines.append(dump(entry))
    return lines


def faults_json(faults: Sequence[Fault]) -> list[str]:
    """Faults of a cycle as lines of `replay` carry them."""
    from trackmarshal.runtime.faults import name_of

    return [f"{name_of(fault)} {fault}" for fault in faults]
