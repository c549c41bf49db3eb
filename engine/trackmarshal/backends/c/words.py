"""What faults that C has found are said to be: C gives their names and places, the words are those of every door."""

from __future__ import annotations

import math
from collections.abc import Iterable

from trackmarshal.backends.c.said import Reason, Said
from trackmarshal.runtime.contract import Contract
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Limits
from trackmarshal.runtime.door.checking import FrameChecker
from trackmarshal.runtime.door.door import Stamp
from trackmarshal.runtime.faults import Fault, fault, name_of
from trackmarshal.runtime.frame import Frame

_Key = tuple[str, str, str, int | None]


class Wording:
    """Words for the faults of one contract's cycles."""

    def __init__(self, contract: Contract, limits: Limits) -> None:
        self._checker = FrameChecker(contract, limits)
        self._limits = limits
        #: The clock's last reading that could be one.
        self.last = -math.inf

    def faults(
        self,
        reasons: Iterable[Reason],
        found: list[Fault],
        frame: Frame | None,
        stamp: Stamp,
        now: float,
        said: Said,
    ) -> tuple[Fault, ...]:
        """The faults among reasons; those that were `found` before as they were. now: the clock as it was read at the arrival."""
        listed = [one for one in reasons if one.rule is None and not one.lost]
        if not listed:
            return ()
        known: dict[_Key, Fault] = {}
        if frame is not None and any(one.signal not in ("cycle", "clock", "supervisor") for one in listed):
            for one in self._values(frame, found):
                known.setdefault(_key(one), one)
        known |= {_key(one): one for one in found}
        made = []
        for reason in listed:
            key = (reason.name, reason.signal, reason.field, reason.index)
            made.append(known.get(key) or fault(*key, self._message(reason, frame, stamp, now, said)))
        return tuple(made)

    def read(self, said: Said) -> None:
        """Note the clock's readings of a step."""
        for reading in (said.now, said.finished):
            if math.isfinite(reading) and reading >= self.last:
                self.last = reading

    def _values(self, frame: Frame, found: list[Fault]) -> list[Fault]:
        faults: list[Fault] = []
        named = {one.signal for one in found}
        self._checker.check_candidates(frame, named, faults)
        self._checker.check_signals(frame, named, faults)
        return faults

    def _message(self, one: Reason, frame: Frame | None, stamp: Stamp, now: float, said: Said) -> str:
        arrived = not math.isnan(said.now)
        if one.name == "bad_clock":
            value, last = (said.finished, said.now) if arrived else (now, self.last)
            return f"{value!r} after {last!r}"
        if one.name == "overrun":
            known = math.isfinite(said.finished) and said.finished >= said.now
            took = (said.finished if known else math.nan) - said.now
            return f"{took:g} s, the budget is {self._limits.budget:g} s"
        if one.name == "starts_elsewhere" and frame is not None:
            return _apart(frame)
        if one.name == "not_at_rest" and frame is not None:
            return f"{abs(float(frame.candidates[EMERGENCY].column('v')[-1])):g} m/s"
        if (one.signal, one.field) == ("cycle", "t"):
            return f"{stamp.t!r} s at {said.now!r} s"
        if (one.signal, one.field) == ("cycle", "number"):
            return f"number {stamp.number}"
        return one.name.replace("_", " ") if one.name != "missing_cycle" else ""


def _apart(frame: Frame) -> str:
    driving, emergency = frame.candidates[DRIVING], frame.candidates[EMERGENCY]
    dx, dy, turn, faster = (
        float(driving.column(name)[0]) - float(emergency.column(name)[0])
        for name in ("x", "y", "heading", "v")
    )
    return f"{math.sqrt(dx * dx + dy * dy):g} m, {abs(turn):g} rad, {abs(faster):g} m/s apart"


def _key(one: Fault) -> _Key:
    return name_of(one), one.signal, one.field, one.index
