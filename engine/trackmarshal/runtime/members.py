"""Members of enumerations in records: by their names, whatever places they have in the enumeration that is in force later."""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.contract import Contract
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle
from trackmarshal.runtime.door.values import floats, is_array, number

#: The members of each field that has some, in order: by the signal (`driving` and `emergency` for the plan), and the field.
Members = Mapping[tuple[str, str], tuple[str, ...]]


def members_of(contract: Contract) -> Members:
    """The members of each field of a contract that has some."""
    assert contract.plan is not None
    called = [(name, contract.plan) for name in (DRIVING, EMERGENCY)] + [
        (s.name, s) for s in contract.signals
    ]
    return {(name, field.name): field.members for name, s in called for field in s.fields_ if field.members}


def listed(members: Members) -> list[list[Any]]:
    """As the head of a record says it."""
    return [[signal, field, list(names)] for (signal, field), names in members.items()]


def unlisted(given: Any) -> Members | None:
    """What the head of a record says; None where it is of a time when heads did not. Raises ValueError for another shape."""
    if given is None:
        return None
    found = {(signal, field): tuple(names) for signal, field, names in given}
    if not all(type(text) is str for place, names in found.items() for text in (*place, *names)):
        raise ValueError("its members are no names")
    return found


def check_named(members: Members | None, contract: Contract, shown: str) -> None:
    """Raise D162 for a record that has members by their places, and does not say of which enumerations these are."""
    fields = [f"`{signal}.{field}`" for signal, field in members_of(contract)] if members is None else []
    if fields:
        raise TrackmarshalError(
            "D162", f"the record does not say of which members {fields[0]} has the places", file=shown,
            help="it was written before records did; the version that wrote it can replay it",
        )  # fmt: skip


def by_name(cycle: Cycle, members: Members, states: Container[str]) -> None:
    """Give the members in a cycle that was read, which nobody else has, by name: each place that is one, and nothing else, is replaced.

    states: the signals that have one value a field. What the door would refuse stays as it came in, since it is quoted.
    """
    for (signal, field), names in members.items():
        given = {DRIVING: cycle.driving, EMERGENCY: cycle.emergency}.get(signal)
        if given is None and isinstance(cycle.signals, dict):
            given = cycle.signals.get(signal)
        if isinstance(given, dict) and field in given:
            given[field] = (_one if signal in states else _column)(given[field], names)
        elif isinstance(given, list | tuple):  # a set, a record an element
            for one in given:
                if isinstance(one, dict) and field in one:
                    one[field] = _one(one[field], names)


def _column(value: Any, names: tuple[str, ...]) -> Any:
    if is_array(value) and value.ndim == 1 and value.size:
        made = floats(value)
        return value if made is None else [_one(entry, names) for entry in made.tolist()]
    return [_one(entry, names) for entry in value] if isinstance(value, list | tuple) else value


def _one(value: Any, names: tuple[str, ...]) -> Any:
    place = number(value)
    known = place is not None and place.is_integer() and 0 <= place < len(names)
    return names[int(place)] if place is not None and known else value
