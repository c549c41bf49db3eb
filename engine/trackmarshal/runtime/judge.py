"""What the Supervisor asks verdicts of: any evaluator of a spec, behind one small surface."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.door import Door
from trackmarshal.runtime.verdict import UNSAFE, VERDICTS, RuleResult

#: Verdict codes (places in VERDICTS) that do not make a trajectory unsafe.
SAFE_CODES = bytes(i for i, name in enumerate(VERDICTS) if name not in UNSAFE)
KNOWN_CODES = bytes(range(len(VERDICTS)))


@dataclass(frozen=True, slots=True)
class Judged:
    """The outcome of all rules for one candidate.

    verdicts: a code a rule (its place in VERDICTS), in the judge's order. margins: (rules,). result gives the whole result of the
    rule of a number, with its witness, where the judge knows more than that.
    """

    verdicts: bytes
    margins: Sequence[float]
    result: Callable[[int], RuleResult] | None = None


class Judge(Protocol):
    """Evaluates all rules on both candidates of a cycle that passed the door."""

    @property
    def rules(self) -> Sequence[RuleInfo]:
        """The rules, in the order of verdicts."""

    @property
    def identity(self) -> Mapping[str, Any]:
        """What decisions depend on besides cycles, for the record: `fingerprint` of the spec, `backend`, `params`, ..."""

    def judge(self, door: Door) -> tuple[Judged, Judged]:
        """The driving and the emergency trajectory of the cycle that the door holds (`Door.signals`)."""
