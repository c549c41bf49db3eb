"""The door's memory for borders and lines: read anew whenever their content changes, compared by content in every cycle."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.runtime.case import Fault, Point
from trackmarshal.runtime.columns import number
from trackmarshal.runtime.faults import fault

Floats = NDArray[np.float64]


class Border:
    """One polyline: `points` (n, 2) and the same as tuples, which stay the same objects while the content does."""

    def __init__(self, signal: str, field: str, capacity: int) -> None:
        self._place = (signal, field)
        self._capacity = capacity
        self._content = b""
        self.points: Floats = np.zeros((0, 2))
        self._tuples: tuple[Point, ...] | None = None

    @property
    def tuples(self) -> tuple[Point, ...]:
        if self._tuples is None:
            self._tuples = tuple(map(tuple, self.points.tolist()))
        return self._tuples

    def fill(self, raw: object, faults: list[Fault]) -> None:
        if type(raw) is np.ndarray and raw.dtype == np.float64:
            points = raw
        else:
            read = self._read(raw, faults)
            if read is None:
                return
            points = read
        if points.ndim != 2 or points.shape[1] != 2:
            faults.append(fault("wrong_type", *self._place, None, f"an array of shape {points.shape}"))
            return
        if len(points) > self._capacity:
            message = f"{len(points)} points, the most is {self._capacity}"
            faults.append(fault("over_capacity", *self._place, self._capacity, message))
            return
        content = points.tobytes()
        if content == self._content:
            return
        if len(points) < 2:
            faults.append(
                fault("bad_border", *self._place, None, f"{len(points)} points, at least 2 are needed")
            )
            return
        points = np.frombuffer(content).reshape(-1, 2)  # what was compared, not what may change meanwhile
        finite = np.isfinite(points)
        if not finite.all():
            index = int(np.flatnonzero(~finite.all(axis=1))[0])
            faults.append(fault("not_finite", *self._place, index, f"{points[index].tolist()}"))
            return
        self._content, self.points, self._tuples = content, points, None

    def _read(self, raw: Any, faults: list[Fault]) -> Floats | None:
        if raw is None:
            faults.append(fault("missing", *self._place))
            return None
        if type(raw) is np.ndarray:
            raw = raw.tolist()
        if type(raw) not in (list, tuple):
            faults.append(fault("wrong_type", *self._place, None, "not a list of points"))
            return None
        if len(raw) > self._capacity:
            message = f"{len(raw)} points, the most is {self._capacity}"
            faults.append(fault("over_capacity", *self._place, self._capacity, message))
            return None
        rows = np.zeros((len(raw), 2))
        for index, point in enumerate(raw):
            pair = point.tolist() if type(point) is np.ndarray else point
            if type(pair) not in (list, tuple) or len(pair) != 2:
                faults.append(fault("wrong_type", *self._place, index, "not a point [x, y]"))
                return None
            for axis, value in enumerate(pair):
                coordinate = number(value)
                if coordinate is None:
                    faults.append(fault("wrong_type", *self._place, index, "not a number"))
                    return None
                rows[index, axis] = coordinate
        return rows
