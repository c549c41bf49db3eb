"""Decisions of the Supervisor that an edit changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trackmarshal.comparing.changes import spans
from trackmarshal.comparing.judged import Judged


@dataclass(frozen=True, slots=True)
class DecisionChange:
    """Cycles of a recording in which something else is driven. old, new: what is; where both are the same word, it is the trajectory of another cycle.

    spans: (first, last) times in s of cycles one after the other.
    """

    recording: str
    old: str
    new: str
    cycles: int
    spans: tuple[tuple[float, float], ...]


def decided(old: Judged, new: Judged) -> Iterator[DecisionChange]:
    """What is driven otherwise, by what was driven and what is, in the order of their first cycles."""
    found: dict[tuple[str, str], list[int]] = {}
    for place, (before, after) in enumerate(zip(old.decisions, new.decisions, strict=True)):
        if before != after:
            found.setdefault((before[0], after[0]), []).append(place)
    for (before_, after_), places in found.items():
        yield DecisionChange(
            old.recording.name, before_, after_, len(places), spans(np.array(places), old.times)
        )
