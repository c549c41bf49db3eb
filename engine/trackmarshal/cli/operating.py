"""What a recording has of the conditions that are driven in: between which values its signals were, and which it does not have at all."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from trackmarshal.units import to_si

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.ir.spec import SignalType, Spec
    from trackmarshal.scenarios.recording import Recording

#: In SI in every recording; all others are in the units that a spec declares.
_IN_SI = ("ego", "objects", "obstacles")


def ranges(recording: Recording, spec: Spec) -> dict[str, tuple[float, float]]:
    """By `signal.field` of records and of sets, the least and the greatest finite number over all cycles, in SI."""
    found: dict[str, tuple[float, float]] = {}
    for signal, record in _records(recording, spec):
        for field in signal.fields_:
            value = record.get(field.name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                continue
            number = float(value) if signal.name in _IN_SI else to_si(float(value), field.unit)
            low, high = found.get(f"{signal.name}.{field.name}", (number, number))
            found[f"{signal.name}.{field.name}"] = (min(low, number), max(high, number))
    return dict(sorted(found.items()))


def defaulted(recording: Recording, evaluator: Evaluator) -> dict[str, tuple[str, ...]]:
    """By assumption, the fields that its monitor reads, that have a default, and that the recording does not give everywhere."""
    read = {
        rule.name: {(signal, name) for signal, name in rule.reads if _default(evaluator.spec, signal, name)}
        for rule in evaluator.rules
        if rule.kind == "assume"
    }
    wanted = set().union(*read.values()) if read else set()
    absent: set[tuple[str, str]] = set()
    if wanted:
        for signal, record in _records(recording, evaluator.spec):
            absent |= {(s, name) for s, name in wanted if s == signal.name and record.get(name) is None}
    return {
        rule: tuple(sorted(f"{signal}.{name}" for signal, name in fields & absent))
        for rule, fields in read.items()
        if fields & absent
    }


def _default(spec: Spec, signal: str, name: str) -> bool:
    info = spec.signals.get(signal)
    field = None if info is None else info.field(name)
    return field is not None and field.default is not None


def _records(recording: Recording, spec: Spec) -> Iterator[tuple[SignalType, Mapping[str, Any]]]:
    """Every record of every cycle, elements of sets by themselves; of the candidates, the samples of the first one that is there."""
    for cycle in recording.cycles:
        given = recording.signals(cycle, next(iter(cycle.candidates)))
        for name, signal in spec.signals.items():
            value = given.get(name)
            if isinstance(value, Mapping) and signal.sequence:
                yield signal, {column: "given" for column, samples in value.items() if samples is not None}
            elif isinstance(value, Mapping) and not signal.many:
                yield signal, value
            elif isinstance(value, list | tuple) and signal.many:
                yield from ((signal, element) for element in value if isinstance(element, Mapping))


__all__ = ["defaulted", "ranges"]
