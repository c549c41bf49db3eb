"""Every cycle of a run, whole, as it was remembered: for whoever explains what came of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from trackmarshal.backends.over_run.history import Past
from trackmarshal.backends.over_run.now import happening
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.backends.reference.functions import Functions
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.driven import as_driven, in_doubt
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Judged, Memory, Program
from trackmarshal.runtime.verdict import About

if TYPE_CHECKING:
    from trackmarshal.runtime.decision import Decision


def past(spec: Spec, frame: Frame, missed: int, functions: Functions | None = None) -> Past:
    """A cycle as one candidate, or what was driven, has it. missed: how many cycles are missing before it. functions: of nodes, for all cycles."""
    now = happening(frame, Reference(spec, frame, functions=functions))
    return Past(now.t, now.name, now.ids, now.leaf, now.number, missed, now)


class Keeping:
    """A program; what it is given to remember is kept besides. missed_since: how many cycles are missing after the last."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self.spec, self.rules, self.identity = program.spec, program.rules, program.identity
        self.cycles: list[Past] = []
        self.missed_since = 0
        self._functions = Functions()

    def start(self) -> Memory:
        return self._program.start()

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        return self._program.judge(memory, frame)

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        return self._program.judge_all(frames)

    def end(self, memory: Memory) -> Mapping[str, tuple[About, ...]]:
        return self._program.end(memory)

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        if in_doubt(frame, decision):
            self._missed(1)
        else:
            self.cycles.append(
                past(self.spec, as_driven(frame, decision), self.missed_since, self._functions)
            )
            self.missed_since = 0
        return self._program.commit(memory, frame, decision)

    def missed(self, memory: Memory, cycles: int = 1) -> Memory:
        self._missed(cycles)
        return self._program.missed(memory, cycles)

    def _missed(self, cycles: int) -> None:
        # What comes before the first cycle is no gap.
        self.missed_since += cycles if self.cycles else 0
