"""What a recording has of the conditions that are driven in: between which values its signals were."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from trackmarshal.units import to_si

if TYPE_CHECKING:
    from trackmarshal.ir.spec import SignalType, Spec
    from trackmarshal.scenarios.recording import Recording


def ranges(recording: Recording, spec: Spec) -> dict[str, tuple[float, float]]:
    """By `signal.field` of records and of sets, the least and the greatest finite number over all cycles, in SI."""
    found: dict[str, tuple[float, float]] = {}
    for signal, record in _records(recording, spec):
        for field in signal.fields_:
            value = record.get(field.name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                continue
            number = to_si(
                float(value), field.unit
            )  # of the format's own fields, which are in SI, no spec says anything else
            low, high = found.get(f"{signal.name}.{field.name}", (number, number))
            found[f"{signal.name}.{field.name}"] = (min(low, number), max(high, number))
    return dict(sorted(found.items()))


def _records(recording: Recording, spec: Spec) -> Iterator[tuple[SignalType, Mapping[str, Any]]]:
    """Every record of every cycle, elements of sets by themselves."""
    for cycle in recording.cycles:
        given = recording.signals(cycle, next(iter(cycle.candidates)))
        for name, signal in spec.signals.items():
            value = given.get(name)
            if isinstance(value, Mapping) and not (signal.many or signal.sequence):
                yield signal, value
            elif isinstance(value, list | tuple) and signal.many:
                yield from ((signal, element) for element in value if isinstance(element, Mapping))


__all__ = ["ranges"]
