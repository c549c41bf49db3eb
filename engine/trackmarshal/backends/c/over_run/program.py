"""Programs whose rules remember, in generated C: each run has a context of its own, in which all is kept."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import TYPE_CHECKING, Any

from trackmarshal.backends.c.over_run.explaining import Explaining
from trackmarshal.backends.c.program import CProgram
from trackmarshal.backends.c.saving import MOST_OF_RULES, bytes_of, numbers_of, pages, words
from trackmarshal.backends.over_run.outcome import is_ahead
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.contract import PLAN
from trackmarshal.runtime.driven import as_driven, in_doubt
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Judged, Memory, Rated, advisory
from trackmarshal.runtime.saving import Piece, Pieces, count, unsaved
from trackmarshal.runtime.verdict import VERDICTS, About

if TYPE_CHECKING:
    from trackmarshal.runtime.decision import Decision

_UNDEFINED = VERDICTS.index("undefined")


@dataclass(slots=True)
class _Run:
    """One run: its context, and how many of its cycles are past."""

    program: CProgram
    cycles: int = 0
    #: What the cycles are called that rules that look ahead keep, by their numbers in the run.
    names: dict[int, object] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _Kept(Memory):
    """What is remembered after so many cycles of a run."""

    run: _Run
    cycles: int


class CRemembering:
    """The compiled rules, some of which are over the run. What a run remembers can be used once: whatever follows takes it over.

    Raises TrackmarshalError E470 to E473.
    """

    backend = "c"

    def __init__(self, spec: Spec, rules: Sequence[RuleInfo]) -> None:
        self.spec = spec
        self._program = CProgram(spec, rules)
        self.rules: Sequence[RuleInfo] = self._program.rules
        self._explaining = Explaining(spec, self.rules)
        self._ahead = {place: rule for place, rule in enumerate(self.rules) if is_ahead(rule)}

    def library_for(self) -> None:
        """Compile the program, for what most runs have."""
        self._program.library_for()

    @property
    def identity(self) -> Mapping[str, Any]:
        return self._program.identity

    def start(self) -> Memory:
        return _Kept(_Run(self._program.anew()), 0)

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        run = self._run(memory)
        return Judged(frame, {name: self._rated(run, one) for name, one in frame.seen()})

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        """Each frame as the first and only cycle of a run, at whatever time it has."""
        run = _Run(self._program.anew())
        run.program.room_for(frames)
        stamped = (replace(frame, t=0.0) if frame.t is None else frame for frame in frames)
        return [
            Judged(frame, {name: self._rated(run, one) for name, one in frame.seen()}) for frame in stamped
        ]

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        if in_doubt(frame, decision):
            return self.missed(memory)
        run = self._run(memory)
        driven = as_driven(frame, decision)
        run.program.remember(driven, not any(fault.signal == PLAN for fault in driven.faults))
        run.cycles += 1
        if self._ahead:
            oldest, following = run.program.present()
            run.names[following - 1] = frame.number
            run.names = {number: name for number, name in run.names.items() if number >= oldest}
        return _Kept(run, run.cycles)

    def missed(self, memory: Memory, cycles: int = 1) -> Memory:
        run = self._run(memory)
        run.program.skip(cycles)
        run.cycles += 1
        return _Kept(run, run.cycles)

    def end(self, memory: Memory) -> dict[str, tuple[About, ...]]:
        run = self._run(memory)
        found = {rule.name: self._about(run, rule, None, True) for rule in self._ahead.values()}
        return {name: said for name, said in found.items() if said}

    def _about(self, run: _Run, rule: RuleInfo, now: object, ended: bool = False) -> tuple[About, ...]:
        """What a rule that looks ahead says, and of which cycles; the present one is called `now`."""
        return tuple(
            About(run.names.get(number, now), verdict, margin, final)
            for number, verdict, margin, final in run.program.about(rule, ended)
        )

    def kept(self) -> tuple[str, str]:
        """Who can restore what a run remembers, and in words what that is made of. Raises TrackmarshalError E486 where it is too much."""
        library = self._program.library_for()
        size = int(library.dll.tmg_remembered_size())
        digest = hashlib.sha256(self._program.source.source.encode()).hexdigest()
        return self.backend, words(digest, [(0, size)], library.sizes, MOST_OF_RULES)

    def save(self, memory: Memory) -> Iterator[Piece]:
        """What a run remembers, taken now, as pieces that are made later."""
        run = self._run(memory)
        data, numbers, following = run.program.remembered()
        names = sorted(run.names.items())
        for _, name in names:
            if name is not None and type(name) not in (int, str):
                raise unsaved(f"a cycle is called {name!r:.40}, which is neither a number nor a text")
        head: Piece = [
            "rules", run.cycles, following, len(data), [list(each) for each in names], run.program.elements,
        ]  # fmt: skip
        return chain([head, ["ids", numbers]], pages(data))

    def restored(self, pieces: Pieces) -> Memory:
        """Raises ValueError, KeyError, TypeError or IndexError for what was not saved by such a program."""
        cycles, following, size, listed, elements = pieces.next("rules", 5)
        numbers = numbers_of(pieces, following)
        run = _Run(self._program.anew(), count(cycles))
        for number, name in listed:
            if name is not None and type(name) not in (int, str):
                raise ValueError("a cycle is called otherwise")
            run.names[count(number)] = name
        run.program.put_back(bytes_of(pieces, count(size)), numbers, count(following), count(elements))
        return _Kept(run, run.cycles)

    @staticmethod
    def _run(memory: Memory) -> _Run:
        assert isinstance(memory, _Kept)
        if memory.run.cycles != memory.cycles:
            raise RuntimeError("the memory of an earlier cycle was taken over by a later one")
        return memory.run

    def _rated(self, run: _Run, frame: Frame) -> Rated:
        verdicts, margins = run.program.run([frame])
        codes, own = bytearray(verdicts.tobytes()), list(margins)
        for place, rule in enumerate(self.rules):
            if frame.faults and frame.unusable(rule.reads) is not None:
                codes[place], own[place] = _UNDEFINED, math.nan

        known = bytes(codes)
        about = {place: self._about(run, rule, frame.number) for place, rule in self._ahead.items()}
        return Rated(
            known,
            own,
            self._explaining.of(frame, known, own, about, run.program.without(frame)),
            advisory(self.rules),
        )
