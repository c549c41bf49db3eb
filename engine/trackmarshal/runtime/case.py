"""One case: the values of all signals at one moment, in SI, with everything that breaks the input contract (S-2-C)."""

from __future__ import annotations

import marshal
import math
import sys
from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import TYPE_CHECKING, Any

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import FieldType, ParamInfo, PlaceInfo, SignalType, Spec, TableInfo
from trackmarshal.units import from_si, to_si

if TYPE_CHECKING:
    from trackmarshal.runtime.together import Together

NAN = math.nan
Point = tuple[float, float]
Line = tuple[Point, ...]
#: Lines by the identity of the data that they were read from, which stands beside them so that it stays unique.
Held = dict[int, tuple[object, Line]]
#: Lines that a reader remembers: more than one run's tracks have, few enough to hold.
KEPT_LINES = 32


@dataclass(frozen=True, slots=True)
class Fault:
    """One breach of the input contract: which field, which sample or element, and what is wrong."""

    code: str
    signal: str
    field: str
    index: int | None
    message: str

    def __str__(self) -> str:
        place = (
            self.signal
            + (f".{self.field}" if self.field else "")
            + ("" if self.index is None else f"[{self.index}]")
        )
        return f"{self.code} {place}: {self.message}"


@dataclass(slots=True)
class Case:
    """Values in SI; NaN stands for a missing number, None for a missing Boolean.

    `columns[signal][field]` holds timelines and sets, one entry a sample or element; `scalars[signal][field]` single
    records; `lines[signal, field]` polylines. `unusable` names (signal, field) pairs ("" for a whole signal):
    rules that read one of them are undefined, whatever they compute.
    """

    id: object = None
    params: dict[str, float] = field(default_factory=dict)
    tables: dict[str, tuple[Sequence[float], Sequence[float]]] = field(default_factory=dict)
    places: dict[str, Line] = field(default_factory=dict)
    columns: dict[str, dict[str, Sequence[Any]]] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    names: dict[str, Sequence[str]] = field(default_factory=dict)
    scalars: dict[str, dict[str, Any]] = field(default_factory=dict)
    lines: dict[tuple[str, str], Line] = field(default_factory=dict)
    closed: dict[str, bool] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    unusable: set[tuple[str, str]] = field(default_factory=set)
    #: The columns of this case and of those that were read with it, where all of them were flawless.
    together: Together | None = field(default=None, repr=False, compare=False)

    def fault(
        self, code: str, signal: str, field_: str, index: int | None, message: str, unusable: bool = True
    ) -> None:
        self.faults.append(Fault(code, signal, field_, index, message))
        if unusable:
            self.unusable.add((signal, field_))

    def blocks(self, reads: Iterable[tuple[str, str]]) -> bool:
        """Whether one of these (signal, field) pairs cannot be used."""
        if not self.unusable:
            return False
        return any(pair in self.unusable or (pair[0], "") in self.unusable for pair in reads)


class CaseReader:
    """Reads cases for one spec; `reads` are the (signal, field) pairs that the chosen rules need."""

    def __init__(self, spec: Spec, reads: Iterable[tuple[str, str]]) -> None:
        self.spec = spec
        self.needed: dict[str, set[str]] = {}
        for signal, name in reads:
            self.needed.setdefault(signal, set()).add(name)
        self._params = _by_short_name(spec.params)
        self._tables = _by_short_name(spec.tables)
        self._places = _by_short_name(spec.places)
        #: Lines of late by content: data that was read before may have changed since, and its identity says nothing.
        self._known: OrderedDict[Any, Line] = OrderedDict()

    def read(self, raw: object) -> Case:
        """A case from plain data as `cli.md` describes it; raises TrackmarshalError D201 to D204."""
        data = _mapping(raw, "the case")
        for key in data.keys() - KEYS:
            hint = close_matches(str(key), KEYS)
            if hint:  # a misspelt override that is left out would change what is evaluated
                raise TrackmarshalError("D203", f"a case has no `{key}`", help=hint)
        case = Case(id=data.get("id"))
        self.overrides(case, data)
        signals = _mapping(data.get("signals", {}), "`signals`")
        for name, needed in self.needed.items():
            if name in self.spec.events:
                self._event(case, name, signals.get(name))
                continue
            signal = self.spec.signals[name]
            if signals.get(name) is None:
                case.fault("D211", name, "", None, "the signal is missing")
                _poison(case, signal, needed)
            elif signal.many:
                self._set(case, signal, needed, signals[name])
            elif signal.sequence:
                self._timeline(case, signal, needed, signals[name])
            elif signal.kind == "state":
                self._state(case, signal, needed, signals[name])
            else:
                self.lines_of(case, signal, needed, signals[name])
        if len(case.faults) > MOST_FAULTS:
            case.faults = _condensed(case.faults)
        return case

    # Overrides ------------------------------------------------------------------------------------------------

    def overrides(self, case: Case, data: Mapping[str, Any]) -> None:
        for name, value in _given(data, "params").items():
            info = _find(self._params, name, "parameter")
            case.params[info.name] = check_param(info, _number(value, f"params.{name}"))
        for name, rows in _given(data, "tables").items():
            table = _find(self._tables, name, "table")
            case.tables[table.name] = check_table(table, rows)
        for name, points in _given(data, "places").items():
            place = _find(self._places, name, "place")
            case.places[place.name] = check_place(place, points)

    # Signals --------------------------------------------------------------------------------------------------

    def _event(self, case: Case, name: str, value: object) -> None:
        if value is not None and not isinstance(value, bool):
            raise TrackmarshalError(
                "D202", f"event `{name}` is true, false or null, not {_type(value)}", help=_MISSING
            )
        if value is None:
            case.fault("D211", name, "", None, "the event is missing")
        case.scalars[name] = {"": value}

    def _state(self, case: Case, signal: SignalType, needed: set[str], raw: object) -> None:
        data = _mapping(raw, f"signal `{signal.name}`")
        values: dict[str, Any] = {}
        _refuse_misspelt(signal, data, needed)
        for kind in wanted(signal, needed):
            value = data.get(kind.name, self._default(kind))
            if kind.name not in data and kind.default is None:
                case.fault("D211", signal.name, kind.name, None, "the field is missing")
            values[kind.name] = self._value(case, signal, kind, value, None)
        case.scalars[signal.name] = values

    def _set(self, case: Case, signal: SignalType, needed: set[str], raw: object) -> None:
        elements = _sequence(raw, f"signal `{signal.name}`")
        records = [_mapping(element, f"{signal.name}[{i}]") for i, element in enumerate(elements)]
        case.counts[signal.name] = len(records)
        names = case.names[signal.name] = [
            name_of(record, i, signal.name) for i, record in enumerate(records)
        ]
        if len(set(names)) < len(names):
            index = next(i for i, name in enumerate(names) if name in names[:i])
            case.fault("D218", signal.name, "id", index, f"`{names[index]}` stands twice", False)
        for record in records:
            _refuse_misspelt(signal, record, needed)
        columns: dict[str, Sequence[Any]] = {}
        for kind in wanted(signal, needed):
            default = self._default(kind)
            if kind.default is None:
                for index, record in enumerate(records):
                    if kind.name not in record:
                        case.fault("D211", signal.name, kind.name, index, "the field is missing")
            columns[kind.name] = tuple(
                self._column(case, signal, kind, [record.get(kind.name, default) for record in records])
            )
        case.columns[signal.name] = columns

    def _timeline(self, case: Case, signal: SignalType, needed: set[str], raw: object) -> None:
        data = _mapping(raw, f"signal `{signal.name}`")
        # The order of samples counts for every rule, whether it reads the time or not.
        orders = {k.name for k in signal.fields_ if k.increasing and k.name in data}
        kinds = wanted(signal, needed | orders)
        _refuse_misspelt(signal, data, needed)
        given = {
            k.name: _sequence(data[k.name], f"{signal.name}.{k.name}")
            for k in kinds
            if data.get(k.name) is not None
        }
        # Columns that no rule reads count too: where one is longer, samples are missing from the others.
        present = [k.name for k in signal.fields_ if k.kind != "polyline" and data.get(k.name) is not None]
        lengths = {name: _length(data[name], f"{signal.name}.{name}") for name in present}
        count = max(lengths.values(), default=1)
        if not lengths:
            case.fault("D211", signal.name, "", None, "the signal has no columns")
        if len(set(lengths.values())) > 1:
            spoken = ", ".join(f"{name} {length}" for name, length in sorted(lengths.items()))
            case.fault("D212", signal.name, "", None, f"the columns have different lengths: {spoken}")
            count = min(lengths.values())
        least = 2 if signal.kind == "trajectory" else 1
        if lengths and min(lengths.values()) < least:
            case.fault(
                "D213", signal.name, "", None, f"{min(lengths.values())} samples, at least {least} are needed"
            )
            count = max(count, 1)
        columns: dict[str, Sequence[Any]] = {}
        for kind in kinds:
            column = given.get(kind.name)
            if column is None:
                # A null is a missing value, not the wish for a default.
                if kind.default is None or kind.name in data:
                    case.fault("D211", signal.name, kind.name, None, "the column is missing")
                    columns[kind.name] = (None if kind.kind == "bool" else NAN,) * count
                else:
                    columns[kind.name] = (kind.default,) * count
                continue
            values = self._column(case, signal, kind, column[:count])
            values += [None if kind.kind == "bool" else NAN] * (count - len(values))
            if kind.increasing:
                if math.isnan(values[0]):
                    case.unusable.add((signal.name, ""))
                for i, (before, after) in enumerate(zip(values, values[1:])):
                    if not before < after:  # NaN too
                        case.fault(
                            "D214", signal.name, kind.name, i + 1, f"{after!r} follows {before!r}", False
                        )
                        case.unusable.add((signal.name, ""))
                        break
            columns[kind.name] = tuple(values)
        case.columns[signal.name] = columns
        case.counts[signal.name] = count

    def lines_of(
        self, case: Case, signal: SignalType, needed: set[str], raw: object, held: Held | None = None
    ) -> None:
        """The lines of a signal; `held` are those of data that cannot have changed since it was put there."""
        if signal.kind == "polyline":
            case.lines[signal.name, ""] = self._line(case, signal.name, "", raw, held)
            return
        data = _mapping(raw, f"signal `{signal.name}`")
        closed = data.get("closed", False)
        if not isinstance(closed, bool):
            raise TrackmarshalError(
                "D202",
                f"{signal.name}.closed is true or false, not {_type(closed)}",
                help="leave it out for false",
            )
        case.closed[signal.name] = closed
        for name in {kind.name for kind in signal.fields_ if kind.kind == "polyline"} & (
            needed | {"left", "right"}
        ):
            if data.get(name) is None:
                case.fault("D211", signal.name, name, None, "the line is missing")
                case.lines[signal.name, name] = ()
            else:
                case.lines[signal.name, name] = self._line(case, signal.name, name, data[name], held)

    def _line(self, case: Case, signal: str, name: str, raw: object, held: Held | None) -> Line:
        """Points of a line. Equal lines of late (a track that many cases share) give the same tuple, so that evaluators
        prepare it once."""
        if held is not None and id(raw) in held:
            return held[id(raw)][1]
        content = _content(raw)
        known = self._known.get(content) if content is not None else None
        points = known or tuple(_points(raw, f"{signal}.{name}" if name else signal))
        if known is None:
            for index, (x, y) in enumerate(points):
                if not (math.isfinite(x) and math.isfinite(y)):
                    case.fault("D215", signal, name, index, "a point is not finite")
                    return points
            if len(points) < 2:
                case.fault("D217", signal, name, None, f"{len(points)} points, at least 2 are needed")
                return points
            if content is None or not _has_numbers_only(raw):
                return points
            self._known[content] = points
            while len(self._known) > KEPT_LINES:
                self._known.popitem(last=False)
        if held is not None:
            held[id(raw)] = raw, points
        return points

    def _column(self, case: Case, signal: SignalType, kind: FieldType, column: Sequence[Any]) -> list[Any]:
        """The values of a column. Almost all columns are flawless numbers, which a few passes over them tell."""
        if kind.kind == "number" and {float}.issuperset(map(type, column)):
            values = list(column) if kind.unit in SI else [to_si(value, kind.unit) for value in column]
            if sound(kind, [values]):
                return values
        return [self._value(case, signal, kind, value, i) for i, value in enumerate(column)]

    @staticmethod
    def _default(kind: FieldType) -> float | None:
        """What stands in for a field that is left out."""
        return stand_in(kind)

    def _value(
        self, case: Case, signal: SignalType, kind: FieldType, value: object, index: int | None
    ) -> Any:
        if kind.kind == "bool":
            if value is None:
                case.fault("D215", signal.name, kind.name, index, "the value is missing", False)
            elif not isinstance(value, bool):
                place = _place(signal.name, kind.name, index)
                raise TrackmarshalError(
                    "D202", f"{place} is true, false or null, not {_type(value)}", help=_MISSING
                )
            return value
        if type(value) is Default:
            return float(value)
        number = _number(value, signal.name, kind.name, index)
        if kind.unit not in SI:
            number = to_si(number, kind.unit)
        if not math.isfinite(number):
            case.fault("D215", signal.name, kind.name, index, "not finite", False)
            return NAN
        if (kind.lower is not None and number < kind.lower) or (
            kind.upper is not None and number > kind.upper
        ):
            low, high = (
                ("-inf", "inf")[i] if b is None else f"{from_si(b, kind.unit):g}"
                for i, b in enumerate((kind.lower, kind.upper))
            )
            message = f"{value!r} {kind.unit} is outside [{low}, {high}]"
            case.fault("D216", signal.name, kind.name, index, message, False)
        return number


#: What a case may hold; other keys are the user's own.
KEYS = {"id", "params", "tables", "places", "signals"}
#: More faults than this are summed up, a few for each field.
MOST_FAULTS = 20


class Default(float):
    """A declared default among data in another unit: in SI already, and not converted."""


def stand_in(kind: FieldType) -> float | None:
    """What stands in for a field that is left out: its default, marked where data is converted; None without one."""
    if kind.default is None or kind.unit in SI:
        return kind.default
    return Default(kind.default)


def sound(kind: FieldType, columns: Sequence[Sequence[Any]]) -> bool:
    """Whether nothing is wrong with any value of some columns, in SI; where it says no, there may still be nothing."""
    values = list(chain.from_iterable(columns))
    if not values:
        return True
    if kind.kind == "bool":
        return set(map(type, values)) == {bool}
    return (
        set(map(type, values)) == {float}
        and math.isfinite(sum(values))  # which it is only if all of them are
        and (kind.lower is None or min(values) >= kind.lower)
        and (kind.upper is None or max(values) <= kind.upper)
    )


def _given(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """The overrides of one kind; null and absent mean none."""
    value = data.get(key)
    return {} if value is None else _mapping(value, f"`{key}`")


def name_of(record: Mapping[str, Any], index: int, signal: str) -> str:
    """What an element is called: its id, or its index."""
    name = record.get("id")
    if name is None:
        return str(index)
    if isinstance(name, bool) or not isinstance(name, (str, int, float)):
        help_ = "leave it out to have the index"
        raise TrackmarshalError(
            "D202", f"{signal}[{index}].id is a string or a number, not {_type(name)}", help=help_
        )
    return str(name)


def _refuse_misspelt(signal: SignalType, data: Mapping[str, Any], needed: set[str]) -> None:
    """Refuse a field whose name is almost that of one that is left out, and whose default would stand in for it."""
    left_out = [
        k.name for k in signal.fields_ if k.default is not None and k.name in needed and k.name not in data
    ]
    if left_out:
        for key in data.keys() - {k.name for k in signal.fields_} - {"id"}:
            hint = close_matches(str(key), left_out, 0.75)
            if hint:
                raise TrackmarshalError("D203", f"`{signal.name}` has no field `{key}`", help=hint)


def _condensed(faults: list[Fault]) -> list[Fault]:
    """The first faults of each kind and field, and how many more there are."""
    groups: dict[tuple[str, str, str], list[Fault]] = {}
    for fault in faults:
        groups.setdefault((fault.code, fault.signal, fault.field), []).append(fault)
    result: list[Fault] = []
    for (code, signal, name), group in groups.items():
        result += group[:3]
        if len(group) > 3:
            result.append(Fault(code, signal, name, None, f"and {len(group) - 3} more"))
    return result


#: Units whose numbers need no conversion; the rest take a multiplication.
SI = {"1", "m", "s", "kg", "rad", "m/s", "m/s^2", "1/m", "N"}


def check_param(info: ParamInfo, value: float) -> float:
    """An override in the declared unit to SI; raises D204 when it is not finite or outside the declared range."""
    number = to_si(value, info.unit)
    short = info.name.rpartition(".")[2]
    if not math.isfinite(number):
        raise TrackmarshalError(
            "D204", f"parameter `{short}` is not finite", help="leave it out to keep the spec's own value"
        )
    if (info.lower is not None and number < info.lower) or (info.upper is not None and number > info.upper):
        help_ = f"the range is declared at {info.span}"
        raise TrackmarshalError(
            "D204", f"parameter `{short}` = {value!r} {info.unit} is outside its range", help=help_
        )
    return number


def check_table(info: TableInfo, rows: object) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Rows [x, y] in the declared units to knots and values in SI; raises D202 or D204."""
    short = info.name.rpartition(".")[2]
    pairs = [(to_si(x, info.units[0]), to_si(y, info.units[1])) for x, y in _points(rows, f"tables.{short}")]
    if not pairs or any(not (math.isfinite(x) and math.isfinite(y)) for x, y in pairs):
        raise TrackmarshalError(
            "D204", f"table `{short}` has no rows, or a value that is not finite", help=_ROWS
        )
    if any(not a[0] < b[0] for a, b in zip(pairs, pairs[1:])):
        raise TrackmarshalError("D204", f"the knots of table `{short}` do not ascend", help=_ROWS)
    return tuple(p[0] for p in pairs), tuple(p[1] for p in pairs)


_ROWS = "rows are [x, y], finite, in the declared units, with x ascending"


def check_place(info: PlaceInfo, points: object) -> Line:
    """Points of a zone (three or more different ones) or a line (two or more), finite; raises D202 or D204."""
    short = info.name.rpartition(".")[2]
    found = tuple(_points(points, f"places.{short}"))
    least = 3 if info.kind == "zone" else 2
    if len(set(found)) < least or not all(math.isfinite(x) and math.isfinite(y) for x, y in found):
        help_ = f"a {info.kind} is a list of at least {least} different points [x, y] in m"
        raise TrackmarshalError("D204", f"the points of `{short}` are too few, or not finite", help=help_)
    return found


def wanted(signal: SignalType, needed: set[str]) -> list[FieldType]:
    return [kind for kind in signal.fields_ if kind.name in needed and kind.kind != "polyline"]


def _poison(case: Case, signal: SignalType, needed: set[str]) -> None:
    """One sample or element of nothing, so that whatever reads the signal is undefined."""
    if signal.many or signal.sequence:
        case.columns[signal.name] = {
            k.name: (None if k.kind == "bool" else NAN,) for k in wanted(signal, needed)
        }
        case.counts[signal.name] = 1
        case.names[signal.name] = ["?"]
    elif signal.kind == "state":
        case.scalars[signal.name] = {
            k.name: None if k.kind == "bool" else NAN for k in wanted(signal, needed)
        }
    else:
        for kind in signal.fields_:
            case.lines[signal.name, kind.name] = ()
        case.lines[signal.name, ""] = ()


Info = ParamInfo | TableInfo | PlaceInfo


def _by_short_name(infos: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Declarations by qualified name, and by the last part of it."""
    result: dict[str, list[Any]] = {}
    for name, info in infos.items():
        result.setdefault(name, []).append(info)
        result.setdefault(name.rpartition(".")[2], []).append(info)
    return result


def _find(known: dict[str, list[Any]], name: str, what: str) -> Any:
    found = known.get(name, [])
    if not found:
        shorts = [key for key in known if "." not in key]
        listed = (
            f"it declares {', '.join(shorts[:12])}" + (", ..." if len(shorts) > 12 else "")
            if shorts
            else f"it has no {what}s"
        )
        raise TrackmarshalError(
            "D203", f"the spec declares no {what} `{name}`", help=close_matches(name, known) or listed
        )
    if len({info.name for info in found}) > 1:
        choices = " or ".join(f"`{info.name}`" for info in found)
        raise TrackmarshalError(
            "D203", f"{what} `{name}` is declared in several modules", help=f"write {choices}"
        )
    return found[0]


def _mapping(raw: object, what: str) -> Mapping[str, Any]:
    if not isinstance(raw, Mapping):
        help_ = "write it as {...}; leave it out if there is none"
        if what == "the case":
            raise TrackmarshalError(
                "D201", f"{what} is an object, not {_type(raw)}", help='write {"id": 1, "signals": {...}}'
            )
        raise TrackmarshalError("D202", f"{what} is an object, not {_type(raw)}", help=help_)
    return raw


def _sequence(raw: object, what: str) -> Sequence[Any]:
    if hasattr(raw, "tolist"):
        raw = raw.tolist()
    if not isinstance(raw, (list, tuple)):
        raise TrackmarshalError("D202", f"{what} is a list, not {_type(raw)}", help="write it as [...]")
    return raw


def _length(raw: Any, what: str) -> int:
    """How many entries a column has that need not be read otherwise."""
    return len(raw) if getattr(raw, "ndim", 0) else len(_sequence(raw, what))


def _number(value: object, *where: object) -> float:
    if type(value) is float:
        return value
    if value is None:
        return NAN
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        if isinstance(value, str) and value in ("nan", "inf", "-inf"):
            return float(value)
        raise TrackmarshalError(
            "D202", f"{_place(*where)} is a number or null, not {_type(value)}", help=_MISSING
        )
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _place(*where: object) -> str:
    """Where a value stands: plan.v[3]."""
    text = ".".join(part for part in where if isinstance(part, str))
    return text + "".join(f"[{part}]" for part in where if isinstance(part, int))


def _content(raw: Any) -> object:
    """A key for lists, tuples and arrays: lines with the same one are the same, types and bits, if they have only numbers.

    `marshal` writes each type of plain data in a way of its own, so there is one way only to read it; but whatever has a
    buffer becomes bytes, which says nothing of its type.
    """
    if is_array(raw):
        return _Content((raw.dtype.str, raw.shape), raw.tobytes()) if raw.dtype.kind in "fiu" else None
    if type(raw) not in (list, tuple):
        return None
    try:
        # Later versions write references: slower, and not in one way only.
        return _Content(None, marshal.dumps(raw, 2))
    except ValueError:
        return None


class _Content:
    """Bytes and what they are of, as a key: compared in full, hashed by a few of them, since hashing takes longer."""

    __slots__ = ("_data", "_kind")

    def __init__(self, kind: object, data: bytes) -> None:
        self._kind, self._data = kind, data

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Content) and self._kind == other._kind and self._data == other._data

    def __hash__(self) -> int:
        data, middle = self._data, len(self._data) // 2
        return hash((len(data), data[:64], data[middle : middle + 64], data[-64:]))


def is_array(raw: object) -> bool:
    """Whether data is a numpy array, and of no derived type."""
    numpy = sys.modules.get("numpy")  # without it there is none
    return numpy is not None and type(raw) is numpy.ndarray


def _has_numbers_only(raw: Any) -> bool:
    """Whether a line is an array, or plain pairs of plain numbers."""
    if type(raw) not in (list, tuple):
        return True
    return all(type(row) in (list, tuple) and {float, int}.issuperset(map(type, row)) for row in raw)


def _points(raw: object, what: str) -> list[Point]:
    points = []
    for index, row in enumerate(_sequence(raw, what)):
        pair = _sequence(row, f"{what}[{index}]")
        if len(pair) != 2:
            entries = "1 entry" if len(pair) == 1 else f"{len(pair)} entries"
            raise TrackmarshalError("D202", f"{what}[{index}] has {entries}, not 2", help="a point is [x, y]")
        points.append((_number(pair[0], what, index), _number(pair[1], what, index)))
    return points


_MISSING = "null stands for a missing value; numbers are in the declared unit"


def _type(raw: object) -> str:
    names = {dict: "an object", list: "a list", str: "a string", bool: "a Boolean", type(None): "null"}
    return names.get(type(raw), "a number" if isinstance(raw, (int, float)) else f"a {type(raw).__name__}")
