"""Stamps of the cycles of a run, in whole nanoseconds: each comes after the one before."""

from __future__ import annotations

from contextlib import suppress

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.overrun import FURTHEST, stamped
from trackmarshal.runtime.frame import Frame


def stamp_after(frame: Frame, last: int | None) -> int:
    """The stamp of a frame [ns]; last: that of the cycle before. Raises TrackmarshalError D206 for one that is none, out of reach, or not after that."""
    stamp = None
    if frame.t is not None:
        with suppress(ValueError, OverflowError):
            stamp = stamped(frame.t)
    if stamp is None or (last is not None and stamp <= last):
        wrong = (
            f"is not within {FURTHEST / 1e9:g} s of 0"
            if stamp is None
            else "does not come after the one before"
        )
        said = "has no stamp" if frame.t is None else f"stamp {frame.t!r} s {wrong}"
        help_ = 'write it as "t", in s, beside "signals": {"t": 0.1, "signals": {...}}'
        raise TrackmarshalError("D206", f"the cycle {said}", help=help_)
    return stamp
