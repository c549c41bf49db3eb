"""The contract, interpreted: whether the values of a frame pass the checks of their fields."""

from __future__ import annotations

from collections.abc import Mapping, Set
from functools import lru_cache
from typing import Any

import numpy as np

from trackmarshal.runtime.contract import EVENT, LINES, SET, Check, Contract, Field, Kind, Signal
from trackmarshal.runtime.cycle import CAPACITIES, DRIVING, EMERGENCY, Limits
from trackmarshal.runtime.door.columns import rows_of
from trackmarshal.runtime.door.lanes import LanesChecker
from trackmarshal.runtime.door.wording import worded
from trackmarshal.runtime.faults import Fault, fault
from trackmarshal.runtime.frame import Columns, Frame
from trackmarshal.runtime.lines import Line

#: A breach of what there is room for.
OVER_CAPACITY = "over_capacity"
#: What conditions of each sort speak of.
_VARIABLES = {"value": ("x",), "step": ("before", "x"), "count": ("n",), "point": ("x",)}


class _Ready:
    """A check with its condition as a function, and its constants as numbers."""

    def __init__(self, check: Check, capacities: Mapping[str, float]) -> None:
        self.fault, self.of = check.kind.fault, check.kind.of
        self.constants = {
            name: capacities[value] if isinstance(value, str) else value for name, value in check.constants
        }
        self.capacity = next((v for _, v in check.constants if isinstance(v, str)), "")
        most = self.constants.get("most") if self.fault == OVER_CAPACITY else None
        #: How many there is room for, of what has a capacity.
        self.room = None if most is None or most == float("inf") else int(most)
        self._function = check.kind.holds.function(*_VARIABLES[self.of], *self.constants)

    def __call__(self, *variables: Any) -> Any:
        return self._function(*variables, *self.constants.values())


class _Together:
    """A kind of check for all rows of a signal that have it, with their constants one above the other."""

    def __init__(self, kind: Kind, rows: list[tuple[int, Check]], height: int) -> None:
        names = [name for name, _ in rows[0][1].constants]
        self.of = kind.of
        #: None: every row.
        self.rows = None if len(rows) == height else rows_of([row for row, _ in rows])
        values = [dict(check.constants) for _, check in rows]
        self._constants = [np.array([[value[name]] for value in values]) for name in names]
        self._function = kind.holds.function(*_VARIABLES[kind.of], *names)

    def hold(self, values: Any) -> bool:
        """Whether all pass, of (..., rows, count)."""
        return bool(self._passed(values).all())

    def each(self, values: Any) -> Any:
        """(frames,): which pass, of (frames, rows, count)."""
        return self._passed(values).all(axis=(-2, -1))

    def _passed(self, values: Any) -> Any:
        x = values if self.rows is None else values[..., self.rows, :]
        variables = (x[..., :-1], x[..., 1:]) if self.of == "step" else (x,)
        return self._function(*variables, *self._constants)


class ColumnsChecker:
    """Checks one signal of columns."""

    def __init__(self, signal: Signal, label: str, limits: Limits | None) -> None:
        self.signal, self.label = signal, label
        capacities = _capacities(limits)
        self._counts = [_Ready(check, capacities) for check in signal.checks]
        self._fields: list[tuple[Field, list[_Ready]]] = [
            (field, [_Ready(check, capacities) for check in field.checks])
            for field in (*signal.numbers, *signal.flags)
        ]
        self._numbers = _together(signal.numbers)
        self._flags = _together(signal.flags)

    def fine(self, columns: Columns) -> bool:
        """Whether nothing is wrong."""
        return (
            all(check(columns.count) for check in self._counts)
            and all(kind.hold(columns.values) for kind in self._numbers)
            and all(kind.hold(columns.flags) for kind in self._flags)
        )

    def all_fine(self, stack: Any, count: int, flags: Any = None) -> bool:
        """Whether nothing is wrong with many frames: their numbers (frames, numbers, count), and flags, where there are any."""
        return all(check(count) for check in self._counts) and (
            count == 0  # of nothing, nothing is wrong
            or (
                all(kind.hold(stack) for kind in self._numbers)
                and (flags is None or all(kind.hold(flags) for kind in self._flags))
            )
        )

    def each_fine(self, stack: Any, count: int, flags: Any = None) -> Any:
        """(frames,): the same of each frame by itself."""
        found = np.full(len(stack), all(check(count) for check in self._counts))
        for kind, values in [(kind, stack) for kind in self._numbers] + [
            (kind, flags) for kind in self._flags
        ]:
            if values is not None and count:
                found &= kind.each(values)
        return found

    def check(self, columns: Columns, faults: list[Fault]) -> None:
        """Add what is wrong: the first entry of every kind in every field."""
        if self.fine(columns):
            return
        for check in self._counts:
            if not check(columns.count):
                message = _too_many(columns.count, check, "entries")
                faults.append(fault(check.fault, self.label, "", check.room, message))
                return
        record = self.signal.form == "record"
        for field, checks in self._fields:
            if field.name in columns.absent:
                continue
            values = columns.column(field.name)
            failed = np.zeros(len(values), dtype=bool)
            for check in checks:
                if check.of == "value":
                    bad = ~check(values)
                    own, failed = bad & ~failed, failed | bad
                elif check.of == "step":
                    own = np.concatenate([[False], ~check(values[:-1], values[1:])])
                else:
                    raise AssertionError(f"a field has no check of {check.of}")
                if own.any():
                    index = int(np.argmax(own))
                    message = worded(check.fault, field, values, index, int(own.sum()))
                    faults.append(
                        fault(check.fault, self.label, field.name, None if record else index, message)
                    )


class LineChecker:
    """Checks the lines of one place; one that has passed passes again."""

    def __init__(self, signal: str, field: Field, limits: Limits | None) -> None:
        self._place = signal, field.name
        self._checks = [_Ready(check, _capacities(limits)) for check in field.checks]
        self._passed: Line | None = None

    def check(self, line: Line, faults: list[Fault]) -> None:
        if line is self._passed:
            return
        for check in self._checks:
            if check.of == "count":
                if not check(len(line)):
                    message = _too_many(len(line), check, "points")
                    faults.append(fault(check.fault, *self._place, check.room, message))
                    return
            elif check.of == "point":
                fine = check(line.points)
                if not fine.all():
                    index = int(np.argmin(fine.all(axis=1)))
                    faults.append(fault(check.fault, *self._place, index, f"{line.points[index].tolist()}"))
                    return
            else:
                raise AssertionError(f"a line has no check of {check.of}")
        self._passed = line


class FrameChecker:
    """Checks frames against a contract. What `found` names already is not looked at again."""

    def __init__(self, contract: Contract, limits: Limits | None = None) -> None:
        self.columns = {
            s.name: _checker(_Same(s), s.name, limits)
            for s in contract.signals
            if s.form not in (LINES, EVENT)
        }
        self.candidates = (
            {}
            if contract.plan is None
            else {name: _checker(_Same(contract.plan), name, limits) for name in (DRIVING, EMERGENCY)}
        )
        self._lines = {
            (s.name, field.name): LineChecker(s.name, field, limits)
            for s in contract.signals
            if s.form == LINES
            for field in s.lines
        }
        self._lanes = {s.name: LanesChecker(s, limits) for s in contract.signals if s.form == SET and s.lines}
        self._order = contract.signals

    def all_fine(self, name: str, stack: Any, count: int) -> bool:
        """Whether nothing is wrong with a signal of columns, or a candidate, in many frames: (frames, numbers, count)."""
        return {**self.columns, **self.candidates}[name].all_fine(stack, count)

    def check_candidates(
        self, frame: Frame, found: set[str], faults: list[Fault], passed: Set[str] = frozenset()
    ) -> None:
        for name, columns in frame.candidates.items():
            if name not in found and name not in passed:
                self.candidates[name].check(columns, faults)

    def check_signals(
        self, frame: Frame, found: set[str], faults: list[Fault], passed: Set[str] = frozenset()
    ) -> None:
        """All others, in the order of the contract; those that have `passed` already are left out."""
        if not found and passed >= self.columns.keys():
            for place, checker in self._lines.items():
                checker.check(frame.lines[place], faults)
            self.check_lanes(frame, faults)
            return
        for signal in self._order:
            name = signal.name
            if name in found or name in passed:
                continue
            if signal.form == LINES:
                for field in signal.lines:
                    self._lines[name, field.name].check(frame.line(name, field.name), faults)
            elif signal.form != EVENT:  # an event that is none is a fault of structure
                self.columns[name].check(frame.columns[name], faults)
        self.check_lanes(frame, faults)

    def check_lanes(self, frame: Frame, faults: list[Fault]) -> None:
        """Lanes, whatever else is wrong with their set: which of them can be used matters to all that read it."""
        for lanes in self._lanes.values():
            lanes.check(frame, faults)


class _Same:
    """A signal that is equal to itself alone: to compare all that it says would take longer than to make what checks it."""

    def __init__(self, signal: Signal) -> None:
        self.signal = signal

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.signal is other.signal

    def __hash__(self) -> int:
        return object.__hash__(self.signal)


@lru_cache(maxsize=128)
def _checker(same: _Same, label: str, limits: Limits | None) -> ColumnsChecker:
    """What checks a signal: it remembers nothing, so that all Supervisors of one contract have the same."""
    return ColumnsChecker(same.signal, label, limits)


def _together(fields: tuple[Field, ...]) -> list[_Together]:
    kinds: dict[int, tuple[Kind, list[tuple[int, Check]]]] = {}
    for row, field in enumerate(fields):
        for check in field.checks:
            kinds.setdefault(id(check.kind), (check.kind, []))[1].append((row, check))
    return [_Together(kind, rows, len(fields)) for kind, rows in kinds.values()]


def _too_many(count: int, check: _Ready, things: str) -> str:
    """A count that a check does not pass, and for a capacity which limit to raise to what."""
    room = check.room
    if room is None:
        return f"{count} {things}"
    if not check.capacity:
        return f"{count} elements, room for {room}: declare the signal with `capacity {count}`"
    return f"{count} {CAPACITIES[check.capacity]}, room for {room}: raise the limit `{check.capacity}` to {count}"


def _capacities(limits: Limits | None) -> dict[str, float]:
    return {name: float("inf") if limits is None else getattr(limits, name) for name in CAPACITIES}
