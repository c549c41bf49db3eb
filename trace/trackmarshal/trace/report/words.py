"""Numbers, times and places as people read them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from trackmarshal.trace.report.reading import number


def quantity(value: float, unit: str, digits: int = 4) -> str:
    """A number with its unit; digits that matter only, a real minus, words for what is not finite."""
    if math.isnan(value):
        return "undefined"
    if math.isinf(value):
        return "+∞" if value > 0 else "−∞"
    text = plain(value, digits)
    return text if unit in ("1", "") else f"{text} {spoken_unit(unit)}"


def plain(value: float, digits: int = 4) -> str:
    """A finite number with some significant digits, not in powers of ten as long as it is short without."""
    if value == 0:
        return "0"
    text = f"{value:.{digits}g}"
    if "e" in text:
        if 1e-4 <= abs(value) < 1e7:
            text = f"{value:.0f}" if abs(value) >= 1 else f"{value:.{digits + 3}f}"
        else:
            mantissa, exponent = text.split("e")
            text = f"{mantissa}·10{str(int(exponent)).translate(_RAISED)}"
    return text.replace("-", "−")


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def spoken_unit(unit: str) -> str:
    return unit.replace("^2", "²").replace("^3", "³").replace("*", "·")


def clock(t: float) -> str:
    """A time in s, to the millisecond."""
    return f"{round(t, 3):.9g}".replace("-", "−")


def interval(first: float, last: float) -> str:
    """From the first to the last cycle of a stretch."""
    return clock(first) if first == last else f"{clock(first)} to {clock(last)}"


def count(amount: int, one: str, many: str | None = None) -> str:
    return f"{amount} {one if amount == 1 else many or one + 's'}"


def listed(words: Sequence[str]) -> str:
    """a; a and b; a, b and c."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}" if words else ""


def decided_by(moment: Mapping[str, Any]) -> str:
    """Which sample or object decided, in words; empty where nothing in particular did."""
    parts = []
    for binder in moment["where"]:
        place = [
            f"{name} = {quantity(number(binder[name]), unit)}"
            for name, unit in (("x", "m"), ("y", "m"))
            if binder[name] is not None
        ]
        if isinstance(binder["value"], int):
            what = f"sample {binder['value']}" + (f" of {binder['signal']}" if binder["signal"] else "")
            if binder["t"] is not None:
                place.insert(0, f"t = {clock(number(binder['t']))} s")
        else:
            what = f"{binder['value']}" + (f" in {binder['signal']}" if binder["signal"] else "")
        parts.append(f"{binder['name']}: {what}" + (f" ({', '.join(place)})" if place else ""))
    if moment["reason"] and moment["reason"] != "nothing in its range":
        parts.append(moment["reason"])
    return "; ".join(parts)
