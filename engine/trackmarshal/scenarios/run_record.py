"""A replayed run as plain data: what a report draws and says, in strict JSON.

run_record.schema.json describes it. Columns hold one entry a cycle; in strings of verdicts one letter (LETTERS) does.
Margins are exact; what only pictures need is rounded to 1e-6. Numbers that are not finite are "nan", "inf" and "-inf".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

from trackmarshal.evaluation import Evaluator
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.margins import SCALED, formula_atoms, own_unit, undecided
from trackmarshal.ir.spec import RuleInfo, remembers
from trackmarshal.runtime.verdict import RuleResult, Said
from trackmarshal.scenarios.fields import other_spec
from trackmarshal.scenarios.in_force import in_force
from trackmarshal.scenarios.inputs import defaulted
from trackmarshal.scenarios.labels import kind_of
from trackmarshal.scenarios.overrides import overrides
from trackmarshal.scenarios.recording import CANDIDATES, Columns, Cycle, Recording
from trackmarshal.scenarios.replay import Replay, intervals
from trackmarshal.source import Span
from trackmarshal.units import to_si

FORMAT = "trackmarshal-run"
VERSION = 1
#: Verdicts in the strings of a record; ABSENT where a cycle has no such candidate.
LETTERS = {"satisfied": "s", "violated": "v", "undefined": "u", "inactive": "i", "open": "o"}
ABSENT = "-"
#: Verdicts that what a rule demands decides, and not whether it applies.
DECIDED = ("satisfied", "violated")
#: Points that are kept of one trajectory.
PATH_POINTS = 16

Number = float | str
#: The result of a rule in a cycle, by its number, with what decided it.
Whole = Callable[[int], RuleResult]


def run_record(replay: Replay, evaluator: Evaluator, source_hash: str = "") -> dict[str, Any]:
    """The record of one run.

    evaluator is the one that the run was evaluated with; source_hash is the sha256 of the recording's bytes.
    """
    recording = replay.recording
    return {
        "format": FORMAT,
        "version": VERSION,
        "scenario": recording.name,
        "source": recording.source,
        "source_hash": source_hash,
        "spec_fingerprint": evaluator.spec.fingerprint,
        "backend": evaluator.backend,
        "use": list(recording.use),
        "notes": [*recording.notes, *filter(None, [other_spec(recording, evaluator)])],
        "ignored_tables": list(replay.ignored),
        "overrides": [
            {"kind": one.kind, "name": one.name, "value": one.value, "own": one.own, "because": one.because}
            for one in overrides(recording, evaluator.spec)
        ],
        "in_force": list(in_force(recording, evaluator.spec, evaluator.rules)),
        "given": [
            {"name": name, "value": _number(value), "because": recording.because.get(name, "")}
            for name, value in recording.given.items()
        ],
        "defaults": [
            {"name": name, "rules": list(rules)}
            for name, rules in defaulted(recording, evaluator.spec, evaluator.rules).items()
        ],
        "vehicle": {
            "length": _size("length", recording, evaluator),
            "width": _size("width", recording, evaluator),
        },
        "track": {
            "left": _points(recording.track["left"]),
            "right": _points(recording.track["right"]),
            "closed": bool(recording.track.get("closed", False)),
        },
        "obstacles": [_box(obstacle) for obstacle in recording.obstacles],
        "places": list(_places(evaluator)),
        "t": [_number(cycle.t) for cycle in recording.cycles],
        "ego": {
            name: [_rounded(c.ego.get(name, math.nan)) for c in recording.cycles]
            for name in ("x", "y", "heading", "v")
        },
        "objects": _objects(recording.cycles),
        "decision": [cycle.decision for cycle in replay.cycles],
        "decision_from": [
            None if c.decision_from is None else _number(c.decision_from) for c in replay.cycles
        ],
        "candidates": {name: _candidate(name, replay) for name in CANDIDATES},
        "rules": [_rule(number, rule, replay, evaluator) for number, rule in enumerate(evaluator.rules)],
        "assumptions": [_assumption(rule) for rule in evaluator.spec.rules if rule.kind == "assume"],
        "ground_truth": {kind: list(truth) for kind, truth in recording.ground_truth.items()},
        "truths": [
            {
                "kind": truth.kind,
                "inside": truth.inside,
                "judged": truth.judged,
                "rules": list(truth.rules),
                "unsafe": list(truth.unsafe),
                "missed": [_number(t) for t in truth.missed],
                "false_alarms": [_number(t) for t in truth.false_alarms],
            }
            for truth in replay.truths
        ],
        "uncovered": list(replay.uncovered),
    }


def _places(evaluator: Evaluator) -> Iterator[dict[str, Any]]:
    """The zones and lines that the rules speak of."""
    named = {name for rule in evaluator.rules for name in _named(rule.formula)}
    for name in sorted(named):
        place = evaluator.spec.places[name]
        yield {"name": name.rpartition(".")[2], "kind": place.kind, "points": _points(place.points)}


@lru_cache(maxsize=1024)
def _named(formula: ir.Formula | None) -> frozenset[str]:
    """The zones and lines that a formula speaks of."""
    nodes = () if formula is None else ir.below(formula)
    return frozenset(
        node.name for node in nodes if isinstance(node, (ir.Area, ir.Line)) and node.kind in ("zone", "place")
    )


def _candidate(name: str, replay: Replay) -> dict[str, Any]:
    """One candidate: whether it was safe (None: not there), its thinned path, and breaches of the input contract."""
    faults = [
        {"cycle": i, "t": _number(c.t), "faults": list(c.results[name].faults)}
        for i, c in enumerate(replay.cycles)
        if name in c.results and c.results[name].faults
    ]
    return {
        "safe": [c.results[name].safe if name in c.results else None for c in replay.cycles],
        "paths": [
            _path(c.candidates[name]) if name in c.candidates else None for c in replay.recording.cycles
        ],
        "faults": faults,
    }


def _rule(number: int, rule: RuleInfo, replay: Replay, evaluator: Evaluator) -> dict[str, Any]:
    """What a rule, the one of this number, said in every cycle."""
    by_candidate: dict[str, Any] = {}
    for name in CANDIDATES:
        whole = partial(_whole, replay, name, number, rule)
        results = replay.said(name, rule.name)
        if any(result is not None for result in results):
            by_candidate[name] = {
                "verdict": "".join(ABSENT if r is None else LETTERS[r.verdict] for r in results),
                "margin": [None if r is None else _number(r.margin) for r in results],
                "least": _least(rule, name, results, replay.recording, whole),
                "firings": list(_firings(rule, name, results, replay.recording, whole)),
            }
    units, shown = _units(number, rule, replay)
    return {
        "name": rule.name,
        "title": rule.title,
        "what": rule.kind,
        "kind": kind_of(rule, evaluator.spec),
        "requirements": [name for name, _ in rule.satisfies],
        "assuming": [name for name, _ in rule.assuming],
        # A formula over several dimensions has the unit of what decides: then every margin may have another.
        "unit": next(iter(units)) if len(units) == 1 else rule.unit,
        # The unit in which the limit is written, "" for SI; where several are, margins of different cycles are shown alike.
        "shown": next(iter(shown)) if len(shown) == 1 and len(units) == 1 else "",
        "scale": 1.0 if rule.unit == SCALED else dict(evaluator.spec.scales).get(rule.unit),
        "severity": rule.severity,
        "because": rule.because,
        "source": rule.source,
        "span": str(rule.span),
        "text": _declaration(rule.span),
        "candidates": by_candidate,
    }


def _whole(replay: Replay, candidate: str, number: int, rule: RuleInfo, cycle: int) -> RuleResult:
    """The result of a rule in a cycle, with what decided it."""
    return replay.cycles[cycle].whole(candidate, number, rule.name)


def _units(number: int, rule: RuleInfo, replay: Replay) -> tuple[set[str], set[str]]:
    """The units of a rule's margins, and those in which the limits are written that decided; of several of either, two are enough: then no single one is
    said, and of margins in several units none of a limit."""
    own = own_unit(rule.unit)
    written = _written(rule.formula)
    units = {rule.unit} if own and any(cycle.results for cycle in replay.cycles) else set()
    shown: set[str] = set()
    if own and written <= {""}:
        return units, shown
    remembering = remembers(rule)
    decisive = _decisive(rule) if own and not remembering else None
    for name in replay.candidates:
        for cycle, said in zip(replay.cycles, replay.said(name, rule.name)):
            if said is None:
                continue
            if decisive is not None and said.verdict in DECIDED and decisive <= shown:
                continue  # whatever decided it
            if said.verdict == "inactive" and not remembering and name in cycle.explain:
                units.add(undecided(rule.unit))
                continue
            result = cycle.whole(name, number, rule.name)
            units.add(result.unit)
            if result.witness is not None:
                shown.add(result.shown)
            if len(units) > 1 or (own and len(shown) >= min(2, len(written))):
                return units, shown
    return units, shown


@lru_cache(maxsize=1024)
def _written(formula: ir.Formula | None) -> frozenset[str]:
    """The units in which the limits of everything that may decide a formula are written, "" for SI."""
    found = set()
    for node in () if formula is None else ir.below(formula):
        if isinstance(node, ir.Compare):
            found.add(node.shown)
        elif isinstance(node, ir.Flag | ir.SweptInside | ir.SweptClear | ir.InArea):
            found.add("")
    return frozenset(found)


def _decisive(rule: RuleInfo) -> set[str]:
    """The units in which limits are written that decide a rule which is satisfied or violated: those of guards decide what is undefined only."""
    atoms = [] if rule.formula is None else formula_atoms(rule.formula)
    return {atom.shown if isinstance(atom, ir.Compare) and atom.unit == rule.unit else "" for atom in atoms}


def _assumption(rule: RuleInfo) -> dict[str, Any]:
    return {
        "name": rule.name,
        "title": rule.title,
        "requirements": [name for name, _ in rule.satisfies],
        "owner": rule.owner,
        "evidence": rule.evidence,
        "because": rule.because,
        "monitored": rule.formula is not None,
        "span": str(rule.span),
    }


def _firings(
    rule: RuleInfo, candidate: str, results: Sequence[Said | None], recording: Recording, whole: Whole
) -> Iterable[dict[str, Any]]:  # fmt: skip
    """Stretches of consecutive cycles in which a rule is against a candidate, each with its worst cycle."""
    numbers = [i for i, result in enumerate(results) if result is not None and result.fired]
    for first, last in intervals(numbers, range(len(results))):
        inside = {i: result for i, result in enumerate(results) if result is not None and first <= i <= last}
        yield {
            "from": _number(recording.cycles[int(first)].t),
            "to": _number(recording.cycles[int(last)].t),
            "cycles": [int(first), int(last)],
            "verdicts": sorted({result.verdict for result in inside.values()}),
            "worst": _moment(rule, candidate, _worst(inside), recording, whole),
        }


def _worst(results: Mapping[int, Said]) -> int:
    """The cycle that is violated by the most; where none is violated, the first undefined one, then the first open one."""
    order = {"violated": 0, "undefined": 1, "open": 2}
    return min(
        results.items(),
        key=lambda item: (order[item[1].verdict], 0.0 if math.isnan(item[1].margin) else item[1].margin),
    )[0]


def _least(
    rule: RuleInfo, candidate: str, results: Sequence[Said | None], recording: Recording, whole: Whole
) -> dict[str, Any] | None:
    """The cycle with the smallest margin; None where no cycle has one."""
    known = {
        i: r
        for i, r in enumerate(results)
        if r is not None and r.verdict in ("satisfied", "violated") and not math.isnan(r.margin)
    }
    if not known:
        return None
    # With equal margins (a strict comparison exactly on its boundary) the violated one counts.
    return _moment(
        rule,
        candidate,
        min(known.items(), key=lambda item: (item[1].margin, item[1].verdict != "violated"))[0],
        recording,
        whole,
    )


def _moment(
    rule: RuleInfo, candidate: str, number: int, recording: Recording, whole: Whole
) -> dict[str, Any]:
    """One result with what decided it: which sample or object, its place, and the line of the spec."""
    result = whole(number)
    cycle = recording.cycles[number]
    moment: dict[str, Any] = {
        "cycle": number,
        "t": _number(cycle.t),
        "verdict": result.verdict,
        "margin": _number(result.margin),
        "unit": result.unit,
        "shown": result.shown,
        "reason": result.reason,
        "where": [],
        "decides": None,
        "span": str(rule.span),
        "line": _line(rule.span),
    }
    witness = result.witness
    if witness is not None:
        signals = recording.signals(cycle, candidate)
        moment["where"] = [_binder(name, value, rule, signals) for name, value in witness.binders.items()]
        moment["decides"] = {"margin": _number(witness.margin), "unit": witness.unit}
        if witness.span is not None:
            moment["span"], moment["line"] = str(witness.span), _line(witness.span)
    return moment


def _binder(name: str, value: int | str, rule: RuleInfo, signals: Mapping[str, Any]) -> dict[str, Any]:
    """A variable of a rule with what it stood for: an element of a set by its id, or a sample by its number (from 0)."""
    signal = _signal_of(name, rule)
    data = signals.get(signal)
    found: dict[str, Any] = {"name": name, "value": value, "signal": signal, "t": None, "x": None, "y": None}
    if isinstance(value, int) and isinstance(data, Mapping):
        for column in ("t", "x", "y"):
            values = data.get(column)
            if values is not None and value < len(values):
                found[column] = _rounded(values[value])
    elif isinstance(value, str) and isinstance(data, list):
        for index, element in enumerate(data):
            if str(element.get("id", index)) == value:
                found["x"], found["y"] = (
                    _rounded(element.get("x", math.nan)),
                    _rounded(element.get("y", math.nan)),
                )
                break
    return found


def _signal_of(name: str, rule: RuleInfo) -> str:
    """The signal that a variable of a rule ranges over; empty where the formula binds no such name."""
    for formula in (rule.formula, rule.active):
        for node in () if formula is None else ir.below(formula):
            if isinstance(node, ir.Quantify) and name in node.names:
                return node.axis.signal
            if isinstance(node, ir.At) and name == node.name:
                return node.axis.signal
    return ""


def _objects(cycles: Sequence[Cycle]) -> list[dict[str, Any]]:
    """Objects by id, each with the numbers of the cycles that it is in and a column per field."""
    found: dict[str, dict[str, Any]] = {}
    for number, cycle in enumerate(cycles):
        for index, element in enumerate(cycle.objects):
            name = str(element.get("id", index))
            entry = found.setdefault(name, {"id": name, "cycles": [], **{field: [] for field in _BOX}})
            entry["cycles"].append(number)
            for field, value in _box(element).items():
                if field != "id":
                    entry[field].append(value)
    return list(found.values())


_BOX = ("x", "y", "heading", "length", "width")


def _box(element: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "id": str(element.get("id", "")),
        **{field: _rounded(element.get(field, math.nan)) for field in _BOX},
    }


def _path(columns: Columns) -> dict[str, list[Number]]:
    """A trajectory's positions, thinned evenly; the first and the last sample are kept."""
    count = min(len(columns.get("x", ())), len(columns.get("y", ())))
    if count <= PATH_POINTS:
        kept: Iterable[int] = range(count)
    else:
        kept = sorted({round(i * (count - 1) / (PATH_POINTS - 1)) for i in range(PATH_POINTS)})
    kept = list(kept)
    return {"x": [_rounded(columns["x"][i]) for i in kept], "y": [_rounded(columns["y"][i]) for i in kept]}


def _size(name: str, recording: Recording, evaluator: Evaluator) -> Number | None:
    """The car's length or width in m: the recording's, else the spec's; None where the spec has no such parameter, or two."""
    declared = [info for info in evaluator.spec.params.values() if info.short == name]
    if len(declared) != 1:
        return None
    info = declared[0]
    given = recording.params.get(info.name, recording.params.get(name))
    return _rounded(info.value if given is None else to_si(given, info.unit))


def _declaration(span: Span) -> str:
    """The text of a declaration: from its keyword to the next blank line."""
    lines: list[str] = []
    number = span.line
    while text := span.file.line(number).rstrip():
        lines.append(text)
        number += 1
    return "\n".join(lines)


def _line(span: Span) -> str:
    return span.file.line(span.line).strip()


def _points(points: Iterable[Sequence[float]]) -> list[list[Number]]:
    return [[_rounded(x), _rounded(y)] for x, y in points]


def _rounded(value: float) -> Number:
    value = float(value)
    return round(value, 6) if math.isfinite(value) else _number(value)


def _number(value: float) -> Number:
    """A float for strict JSON: non-finite ones as words."""
    value = float(value)
    if math.isfinite(value):
        return value
    return "nan" if math.isnan(value) else "inf" if value > 0 else "-inf"
