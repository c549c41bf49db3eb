"""The door of a Supervisor (S-2-C): whether a cycle keeps the input contract, and if not, in which field and at which place.

docs/supervisor.md lists the faults. They come in this order: what is wrong with the structure, with number and stamp, with the
candidates, with everything else.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from trackmarshal.runtime.contract import EGO, Contract
from trackmarshal.runtime.contract.cycles import COUNTED, END, NUMBER, STAMP, START, TIMELY, Demand
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.checking import FrameChecker
from trackmarshal.runtime.door.reading import CycleReader, Read
from trackmarshal.runtime.faults import Fault, fault
from trackmarshal.runtime.frame import NO_SETTINGS, Frame, Settings

_LARGEST = 2**63 - 1


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the car was, and when on the Supervisor's clock; s, m, rad. v: how fast it was, m/s; None where the spec has no speed."""

    t: float
    x: float
    y: float
    heading: float
    v: float | None


@dataclass(frozen=True, slots=True)
class Admission:
    """What the door says of one cycle: the step that it is about, the cycle as a frame, and everything that is wrong with it.

    number, t: None where they are no numbers. pose: the car's, where it and the stamp are in order.
    """

    about: int
    frame: Frame
    number: int | None
    t: float | None
    faults: tuple[Fault, ...]
    pose: Pose | None


class Stamp(NamedTuple):
    """Number and stamp of a cycle as far as they are numbers, with what is wrong with them otherwise."""

    number: int | None
    t: float | None
    faults: tuple[Fault, ...]


def stamp_of(cycle: Cycle) -> Stamp:
    """Number and stamp of a cycle by their types; numbers beyond 64 bits are none."""
    number, t = cycle.number, cycle.t
    if type(number) is int and type(t) is float and -_LARGEST <= number <= _LARGEST:
        return Stamp(number, t, ())
    found: list[Fault] = []
    number, t = values.whole(number), values.number(t)
    if number is None:
        name = "missing" if cycle.number is None else "wrong_type"
        found.append(fault(name, "cycle", "number", None, values.worded(cycle.number)))
    elif not -_LARGEST <= number <= _LARGEST:
        found.append(fault("out_of_range", "cycle", "number", None, "more than 64 bits"))
        number = None
    if t is None or cycle.t is None:
        name = "missing" if cycle.t is None else "wrong_type"
        found.append(fault(name, "cycle", "t", None, values.worded(cycle.t)))
        t = None
    return Stamp(number, t, tuple(found))


class Door:
    """Checks cycles one after the other; remembers number and stamp of the last one that was in order."""

    def __init__(self, contract: Contract, limits: Limits, settings: Settings = NO_SETTINGS) -> None:
        self.contract = contract
        self.limits = limits
        self.reader = CycleReader(contract, settings)
        self._checker = FrameChecker(contract, limits)
        self._demands = _Demands(limits)
        #: Of stamps that are in order.
        self._timely = (*TIMELY, *(COUNTED if contract.over_run else ()))
        #: Those of the last cycle in order; None where there was none.
        self._number: int | None = None
        self._stamp: float | None = None

    @property
    def last(self) -> tuple[int | None, float | None]:
        """Number and stamp of the last cycle in order, which the next one is compared with; None where there was none."""
        return self._number, self._stamp

    @last.setter
    def last(self, given: tuple[int | None, float | None]) -> None:
        self._number, self._stamp = given

    def admit(self, about: int, cycle: Cycle, now: float) -> Admission:
        """What there is to say of a cycle that arrived now (NaN: the clock is wrong)."""
        return self._admitted(about, cycle, now, Read(*self.reader.read(cycle), set()))

    def admit_all(self, cycles: Sequence[Cycle]) -> list[Admission]:
        """The same of cycles that come one after the other, each at its stamp, cheaper; they are about no step."""
        read = self.reader.read_all(cycles, self._checker.all_fine)
        return [self._admitted(-1, cycle, cycle.t, one) for cycle, one in zip(cycles, read)]

    def _admitted(self, about: int, cycle: Cycle, now: float, read: Read) -> Admission:
        stamp = stamp_of(cycle)
        frame, structure, passed = read
        found = {fault.signal for fault in structure}
        faults = [*stamp.faults, *structure]
        in_order = self._in_order(stamp, now, faults)
        before = len(faults)
        self._checker.check_candidates(frame, found, faults, passed)
        if len(faults) == before and not found & {DRIVING, EMERGENCY}:
            self._fit(frame, faults)
        before = len(faults)
        self._checker.check_signals(frame, found, faults, passed)
        frame.faults, frame.t, frame.number = faults, stamp.t, stamp.number
        pose = None
        if in_order and stamp.t is not None and not any(f.signal in (EGO, "signals") for f in faults):
            pose = _pose(frame, stamp.t)
        return Admission(about, frame, stamp.number, stamp.t, tuple(faults), pose)

    def _in_order(self, stamp: Stamp, now: float, faults: list[Fault]) -> bool:
        """Number and stamp against the last cycle in order and the clock; whether the stamp can be relied on."""
        number, t = stamp.number, stamp.t
        in_order = False
        if t is not None:
            begun, since = (0, 0.0) if self._stamp is None else (1, t - self._stamp)
            given: dict[str, Any] = {"t": t, "now": now, "begun": begun, "since": since}
            in_order = self._demands.chain(STAMP, given, faults, f"{t!r} s at {now!r} s")
            if in_order:
                self._demands.each(self._timely, given, faults, f"{t!r} s at {now!r} s")
        if number is not None:
            last = self._number
            given = {"number": number, "last": 0 if last is None else last, "begun": int(last is not None)}
            self._demands.chain(NUMBER, given, faults, f"number {number}")
        if in_order and t is not None:
            self._stamp = t
            if number is not None:
                self._number = number
        return in_order

    def _fit(self, frame: Frame, faults: list[Fault]) -> None:
        """Both candidates start in one place, and the emergency trajectory ends at rest."""
        driving, emergency = frame.candidates[DRIVING], frame.candidates[EMERGENCY]
        dx, dy, turn, faster = (
            float(driving.column(name)[0]) - float(emergency.column(name)[0])
            for name in ("x", "y", "heading", "v")
        )
        given = {"dx": dx, "dy": dy, "turn": turn, "faster": faster}
        said = f"{math.sqrt(dx * dx + dy * dy):g} m, {abs(turn):g} rad, {abs(faster):g} m/s apart"
        self._demands.each(START, given, faults, said, EMERGENCY, 0)
        last = float(emergency.column("v")[-1])
        self._demands.each(END, {"last": last}, faults, f"{abs(last):g} m/s", EMERGENCY, emergency.count - 1)


def _pose(frame: Frame, t: float) -> Pose:
    known = frame.columns[EGO].names.rows
    age = frame.value(EGO, "age") if "age" in known else 0.0
    x, y, heading = (frame.value(EGO, name) for name in ("x", "y", "heading"))
    return Pose(t - age, x, y, heading, frame.value(EGO, "v") if "v" in known else None)


class _Demands:
    """Demands on cycles with the limits of one Supervisor."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits

    def chain(self, demands: Iterable[Demand], given: dict[str, Any], faults: list[Fault], said: str) -> bool:
        """Whether all hold; the first that does not is a fault."""
        for demand in demands:
            if not holds(demand, given, self._limits):
                faults.append(fault(demand.fault, "cycle", demand.field, None, said))
                return False
        return True

    def each(
        self, demands: Iterable[Demand], given: dict[str, Any], faults: list[Fault], said: str, signal: str = "cycle",
        index: int | None = None,
    ) -> None:  # fmt: skip
        """Every one that does not hold is a fault."""
        for demand in demands:
            if not holds(demand, given, self._limits):
                faults.append(fault(demand.fault, signal, demand.field, index, said))


def holds(demand: Demand, given: dict[str, Any], limits: Limits) -> bool:
    """Whether a demand holds, given what it speaks of; limits by name."""
    names, function = demand.ready
    return bool(function(*[given[name] if name in given else getattr(limits, name) for name in names]))
