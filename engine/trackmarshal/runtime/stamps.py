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
    if stamp is not None and (last is None or stamp > last):
        return stamp
    if frame.t is None:
        said, help_ = "has no stamp", 'write it as "t", in s, beside "signals": {"t": 0.1, "signals": {...}}'
    elif stamp is None:
        said = f"stamp {frame.t!r} s is not within {FURTHEST / 1e9:g} s of 0"
        help_ = "stamps are finite, and in s, from wherever they count: of one in ms or ns take 0.001 or 1e-9"
    else:
        said = f"stamp {frame.t!r} s does not come after the one before"
        help_ = (
            "a run is in the order of its stamps, each once; where a clock was set back, another run begins"
        )
    raise TrackmarshalError("D206", f"the cycle {said}", help=help_)
