"""Members of enumerations in a record that was read: by their names, whatever places they have in the enumeration that is in force later."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from trackmarshal.ir.reads import PLAN
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.declared import Members
from trackmarshal.runtime.door.values import floats, is_array, number


def by_name(cycle: Cycle, members: Members) -> None:
    """Give the members in a cycle that was read, which nobody else has, by name: each place that is one, and nothing else, is replaced.

    What the door would refuse stays as it came in, since it is quoted.
    """
    for signal, field, column, names in members:
        for given in (cycle.driving, cycle.emergency) if signal == PLAN else (_held(cycle.signals, signal),):
            if isinstance(given, dict) and field in given:
                given[field] = (_column if column else _one)(given[field], names)
            elif isinstance(given, list | tuple) and column:  # a set, a record an element
                for one in given:
                    if isinstance(one, dict) and field in one:
                        one[field] = _one(one[field], names)


def _held(signals: Any, name: str) -> Any:
    return signals.get(name) if isinstance(signals, dict) else None


def _column(value: Any, names: Sequence[str]) -> Any:
    if is_array(value) and value.ndim == 1 and value.size:
        made = floats(value)
        return value if made is None else [_one(entry, names) for entry in made.tolist()]
    return [_one(entry, names) for entry in value] if isinstance(value, list | tuple) else value


def _one(value: Any, names: Sequence[str]) -> Any:
    place = number(value)
    known = place is not None and place.is_integer() and 0 <= place < len(names)
    return names[int(place)] if place is not None and known else value
