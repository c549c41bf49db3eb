"""Made-up inputs of one rule about numbers alone: one sample, or as many as the rule looks at in a row, and one element of each set."""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

from trackmarshal import typed
from trackmarshal.ir.spec import FieldType, RuleInfo, Spec
from trackmarshal.reading.solving.algebra import Place, Unsolvable

#: How far numbers go of a field that declares no range.
FAR = 100.0
#: A range that is wider, in SI, says no more than that there are numbers in it (a mass of 400 t is 4e5 kg; a time within 1e10 s is any); and how far numbers go then.
_WIDEST, _DRIVEN = 1e6, 1e4


class Inputs:
    """Cases of a rule, in SI. Raises Unsolvable for a rule that reads lines, or samples that are not in a row."""

    def __init__(self, rule: RuleInfo, spec: Spec) -> None:
        if rule.course is not None:  # its samples are those of cycles that were, and of a candidate
            raise Unsolvable("samples")
        self._spec = spec
        self._fields: dict[str, list[FieldType]] = {}
        for signal, name in sorted(rule.reads):
            field = spec.field(signal, name)
            fields = self._fields.setdefault(signal, [])
            if signal in spec.events or not name:
                continue
            if field is None or field.kind == "polyline":
                raise Unsolvable("lines")
            fields.append(field)
        assert rule.typed is not None
        self._samples: dict[str, int] = {}
        for node in typed.below(rule.typed):
            if isinstance(node, typed.Range) and node.signal.sequence:
                name = node.signal.name
                if name in self._samples:
                    raise Unsolvable("samples")
                self._samples[name] = len(node.names)
        for signal, count in self._samples.items():
            # A trajectory has two samples at least: of a rule on each one by itself, two that are alike, which times are not.
            if count == 1 and any(field.increasing for field in self._fields.get(signal, ())):
                raise Unsolvable("times")

    def bounds(self, place: Place) -> tuple[float, float]:
        """Between which values a number lies."""
        return limits(self._spec, place)

    def made(self, choose: random.Random) -> dict[str, Any]:
        """Numbers of all magnitudes."""
        signals: dict[str, Any] = {}
        for signal, fields in self._fields.items():
            info = self._spec.signals.get(signal)
            if info is None:
                signals[signal] = True  # an event: where it is not, the rule says nothing
                continue
            count = self._samples.get(signal, 1)
            columns = {field.name: _column(field, count, choose) for field in fields}
            if info.sequence:
                signals[signal] = {
                    name: column * (2 if count == 1 else 1) for name, column in columns.items()
                }
            else:
                record = {name: column[0] for name, column in columns.items()}
                signals[signal] = [record] if info.many else record
        return {"signals": signals, "params": {}}

    def value(self, case: Mapping[str, Any], place: Place) -> float:
        """The number of a case at a place; a parameter's is the one in force."""
        if not place.record:
            return float(case["params"].get(place.name, self._spec.params[place.name].value))
        record, key = self._held(case, place)
        return float(record[key])

    def put(self, case: Mapping[str, Any], place: Place, value: float) -> None:
        """Put a number at a place."""
        if not place.record:
            case["params"][place.name] = value
            return
        record, key = self._held(case, place)
        if isinstance(record, list) and self._samples[place.signal] == 1:
            record[:] = [value] * len(record)
        else:
            record[key] = value

    def _held(self, case: Mapping[str, Any], place: Place) -> tuple[Any, Any]:
        signal = case["signals"][place.signal]
        record = signal[0] if isinstance(signal, list) else signal
        held = record[place.name]
        return (held, place.offset) if isinstance(held, list) else (record, place.name)


def limits(spec: Spec, place: Place) -> tuple[float, float]:
    """Between which values a number of a rule lies, in SI."""
    if not place.record:
        info = spec.params[place.name]
        return _bounds(info.lower, info.upper)
    field = spec.field(place.signal, place.name)
    assert field is not None
    return _bounds(field.lower, field.upper)


def _bounds(lower: float | None, upper: float | None) -> tuple[float, float]:
    """A declared range; of one so wide that it is no range of what is measured, as far as people drive."""
    low = -FAR if lower is None else lower
    high = FAR if upper is None else upper
    if high - low > _WIDEST:
        near = max(low, -_DRIVEN), min(high, _DRIVEN)
        return near if near[0] < near[1] else (low, high)
    return low, high


def _column(field: FieldType, count: int, choose: random.Random) -> list[Any]:
    values = [_any(field, choose) for _ in range(count)]
    return sorted(values) if field.increasing else values


def _any(field: FieldType, choose: random.Random) -> Any:
    if field.kind == "bool":
        return choose.random() < 0.5
    if field.enumeration is not None:
        return choose.choice(field.enumeration.members)
    low, high = _bounds(field.lower, field.upper)
    value = choose.uniform(low, high) * choose.choice((1.0, 0.3, 0.03))
    return min(max(value, low), high)
