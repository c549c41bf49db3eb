"""What became of one rule: which verdicts turned, how margins moved, and one word for it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.verdict import UNSAFE, VERDICTS
from trackmarshal.scenarios.recording import CANDIDATES

EQUAL, STRICTER, WEAKER, MIXED = "equal", "stricter", "weaker", "mixed"
NOT_COMPARABLE, NEW, GONE = "not comparable", "new", "gone"
_OPEN = VERDICTS.index("open")
_UNSAFE = [VERDICTS.index(name) for name in UNSAFE]


@dataclass(frozen=True, slots=True)
class Moment:
    """A cycle of a recording, with the candidate; t in s."""

    recording: str
    t: float
    candidate: str


@dataclass(frozen=True, slots=True)
class Flip:
    """Cycles in which a verdict turned; spans: (first, last) times in s of cycles one after the other."""

    recording: str
    candidate: str
    old: str
    new: str
    cycles: int
    spans: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Margins:
    """How margins moved where both are finite, new less old, in SI, over the cycles in which they did."""

    cycles: int
    least: float
    median: float
    most: float
    least_at: Moment
    most_at: Moment


@dataclass(frozen=True, slots=True)
class RuleChange:
    """What became of a rule. name: its new name (of one that is gone, its old one); was: its old one, where it has another now.

    word: EQUAL; STRICTER: nowhere a larger margin, and nothing that was against a candidate is not any more; WEAKER: the other way round; MIXED: both;
    NOT_COMPARABLE: what cannot be held against each other, as in another unit, or no cycle to compare; NEW, GONE. cycles: how many were compared,
    a cycle for each candidate; changed: in how many of them verdict or margin differ. severity: old and new, where they differ. unsafe: of NEW and
    GONE, in how many cycles it is against the candidate. undecided: cycles that the recording's end leaves open on one side alone; they are left out.
    """

    name: str
    word: str
    unit: str
    cycles: int = 0
    changed: int = 0
    was: str = ""
    flips: tuple[Flip, ...] = ()
    margins: Margins | None = None
    severity: tuple[str, str] | None = None
    unsafe: int = 0
    undecided: int = 0


@dataclass(frozen=True, slots=True)
class Column:
    """What one rule said in one recording, before and after. (cycles, candidates) each; codes: places in VERDICTS; margins in SI."""

    recording: str
    times: NDArray[np.float64]
    there: NDArray[np.bool_]
    old_codes: NDArray[np.uint8]
    new_codes: NDArray[np.uint8]
    old_margins: NDArray[np.float64]
    new_margins: NDArray[np.float64]


def changed(old: RuleInfo, new: RuleInfo, columns: Sequence[Column], alike: bool = True) -> RuleChange:
    """What became of a rule, over all recordings. alike: margins of the same units are those of the same dimensions, by the same scales."""
    alike = alike and old.unit == new.unit
    stricter = weaker = unlike = differing = cycles = undecided = 0
    for one in columns:
        # The recording ends before something is decided on one side: nobody knows whether it differs.
        waits = one.there & ((one.old_codes == _OPEN) != (one.new_codes == _OPEN))
        undecided += int(waits.sum())
        there = one.there & ~waits
        was, is_ = np.isin(one.old_codes, _UNSAFE), np.isin(one.new_codes, _UNSAFE)
        numbers = ~np.isnan(one.old_margins) & ~np.isnan(one.new_margins) & alike
        lower, higher = (
            numbers & (one.new_margins < one.old_margins),
            numbers & (one.new_margins > one.old_margins),
        )
        same = (one.old_margins == one.new_margins) | (np.isnan(one.old_margins) & np.isnan(one.new_margins))
        moved = (one.old_codes != one.new_codes) | ~same
        # Where the side stays and no margin says which is more (undefined, open, a rule that began to apply), nothing can be said.
        dark = moved & (was == is_) & ~lower & ~higher
        stricter += int((there & (lower | (is_ & ~was))).sum())
        weaker += int((there & (higher | (was & ~is_))).sum())
        unlike += int((there & dark).sum())
        differing += int((there & moved).sum())
        cycles += int(there.sum())
    severity = (old.severity, new.severity) if old.severity != new.severity else None
    if old.advisory != new.advisory:  # what decided only warns now, or the other way round
        stricter, weaker = (stricter, weaker + 1) if new.advisory else (stricter + 1, weaker)
    word = _word(stricter, weaker, unlike or not cycles or not alike)
    if word == EQUAL and undecided:
        word = NOT_COMPARABLE
    return RuleChange(
        new.name, word, new.unit, cycles, differing, old.name if old.name != new.name else "", tuple(_flips(columns)),
        _margins(columns) if alike else None, severity, undecided=undecided,
    )  # fmt: skip


def alone(
    rule: RuleInfo, word: str, columns: Sequence[tuple[NDArray[np.bool_], NDArray[np.uint8]]]
) -> RuleChange:
    """A rule that only one side has; columns: there and codes, (cycles, candidates) each."""
    cycles = sum(int(there.sum()) for there, _ in columns)
    unsafe = sum(int((there & np.isin(codes, _UNSAFE)).sum()) for there, codes in columns)
    return RuleChange(rule.name, word, rule.unit, cycles, unsafe=unsafe)


def _word(stricter: int, weaker: int, unlike: int | bool) -> str:
    if unlike:
        return NOT_COMPARABLE
    if stricter and weaker:
        return MIXED
    return STRICTER if stricter else WEAKER if weaker else EQUAL


def _flips(columns: Iterable[Column]) -> Iterable[Flip]:
    for one in columns:
        for candidate, name in enumerate(CANDIDATES):
            old, new = one.old_codes[:, candidate], one.new_codes[:, candidate]
            turned = one.there[:, candidate] & (old != new) & ((old == _OPEN) == (new == _OPEN))
            for before, after in sorted({(int(a), int(b)) for a, b in zip(old[turned], new[turned])}):
                found = np.flatnonzero(turned & (old == before) & (new == after))
                yield Flip(
                    one.recording,
                    name,
                    VERDICTS[before],
                    VERDICTS[after],
                    len(found),
                    spans(found, one.times),
                )


def spans(found: NDArray[np.intp], times: NDArray[np.float64]) -> tuple[tuple[float, float], ...]:
    """Places in ascending order as (first, last) times of those one after the other."""
    if not len(found):
        return ()
    parts = np.split(found, np.flatnonzero(np.diff(found) > 1) + 1)
    return tuple((float(times[part[0]]), float(times[part[-1]])) for part in parts)


def _margins(columns: Sequence[Column]) -> Margins | None:
    deltas: list[NDArray[np.float64]] = []
    places: list[Moment] = []
    for one in columns:
        both = (
            one.there
            & np.isfinite(one.old_margins)
            & np.isfinite(one.new_margins)
            & (one.old_margins != one.new_margins)
        )
        at = np.argwhere(both)
        deltas.append(one.new_margins[both] - one.old_margins[both])
        places += [
            Moment(one.recording, float(one.times[cycle]), CANDIDATES[candidate]) for cycle, candidate in at
        ]
    if not places:
        return None
    all_ = np.concatenate(deltas)
    least, most = int(all_.argmin()), int(all_.argmax())
    return Margins(
        len(all_), float(all_[least]), float(np.median(all_)), float(all_[most]), places[least], places[most]
    )
