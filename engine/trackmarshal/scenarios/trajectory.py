"""Trajectories of recordings that come without arc length and time (see `trackmarshal.trajectories`, where they are computed)."""

from __future__ import annotations

from trackmarshal.scenarios.recording import Columns
from trackmarshal.trajectories.along import REST_SPEED, REST_STEP, arc_length, time_along, wrap
from trackmarshal.trajectories.rest import cut, first_at_rest

__all__ = ["REST_SPEED", "REST_STEP", "arc_length", "complete", "first_at_rest", "time_along", "wrap"]


def complete(samples: Columns) -> tuple[Columns, int]:
    """Columns x, y, heading, kappa, v, a completed by t and s, and how many samples were dropped behind the first at rest.

    A recording is what was planned, so only what exactly stands still (REST_SPEED) is cut.
    """
    columns, dropped = cut(samples, REST_SPEED)
    s = arc_length(columns["x"], columns["y"])
    return {"t": time_along(s, columns["v"]), "s": s, **columns}, dropped
