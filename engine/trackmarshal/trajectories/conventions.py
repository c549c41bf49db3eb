"""Headings of other conventions."""

from __future__ import annotations

import math

from trackmarshal.doubles import double
from trackmarshal.errors import TrackmarshalError
from trackmarshal.trajectories.along import wrap

#: Where a heading of 0 points to -> rad from +x, counter-clockwise. East, north, west and south with x to the east and y to the north.
ZEROS = {
    "+x": 0.0, "+y": math.pi / 2, "-x": math.pi, "-y": -math.pi / 2,
    "east": 0.0, "north": math.pi / 2, "west": math.pi, "south": -math.pi / 2,
}  # fmt: skip


def converted(heading: list[float], zero: str | float, clockwise: bool, degrees: bool) -> list[float]:
    """Headings in rad from +x, counter-clockwise, in (-pi, pi]. `zero` is where 0 points to: a name of ZEROS, or rad from +x.

    Raises D193 for another one.
    """
    if isinstance(zero, str):
        if zero not in ZEROS:
            raise TrackmarshalError(
                "D193", f"a heading of 0 points to `{zero:.40}`?", help=f"known are {', '.join(ZEROS)}"
            )
        begin = ZEROS[zero]
    elif isinstance(zero, int | float) and not isinstance(zero, bool) and math.isfinite(double(zero)):
        begin = float(zero)
    else:
        raise TrackmarshalError("D193", f"a heading of 0 points to {zero!r:.40}?", help="give rad from +x")
    unit = math.pi / 180.0 if degrees else 1.0
    sign = -1.0 if clockwise else 1.0
    return [wrap(begin + sign * unit * value) for value in heading]
