"""Both candidates of a cycle as C rated them: margins and verdicts as they stand in memory."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from trackmarshal.backends.c.over_run.explaining import Explaining
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Copied, Rated
from trackmarshal.runtime.verdict import RuleResult


class BothRated(Copied):
    """What C said of both candidates, taken apart when somebody asks: of most cycles, nobody does."""

    __slots__ = ("advisory", "both", "copied", "explaining", "frame")

    both: dict[str, Rated]

    def __init__(self, explaining: Explaining, advisory: frozenset[int], frame: Frame, copied: bytes) -> None:
        """copied: margins and verdicts of both as they stand in memory."""
        self.explaining, self.advisory, self.frame, self.copied = explaining, advisory, frame, copied

    def __getattr__(self, name: str) -> Any:
        """What is made when somebody asks for it (quick.c makes no more than __init__)."""
        if name == "both":
            self.both = {one: self._rated(place, one) for place, one in enumerate((DRIVING, EMERGENCY))}
        elif name in ("margins", "verdicts"):
            margins = len(self.copied) // 18 * 16
            self.margins, self.verdicts = self.copied[:margins], self.copied[margins:]
        else:
            raise AttributeError(name)
        return getattr(self, name)

    def __getitem__(self, name: str) -> Rated:
        return self.both[name]

    def __iter__(self) -> Iterator[str]:
        return iter((DRIVING, EMERGENCY))

    def __len__(self) -> int:
        return 2

    def _rated(self, place: int, candidate: str) -> Rated:
        count = len(self.verdicts) // 2
        verdicts = self.verdicts[place * count : (place + 1) * count]
        margins = np.frombuffer(self.margins, dtype=np.float64)[place * count : (place + 1) * count]
        explain = partial(_explain, self.explaining, self.frame, candidate, verdicts, margins)
        return Rated(verdicts, margins, explain, self.advisory)


def _explain(
    explaining: Explaining, frame: Frame, candidate: str, verdicts: bytes, margins: Any, number: int, series: bool = False
) -> RuleResult:  # fmt: skip
    return explaining.of(frame.of(candidate), verdicts, margins)(number, series)
