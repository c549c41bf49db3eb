"""Judging the frames of a campaign: most of its faults have the same cycles before and after them, which are judged once by themselves, and
once more together with others."""

from __future__ import annotations

from collections.abc import Hashable, Mapping

from trackmarshal.backends.results import Stateless
from trackmarshal.runtime.frame import Columns, Frame, Settings
from trackmarshal.runtime.lines import Line
from trackmarshal.runtime.program import Judged, Memory, Program, Rated
from trackmarshal.scenarios.faults.around import Around


class Judging(Around):
    """A program, asked once about frames that are the same in every bit. Where its rules remember, it is asked about every one."""

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self._remembers = not isinstance(program, Stateless)
        self._known: dict[Hashable, Mapping[str, Rated]] = {}
        #: Settings by their identity, which stays theirs for as long as they are kept.
        self._settings: dict[int, Settings] = {}
        #: Frames that were judged once, as they came last.
        self._once: dict[Hashable, Frame] = {}

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        key = None if self._remembers else _content(frame)
        if key is None:
            return self._program.judge(memory, frame)
        self._settings[id(frame.settings)] = frame.settings
        rated = self._known.get(key)
        if rated is None:
            judged = self._program.judge(memory, frame)
            if judged.about is not frame:
                return judged  # nobody takes it for an answer
            rated = self._known[key] = judged.rated
            self._once[key] = frame
        elif key in self._once:
            self._once[key] = frame
        return Judged(frame, rated)

    def confirmed(self) -> bool:
        """Whether the frames that have been judged once come out the same again, all together."""
        again, self._once = self._once, {}
        if not again:
            return True
        found = self._program.judge_all(list(again.values()))
        return all(
            _said(self._known[key]) == _said(judged.rated) for key, judged in zip(again, found, strict=True)
        )


def _said(rated: Mapping[str, Rated]) -> list[tuple[str, bytes, list[str]]]:
    return [(name, one.verdicts, list(map(repr, one.margins))) for name, one in rated.items()]


def _content(frame: Frame) -> Hashable | None:
    """All that rules see of a frame; None where that is more than is compared here."""
    signals = {**frame.columns, **frame.candidates}
    if frame.lanes or any(columns.joined is not None for columns in signals.values()):
        return None
    return (
        tuple((name, _of(columns)) for name, columns in frame.columns.items()),
        tuple((name, _of(columns)) for name, columns in frame.candidates.items()),
        tuple(frame.events.items()),
        tuple((place, _points(line)) for place, line in frame.lines.items()),
        tuple(frame.closed.items()),
        tuple(map(repr, frame.faults)),
        id(frame.settings),
        frame.orders,
        frame.straight,
        repr((frame.t, frame.number)),
    )


def _of(columns: Columns) -> Hashable:
    flags = None if columns.flags is None else columns.flags.tobytes()
    names = columns.names.numbers, columns.names.flags
    return names, columns.count, columns.packed(), flags, columns.ids, columns.absent


def _points(line: Line) -> bytes:
    return line.points.astype("<f8").tobytes()
