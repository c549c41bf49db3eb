"""Lanes that come with the cycle, on a batch: what all bodies and points of a case ask of one lane, at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, assert_never

import numpy as np

from trackmarshal.backends.numpy import places, touching
from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime import geometry
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.lines import Line


def on_lane(batch: Batch, node: ir.OnLane, lane: Any, *ends: Any) -> Any:
    """What `ir.OnLane` says of the lanes of every case: an array of the arguments' shape, with all cases along its first axis."""
    shape = np.broadcast(lane, *ends).shape
    shape = (batch.size, *(shape[1:] or (1,) * (batch.rank - 1)))
    made = np.full(shape, np.nan)
    which, *whole = (np.broadcast_to(each, shape) for each in (lane, *ends))
    for index, case in enumerate(batch.cases):
        own = slice(index, index + 1)
        for number, borders in enumerate(case.lanes.get(node.signal, ())):
            asked = which[own] == number
            if asked.any():
                made[own][asked] = _of_one(batch, node, borders, [each[own][asked] for each in whole])
    return made


def _of_one(batch: Batch, node: ir.OnLane, borders: tuple[Line, Line], args: Sequence[Any]) -> Any:
    """The same of one lane: (n,) of arguments (n,)."""
    match node.what:
        case "inside":
            road = places.lane(batch, *borders)
            border = road.border
            if border is None:
                return math.nan
            return _settled(border, road.margin_inside(*args), args)
        case "meets":
            road = places.lane(batch, *borders)
            border = road.border
            if border is None:
                return math.nan
            return [touching.meets(border, row) for row in zip(*(each.tolist() for each in args))]
        case "station" | "offset" | "direction":
            found = _line(batch, node.side, borders).project(*args)
            return found[("station", "offset", "direction").index(node.what)]
        case "distance":
            return _line(batch, node.side, borders).distance(*args)
        case "gap":
            return _line(batch, node.side, borders).gap(*args)
        case "room":
            return _line(batch, node.side, borders).stretch_room(*args)
        case _:
            assert_never(node.what)


def _settled(border: Border, margin: Any, args: Sequence[Any]) -> Any:
    """Margins inside a lane, those next to zero by the reference's steps."""
    return touching.settled(margin, args, lambda at, row: touching.inside(border, row))


def _line(batch: Batch, side: ir.LaneSide, borders: tuple[Line, Line]) -> geometry.Polyline:
    match side:
        case "left" | "right":
            return places.polyline(batch, borders[0 if side == "left" else 1])
        case "centre":
            return places.lane(batch, *borders).centre
        case _:
            assert_never(side)
