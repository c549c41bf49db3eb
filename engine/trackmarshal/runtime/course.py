"""What was driven and what is planned as one timeline: what a run remembers of it, and the columns that rules see.

Source: the language's section on what was (section 11 of its definition). Stamps are whole nanoseconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence, Set
from dataclasses import replace
from typing import NamedTuple

from trackmarshal.ir.overrun import nanoseconds, stamped
from trackmarshal.ir.reads import reads
from trackmarshal.ir.spec import CourseInfo, RuleInfo
from trackmarshal.runtime.frame import Columns, Frame, Joined, Names
from trackmarshal.runtime.saving import Piece, Pieces, checked, count, spelt, unspelt

#: A Boolean that is not known, among those of columns.
_MISSING = -1


class Sample(NamedTuple):
    """A record of what was driven at a stamp [ns]; missed: how many cycles are missing between the stamp `after` and it; 0: there is no gap."""

    t: int
    values: tuple[float, ...]
    flags: tuple[int, ...]
    missed: int
    after: int


class Lived(NamedTuple):
    """What is remembered of one course: samples, the oldest first; the last stamp (None: there was no cycle yet); and how many cycles are missing since then."""

    samples: tuple[Sample, ...] = ()
    last: int | None = None
    missed: int = 0


class Courses:
    """The courses that some rules live along. A state is a value: a step gives another one, and leaves it as it is."""

    def __init__(self, rules: Iterable[RuleInfo]) -> None:
        found: dict[str, tuple[CourseInfo, set[str]]] = {}
        for rule in rules:
            if rule.course is not None:
                name = rule.course.signal.name
                read = reads(rule.formula) | reads(rule.active)
                found.setdefault(name, (rule.course, set()))[1].update(
                    field for signal, field in read if signal == name
                )
        self.infos = tuple(info for info, _ in found.values())
        #: What rules read of each: frames have no more.
        self._names = [_names(info, read) for info, read in found.values()]

    def start(self) -> tuple[Lived, ...]:
        return (Lived(),) * len(self.infos)

    def joined(self, state: Sequence[Lived], frame: Frame) -> Frame:
        """A frame that rates a candidate, or a case, with its courses among its columns."""
        if not self.infos:
            return frame
        made = {
            info.signal.name: _columns(info, names, lived, frame)
            for info, names, lived in zip(self.infos, self._names, state)
        }
        return replace(frame, columns={**frame.columns, **made})

    def commit(self, state: Sequence[Lived], frame: Frame) -> tuple[Lived, ...]:
        """After a cycle that was accepted."""
        return tuple(
            _with(info, names, lived, frame) for info, names, lived in zip(self.infos, self._names, state)
        )

    def missed(self, state: Sequence[Lived], cycles: int = 1) -> tuple[Lived, ...]:
        """After so many cycles that were refused, or did not come; what comes before the first cycle is no gap."""
        return tuple(
            lived._replace(missed=0 if lived.last is None else lived.missed + cycles) for lived in state
        )

    @property
    def described(self) -> str:
        """In words, what a state is made of."""
        return "\n".join(
            f"course {info.signal.name} {info.lived} {info.back} {info.planned} {names.rows}"
            for info, names in zip(self.infos, self._names)
        )

    def save(self, state: Sequence[Lived]) -> Iterator[Piece]:
        """A state as plain data."""
        for lived in state:
            yield ["course", len(lived.samples), lived.last, lived.missed]
            for one in lived.samples:
                yield ["driven", one.t, one.missed, one.after, list(map(spelt, one.values)), list(one.flags)]

    def load(self, pieces: Pieces) -> tuple[Lived, ...]:
        """The state again; raises ValueError or TypeError for what was not saved of such courses."""
        return tuple(_loaded(pieces, names) for names in self._names)


def _names(info: CourseInfo, read: Set[str]) -> Names:
    """The columns of a course: the time, and what is read of it."""
    time, *others = info.signal.fields_
    fields = [time, *(field for field in others if field.name in read)]
    numbers = [field.name for field in fields if field.kind == "number"]
    return Names(numbers, [field.name for field in fields if field.kind == "bool"])


def _sample(info: CourseInfo, names: Names, frame: Frame) -> tuple[tuple[float, ...], tuple[int, ...]]:
    """The record that is now: numbers without the time, and flags; nothing of it is known where its signal cannot be used."""
    if frame.unusable([(info.lived, "")]) is not None:
        return (math.nan,) * (len(names.numbers) - 1), (_MISSING,) * len(names.flags)
    own = frame.columns[info.lived]

    def known(name: str) -> bool:
        return name in own.names.rows and frame.unusable([(info.lived, name)]) is None

    values = tuple(float(own.column(name)[0]) if known(name) else math.nan for name in names.numbers[1:])
    flags = tuple(int(own.column(name)[0]) if known(name) else _MISSING for name in names.flags)
    return values, flags


def _now(info: CourseInfo, names: Names, lived: Lived, frame: Frame) -> Sample:
    return Sample(
        _stamp(frame), *_sample(info, names, frame), lived.missed, 0 if lived.last is None else lived.last
    )


def _with(info: CourseInfo, names: Names, lived: Lived, frame: Frame) -> Lived:
    this = _now(info, names, lived, frame)
    return Lived((*(one for one in lived.samples if one.t >= this.t - info.back), this), this.t)


def _columns(info: CourseInfo, names: Names, lived: Lived, frame: Frame) -> Columns:
    """(numbers, samples): what was, gaps between, the sample that is now, and what is planned after it."""
    this = _now(info, names, lived, frame)
    now = this.t
    rows: list[tuple[float, ...]] = []
    flags: list[tuple[int, ...]] = []
    spans: list[tuple[int, int]] = []
    gaps: list[int] = []
    missing: list[int] = []
    unknown, unsaid = (math.nan,) * (len(names.numbers) - 1), (_MISSING,) * len(names.flags)
    for one in (*(one for one in lived.samples if one.t >= now - info.back), this):
        # A gap counts as far as it lies in the time that is looked at. Between stamps that are next to each other is no time at all.
        if one.missed and one.t - one.after > 1 and one.t > now - info.back:
            gaps.append(len(rows))
            missing.append(one.missed)
            spans.append((one.after + 1 - now, one.t - 1 - now))
            rows.append(((one.after + 1 - now) / 1e9, *unknown))
            flags.append(unsaid)
        spans.append((one.t - now, one.t - now))
        rows.append(((one.t - now) / 1e9, *one.values))
        flags.append(one.flags)
    at = len(rows) - 1
    if frame.unusable([(info.planned, "t")]) is None:
        plan = frame.columns[info.planned]
        there = plan.names.rows
        values = [plan.listed(name) if name in there else [math.nan] * plan.count for name in names.numbers]
        truths = [
            plan.column(name).tolist() if name in there else [_MISSING] * plan.count for name in names.flags
        ]
        if not all(math.isfinite(t * 1e9) for t in values[0]):  # when they are due, nobody can count
            return _unknown(names)
        if nanoseconds(values[0][-1]) < 0:  # it was over before now, and says nothing of what comes
            return _unknown(names)
        for row in zip(*values, *truths):
            due = nanoseconds(row[0])
            if due > 0:  # two may be due in one nanosecond: none of them is left out
                spans.append((due, due))
                rows.append(row[: len(values)])
                flags.append(row[len(values) :])
    import numpy as np  # not before a run: what checks specs does without

    made = Columns(names, np.array(rows).T, np.array(flags, dtype=np.int8).reshape(len(rows), -1).T)
    begin, end = (np.array(edge, dtype=np.float64) for edge in zip(*spans))
    made.joined = Joined(at, begin, end, tuple(gaps), tuple(missing))
    return made


def _unknown(names: Names) -> Columns:
    """One sample, now, of which nothing is known."""
    import numpy as np

    made = Columns(
        names,
        np.full((len(names.numbers), 1), np.nan),
        np.full((len(names.flags), 1), _MISSING, dtype=np.int8),
    )
    made.joined = Joined(0, np.zeros(1), np.zeros(1), (), ())
    return made


def _stamp(frame: Frame) -> int:
    assert frame.t is not None, "a cycle of a run has a stamp"
    return stamped(frame.t)


def _loaded(pieces: Pieces, names: Names) -> Lived:
    many, last, missed = pieces.next("course", 3)
    samples = []
    for _ in range(count(many)):
        t, gap, after, values, flags = pieces.next("driven", 5)
        numbers = tuple(unspelt(value) for value in checked(values, list))
        said = tuple(checked(flag, int) for flag in checked(flags, list))
        samples.append(Sample(checked(t, int), numbers, said, count(gap), checked(after, int)))
    if any(
        len(one.values) != len(names.numbers) - 1 or len(one.flags) != len(names.flags) for one in samples
    ):
        raise ValueError("a sample has other fields than its course")
    if last is None and (samples or missed):
        raise ValueError("what is remembered of no cycle")
    if any(one.t >= other.t for one, other in zip(samples, samples[1:])):
        raise ValueError("the samples of a course follow each other")
    return Lived(tuple(samples), None if last is None else checked(last, int), count(missed))
