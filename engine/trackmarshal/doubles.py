"""Numbers as doubles, which everything is worked out in."""

from __future__ import annotations

import math


def double(number: float) -> float:
    """The double next to a number; whole ones that are beyond them become infinite."""
    try:
        return float(number)
    except OverflowError:
        return math.inf if number > 0 else -math.inf
