"""Units that are not in the closed list, and what to write for them."""

from __future__ import annotations

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.units import UNITS

_PLAIN = "the unit of a plain number is 1"
_NO_TEXT = "words are the members of an `enum`"
_NO_ELECTRICITY = "there is no unit of electricity: the unit of a plain number is 1"
_NO_TEMPERATURE = "there is no unit of temperature: the unit of a plain number is 1"
#: Units that authors reach for, and what to write.
_FOREIGN = {
    "mph": "1 mph = 1.609344 km/h", "kph": "write `km/h`", "kmh": "write `km/h`", "kmph": "write `km/h`", "mps": "write `m/s`",
    "sec": "write `s`", "secs": "write `s`", "second": "write `s`", "seconds": "write `s`", "hr": "write `h`", "hrs": "write `h`",
    "hour": "write `h`", "hours": "write `h`", "minute": "write `min`", "minutes": "write `min`", "meter": "write `m`",
    "meters": "write `m`", "metre": "write `m`", "metres": "write `m`", "ft": "1 ft = 0.3048 m", "yd": "1 yd = 0.9144 m",
    "mi": "1 mi = 1.609344 km", "mile": "1 mile = 1.609344 km", "miles": "1 mile = 1.609344 km", "inch": "1 inch = 2.54 cm",
    "kn": "the kilonewton is `kN`, one knot 1.852 km/h", "kt": "1 kt = 1.852 km/h", "knot": "1 knot = 1.852 km/h", "knots": "1 knot = 1.852 km/h",
    "NM": "1 NM = 1.852 km", "nmi": "1 nmi = 1.852 km", "g": "1000 g = 1 kg; standard gravity is 9.80665 m/s^2",
    "lb": "1 lb = 0.45359237 kg", "lbs": "1 lb = 0.45359237 kg", "degree": "write `deg`", "degrees": "write `deg`",
    "radian": "write `rad`", "radians": "write `rad`", "percent": "write `%`", "hz": "write `Hz`", "nm": "the newton metre is `N*m`, or `J`; one nautical mile 1.852 km",
    "Nm": "write `N*m`, or `J`", "ton": "write `t`", "tons": "write `t`", "hp": "1 hp = 0.7457 kW", "S": "write `s`",
    "M": "write `m`", "Wh": "1 Wh = 3600 J", "kWh": "1 kWh = 3600000 J", "MWh": "1 MWh = 3600000000 J", "rpm": "60 rpm = 1 Hz",
    "Pa": "1 Pa = 1 N/m^2", "kPa": "1 kPa = 1 kN/m^2", "bar": "1 bar = 100 kN/m^2", "psi": "1 psi = 6.894757 kN/m^2", "l": "1 l = 0.001 m^3",
    "V": _NO_ELECTRICITY, "mV": _NO_ELECTRICITY, "A": _NO_ELECTRICITY, "mA": _NO_ELECTRICITY, "Ah": _NO_ELECTRICITY, "mAh": _NO_ELECTRICITY,
    "dB": _PLAIN, "dBm": _PLAIN, "L": "1 L = 0.001 m^3", "K": _NO_TEMPERATURE, "C": _NO_TEMPERATURE, "degC": _NO_TEMPERATURE, "float": _PLAIN, "double": _PLAIN,
    "int": _PLAIN, "integer": _PLAIN, "number": _PLAIN, "boolean": "write `bool`", "string": _NO_TEXT, "str": _NO_TEXT, "text": _NO_TEXT,
}  # fmt: skip
#: A prefix before a unit that is known without it, or with another one: what is closest to `MJ` is a million times less.
_PREFIXES = {"n": "0.000000001", "m": "0.001", "d": "0.1", "k": "1000", "M": "1000000", "G": "1000000000"}


def _prefixed(name: str) -> str:
    base = name[1:]
    if name[:1] not in _PREFIXES or base not in ("m", "s", "N", "J", "W", "Hz", "rad"):
        return ""
    return f"1 {name} = {_PREFIXES[name[0]]} {base}"


def unit_hint(name: str, whole: str, kinds: str) -> str:
    """What to write for an unknown unit in a whole one; `kinds` are the words that could stand there too."""
    if not kinds and name in ("bool", "boolean"):
        return "this is a number: what is true or false is a `bool` field of a signal, or an `event`"
    known = [unit for unit in UNITS if unit.lower() == name.lower()]
    foreign = _FOREIGN.get(name) or ("" if known else _prefixed(name))
    hint = foreign or (f"write `{known[0]}`" if known else close_matches(name, UNITS))
    if not hint or (kinds and not foreign and not known):
        hint = f"the units are {', '.join(UNITS)}" + (f"; the kinds are {kinds}" if kinds else "")
    if (
        "/" in whole
        and name != whole.split("/", maxsplit=1)[0]
        and not known
        and (not foreign or len(name) == 1)
    ):
        hint += f"{'' if hint.endswith('?') else '.'} To divide by a quantity called `{name}`, put blanks around `/`"
    return hint
