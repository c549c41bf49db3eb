"""What evaluators of rules are to everything else: programs that judge frames."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.verdict import UNSAFE, VERDICTS, About, RuleResult

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from trackmarshal.runtime.decision import Decision

#: Verdict codes (places in VERDICTS) that do not make a trajectory unsafe.
SAFE_CODES = bytes(i for i, name in enumerate(VERDICTS) if name not in UNSAFE)
KNOWN_CODES = bytes(range(len(VERDICTS)))


class Rated(NamedTuple):
    """The outcome of all rules for one candidate, or one case.

    verdicts: a code a rule (its place in VERDICTS), in the program's order. margins: (rules,), in SI. explain gives the whole result of
    the rule of a number, with its witness and, if asked for, its series; it is looked for only then. advisory: the numbers of rules that
    never decide.
    """

    verdicts: bytes
    margins: Sequence[float] | NDArray[np.float64]
    explain: Callable[[int, bool], RuleResult]
    advisory: frozenset[int] = frozenset()

    @property
    def safe(self) -> bool:
        """Whether no rule makes it unsafe; nothing is safe by no rule, or by advisory ones alone."""
        decisive = self.verdicts
        if self.advisory:
            decisive = bytes(code for place, code in enumerate(self.verdicts) if place not in self.advisory)
        return bool(decisive) and not decisive.translate(None, SAFE_CODES)


def advisory(rules: Sequence[RuleInfo]) -> frozenset[int]:
    """The numbers of rules that never decide."""
    return frozenset(place for place, rule in enumerate(rules) if rule.advisory)


class Copied(Mapping[str, Rated]):
    """The outcomes of both candidates, driving first, as memory that was copied: verdicts, a code a rule, and margins, native float64."""

    __slots__ = ("margins", "verdicts")

    def __init__(self, verdicts: bytes, margins: bytes) -> None:
        self.verdicts, self.margins = verdicts, margins


class Judged(NamedTuple):
    """The outcome of one frame: of which one, and by candidate ('' for a case)."""

    about: Frame
    rated: Mapping[str, Rated]

    def __deepcopy__(self, memo: dict[int, Any]) -> Judged:
        return self  # what explains it belongs to the program, and no program is copied


@dataclass(frozen=True, slots=True)
class Memory:
    """What rules remember from one cycle to the next: nothing, where no rule speaks of other cycles; programs derive their own."""


NOTHING = Memory()


class Program(Protocol):
    """Rules of a spec, compiled. Implemented by the reference, numpy and generated C."""

    @property
    def spec(self) -> Spec: ...

    @property
    def rules(self) -> Sequence[RuleInfo]:
        """The rules, in the order of verdicts."""

    @property
    def identity(self) -> Mapping[str, Any]:
        """What verdicts depend on besides frames, for the record: `backend`, the spec's `fingerprint`, the rules, and its `units` and `members`."""

    def start(self) -> Memory:
        """What is remembered before the first cycle of a run."""

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        """The outcome of all rules for every candidate of a frame, or for a case."""

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        """The same of many frames, each as the first cycle of a run; cheaper than one by one."""

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        """What is remembered of a cycle, once it is decided what is driven; None: a case, in which nothing is decided."""

    def missed(self, memory: Memory, cycles: int = 1) -> Memory:
        """What is remembered of cycles that were refused before they became a frame, or did not come: that there is a gap."""

    def end(self, memory: Memory) -> Mapping[str, tuple[About, ...]]:
        """By rule, what is said of the cycles that were open after the last cycle of a run: nothing is to come."""
