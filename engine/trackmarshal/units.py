"""Dimensions, and the closed list of units (SI brochure, 9th edition; an angle is a ratio, rad = 1)."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from functools import lru_cache

#: Exponents of metre, second and kilogram.
Dimension = tuple[Fraction, Fraction, Fraction]

_F = Fraction
NUMBER: Dimension = (_F(0), _F(0), _F(0))
LENGTH: Dimension = (_F(1), _F(0), _F(0))
TIME: Dimension = (_F(0), _F(1), _F(0))
MASS: Dimension = (_F(0), _F(0), _F(1))


def times(a: Dimension, b: Dimension) -> Dimension:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def over(a: Dimension, b: Dimension) -> Dimension:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def power(a: Dimension, n: Fraction) -> Dimension:
    return (a[0] * n, a[1] * n, a[2] * n)


SPEED = over(LENGTH, TIME)
ACCELERATION = over(SPEED, TIME)
FORCE = times(MASS, ACCELERATION)

#: Name -> (factor to SI, as a decimal a person can check; dimension).
UNITS: dict[str, tuple[float, Dimension]] = {
    "m": (1.0, LENGTH), "km": (1000.0, LENGTH), "cm": (0.01, LENGTH), "mm": (0.001, LENGTH),
    "s": (1.0, TIME), "ms": (0.001, TIME), "us": (1e-6, TIME), "min": (60.0, TIME), "h": (3600.0, TIME),
    "kg": (1.0, MASS), "t": (1000.0, MASS),
    "N": (1.0, FORCE), "kN": (1000.0, FORCE), "J": (1.0, times(FORCE, LENGTH)),
    "W": (1.0, times(FORCE, SPEED)), "kW": (1000.0, times(FORCE, SPEED)),
    "Hz": (1.0, over(NUMBER, TIME)),
    "rad": (1.0, NUMBER), "deg": (math.pi / 180.0, NUMBER), "%": (0.01, NUMBER),
}  # fmt: skip

#: The regular expression of one unit with its exponent, longest names first.
UNIT_PATTERN = "(?:" + "|".join(sorted(UNITS, key=len, reverse=True)) + r")(?:\^-?[0-9]{1,2}|[²³])?"

#: What reports call a dimension; anything else is spelled out from m, s and kg.
_NAMED = {FORCE: "N", times(FORCE, LENGTH): "J", times(FORCE, SPEED): "W", NUMBER: "1"}


@lru_cache(maxsize=1024)
def parse_unit(text: str) -> tuple[float, float, Dimension]:
    """A unit as written to (multiplier, divisor, dimension): SI value = number * multiplier / divisor.

    Multiplier and divisor stay apart so that 60 km/h is 60 * 1000 / 3600, correctly rounded once each.
    Raises ValueError for anything that is not a unit of the list.
    """
    multiplier, divisor, dimension = 1.0, 1.0, NUMBER
    sign, name = 1, ""
    for part in _parts(text):
        if part in ("/", "*"):
            sign = -1 if part == "/" else 1
            continue
        name, exponent = _exponent(part)
        if name == "1":
            continue
        if name not in UNITS:
            raise ValueError(name)
        factor, dim = UNITS[name]
        exponent *= sign
        dimension = times(dimension, power(dim, Fraction(exponent)))
        for _ in range(abs(exponent)):
            if exponent > 0:
                multiplier, divisor = _scaled(multiplier, divisor, factor)
            else:
                divisor, multiplier = _scaled(divisor, multiplier, factor)
    return multiplier, divisor, dimension


def _scaled(up: float, down: float, factor: float) -> tuple[float, float]:
    """Multiply by a factor; one like 0.001 divides by its exact reciprocal instead."""
    inverse = round(1 / factor)
    if factor < 1 and 1 / inverse == factor:
        return up, down * inverse
    return up * factor, down


def _parts(text: str) -> list[str]:
    parts, current = [], ""
    for char in text.replace("·", "*"):
        if char in "/*":
            parts += [current, char]
            current = ""
        else:
            current += char
    return [*parts, current]


def _exponent(part: str) -> tuple[str, int]:
    if part.endswith("²"):
        return part[:-1], 2
    if part.endswith("³"):
        return part[:-1], 3
    name, _, exponent = part.partition("^")
    return name, int(exponent) if exponent else 1


def to_si(number: float, unit: str) -> float:
    """A number in a unit to SI."""
    multiplier, divisor, _ = parse_unit(unit)
    return number * multiplier / divisor


def from_si(number: float, unit: str) -> float:
    """An SI number in a unit."""
    multiplier, divisor, _ = parse_unit(unit)
    return number * divisor / multiplier


def written(value: float, unit: str, shown: str = "", digits: int = 4) -> str:
    """An SI value as people read it: in the unit `shown` where there is one, else in `unit`, which is SI: -12.4 km/h."""
    number = (from_si(value, shown) if shown else value) + 0.0  # no minus before a zero
    text = f"{number:.{digits}g}"
    return text if (shown or unit) == "1" else f"{text} {shown or unit}"


def beside(value: float, unit: str, shown: str = "", digits: int = 4) -> str:
    """The same, with the SI value beside it where that is another number: -12.4 km/h (-3.444 m/s)."""
    text = written(value, unit, shown, digits)
    if not shown or not math.isfinite(value) or parse_unit(shown)[:2] == (1.0, 1.0):
        return text
    return f"{text} ({written(value, unit, '', digits)})"


def show(dimension: Dimension) -> str:
    """The SI unit of a dimension, as a rule author would write it."""
    if dimension in _NAMED:
        return _NAMED[dimension]
    above = [
        _factor(n, e) for n, e in zip(("kg", "m", "s"), (dimension[2], dimension[0], dimension[1])) if e > 0
    ]
    below = [
        _factor(n, -e) for n, e in zip(("kg", "m", "s"), (dimension[2], dimension[0], dimension[1])) if e < 0
    ]
    return "/".join(["*".join(above) or "1", *below])


def _factor(name: str, exponent: Fraction) -> str:
    if exponent == 1:
        return name
    return f"{name}^{exponent}" if exponent.denominator == 1 else f"{name}^({exponent})"


def parse_shown(text: str) -> Dimension:
    """The dimension that `show` gave a text for; raises ValueError for any other text."""
    dimension, sign = NUMBER, 1
    for part in re.findall(r"[*/]|[^*/(]+(?:\([^)]*\))?", text):
        if part in "*/":
            sign = 1 if part == "*" else -1
            continue
        unit, _, exponent = part.partition("^")
        if unit != "1":
            if unit not in UNITS:
                raise ValueError(unit)
            dimension = times(dimension, power(UNITS[unit][1], sign * Fraction(exponent.strip("()") or 1)))
    return dimension


def name(dimension: Dimension) -> str:
    """What people call a dimension: a speed, a length."""
    return _SPOKEN.get(dimension, show(dimension))


def quantity(dimension: Dimension) -> str:
    """A dimension with its unit, as messages show it: a speed [m/s]."""
    spoken, unit = name(dimension), show(dimension)
    return spoken if dimension == NUMBER or spoken == unit else f"{spoken} [{unit}]"


_SPOKEN = {
    NUMBER: "a plain number", LENGTH: "a length", TIME: "a time", MASS: "a mass", SPEED: "a speed",
    ACCELERATION: "an acceleration", FORCE: "a force", over(NUMBER, LENGTH): "a curvature",
    over(NUMBER, TIME): "a frequency", times(LENGTH, LENGTH): "an area",
}  # fmt: skip
