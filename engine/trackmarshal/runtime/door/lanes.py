"""Sets of lanes: the borders of every lane of a cycle, and what is wrong with them."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Sequence
from typing import Any

from trackmarshal.runtime.contract import Signal
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.lines import NOWHERE, LineReader, NoLineError
from trackmarshal.runtime.faults import Fault, fault, name_of
from trackmarshal.runtime.frame import SIDES, Frame
from trackmarshal.runtime.geometry.corridor import corridor_region
from trackmarshal.runtime.lines import Line

#: Lanes of which it is remembered whether they can be used: those of a few cycles.
KEPT = 512


class LanesReader:
    """Reads the borders of one set of lanes; its other fields are columns, and read as those of any set."""

    def __init__(self, signal: Signal) -> None:
        self.signal = signal
        self._readers: list[tuple[LineReader, LineReader]] = []

    def read(self, raw: Any, frame: Frame, faults: list[Fault]) -> None:
        """Put the lanes into a frame. Where the set is none at all, that is said with its columns."""
        name = self.signal.name
        frame.lanes[name] = ((NOWHERE, NOWHERE),)
        found: list[Fault] = []
        try:
            sides = _sides(raw)
            if sides is not None:
                frame.lanes[name] = tuple(
                    self._lane(index, pair, found) for index, pair in enumerate(zip(*sides))
                )
            faults += _first(found)
        except Exception:  # what was handed in has a say in how it is read
            frame.lanes[name] = ((NOWHERE, NOWHERE),)
            if not any(one.signal == name and not one.field and one.index is None for one in faults):
                faults.append(fault("wrong_type", name, "", None, "its lanes cannot be read"))

    def _lane(self, index: int, pair: tuple[Any, Any], faults: list[Fault]) -> tuple[Line, Line]:
        while len(self._readers) <= index:
            self._readers.append((LineReader(), LineReader()))
        left, right = (
            self._line(reader, side, index, raw, faults)
            for reader, side, raw in zip(self._readers[index], SIDES, pair)
        )
        return left, right

    def _line(self, reader: LineReader, side: str, index: int, raw: Any, faults: list[Fault]) -> Line:
        if raw is None:
            faults.append(fault("missing", self.signal.name, side, index, "it is not there"))
            return NOWHERE
        try:
            return reader.read(raw)
        except NoLineError as error:
            where = "" if error.index is None else f"point {error.index}: "
            faults.append(fault(error.name, self.signal.name, side, index, where + error.message))
            return NOWHERE


class LanesChecker:
    """Checks the borders of one set of lanes: each has two points at least, and they make a road that does not cross itself. limits: of a
    Supervisor, whose `border` is the most points of each."""

    def __init__(self, signal: Signal, limits: Limits | None = None) -> None:
        self._name = signal.name
        self._room = math.inf if limits is None else limits.border
        self._most = _most(signal, limits)
        self._known: OrderedDict[tuple[int, int], str] = OrderedDict()

    def check(self, frame: Frame, faults: list[Fault]) -> None:
        """A fault of the first lane that cannot be used; those of which a border could not be read are named already."""
        if any(found.signal == self._name and not found.field and found.index is None for found in faults):
            return  # there is no set
        found = []
        # Where columns are of different lengths, no more than the shortest of them, as of any set.
        lanes = frame.lanes[self._name][: frame.columns[self._name].count]
        if len(lanes) > self._most:  # which is a fault of the set
            return
        for place, side in enumerate(SIDES):
            for index, lane in enumerate(lanes):
                count = len(lane[place])
                if count > self._room:
                    message = f"{count} points, room for {self._room:g}: raise the limit `border` to {count}"
                    found.append(fault("over_capacity", self._name, side, index, message))
        for index, (left, right) in enumerate(lanes):
            there = left is not NOWHERE and right is not NOWHERE and max(len(left), len(right)) <= self._room
            problem = self._problem(left, right) if there else ""
            if problem:
                found.append(fault("bad_border", self._name, "", index, problem))
        faults += _first(found)

    def _problem(self, left: Line, right: Line) -> str:
        key = left.number, right.number
        known = self._known.get(key)
        if known is None:
            region = corridor_region(left.points, right.points, False)
            known = self._known[key] = region if isinstance(region, str) else ""
            while len(self._known) > KEPT:
                self._known.popitem(last=False)
        return known


def _most(signal: Signal, limits: Limits | None) -> float:
    """How many lanes there is room for."""
    told = [value for check in signal.checks for name, value in check.constants if name == "most"]
    if limits is None:
        told = [value for value in told if not isinstance(value, str)]
    return min(
        (getattr(limits, value) if isinstance(value, str) else value for value in told), default=math.inf
    )


def _first(faults: list[Fault]) -> list[Fault]:
    """The first fault of each kind and field, which says how many more there are."""
    alike: dict[tuple[str, str], list[Fault]] = {}
    for each in faults:
        alike.setdefault((name_of(each), each.field), []).append(each)
    return [
        first
        if not more
        else fault(name, first.signal, field, first.index, f"{first.message}, and {len(more)} more")
        for (name, field), (first, *more) in alike.items()
    ]


def _sides(raw: Any) -> tuple[Sequence[Any], Sequence[Any]] | None:
    """What stands for the left borders, and for the right ones, of a list of records or of columns; None for neither."""
    if raw is None:
        return None
    if values.is_a(raw, (list, tuple)):
        lanes = [values.mapping(one) for one in values.entries(raw)]
        return [lane.get("left") for lane in lanes], [lane.get("right") for lane in lanes]
    data = values.mapping(raw)
    left, right = (list(data.get(side, ())) for side in SIDES)
    count = max(len(left), len(right), *(_length(column) for column in data.values()))
    return left + [None] * (count - len(left)), right + [None] * (count - len(right))


def _length(column: Any) -> int:
    return len(column) if hasattr(column, "__len__") else 0
