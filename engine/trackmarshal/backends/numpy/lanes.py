"""Lanes that come with the cycle, on a batch: one lane and one body after the other, by the reference's steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.backends.reference import lanes
from trackmarshal.ir import nodes as ir


def on_lane(batch: Batch, node: ir.OnLane, lane: Any, *ends: Any) -> Any:
    """What `ir.OnLane` says of the lanes of every case: an array of the arguments' shape, with all cases along its first axis."""
    shape = np.broadcast(lane, *ends).shape
    shape = (batch.size, *(shape[1:] or (1,) * (batch.rank - 1)))
    made = np.full(shape, np.nan)
    whole = [np.broadcast_to(each, shape) for each in (lane, *ends)]
    for at in np.ndindex(shape):
        place, *numbers = (float(each[at]) for each in whole)
        made[at] = lanes.on_lane(node, batch.cases[at[0]], place, numbers)
    return made
