"""Files of cycles: what the emitted example reads. docs/generated-c.md describes the format.

Every number is its 64 bits in hexadecimal digits, leading zeros left out: nothing is rounded, and a C library that can neither read
nor print decimal numbers exactly will do.
"""

from __future__ import annotations

import hashlib
import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from trackmarshal.backends.c.over_run.numbering import Numbering
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.backends.c.supervised.interface import LIMITS, in_force
from trackmarshal.backends.c.supervised.lanes import Lanes, as_many
from trackmarshal.runtime.contract import EVENT, LINES, RECORD, Signal
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Limits
from trackmarshal.runtime.decision import MOST_REASONS
from trackmarshal.runtime.faults import Fault, name_of

if TYPE_CHECKING:
    from trackmarshal.runtime.frame import Columns, Frame, Settings
    from trackmarshal.runtime.lines import Line

FORMAT, VERSION = "trackmarshal-cycles", 1
#: The most letters of a name in a file; longer ones are cut.
LETTERS = 63
#: The most faults of one cycle in a file: one more than a decision has room for, so that it says that there are more.
FOUND = MOST_REASONS + 1


@dataclass(frozen=True, slots=True)
class Arrival:
    """What the Supervisor is given in one step: a cycle as its reader understood it, or None where none came, and the clock.

    number: None where it is none. t: the stamp in s, None where it is none. now, finished: the clock at the arrival and when all rules
    had been checked, in s. found: what the reader says is wrong with it.
    """

    frame: Frame | None
    number: int | None
    t: float | None
    now: float
    finished: float
    found: Sequence[Fault] = ()


def digest(source: Source) -> str:
    """Tells programs apart by spec, with what it says of its inputs, and rules: 16 hexadecimal digits."""
    told = [source.plan.spec.fingerprint, source.plan.spec.inputs, *(code.rule.name for code in source.rules)]
    return hashlib.sha256("\n".join(told).encode()).hexdigest()[:16]


def label(name: str) -> str:
    """A name as one word of a file: what is no printable ASCII is replaced, as is nothing at all."""
    return "".join(c if "!" <= c <= "~" and c not in '"\\?' else "_" for c in name[:LETTERS]) or "-"


def word(x: float) -> str:
    """The bits of a double."""
    return f"{struct.unpack('<Q', struct.pack('<d', x))[0]:x}"


def integer(n: int) -> str:
    """The bits of a whole number of 64 bits, in two's complement."""
    return f"{n & 0xFFFF_FFFF_FFFF_FFFF:x}"


class CycleWriter:
    """Lines of a file for one program. Lines of borders are written when they change."""

    def __init__(self, source: Source, given: Supervised) -> None:
        self._source, self._contract = source, given.contract
        self._last: dict[str, tuple[object, ...]] = {}
        #: Lines by their number, in the order in which they come.
        self._ids: dict[int, int] = {}
        #: Elements that are known again; none is ever forgotten, which a Supervisor may do.
        self._numbering = Numbering()

    def head(self, settings: Settings, limits: Limits) -> Iterator[str]:
        """What stands before the first cycle. Capacities are no part of it: they are compiled in."""
        plan = self._source.plan
        yield f"{FORMAT} {VERSION:x}"
        yield f"program {digest(self._source)}"
        for name in LIMITS:
            yield f"{label(name)} {word(float(getattr(limits, name)))}"
        for name, value in in_force(plan, settings.params, asdict(limits)).items():
            yield f"{label(name)} {word(value)}"
        for name in plan.tables:
            info = plan.spec.tables[name]
            knots, values = settings.tables.get(name, (info.knots, info.values))
            rows = [word(x) for row in zip(knots, values, strict=True) for x in row]
            yield " ".join([label(name), f"{len(knots):x}", *rows])

    def cycle(self, arrival: Arrival) -> Iterator[str]:
        """One step."""
        frame, number, t = arrival.frame, arrival.number, arrival.t
        yield " ".join([
            "cycle", integer(frame is not None), integer(number is not None), integer(number or 0), integer(t is not None),
            word(math.nan if t is None else t), word(arrival.now), word(arrival.finished),
        ])  # fmt: skip
        if frame is None:
            return
        found = arrival.found[:FOUND]
        yield f"found {len(found):x}"
        for fault in found:
            index = "-" if fault.index is None else integer(fault.index)
            yield f" {name_of(fault)} {label(fault.signal)} {label(fault.field)} {index}"
        spoilt = {fault.signal for fault in arrival.found}
        assert self._contract.plan is not None
        for name in (DRIVING, EMERGENCY):
            yield from self._columns(name, self._contract.plan, frame.candidates[name], spoilt)
        for signal in self._contract.signals:
            if signal.form == EVENT:
                yield f"{label(signal.name)} {integer(frame.events[signal.name])}"
            elif signal.form == LINES:
                yield from self._lines(signal, frame, spoilt)
            else:
                yield from self._columns(signal.name, signal, frame.columns[signal.name], spoilt)
                if signal.lines and signal.name not in spoilt:
                    yield from self._lanes(as_many(frame.lanes[signal.name], frame.columns[signal.name]))

    def end(self) -> Iterator[str]:
        """What stands after the last cycle: without it, a file was cut off."""
        yield "end"

    def _columns(self, name: str, signal: Signal, columns: Columns, spoilt: set[str]) -> Iterator[str]:
        if name in spoilt:  # nobody looks at it
            yield f"{label(name)} -"
            return
        yield f"{label(name)} {':' if signal.form == RECORD else format(columns.count, 'x')}"
        if signal.named:
            yield " ".join([" id", *map(integer, self._numbering.of(name, columns.ids)[: columns.count])])
        for field in (*signal.numbers, *signal.flags):
            yield " ".join([f" {label(field.name)}", *_words(columns.column(field.name))])

    def _lines(self, signal: Signal, frame: Frame, spoilt: set[str]) -> Iterator[str]:
        name = signal.name
        if name in spoilt:
            yield f"{label(name)} -"
            return
        lines = [(field.name, frame.line(name, field.name)) for field in signal.lines]
        closed = [integer(frame.closed.get(name, False))] if any(field for field, _ in lines) else []
        now = (*closed, *(line.number for _, line in lines))
        if self._last.get(name) == now:
            yield f"{label(name)} ="
            return
        self._last[name] = now
        yield " ".join([label(name), ":", *closed])
        for field, line in lines:
            yield self._line(field or "line", line)

    def _lanes(self, lanes: Lanes) -> Iterator[str]:
        """The borders of each lane, the left ones first."""
        for side, name in enumerate(("left", "right")):
            for lane in lanes:
                yield self._line(name, lane[side]) if len(lane[side]) else f" {name} -"

    def _line(self, name: str, line: Line) -> str:
        known = self._ids.setdefault(line.number, len(self._ids) + 1)
        points = _words(line.points.reshape(-1))
        return " ".join([f" {label(name)}", integer(known), integer(len(line)), *points])


def _words(column: np.ndarray[Any, Any]) -> Iterator[str]:
    if column.dtype == np.float64:
        return map("{:x}".format, np.ascontiguousarray(column).view(np.uint64).tolist())
    return map(integer, column.tolist())
