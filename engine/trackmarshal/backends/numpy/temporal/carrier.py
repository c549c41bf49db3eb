"""The two things a formula's value is made of, a Boolean and a margin, as one kind of lattice of arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.temporal.windows import BoolArray, FloatArray, Windows

#: Rows of samples, (rows, n), of one carrier's type, in an operator's direction.
Rows: TypeAlias = NDArray[Any]
#: A formula's value along a timeline: (sat, margin), both (..., n).
Bound: TypeAlias = tuple[BoolArray, FloatArray]


@dataclass(frozen=True, slots=True)
class Carrier:
    """A chain: its meet (and, minimum) and join (or, maximum), their neutral elements, its array type."""

    meet: np.ufunc
    join: np.ufunc
    top: float | bool
    bottom: float | bool
    dtype: type

    def rows(self, values: Rows, w: Windows) -> Rows:
        """The samples (..., n) as rows in the windows' direction, without a copy where the layout allows."""
        if values.dtype != self.dtype or values.shape[-1:] != (w.n,):
            raise TypeError(
                f"{w.n} samples of {self.dtype.__name__} expected, not {values.shape} of {values.dtype}"
            )
        return _directed(values, w)

    def results(self, samples: tuple[int, ...], w: Windows, neutral: float | bool) -> tuple[Rows, Rows]:
        """Room for what is said of samples of a shape (..., n): (..., asked), neutral, and the same as rows in the windows' direction."""
        made: Rows = np.full((*samples[:-1], w.asked), neutral, dtype=self.dtype)
        return made, _directed(made, w)

    def fetch(self, rows: Rows, low: int, high: int, beyond: float | bool) -> Rows:
        """A copy of the samples [low, high) to work in, `beyond` standing for those after the trace's end.

        Adding 0.0 turns -0.0 into 0.0: which of the two a minimum returns is up to the processor otherwise.
        """
        inside = max(min(high, rows.shape[-1]) - low, 0)
        buffer: Rows = np.empty((rows.shape[0], high - low), dtype=self.dtype)
        np.add(rows[:, low : low + inside], self.dtype(0), out=buffer[:, :inside])
        buffer[:, inside:] = beyond
        return buffer


def _directed(values: Rows, w: Windows) -> Rows:
    count = values.shape[-1]
    rows = values.reshape(-1, count) if count else values.reshape(0, 0)
    return rows[:, ::-1] if w.past else rows


VERDICT = Carrier(np.logical_and, np.logical_or, True, False, np.bool_)
MARGIN = Carrier(np.minimum, np.maximum, np.inf, -np.inf, np.float64)
