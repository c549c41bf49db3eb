"""Connectives on values between worst and best case: strong Kleene logic with margins, one definition for scalars."""

from __future__ import annotations

import math
from typing import assert_never

from trackmarshal.ir.operators import ConnectiveOp
from trackmarshal.runtime.verdict import Bound, Truth

INF = math.inf
HOLDS = Bound(True, INF)
FAILS = Bound(False, -INF)
TRUE = Truth(HOLDS, HOLDS)
FALSE = Truth(FAILS, FAILS)
UNDEFINED = Truth(FAILS, HOLDS)


def known(sat: bool, margin: float) -> Truth:
    """A formula without anything undefined in it."""
    bound = Bound(sat, margin)
    return Truth(bound, bound)


def least(a: Bound, b: Bound) -> Bound:
    low, sat = b if b.margin < a.margin else a, a.sat and b.sat
    return low if low.sat == sat else Bound(sat, low.margin)


def greatest(a: Bound, b: Bound) -> Bound:
    high, sat = b if b.margin > a.margin else a, a.sat or b.sat
    return high if high.sat == sat else Bound(sat, high.margin)


def negate(a: Truth) -> Truth:
    return Truth(Bound(not a.best.sat, -a.best.margin), Bound(not a.worst.sat, -a.worst.margin))


def scaled(a: Truth, scale: float) -> Truth:
    """The same formula with margins divided by a scale above 0."""
    return Truth(Bound(a.worst.sat, a.worst.margin / scale), Bound(a.best.sat, a.best.margin / scale))


def connect(op: ConnectiveOp, a: Truth, b: Truth) -> Truth:
    """Two formulas joined."""
    match op:
        case "and":
            return Truth(least(a.worst, b.worst), least(a.best, b.best))
        case "or":
            return Truth(greatest(a.worst, b.worst), greatest(a.best, b.best))
        case "xor":
            return _differ(a, b)
        case "iff":
            return negate(_differ(a, b))
        case _:
            assert_never(op)


def _differ(a: Truth, b: Truth) -> Truth:
    """Exactly one holds; the margin is the distance of the two margins, whatever the undefined parts are."""
    surely = (a.worst.sat and not b.best.sat) or (b.worst.sat and not a.best.sat)
    surely_not = (a.worst.sat and b.worst.sat) or not (a.best.sat or b.best.sat)
    apart = max(0.0, _difference(a.worst.margin, b.best.margin), _difference(b.worst.margin, a.best.margin))
    at_most = max(_difference(a.best.margin, b.worst.margin), _difference(b.best.margin, a.worst.margin))
    return Truth(Bound(surely, apart), Bound(not surely_not, at_most))


def _difference(x: float, y: float) -> float:
    """x - y, where equal infinities do not differ."""
    return 0.0 if x == y else x - y
