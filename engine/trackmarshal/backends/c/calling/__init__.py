"""Calls a step in C from Python at little cost: one call of a built-in function, with Python's clock for C's."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path
from typing import Any

from trackmarshal.backends.c.build import small_library


class _Calling(ctypes.Structure):
    """A `calling` of call.c."""

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
        library = ctypes.PyDLL(str(small_library(Path(__file__).with_name("call.c"))))
        self._kept = clock
        self._own = _Calling(step, bound, words, signals, id(clock), None)
        library.made.restype, library.made.argtypes = ctypes.py_object, [ctypes.c_void_p]
        self.user = ctypes.addressof(self._own)
        self.step: Callable[..., Any] = library.made(self.user)
        self.clock: int = ctypes.cast(library.clock_reading, ctypes.c_void_p).value or 0
