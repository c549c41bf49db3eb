"""Many cases at once: what has no flaw is checked together, everything else is read by itself, with its faults."""

from __future__ import annotations

import gc
import operator
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import FieldType, SignalType, Spec
from trackmarshal.runtime.case import (
    KEYS,
    SI,
    Case,
    CaseReader,
    Default,
    Held,
    is_array,
    name_of,
    sound,
    stand_in,
    wanted,
)  # fmt: skip
from trackmarshal.units import to_si

if TYPE_CHECKING:
    from trackmarshal.runtime.together import Together

#: Cases that are checked together, while their numbers are in the processor's cache.
AT_ONCE = 64


class CasesReader:
    """Reads cases for one spec, as `CaseReader` does, many at a time."""

    def __init__(self, spec: Spec, reads: Iterable[tuple[str, str]]) -> None:
        self._one = CaseReader(spec, reads)
        self._doors = {
            name: _door(self._one, spec.signals.get(name), needed)
            for name, needed in self._one.needed.items()
        }

    def read(self, raw: object) -> Case:
        """A case from plain data; raises TrackmarshalError D201 to D204."""
        return self.read_all([raw])[0]

    def read_all(self, raws: Iterable[object]) -> list[Case]:
        """Cases from plain data, in order; raises what the first of them that cannot be read raises.

        Plain containers are looked at first, in one go: nobody else's code runs meanwhile, so a line that many cases hold is
        the same for all of them.
        """
        if type(raws) not in (list, tuple):
            return [self.read(raw) for raw in raws]  # it may be made, or changed, as it is asked for
        raws = list(raws)
        held: Held = {}
        cases: list[Case | None] = []
        with _uncollected() if len(raws) > AT_ONCE else nullcontext():
            for first in range(0, len(raws), AT_ONCE):
                columns = _Columns(held)
                for columns.case, raw in enumerate(raws[first : first + AT_ONCE], start=first):
                    cases.append(self._plain(raw, columns))
                read = cases[first : first + AT_ONCE]
                together = columns.together() if all(read) else None
                if together is None:
                    for index in columns.flawed():
                        cases[index] = None
                else:
                    for case in read:
                        case.together = together  # type: ignore[union-attr]
        return [self._one.read(raw) if case is None else case for raw, case in zip(raws, cases)]

    def _plain(self, raw: object, columns: _Columns) -> Case | None:
        """A case of plain containers with nothing wrong but, maybe, in its lines and columns; None for any other."""
        if type(raw) is not dict or not raw.keys() <= KEYS:
            return None
        signals = raw.get("signals")
        if type(signals) is not dict:
            return None
        case = Case(id=raw.get("id"))
        try:
            for key in ("params", "tables", "places"):
                given = raw.get(key)
                if given is not None:
                    _need(type(given) is dict)
                    self._one.overrides(case, {key: given})
            for name, door in self._doors.items():
                door.read(case, name, signals.get(name), columns)
        except (_FlawedError, TrackmarshalError):
            return None  # what is wrong comes to light when it is read by itself
        return case


@contextmanager
def _uncollected() -> Iterator[None]:
    """Without garbage collection, which would look again and again through containers that are all still needed.

    At the end they count as old, where nobody froze objects for reasons of their own: frozen and thawed, without being looked at.
    """
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        if not gc.get_freeze_count():
            gc.freeze()
            gc.unfreeze()
        gc.enable()


class _FlawedError(Exception):
    """A case is not as most cases are."""


def _need(condition: bool) -> None:
    if not condition:
        raise _FlawedError


@dataclass(frozen=True, slots=True)
class Field:
    """A field that is read: of which signal, and what its values must be like, in SI."""

    #: Signal and field.
    place: tuple[str, str]
    #: At the most those of the finite numbers.
    lower: float
    upper: float
    increasing: bool


@dataclass(slots=True, eq=False)
class _Field:
    """A field that is read."""

    kind: FieldType
    name: str
    #: What a number must be like.
    limits: Field
    #: What stands in for it where it is left out.
    default: float | None
    converted: bool


_NUMBERS = {float, Default}


def _in_si(value: float, unit: str) -> float:
    return float(value) if type(value) is Default else to_si(value, unit)


class _Columns:
    """Columns in SI whose values are not checked yet, by field, each with the number of its case."""

    def __init__(self, held: Held) -> None:
        self.case = 0
        self.held = held
        #: Sets by the identity of the data that they were read from: who reads them, names and columns.
        self.sets: dict[int, tuple[_Door, list[str], dict[str, tuple[Any, ...]]]] = {}
        self._columns: dict[_Field, list[tuple[Any, ...]]] = {}
        self._values: dict[_Field, list[Any]] = {}
        self._cases: dict[_Field, list[int]] = {}

    def add(self, field: _Field, column: Sequence[Any]) -> tuple[Any, ...]:
        """A column of the case in SI."""
        if field.converted:
            _need(_NUMBERS.issuperset(map(type, column)))
            column = [_in_si(value, field.kind.unit) for value in column]
        made = tuple(column)
        self.again(field, made)
        return made

    def again(self, field: _Field, column: tuple[Any, ...]) -> None:
        """A column that is in SI already."""
        if field in self._columns:
            self._columns[field].append(column)
            self._cases[field].append(self.case)
        else:
            self._columns[field], self._cases[field] = [column], [self.case]

    def add_value(self, field: _Field, value: Any) -> Any:
        """A column of one value for each case, all in one list."""
        if field.converted:
            _need(type(value) in _NUMBERS)
            value = _in_si(value, field.kind.unit)
        if field in self._values:
            self._values[field].append(value)
            self._cases[field].append(self.case)
        else:
            self._values[field], self._cases[field] = [value], [self.case]
        return value

    def together(self) -> Together | None:
        """All columns as arrays, when nothing is wrong with any; None when something may be."""
        # It brings numpy, which whoever reads no data does without.
        from trackmarshal.runtime.together import checked

        numbers: list[tuple[Field, Sequence[Any]]] = []
        for field, columns in self._columns.items():
            if field.kind.kind == "number":
                numbers.append((field.limits, columns))
            elif not sound(field.kind, columns):
                return None
        for field, values in self._values.items():
            if field.kind.kind == "number":
                numbers.append((field.limits, [tuple(values)]))
            elif not sound(field.kind, [values]):
                return None
        return checked(numbers)

    def flawed(self) -> set[int]:
        """The numbers of the cases with a column that is not as it should be."""
        found: set[int] = set()
        for field, values in self._values.items():
            if not sound(field.kind, [values]):
                found.update(
                    case
                    for case, value in zip(self._cases[field], values)
                    if not sound(field.kind, [[value]])
                )
        for field, columns in self._columns.items():
            kind, cases = field.kind, self._cases[field]
            if not sound(kind, columns):
                found.update(case for case, column in zip(cases, columns) if not sound(kind, [column]))
            if kind.increasing:
                found.update(
                    case
                    for case, column in zip(cases, columns)
                    if case not in found and not all(map(operator.lt, column, islice(column, 1, None)))
                )
        return found


class _Door:
    """Reads a signal into a case as long as it has no flaw."""

    def __init__(self, signal: SignalType, kinds: list[FieldType]) -> None:
        self.read_fields = [
            _Field(
                kind,
                kind.name,
                _limits(signal.name, kind),
                stand_in(kind),
                kind.kind == "number" and kind.unit not in SI,
            )
            for kind in kinds
        ]
        self._optional = [kind.name for kind in kinds if kind.default is not None]
        self._names = {kind.name for kind in signal.fields_} | {"id"}

    def fields(self, data: Any) -> dict[str, Any]:
        """Data with fields, none of which may be the misspelt name of one that is left out."""
        _need(type(data) is dict)
        _need(
            not self._optional or data.keys() <= self._names or all(name in data for name in self._optional)
        )
        fields: dict[str, Any] = data
        return fields

    def read(self, case: Case, name: str, raw: Any, columns: _Columns) -> None:
        raise NotImplementedError


class _State(_Door):
    def read(self, case: Case, name: str, raw: Any, columns: _Columns) -> None:
        data = self.fields(raw)
        case.scalars[name] = {
            field.name: columns.add_value(field, data.get(field.name, field.default))
            for field in self.read_fields
        }


class _Set(_Door):
    def read(self, case: Case, name: str, raw: Any, columns: _Columns) -> None:
        known = columns.sets.get(id(raw))
        if known is None or known[0] is not self:
            _need(type(raw) is list)
            records = [self.fields(record) for record in raw]
            names = [name_of(record, index, name) for index, record in enumerate(records)]
            _need(len(set(names)) == len(names))
            made = {
                field.name: columns.add(field, [record.get(field.name, field.default) for record in records])
                for field in self.read_fields
            }
            columns.sets[id(raw)] = self, names, made
        else:  # the candidates of a cycle have their objects in common
            _, names, made = known
            for field in self.read_fields:
                columns.again(field, made[field.name])
        case.names[name], case.counts[name], case.columns[name] = names.copy(), len(names), {**made}


class _Timeline(_Door):
    def __init__(self, signal: SignalType, kinds: list[FieldType]) -> None:
        super().__init__(signal, kinds)
        self._every = [kind.name for kind in signal.fields_ if kind.kind != "polyline"]
        self._least = 2 if signal.kind == "trajectory" else 1

    def read(self, case: Case, name: str, raw: Any, columns: _Columns) -> None:
        data = self.fields(raw)
        given = {key: data[key] for key in self._every if key in data}
        for column in given.values():
            _need(type(column) is list or (is_array(column) and column.ndim == 1))
        lengths = set(map(len, given.values()))
        _need(len(lengths) == 1)
        (count,) = lengths
        _need(count >= self._least)
        made: dict[str, Sequence[Any]] = {}
        case.counts[name], case.columns[name] = count, made
        for field in self.read_fields:
            column = given.get(field.name)
            if column is not None:
                made[field.name] = columns.add(field, column if type(column) is list else column.tolist())
            else:
                _need(field.default is not None)
                made[field.name] = (field.kind.default,) * count


class _Lines(_Door):
    def __init__(self, reader: CaseReader, signal: SignalType, needed: set[str]) -> None:
        super().__init__(signal, [])
        self._reader, self._signal, self._needed = reader, signal, needed

    def read(self, case: Case, name: str, raw: Any, columns: _Columns) -> None:
        _need(raw is not None and (self._signal.kind == "polyline" or type(raw) is dict))
        self._reader.lines_of(case, self._signal, self._needed, raw, columns.held)


class _Event:
    def read(self, case: Case, name: str, raw: Any, columns: _Columns) -> None:
        _need(type(raw) is bool)
        case.scalars[name] = {"": raw}


def _limits(signal: str, kind: FieldType) -> Field:
    most = sys.float_info.max
    lower, upper = -most if kind.lower is None else kind.lower, most if kind.upper is None else kind.upper
    return Field((signal, kind.name), lower, upper, kind.increasing)


def _door(reader: CaseReader, signal: SignalType | None, needed: set[str]) -> _Door | _Event:
    if signal is None:
        return _Event()
    if signal.many:
        return _Set(signal, wanted(signal, needed))
    if signal.sequence:
        ordered = {kind.name for kind in signal.fields_ if kind.increasing}
        return _Timeline(signal, wanted(signal, needed | ordered))
    if signal.kind == "state":
        return _State(signal, wanted(signal, needed))
    return _Lines(reader, signal, needed)
