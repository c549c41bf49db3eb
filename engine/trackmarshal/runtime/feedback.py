"""What a planner is told of a decision: every reason as plain data, with the candidate, the rule, the place and by how much."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from trackmarshal.runtime.contract import PLAN
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.faults import Fault, name_of
from trackmarshal.runtime.frame import Frame

if TYPE_CHECKING:
    from trackmarshal.runtime.decision import Decision, Violation

#: What is told of the sample that decided, as far as the plan has it.
_PLACE = ("t", "s", "x", "y", "v")


def feedback(decision: Decision) -> list[dict[str, Any]]:
    """One entry a reason, in the order of `Decision.reasons`; strict JSON (numbers that are not finite are "inf", "-inf" and "nan").

    kind `rule`: candidate, rule, requirements, verdict, margin and unit, `by` (how much is missing, in the same unit; None where that is
    not known), `reason` (why it is undefined, or that nothing fulfils it), `at` (variables of the rule), `where` (the first sample of the candidate that decided: `sample`,
    `to` where it is a stretch, `t`, `s`, `x`, `y`, `v`; None where it is none of its samples), `object` (who else it is about), `decided_by` (the place in the spec).
    kind `fault`: candidate (or None), fault, code, signal, field, index, message. kind `lost`: reason.
    """
    told = [_of_fault(fault) for fault in decision.faults]
    frame = None if decision.judged is None else decision.judged.about
    told += [_of_rule(violation, frame) for violation in decision.violations]
    if decision.more:
        told.append({"kind": "more"})
    if decision.lost:
        told.append({"kind": "lost", "reason": decision.lost})
    return told


def _of_fault(fault: Fault) -> dict[str, Any]:
    candidate = fault.signal if fault.signal in (DRIVING, EMERGENCY) else None
    return {
        "kind": "fault", "candidate": candidate, "fault": name_of(fault), "code": fault.code, "signal": fault.signal,
        "field": fault.field, "index": fault.index, "message": fault.message,
    }  # fmt: skip


def _of_rule(violation: Violation, frame: Frame | None) -> dict[str, Any]:
    result = violation.explain()
    witness = result.witness
    places = witness.places if witness is not None else ()
    short = -violation.margin if -math.inf < violation.margin < 0.0 else None
    reason = "nothing in its range fulfils it" if result.unmet else result.reason
    return {
        "kind": "rule", "candidate": violation.candidate, "rule": violation.rule, "requirements": list(violation.requirements),
        "verdict": violation.verdict, "margin": _number(violation.margin), "unit": result.unit or violation.unit,
        "by": short, "reason": reason,
        "at": dict(witness.binders) if witness is not None else {},
        "where": None if frame is None else _where(frame, violation.candidate, places),
        "object": None if frame is None else _object(frame, places),
        "decided_by": str(witness.span) if witness is not None and witness.span is not None else None,
    }  # fmt: skip


def _where(frame: Frame, candidate: str, places: tuple[tuple[str, int], ...]) -> dict[str, Any] | None:
    """The samples of the candidate that decided; the first of them with its place."""
    columns = frame.candidates.get(candidate)
    if columns is None:
        return None
    samples = sorted({i if i >= 0 else columns.count + i for signal, i in places if signal == PLAN})
    samples = [i for i in samples if 0 <= i < columns.count]
    if not samples:
        return None
    told: dict[str, Any] = {"sample": samples[0]}
    if samples[-1] != samples[0]:
        told["to"] = samples[-1]
    for name in _PLACE:
        if name in columns.names.rows and name not in columns.absent:
            told[name] = _number(float(columns.column(name)[samples[0]]))
    return told


def _object(frame: Frame, places: tuple[tuple[str, int], ...]) -> dict[str, Any] | None:
    """The element of a set that decided: its signal and id."""
    for signal, index in places:
        columns = frame.columns.get(signal)
        if signal != PLAN and columns is not None and columns.ids and 0 <= index < columns.count:
            return {"signal": signal, "id": columns.ids[index]}
    return None


def _number(value: float) -> float | str:
    return value if math.isfinite(value) else str(value)
