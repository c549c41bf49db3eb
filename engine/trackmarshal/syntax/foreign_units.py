"""Units that are not in the closed list, and what to write for them."""

from __future__ import annotations

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.units import UNITS

#: Units that authors reach for, and what to write.
_FOREIGN = {
    "mph": "1 mph = 1.609344 km/h", "kph": "write `km/h`", "kmh": "write `km/h`", "kmph": "write `km/h`", "mps": "write `m/s`",
    "sec": "write `s`", "secs": "write `s`", "second": "write `s`", "seconds": "write `s`", "hr": "write `h`", "hrs": "write `h`",
    "hour": "write `h`", "hours": "write `h`", "minute": "write `min`", "minutes": "write `min`", "meter": "write `m`",
    "meters": "write `m`", "metre": "write `m`", "metres": "write `m`", "ft": "1 ft = 0.3048 m", "yd": "1 yd = 0.9144 m",
    "mi": "1 mi = 1.609344 km", "mile": "1 mile = 1.609344 km", "miles": "1 mile = 1.609344 km", "inch": "1 inch = 2.54 cm",
    "kn": "the kilonewton is `kN`, one knot 0.514444 m/s", "g": "1000 g = 1 kg; standard gravity is 9.80665 m/s^2",
    "lb": "1 lb = 0.45359237 kg", "lbs": "1 lb = 0.45359237 kg", "degree": "write `deg`", "degrees": "write `deg`",
    "radian": "write `rad`", "radians": "write `rad`", "percent": "write `%`", "hz": "write `Hz`", "nm": "write `N*m`, or `J`",
    "Nm": "write `N*m`, or `J`", "ton": "write `t`", "tons": "write `t`", "hp": "1 hp = 0.7457 kW", "S": "write `s`",
    "M": "write `m`",
}  # fmt: skip


def unit_hint(name: str, whole: str, kinds: str) -> str:
    """What to write for an unknown unit in a whole one; `kinds` are the words that could stand there too."""
    known = [unit for unit in UNITS if unit.lower() == name.lower()]
    hint = _FOREIGN.get(name) or (f"write `{known[0]}`" if known else close_matches(name, UNITS))
    if not hint or (kinds and name not in _FOREIGN and not known):
        hint = f"the units are {', '.join(UNITS)}" + (f"; the kinds are {kinds}" if kinds else "")
    if "/" in whole and name != whole.split("/", maxsplit=1)[0] and name not in _FOREIGN and not known:
        hint += f"{'' if hint.endswith('?') else '.'} To divide by a quantity called `{name}`, put blanks around `/`"
    return hint
