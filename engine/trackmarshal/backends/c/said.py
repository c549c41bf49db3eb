"""What a Supervisor in C says of a step, as Python has it, and what is to be asked of whatever takes the steps."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.c.library import Result
from trackmarshal.backends.c.supervised.binding import Words
from trackmarshal.backends.c.supervised.lanes import Lanes
from trackmarshal.runtime.frame import Arena, Columns
from trackmarshal.runtime.lines import Line

Floats = NDArray[np.float64]
#: The index of a fault that has none.
NO_INDEX = ctypes.c_size_t(-1).value


@dataclass(frozen=True, slots=True)
class Reason:
    """A fault (`rule` None) by its name and place, or a rule's number with the candidate."""

    name: str
    signal: str
    field: str
    index: int | None
    rule: int | None
    candidate: int
    lost: bool


class Said(NamedTuple):
    """A decision as C gives it; see tm_decision in the header. verdicts, margins: (2, rules), driving first."""

    serial: int
    state: int
    safe: int
    driven: int
    first: int
    driven_number: int
    driven_t: float
    stored: int
    stored_number: int
    stored_t: float
    lost: int
    now: float
    finished: float
    valid_until: float
    judged: int
    fault_count: int
    reason_count: int
    more: int


class CFault(ctypes.Structure):
    """A `tm_fault`."""

    _fields_ = [
        ("name", ctypes.c_int),
        ("signal", ctypes.c_char_p),
        ("field", ctypes.c_char_p),
        ("index", ctypes.c_size_t),
    ]


class CReason(ctypes.Structure):
    """A `tm_reason`."""

    _fields_ = [
        ("kind", ctypes.c_int),
        ("fault", CFault),
        ("rule", ctypes.c_size_t),
        ("candidate", ctypes.c_int),
        ("result", Result),
    ]


class Stepping(Protocol):
    """What takes steps, here or in another process; see `Stepper`."""

    words: Words
    margins: Floats
    verdicts: NDArray[np.int8]
    #: Whether no columns are wanted where there is an arena.
    takes_arenas: bool

    def step(
        self, number: int | None, t: float | None, now: float, columns: Sequence[Columns | None], lines: Sequence[Line],
        closed: Sequence[bool] = (), events: Sequence[int] = (), found: Sequence[tuple[str, str, str, int | None]] = (),
        arena: Arena | None = None, lanes: Sequence[Lanes] = (),
    ) -> Said: ...  # fmt: skip

    def none_came(self, now: float, found: Sequence[tuple[str, str, str, int | None]] = ()) -> Said: ...

    def nothing(self) -> Said: ...

    def reasons(self, said: Said) -> list[Reason]: ...

    @property
    def taken(self) -> int: ...

    @property
    def serial(self) -> Sequence[int]: ...

    @staticmethod
    def lost(said: Said) -> str: ...
