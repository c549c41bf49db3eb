"""From what a caller hands in to a frame: each signal by its reader. Faults of structure are found here, for all backends alike."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from trackmarshal.runtime.contract import EVENT, FOLLOWED, LINES, PLAN, SET, Contract, Signal
from trackmarshal.runtime.contract.tracks import elsewhere
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle
from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.at_once import AtOnce, Remembered
from trackmarshal.runtime.door.columns import ColumnsReader
from trackmarshal.runtime.door.lanes import LanesReader
from trackmarshal.runtime.door.lines import NOWHERE, LineReader, NoLineError
from trackmarshal.runtime.door.stacks import Stacks
from trackmarshal.runtime.door.unknown import refuse_unknown
from trackmarshal.runtime.door.values import WrongTypeError
from trackmarshal.runtime.faults import Fault, fault, name_of
from trackmarshal.runtime.frame import NO_SETTINGS, Columns, Frame, Names, Settings
from trackmarshal.runtime.lines import Line

#: Kinds of what nobody can change.
_FROZEN = {Line, bool, str}
#: Columns that are still to come.
LATER = Columns(Names(()), np.zeros((0, 0)))


class LinesReader:
    """Reads a signal of lines: a polyline, or a corridor with its borders and whether they are closed."""

    def __init__(self, signal: Signal) -> None:
        self.signal = signal
        self._readers = {field.name: LineReader() for field in signal.lines}
        self._known = signal.declared | {field.name for field in signal.lines} | {"closed", "name"}
        self._places = [(line, (signal.name, line), reader) for line, reader in self._readers.items()]

    def read(self, raw: Any, frame: Frame, faults: list[Fault]) -> None:
        if type(raw) is dict and raw.keys() <= self._known and self._unchanged(raw, frame):
            return
        name = self.signal.name
        before = len(faults)
        for line in self._readers:
            frame.lines[name, line] = NOWHERE
        try:
            if "" in self._readers:
                self._line("", raw, frame, faults)
                return
            if raw is None:
                faults.append(fault("missing", name, "", None, "it is not there"))
                return
            data = raw if type(raw) is dict else values.mapping(raw)
            if not data.keys() <= self._known:
                refuse_unknown(name, [data], self._known, faults)
            closed = values.flag(data.get("closed", False))
            if closed in (0, 1):
                frame.closed[name] = closed == 1
            else:
                faults.append(fault("wrong_type", name, "closed", None, "neither true nor false"))
            for line in self._readers:
                self._line(line, data.get(line), frame, faults)
        except WrongTypeError as error:
            faults.append(fault("wrong_type", name, "", None, error.message))
        except Exception:  # what was handed in has a say in how it is read
            del faults[before:]
            faults.append(fault("wrong_type", name, "", None, "it cannot be read"))

    def _unchanged(self, raw: dict[Any, Any], frame: Frame) -> bool:
        """Read a corridor whose borders are the very lines that were read last; false for any other."""
        closed = raw.get("closed", False)
        if closed is not True and closed is not False:
            return False
        for name, place, reader in self._places:
            given = raw.get(name)
            if type(given) is not Line or given is not reader.same:
                return False
            frame.lines[place] = given
        frame.closed[self.signal.name] = closed
        return True

    def _line(self, line: str, raw: Any, frame: Frame, faults: list[Fault]) -> None:
        place = self.signal.name, line
        if raw is None:
            faults.append(fault("missing", *place, None, "it is not there"))
            return
        try:
            frame.lines[place] = self._readers[line].read(raw)
        except NoLineError as error:
            faults.append(fault(error.name, *place, error.index, error.message))


class SignalsReader:
    """Reads all signals of a contract but the candidates."""

    def __init__(self, contract: Contract, spelt: bool = False) -> None:
        columns = [s for s in contract.signals if s.form not in (LINES, EVENT)]
        self.columns = {s.name: ColumnsReader(s, spelt=spelt) for s in columns}
        self.lines = {s.name: LinesReader(s) for s in contract.signals if s.form == LINES}
        self.lanes = {s.name: LanesReader(s) for s in contract.signals if s.form == SET and s.lines}
        self.events = [s.name for s in contract.signals if s.form == EVENT]
        self._places = contract.places
        self._corridors = contract.corridors
        #: Those whose borders no rule reads: what is asked of them is the name.
        self._unread = [name for name in contract.corridors if name not in self.lines]

    def read(self, raw: dict[Any, Any], frame: Frame, faults: list[Fault]) -> None:
        """Put the signals into a frame. What the spec declares and no rule reads is left out."""
        for name, reader in self.columns.items():
            frame.columns[name] = reader.read(raw.get(name), faults)
        self.read_others(raw, frame, faults)

    def read_later(
        self, raw: dict[Any, Any], frame: Frame, faults: list[Fault], stacks: dict[str, Stacks], place: int
    ) -> None:
        """The same, but that columns may be left to `stacks`, where this frame has a place."""
        for name, reader in self.columns.items():
            one = raw.get(name)
            # Signals are in order, also where the columns come later.
            frame.columns[name] = LATER if stacks[name].take(one, place) else reader.read(one, faults)
        self.read_others(raw, frame, faults)

    def read_others(self, raw: dict[Any, Any], frame: Frame, faults: list[Fault]) -> None:
        """Put lines and events into a frame."""
        for name, lines in self.lines.items():
            lines.read(raw.get(name), frame, faults)
        for name, lanes in self.lanes.items():
            lanes.read(raw.get(name), frame, faults)
        for name in self.events:
            frame.events[name] = self.event(name, raw.get(name), faults)
        if self._corridors:
            self.same_track(raw, frame.settings, faults)

    def remembered(self, raw: dict[Any, Any]) -> Remembered | None:
        """What the lines, events and names of tracks are that were read without a fault, as (name, names within, objects), where nobody can change
        any of that; else None."""
        found = []
        for name in (*self.lines, *self.events, *self._unread):
            one = raw.get(name)
            names, objects = (tuple(one), tuple(one.values())) if type(one) is dict else ((), (one,))
            if _FROZEN.issuperset(map(type, objects)) and {str}.issuperset(map(type, names)):
                found.append((name, names, objects))
            elif name not in self._unread:
                return None
            # Borders that nobody reads keep no cycle from being the same; what the track is called is looked at in each that has more than that.
        return None if self.lanes else tuple(found)

    def same_track(self, raw: Mapping[Any, Any], settings: Settings, faults: list[Fault]) -> None:
        """A fault where the data names a track by no text, or one that the places which rules read are not on."""
        for signal in self._corridors:
            given = raw.get(signal)
            try:
                name = None if given is None else values.mapping(given).get("name")
            except Exception:  # what was handed in has a say in how it is read
                continue  # whoever reads it says what is wrong
            if name is None:
                continue
            if not isinstance(name, str):
                faults.append(fault("wrong_type", signal, "name", None, "the name of a track is a text"))
                continue
            problem = elsewhere(self._places, str(name), settings.places.keys())
            if problem:
                faults.append(fault("wrong_track", signal, "name", None, problem))

    def refuse_unknown(self, raw: dict[Any, Any], faults: list[Fault], known: frozenset[str]) -> None:
        """Faults of signals that nothing declares."""
        refuse_unknown("signals", [raw], known, faults)

    @staticmethod
    def event(name: str, raw: Any, faults: list[Fault]) -> int:
        """An event as 1, 0, and -1 for a missing one."""
        found = values.flag(raw)
        if raw is None:
            faults.append(fault("missing", name, "", None, "it is not there"))
        elif found is None:
            faults.append(
                fault("wrong_type", name, "", None, f"{values.worded(raw)} is neither true nor false")
            )
        return -1 if found is None else found


#: Whether nothing is wrong with a signal in many frames: its name, (frames, numbers, count), and how many entries it has.
Passes = Callable[[str, Any, int], bool]


class Read(NamedTuple):
    """A cycle as a frame, what is wrong with its structure, and the signals that passed all checks of their values already."""

    frame: Frame
    faults: list[Fault]
    passed: set[str]


class CycleReader:
    """Reads cycles of one contract."""

    def __init__(
        self, contract: Contract, settings: Settings = NO_SETTINGS,
        at_once: Callable[[Sequence[ColumnsReader]], AtOnce] = AtOnce,
    ) -> None:  # fmt: skip
        assert contract.plan is not None
        self.settings = settings
        self.candidates = [(name, ColumnsReader(contract.plan, name)) for name in (DRIVING, EMERGENCY)]
        self.shared = SignalsReader(contract)
        #: What reads most cycles.
        self.at_once = at_once([reader for _, reader in self.candidates] + list(self.shared.columns.values()))
        #: Signals that a cycle may bring; the candidates come by themselves.
        self._known = contract.known - {PLAN, FOLLOWED}
        #: Whether a signal has the name of a candidate.
        self._called_alike = not self.shared.columns.keys().isdisjoint((DRIVING, EMERGENCY))
        #: Lines, whether they are closed, and events of the cycle that is remembered.
        self._others: tuple[dict[tuple[str, str], Line], dict[str, bool], dict[str, int]] = {}, {}, {}

    def read(self, cycle: Cycle) -> tuple[Frame, list[Fault]]:
        """The frame of a cycle, and what is wrong with the structure of it: types, what is missing, lengths that differ, misspelt
        names. Number and stamp are not in it."""
        faults: list[Fault] = []
        signals, others = cycle.signals, self._others
        if type(signals) is dict:
            arena = self.at_once.read(cycle.driving, cycle.emergency, signals)
            if arena is not None and (arena.shape.whole or signals.keys() <= self._known):
                if arena.shape.unchanged:
                    if not arena.shape.whole:
                        self.shared.same_track(signals, self.settings, faults)
                    return Frame.unread(self.settings, arena, *others), self._but_known(cycle, faults)
                frame = Frame.unread(self.settings, arena, {}, {}, {})
                self.shared.read_others(signals, frame, faults)
                if self.at_once.remembers and not faults:
                    self.at_once.remembered = self.shared.remembered(signals)
                    self._others = frame.lines, frame.closed, frame.events
                return frame, self._but_known(cycle, faults)
        read = self._closely(cycle, Frame(settings=self.settings), faults)
        self.at_once.learn()
        return read

    def read_all(self, cycles: Sequence[Cycle], passes: Passes) -> list[Read]:
        """The same of many cycles, cheaper: numbers of a signal that are alike in many of them are read and checked together."""
        stacks: dict[str, Stacks] = {}
        also: Any = None
        found: list[Read] = []
        for place, cycle in enumerate(cycles):
            if type(cycle.signals) is not dict or type(cycle.also) is not frozenset or self._called_alike:
                found.append(Read(*self.read(cycle), set()))
                continue
            if cycle.also is not also:  # a recording has the same for all its cycles
                self._finish(stacks, found, passes)
                also = cycle.also
                readers = [*self.candidates, *self.shared.columns.items()]
                stacks = {name: Stacks(reader, spare(name, also)) for name, reader in readers}
            frame, faults = Frame(settings=self.settings), list[Fault]()
            for (name, reader), raw in zip(self.candidates, (cycle.driving, cycle.emergency)):
                frame.candidates[name] = (
                    LATER if stacks[name].take(raw, place) else for_good(reader.read(raw, faults))
                )
            self.shared.refuse_unknown(cycle.signals, faults, self._known)
            self.shared.read_later(cycle.signals, frame, faults, stacks, place)
            found.append(Read(frame, self._but_known(cycle, faults), set()))
        self._finish(stacks, found, passes)
        return found

    def _finish(self, stacks: dict[str, Stacks], found: list[Read], passes: Passes) -> None:
        """Put columns in place that were read together."""
        for name, one in stacks.items():
            for stack, places, columns in one.finish():
                fine = passes(name, stack, stack.shape[2])
                for place, made in zip(places, columns):
                    frame, _, passed = found[place]
                    into = frame.candidates if name in frame.candidates else frame.columns
                    into[name] = made
                    if fine:
                        passed.add(name)

    def _closely(self, cycle: Cycle, frame: Frame, faults: list[Fault]) -> tuple[Frame, list[Fault]]:
        given: dict[str, Columns] = frame.candidates
        for (name, reader), raw in zip(self.candidates, (cycle.driving, cycle.emergency)):
            given[name] = for_good(reader.read(raw, faults))
        try:
            signals = values.mapping(cycle.signals)
        except Exception:
            name = "missing" if cycle.signals is None else "wrong_type"
            faults.append(fault(name, "signals", "", None, "the signals are no object"))
            signals = {}
        else:
            self.shared.refuse_unknown(signals, faults, self._known)
        self.shared.read(signals, frame, faults)
        return frame, self._but_known(cycle, faults)

    @staticmethod
    def _but_known(cycle: Cycle, faults: list[Fault]) -> list[Fault]:
        """The faults but for names that whoever made the cycle knows of."""
        if faults and cycle.also and type(cycle.also) is frozenset:
            return [fault for fault in faults if not known(fault, cycle.also)]
        return faults


def for_good(columns: Columns) -> Columns:
    """Columns that nobody changes any more: what is driven is what was judged."""
    columns.values.setflags(write=False)
    return columns


def spare(label: str, also: frozenset[str]) -> frozenset[str]:
    """Of names such as `ego.kappa` those of the fields of one signal."""
    return frozenset(name.partition(".")[2] for name in also if name.startswith(f"{label}."))


def known(fault: Fault, also: frozenset[str]) -> bool:
    """Whether it is the fault of a name that is known after all."""
    name = fault.field if fault.signal == "signals" else f"{fault.signal}.{fault.field}"
    return name_of(fault) == "unknown" and name in also
