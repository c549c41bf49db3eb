"""Values in place of a spec's own: parameters, tables and places from plain data, in the declared units."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping
from typing import Any

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import ParamInfo, PlaceInfo, Spec, TableInfo, short_name
from trackmarshal.ir.tables import in_period
from trackmarshal.runtime.frame import Settings
from trackmarshal.runtime.lines import Point
from trackmarshal.units import to_si

_MISSING = "null stands for a missing value; numbers are in the declared unit"
_ROWS = "rows are [x, y], finite, in the declared units, with x ascending"


class SettingsReader:
    """Reads overrides for one spec."""

    def __init__(self, spec: Spec) -> None:
        self._params = _by_short_name(spec.params)
        self._tables = _by_short_name(spec.tables)
        self._places = _by_short_name(spec.places)

    def read(self, data: Mapping[str, Any]) -> Settings:
        """The overrides in `params`, `tables` and `places`; raises TrackmarshalError D202, D203, D204 or D240."""
        params: dict[str, float] = {}
        tables: dict[str, Any] = {}
        places: dict[str, Any] = {}
        for name, value in _given(data, "params").items():
            param: ParamInfo = _find(self._params, name, "parameter", params)
            params[param.name] = check_param(param, _number(value, f"params.{name}"))
        for name, rows in _given(data, "tables").items():
            table: TableInfo = _find(self._tables, name, "table", tables)
            tables[table.name] = check_table(table, rows)
        for name, points in _given(data, "places").items():
            place: PlaceInfo = _find(self._places, name, "place", places)
            places[place.name] = check_place(place, points)
        return Settings(params, tables, places)


def as_plain(data: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters and tables that a reader took, in the declared units, as JSON has them: whatever numbers they are of."""
    params = {name: _number(value, f"params.{name}") for name, value in data["params"].items()}
    tables = {
        name: [list(pair) for pair in _points(rows, f"tables.{name}")]
        for name, rows in data["tables"].items()
    }
    return {"params": params, "tables": tables}


def check_param(info: ParamInfo, value: float) -> float:
    """An override in the declared unit to SI; raises D204 when it is not finite or outside the declared range."""
    number = to_si(value, info.unit)
    short = info.short
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
    """Rows [x, y] in the declared units to knots and values in SI; raises D202, D204, or D240 for a table of two arguments."""
    short = info.name.rpartition(".")[2]
    if info.across is not None:
        help_ = "a configuration replaces it: a module with a table of this name"
        raise TrackmarshalError("D240", f"table `{short}` has two arguments", help=help_)
    pairs = [(to_si(x, info.units[0]), to_si(y, info.units[1])) for x, y in _points(rows, f"tables.{short}")]
    if not pairs or any(not (math.isfinite(x) and math.isfinite(y)) for x, y in pairs):
        raise TrackmarshalError(
            "D204", f"table `{short}` has no rows, or a value that is not finite", help=_ROWS
        )
    if any(not a[0] < b[0] for a, b in zip(pairs, pairs[1:])):
        raise TrackmarshalError("D204", f"the knots of table `{short}` do not ascend", help=_ROWS)
    if not in_period(info.way, [x for x, _ in pairs]):
        help_ = f"its knots lie from 0 up to the length of its period, see {info.span}"
        raise TrackmarshalError("D204", f"a knot of table `{short}` is outside its period", help=help_)
    return tuple(p[0] for p in pairs), tuple(p[1] for p in pairs)


def check_place(info: PlaceInfo, points: object) -> tuple[Point, ...]:
    """Points of a zone (three or more different ones) or a line (two or more), finite, and not rounded by short floats; raises D202 or D204.

    What they enclose, if anything, is for geometry to say: of what is no zone or no line, rules are undefined.
    """
    short = info.name.rpartition(".")[2]
    found = tuple(_points(points, f"places.{short}", placed=True))
    least = 3 if info.kind == "zone" else 2
    if len(set(found)) < least or not all(math.isfinite(x) and math.isfinite(y) for x, y in found):
        help_ = f"a {info.kind} is a list of at least {least} different points [x, y] in m"
        raise TrackmarshalError("D204", f"the points of `{short}` are too few, or not finite", help=help_)
    return found


def _given(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """The overrides of one kind; null and absent mean none."""
    from trackmarshal.runtime.door.values import worded

    value = data.get(key)
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        help_ = "write it as {...}; leave it out if there is none"
        raise TrackmarshalError("D202", f"`{key}` is an object, not {worded(value)}", help=help_)
    return value


def _by_short_name(infos: Mapping[str, Any]) -> dict[str, list[Any]]:
    """Declarations by qualified name, and by the last part of it."""
    result: dict[str, list[Any]] = {}
    for name, info in infos.items():
        result.setdefault(name, []).append(info)
        result.setdefault(short_name(info), []).append(info)
    return result


def _find(known: dict[str, list[Any]], name: str, what: str, given: Container[str]) -> Any:
    """What is meant by a name, of what is declared; raises D203, and D204 for what was given already, by its other name."""
    found = known.get(name, [])
    if not found:
        shorts = list(dict.fromkeys(short_name(info) for infos in known.values() for info in infos))
        listed = (
            f"it declares {', '.join(shorts[:12])}" + (", ..." if len(shorts) > 12 else "")
            if shorts
            else f"it has no {what}s"
        )
        raise TrackmarshalError(
            "D203", f"the spec declares no {what} `{name}`", help=close_matches(str(name), known) or listed
        )
    if len({info.name for info in found}) > 1:
        choices = " or ".join(f"`{info.name}`" for info in found)
        raise TrackmarshalError(
            "D203", f"{what} `{name}` is declared in several modules", help=f"write {choices}"
        )
    if found[0].name in given:
        message = f"{what} `{found[0].name}` is given twice, by its short name and by its whole one"
        raise TrackmarshalError("D204", message, help="leave one of them out")
    return found[0]


def _number(value: object, where: str) -> float:
    if type(value) is float:  # without numpy, as below
        return value
    from trackmarshal.runtime.door.values import number, worded

    found = number(value, spelt=True)
    if found is None:
        raise TrackmarshalError("D202", f"{where} is a number or null, not {worded(value)}", help=_MISSING)
    return found


def _points(raw: Any, what: str, placed: bool = False) -> list[Point]:
    """Pairs of numbers. placed: they are places, and refused as the door refuses a border whose coordinates short floats have rounded."""
    points = []
    for index, row in enumerate(_rows(raw, what)):
        pair = _rows(row, f"{what}[{index}]")
        if len(pair) != 2:
            entries = "1 entry" if len(pair) == 1 else f"{len(pair)} entries"
            raise TrackmarshalError("D202", f"{what}[{index}] has {entries}, not 2", help="a point is [x, y]")
        if placed and not {float, int}.issuperset(map(type, pair)):
            from trackmarshal.runtime.door.values import rounded

            if lost := rounded(pair):
                raise TrackmarshalError("D204", f"{what}[{index}]: {lost}", help="give it as float64")
        points.append((_number(pair[0], f"{what}[{index}]"), _number(pair[1], f"{what}[{index}]")))
    return points


def _rows(raw: Any, what: str) -> list[Any]:
    """The entries of a list, a tuple, or an array of numbers or objects."""
    if type(raw) is list:
        return raw.copy()  # what is read is what was checked, whoever writes to it meanwhile
    from trackmarshal.runtime.door import values  # with numpy, which whoever reads no data does without

    try:
        return values.listed(raw)
    except values.WrongTypeError:
        raise TrackmarshalError(
            "D202", f"{what} is a list, not {values.worded(raw)}", help="write it as [...]"
        ) from None
