"""A Supervisor with a judge and a clock that tests control."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import load
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Judged, Memory, Rated, advisory
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.runtime.verdict import VERDICTS, About, RuleResult

ROOT = Path(__file__).resolve().parents[2]


#: Whatever the shipped rules say, each evaluator says.
BACKENDS = pytest.mark.parametrize(
    "backend", ["reference", "numpy", pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))]
)  # fmt: skip


@cache
def shipped() -> Spec:
    return load([ROOT / "specs" / "supervisor"])


@cache
def everything() -> Spec:
    """All shipped specs, from the root of the project."""
    return load([ROOT / "specs"], [], ROOT)


def against(given: Cycle, backend: str) -> set[tuple[str, str]]:
    """Which shipped rules are against which candidate of a cycle that a Supervisor gets first, and in which nothing else is wrong."""
    decision = tm.supervisor(shipped(), backend=backend, clock=lambda: 0.0).step(given)
    assert decision.faults == ()
    assert decision.safe == (not decision.violations)
    return {(one.rule, one.candidate) for one in decision.violations}


class Clock:
    """Shows what it is told to; `ticks`, where there are any, first."""

    def __init__(self) -> None:
        self.now = 0.0
        self.ticks: list[Any] = []

    def __call__(self) -> float:
        value = self.ticks.pop(0) if self.ticks else self.now
        if isinstance(value, Exception):
            raise value
        return value


class Oracle:
    """A program that says what it is told to: `unsafe` names (candidate, rule) pairs; `act` replaces it altogether."""

    identity: Mapping[str, Any] = {"fingerprint": "oracle", "backend": "oracle"}

    def __init__(self, rules: Sequence[str] | None = None) -> None:
        self.spec = shipped()
        self.rules: Sequence[RuleInfo] = [
            r for r in shipped().rules if r.formula is not None and (rules is None or r.name in rules)
        ]
        self.unsafe: set[tuple[str, str]] = set()
        self.act: Callable[[Frame], Any] | None = None
        self.asked = 0

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        self.asked += 1
        if self.act is not None:
            return self.act(frame)  # type: ignore[no-any-return]
        return Judged(frame, {name: self.say(name) for name in ("driving", "emergency")})

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        return [self.judge(Memory(), frame) for frame in frames]

    def start(self) -> Memory:
        return Memory()

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        return memory

    def missed(self, memory: Memory, cycles: int = 1) -> Memory:
        return memory

    def end(self, memory: Memory) -> Mapping[str, tuple[About, ...]]:
        return {}

    def say(self, candidate: str) -> Rated:
        codes = [int((candidate, rule.name) in self.unsafe) for rule in self.rules]
        return self.rated(bytes(codes), [-1.0 if code else 1.0 for code in codes])

    def rated(self, verdicts: Any, margins: Any) -> Rated:
        """An outcome that explains itself in no more words than it has."""

        def explain(number: int, series: bool) -> RuleResult:
            rule = self.rules[number]
            return RuleResult(rule.name, VERDICTS[verdicts[number]], margins[number], rule.unit)

        return Rated(verdicts, margins, explain, advisory(self.rules))


def made(
    limits: Limits | None = None, rules: Sequence[str] | None = None
) -> tuple[Supervisor, Oracle, Clock]:
    """A Supervisor that starts, with its judge and its clock."""
    oracle, clock = Oracle(rules), Clock()
    return Supervisor(shipped(), oracle, limits, clock), oracle, clock
