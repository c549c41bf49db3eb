"""Units and members of the numbers in a record: those of then, beside which a spec may declare others later."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import SignalType, Spec, short_name
from trackmarshal.runtime.contract import Contract
from trackmarshal.units import is_si, parse_unit

if TYPE_CHECKING:
    from trackmarshal.runtime.record.reading import Run

#: By what a number is of (`field`, `param` or `table`) and its name (`ego.v`), the unit as it was declared; of a table those of both columns.
Units = Mapping[tuple[str, str], tuple[str, ...]]
#: Fields that have members: their signals, names, whether they are columns, and the members in order. A field of the plan is one of both candidates.
Members = Sequence[tuple[str, str, bool, Sequence[str]]]

#: No unit has such an exponent, and to work one out may take for ever.
_ENDLESS = re.compile("[0-9]{3}")


def units_of_fields(signals: Iterable[SignalType]) -> Units:
    """The units of all fields of signals that are numbers, and no members."""
    return {
        ("field", f"{signal.name}.{field.name}"): (field.unit,)
        for signal in signals
        for field in signal.fields_
        if field.kind == "number" and field.enumeration is None
    }


def units_of_values(spec: Spec, params: Collection[str], tables: Collection[str]) -> Units:
    """The units of values in place of a spec's own, by the names under which they are given."""
    found: dict[tuple[str, str], tuple[str, ...]] = {}
    for param in spec.params.values():
        found |= {("param", name): (param.unit,) for name in {param.name, short_name(param)} & {*params}}
    for table in spec.tables.values():
        found |= {("table", name): table.units for name in {table.name, short_name(table)} & {*tables}}
    return found


def listed(units: Units) -> list[list[str]]:
    """Units as the head of a record says them."""
    return [[kind, name, *of] for (kind, name), of in units.items()]


def unlisted(given: Any) -> Units | None:
    """The units that the head of a record says; None where it is of a time when heads did not. Raises ValueError for another shape."""
    if given is None:
        return None
    found = {(kind, name): tuple(of) for kind, name, *of in given}
    if not all(type(text) is str for place, of in found.items() for text in (*place, *of)):
        raise ValueError("its units are no names")
    for of in found.values():
        if any(map(_ENDLESS.search, of)):
            raise ValueError("its units are none")
        _parsed(of)
    return found


def listed_members(spec: Spec) -> list[list[Any]]:
    """Those of all fields that a spec declares, read or not, as the head of a record says them: a later rule may read what came in and nobody read."""
    return [
        [signal.name, field.name, signal.many or signal.sequence, list(field.enumeration.members)]
        for signal in spec.signals.values()
        for field in signal.fields_
        if field.enumeration is not None
    ]


def unlisted_members(given: Any) -> Members | None:
    """The members that the head of a record says; None where it is of a time when heads did not. Raises ValueError for another shape."""
    if given is None:
        return None
    found = [(signal, field, column, tuple(names)) for signal, field, column, names in given]
    if any(
        type(column) is not bool or not {str}.issuperset(map(type, (signal, field, *names)))
        for signal, field, column, names in found
    ):
        raise ValueError("its members are no names")
    return found


def check_numbers(
    run: Run, spec: Spec, contract: Contract, params: Collection[str] | None = None, tables: Collection[str] | None = None
) -> None:  # fmt: skip
    """Raise D162 for a record with numbers that would be taken in another unit, or as places of members; and for one that does not say in
    which units they are, where these may be others than those of the SI, or of which enumerations places are those of members.

    contract: what rules read. params, tables: the names of the values that are taken from the record, those that it has if none are given.
    """
    units, shown = run.units, run.source
    params = run.identity.get("params", ()) if params is None else params
    tables = run.identity.get("tables", ()) if tables is None else tables
    fields = contract.numbers
    for name, field in fields.items():
        if field.members and run.members is None:
            raise _unsaid(f"of which members `{name}` has the places", shown)
        if field.members and ("field", name) in (units or {}):
            raise _other(f"`{name}` is a number in the record, and has members in the spec", shown)
    read: Units = {("field", name): (field.unit,) for name, field in fields.items() if not field.members}
    for (kind, name), now in {**read, **units_of_values(spec, params, tables)}.items():
        was = None if units is None else units.get((kind, name))
        if was is not None and _parsed(was) != _parsed(now):
            message = f"`{name}` is in {' and '.join(was)} in the record, and the spec has it in {' and '.join(now)}"
            raise _other(message, shown)
        unsaid = was is None and (units is None or kind != "field")  # a field that is new is in no cycle
        if unsaid and not all(map(is_si, now)):
            raise _unsaid(f"in which unit `{name}` is", shown)


def _unsaid(what: str, shown: str) -> TrackmarshalError:
    return TrackmarshalError(
        "D162", f"the record does not say {what}", file=shown,
        help="it was written before records did; the version that wrote it can replay it",
    )  # fmt: skip


def _other(message: str, shown: str) -> TrackmarshalError:
    return TrackmarshalError(
        "D162", message, file=shown, help="replay it with a spec that declares it as that of the run did"
    )


def _parsed(units: tuple[str, ...]) -> list[tuple[Any, ...]]:
    return [parse_unit(unit) for unit in units]
