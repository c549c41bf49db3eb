"""Dimensions, and the closed list of units (SI brochure, 9th edition; an angle is a ratio, rad = 1)."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from functools import lru_cache

from trackmarshal.doubles import double

#: Exponents of metre, second and kilogram. Whole ones are ints, which are quickly compared.
Dimension = tuple["int | Fraction", "int | Fraction", "int | Fraction"]

_F = Fraction
NUMBER: Dimension = (0, 0, 0)
LENGTH: Dimension = (1, 0, 0)
TIME: Dimension = (0, 1, 0)
MASS: Dimension = (0, 0, 1)


def times(a: Dimension, b: Dimension) -> Dimension:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def over(a: Dimension, b: Dimension) -> Dimension:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@lru_cache(maxsize=1024)
def power(a: Dimension, n: int | Fraction) -> Dimension:
    x, y, z = (exponent * n for exponent in a)
    return (_whole(x), _whole(y), _whole(z))


def _whole(number: int | Fraction) -> int | Fraction:
    """The same number, an int if it is one."""
    return number.numerator if number.denominator == 1 else number


SPEED = over(LENGTH, TIME)
ACCELERATION = over(SPEED, TIME)
FORCE = times(MASS, ACCELERATION)

#: pi/180 to 74 bits, as a ratio of whole numbers so small that the product with any number of up to 21 bits (every
#: multiple of a half up to a million) is exact: what people write in degrees is rounded once, by the quotient.
_DEGREE = _F(2339260349, 134029745180)

#: Name -> (exact factor to SI; dimension).
UNITS: dict[str, tuple[Fraction, Dimension]] = {
    "m": (_F(1), LENGTH), "km": (_F(1000), LENGTH), "cm": (_F(1, 100), LENGTH), "mm": (_F(1, 1000), LENGTH),
    "s": (_F(1), TIME), "ms": (_F(1, 1000), TIME), "us": (_F(1, 10**6), TIME), "min": (_F(60), TIME), "h": (_F(3600), TIME),
    "kg": (_F(1), MASS), "t": (_F(1000), MASS),
    "N": (_F(1), FORCE), "kN": (_F(1000), FORCE), "J": (_F(1), times(FORCE, LENGTH)),
    "W": (_F(1), times(FORCE, SPEED)), "kW": (_F(1000), times(FORCE, SPEED)),
    "Hz": (_F(1), over(NUMBER, TIME)),
    "rad": (_F(1), NUMBER), "deg": (_DEGREE, NUMBER), "%": (_F(1, 100), NUMBER),
}  # fmt: skip

#: The regular expression of one unit with its exponent, longest names first.
UNIT_PATTERN = "(?:" + "|".join(sorted(UNITS, key=len, reverse=True)) + r")(?:\^-?[0-9]{1,2}|[²³])?"

#: What reports call a dimension; anything else is spelled out from m, s and kg.
_NAMED = {FORCE: "N", times(FORCE, LENGTH): "J", times(FORCE, SPEED): "W", NUMBER: "1"}


@lru_cache(maxsize=1024)
def parse_unit(text: str) -> tuple[float, float, Dimension]:
    """A unit as written to (multiplier, divisor, dimension): see `to_si`.

    Multiplier and divisor are whole numbers without a common factor, 5 and 18 for km/h.
    Raises ValueError for anything that is not a unit of the list.
    """
    whole, dimension = _F(1), NUMBER
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
        whole *= factor ** (sign * exponent)
        dimension = times(dimension, power(dim, Fraction(sign * exponent)))
    return double(whole.numerator), double(whole.denominator), dimension


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


def is_si(unit: str) -> bool:
    """Whether a number in a unit is that of the SI as it stands: `m/s`, `N`, `rad`."""
    return parse_unit(unit)[:2] == (1.0, 1.0)


def to_si(number: float, unit: str) -> float:
    """A number in a unit to SI: `number * multiplier / divisor`, each rounded once.

    Every number that has a unit goes through this, in specs and in data, so that one number in one unit is one double
    wherever it stands. Arrays do the same two operations in the same order, and get the same bits:
    `array * multiplier / divisor` with the multiplier and the divisor of `parse_unit`.
    """
    multiplier, divisor, _ = parse_unit(unit)
    return number * multiplier / divisor


def from_si(number: float, unit: str) -> float:
    """An SI number in a unit, for people: where any double of the unit gives the number back by `to_si`, such a one.

    Some SI numbers are between the values of two neighbours in the unit; nothing that is computed with goes this way.
    """
    multiplier, divisor, _ = parse_unit(unit)
    near = number * divisor / multiplier
    if near * multiplier / divisor == number:  # mostly
        return near
    for candidate in (math.nextafter(near, math.inf), math.nextafter(near, -math.inf)):
        if candidate * multiplier / divisor == number:
            return candidate
    return near


def in_full(number: float, unit: str) -> str:
    """An SI number as an author would write it in a unit, `130 km/h`, with all of its digits."""
    return digits(number, unit) + ("" if unit == "1" else f" {unit}")


def about(full: str) -> str:
    """What `in_full` says, for sentences: of a number with more than six digits that matter six, with a sign that there are more: `≈ 1.32518`."""
    number, _, unit = full.partition(" ")
    value = float(number)
    short = f"{value:g}"
    if not math.isfinite(value) or float(short) == value or value.is_integer():
        return full
    return f"≈ {short} {unit}".rstrip()


def digits(number: float, unit: str) -> str:
    """An SI number in a unit, without it, and with all of its digits: numbers that differ look different."""
    value = from_si(number, unit)
    short = f"{value:g}"
    return short if math.isnan(value) or float(short) == value else repr(value)


def written(value: float, unit: str, shown: str = "", digits: int = 4) -> str:
    """An SI value as people read it: in the unit `shown` where there is one, else in `unit`, which is SI: -12.4 km/h."""
    number = (from_si(value, shown) if shown else value) + 0.0  # no minus before a zero
    text = f"{number:.{digits}g}"
    return text if (shown or unit) == "1" else f"{text} {shown or unit}"


def beside(value: float, unit: str, shown: str = "", digits: int = 4) -> str:
    """The same, with the SI value beside it where that is another number: -12.4 km/h (-3.444 m/s)."""
    text = written(value, unit, shown, digits)
    if not shown or not math.isfinite(value) or is_si(shown):
        return text
    return f"{text} ({written(value, unit, '', digits)})"


def moment(t: float) -> str:
    """The stamp of a cycle [s] as people read it: six digits, and milliseconds too of a clock that counts from far away, as that of Unix."""
    return f"{t:.6g}" if abs(t) < 1e5 else f"{t:.13g}"


@lru_cache(maxsize=1024)
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


def _factor(name: str, exponent: int | Fraction) -> str:
    if exponent == 1:
        return name
    return f"{name}^{exponent}" if exponent.denominator == 1 else f"{name}^({exponent})"


@lru_cache(maxsize=1024)
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
