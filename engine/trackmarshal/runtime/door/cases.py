"""Cases, as `eval` takes them, through the same door: JSON's plain data in, frames out, many at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.contract import of_cases
from trackmarshal.runtime.contract.tracks import Places
from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.checking import FrameChecker
from trackmarshal.runtime.door.reading import SignalsReader, known
from trackmarshal.runtime.door.stacks import Stacks
from trackmarshal.runtime.door.unknown import suggested
from trackmarshal.runtime.faults import Fault, name_of
from trackmarshal.runtime.frame import NO_SETTINGS, Frame, Settings
from trackmarshal.runtime.settings import SettingsReader

#: What a case may hold.
KEYS = frozenset({"id", "t", "params", "tables", "places", "signals"})
_SETTINGS = ("params", "tables", "places")
#: Cases that are checked together; as many as are evaluated together, so that evaluation finds their numbers in one array.
AT_ONCE = 500
_MISSING = "null stands for a missing value; numbers are in the declared unit"
_COLUMN = (
    "a column is a list, or an array of numbers with one axis; arrays of many cases are for `Evaluator.batch`"
)


class CasesReader:
    """Reads cases for one spec; `reads` are the (signal, field) pairs that the chosen rules need.

    declared: names (`objects`, `ego.kappa`) that data may have besides those of the spec, asked for only when one turns up. broken: which constraints of
    the spec do not hold with settings. places: those of named tracks that the rules read.
    """

    def __init__(
        self, spec: Spec, reads: Iterable[tuple[str, str]], declared: Callable[[], frozenset[str]] = frozenset,
        broken: Callable[[Settings], tuple[str, ...]] = lambda _: (), places: Places = (),
    ) -> None:  # fmt: skip
        self.contract = of_cases(spec, reads, places)
        self._settings = SettingsReader(spec)
        self.reader = SignalsReader(self.contract, spelt=True)
        self._stacks = {name: Stacks(reader) for name, reader in self.reader.columns.items()}
        self._checker = FrameChecker(self.contract)
        self._declared, self._broken = declared, broken
        self._own: Settings | None = None
        self.orders = frozenset(
            (signal.name, field.name)
            for signal in self.contract.signals
            for field in signal.fields_
            if any(check.kind.of == "step" for check in field.checks)
        )

    def read(self, raw: object) -> Frame:
        """A case from plain data; raises TrackmarshalError D201 to D204."""
        return self.read_all([raw])[0]

    def read_all(self, raws: Iterable[object]) -> list[Frame]:
        """Cases from plain data, in order; raises what the first of them that cannot be read raises."""
        frames: list[Frame] = []
        chunk: list[Frame] = []
        for stacks in self._stacks.values():
            stacks.clear()
        for raw in raws:  # each is read before the next is asked for: it may be made in the same memory
            chunk.append(self._structure(raw, len(chunk)))
            if len(chunk) == AT_ONCE:
                frames += self._checked(chunk)
                chunk = []
        return frames + self._checked(chunk)

    def _checked(self, chunk: list[Frame]) -> list[Frame]:
        for frame, passed in zip(chunk, self._together(chunk)):
            self.check(frame, passed)
        return chunk

    def check(self, frame: Frame, passed: Set[str] = frozenset()) -> None:
        """Add what is wrong with the values of a frame to its faults; signals that have `passed` already are left out."""
        if not frame.faults:
            self._checker.check_signals(frame, set(), frame.faults, passed)
            return
        named = {(f.signal, f.field) for f in frame.faults}
        broken = {signal for signal, _ in named}
        self._checker.check_signals(frame, broken, frame.faults, passed)
        for name in broken & self._checker.columns.keys():
            if (name, "") in named:
                continue  # no rule can use any of it
            # A column that is missing says nothing of the others, which rules may read that do not read it.
            found: list[Fault] = []
            self._checker.columns[name].check(frame.columns[name], found)
            frame.faults += [fault for fault in found if (name, fault.field) not in named]

    def fine(self, name: str, stack: Any, count: int, flags: Any = None) -> bool:
        """Whether nothing is wrong with a signal of columns in many frames: (frames, numbers, count), (frames, flags, count)."""
        return self._checker.columns[name].all_fine(stack, count, flags)

    def each_fine(self, name: str, stack: Any, count: int, flags: Any = None) -> Any:
        """(frames,): the same of each frame by itself."""
        return self._checker.columns[name].each_fine(stack, count, flags)

    def settings(self, data: Mapping[str, Any]) -> Settings:
        """Overrides from plain data, with the constraints that do not hold with them; raises TrackmarshalError."""
        given = [] if data.keys().isdisjoint(_SETTINGS) else [data.get(key) for key in _SETTINGS]
        if all(value is None or (isinstance(value, Mapping) and not value) for value in given):
            if self._own is None:
                self._own = Settings(broken=self._broken(NO_SETTINGS))
            return self._own
        read = self._settings.read(data)
        return Settings(read.params, read.tables, read.places, self._broken(read))

    def _structure(self, raw: object, place: int) -> Frame:
        if type(raw) is not dict and not isinstance(raw, Mapping):
            help_ = 'write {"id": 1, "signals": {...}}'
            raise TrackmarshalError("D201", f"the case is an object, not {values.worded(raw)}", help=help_)
        for key in raw:
            if key not in KEYS:
                name = key[:40] if isinstance(key, str) else values.worded(key)
                hint = suggested(name, KEYS) or f"it may have {', '.join(sorted(KEYS))}"
                if key in self.contract.known:
                    hint = f'signals stand under `signals`: {{"signals": {{"{name}": ...}}}}'
                raise TrackmarshalError("D203", f"a case has no `{name}`", help=hint)
        signals = raw.get("signals", {})
        if type(signals) is not dict and not isinstance(signals, Mapping):
            help_ = "write it as {...}; leave it out if there is none"
            raise TrackmarshalError(
                "D202", f"`signals` is an object, not {values.worded(signals)}", help=help_
            )
        frame = Frame(
            raw.get("id"),
            self.settings(raw),
            orders=self.orders,
            t=_stamp(raw.get("t")),
            number=raw.get("id"),
        )
        given = signals if type(signals) is dict else dict(signals)
        if not given.keys() <= self.contract.known:
            self.reader.refuse_unknown(given, frame.faults, self.contract.known)
        self.reader.read_later(given, frame, frame.faults, self._stacks, place)
        if frame.faults:
            frame.faults = self.refused(frame.faults)
        return frame

    def refused(self, faults: list[Fault]) -> list[Fault]:
        """Faults of structure without those of names that are known after all; raises for what makes a case unreadable."""
        if any(name_of(fault) == "unknown" for fault in faults):
            also = self._declared()
            faults = [fault for fault in faults if not known(fault, also)]
        for fault in faults:
            _refuse(fault)
        return faults

    def _together(self, frames: Sequence[Frame]) -> list[set[str]]:
        """Put columns in place that were read together; which signals of each frame passed all checks by that."""
        passed: list[set[str]] = [set() for _ in frames]
        for name, stacks in self._stacks.items():
            checker = self._checker.columns[name]
            for stack, places, columns in stacks.finish():
                fine = checker.all_fine(stack, stack.shape[2])
                for place, made in zip(places, columns):
                    frames[place].columns[name] = made
                    if fine:
                        passed[place].add(name)
        return passed


def _stamp(raw: object) -> float | None:
    """The stamp of a case that is a cycle of a run [s]; raises D202 for what is no number."""
    t = None if raw is None else values.number(raw)
    if t is None and raw is not None:
        raise TrackmarshalError(
            "D202", f"`t` is a number, not {values.worded(raw)}", help="it is the cycle's stamp, in s"
        )
    return t


def _refuse(fault: Fault) -> None:
    """Raise for what makes a case unreadable: something of a wrong type, or a name that nothing declares."""
    name = name_of(fault)
    if name not in ("wrong_type", "unknown"):
        return
    place = fault.signal + (f".{fault.field}" if fault.field else "")
    place += "" if fault.index is None else f"[{fault.index}]"
    if name == "wrong_type":
        help_ = _COLUMN if fault.message.startswith("something else is no column") else _MISSING
        raise TrackmarshalError("D202", f"{place}: {fault.message}", help=help_)
    message, _, hint = fault.message.partition("; ")
    raise TrackmarshalError(
        "D203", f"{fault.signal}: {message}", help=hint or "the spec's signals say what there may be"
    )
