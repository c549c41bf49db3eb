"""Cases as the cycles of one run, one after the other: what rules remember between them is kept, saved and restored."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING

from trackmarshal.errors import wrong_type
from trackmarshal.runtime import saving
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.stamps import stamp_after
from trackmarshal.runtime.verdict import About, CaseResult

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator


class Run:
    """Cases as the cycles of one run. `step` takes them in order; `end` says what was open after the last one."""

    def __init__(self, evaluator: Evaluator, saved: Sequence[str] | None = None) -> None:
        self._evaluator = evaluator
        #: The same to the end: an evaluator that has to do without C takes another one for what comes.
        self._program = evaluator.program
        self._memory = self._program.start()
        self._last: int | None = None
        if saved is not None:
            self._restore(saved)

    def save(self) -> list[str]:
        """What the rules remember now, as lines of JSON (docs/memory.md). Raises TrackmarshalError E486 for an evaluator that saves none, and
        for a cycle whose name is neither a whole number nor a text."""
        kind, of = self._of()
        pieces: list[saving.Piece] = [["run", self._last]]
        return saving.whole(saving.Saving(kind, of, chain(pieces, saving.save(self._program, self._memory))))

    def _restore(self, saved: Sequence[str]) -> None:
        pieces = saving.opened(saved, *self._of())
        try:
            (last,) = pieces.next("run", 1)
            self._last = None if last is None else saving.checked(last, int)
            self._memory = saving.restored(self._program, pieces)
            pieces.end()
        except saving.NOT_SAVED as error:
            raise saving.damaged(str(error)) from error

    def _of(self) -> tuple[str, str]:
        """Who can restore it, and the hash of all that it rests on."""
        program = self._program
        kind, words = saving.kept_by(program)
        return kind, saving.meaning(program.spec, [rule.name for rule in program.rules], words, more="run")

    def step(self, frame: Frame, series: bool = False) -> CaseResult:
        """The result of the next cycle. Raises TrackmarshalError D206 for a stamp that is none, or not after the last one, D211 for a curvature that
        is not there."""
        with self._coming(frame):
            judged = self._program.judge(self._memory, frame)
            self._memory = self._program.commit(self._memory, frame, None)
            ((_, rated),) = judged.rated.items()
            return self._evaluator.result(frame, rated, series)

    def remember(self, frame: Frame) -> None:
        """The next cycle, of which only what is remembered of it is asked. Raises TrackmarshalError as `step`."""
        with self._coming(frame):
            self._memory = self._program.commit(self._memory, frame, None)

    @contextmanager
    def _coming(self, frame: Frame) -> Iterator[None]:
        """With a frame that can follow."""
        if not isinstance(frame, Frame):
            raise wrong_type("a frame is what `Evaluator.read` makes of a case", frame)
        self._evaluator.refuse_straight(frame)
        with self._evaluator.alone:
            self._last = stamp_after(frame, self._last)
            yield

    def missed(self) -> None:
        """A cycle that could not be read: a gap."""
        self._memory = self._program.missed(self._memory)

    def end(self) -> Mapping[str, tuple[About, ...]]:
        """By rule, what is said of cycles that were open."""
        return self._program.end(self._memory)
