"""Stamps of the cycles of a run, in whole nanoseconds: each comes after the one before."""

from __future__ import annotations

import math

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.runtime.frame import Frame


def stamp_after(frame: Frame, last: int | None) -> int:
    """The stamp of a frame [ns]; last: that of the cycle before. Raises TrackmarshalError D206 for one that is none, or not after that."""
    stamp = None if frame.t is None or not math.isfinite(frame.t) else nanoseconds(frame.t)
    if stamp is None or (last is not None and stamp <= last):
        said = (
            "has no stamp" if frame.t is None else f"stamp {frame.t!r} s does not come after the one before"
        )
        help_ = 'write it as "t", in s, beside "signals": {"t": 0.1, "signals": {...}}'
        raise TrackmarshalError("D206", f"the cycle {said}", help=help_)
    return stamp
