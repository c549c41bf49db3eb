"""Counts of samples of a timeline on a batch: sums up to each sample, less those up to where its count starts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, assert_never

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy import temporal
from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.backends.numpy.logic import NEITHER, Side, Value
from trackmarshal.backends.numpy.time import without_gaps
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import COMPARISONS, Measure
from trackmarshal.runtime.timeline import measured

Ints = NDArray[np.int64]


def tally(batch: Batch, node: ir.Tallied, operands: Sequence[Value], limit: Any) -> Value:
    """The value of a comparison of a count with a number at every sample of every case."""
    axis, size = 1 + node.axis.level, batch.count(node.axis)
    known = without_gaps(batch, node.axis, operands)
    shapes = [side.sat.shape for value in known for side in value]
    shape = np.broadcast_shapes(*shapes, (batch.size,) + (1,) * (batch.rank - 1))
    shape = (*shape[:axis], size, *shape[axis + 1 :])

    def last(array: Any) -> Any:
        return np.moveaxis(np.broadcast_to(array, shape), axis, -1)

    counted, *resets = known
    weights = batch.on_axis(_weights(batch, node.axis), node.axis)
    if resets:
        starts = _after(last(resets[0].best.sat)), _after(last(resets[0].worst.sat))
    else:
        begin = _starts(batch, node).reshape(batch.size, *(1,) * (len(shape) - 2), size)
        starts = begin, begin
    sure = _between(last(counted.worst.sat).astype(np.int64), starts[0])
    possible = _between(last(counted.best.sat * weights).astype(np.int64), starts[1])
    return compared(node, np.moveaxis(sure, -1, axis), np.moveaxis(possible, -1, axis), limit)


def _weights(batch: Batch, axis: ir.Axis) -> Ints:
    """(cases, n): how many samples each may be."""
    found = np.ones((batch.size, batch.count(axis)), dtype=np.int64)
    for row, columns in zip(found, batch.own(axis.signal)):
        if columns.joined is not None:
            row[list(columns.joined.gaps)] = columns.joined.missing
    return found


def _starts(batch: Batch, node: ir.Tallied) -> Ints:
    """(cases, n): the first sample that counts at each."""
    found = np.zeros((batch.size, batch.count(node.axis)), dtype=np.int64)
    if node.upper is None:
        return found
    for row, columns, case in zip(found, batch.own(node.axis.signal), batch.cases):
        # Where the structure of a signal is broken, its times have not been looked at; a rule that reads it has no verdict then.
        if case.unusable([(node.axis.signal, "")]) is None:
            begins, ends, _, upper = measured(columns, None, node.upper)
            row[: columns.count] = temporal.windows(begins, None, upper, True, ends).start
    return found


def _after(anew: NDArray[np.bool_]) -> Ints:
    """(.., n): the last sample, up to each, with which a count starts anew; the first where there is none."""
    places = np.where(anew, np.arange(anew.shape[-1]), 0)
    found: Ints = np.maximum.accumulate(places, axis=-1)
    return found


def _between(each: Ints, start: Ints) -> Ints:
    """(.., n): the sum up to each sample, that one included, from where it starts."""
    sums = np.zeros((*each.shape[:-1], each.shape[-1] + 1), dtype=np.int64)
    np.cumsum(each, axis=-1, out=sums[..., 1:])
    before = np.take_along_axis(sums, np.broadcast_to(start, each.shape), axis=-1)
    found: Ints = sums[..., 1:] - before
    return found


def compared(node: ir.Tallied | ir.Counted, count: Ints, most: Ints, limit: Any) -> Value:
    """Counts, surely and possibly, compared with numbers, of samples and of cycles: as `backends.over_run.counts` does it."""
    measure, at_zero = COMPARISONS[node.op]
    sure, possible = count.astype(np.float64), most.astype(np.float64)
    known = np.isfinite(limit)
    limit = np.where(known, limit, 0.0)
    nearest = np.minimum(np.maximum(np.rint(limit), sure), possible)
    farthest = np.maximum(np.abs(sure - limit), np.abs(possible - limit))
    match measure:
        case Measure.ROOM:
            ends = (sure - limit, possible - limit) if node.turned else (limit - possible, limit - sure)
        case Measure.NEARNESS:
            ends = -farthest, -np.abs(nearest - limit)
        case Measure.DISTANCE:
            ends = np.abs(nearest - limit), farthest
        case Measure.SAMENESS:
            raise AssertionError("a count is no member of an enumeration")
        case _:
            assert_never(measure)
    worst, best = (np.where(known, end + 0.0, blank) for end, blank in zip(ends, (-np.inf, np.inf)))
    sides = [Side(end, NEITHER, (end > 0.0) | (at_zero & (end == 0.0))) for end in (worst, best)]
    return Value(*sides)
