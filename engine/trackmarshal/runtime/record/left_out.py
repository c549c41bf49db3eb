"""What a cycle did not have: columns in which the spec's defaults stand, and names of tracks; told when it is written, and left out again when it is read."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

from trackmarshal.runtime.contract import Contract
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.door.values import entries, is_a
from trackmarshal.runtime.record.columns import called

#: By candidate or signal, the fields that need not be there, each with its column.
Spare = list[tuple[str, tuple[tuple[str, str], ...]]]
#: A column that a cycle does not have; or that elements at these places do not.
_Lacking = str | tuple[str, tuple[int, ...]]


def spare_of(contract: Contract) -> Spare:
    """The fields of a contract that need not be there."""
    return [
        (name, fields)
        for name, signal in called(contract)
        if (fields := tuple((f.name, f"{name}.{f.name}") for f in signal.fields_ if f.default is not None))
    ]


def track_names(cycle: Any, corridors: Sequence[str]) -> dict[str, str | None] | None:
    """What a cycle which passed the door calls its tracks; None where what was handed in cannot be asked."""
    found: dict[str, str | None] = {}
    try:
        for signal in corridors:
            given = cycle.signals.get(signal)
            name = given.get("name") if is_a(given, Mapping) else None
            found[signal] = None if name is None else str.__str__(name)
    except Exception:  # what was handed in has a say in how it is read
        return None
    return found


def left_out_of(cycle: Any, spare: Spare, names: Mapping[str, str | None]) -> str | None:
    """JSON of the columns that a cycle which passed the door does not have, empty for none; each with the places of elements where only some lack
    it. names: of its tracks. None where what was handed in cannot be asked."""
    found: list[_Lacking] = [f"{signal}.name" for signal, name in names.items() if name is None]
    try:
        for name, fields in spare:
            # A candidate is called as the part of the cycle that it is.
            given: Any = getattr(cycle, name) if name in (DRIVING, EMERGENCY) else cycle.signals[name]
            if type(given) is not dict and not is_a(given, Mapping):
                elements = entries(given)
                for field, column in fields:
                    places = tuple([place for place, one in enumerate(elements) if field not in one])
                    if places:
                        found.append(column if len(places) == len(elements) else (column, places))
            else:
                found += [column for field, column in fields if field not in given]
    except Exception:  # what was handed in has a say in how it is read
        return None
    return _listed(tuple(found)) if found else ""


@lru_cache(maxsize=64)
def _listed(columns: tuple[_Lacking, ...]) -> str:
    return json.dumps(columns)


def without(signals: dict[str, Any], some: list[Any]) -> None:
    """Give sets of which only some elements have a field as records, without it where they do not."""
    for column, places in some:
        signal, _, field = column.rpartition(".")
        given = signals[signal]
        if type(given) is dict:
            listed = {name: part if name == "id" else part.tolist() for name, part in given.items()}
            given = signals[signal] = [
                dict(zip(listed, one, strict=True)) for one in zip(*listed.values(), strict=True)
            ]
        for place in places:
            del given[place][field]
