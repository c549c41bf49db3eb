"""Numbers of many: sums, least and greatest ones, and which one is the nearest; of a whole batch at once."""

from __future__ import annotations

from typing import Any, assert_never

import numpy as np

from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.ir import nodes as ir


def ordinal(batch: Batch, axis: ir.Axis) -> Any:
    """Which value of an axis each of its entries is."""
    table = np.arange(batch.count(axis), dtype=np.float64)
    return batch.on_axis(np.broadcast_to(table, (batch.size, len(table))), axis)


def fold(batch: Batch, node: ir.Fold, body: Any, otherwise: Any, surely: Any, maybe: Any) -> Any:
    """One number of the values of `body` along an axis that are in range; `surely` and `maybe`: whether the guard holds in the worst and
    in the best case, None where it is said of no guard, or where both are the same. Arrays broadcast against each other.
    """
    place, mask = 1 + node.axis.level, batch.mask(node.axis)
    if mask is None and surely is None and body.ndim and body.shape[place] == batch.count(node.axis):
        match node.op:
            case "sum":
                return _sum(body, place)
            case "least" | "greatest":  # 0.0 for both zeros
                extreme = np.minimum if node.op == "least" else np.maximum
                return extreme.reduce(body, axis=place, keepdims=True) + 0.0
            case "nearest":
                pass
            case _:
                assert_never(node.op)
    guard = surely if maybe is None else maybe
    if mask is None and guard is not None and guard.ndim and guard.shape[place] == batch.count(node.axis):
        inside = guard
    else:
        shape = [batch.size] + [1] * (batch.rank - 1)
        shape[place] = batch.count(node.axis)
        there: Any = np.ones(shape, dtype=np.bool_) if mask is None else mask
        inside = there if guard is None else there & guard
    unknown = None if maybe is None else inside & ~surely
    match node.op:
        case "sum":
            return _sum(_known(np.where(inside, body, 0.0), unknown), place)
        case "least":
            least = _known(np.where(inside, body, np.inf), unknown)
            found = np.minimum.reduce(least, axis=place, keepdims=True, initial=np.inf)
            return _of_some(found, inside, otherwise, place)
        case "greatest":
            greatest = _known(np.where(inside, body, -np.inf), unknown)
            found = np.maximum.reduce(greatest, axis=place, keepdims=True, initial=-np.inf)
            return _of_some(found, inside, otherwise, place)
        case "nearest":
            wrong = inside & ~np.isfinite(body)
            return _nearest(
                np.where(inside, body, np.inf), inside, wrong if unknown is None else wrong | unknown, place
            )
        case _:
            assert_never(node.op)


def _known(values: Any, unknown: Any) -> Any:
    return values if unknown is None else np.where(unknown, np.nan, values)


def _sum(values: Any, place: int) -> Any:
    """The sum in the order of the axis: `accumulate` adds one after the other, where `reduce` adds in pairs."""
    if values.shape[place] == 0:
        return np.zeros([1 if i == place else n for i, n in enumerate(values.shape)])
    last = [slice(None)] * values.ndim
    last[place] = slice(-1, None)
    return (
        np.add.accumulate(values, axis=place)[tuple(last)] + 0.0
    )  # begins with 0.0, so that it is never -0.0


def _of_some(found: Any, inside: Any, otherwise: Any, place: int) -> Any:
    """What was found, 0.0 for both zeros, where there was anything."""
    some = np.logical_or.reduce(inside, axis=place, keepdims=True)
    return np.where(some, found + 0.0, np.nan if otherwise is None else otherwise)


def _nearest(keys: Any, inside: Any, wrong: Any, place: int) -> Any:
    some = np.logical_or.reduce(inside, axis=place, keepdims=True)
    if keys.shape[place] == 0:
        return np.full(some.shape, -1.0)
    first = np.argmin(keys, axis=place, keepdims=True).astype(np.float64)
    bad = np.logical_or.reduce(wrong, axis=place, keepdims=True)
    return np.where(bad, np.nan, np.where(some, first, -1.0))
