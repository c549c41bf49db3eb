"""Where a number makes a rule hold, found on the evaluator: the inputs are those of a test, the number is put everywhere in them."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any, NamedTuple

from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.reading.solving.algebra import Place
from trackmarshal.testing.cases import PreparedTest
from trackmarshal.testing.si import spec_in_si

#: At how many places a rule is looked at first; how near a boundary between two of them is found, and what is none beside 0, relative to all that is looked at.
PLACES, _NEAR = 61, 1e-12


class Boundary(NamedTuple):
    """Between which values of a number, of those looked at, a rule holds or asks nothing with the inputs of a test; SI."""

    test: str
    lower: float
    upper: float
    holds: tuple[tuple[float, float], ...]


def boundary(
    rule: RuleInfo, spec: Spec, test: PreparedTest, target: Place, limits: tuple[float, float]
) -> Boundary | None:
    """The boundary in one test's inputs; None where the rule is undefined somewhere, or the number is not in them."""
    in_si = spec_in_si(spec)
    evaluator = Evaluator(in_si, [rule.name], "reference")
    case = copy.deepcopy(test.case)
    if not _put(case, target, limits[0]):
        return None

    def says(x: float) -> bool | None:
        _put(case, target, x)
        verdict = evaluator.case(case).rules[rule.name].verdict
        return {"satisfied": True, "inactive": True, "violated": False}.get(verdict)

    low, high = limits
    places = [low + (high - low) * k / (PLACES - 1) for k in range(PLACES)]
    told = [says(x) for x in places]
    if any(one is None for one in told):
        return None
    holds, start = [], low if told[0] else None
    for (a, before), (b, after) in zip(zip(places, told), zip(places[1:], told[1:])):
        if before is not after:
            inside = _halved(a if before else b, b if before else a, says, _NEAR * (high - low))
            inside = 0.0 if abs(inside) <= _NEAR * (high - low) else inside
            if after:
                start = inside
            else:
                assert start is not None
                holds.append((start, inside))
                start = None
    if start is not None:
        holds.append((start, high))
    return Boundary(test.title, low, high, tuple(holds))


def _halved(inside: float, outside: float, says: Callable[[float], bool | None], near: float) -> float:
    """The last number at which a rule holds, so near to one at which it does not."""
    while abs(inside - outside) > near:
        middle = inside + (outside - inside) / 2.0
        if middle in (inside, outside):
            break
        if says(middle):
            inside = middle
        else:
            outside = middle
    return inside


def _put(case: dict[str, Any], target: Place, value: float) -> bool:
    """Put a number everywhere in a case; whether there is a place for it."""
    if not target.record:
        case["params"] = {**case.get("params", {}), target.name: value}
        return True
    signal = case["signals"].get(target.signal)
    records = signal if isinstance(signal, list) else [signal]
    for record in records:
        if not isinstance(record, dict) or target.name not in record:
            return False
        held = record[target.name]
        record[target.name] = [value] * len(held) if isinstance(held, list) else value
    return bool(records)
