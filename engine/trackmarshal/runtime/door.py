"""The door (S-2-C): whether a cycle keeps the input contract, and if not, in which field and at which place.

What passes has been copied into the door's own memory; `signals` gives it to a judge. docs/supervisor.md lists the faults.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trackmarshal.ir.spec import FieldType, SignalType
from trackmarshal.runtime.borders import Border
from trackmarshal.runtime.case import Fault
from trackmarshal.runtime.columns import Block, number, scaling
from trackmarshal.runtime.contract import EGO, IS_EMERGENCY, PLAN, Contract
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.faults import fault
from trackmarshal.runtime.plan import Plan

_MOST = sys.float_info.max
_LARGEST = 2**63 - 1


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the car was, and when on the Supervisor's clock; s, m, rad."""

    t: float
    x: float
    y: float
    heading: float


class Door:
    """Checks cycles one after the other; remembers number and stamp of the last one that was in order."""

    def __init__(self, contract: Contract, limits: Limits) -> None:
        self.contract = contract
        self.limits = limits
        self._number: int | None = None
        self._stamp = -math.inf
        self.driving = Block(DRIVING, contract.plan, limits.samples)
        self.emergency = Block(EMERGENCY, contract.plan, limits.samples)
        self._blocks: dict[str, Block] = {}
        self._records: dict[str, _Record] = {}
        self._borders: dict[str, dict[str, Border]] = {}
        self.closed: dict[str, bool] = {}
        self._events: dict[str, bool] = {}
        for signal in contract.shared:
            if signal.many or signal.sequence:
                capacity = limits.elements if signal.many else limits.samples
                self._blocks[signal.name] = Block(signal.name, signal, capacity)
            elif signal.kind == "state":
                self._records[signal.name] = _Record(signal)
            else:
                lines = ("",) if signal.kind == "polyline" else _lines(signal)
                self._borders[signal.name] = {
                    line: Border(signal.name, line, limits.border) for line in lines
                }
                self.closed[signal.name] = False
        rows = [self.driving.names.index(name) for name in ("x", "y", "heading", "v")]
        self._x, self._y, self._heading, self._v = rows

    def check(self, cycle: Cycle, now: float) -> tuple[list[Fault], Pose | None]:
        """The faults of a cycle that arrived now, and the car's pose where it and the stamp are in order."""
        faults: list[Fault] = []
        stamp = self._in_order(cycle, now, faults)
        before = len(faults)
        self.driving.fill(cycle.driving, faults)
        self.emergency.fill(cycle.emergency, faults)
        if len(faults) == before:
            self._candidates(faults)
        if type(cycle.signals) is not dict:
            faults.append(fault("missing" if cycle.signals is None else "wrong_type", "signals"))
            return faults, None
        ego_fits = self._fill_shared(cycle.signals, faults)
        return faults, self._pose(stamp) if ego_fits and stamp is not None else None

    def plans(self, cycle: Cycle) -> tuple[Plan, Plan]:
        """Both candidates of the cycle that has passed, for good."""
        t = float(cycle.t)
        driving, emergency = (
            Plan(block.name, cycle.number, t, block.names, block.view().matrix.copy())
            for block in (self.driving, self.emergency)
        )
        return driving, emergency

    def hold(self, cycle: Cycle) -> None:
        """Make sure that `signals` has the cycle that has passed; raises ValueError where it cannot."""

    def signals(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """What was checked, for the driving and for the emergency trajectory, in SI: columns by field for timelines and sets
        (with `id`), numbers by field for states, (n, 2) arrays by line and `closed` for borders, Booleans for events.

        The arrays are the door's own memory and change with the next cycle.
        """
        shared: dict[str, Any] = {name: block.view().columns for name, block in self._blocks.items()}
        for name, record in self._records.items():
            shared[name] = record.values
        for name, borders in self._borders.items():
            lines: dict[str, Any] = {line: border.points for line, border in borders.items()}
            shared[name] = lines | {"closed": self.closed[name]}
        shared |= self._events
        driving = {**shared, PLAN: self.driving.view().columns}
        emergency = {**shared, PLAN: self.emergency.view().columns}
        if self.contract.tells_emergency:
            driving[IS_EMERGENCY], emergency[IS_EMERGENCY] = False, True
        return driving, emergency

    def block(self, name: str) -> Block:
        """The columns of a candidate, a timeline or a set."""
        return (
            self.driving if name == DRIVING else self.emergency if name == EMERGENCY else self._blocks[name]
        )

    def ids(self) -> Mapping[str, tuple[str, ...]]:
        """The ids of the elements of every set."""
        return {name: block.ids for name, block in self._blocks.items() if block.many}

    def lines(self) -> dict[tuple[str, str], Border]:
        """Every border and line by signal and field."""
        return {(name, line): b for name, borders in self._borders.items() for line, b in borders.items()}

    def _fill_shared(self, signals: dict[str, Any], faults: list[Fault]) -> bool:
        """Everything but the candidates; whether the car's own state has no fault."""
        ego_fits = False
        for name, record in self._records.items():
            before = len(faults)
            record.fill(signals.get(name), faults)
            ego_fits = ego_fits or (name == EGO and len(faults) == before)
        for name, block in self._blocks.items():
            block.fill(signals.get(name), faults)
        for name, borders in self._borders.items():
            self._fill_borders(name, borders, signals.get(name), faults)
        for name in self.contract.events:
            value = signals.get(name)
            if type(value) not in (bool, np.bool_):
                faults.append(fault("missing" if value is None else "wrong_type", name))
            else:
                self._events[name] = bool(value)
        return ego_fits

    # Parts ----------------------------------------------------------------------------------------------------

    def _in_order(self, cycle: Cycle, now: float, faults: list[Fault]) -> float | None:
        """Number and stamp against the last cycle in order and the clock; the stamp where it can be relied on."""
        stamp, count = number(cycle.t), cycle.number
        limits = self.limits
        before = len(faults)
        if stamp is None or not math.isfinite(stamp):
            name = "wrong_type" if stamp is None else "missing" if cycle.t is None else "not_finite"
            faults.append(fault(name, "cycle", "t"))
        elif abs(stamp - self._stamp) <= limits.shortest_gap:
            faults.append(fault("repeated", "cycle", "t", None, f"{stamp!r} after {self._stamp!r}"))
        elif stamp < self._stamp:
            faults.append(fault("out_of_order", "cycle", "t", None, f"{stamp!r} after {self._stamp!r}"))
        elif stamp - now > limits.clock_tolerance:
            faults.append(fault("early", "cycle", "t", None, f"{stamp!r} at {now!r}"))
        in_order = len(faults) == before
        if type(count) is not int:
            faults.append(fault("missing" if count is None else "wrong_type", "cycle", "number"))
        elif not -_LARGEST <= count <= _LARGEST:
            faults.append(fault("out_of_range", "cycle", "number", None, "more than 64 bits"))
        elif self._number is not None and count != self._number + 1:
            name = (
                "repeated" if count == self._number else "skipped" if count > self._number else "out_of_order"
            )
            faults.append(fault(name, "cycle", "number", None, f"{count} after {self._number}"))
        if not in_order or stamp is None:
            return None
        if stamp - self._stamp > limits.longest_gap and self._number is not None:
            faults.append(
                fault("late", "cycle", "t", None, f"{stamp - self._stamp:g} s after the one before")
            )
        if now - stamp > limits.oldest:
            faults.append(fault("stale", "cycle", "t", None, f"{now - stamp:g} s old"))
        self._stamp = stamp
        if type(count) is int and -_LARGEST <= count <= _LARGEST:
            self._number = count
        return stamp

    def _candidates(self, faults: list[Fault]) -> None:
        """Both start in one place, and the emergency trajectory ends at rest."""
        d, e = self.driving.view().matrix, self.emergency.view().matrix
        x, y, heading, v = self._x, self._y, self._heading, self._v
        limits = self.limits
        first, other = d[:, 0].tolist(), e[:, 0].tolist()
        gap = math.hypot(first[x] - other[x], first[y] - other[y])
        turn = abs(math.remainder(first[heading] - other[heading], math.tau))
        faster = abs(first[v] - other[v])
        for field, difference, limit, unit in (
            ("x" if abs(first[x] - other[x]) >= abs(first[y] - other[y]) else "y", gap, limits.start_distance, "m"),
            ("heading", turn, limits.start_turn, "rad"),
            ("v", faster, limits.start_speed, "m/s"),
        ):  # fmt: skip
            if not difference <= limit:
                faults.append(fault("starts_elsewhere", EMERGENCY, field, 0, f"{difference:g} {unit} apart"))
        last = abs(float(e[v, -1]))
        if not last <= limits.rest_speed:
            faults.append(fault("not_at_rest", EMERGENCY, "v", self.emergency.count - 1, f"{last:g} m/s"))

    def _pose(self, stamp: float) -> Pose:
        ego = self._records[EGO].values
        return Pose(stamp - ego.get("age", 0.0), ego["x"], ego["y"], ego["heading"])

    def _fill_borders(self, name: str, borders: dict[str, Border], raw: Any, faults: list[Fault]) -> None:
        if "" in borders:
            borders[""].fill(raw, faults)
            return
        if type(raw) is not dict:
            faults.append(fault("missing" if raw is None else "wrong_type", name))
            return
        for line, border in borders.items():
            border.fill(raw.get(line), faults)
        closed = raw.get("closed", False)
        if type(closed) is not bool:
            faults.append(fault("wrong_type", name, "closed"))
        else:
            self.closed[name] = closed


class _Record:
    """The fields of a state, as numbers in SI and Booleans."""

    def __init__(self, signal: SignalType) -> None:
        self.name = signal.name
        self.values: dict[str, Any] = {}
        self._fields = [
            (kind, kind.name, _low(kind), _high(kind), scaling(kind))
            for kind in signal.fields_
            if kind.kind in ("number", "bool")
        ]

    def fill(self, raw: object, faults: list[Fault]) -> None:
        if type(raw) is not dict:
            faults.append(fault("missing" if raw is None else "wrong_type", self.name))
            return
        values = {}
        for kind, name, low, high, scale in self._fields:
            if name not in raw:
                if kind.default is None:
                    faults.append(fault("missing", self.name, name))
                values[name] = kind.default
                continue
            given = raw[name]
            if kind.kind == "bool":
                if type(given) not in (bool, np.bool_):
                    faults.append(fault("missing" if given is None else "wrong_type", self.name, name))
                values[name] = bool(given) if type(given) in (bool, np.bool_) else None
                continue
            value = number(given)
            if value is not None and scale is not None:
                value = value * scale[0] / scale[1]
            if value is None:
                faults.append(fault("wrong_type", self.name, name))
            elif not low <= value <= high:
                finite = math.isfinite(value)
                message = f"{value!r} is outside [{low:g}, {high:g}] in SI units" if finite else f"{value!r}"
                faults.append(
                    fault("out_of_range" if finite else "not_finite", self.name, name, None, message)
                )
            values[name] = value
        self.values = values


def _low(kind: FieldType) -> float:
    return -_MOST if kind.lower is None else kind.lower


def _high(kind: FieldType) -> float:
    return _MOST if kind.upper is None else kind.upper


def _lines(corridor: SignalType) -> list[str]:
    """The lines of a corridor: those that are declared, and both borders."""
    declared = [kind.name for kind in corridor.fields_ if kind.kind == "polyline"]
    return list(dict.fromkeys((*declared, "left", "right")))
