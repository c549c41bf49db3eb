"""What is demanded of a cycle as a whole: that it follows the one before, comes in time, and has candidates that fit together.

Each demand is a row: what its breach is called, the field that it is about, and the condition. In a chain, the first row that does
not hold is the breach, and the rows behind it are not looked at.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

from trackmarshal.ir.overrun import FURTHEST
from trackmarshal.node import Node
from trackmarshal.runtime.contract.checks import MOST
from trackmarshal.runtime.contract.conditions import Condition


class Demand(Node):
    """A row: `fault` at `field` where `holds` does not hold."""

    fault: str
    field: str
    holds: Condition

    @cached_property
    def ready(self) -> tuple[tuple[str, ...], Callable[..., Any]]:
        """The names that its condition speaks of, and the function of them in that order: asked several times in every cycle."""
        names = tuple(sorted(self.holds.names))
        return names, self.holds.function(*names)


def _demand(fault: str, field: str, holds: str) -> Demand:
    return Demand(fault, field, Condition(holds))


#: Of the stamp `t` [s]; `begun`: 1 once a stamp was in order, else 0; `since`: the time from that one, else 0; `now`: the clock at the
#: arrival, NaN where it is wrong. A chain. A stamp is in order where all hold; only then it is remembered, and the number with it.
STAMP = (
    _demand("not_finite", "t", f"(t >= -{MOST!r}) & (t <= {MOST!r})"),
    _demand("repeated", "t", "(begun == 0) | (fabs(since) > shortest_gap)"),
    _demand("out_of_order", "t", "(begun == 0) | (since > 0.0)"),
    # Where the clock is wrong, only a stamp that follows soon is known to be none of the future: one that is kept refuses all that come before it.
    _demand(
        "early",
        "t",
        "((t - now) <= clock_tolerance) | ((now != now) & (begun == 1) & (since <= longest_gap))",
    ),
)
#: Of a stamp that is in order; each by itself.
TIMELY = (
    _demand("late", "t", "(begun == 0) | (since <= longest_gap)"),
    _demand("stale", "t", "((now - t) <= oldest) | (now != now)"),
)
#: Of a stamp that is in order, where rules look at other cycles, which they count with in nanoseconds (`ir.overrun.stamped`: a number as large as this
#: has no fraction to round): those that can be counted, and come to another nanosecond than the one before, whichever way both are rounded.
COUNTED = (
    _demand("out_of_range", "t", f"fabs(t * 1e9) < {float(FURTHEST)!r}"),
    _demand(
        "repeated",
        "t",
        f"(begun == 0) | (fabs(t * 1e9) >= {float(FURTHEST)!r}) | (((t * 1e9) - ((t - since) * 1e9)) > 1.0)",
    ),
)
#: Of the cycle's `number` and the `last` one that came with a stamp in order (`begun` 1 once there is one, else `last` is 0), whole
#: numbers of 64 bits. A chain, whatever the stamp is.
NUMBER = (
    _demand("repeated", "number", "(begun == 0) | (number != last)"),
    _demand("out_of_order", "number", "(begun == 0) | (number > last)"),
    _demand("skipped", "number", "(begun == 0) | ((number - 1) <= last)"),
)
#: Of the first samples of both candidates: `dx`, `dy` [m], `turn` [rad] and `faster` [m/s], driving minus emergency; each by itself.
START = (
    _demand(
        "starts_elsewhere", "x", "(sqrt((dx * dx) + (dy * dy)) <= start_distance) | (fabs(dx) < fabs(dy))"
    ),
    _demand(
        "starts_elsewhere", "y", "(sqrt((dx * dx) + (dy * dy)) <= start_distance) | (fabs(dx) >= fabs(dy))"
    ),
    _demand("starts_elsewhere", "heading", f"fabs(remainder(turn, {6.283185307179586!r})) <= start_turn"),
    _demand("starts_elsewhere", "v", "fabs(faster) <= start_speed"),
)
#: Of the speed at the end of the emergency trajectory, `last` [m/s].
END = (_demand("not_at_rest", "v", "fabs(last) <= rest_speed"),)
#: Of a stored trajectory that may be driven now: `end`, when its last sample is due; where the car was seen (`posed` 1), how far from
#: its path (`away` [m]), how much turned (`turn` [rad]) and, where its speed is known (`paced` 1), how fast it was and is to be there (`speed`, `planned` [m/s]);
#: `confirmed`, when it was last seen on the trajectory. A chain.
STORED = (
    _demand("expired", "", "(now <= end) | (now != now)"),
    _demand(
        "apart",
        "",
        f"(posed == 0) | ((away <= beside) & (fabs(remainder(turn, {6.283185307179586!r})) <= turned))",
    ),
    # Speeds are negative backwards: faster is further from rest than planned, or any way against the direction that is planned.
    _demand(
        "too_fast",
        "",
        "(posed == 0) | (paced == 0) | ((fabs(speed) <= overspeed) & (planned == planned))"
        " | ((speed > 0) & ((speed - planned) <= overspeed)) | ((speed < 0) & ((planned - speed) <= overspeed))",
    ),
    _demand("unconfirmed", "", "(now - confirmed) <= blind"),
)
