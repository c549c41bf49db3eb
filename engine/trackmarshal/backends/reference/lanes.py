"""Numbers of lanes that come with the cycle, one lane at a time. numpy takes these, too: lanes are few, and each is another one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import assert_never

from trackmarshal.backends.reference import geometry
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.lines import Point


def on_lane(node: ir.OnLane, frame: Frame, lane: float, ends: Sequence[float]) -> float:
    """What `ir.OnLane` says of a lane, by its place in its set, and numbers; NaN where there is no such lane, or none that can be used."""
    lanes = frame.lanes.get(node.signal, ())
    if math.isnan(lane) or not 0.0 <= lane < len(lanes):
        return math.nan
    left, right = (line.tuples for line in lanes[int(lane)])
    match node.what:
        case "inside" | "meets":
            x0, y0, heading0, x1, y1, heading1, length, width, *bend = ends
            margin = geometry.hull_inside_margin if node.what == "inside" else geometry.hull_meets_margin
            return margin(left, right, False, (x0, y0, heading0), (x1, y1, heading1), length, width, bend)
        case "station" | "offset" | "direction":
            x, y = ends
            found = geometry.project(x, y, _line(node.side, left, right))
            return found[("station", "offset", "direction").index(node.what)]
        case "distance":
            x, y = ends
            return geometry.distance_to_line(x, y, _line(node.side, left, right))
        case "gap":
            start, end = ends
            return geometry.station_gap(_line(node.side, left, right), start, end)
        case "room":
            station, start, end = ends
            return geometry.stretch_room(_line(node.side, left, right), station, start, end)
        case _:
            assert_never(node.what)


def _line(side: ir.LaneSide, left: Sequence[Point], right: Sequence[Point]) -> Sequence[Point]:
    match side:
        case "left":
            return left
        case "right":
            return right
        case "centre":
            return geometry.centre_line(left, right)
        case _:
            assert_never(side)
