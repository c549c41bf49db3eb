"""Calls a step in C from Python at little cost: one call of a built-in function, with Python's clock for C's."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path
from typing import Any

from trackmarshal.backends.c.build import small_library

_HERE = Path(__file__).parent
_FILES = (
    *(_HERE / name for name in ("python.h", "call.h", "call.c", "quick.c")),
    *(_HERE.parent / "gather" / name for name in ("gather.h", "gather.c")),
)


def shell() -> ctypes.PyDLL:
    """The library of all that C has to do with Python's objects. Raises TrackmarshalError E471 or E472 without a compiler."""
    library = ctypes.PyDLL(str(small_library(*_FILES)))
    for name in ("made_call", "made_gather", "made_quick"):
        made = getattr(library, name)
        made.restype, made.argtypes = ctypes.py_object, [ctypes.c_void_p]
    return library


class _Calling(ctypes.Structure):
    """A `calling` of call.h."""

    _fields_ = [
        (name, ctypes.c_int64 if name == "signals" else ctypes.c_void_p)
        for name in ("step", "bound", "words", "signals", "clock", "state")
    ]


class Calling:
    """One stepper's step, of the addresses that it is called with (`binding`), where a cycle's words go, and how many signals are columns.

    step: takes it; either of what is among the words, or of a cycle in order: number, stamp, arrival, and the bytes of its arena; other words
    then stay as they are. clock, user: C's clock, and what it is called with. Raises TrackmarshalError E471 or E472 without a compiler.
    """

    def __init__(self, step: int, bound: int, words: int, signals: int, clock: Callable[[], float]) -> None:
        library = shell()
        self._kept = clock
        self._own = _Calling(step, bound, words, signals, id(clock), None)
        self.signals = signals
        self.user = ctypes.addressof(self._own)
        self.step: Callable[..., Any] = library.made_call(self.user)
        self.clock: int = ctypes.cast(library.clock_reading, ctypes.c_void_p).value or 0
