"""Programs whose rules remember, in generated C: each run has a context of its own, in which all is kept."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from trackmarshal.backends.c.over_run.explaining import Explaining
from trackmarshal.backends.c.program import CProgram
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.contract import PLAN
from trackmarshal.runtime.driven import as_driven, in_doubt
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Judged, Memory, Rated, advisory
from trackmarshal.runtime.verdict import VERDICTS, About

if TYPE_CHECKING:
    from trackmarshal.runtime.decision import Decision

_UNDEFINED = VERDICTS.index("undefined")


@dataclass(slots=True)
class _Run:
    """One run: its context, and how many of its cycles are past."""

    program: CProgram
    cycles: int = 0


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

    def library_for(self) -> None:
        """Compile the program, for what most runs have."""
        self._program.library_for()

    @property
    def identity(self) -> Mapping[str, Any]:
        return self._program.identity

    def start(self) -> Memory:
        return _Kept(_Run(self._program.anew()), 0)

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        program = self._run(memory).program
        return Judged(frame, {name: self._rated(program, one) for name, one in frame.seen()})

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        """Each frame as the first and only cycle of a run."""
        program = self._program.anew()
        return [
            Judged(frame, {name: self._rated(program, one) for name, one in frame.seen()}) for frame in frames
        ]

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        if in_doubt(frame, decision):
            return self.missed(memory)
        run = self._run(memory)
        driven = as_driven(frame, decision)
        run.program.remember(driven, not any(fault.signal == PLAN for fault in driven.faults))
        run.cycles += 1
        return _Kept(run, run.cycles)

    def missed(self, memory: Memory) -> Memory:
        run = self._run(memory)
        run.program.skip()
        run.cycles += 1
        return _Kept(run, run.cycles)

    def end(self, memory: Memory) -> dict[str, tuple[About, ...]]:
        """Nothing is open: rules look back alone."""
        return {}

    @staticmethod
    def _run(memory: Memory) -> _Run:
        assert isinstance(memory, _Kept)
        if memory.run.cycles != memory.cycles:
            raise RuntimeError("the memory of an earlier cycle was taken over by a later one")
        return memory.run

    def _rated(self, program: CProgram, frame: Frame) -> Rated:
        verdicts, margins = program.run([frame])
        codes, own = bytearray(verdicts.tobytes()), list(margins)
        for place, rule in enumerate(self.rules):
            if frame.faults and frame.unusable(rule.reads) is not None:
                codes[place], own[place] = _UNDEFINED, math.nan

        known = bytes(codes)
        return Rated(known, own, self._explaining.of(frame, known, own), advisory(self.rules))
