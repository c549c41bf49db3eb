"""Where cases lie among a demand's inputs: at every sample and element that it is asked of, the values of its inputs and what it comes to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackmarshal import typed
from trackmarshal.backends.numpy.logic import Value, parts
from trackmarshal.backends.numpy.program import NumpyProgram, Run
from trackmarshal.ir import nodes as ir
from trackmarshal.reading.drawing.demand import BROKEN, HOLDS, UNKNOWN, Codes, Demand, Floats, outcome
from trackmarshal.runtime.frame import Frame

#: Frames that are looked at together: of pairs of samples, each has thousands of places.
_CHUNK = 50


class Points(NamedTuple):
    """n places. values: (inputs, n) in SI; codes, margins, frames: (n,): what the demand comes to, its margin, and of which frame it is.

    lost: how many places are left out, as an input is missing there, or nobody knows whether the rule asks anything.
    """

    values: Floats
    codes: Codes
    margins: Floats
    frames: NDArray[np.intp]
    lost: int

    def decisive(self) -> int | None:
        """The place that decides: of those where it is broken, or else of all, the one with the least margin; None where that is not known."""
        chosen = np.flatnonzero(self.codes == BROKEN)
        if not len(chosen) and not self.lost and (self.codes == HOLDS).all():
            chosen = np.arange(len(self.codes))
        return int(chosen[np.argmin(self.margins[chosen])]) if len(chosen) else None


def together(found: Sequence[Points]) -> Points:
    """All places of several; which frame one is of, only each by itself says."""
    return Points(
        np.concatenate([one.values for one in found], axis=1),
        np.concatenate([one.codes for one in found]),
        np.concatenate([one.margins for one in found]),
        np.concatenate([one.frames for one in found]),
        sum(one.lost for one in found),
    )


class Places:
    """Looks at cases of the spec of a demand."""

    def __init__(self, demand: Demand) -> None:
        self._demand = demand
        make, rule = demand.lowering.make, demand.rule
        zero = make(ir.Const, 0.0)
        #: A number as the margin of `0 <= number`.
        self._numbers = [
            make(ir.Compare, "<=", zero, one.node, one.unit, rule.span, "", False) for one in demand.quantities
        ]  # fmt: skip
        self._ranges = [level.range(demand.lowering) for level in demand.levels]
        for place, level in enumerate(demand.levels):
            if level.by is not None:
                assert isinstance(level.clause, typed.ForEach)
                self._ranges[place] = demand.lowering.nearest(
                    level.clause.range, self._ranges[place], level.by, level.clause.span
                )
        leaves = [*self._numbers, demand.body, *(one for one in self._ranges if one is not None)]
        # A clause of which nothing is asked has an axis, too.
        rank = max([1, *(level.axis.level + 2 for level in demand.levels if level.axis is not None)])
        self._program = NumpyProgram(demand.spec, [], leaves, rank)

    def of(self, frames: Sequence[Frame]) -> Points:
        """The places of frames as one candidate or case sees them."""
        found = [self._chunk(frames, start) for start in range(0, len(frames), _CHUNK)]
        if not found:
            return self._none(0)
        return together(found)

    def _none(self, lost: int) -> Points:
        empty = np.zeros(0)
        return Points(np.zeros((len(self._numbers), 0)), empty.astype(np.uint8), empty, empty.astype(np.intp), lost)  # fmt: skip

    def _chunk(self, frames: Sequence[Frame], start: int) -> Points:
        reads = self._demand.rule.reads
        usable = [
            k for k in range(start, min(start + _CHUNK, len(frames))) if frames[k].unusable(reads) is None
        ]
        lost = min(_CHUNK, len(frames) - start) - len(usable)
        if not usable:
            return self._none(lost)
        run = self._program.run([frames[k] for k in usable])
        arrays = _Arrays(run, self._demand.body, self._numbers)
        for level, range_ in zip(self._demand.levels, self._ranges):
            arrays.enter(level.axis, None if range_ is None else run.of(range_))
        exists = False
        inner: list[tuple[Any, bool, bool]] = []
        for level in self._demand.levels:
            if level.axis is not None:
                some = isinstance(level.clause, typed.ForEach) and level.clause.quantifier == "exists"
                inner.append((level, some, exists))
                exists = exists or some
        for level, some, inside in reversed(inner):
            if isinstance(level.clause, typed.Along):
                arrays.at(level.axis, run.batch.places(level.axis.signal, level.clause.place))
            elif some or inside:  # of an `exists` the one that counts; below one, the one that is against it
                arrays.one(level.axis, some)
        return arrays.points(np.array(usable, dtype=np.intp), lost)


class _Arrays:
    """The values of a run over all axes of a demand: (frames, first axis, second axis, ...)."""

    def __init__(self, run: Run, body: ir.Formula, numbers: Sequence[ir.Formula]) -> None:
        self._batch = run.batch
        self._body = [np.asarray(one) for one in _sides(run.of(body))]
        # Where a number is none, its comparison is neither here nor there.
        values = [run.of(one) for one in numbers]
        self._numbers = [np.where(one.worst.margin == one.best.margin, one.worst.margin, np.nan) for one in values]  # fmt: skip
        self._surely: Any = np.ones((1,) * run.batch.rank, dtype=bool)
        self._possibly: Any = self._surely

    def enter(self, axis: ir.Axis | None, range_: Value | None) -> None:
        """Under one more clause."""
        if range_ is not None:
            self._surely = self._surely & range_.worst.sat
            self._possibly = self._possibly & range_.best.sat
        if axis is not None:
            size = [1] * self._batch.rank
            size[1 + axis.level] = self._batch.count(axis)
            there = np.ones(size, dtype=bool)
            mask = self._batch.mask(axis)
            there = there if mask is None else there & mask
            self._surely, self._possibly = self._surely & there, self._possibly & there

    def at(self, axis: ir.Axis, places: NDArray[np.intp]) -> None:
        """One sample of each frame."""
        self._take(axis, places.reshape(-1, *(1,) * (self._batch.rank - 1)))

    def one(self, axis: ir.Axis, best: bool) -> None:
        """Of all along an axis the one that decides: where one of them is to meet the demand the best one, else the one that is most against it.

        One that decides outranks one of which nobody knows whether it does, and that one all others.
        """
        self._spread()
        along = 1 + axis.level
        if not self._surely.shape[along]:
            return  # there is none: nothing is asked of any
        codes, margins = outcome(*self._body)
        decides = codes == (HOLDS if best else BROKEN)
        doubtful = (
            self._possibly & ((codes == UNKNOWN) | ~self._surely) & (codes != (BROKEN if best else HOLDS))
        )
        rank = np.where(self._surely & decides, 3, np.where(doubtful, 2, np.where(self._surely, 1, 0)))
        first = rank == rank.max(axis=along, keepdims=True)
        score = np.where(first & ~np.isnan(margins), margins if best else -margins, -np.inf)
        chosen = np.where(first, score, -np.inf).argmax(axis=along)
        # Of nothing but what is unknown, the first one.
        unknown = ~np.isfinite(score.max(axis=along))
        chosen = np.where(unknown, first.argmax(axis=along), chosen)
        self._take(axis, np.expand_dims(chosen, along))

    def _spread(self) -> None:
        arrays = [*self._body, *self._numbers, self._surely, self._possibly]
        ones = (1,) * (self._batch.rank - 1)
        shape = np.broadcast_shapes((self._batch.size, *ones), *(one.shape for one in arrays))
        self._body = [np.broadcast_to(one, shape) for one in self._body]
        self._numbers = [np.broadcast_to(one, shape) for one in self._numbers]
        self._surely, self._possibly = np.broadcast_to(self._surely, shape), np.broadcast_to(self._possibly, shape)  # fmt: skip

    def _take(self, axis: ir.Axis, places: NDArray[np.intp]) -> None:
        self._spread()
        shape = list(self._surely.shape)
        shape[1 + axis.level] = 1
        index = np.broadcast_to(places, shape)

        def taken(one: Any) -> Any:
            return np.take_along_axis(one, index, axis=1 + axis.level)

        self._body = [taken(one) for one in self._body]
        self._numbers = [taken(one) for one in self._numbers]
        self._surely, self._possibly = taken(self._surely), taken(self._possibly)

    def points(self, usable: NDArray[np.intp], lost: int) -> Points:
        """All that is surely asked, and of which every input is known."""
        self._spread()
        codes, margins = outcome(*self._body)
        known = np.all([np.isfinite(one) for one in self._numbers], axis=0)
        # What is met is met, whether or not it is asked.
        kept = (self._surely | (self._possibly & (codes == HOLDS))) & known
        lost += int((self._possibly & ~kept).sum())
        frames = np.broadcast_to(usable.reshape(-1, *(1,) * (codes.ndim - 1)), codes.shape)
        return Points(np.array([one[kept] for one in self._numbers]), codes[kept], margins[kept], frames[kept], lost)  # fmt: skip


def _sides(value: Value) -> tuple[Any, Any, Any, Any]:
    worst, best, worst_sat, best_sat = parts(value)
    return worst_sat, worst, best_sat, best
