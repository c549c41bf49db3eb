"""The structure of a recording's lines, checked by hand: what recording.schema.json says, without a library.

Every message begins with the path of the field in the line.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import Any

from trackmarshal.json_text import BadJson, kind, number
from trackmarshal.scenarios.fields import ELSEWHERE, OWN, suggestion
from trackmarshal.scenarios.inputs import not_to_be_given
from trackmarshal.scenarios.labels import label
from trackmarshal.scenarios.recording import CANDIDATES, COLUMNS, TRUTHS, Columns, Cycle, Track
from trackmarshal.scenarios.trajectory import arc_length

_SPELT = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}
_HEADER = (
    "format",
    "version",
    "name",
    "track",
    "params",
    "tables",
    "obstacles",
    "use",
    "notes",
    "extra",
    "signals",
    "judged",
    "given",
    "because",
)
_CYCLE = ("t", "ego", "objects", "candidates", "ground_truth", "signals", "obstacles")
_NEEDED = _CYCLE[:4]


class Wrong(ValueError):
    """A field that is not what it should be; the message names it."""


def header(value: dict[str, Any]) -> dict[str, Any]:
    """Arguments of Recording but for cycles, ground truth and source. Raises Wrong."""
    _keys(value, "header", needed=("name", "track"), known=_HEADER)
    params = _mapping(value.get("params", {}), "params")
    tables = _mapping(value.get("tables", {}), "tables")
    given = _given(value.get("given", {}))
    return {
        "name": _text(value["name"], "name"),
        "track": _track(value["track"]),
        "params": {name: _finite(item, f"params.{name}") for name, item in params.items()},
        "tables": {name: _table(item, f"tables.{name}") for name, item in tables.items()},
        "obstacles": _objects(value.get("obstacles", []), "obstacles"),
        "use": tuple(_text(item, "use") for item in _list(value.get("use", []), "use")),
        "notes": tuple(_text(item, "notes") for item in _list(value.get("notes", []), "notes")),
        "extra": _extra(value.get("extra", {})),
        "always": _signals(value.get("signals", {})),
        "judged": _judged(value.get("judged", {})),
        "given": given,
        "because": _because(value.get("because", {}), given, {*params, *tables}),
    }


def _given(value: Any) -> dict[str, float]:
    given = _mapping(value, "given")
    for problem in filter(None, map(not_to_be_given, given)):
        raise Wrong(f"given: {problem}")
    return {name: _finite(item, f"given.{name}") for name, item in given.items()}


def _because(value: Any, given: Iterable[str], overridden: Iterable[str]) -> dict[str, str]:
    """The reasons; what is given in place of an input has one."""
    because = _mapping(value, "because")
    _keys(because, "because", needed=given, known=(*given, *overridden))
    for name, item in because.items():
        if not _text(item, f"because.{name}").strip():
            raise Wrong(f"because.{name}: the reason is empty")
    return dict(because)


def _judged(value: Any) -> dict[str, str]:
    judged = _mapping(value, "judged")
    for name, item in judged.items():
        if _text(item, f"judged.{name}") not in TRUTHS:
            raise Wrong(f"judged.{name}: {item!r:.40} is not known; known are {', '.join(TRUTHS)}")
    return judged


def _extra(value: Any) -> dict[str, tuple[str, ...]]:
    extra = _mapping(value, "extra")
    _keys(extra, "extra", needed=(), known=OWN)
    return {
        name: tuple(_text(item, f"extra.{name}") for item in _list(names, f"extra.{name}"))
        for name, names in extra.items()
    }


def cycle(value: dict[str, Any]) -> tuple[Cycle, dict[str, bool | None]]:
    """A cycle and its ground truth. Raises Wrong."""
    _keys(value, "cycle", needed=_NEEDED, known=_CYCLE)
    ego = _mapping(value["ego"], "ego")
    objects = _objects(value["objects"], "objects")
    candidates = _mapping(value["candidates"], "candidates")
    _keys(candidates, "candidates", needed=(), known=CANDIDATES)
    if not candidates:
        raise Wrong("candidates: there is none")
    result = Cycle(
        _finite(value["t"], "t"),
        {name: _value(item, name, OWN["ego"], f"ego.{name}") for name, item in ego.items()},
        objects,
        {name: _columns(item, f"candidates.{name}") for name, item in candidates.items()},
        _signals(value.get("signals", {})),
        _objects(value["obstacles"], "obstacles") if "obstacles" in value else None,
    )
    truth = _mapping(value.get("ground_truth", {}), "ground_truth")
    _keys(truth, "ground_truth", needed=(), known=(*TRUTHS, *(name for name in truth if label(name))))
    for name, item in truth.items():
        if item is not None and not isinstance(item, bool):
            raise Wrong(f"ground_truth.{name}: {kind(item)} is not true, false or null")
    return result, truth


def _signals(value: Any) -> dict[str, Any]:
    """Signals besides those of the format: whether they are what a spec declares, its door says."""
    signals = _mapping(value, "signals")
    for name in signals:
        if name in ELSEWHERE:
            raise Wrong(f"signals: `{name}` has its own place: {ELSEWHERE[name]}")
    return {name: plain(item, f"signals.{name}") for name, item in signals.items()}


def plain(value: Any, where: str) -> Any:
    """Any value, with numbers as they are meant. Raises Wrong."""
    if isinstance(value, dict):
        return {name: plain(item, f"{where}.{name}") for name, item in value.items()}
    if isinstance(value, list):
        return [plain(item, f"{where}[{place}]") for place, item in enumerate(value)]
    if isinstance(value, bool) or (isinstance(value, str) and value not in _SPELT):
        return value
    return _number(value, where)


def _keys(value: dict[str, Any], where: str, needed: Iterable[str], known: Iterable[str]) -> None:
    missing = [name for name in needed if name not in value]
    if missing:
        raise Wrong(f"{where}: `{missing[0]}` is missing")
    unknown = [name for name in value if name not in known]
    if unknown:
        hint = suggestion(unknown[0], known)
        raise Wrong(f"{where}: {unknown[0]!r:.40} is not known; {hint or 'known are ' + ', '.join(known)}")


def _mapping(value: Any, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise Wrong(f"{where}: {kind(value)} stands where an object is expected")
    return value


def _list(value: Any, where: str) -> list[Any]:
    if not isinstance(value, list):
        raise Wrong(f"{where}: {kind(value)} stands where a list is expected")
    return value


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise Wrong(f"{where}: {kind(value)} stands where a text is expected")
    return value


def _number(value: Any, where: str) -> float:
    """A number, null (NaN), or one of the texts for numbers that are not finite."""
    if type(value) is float and math.isfinite(value):
        return value
    if value is None:
        return math.nan
    if isinstance(value, str) and value in _SPELT:
        return _SPELT[value]
    try:
        result = number(value)
    except BadJson as error:
        raise Wrong(f"{where}: {error}") from error
    if not math.isfinite(result):
        raise Wrong(f'{where}: the number is beyond the range of IEEE double (infinity is "inf")')
    return result


def _finite(value: Any, where: str) -> float:
    result = _number(value, where)
    if not math.isfinite(result):
        raise Wrong(f"{where}: has to be finite")
    return result


def _objects(value: Any, where: str) -> list[dict[str, Any]]:
    objects = [_object(item, f"{where}[{i}]") for i, item in enumerate(_list(value, where))]
    if len({item["id"] for item in objects}) != len(objects):
        raise Wrong(f"{where}: an id stands twice")
    return objects


def _object(value: Any, where: str) -> dict[str, Any]:
    fields = _mapping(value, where)
    _text(fields.get("id"), f"{where}.id")
    return {
        name: item
        if name == "id" or isinstance(item, bool)
        else _value(item, name, OWN["objects"], f"{where}.{name}")
        for name, item in fields.items()
    }


def _columns(value: Any, where: str) -> Columns:
    """Equally long lists of numbers; `s` is computed where it is missing, further columns are kept."""
    fields = _mapping(value, where)
    _keys(fields, where, needed=[name for name in COLUMNS if name != "s"], known=fields)
    columns = {name: _column(column, name, f"{where}.{name}") for name, column in fields.items()}
    lengths = {len(column) for column in columns.values()}
    if len(lengths) != 1 or 0 in lengths:
        counts = ", ".join(f"{name} {len(column)}" for name, column in columns.items())
        raise Wrong(f"{where}: columns have to be equally long, one sample at least ({counts})")
    if "s" not in columns:
        columns["s"] = arc_length(columns["x"], columns["y"])
    return columns


def _value(value: Any, name: str, own: Iterable[str], where: str) -> Any:
    """A number; of a field that the format does not have itself, also a Boolean or a text, such as a member of an enumeration."""
    further = name not in own and (
        isinstance(value, bool) or (isinstance(value, str) and value not in _SPELT)
    )
    return value if further else _number(value, where)


def _column(value: Any, name: str, where: str) -> list[Any]:
    column = _list(value, where)
    # Nearly always: a sum is finite only if all numbers are.
    if {float}.issuperset(map(type, column)) and math.isfinite(sum(column)):
        return column
    return [_value(item, name, COLUMNS, f"{where}[{i}]") for i, item in enumerate(column)]


def _table(value: Any, where: str) -> list[list[float]]:
    rows = [_pair(item, f"{where}[{i}]") for i, item in enumerate(_list(value, where))]
    if not rows or any(b[0] <= a[0] for a, b in pairwise(rows)):
        raise Wrong(f"{where}: needs rows with strictly increasing first numbers")
    return rows


def _pair(value: Any, where: str) -> list[float]:
    pair = [_finite(item, where) for item in _list(value, where)]
    if len(pair) != 2:
        raise Wrong(f"{where}: {len(pair)} numbers, not two")
    return pair


def _track(value: Any) -> Track:
    track = _mapping(value, "track")
    _keys(track, "track", needed=("left", "right"), known=("left", "right", "closed", "name"))
    closed = track.get("closed", False)
    if not isinstance(closed, bool):
        raise Wrong(f"track.closed: {kind(closed)} is not true or false")
    sides = {}
    for side in ("left", "right"):
        where = f"track.{side}"
        points = _list(track[side], where)
        sides[side] = [_pair(point, f"{where}[{i}]") for i, point in enumerate(points)]
        if len(sides[side]) < 2:
            raise Wrong(f"{where}: needs two or more points")
    named = {"name": _text(track["name"], "track.name")} if "name" in track else {}
    return {**sides, "closed": closed, **named}
