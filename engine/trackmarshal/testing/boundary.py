"""Tests on the boundary of their rule: they expect a margin of about 0, and fail as soon as the rule's limits move by a stated distance.

A test that takes any margin within a kilometre for none shows nothing, and neither does one whose margin is 0 for another reason than a
limit. So the limits are moved, both ways, and the test is run again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.margins import SCALED, margin_units, own_unit
from trackmarshal.ir.spec import Spec
from trackmarshal.testing.cases import PreparedTest
from trackmarshal.units import in_full, parse_unit, show, to_si

#: How far limits are moved where a project says nothing else, in SI units.
DISTANCE = 0.01
#: A tolerance about 0 is small where it is at most this share of the distance.
SHARE = 0.1

CODES = {
    "T347": (
        "a distance that is none",
        "`boundary_distance` says by how much a rule's limits are moved to see that its boundary tests fail: a number above 0 with its unit, such "
        "as `1 cm`, one for each dimension.",
    ),
}


class Near(NamedTuple):
    """How near to the boundary a test stands: `within` which margin about 0, and the `distance` that limits are moved by, as people read them.

    narrow: whether the first is small against the second. Both texts are empty for a test that does not expect a margin of about 0.
    """

    narrow: bool = False
    distance: str = ""
    within: str = ""


class Distances:
    """By how much limits are moved, by the SI unit of what they limit."""

    def __init__(self, given: Mapping[str, tuple[str, int]] | None = None) -> None:
        """given: texts such as `1 cm`, each with the file and the line where it stands; raises T347."""
        self._of: dict[str, float] = {}
        for text, (file, line) in (given or {}).items():
            number, _, unit = text.partition(" ")
            try:
                value, key = to_si(float(number), unit or "1"), show(parse_unit(unit or "1")[2])
            except ValueError:
                raise _bad(text, "is no number with a unit", file, line) from None
            if not 0.0 < value < math.inf:
                raise _bad(text, "is not above 0", file, line)
            if key in self._of:
                raise _bad(text, "is the second one of its dimension", file, line)
            self._of[key] = value

    def of(self, unit: str) -> float:
        """The distance in a unit of margins, in SI."""
        return self._of.get(unit, DISTANCE)


def near(test: PreparedTest, spec: Spec, distances: Distances) -> Near:
    """How near to the boundary of its rule a test stands, by what it expects."""
    if test.margin != 0.0 or test.verdict not in ("satisfied", "violated") or test.rule.formula is None:
        return Near()
    units = (
        {test.unit}
        if test.unit is not None
        else {test.rule.unit}
        if own_unit(test.rule.unit)
        else margin_units(test.rule.formula)
    )
    scales: Mapping[str, float] = dict(spec.scales) if test.rule.unit == SCALED else {}
    least = min((distances.of(unit) / scales.get(unit, 1.0) for unit in units), default=distances.of("1"))
    shown = ", ".join(in_full(distances.of(unit), unit) for unit in sorted(units))
    unit = next(iter(units)) if len(units) == 1 else "1"
    within = in_full(test.tolerance * scales.get(unit, 1.0), unit)
    return Near(test.tolerance <= SHARE * least, shown, within)


def _bad(text: str, why: str, file: str, line: int) -> TrackmarshalError:
    help_ = "such as `1 cm`, `0.1 m/s`, `1 N`"
    return TrackmarshalError("T347", f"the distance `{text}` {why}", file=file, line=line, help=help_)
