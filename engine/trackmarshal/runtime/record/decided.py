"""Decisions as the values of their columns, and where one is not, to the bit, what was recorded."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.record.arrow import FLOAT, FLOATS
from trackmarshal.runtime.record.columns import DECISION
from trackmarshal.runtime.record.stencil import letters

if TYPE_CHECKING:
    from trackmarshal.runtime.record.reading import Recorded


def decided(decision: Decision) -> list[Any]:
    """A decision as the values of its columns: two decisions are the same when these are, to the bit."""
    driven = decision.driven
    judged = decision.judged
    faults = [[name_of(f), f.code, f.signal, f.field, f.index, f.message] for f in decision.faults]
    rated = [judged.rated[name] for name in (DRIVING, EMERGENCY)] if judged else []
    verdicts = [letters(one.verdicts) for one in rated] or ["", ""]
    margins = [one.margins for one in rated] or [(), ()]
    return [
        decision.state, int(decision.safe), "" if driven is None else driven.candidate, -1 if driven is None else driven.number,
        math.nan if driven is None else driven.t, decision.lost, _dumped(faults), violations(decision), *verdicts, *margins,
    ]  # fmt: skip


def violations(decision: Decision) -> str:
    """JSON of what rules are against, as the column of that name has it."""
    return _dumped([
        {
            "rule": v.rule, "requirements": list(v.requirements), "candidate": v.candidate, "verdict": v.verdict,
            "margin": spelt(v.margin), "unit": v.unit,
        }
        for v in decision.violations
    ])  # fmt: skip


def _dumped(reasons: list[Any]) -> str:
    return json.dumps(reasons) if reasons else "[]"


def decided_by_name(decision: Decision) -> dict[str, Any]:
    """A decision by the names of its columns."""
    return {name: value for (name, _), value in zip(DECISION, decided(decision))}


def spelt(value: Any) -> Any:
    """A value for strict JSON, which has no word for numbers that are not finite."""
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


@dataclass(frozen=True, slots=True)
class Difference:
    """A cycle (its place in the record) whose decision is another one now: which column, what was and what is."""

    place: int
    t: float
    column: str
    recorded: Any
    now: Any


def differences(place: int, recorded: Recorded, decision: Decision) -> list[Difference]:
    """Where a decision is not bit for bit the recorded one."""
    return [
        Difference(place, decision.t, name, old, new)
        for (name, kind), old, new in zip(DECISION, recorded.decision, decided(decision))
        if _bits(kind, old) != _bits(kind, new)
    ]


def _bits(kind: str, value: Any) -> Any:
    return np.asarray(value, dtype="<f8").tobytes() if kind in (FLOAT, FLOATS) else value
