"""A Supervisor in C as Python calls it: one context and its buffers, one call a cycle, numbers in SI."""

from __future__ import annotations

import ctypes
import struct
from array import array
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.c.build import library, loaded
from trackmarshal.backends.c.calling import Calling
from trackmarshal.backends.c.capacities import capacities, of_limits
from trackmarshal.backends.c.library import aligned
from trackmarshal.backends.c.over_run.numbering import Numbering, lasting
from trackmarshal.backends.c.said import NO_INDEX, CFault, CReason, Floats, Reason, Said
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.supervised.binding import SAID, words
from trackmarshal.backends.c.supervised.interface import FAULT_NAMES, LASTING, LIMITS, in_force
from trackmarshal.backends.c.supervised.lanes import Lanes, as_many
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.door.lines import NOWHERE
from trackmarshal.runtime.frame import Arena, Columns
from trackmarshal.runtime.lines import Line

#: Statuses of a configuration by number, those that can be.
STATUSES = {3: "unusable", 5: "limit", 6: "parameter", 7: "table", 8: "constraint"}
#: The address of nothing in particular, where something is said to be.
_NOTHING = ctypes.c_double()
_SOMEWHERE = ctypes.addressof(_NOTHING)
#: What a context may take.
_MOST_BYTES = 1 << 30


class Stepper:
    """One context. limits: by name, the capacities `samples`, `elements` and `border` among them; parameters and tables by their
    qualified names, in SI, in place of the spec's. clock: s, called when the rules are done; NaN is put in where it raises.

    Raises TrackmarshalError E471 or E472 without a compiler, E473 for a configuration that C refuses.
    """

    takes_arenas = True

    def __init__(
        self, source: Source, limits: Mapping[str, float], clock: Callable[[], float], params: Mapping[str, float] | None = None,
        tables: Mapping[str, tuple[Sequence[float], Sequence[float]]] | None = None,
    ) -> None:  # fmt: skip
        given = source.supervised
        if given is None:
            raise ValueError("the program is the rules alone")
        self.source = source
        self.words = words(given)
        knots = max((len(rows[0]) for rows in (tables or {}).values()), default=0)
        declared = of_limits(source.plan.spec, limits, knots)
        self.sizes = {name: declared[name] for name in capacities(source.plan, given)}
        #: The library that it is in.
        self.path = path = library(source, self.sizes)
        #: Which program this is: its name has the hash of its source and of its code.
        self.program = path.name
        self._dll = dll = loaded(path)
        size, pointer = ctypes.c_size_t, ctypes.c_void_p
        for name, kinds, result in (
            ("tmg_size", [], size), ("tmg_decision_size", [], size), ("tmg_reasons", [], size), ("tmg_reason_size", [], size),
            ("tmg_stored", [size], size), ("tmg_lasting", [size, pointer], size), ("tmg_init", [pointer], ctypes.c_int),
            ("tmg_configure", [pointer] * 7, ctypes.c_int),
            ("tmg_step", [pointer], None),
        ):  # fmt: skip
            getattr(dll, name).argtypes, getattr(dll, name).restype = kinds, result
        if dll.tmg_reason_size() != ctypes.sizeof(CReason):
            raise AssertionError("the compiler lays structs out differently than ctypes")
        if dll.tmg_size() > _MOST_BYTES:
            raise TrackmarshalError(
                "E473",
                f"the context takes {dll.tmg_size() >> 20} MiB, more than {_MOST_BYTES >> 20}",
                help="lower the limits, or shorten windows",
            )
        self._memory, self.context = aligned(dll.tmg_size())
        self._place = self.context - ctypes.addressof(self._memory)
        self._decision, decision = aligned(dll.tmg_decision_size())
        self._reasons = decision + dll.tmg_reasons()
        self._head, self._middle, self._tail = map(struct.Struct, self.words.formats)
        #: All words of a cycle.
        self._in = bytearray(self.width)
        self._before = self._head.size + self._middle.size
        #: Lines, ids, lanes, closed and events, of which the words are the last ones of `_in`; None where they are not there.
        self._rest: tuple[Any, ...] | None = None
        self._named = [self.words.place(name) for name in self.words.ids]
        if self._named or self.words.lanes:
            self.takes_arenas = (
                False  # how many elements there are, and what they are called, is told by columns
            )
        self._numbering = Numbering(lasting(source.plan.spec))
        self._ids: list[array[int]] = []
        self._said = struct.Struct("=" + "".join(kind for _, kind in SAID))
        count = len(source.rules)
        #: Bytes of margins and verdicts.
        self.outcome = 18 * count
        # What is said of a step, its margins and its verdicts, side by side.
        together = ctypes.create_string_buffer(self._said.size + self.outcome)
        self._out = (ctypes.c_char * self._said.size).from_buffer(together)
        begin = self._said.size, self._said.size + 16 * count
        #: (2, rules) margins and verdict codes (places in runtime.verdict.VERDICTS) of the last step; driving first.
        self.margins = np.frombuffer(memoryview(together), np.float64, 2 * count, begin[0]).reshape(2, count)
        self.verdicts = np.frombuffer(memoryview(together), np.int8, 2 * count, begin[1]).reshape(2, count)
        self.margins[:], self.verdicts[:] = np.nan, 2
        self._most = max(self.sizes.get(name, 1) for name in ("TM_MAX_SAMPLES", "TM_MAX_ELEMENTS"))
        fields = [item.fields for item in source.plan.inputs.values() if item.kind != "event"]
        width = sum(map(len, fields)) + len(given.plan.fields)
        self._numbers = np.zeros(max(1, width * self._most))
        self._flags = np.zeros(max(1, width * self._most), dtype=np.int8)
        self._bases = self._numbers.ctypes.data, self._flags.ctypes.data
        #: Words of lanes, which are read in the step.
        self._lanes: list[array[int]] = []
        self._lines: list[tuple[Line | None, int, int]] = [(None, 0, 0)] * len(self.words.lines)
        #: Texts of faults that were found before; reasons speak of them up to the next step.
        self._kept: Any = None
        #: All that a call needs, in one place.
        self._where = np.zeros(8, dtype=np.uint64)
        where_in = ctypes.addressof(ctypes.c_char.from_buffer(self._in))
        step = ctypes.cast(dll.tmg_step, pointer).value or 0
        self._calling = Calling(step, self.bound, where_in, len(self.words.columns), clock)
        self._where[:] = (
            self.context, where_in, self._calling.clock, decision, ctypes.addressof(self._out), self.margins.ctypes.data,
            self.verdicts.ctypes.data, self._calling.user,
        )  # fmt: skip
        self._run = self._calling.step
        at, _ = self.lasting[LASTING.index("serial")]
        #: How many steps were taken, where C counts them.
        self.serial = memoryview(self._memory).cast("B")[self._place + at :][:8].cast("Q")
        dll.tmg_init(self.context)
        self._configure(limits, params or {}, tables or {})

    def _configure(
        self,
        limits: Mapping[str, float],
        params: Mapping[str, float],
        tables: Mapping[str, tuple[Sequence[float], Sequence[float]]],
    ) -> None:
        spec, plan = self.source.plan.spec, self.source.plan
        held = np.array([limits[name] for name in LIMITS], dtype=np.float64)
        values = np.array([*in_force(plan, params, limits).values()] or [0.0])
        rows = [tables.get(name, (spec.tables[name].knots, spec.tables[name].values)) for name in plan.tables]
        columns = [[np.array(row[i], dtype=np.float64) for row in rows] for i in (0, 1)]
        addresses = [
            np.array([column.ctypes.data for column in each] or [0], dtype=np.uint64) for each in columns
        ]
        counts = np.array([len(column) for column in columns[0]] or [0], dtype=np.uint64)
        which = ctypes.c_char_p()
        given = (held, values, *addresses, counts)
        status = self._dll.tmg_configure(
            self.context, *(each.ctypes.data for each in given), ctypes.addressof(which)
        )
        if status:
            what = STATUSES.get(status, "value")
            name = (which.value or b"").decode()
            raise TrackmarshalError(
                "E473", f"the generated Supervisor refuses the {what} `{name}`", help="change it"
            )

    # For whoever calls the step from C -------------------------------------------------------------------------

    @property
    def function(self) -> Any:
        """The binding's step, a C function of the address `bound`."""
        return self._dll.tmg_step

    @property
    def bound(self) -> int:
        """Where the addresses are that a step is called with: of the context, a cycle's words, ... (`binding`)."""
        return int(self._where.ctypes.data)

    @property
    def width(self) -> int:
        """Bytes of a cycle's words."""
        return self._head.size + self._middle.size + self._tail.size

    @property
    def answer(self) -> int:
        """The address of what is said of the last step, the words of `binding.SAID`, with margins and verdicts behind it."""
        return ctypes.addressof(self._out)

    @property
    def calling(self) -> Calling:
        """What Python calls the step by."""
        return self._calling

    @property
    def judged(self) -> int:
        """The address of the word that says whether the last cycle was judged."""
        return ctypes.addressof(self._out) + 8 * [name for name, _ in SAID].index("judged")

    def bind_clock(self, address: int) -> None:
        """Take the C function at an address for the clock."""
        self._where[2] = address

    def pack(
        self, words: NDArray[np.uint8], columns: Sequence[Columns], lines: Sequence[Line], closed: Sequence[bool] = (),
        events: Sequence[int] = (),
    ) -> None:  # fmt: skip
        """The words of a cycle that came, number and stamp 0, whose columns are read where they are. Raises AssertionError for a program
        that knows elements again."""
        if self.words.ids or self.words.lanes:
            raise AssertionError("elements that are known again have more words")
        own: list[Any] = []
        for entry in columns:
            flags = 0 if entry.flags is None else entry.flags.ctypes.data
            own += (entry.values.ctypes.data, flags, entry.count)
        borders: list[Any] = []
        self._bordered(lines, borders)
        head, tail = self._head.pack(1, 1, 1, 0, 0.0, 0.0, 0, 0), self._tail.pack(*borders, *closed, *events)
        words[: self.width] = np.frombuffer(head + self._middle.pack(*own) + tail, dtype=np.uint8)

    # What a step leaves to the next ------------------------------------------------------------------------------

    @cached_property
    def lasting(self) -> list[tuple[int, int]]:
        """Where it stands in the context, and how many bytes each part of it has."""
        found: list[tuple[int, int]] = []
        size = ctypes.c_size_t()
        while True:
            at = int(self._dll.tmg_lasting(len(found), ctypes.addressof(size)))
            if not size.value:
                return found
            found.append((at, int(size.value)))

    def save(self) -> tuple[bytes, dict[str, dict[str, int]], int]:
        """It as bytes, which only the same program can read; the numbers that elements have, by signal, and the next one."""
        parts = [ctypes.string_at(self.context + at, size) for at, size in self.lasting]
        return b"".join(parts), *self._numbering.taken()

    def load(self, data: bytes, numbers: dict[str, dict[str, int]], following: int) -> None:
        """Go on from there. Raises ValueError for other bytes than a program of this layout saves."""
        if len(data) != sum(size for _, size in self.lasting):
            raise ValueError("it is of another size")
        self._numbering.put(numbers, following)
        self._rest = None  # words of ids, as they were numbered before
        begin = 0
        for at, size in self.lasting:
            ctypes.memmove(self.context + at, data[begin : begin + size], size)
            begin += size

    # A cycle ---------------------------------------------------------------------------------------------------

    def step(
        self, number: int | None, t: float | None, now: float, columns: Sequence[Columns | None], lines: Sequence[Line],
        closed: Sequence[bool] = (), events: Sequence[int] = (), found: Sequence[tuple[str, str, str, int | None]] = (),
        arena: Arena | None = None, lanes: Sequence[Lanes] = (),
    ) -> Said:  # fmt: skip
        """One cycle that came: number and stamp, None where there is none; its signals in the order of `words`, None for one that is
        missing; what is wrong with it already, as (name, signal, field, index). Of an arena, columns are not asked for where it `takes_arenas`."""
        ids = tuple(_ids(columns[place]) for place in self._named) if self._named else ()
        if lanes:  # as many as the set has elements: where it is none, C is not told of lanes either
            places = map(self.words.place, self.words.lanes)
            lanes = [as_many(each, columns[place]) for each, place in zip(lanes, places)]
        rest = (tuple(lines), ids, tuple(lanes), tuple(closed), tuple(events))
        if rest != self._rest:
            self._rest = None  # a step that is stopped meanwhile leaves words that are of no cycle
            own: list[Any] = []
            self._bordered(lines, own)
            self._ids = [self._numbering.of(name, each or ()) for name, each in zip(self.words.ids, ids)]
            own += [0 if each is None else kept.buffer_info()[0] for each, kept in zip(ids, self._ids)]
            self._lanes = [_words_of(each) for each in lanes]
            own += [each.buffer_info()[0] for each in self._lanes]
            self._in[self._before :] = self._tail.pack(*own, *closed, *events)
            self._rest = rest
        if arena is not None and not found and number is not None and t is not None:
            self._kept = None
            self._run(number, t, now, arena.data)
        else:
            given: list[Any] = [1, number is not None, t is not None, number or 0, t or 0.0, now, 0, 0]
            self._kept = self._found(found, given) if found else None
            own = []
            self._columns(columns if arena is None else arena.columns(), own)
            self._in[: self._before] = self._head.pack(*given) + self._middle.pack(*own)
            self._run()
        said = self.last()
        if said.judged and self._named:
            self._numbering.settle(t)
        return said

    def last(self) -> Said:
        """What is said of the last step."""
        said: Said = tuple.__new__(Said, self._said.unpack_from(self._out))
        return said

    def none_came(self, now: float, found: Sequence[tuple[str, str, str, int | None]] = ()) -> Said:
        """A cycle was due and did not come, or what came is none, for what was `found`."""
        given: list[Any] = [0, 0, 0, 0, 0.0, now, 0, 0]
        self._kept = self._found(found, given) if found else None
        self._in[:] = self._head.pack(*given).ljust(self.width, b"\0")
        self._rest = None
        self._run()
        return self.last()

    def nothing(self) -> Said:
        """Of a step that cannot be taken: what was said before it, which is not of this one."""
        return self.last()

    @property
    def taken(self) -> int:
        """How many steps the context has taken: the serial of the last one."""
        return self.serial[0]

    @staticmethod
    def lost(said: Said) -> str:
        """Why nothing stored is driven; empty where it is, or need not be."""
        return FAULT_NAMES[said.lost] if said.lost else ""

    def reasons(self, said: Said) -> list[Reason]:
        """Why the cycle of the last step is not safe."""
        listed = (CReason * said.reason_count).from_address(self._reasons)
        result = []
        for one in listed:
            found = one.fault
            index = None if found.index == NO_INDEX else int(found.index)
            rule = int(one.rule) if one.kind == 1 else None
            signal, field = (found.signal or b"").decode(), (found.field or b"").decode()
            result.append(
                Reason(FAULT_NAMES[found.name], signal, field, index, rule, int(one.candidate), one.kind == 2)
            )
        return result

    def stored(self, place: int) -> Floats:
        """(samples,) of a number of `plan`, in the context's memory: the stored trajectory's first `count` are in use."""
        offset = self._place + self._dll.tmg_stored(place)
        seen: Floats = np.frombuffer(
            memoryview(self._memory), np.float64, self.sizes["TM_MAX_SAMPLES"], offset
        )
        return seen

    def _columns(self, columns: Sequence[Columns | None], given: list[Any]) -> None:
        """Copy the columns one after the other into memory whose address is known; of one that is too long, C needs the count alone."""
        numbers, flags = [], []
        place, mark = self._bases
        for entry in columns:
            if entry is None:
                given += (0, 0, 0)
                continue
            count = entry.count
            given += (place, mark, count)
            if count > self._most:
                continue
            numbers.append(entry.values.reshape(-1))
            place += entry.values.nbytes
            if entry.flags is not None:
                flags.append(entry.flags.reshape(-1))
                mark += entry.flags.nbytes
        np.concatenate(numbers, out=self._numbers[: (place - self._bases[0]) // 8])
        if flags:
            np.concatenate(flags, out=self._flags[: mark - self._bases[1]])

    def _bordered(self, lines: Sequence[Line], given: list[Any]) -> None:
        """Lines where they are: a frame keeps them, and nobody can change them."""
        for place, line in enumerate(lines):
            known = self._lines[place]
            if known[0] is not line:
                known = self._lines[place] = (line, *_memory_of(line.points))
            given += (known[1], known[2], line.number)

    @staticmethod
    def _found(found: Sequence[tuple[str, str, str, int | None]], given: list[Any]) -> Any:
        """Faults as C reads them; they live as long as what is returned."""
        texts = [(signal.encode(), field.encode()) for _, signal, field, _ in found]
        listed = (CFault * len(found))()
        for place, ((name, _, _, index), (signal, field)) in enumerate(zip(found, texts)):
            listed[place] = CFault(
                FAULT_NAMES.index(name), signal, field, NO_INDEX if index is None else index
            )
        given[6:8] = (ctypes.addressof(listed), len(found))
        return listed, texts


def _ids(columns: Columns | None) -> tuple[str, ...] | None:
    """The ids of a set, None where not each of its elements has one: C reads as many as there are elements."""
    return None if columns is None or len(columns.ids) != columns.count else columns.ids


def _words_of(lanes: Lanes) -> array[int]:
    """Address, count and id of the left borders, then of the right ones."""
    own: list[int] = []
    for side in (0, 1):
        for pair in lanes:
            address, count = _memory_of(pair[side].points)
            # One without points is there, other than one that is missing: no point of it is read.
            own += (address if count or pair[side] is NOWHERE else _SOMEWHERE, count, pair[side].number)
    return array("Q", own or [0])


def _memory_of(points: Floats) -> tuple[int, int]:
    """Address and number of points; raises ValueError for what C cannot read as they are."""
    if points.dtype != np.float64 or points.shape[1:] != (2,) or not points.flags.c_contiguous:
        raise ValueError("a line's points do not stand one after the other")
    return (points.ctypes.data if len(points) else 0), len(points)
