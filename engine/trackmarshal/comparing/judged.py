"""All that the rules say of a recording, and what is decided of it, as arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import remembers
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.scenarios.overrides import known_tables
from trackmarshal.scenarios.recording import CANDIDATES, Recording
from trackmarshal.scenarios.supervised import supervised


@dataclass(frozen=True, slots=True)
class Judged:
    """times (cycles,), s; there (cycles, candidates): whether the candidate is; codes (cycles, candidates, rules): places in VERDICTS; margins alike, in
    SI, NaN where undefined or open, inf where nothing was demanded. decisions: by cycle, what is driven, and since which time, s.

    Of rules over the run, a cycle's verdict is the last that was said of it, maybe in a later cycle.
    """

    recording: Recording
    evaluator: Evaluator
    times: NDArray[np.float64]
    there: NDArray[np.bool_]
    codes: NDArray[np.uint8]
    margins: NDArray[np.float64]
    decisions: tuple[tuple[str, float | None], ...]

    @property
    def unknown(self) -> frozenset[str]:
        """Rules that are undefined of every candidate in every cycle, as where the recording lacks what they read."""
        undefined = (self.codes == VERDICTS.index("undefined")) | ~self.there[:, :, np.newaxis]
        return frozenset(
            rule.name for rule, always in zip(self.evaluator.rules, undefined.all(axis=(0, 1))) if always
        )


def judge(
    evaluator: Evaluator, recording: Recording, watch: Callable[[Sequence[Any]], Iterable[Any]] = iter
) -> Judged:
    """A recording through the Supervisor, rule by rule; `watch` wraps the chunks of work. Raises TrackmarshalError as a replay does."""
    tables, _ = known_tables(recording, evaluator.spec)
    shape = (len(recording.cycles), len(CANDIDATES), len(evaluator.rules))
    codes = np.full(shape, VERDICTS.index("undefined"), np.uint8)
    margins = np.full(shape, np.nan)
    there = np.zeros(shape[:2], np.bool_)
    later = [number for number, rule in enumerate(evaluator.rules) if remembers(rule)]
    decisions: list[tuple[str, float | None]] = []
    for place, (_, judged, decision) in enumerate(supervised(recording, evaluator, tables, watch)):
        for candidate, name in enumerate(CANDIDATES):
            rated = judged.rated.get(name)
            if rated is None:
                continue
            there[place, candidate] = True
            codes[place, candidate] = np.frombuffer(rated.verdicts, np.uint8)
            margins[place, candidate] = rated.margins
            for number in later:
                for about in rated.explain(number, False).about:
                    if isinstance(about.cycle, int):  # as cycles of recordings are numbered
                        codes[about.cycle, candidate, number] = VERDICTS.index(about.verdict)
                        margins[about.cycle, candidate, number] = about.margin
        decisions.append((decision.action, None if decision.driven is None else decision.driven.t))
    times = np.array([cycle.t for cycle in recording.cycles], np.float64)
    return Judged(recording, evaluator, times, there, codes, margins, tuple(decisions))
