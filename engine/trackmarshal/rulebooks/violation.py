"""How much a rule is violated: what rulebooks compare."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

KEPT, VIOLATED, UNDEFINED = 0, 1, 2
#: The first number of a violation, by verdict.
GRADES = {"satisfied": KEPT, "inactive": KEPT, "open": KEPT, "violated": VIOLATED, "undefined": UNDEFINED}


class Violation(NamedTuple):
    """A pair that is compared in order; more is worse.

    grade: 0 satisfied, inactive or open, 1 violated, 2 undefined. size: by how much, in SI units of the margin, at least 0; 0 where the grade is 0,
    inf where nobody knows.
    """

    grade: int
    size: float


NONE = Violation(KEPT, 0.0)
#: Whatever is not known counts as much as anything can.
UNKNOWN = Violation(UNDEFINED, math.inf)


def violation(verdict: str, margin: float) -> Violation:
    """The violation of a rule, from its verdict and its margin in SI. Raises ValueError for a verdict that is none.

    A margin that is no number is none that could be small: of what is undefined, or violated by nobody knows how much, the size is inf.
    """
    if verdict not in GRADES:
        raise ValueError(f"there is no verdict `{verdict!s:.40}`")
    grade = GRADES[verdict]
    if grade == KEPT:
        return NONE
    if grade == UNDEFINED or math.isnan(margin):
        return Violation(grade, math.inf)
    return Violation(grade, -margin if margin < 0.0 else 0.0)


def worst(violations: Iterable[Violation]) -> Violation:
    """The worst of the cycles of a run. Raises ValueError where there are none: of nothing, nothing is known."""
    return max(violations)
