"""One cycle or case in SI units, as every evaluator sees it: columns, sets with their ids, borders, and candidates by name."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from trackmarshal.runtime.contract import FOLLOWED, ID, IS_DRIVEN, IS_EMERGENCY, PLAN
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.faults import UNUSABLE, Fault, name_of
from trackmarshal.runtime.lines import Line

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from trackmarshal.ir.nodes import JudgedAt

    Floats = NDArray[np.float64]
    Flags = NDArray[np.int8]

NAN = math.nan
_LITTLE = sys.byteorder == "little"
_NONE: frozenset[str] = frozenset()


class Names:
    """The columns that a signal has: numbers and flags, each by its row. Frames of one contract share it."""

    __slots__ = ("flags", "numbers", "rows")

    def __init__(self, numbers: Sequence[str], flags: Sequence[str] = ()) -> None:
        self.numbers, self.flags = tuple(numbers), tuple(flags)
        self.rows = {name: row for names in (self.numbers, self.flags) for row, name in enumerate(names)}


class Joined(NamedTuple):
    """What a timeline has besides columns that joins what was driven with what is planned.

    now: the number of the sample that is now. begin, end: (count,) float64, whole nanoseconds from now, when each sample begins and ends: one
    moment, or a gap in which nothing is known. gaps: the numbers of those; missing: how many cycles are missing in each.
    """

    now: int
    begin: Floats
    end: Floats
    gaps: tuple[int, ...]
    missing: tuple[int, ...]


class Columns:
    """A timeline or set, one entry a sample or element, or a record, of one entry.

    values: (numbers, count) float64, NaN for a missing number; flags: (flags, count) int8: 1, 0, and -1 for a missing one. ids: what
    the elements of a set are called. absent: columns that are not there, and need not be. `stack`: what many frames' values were put into, these in its `row`, or None. `joined`: what a course has besides, else None.
    """

    __slots__ = (
        "_listed",
        "_place",
        "_values",
        "absent",
        "count",
        "flags",
        "ids",
        "joined",
        "names",
        "row",
        "stack",
    )

    def __init__(
        self, names: Names, values: Floats, flags: Flags | None = None, ids: tuple[str, ...] = ()
    ) -> None:
        self.names = names
        self._values: Floats | None = values
        self._place: tuple[Floats, int] | None = None
        self.flags = flags
        self.count: int = values.shape[1] if flags is None or names.numbers else flags.shape[1]
        self.ids = ids
        self.absent = _NONE
        self.joined: Joined | None = None
        self.stack: Floats | None = None
        self.row = 0
        #: Made when first asked for: of many frames, most are never asked.
        self._listed: dict[str, list[Any]] | None = None

    @classmethod
    def within(cls, names: Names, arena: Floats, start: int, count: int, ids: tuple[str, ...]) -> Columns:
        """Numbers that stand in an arena from a place on, one column after the other; of most cycles, nobody looks at them there."""
        made = cls.__new__(cls)
        made.names, made.count, made.ids = names, count, ids
        made._values, made._place = None, (arena, start)
        made.flags = made.stack = made.joined = made._listed = None
        made.absent, made.row = _NONE, 0
        return made

    @property
    def values(self) -> Floats:
        if self._values is None:
            assert self._place is not None
            arena, start = self._place
            width = len(self.names.numbers)
            self._values = arena[start : start + width * self.count].reshape(width, self.count)
        return self._values

    def packed(self) -> bytes:
        """The numbers, one column after the other, as little-endian float64."""
        if self._values is None and self._place is not None and _LITTLE:
            arena, start = self._place
            return arena[start : start + len(self.names.numbers) * self.count].tobytes()
        return self.values.astype("<f8").tobytes()

    def column(self, name: str) -> NDArray[Any]:
        """(count,) of a field; the array is the frame's own. Raises KeyError where there is none."""
        row = self.names.rows[name]
        if name in self.names.flags:
            assert self.flags is not None
            return self.flags[row, :]
        return self.values[row, :]

    def listed(self, name: str) -> list[Any]:
        """The same as Python's numbers, or True, False and None."""
        if self._listed is None:
            self._listed = {}
        found = self._listed.get(name)
        if found is None:
            found = self.column(name).tolist()
            if name in self.names.flags:
                found = [None if flag < 0 else flag == 1 for flag in found]
            self._listed[name] = found
        return found

    def name(self, index: int) -> int | str:
        """What reports call an entry: its id, or its number; of a course, counted from the sample that is now."""
        if self.joined is not None:
            return index - self.joined.now
        return self.ids[index] if self.ids else index

    def weight(self, index: int) -> int:
        """How many samples an entry may be: of a gap, as many as cycles are missing."""
        if self.joined is None or index not in self.joined.gaps:
            return 1
        return self.joined.missing[self.joined.gaps.index(index)]

    def place(self, judged: JudgedAt) -> int:
        """The number of the sample at which a rule is judged. Raises ValueError where none is now."""
        if judged == "now":
            if self.joined is None:
                raise ValueError("of this timeline, no sample is now")
            return self.joined.now
        return 0 if judged == "first" else self.count - 1


class Packed(NamedTuple):
    """Columns as memory: how many entries, their ids, and the numbers as little-endian float64, one column after the other."""

    entries: int
    ids: tuple[str, ...]
    numbers: bytes


class Shape(NamedTuple):
    """What arenas have alike.

    called: the signals after the two candidates. names, ids: of each signal; ids are None where elements are counted. floats: bytes as numbers
    of this machine. unchanged: whether all other signals are the very objects that are remembered of an earlier cycle; whole: and there are
    no more.
    """

    called: Sequence[str]
    names: Sequence[Names]
    ids: Sequence[tuple[str, ...] | None]
    floats: Callable[[bytes], Floats]
    unchanged: bool = False
    whole: bool = False


class Arena(NamedTuple):
    """Candidates and columns of a cycle, one signal after the other in the contract's order.

    data: 8 bytes of whoever made it; of each signal where its numbers begin in all these bytes, 0, and how many entries there are, as 64-bit words;
    then the numbers, float64, (fields, entries) of each signal.
    """

    data: bytes
    shape: Shape

    @property
    def begin(self) -> int:
        """Where the numbers begin."""
        return 8 + 24 * len(self.shape.names)

    @property
    def counts(self) -> list[int]:
        """How many entries each signal has."""
        return memoryview(self.data)[: self.begin].cast("q").tolist()[3::3]

    def packed(self) -> list[Packed]:
        """Of each signal, the candidates first."""
        made, (data, shape), end = [], self, self.begin
        for names, ids, count in zip(shape.names, shape.ids, self.counts):
            begin, end = end, end + 8 * count * len(names.numbers)
            known = tuple(map(str, range(count))) if ids is None else ids
            own = data[begin:end]
            if not _LITTLE:
                own = shape.floats(own).astype("<f8").tobytes()
            made.append(Packed(count, known, own))
        return made

    def columns(self) -> list[Columns]:
        """Of each signal, the candidates first."""
        made, (data, shape) = [], self
        words = memoryview(data)[: self.begin].cast("q")
        numbers = shape.floats(data)
        for names, ids, begin, count in zip(shape.names, shape.ids, words[1::3], words[3::3]):
            known = tuple(map(str, range(count))) if ids is None else ids
            made.append(Columns.within(names, numbers, begin // 8, count, known))
        return made


@dataclass(frozen=True, slots=True)
class Settings:
    """What stands in for values of the spec: parameters in SI, tables as knots and values in SI, points of places in m."""

    params: Mapping[str, float] = field(default_factory=dict)
    tables: Mapping[str, tuple[Sequence[float], Sequence[float]]] = field(default_factory=dict)
    places: Mapping[str, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    #: Constraints of the spec that do not hold with these values: nothing that is evaluated with them is safe.
    broken: tuple[str, ...] = ()


NO_SETTINGS = Settings()
NO_ORDERS: frozenset[tuple[str, str]] = frozenset()
#: The borders of a lane.
SIDES = ("left", "right")
#: Faults for which nothing of a signal can be used, whichever field they name.
_WHOLE = {"not_increasing", "wrong_length", "too_short"}


@dataclass(slots=True, eq=False)
class Frame:
    """Signals by name. `candidates`: what stands for `plan`, by candidate; a case has none, its `plan` is among the signals.

    events: 1, 0, and -1 for a missing one. faults: what breaks the contract; a candidate's carry its name in place of `plan`.
    """

    id: object = None
    settings: Settings = NO_SETTINGS
    columns: dict[str, Columns] = field(default_factory=dict)
    events: dict[str, int] = field(default_factory=dict)
    lines: dict[tuple[str, str], Line] = field(default_factory=dict)
    closed: dict[str, bool] = field(default_factory=dict)
    candidates: dict[str, Columns] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    #: Columns (signal, field) that order the samples of their signal.
    orders: frozenset[tuple[str, str]] = NO_ORDERS
    #: Columns (signal, field) of curvatures that a case does not have: what would follow them goes straight.
    straight: frozenset[tuple[str, str]] = frozenset()
    arena: Arena | None = None
    #: The stamp [s]; None of a case that is in no run.
    t: float | None = None
    #: What its cycle is called in a run: its number, or the case's own name.
    number: object = None
    #: Of each set of lanes the left and the right border of every one.
    lanes: dict[str, tuple[tuple[Line, Line], ...]] = field(default_factory=dict)

    @staticmethod
    def unread(
        settings: Settings, arena: Arena, lines: dict[tuple[str, str], Line], closed: dict[str, bool], events: dict[str, int],
    ) -> Frame:  # fmt: skip
        """A cycle in an arena, whose columns are made when somebody asks for them: in most cycles, nobody does."""
        made = Unread.__new__(Unread)
        made.settings, made.arena = settings, arena
        made.lines, made.closed, made.events = lines, closed, events
        return made

    def of(self, candidate: str) -> Frame:
        """The frame as rules see it that rate a candidate: with its `plan`, its own faults and those of what all share."""
        unseen = self.candidates.keys() - {candidate, FOLLOWED}
        columns = {**self.columns, PLAN: self.candidates[candidate]}
        if FOLLOWED in self.candidates:  # else it is among the columns, missing, with a fault that says so
            columns[FOLLOWED] = self.candidates[FOLLOWED]
        faults = [f for f in self.faults if f.signal not in unseen]
        faults += [
            Fault(f.code, PLAN, f.field, f.index, f.message) for f in self.faults if f.signal == candidate
        ]
        told = {IS_EMERGENCY: int(candidate == EMERGENCY), IS_DRIVEN: 1}
        return Frame(
            candidate, self.settings, columns, {**self.events, **told}, self.lines, self.closed, {},
            faults, self.orders, t=self.t, number=self.number, lanes=self.lanes,
        )  # fmt: skip

    def seen(self) -> list[tuple[str, Frame]]:
        """Every candidate with the frame that rates it; a case by itself, with the name ''."""
        return [(name, self.of(name)) for name in self.candidates] if self.candidates else [("", self)]

    # What evaluators ask --------------------------------------------------------------------------------------

    def count(self, signal: str) -> int:
        """How many samples or elements a signal has."""
        return self.columns[signal].count

    def value(self, signal: str, name: str) -> float:
        """A number of a record."""
        return float(self.columns[signal].listed(name)[0])

    def flag(self, signal: str, name: str, index: int = 0) -> bool | None:
        """An event (of no field), or a Boolean of a record, or of a sample (-1: the last); None where it is missing."""
        if name:
            found: bool | None = self.columns[signal].listed(name)[index]
            return found
        event = self.events[signal]
        return None if event < 0 else event == 1

    def line(self, signal: str, name: str) -> Line:
        """A border or line; one of no points where it is missing."""
        return self.lines[signal, name]

    def corridor(self, signal: str) -> tuple[Line, Line, bool]:
        """Left and right border, and whether they are closed."""
        return self.line(signal, "left"), self.line(signal, "right"), self.closed.get(signal, False)

    def unusable(self, reads: Iterable[tuple[str, str]]) -> Fault | None:
        """The fault for which what reads these (signal, field) pairs has no verdict; None where there is none."""
        for fault in self.faults:
            name = name_of(fault)
            # How samples are ordered, and which of them belong together, counts for every rule.
            whole = name in _WHOLE or (fault.signal, fault.field) in self.orders
            if (
                whole
                or name in UNUSABLE
                or fault.field == ID
                or (fault.signal, fault.field) in self.lines
                # A field of a lane beside its borders is a number as any other: where it is missing, what it does not matter to is known.
                or (fault.signal in self.lanes and fault.field in SIDES)
            ):
                for signal, field_ in reads:
                    if signal == fault.signal and (whole or fault.field in ("", field_)):
                        return fault
        return None


class Unread(Frame):
    """A frame of an arena that has nothing yet but that, its settings, lines, closed and events; Supervisors in C make them, too."""

    __slots__ = ()

    def __getattr__(self, name: str) -> Any:
        if name in ("columns", "candidates"):
            driving, emergency, *others = self.arena.columns()  # type: ignore[union-attr]
            self.candidates = {DRIVING: driving, EMERGENCY: emergency}
            self.columns = dict(zip(self.arena.shape.called, others))  # type: ignore[union-attr]
        elif name in _NOT_YET:
            setattr(self, name, _NOT_YET[name]())
        else:
            raise AttributeError(name)
        return getattr(self, name)


#: What a frame of an arena has besides that.
_NOT_YET: dict[str, Callable[[], Any]] = {
    "id": lambda: None, "t": lambda: None, "number": lambda: None, "faults": list, "lanes": dict,
    "orders": lambda: NO_ORDERS, "straight": lambda: NO_ORDERS,
}  # fmt: skip
