"""Who keeps to its line beside the middle of the road, and where it may be from now on: does a candidate lead into it?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import shapely

from support.dense import curve, rss, traffic
from support.dense.car import Car
from support.dense.recording import Columns, Cycle
from support.dense.sweep import corners

#: Instants that are looked at, s, and places of a line, m.
EVERY, APART = 0.05, 1.0


def meets(
    lane: traffic.Lane, cycle: Cycle, columns: Columns, gaps: Sequence[traffic.Gaps], car: Car, r: rss.Response, slack: float
) -> bool:  # fmt: skip
    """Whether a candidate, driven from now on, touches somebody who keeps to a line of its own, or moves over by half of the room that is left between
    both, anywhere between where it is if it brakes at once and where it is if it speeds up until it has reacted; slack in m.

    Who is behind answers for what happens; who stands, comes the other way, or is in the car's own line now is looked at elsewhere.
    """
    if curve.chords(columns).max() <= curve.SAME:
        return False
    due = columns["t"] - traffic.at_car(cycle, columns)
    times = np.arange(0.0, due[-1], EVERY)
    x, y, heading = (
        np.interp(times, due, column)
        for column in (columns["x"], columns["y"], np.unwrap(columns["heading"]))
    )
    own = shapely.polygons(corners(x, y, heading, car.length + slack / 50, car.width + slack / 50))
    for body, gap in zip(cycle.objects, gaps, strict=True):
        elsewhere = gap.oncoming or abs(body["v"]) <= 0.5 or gap.across <= gap.needed_across - slack / 50
        if elsewhere or (gap.behind and gap.along >= -slack):
            continue
        least, most = between(body["v"], times, r)
        # Rules turn bodies against straight pieces of the middle, by up to 0.15 rad: as much as 0.4 m on either side.
        wider = {**body, "width": body["width"] + max(0.0, gap.across - r.sway + slack / 3)}
        there = [line(lane, wider, a - slack, b + slack) for a, b in zip(least, most, strict=True)]
        if shapely.intersects(own, there).any():
            return True
    return False


def between(v: float, t: Any, r: rss.Response) -> tuple[Any, Any]:
    """How far on somebody is at least, and at most, after some time; m."""
    brakes = np.minimum(t, v / r.brake)
    responds = np.minimum(t, r.time)
    return v * brakes - r.brake * brakes**2 / 2, (v + r.accelerate * responds) * t


def line(lane: traffic.Lane, body: Mapping[str, Any], begin: float, end: float) -> shapely.Polygon:
    """What a body covers that goes anywhere between two ways along the road, as far beside its middle as it is now."""
    station, offset, _ = lane.place(body)
    half = body["length"] / 2
    begin, end = begin - half, max(end, begin) + half
    s = station + np.linspace(begin, end, max(2, int((end - begin) / APART) + 1))
    ahead = shapely.get_coordinates(lane.line.interpolate(np.remainder(s + APART / 2, lane.line.length)))
    behind = shapely.get_coordinates(lane.line.interpolate(np.remainder(s - APART / 2, lane.line.length)))
    along = ahead - behind
    along /= np.hypot(*along.T)[:, None]
    points = (ahead + behind) / 2 + offset * np.stack([-along[:, 1], along[:, 0]], axis=1)
    return shapely.LineString(points).buffer(body["width"] / 2, cap_style="flat")
