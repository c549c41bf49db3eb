"""Temporal operators on a batch: each case by itself along its own times, worst and best case."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, assert_never

import numpy as np

from trackmarshal.backends.numpy import temporal
from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.backends.numpy.logic import NEITHER, Side, Value
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.runtime.timeline import measured

#: Whether a formula holds, and its margin.
Pair = tuple[Any, Any]


def operator(batch: Batch, node: ir.Timed, operands: Sequence[Value]) -> Value:
    """The value of a temporal formula at every sample of every case."""
    operands = without_gaps(batch, node.axis, operands)
    single = all(value.worst is value.best for value in operands)
    timed = isinstance(node, (ir.Temporal, ir.Until))
    # Where the structure of a signal is broken, its times have not been looked at; a rule that reads it has no verdict then.
    blocked = [timed and case.unusable([(node.axis.signal, "")]) is not None for case in batch.cases]
    worst = _side(batch, node, [value.worst for value in operands], blocked, False)
    if single and not any(blocked):
        return Value(worst, worst)
    return Value(worst, _side(batch, node, [value.best for value in operands], blocked, True))


def _side(batch: Batch, node: ir.Timed, sides: list[Side], blocked: list[bool], best: bool) -> Side:
    axis = 1 + node.axis.level
    size = batch.count(node.axis)
    lengths = batch.lengths(node.axis.signal)
    shape = np.broadcast_shapes(*(s.sat.shape for s in sides), (batch.size,) + (1,) * (batch.rank - 1))
    shape = (*shape[:axis], size, *shape[axis + 1 :])
    inputs = [_last(side, shape, axis) for side in sides]
    rows: list[Pair] = []
    for index in range(batch.size):
        n = int(lengths[index])
        if blocked[index]:  # its times mean nothing: undefined
            unknown = inputs[0][1][index]
            rows.append((np.full(unknown.shape, best), np.full(unknown.shape, np.inf if best else -np.inf)))
            continue
        cut = [(sat[index, ..., :n], margin[index, ..., :n]) for sat, margin in inputs]
        rows.append(_kernel(batch, node, index, cut))
    if batch.size == 1:
        sat, margin = rows[0][0][None], rows[0][1][None]
    else:
        whole = inputs[0][1].shape
        sat, margin = np.zeros(whole, dtype=bool), np.zeros(whole)
        for index, (row_sat, row_margin) in enumerate(rows):
            sat[index, ..., : row_sat.shape[-1]] = row_sat
            margin[index, ..., : row_margin.shape[-1]] = row_margin
    return Side(np.moveaxis(margin, -1, axis), NEITHER, np.moveaxis(sat, -1, axis))


def _last(side: Side, shape: tuple[int, ...], axis: int) -> Pair:
    """A side in full shape with its time axis last."""
    return (
        np.moveaxis(np.broadcast_to(side.sat, shape), axis, -1),
        np.moveaxis(np.broadcast_to(side.margin, shape), axis, -1),
    )


def _kernel(batch: Batch, node: ir.Timed, index: int, sides: list[Pair]) -> Pair:
    match node:
        case ir.Temporal():
            windows = _windows(batch, node, index)
            kernel = temporal.always if node.extreme is Extreme.LEAST else temporal.eventually
            return kernel(*sides[0], windows)
        case ir.Until():
            windows = _windows(batch, node, index)
            held = temporal.since if node.past else temporal.until
            return held(*sides[0], *sides[1], windows)
        case ir.Shift():
            return temporal.shift(*sides[0], node.step, node.weak)
        case _:
            assert_never(node)


def without_gaps(batch: Batch, axis: ir.Axis, operands: Sequence[Value]) -> list[Value]:
    """The operands with nothing known of them in gaps of a timeline."""
    gaps = batch.gaps(axis)
    if gaps is None:
        return list(operands)
    return [
        Value(
            Side(np.where(gaps, -np.inf, worst.margin), NEITHER, np.where(gaps, False, worst.sat)),
            Side(np.where(gaps, np.inf, best.margin), NEITHER, np.where(gaps, True, best.sat)),
        )
        for worst, best in operands
    ]


def _windows(batch: Batch, node: ir.Temporal | ir.Until, index: int) -> temporal.Windows:
    begins, ends, lower, upper = measured(batch.own(node.axis.signal)[index], node.lower, node.upper)
    return temporal.windows(begins, lower, upper, node.past, ends)
