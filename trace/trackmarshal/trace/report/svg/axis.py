"""Axes: from values to pixels, with ticks at round numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

#: A margin axis becomes logarithmic on both sides of zero where the largest value is so much more than what matters.
HUGE = 60.0
#: Spans below this are the noise of rounding, not something to see.
TINY = 1e-12
#: What is beyond is drawn at the axis's end.
LARGEST = 1e9


def nice_step(span: float, wanted: int) -> float:
    """1, 2 or 5 times a power of ten that cuts a span into at most about `wanted` parts."""
    if not (math.isfinite(span) and span > TINY):
        return 1.0
    raw = span / max(1, wanted)
    power = 10.0 ** math.floor(math.log10(raw))
    return next(
        (factor * power for factor in (1.0, 2.0, 5.0) if factor * power >= raw * (1 - 1e-9)), 10.0 * power
    )


def nice_ticks(low: float, high: float, wanted: int) -> list[float]:
    """Round numbers inside [low, high]."""
    step = nice_step(high - low, wanted)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [round(i * step, 12) + 0.0 for i in range(first, last + 1)]


@dataclass(frozen=True, slots=True)
class Axis:
    """Values from `low` to `high` on pixels from `start` to `stop`; logarithmic beyond `linear` where that is not None."""

    low: float
    high: float
    start: float
    stop: float
    linear: float | None = None

    def at(self, value: float) -> float:
        """The pixel of a value; values beyond the ends, infinite ones too, are at the ends."""
        inside = min(max(value, self.low), self.high)
        if self.linear is None:
            return self.start + (inside - self.low) / (self.high - self.low) * (self.stop - self.start)
        low, high = self._bent(self.low), self._bent(self.high)
        return self.start + (self._bent(inside) - low) / (high - low) * (self.stop - self.start)

    def ticks(self, wanted: int) -> list[float]:
        if self.linear is None:
            return nice_ticks(self.low, self.high, wanted)
        first = math.floor(math.log10(self.linear))
        last = math.ceil(math.log10(max(abs(self.low), abs(self.high))))
        sizes = [10.0**power for power in range(first, last + 1)]
        found = sorted({0.0, *sizes, *(-size for size in sizes)})
        found = [value for value in found if self.low <= value <= self.high]
        room = abs(self.stop - self.start) / max(1, wanted)
        kept = [0.0]
        for value in sorted(found, key=abs):
            if all(abs(self.at(value) - self.at(other)) >= 0.7 * room for other in kept):
                kept.append(value)
        return sorted(kept)

    def _bent(self, value: float) -> float:
        if self.linear is None:
            return value
        return math.copysign(math.log10(1.0 + abs(value) / self.linear), value)


def time_axis(t: Sequence[float], end: Sequence[float], start: float, stop: float) -> Axis:
    """From the first cycle to the end of the last one."""
    return Axis(t[0], end[-1], start, stop) if t else Axis(0.0, 1.0, start, stop)


def margin_axis(values: Sequence[float], start: float, stop: float) -> Axis:
    """Room for some margins and for the bound at zero; `start` is the pixel of the lowest value."""
    finite = [min(max(v, -LARGEST), LARGEST) for v in values if math.isfinite(v)]
    low, high = min([0.0, *finite]), max([0.0, *finite])
    if high - low <= TINY:
        low, high = -1.0, 1.0
    largest = max(-low, high)
    matter = _what_matters(finite)
    linear = None
    if largest > HUGE * matter:
        linear = 10.0 ** math.floor(math.log10(matter))
    else:
        room = 0.06 * (high - low)
        high, low = high + room, low - room
    if linear is not None:
        high = high * 1.5 if high > 0 else linear
        low = low * 1.5 if low < 0 else -linear * 0.5
    return Axis(low, high, start, stop, linear)


def _what_matters(finite: Sequence[float]) -> float:
    """The size of margins that must stay visible: the violations', or else the lower quarter's."""
    negative = sorted(-v for v in finite if v < 0.0)
    positive = sorted(v for v in finite if v > 0.0)
    size = negative[len(negative) // 2] if negative else positive[len(positive) // 4] if positive else 1.0
    return max(size, 1e-9)
