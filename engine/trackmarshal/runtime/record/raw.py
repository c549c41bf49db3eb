"""Cycles that did not pass the door, of whatever was handed in, as strict JSON data and back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.door.lines import line
from trackmarshal.runtime.door.values import entries, is_a, is_masked, mapping
from trackmarshal.runtime.lines import Line

_CYCLE = ("number", "t", "driving", "emergency", "signals")


@dataclass(frozen=True, slots=True)
class Opaque:
    """Stands for something that JSON has no word for."""

    kind: str


def plain(value: Any, depth: int = 0) -> Any:
    """Anything as strict JSON data: what JSON does not have is {"$": kind, ...}. What the door takes comes back as what it takes alike."""
    kind = type(value)
    if value is None or kind in (bool, str):
        return value
    if isinstance(value, str):  # whatever is derived from it is taken as the text that it is
        return str.__str__(value)
    if is_a(value, int) and kind is not bool:
        whole = int.__pos__(value)
        return whole if abs(whole) < 2**63 else {"$": "int", "of": hex(whole)}
    if is_a(value, (float, np.floating)):
        number = float.__pos__(value) if is_a(value, float) else float(value)
        if not math.isfinite(number):
            return {"$": str(number)}
        # Of a length, a short one may have lost what a float of the same number has: the door asks.
        short = is_a(value, np.floating) and value.dtype.itemsize < 8
        return {"$": "scalar", "type": value.dtype.str, "of": number} if short else number
    if (
        isinstance(value, np.bool_ | np.integer) and value.dtype.kind in "biu"
    ):  # spans of time are whole numbers to numpy
        return {"$": "scalar", "type": value.dtype.str, "of": value.item()}
    if depth < 8:
        try:
            return _composed(value, depth + 1)
        except Exception:  # what was handed in has a say in how it is read
            pass
    return {"$": "opaque", "kind": kind.__name__}


def _composed(value: Any, depth: int) -> Any:
    """The same of what is made of others."""
    kind = type(value)
    if is_a(value, Cycle):
        given = [getattr(value, name, None) for name in _CYCLE] + [sorted(value.also)]
        return {"$": "cycle", "of": [plain(item, depth) for item in given]}
    if is_a(value, Mapping):
        held = mapping(value)
        pairs = [(key, plain(item, depth)) for key, item in held.items()]
        if all(type(key) is str for key in held) and "$" not in held:
            return dict(pairs)
        return {"$": "dict", "of": [(plain(key, depth), item) for key, item in pairs]}
    if kind is Line:
        return {"$": "line", "of": value.points.tolist()}
    if is_a(value, (list, tuple)):
        items = [plain(item, depth) for item in entries(value)]
        return items if is_a(value, list) else {"$": "tuple", "of": items}
    if is_masked(value):
        parts = [plain(part, depth) for part in (np.ma.getdata(value), np.ma.getmaskarray(value))]
        return {"$": "masked", "of": parts}
    if kind in (np.ndarray, np.memmap) and value.dtype.kind in "iufbU":
        wide = value.dtype.itemsize > 8 and value.dtype.kind != "U"
        array = value.astype(np.float64) if wide else value
        items = plain(array.ravel().tolist(), depth)
        return {"$": "array", "type": array.dtype.str, "shape": array.shape, "of": items}
    if kind is np.ndarray and value.dtype == object:
        items = [plain(item, depth) for item in value.ravel().tolist()]
        return {"$": "objects", "shape": value.shape, "of": items}
    return {"$": "opaque", "kind": kind.__name__}


def unplain(value: Any) -> Any:
    if type(value) is list:
        return [unplain(item) for item in value]
    if type(value) is not dict:
        return value
    kind = value.get("$")
    of: Any = value.get("of")
    match kind:
        case None:
            return {key: unplain(item) for key, item in value.items()}
        case "nan" | "inf" | "-inf":
            return float(kind)
        case "int":
            return int(of, 16)
        case "cycle":
            number, t, driving, emergency, signals = (unplain(item) for item in of[:-1])
            return Cycle(number, t, driving, emergency, signals, frozenset(of[-1]))
        case "dict":
            return {unplain(key): unplain(item) for key, item in of}
        case "line":
            return line(np.array(of, dtype=np.float64).reshape(-1, 2))
        case "tuple":
            return tuple(unplain(item) for item in of)
        case "array":
            return np.array(unplain(of), dtype=value["type"]).reshape(value["shape"])
        case "masked":
            data, mask = (unplain(part) for part in of)
            return np.ma.MaskedArray(data, mask)
        case "objects":
            held = np.empty(len(of), dtype=object)
            held[:] = [unplain(item) for item in of]
            return held.reshape(value["shape"])
        case "scalar":
            return np.dtype(value["type"]).type(of)
        case "opaque":
            return Opaque(value["kind"])
        case _:
            raise ValueError(f"unknown kind {kind!r:.40}")
