"""A whole step as most of them are, in one call of a built-in function: quick.c, and what it is told of the Supervisor that it is of."""

from __future__ import annotations

import ctypes
import math
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from trackmarshal.backends.c.calling import shell
from trackmarshal.backends.c.calling.ahead import libraries, objects
from trackmarshal.backends.c.calling.objects import place_of_bytes, place_of_items, place_of_number, places
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.frame import Arena, Frame, Unread
from trackmarshal.runtime.machine import DRIVE
from trackmarshal.runtime.plan import Plan
from trackmarshal.runtime.program import Judged

if TYPE_CHECKING:
    from trackmarshal.backends.c.gather import Gathered
    from trackmarshal.backends.c.step import Stepper

#: Attributes of what is read and made, as `places` in quick.c has them.
_CYCLE = "number", "t", "driving", "emergency", "signals"
_PLAN = "of", "candidate", "number", "t"
_FRAME = "settings", "arena", "lines", "closed", "events"
_SAID = "explaining", "advisory", "frame", "copied"


class _Stretch(ctypes.Structure):
    """A `stretch` of quick.c."""

    _fields_ = [("begin", ctypes.c_void_p), ("size", ctypes.c_int64)]


class _Quick(ctypes.Structure):
    """A `quick` of quick.c."""

    _fields_ = [
        ("reading", ctypes.c_void_p),
        ("calling", ctypes.c_void_p),
        ("is_", ctypes.c_void_p),
        ("at", ctypes.c_void_p),
        ("said", ctypes.c_void_p),
        ("outcome", ctypes.c_int64),
        ("stretches", ctypes.c_void_p),
        ("stretch_count", ctypes.c_int64),
        ("armed", ctypes.c_void_p),
        ("expected", ctypes.c_int64),
        ("steps", ctypes.c_int64),
        ("last", ctypes.c_double),
        ("stored", ctypes.c_void_p),
        ("left", ctypes.c_void_p),
        ("decides", ctypes.c_int64),
        ("recorded", ctypes.c_int64),
        ("taker", ctypes.c_uint64),
    ]


class Left(NamedTuple):
    """What a step has left: the clock's reading, where it was read; where the step was taken, the frame of a cycle of which Python is to say what was
    decided, or the Decision, where it is to be recorded; number and stamp."""

    now: float | None
    made: Any
    number: Any
    t: Any


NOTHING = Left(None, None, None, None)


class Slowly:
    """What a Supervisor remembers from step to step: how many there were, the clock's last reading, the stored trajectory. Every step is for
    Python."""

    steps: int = 0
    last: float = -math.inf
    stored: Plan | None = None
    #: Whether decisions are recorded, which is for Python.
    recorded: bool = False

    def __init__(self) -> None:
        self._looked_at, self._taker = threading.RLock(), 0  # see runtime.supervisor.Supervisor

    def step(self, cycle: Cycle | None) -> Decision | Literal[False] | None:
        """The Decision of a cycle; None where Python has to go on, with what is `left`, and to `release` in the end; False where a step is being
        taken."""
        own = threading.get_ident()
        with self._looked_at:
            # A signal that is seen behind this finds who takes the step, and is to release it.
            if self._taker:
                return False
            self._taker = own
        return None

    def release(self) -> None:
        """The step that this thread was taking is over."""
        if self._taker == threading.get_ident():
            self._taker = 0

    def stopped(self, taken: int) -> Left:
        """The step that this thread was taking has ended before its time; C has taken so many by now. What it has left, which is not for the next one."""
        if self._taker != threading.get_ident():
            return NOTHING
        self.steps = taken
        self.release()
        return NOTHING

    def left(self) -> Left:
        """What Python goes on with."""
        return NOTHING

    def arm(self, arena: Arena, frame: Frame, known: tuple[Any, ...], remembered: tuple[Any, ...]) -> None:
        """Cycles may come that are like this one, of which ids and other signals are those."""

    def disarm(self) -> None:
        """Nothing is known of the next cycle."""


class Quick(Slowly):
    """Takes steps in one call.

    reader: what reads cycles; stepper: what takes the steps; kind: what is made of margins and verdicts. Raises OSError where objects look
    otherwise here, TrackmarshalError E471 or E472 without a compiler.
    """

    step: Callable[[Cycle | None], Decision | Literal[False] | None]  # type: ignore[assignment]  # a built-in function

    def __init__(
        self, reader: Gathered, stepper: Stepper, kind: type, explaining: object, advisory: frozenset[int]
    ) -> None:
        constants: tuple[Any, ...] = (
            Cycle, int, float, Decision, Plan, Unread, Arena, Judged, kind, DRIVING, EMERGENCY, DRIVE, "", (), math.nan, explaining, advisory,
        )  # fmt: skip
        standing = [
            *places(Cycle, *_CYCLE), *places(Plan, *_PLAN), *places(Unread, *_FRAME), *places(kind, *_SAID), place_of_items(),
            place_of_number(), place_of_bytes(),
        ]  # fmt: skip
        library = shell()
        paths = Path(library._name), stepper.path
        fetched = [
            _Stretch(*one)
            for one in (*objects(*reader.looked_for, *constants, True, False), *libraries(*paths))
        ]
        self._stored: list[Plan | None] = [None]
        self._left: list[Any] = [*NOTHING]
        self._armed: tuple[Any, ...] | None = None
        own: list[Any] = [
            (ctypes.c_void_p * len(constants))(*map(id, constants)), (ctypes.c_int64 * len(standing))(*standing),
            (_Stretch * len(fetched))(*fetched),
        ]  # fmt: skip
        is_, at, ahead = map(ctypes.addressof, own)
        self._own = _Quick(
            reader.address, stepper.calling.user, is_, at, stepper.answer, stepper.outcome, ahead, len(fetched), None, 0, 0, -math.inf,
            id(self._stored), id(self._left), not advisory, 0, 0,
        )  # fmt: skip
        #: All that C has the addresses of.
        self._kept = (constants, own)
        self.step = library.made_quick(ctypes.addressof(self._own))

    def release(self) -> None:
        if self._own.taker == threading.get_ident():
            self._own.taker = 0

    def stopped(self, taken: int) -> Left:
        if self._own.taker != threading.get_ident():
            return NOTHING
        left, self.steps = self.left(), taken
        self.release()
        return left

    def left(self) -> Left:
        if self._left[0] is None:
            return NOTHING
        left = Left(*self._left)
        self._left[:] = NOTHING
        return left

    def arm(self, arena: Arena, frame: Frame, known: tuple[Any, ...], remembered: tuple[Any, ...]) -> None:
        own = known, remembered, arena.shape, frame.settings, frame.lines, frame.closed, frame.events
        self._own.armed, self._own.expected = id(own), int.from_bytes(arena.data[:8], sys.byteorder)
        self._armed = own

    def disarm(self) -> None:
        if self._armed is not None:
            self._own.armed = self._armed = None

    @property
    def steps(self) -> int:
        return int(self._own.steps)

    @steps.setter
    def steps(self, given: int) -> None:
        self._own.steps = given

    @property
    def last(self) -> float:
        return float(self._own.last)

    @last.setter
    def last(self, given: float) -> None:
        self._own.last = given

    @property
    def stored(self) -> Plan | None:
        return self._stored[0]

    @stored.setter
    def stored(self, given: Plan | None) -> None:
        self._stored[0] = given

    @property
    def recorded(self) -> bool:
        return bool(self._own.recorded)

    @recorded.setter
    def recorded(self, given: bool) -> None:
        self._own.recorded = given
