"""Every rule on every cycle of a drive, as arrays: what causes, rates, margins and limits are told from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.evaluation import CHUNK, Evaluator
from trackmarshal.ir.spec import remembers
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Judged, Program
from trackmarshal.runtime.verdict import UNSAFE, VERDICTS, RuleResult
from trackmarshal.scenarios.fields import check_fit, further_names
from trackmarshal.scenarios.overrides import known_params, known_tables
from trackmarshal.scenarios.recording import CANDIDATES, Recording
from trackmarshal.scenarios.supervised import cycles, shown, supervised
from trackmarshal.supervision import rulebox

Floats = NDArray[np.float64]
_UNSAFE = [VERDICTS.index(name) for name in UNSAFE]
_INACTIVE = VERDICTS.index("inactive")
#: What stands for breaches of the input contract among the rules.
CONTRACT = "input contract"


@dataclass(frozen=True, slots=True)
class Judgement:
    """times (cycles,), s; codes (cycles, candidates, rules): places in VERDICTS; margins alike, in SI; faults: by cycle, what breaks the contract;
    in_step: by cycle, what rules over the run said of each candidate, by its name and the number of the rule; of the others, a cycle may be
    asked about by itself."""

    evaluator: Evaluator
    times: Floats
    frames: Sequence[Frame]
    codes: NDArray[np.uint8]
    margins: Floats
    faults: dict[int, str]
    in_step: Sequence[Mapping[tuple[str, int], RuleResult]] = ()

    @property
    def rules(self) -> list[str]:
        return [rule.name for rule in self.evaluator.rules]

    @property
    def unsafe(self) -> NDArray[np.bool_]:
        """(cycles, candidates, rules)"""
        found: NDArray[np.bool_] = np.isin(self.codes, _UNSAFE)
        return found

    @property
    def active(self) -> NDArray[np.bool_]:
        """(cycles, candidates, rules): where the rule said something."""
        found: NDArray[np.bool_] = self.codes != _INACTIVE
        return found

    def result(self, cycle: int, candidate: int, rule: int) -> RuleResult:
        """One outcome with its witness."""
        known = self.in_step[cycle].get((CANDIDATES[candidate], rule)) if self.in_step else None
        if known is not None:
            return known
        (judged,) = self.evaluator.judge_all([self.frames[cycle]])
        return judged.rated[CANDIDATES[candidate]].explain(rule, False)


def judge(
    recording: Recording, evaluator: Evaluator, watch: Callable[[Sequence[Any]], Iterable[Any]] = iter
) -> Judgement:
    """All cycles of a recording, through the door, by all rules; `watch` wraps the chunks of work."""
    check_fit(recording, evaluator)
    tables, _ = known_tables(recording, evaluator.spec)
    times, number = np.array([cycle.t for cycle in recording.cycles]), len(evaluator.rules)
    over_run = [place for place, rule in enumerate(evaluator.rules) if remembers(rule)]
    if over_run:
        # Asked about one frame by itself, they take it for the first and only cycle of a run.
        seen, parts, said = [], [], []
        for _, judged, _ in supervised(recording, evaluator, tables, watch):
            seen.append(judged.about)
            parts.append(_listed([judged], number))
            # All that was said would keep what was computed of each cycle: of an hour, gigabytes.
            said.append({(name, rule): one.explain(rule, False) for name, one in judged.rated.items() for rule in over_run})  # fmt: skip
        return Judgement(evaluator, times, seen, *_joined(parts, number), _breaches(seen), said)
    box = rulebox(evaluator, known_params(recording, evaluator.spec), tables)
    door = box.supervisor(box.open_loop).door
    frames = [
        shown(door.admit(-1, cycle, cycle.t).frame)
        for cycle in cycles(recording, further_names(recording, evaluator))
    ]
    codes, margins = rated(evaluator.program, frames, number, watch)
    return Judgement(evaluator, times, frames, codes, margins, _breaches(frames))


def _breaches(frames: Sequence[Frame]) -> dict[int, str]:
    return {place: str(frame.faults[0]) for place, frame in enumerate(frames) if frame.faults}


def rated(
    program: Program,
    frames: Sequence[Frame],
    rules: int,
    watch: Callable[[Sequence[Any]], Iterable[Any]] = iter,
) -> tuple[NDArray[np.uint8], Floats]:
    """Codes and margins (frames, candidates, rules) of frames that are judged each by itself."""
    parts = [
        _listed(program.judge_all(frames[start : start + CHUNK]), rules)
        for start in watch(range(0, len(frames), CHUNK))
    ]
    return _joined(parts, rules)


def _joined(
    parts: Sequence[tuple[NDArray[np.uint8], Floats]], rules: int
) -> tuple[NDArray[np.uint8], Floats]:
    codes, margins = zip(*parts or [_listed([], rules)])
    return np.concatenate(codes), np.concatenate(margins)


def _listed(found: Sequence[Judged], rules: int) -> tuple[NDArray[np.uint8], Floats]:
    """Codes and margins (cycles, candidates, rules); a candidate that is not there is undefined."""
    codes = np.full((len(found), len(CANDIDATES), rules), VERDICTS.index("undefined"), np.uint8)
    margins = np.full(codes.shape, np.nan)
    for place, judged in enumerate(found):
        for number, name in enumerate(CANDIDATES):
            one = judged.rated.get(name)
            if one is not None:
                codes[place, number] = np.frombuffer(one.verdicts, np.uint8)
                margins[place, number] = one.margins
    return codes, margins
