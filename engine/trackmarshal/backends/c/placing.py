"""Tracks, places and lanes of cases, as Python puts them into the context of a program."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from itertools import chain
from typing import Any

from trackmarshal.backends.c.layout import Layout, is_lanes
from trackmarshal.backends.c.library import Library
from trackmarshal.backends.c.places import bordered, lanes, ordered
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.lines import Line

#: A `tm_status`.
_UNSUPPORTED = 4


class PlaceSetter:
    """Puts the tracks and places of cases into a context; the same points are prepared once."""

    def __init__(self, plan: Layout, library: Library) -> None:
        self._plan = plan
        self._library = library
        self._set = library.dll.tmg_set_place
        self._names = ordered(plan)
        #: What is in the context now, by number; the spec's own places are there from the start.
        self._now: list[tuple[Any, ...] | None] = [None] * len(self._names)
        self._status = [0] * len(self._names)
        self._lanes = [
            LaneSetter(name, number, library, plan.spec.signals[name].capacity)
            for number, name in enumerate(lanes(plan))
        ]

    def put(self, case: Frame) -> None:
        """Raises TrackmarshalError E473 for a track that the C geometry refuses."""
        for each in self._lanes:
            each.put(case)
        for index, name in enumerate(self._names):
            if is_lanes(self._plan.spec, name):
                continue
            given = self._given(case, name)
            before = self._now[index]
            if before is None or len(before) != len(given) or any(a is not b for a, b in zip(before, given)):
                self._status[index] = self._put(index, given)
                self._now[index] = given
            if self._status[index] in (1, _UNSUPPORTED):
                raise _refused(name, case)

    def _given(self, case: Frame, name: str) -> tuple[Any, ...]:
        if name not in self._plan.spec.signals:
            return (case.settings.places.get(name, self._plan.spec.places[name].points), (), False)
        if bordered(self._plan, name):
            return case.corridor(name)
        return (case.line(name, ""), (), False)

    def _put(self, index: int, given: tuple[Any, ...]) -> int:
        left, right = _flat(given[0]), _flat(given[1])
        status: int = self._set(
            self._library.context,
            index,
            left.buffer_info()[0],
            len(given[0]),
            right.buffer_info()[0],
            len(given[1]),
            int(given[2]),
        )
        return status


class LaneSetter:
    """Puts the lanes of one set into a context; the same borders at the same place are prepared once. most: its capacity, if it declares one."""

    def __init__(self, name: str, number: int, library: Library, most: int | None = None) -> None:
        self._most = most
        self._name, self._number, self._library = name, number, library
        self._now: list[tuple[Line, Line]] = []
        self._status: list[int] = []

    def put(self, case: Frame) -> None:
        """Raises TrackmarshalError E473 for a lane that the C geometry refuses."""
        # Of more than it declares, the rules are undefined, and none is asked for; nor of borders beyond the other columns, for which there is no memory.
        lanes = case.lanes.get(self._name, ())[: self._most]
        for lane, given in enumerate(lanes[: case.count(self._name)] if lanes else ()):
            before = self._now[lane] if lane < len(self._now) else None
            if before is None or before[0] is not given[0] or before[1] is not given[1]:
                self._now[lane : lane + 1] = [given]
                self._status[lane : lane + 1] = [self._put(lane, given)]
            if self._status[lane] in (1, _UNSUPPORTED):
                raise _refused(self._name, case)

    def _put(self, lane: int, given: tuple[Line, Line]) -> int:
        left, right = (_flat(line) for line in given)
        status: int = self._library.dll.tmg_set_lane(
            self._library.context, self._number, lane, left.buffer_info()[0], len(given[0]), right.buffer_info()[0], len(given[1])
        )  # fmt: skip
        return status


def _refused(name: str, case: Frame) -> TrackmarshalError:
    return TrackmarshalError(
        "E473", f"the C geometry refuses `{name}` of case {case.id!r}", help="choose another backend"
    )


def _flat(points: Line | Sequence[tuple[float, float]]) -> array[float]:
    if isinstance(points, Line):
        return array("d", points.points.tobytes()) or array("d", [0.0])
    return array("d", chain.from_iterable(points)) or array("d", [0.0])
