"""Numbers, times and places as people read them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from trackmarshal.trace.report.reading import number
from trackmarshal.units import from_si, is_si


def quantity(value: float, unit: str, digits: int = 4) -> str:
    """A number with its unit; digits that matter only, a real minus, words for what is not finite."""
    if math.isnan(value):
        return "undefined"
    if math.isinf(value):
        return "+∞" if value > 0 else "−∞"
    text = plain(value, digits)
    return text if unit in ("1", "") else f"{text} {spoken_unit(unit)}"


def measured(moment: Mapping[str, Any], beside: bool = True) -> str:
    """A margin of a record in the unit in which its limit is written, with SI beside it where that is another number."""
    margin, unit, shown = number(moment["margin"]), moment["unit"], moment.get("shown", "")
    if not shown or not math.isfinite(margin):
        return quantity(margin, unit)
    text = quantity(from_si(margin, shown), shown)
    return f"{text} ({quantity(margin, unit)})" if beside and not is_si(shown) else text


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


#: What stands for a unit where a rule has margins of several dimensions: numbers in SI, or of scales.
_SEVERAL = {"mixed": "SI", "scaled": "scales"}


def spoken_unit(unit: str) -> str:
    return _SEVERAL.get(unit) or _raised(unit)


def _raised(text: str) -> str:
    return text.replace("^2", "²").replace("^3", "³").replace("*", "·")


def told(line: str) -> tuple[str, str]:
    """A line that `trackmarshal explain` prints as what it is of and how much that is, "" where it is no number."""
    name, _, value = line.strip().partition(" = ") if line.startswith("    ") else (line.strip(), "", "")
    return name, _raised(value)


def clock(t: float) -> str:
    """A time in s, to the millisecond, also of a clock that counts from far away, as that of Unix."""
    return f"{round(t, 3) + 0.0:.13g}".replace("-", "−")


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
    parts = [_spoken(group) for group in _neighbours(moment["where"])]
    if moment["reason"] and moment["reason"] != "nothing in its range":
        parts.append(moment["reason"])
    return "; ".join(parts)


def _neighbours(binders: Sequence[Mapping[str, Any]]) -> list[list[Mapping[str, Any]]]:
    """Binders in groups: consecutive samples of one signal belong together."""
    groups: list[list[Mapping[str, Any]]] = []
    for binder in binders:
        last = groups[-1][-1] if groups else None
        follows = (
            last is not None
            and isinstance(binder["value"], int)
            and last["signal"] == binder["signal"] != ""
            and last["value"] == binder["value"] - 1
        )
        if follows:
            groups[-1].append(binder)
        else:
            groups.append([binder])
    return groups


def _spoken(group: Sequence[Mapping[str, Any]]) -> str:
    first, last = group[0], group[-1]
    of = f" of {first['signal']}" if first["signal"] else ""
    place = [] if first["t"] is None else [f"t = {interval(number(first['t']), number(last['t']))} s"]
    place += [
        f"{axis} = {quantity(number(first[axis]), 'm')}" for axis in ("x", "y") if first[axis] is not None
    ]
    if len(group) > 1:
        what = f"samples {first['value']} to {last['value']}{of}"
    elif isinstance(first["value"], int):
        what = f"sample {first['value']}{of}"
    else:
        what = f"{first['value']}" + (f" in {first['signal']}" if first["signal"] else "")
    return f"{', '.join(binder['name'] for binder in group)}: {what}" + (
        f" ({', '.join(place)})" if place else ""
    )
