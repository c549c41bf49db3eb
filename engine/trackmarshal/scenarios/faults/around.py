"""A program that is asked through another one: what a wrapper does not say itself, the program inside says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Judged, Memory, Program
from trackmarshal.runtime.verdict import About


class Around:
    """All of a program but `judge`."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self.spec, self.rules, self.identity = program.spec, program.rules, program.identity

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        return self._program.judge_all(frames)

    def start(self) -> Memory:
        return self._program.start()

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        return self._program.commit(memory, frame, decision)

    def missed(self, memory: Memory, cycles: int = 1) -> Memory:
        return self._program.missed(memory, cycles)

    def end(self, memory: Memory) -> Mapping[str, tuple[About, ...]]:
        return self._program.end(memory)


__all__ = ["Around"]
