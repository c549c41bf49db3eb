"""`replay` of a record: the cycles of a run through the Supervisor again, at the recorded times, and whether it decides the same."""

from __future__ import annotations

import json
import math
import sys
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.output import dump, number, progress, rule_json, say
from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import read_regular
from trackmarshal.runtime.faults import Fault
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.units import moment

if TYPE_CHECKING:
    from trackmarshal.ir.spec import RuleInfo, Spec
    from trackmarshal.runtime.decision import Decision
    from trackmarshal.runtime.record.decided import Difference
    from trackmarshal.runtime.record.reading import Recorded, Run

#: Differences that the text shows.
SHOWN = 10
#: A verdict by its letter in a record.
_VERDICT = dict(zip("svuio", VERDICTS, strict=True))


def is_record(path: str) -> bool:
    """Whether a file begins as a record of a run does."""
    from trackmarshal.runtime.record import reading

    try:
        return reading.is_record(read_regular(Path(path), 4))
    except (OSError, ValueError):
        return False  # said by whoever reads it as a recording


def replay_record(
    path: str, spec: Spec, backend: str | None, format_: str, quiet: bool, mcap: str | None = None, begin: str | None = None
) -> int:  # fmt: skip
    """Print what became of it, from a place on where `begin` says one; 0 when there are decisions, every one is the recorded one and none is
    missing, else 1. Raises D120, D124, D161, D162, E436, E484."""
    from trackmarshal.runtime.record.reading import read
    from trackmarshal.scenarios import content
    from trackmarshal.supervision import box_of, nearest, rerun

    run = read(content.read_record(path), path)
    box = box_of(run, spec, backend)
    other = run.other_spec(box.evaluator.spec)
    if other and not quiet:
        say(f"note: {path}: {other}", file=sys.stderr)
    if run.damage and not quiet and format_ != "text":
        say(f"note: {path}: {run.damage}", file=sys.stderr)
    if run.went_on and not quiet and format_ != "text":
        say(f"note: {path}: {run.went_on}", file=sys.stderr)
    first = 0 if begin is None else _place(begin, run, path)
    snapshot, refused = (None, None) if begin is None else nearest(run, box, first)
    if refused is not None and not quiet:
        say(f"note: {path}: a snapshot is not used: {refused.code} {refused.message}", file=sys.stderr)
    start = 0 if snapshot is None else snapshot.after
    decisions: list[Decision] = []
    found: list[Difference] = []
    steps = rerun(run, box, snapshot)
    for place in progress(range(start, len(run.cycles)), path, quiet):
        decision, differing = next(steps)
        if place >= first:
            decisions.append(decision)
            found += differing
    if mcap is not None:
        from trackmarshal.scenarios import foxglove

        foxglove.write(run, decisions, mcap)
    if format_ == "jsonl":
        places = {difference.place for difference in found}
        for place, decision in enumerate(decisions, first):
            for line in _lines(path, decision, box.evaluator.rules, place not in places):
                print(line)
    else:
        began = None if begin is None else start
        rules = [rule.name for rule in box.evaluator.rules]
        say(*_summary(path, run, decisions, found, first, began, rules))
    return 1 if found or run.missed or run.damage or not decisions else 0


def _place(begin: str, run: Run, path: str) -> int:
    """The place in a record that `--from` says: `120`, or `12.5s`; raises E436."""
    text, seconds = begin.strip(), begin.strip().endswith("s")
    try:
        wanted = float(text[:-1]) if seconds else int(text)
    except ValueError as error:
        help_ = "a cycle by its number in the record (120), or a time with its unit (12.5s)"
        raise TrackmarshalError("E436", f"`--from {begin}` is no place", file=path, help=help_) from error
    if not seconds and 0 <= wanted < len(run.cycles):
        return int(wanted)
    if seconds:
        for place, one in enumerate(run.cycles):
            if _time(one) >= wanted:
                return place
    times = [t for t in map(_time, run.cycles) if math.isfinite(t)]
    said = f", from {moment(min(times))} s to {moment(max(times))} s" if times else ""
    raise TrackmarshalError(
        "E436", f"the record has no cycle at `{begin}`", file=path, help=f"it has {len(run.cycles)} cycles, numbered from 0{said}"
    )  # fmt: skip


def _time(one: Recorded) -> float:
    """The stamp of a cycle where it is a number, else when it arrived; NaN where neither is known."""
    t: Any = getattr(one.cycle, "t", None)
    stamp = float(t) if type(t) in (int, float) else math.nan
    return stamp if math.isfinite(stamp) else one.readings[0]


def _summary(
    path: str,
    run: Run,
    decisions: Sequence[Decision],
    found: Sequence[Difference],
    first: int,
    began: int | None,
    rules: Sequence[str],
) -> list[str]:
    """first: the place of the first decision; began: that of the first cycle that was run again, where one was asked for; rules: those that were judged."""
    counts = Counter(decision.action for decision in decisions)
    ending = "" if run.ended else f"; not closed, {run.rest} bytes behind the last whole cycle"
    lines = [
        f"{path}: {len(decisions)} cycles{'' if began is None else f' from cycle {first} on'}"
        + "".join(f", {count} {action}" for action, count in counts.items())
        + ending
    ]
    if began is not None:
        lines.append(
            f"started at the snapshot after {began} cycles"
            if began
            else "started at the beginning: there is no snapshot before that can be used"
        )
    if run.went_on:
        lines.append(run.went_on)
    if run.damage:
        lines.append(run.damage)
    if run.missed:
        lines.append(
            f"{run.missed} cycles are missing, which could not be written, or whose steps were stopped; what was decided in them is not known"
        )
    if not decisions:
        return [*lines, "no decision is in it: none is shown to be the same"]
    if not found and not run.missed and not run.damage:
        return [*lines, "same decisions, bit for bit"]
    if not found:
        return [
            *lines,
            "what is left of it was decided the same, bit for bit: not all of the run is shown to be",
        ]
    places = {difference.place for difference in found}
    lines.append(f"{len(places)} cycles were decided otherwise:")
    shown = [
        f"  cycle {difference.place} at {moment(difference.t)} s, {said}"
        for difference in found[: SHOWN + 1]
        for said in told(difference, rules)
    ]
    return [*lines, *shown[:SHOWN], *(["  ..."] if len(shown) > SHOWN else [])]


def told(difference: Difference, rules: Sequence[str]) -> list[str]:
    """What was recorded and what is, of verdicts and margins by rule: nobody counts letters. Margins that differ in nothing but how NaN is written, what
    was never written so, and columns that are not of these rules, are told as they stand."""
    column, _, candidate = difference.column.partition(".")
    old, new, said = difference.recorded, difference.now, list[str]()
    if column in ("verdicts", "margins") and len(old) == len(new) == len(rules):
        about = "" if column == "verdicts" else "margin of "
        was, now = (
            [_VERDICT.get(x, x) if column == "verdicts" else repr(float(x)) for x in each]
            for each in (old, new)
        )
        said = [
            f"{about}{name} of {candidate}: recorded {a}, now {b}"
            for name, a, b in zip(rules, was, now)
            if a != b
        ]
    elif column == "violations":
        with suppress(ValueError, KeyError, TypeError):  # a record that somebody has changed
            named, names = (
                ", ".join(dict.fromkeys(one["rule"] for one in json.loads(each))) or "nothing"
                for each in (old, new)
            )
            said = [f"violations: recorded {named}, now {names}"] if named != names else []
    return said or [f"{difference.column}: recorded {old!r:.60}, now {new!r:.60}"]


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
