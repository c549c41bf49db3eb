"""Python's collection of garbage, for verbs that hold very many objects to their end."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

#: After how many more objects than were freed the youngest are looked at, and after how many such looks the older ones are.
_SELDOM = (2_000_000, 20, 50)
#: How many objects may be set aside by nobody: Python 3.12 begins with some hundred. Who sets a program aside has tens of thousands.
_OF_PYTHON = 1000


@contextmanager
def seldom() -> Iterator[None]:
    """Look for garbage seldom: a recording and its results are no garbage, and going through all of them again and again takes longer than
    judging them. Most of what becomes garbage is freed without being looked for."""
    before = gc.get_threshold()
    gc.set_threshold(*_SELDOM)
    try:
        yield
    finally:
        if not _set_aside():
            # All that there is counts as old from here on: it is not gone through only because the usual thresholds are passed by far.
            gc.freeze()
            gc.unfreeze()
        gc.set_threshold(*before)


@cache
def _set_aside() -> bool:
    """Whether others set objects aside, which stay there. Asked once: the answer counts all of them."""
    return gc.get_freeze_count() > _OF_PYTHON
