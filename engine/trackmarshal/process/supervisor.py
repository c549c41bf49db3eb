"""A Supervisor that is a process of its own, behind Python's surface: `step(cycle)` gives a Decision, as in one process."""

from __future__ import annotations

import math
import struct
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from trackmarshal.backends.c.over_run.numbering import Numbering, lasting
from trackmarshal.backends.c.said import Reason, Said
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.supervised.binding import SAID, Words, words
from trackmarshal.backends.c.supervised.interface import FAULT_NAMES
from trackmarshal.backends.c.supervised.lanes import Lanes
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.process.client import Block, Border, Client, Found
from trackmarshal.process.messages import Entry, Layout, LinkError, Message
from trackmarshal.process.serving import emitted
from trackmarshal.runtime.contract import RECORD
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Limits
from trackmarshal.runtime.frame import NO_SETTINGS, Arena, Columns, Settings
from trackmarshal.runtime.lines import Line
from trackmarshal.runtime.machine import NO_SAFE_TRAJECTORY, STATES
from trackmarshal.supervision import limits_with

#: Kinds of reasons beside faults.
_RULE, _LOST = 1, 2
_SAID = struct.Struct("<" + "".join(kind for _, kind in SAID))


class NoAnswer(Exception):
    """No decision came in time about a cycle that was sent."""


class RemoteSupervisor(CSupervisor):
    """Decides as the process at the other end of a client does. spec, rules, limits and settings are those that the process was made with.

    patience: s, how long to wait for a decision. Where none comes, the step says that nothing is driven (`incomplete`); what the executing
    layer does meanwhile is its own business. Raises TrackmarshalError as CSupervisor does; LinkError where the program is another one.
    """

    def __init__(
        self, spec: Spec, rules: list[RuleInfo], client: Client, limits: Limits | None = None, clock: Callable[[], float] = time.monotonic,
        settings: Settings = NO_SETTINGS, patience: float = 0.1,
    ) -> None:  # fmt: skip
        self.client = client
        given = limits_with(spec, {}, settings) if limits is None else limits

        def stepping(source: Source) -> RemoteStepper:
            _refuse_other(client.layout, Layout(emitted(source, given, settings).description))
            return RemoteStepper(source, client, patience)

        super().__init__(spec, rules, given, clock, settings, stepping)

    def close(self) -> None:
        super().close()
        self.client.close()


def _refuse_other(theirs: Layout, ours: Layout) -> None:
    """Raise LinkError for a process that was made of something else: what is said of its decisions, and recorded, would be of other rules."""
    if theirs.fingerprint == ours.fingerprint:
        return
    parts = ("rules", "limits", "params", "tables", "capacities", "program")
    other = [part for part in parts if theirs.said.get(part) != ours.said[part]]
    if not other:
        raise LinkError(
            "the process was built by another version of trackmarshal: build it anew with this one"
        )
    raise LinkError(f"the process has other {' and '.join(other)}: start it anew with those of this spec")


class RemoteStepper:
    """Steps that another process takes; the surface of `backends.c.step.Stepper` that a CSupervisor needs."""

    takes_arenas = False

    def __init__(self, source: Source, client: Client, patience: float) -> None:
        given = source.supervised
        assert given is not None
        names = [code.rule.name for code in source.rules]
        self.words: Words = words(given)
        self._records = {signal.name for signal in given.inputs if signal.form == RECORD}
        self.client, self._patience = client, patience
        self.margins = np.full((2, len(names)), np.nan)
        self.verdicts = np.full((2, len(names)), 2, dtype=np.int8)
        #: The newest decision, and what was found before it was asked for.
        self.decision: Message | None = None
        self._found: Sequence[Found] = ()
        self._silent = False
        self._serial = 0
        #: How many steps the process was asked for.
        self.serial = client.cycles
        self._bordered: dict[int, _Points] = {}
        self._numbering = Numbering(lasting(source.plan.spec))
        # What the process remembers of elements outlasts this side: another one's numbers, or a caller's, are none of these.
        self._numbering.put({}, time.monotonic_ns())
        #: The stamp of the cycle that was asked about last [s].
        self._t: float | None = None

    def step(
        self, number: int | None, t: float | None, now: float, columns: Sequence[Columns | None], lines: Sequence[Line],
        closed: Sequence[bool] = (), events: Sequence[int] = (), found: Sequence[Found] = (), arena: Arena | None = None,
        lanes: Sequence[Lanes] = (),
    ) -> Said:  # fmt: skip
        """As a Stepper's; the process reads the clock itself. Raises NoAnswer."""
        if lanes:
            raise AssertionError("messages have none: a process that would need them is not built")
        order = self.words
        driving, emergency = (_columns(one, False) for one in columns[:2])
        signals: dict[str, Any] = {  # of which one may be called as a candidate is
            name: _columns(one, name in self._records) for name, one in zip(order.columns[2:], columns[2:])
        }
        for name in order.ids:
            block = signals[name]
            if isinstance(block, _Matrix) and len(block.columns.ids) == block.columns.count:
                block.ids = self._numbering.of(name, block.columns.ids)
        known: dict[int, _Points] = {}
        for (signal, field), line in zip(order.lines, lines):
            points = known[line.number] = self._bordered.get(line.number) or _Points(line)
            if field:
                signals.setdefault(signal, {})[field] = points
            else:
                signals[signal] = points
        self._bordered = known
        for signal, is_closed in zip(order.closed, closed):
            signals[signal]["closed"] = is_closed
        for event, flag in zip(order.events, events):
            signals[event] = None if flag < 0 else flag == 1
        self._t = t
        return self._asked(self.client.send(number, t, driving, emergency, signals, found), found)

    def none_came(self, now: float, found: Sequence[Found] = ()) -> Said:
        """A cycle was due and did not come, or what came is none; after a step without an answer, that nothing is known. Raises NoAnswer."""
        if self._silent:
            return self.nothing()
        return self._asked(self.client.send(None, None, None, None, {}, found, came=False), found)

    def reasons(self, said: Said) -> list[Reason]:
        """Why the cycle of the last step is not safe."""
        message = self.decision
        if message is None:
            return []
        layout, left = self.client.layout, list(self._found)
        names = {
            name: message[f"reason_{name}"]
            for name in ("name", "signal", "field", "index", "rule", "kind", "candidate")
        }
        result = []
        for i in range(said.reason_count):
            name, index = layout.faults[names["name"][i]], names["index"][i]
            kind = names["kind"][i]
            signal, field = _text(layout.signals, names["signal"][i]), _text(layout.fields, names["field"][i])
            if kind == _RULE:
                signal, field = "", ""
            elif signal is None or field is None:
                # What no spec knows has no number: it is what this side has found, in the same order.
                own = next(one for one in left if one[0] == name)
                left.remove(own)
                signal, field = own[1], own[2]
            result.append(
                Reason(
                    name, signal, field, None if index < 0 else index, names["rule"][i] if kind == _RULE else None, names["candidate"][i],
                    kind == _LOST,
                )
            )  # fmt: skip
        return result

    @property
    def taken(self) -> int:
        """How many steps were answered since the last one that was not."""
        return self._serial

    @staticmethod
    def lost(said: Said) -> str:
        """Why nothing stored is driven; empty where it is, or need not be."""
        return FAULT_NAMES[said.lost] if said.lost else ""

    def _asked(self, sequence: int, found: Sequence[Found]) -> Said:
        message = self.client.answer(sequence, self._patience) if sequence else None
        self.decision, self._found = message, found
        if message is None:
            self._silent, self._serial = True, 0
            raise NoAnswer(f"no decision within {self._patience:g} s")
        count = self.margins.shape[1]
        for row, name in enumerate((DRIVING, EMERGENCY)):
            self.margins[row] = message[f"{name}_margin"][:count]
            self.verdicts[row] = message[f"{name}_verdict"][:count]
        said = Said._make(_SAID.unpack_from(message.data, message.kind.entries[SAID[0][0]].offset))
        if said.judged:
            self._numbering.settle(self._t)
        self._serial += 1
        return said._replace(serial=self._serial)

    def nothing(self) -> Said:
        """Of a step that nobody answers, or that this client cannot ask for, as in a fork."""
        nan, self._serial, self._silent = math.nan, 0, False
        state = STATES.index(NO_SAFE_TRAJECTORY)
        return Said(0, state, 0, 0, -1, 0, nan, 0, 0, nan, 0, nan, nan, nan, 0, 0, 0, 0)


class _Points(Border):
    """A line as a client sends it."""

    __slots__ = ()

    def __init__(self, line: Line) -> None:
        # Lines and Borders are counted apart: below 0, the one is never taken for the other.
        self.number, self.count = -line.number, len(line)
        self.points: Any = np.ascontiguousarray(line.points, dtype=np.float64).reshape(-1)


def _columns(columns: Columns | None, record: bool) -> dict[str, Any] | _Matrix | None:
    """Columns as a client takes them; of a record its numbers and flags."""
    if columns is None:
        return None
    if not record:
        return _Matrix(columns)
    found: dict[str, Any] = dict(zip(columns.names.numbers, columns.values[:, 0].tolist()))
    if columns.flags is not None:
        flags = (None if flag < 0 else flag == 1 for flag in columns.flags[:, 0].tolist())
        found |= dict(zip(columns.names.flags, flags))
    return found


class _Matrix(Block):
    """Columns that stand one below the other, as their entries do."""

    def __init__(self, columns: Columns) -> None:
        self.columns = columns

    def write(self, message: bytearray, columns: Sequence[tuple[str, Entry]]) -> int:
        given = self.columns
        for kind, values in (("f64", given.values), ("i8", given.flags)):
            entries = [entry for _, entry in columns if entry.type == kind]
            if values is None or not entries:
                continue
            room, first = entries[0].room, entries[0]
            if any(
                entry.offset != first.offset + k * room * values.itemsize for k, entry in enumerate(entries)
            ):
                raise AssertionError("columns of one kind stand one behind the other")
            whole = np.ndarray((len(entries), room), values.dtype, message, first.offset)
            whole[:, : given.count] = values[:, :room]
        return given.count


def _text(names: Sequence[str], place: int) -> str | None:
    return names[place] if place < len(names) else None
