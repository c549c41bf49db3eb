"""Cases, as `eval` takes them, through the same door: JSON's plain data in, frames out, many at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.contract import of_cases
from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.checking import FrameChecker
from trackmarshal.runtime.door.columns import suggested
from trackmarshal.runtime.door.reading import SignalsReader, known
from trackmarshal.runtime.faults import Fault, name_of
from trackmarshal.runtime.frame import NO_SETTINGS, Columns, Frame, Settings
from trackmarshal.runtime.settings import SettingsReader

#: What a case may hold.
KEYS = frozenset({"id", "params", "tables", "places", "signals"})
_SETTINGS = ("params", "tables", "places")
#: Cases that are checked together.
AT_ONCE = 256
_MISSING = "null stands for a missing value; numbers are in the declared unit"


class CasesReader:
    """Reads cases for one spec; `reads` are the (signal, field) pairs that the chosen rules need.

    declared: names (`objects`, `ego.kappa`) that data may have besides those of the spec, asked for only when one turns up. broken: which constraints of
    the spec do not hold with settings.
    """

    def __init__(
        self, spec: Spec, reads: Iterable[tuple[str, str]], declared: Callable[[], frozenset[str]] = frozenset,
        broken: Callable[[Settings], tuple[str, ...]] = lambda _: (),
    ) -> None:  # fmt: skip
        self.contract = of_cases(spec, reads)
        self._settings = SettingsReader(spec)
        self._reader = SignalsReader(self.contract, spelt=True)
        self._checker = FrameChecker(self.contract)
        self._declared, self._broken = declared, broken
        self._own: Settings | None = None
        self._orders = frozenset(
            (signal.name, field.name)
            for signal in self.contract.signals
            for field in signal.fields_
            if any(check.kind.of == "step" for check in field.checks)
        )
        self._ordered = {signal for signal, _ in self._orders}

    def read(self, raw: object) -> Frame:
        """A case from plain data; raises TrackmarshalError D201 to D204."""
        return self.read_all([raw])[0]

    def read_all(self, raws: Iterable[object]) -> list[Frame]:
        """Cases from plain data, in order; raises what the first of them that cannot be read raises."""
        frames: list[Frame] = []
        chunk: list[Frame] = []
        for raw in raws:  # each is read before the next is asked for: it may be made in the same memory
            chunk.append(self._structure(raw))
            if len(chunk) == AT_ONCE:
                frames += self._checked(chunk)
                chunk = []
        return frames + self._checked(chunk)

    def _checked(self, chunk: list[Frame]) -> list[Frame]:
        passed = self._together(chunk)
        for frame in chunk:
            broken = {f.signal for f in frame.faults}
            self._checker.check_signals(frame, broken, frame.faults, passed)
            for name in broken & self._ordered:
                # A column that is missing says nothing of the others; without order in time, none of them means anything.
                found: list[Fault] = []
                self._checker.columns[name].check(frame.columns[name], found)
                frame.faults += [fault for fault in found if name_of(fault) == "not_increasing"]
        return chunk

    def settings(self, data: Mapping[str, Any]) -> Settings:
        """Overrides from plain data, with the constraints that do not hold with them; raises TrackmarshalError."""
        given = [data.get(key) for key in _SETTINGS]
        if all(value is None or (isinstance(value, Mapping) and not value) for value in given):
            if self._own is None:
                self._own = Settings(broken=self._broken(NO_SETTINGS))
            return self._own
        read = self._settings.read(data)
        return Settings(read.params, read.tables, read.places, self._broken(read))

    def _structure(self, raw: object) -> Frame:
        if not isinstance(raw, Mapping):
            help_ = 'write {"id": 1, "signals": {...}}'
            raise TrackmarshalError("D201", f"the case is an object, not {values.worded(raw)}", help=help_)
        for key in raw:
            if key not in KEYS:
                name = key[:40] if isinstance(key, str) else values.worded(key)
                hint = suggested(name, KEYS) or f"it may have {', '.join(sorted(KEYS))}"
                raise TrackmarshalError("D203", f"a case has no `{name}`", help=hint)
        signals = raw.get("signals", {})
        if not isinstance(signals, Mapping):
            help_ = "write it as {...}; leave it out if there is none"
            raise TrackmarshalError(
                "D202", f"`signals` is an object, not {values.worded(signals)}", help=help_
            )
        frame = Frame(raw.get("id"), self.settings(raw), orders=self._orders)
        given = signals if type(signals) is dict else dict(signals)
        self._reader.refuse_unknown(given, frame.faults, self.contract.known)
        self._reader.read(given, frame, frame.faults)
        if any(name_of(fault) == "unknown" for fault in frame.faults):
            also = self._declared()
            frame.faults = [fault for fault in frame.faults if not known(fault, also)]
        for fault in frame.faults:
            _refuse(fault)
        return frame

    def _together(self, frames: Sequence[Frame]) -> frozenset[str]:
        """Put the numbers of all frames into one array a signal, where they have the same size; which signals passed all checks."""
        passed = set()
        if len(frames) < 2:
            return frozenset()
        for name in self._reader.columns:
            own = [frame.columns[name] for frame in frames]
            first = own[0]
            if first.flags is not None or any(columns.count != first.count for columns in own):
                continue
            stack = np.array([columns.values for columns in own])
            if not self._checker.columns[name].all_fine(stack, first.count):
                continue
            stack.flags.writeable = False
            for place, (frame, columns) in enumerate(zip(frames, own)):
                frame.columns[name] = made = Columns(columns.names, stack[place], None, columns.ids)
                made.stack = stack, place
            passed.add(name)
        return frozenset(passed)


def _refuse(fault: Fault) -> None:
    """Raise for what makes a case unreadable: something of a wrong type, or a name that nothing declares."""
    name = name_of(fault)
    if name not in ("wrong_type", "unknown"):
        return
    place = fault.signal + (f".{fault.field}" if fault.field else "")
    place += "" if fault.index is None else f"[{fault.index}]"
    if name == "wrong_type":
        raise TrackmarshalError("D202", f"{place}: {fault.message}", help=_MISSING)
    message, _, hint = fault.message.partition("; ")
    raise TrackmarshalError(
        "D203", f"{fault.signal}: {message}", help=hint or "the spec's signals say what there may be"
    )
