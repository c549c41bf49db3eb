"""What the Supervisor says in a cycle: what is driven, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from trackmarshal.runtime.case import Fault
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.judge import Judged
from trackmarshal.runtime.machine import NO_EMERGENCY_YET, NO_SAFE_TRAJECTORY
from trackmarshal.runtime.plan import Plan
from trackmarshal.runtime.verdict import Witness


@dataclass(frozen=True, slots=True)
class Violation:
    """A rule that makes a candidate unsafe; the margin is in `unit`, the witness is there where the judge gives one."""

    rule: str
    requirements: tuple[str, ...]
    candidate: str
    verdict: str
    margin: float
    unit: str
    witness: Witness | None
    reason: str = ""

    def __str__(self) -> str:
        asked = f" ({', '.join(self.requirements)})" if self.requirements else ""
        return f"{self.candidate}: {self.rule} {self.verdict}, margin {self.margin:.6g} {self.unit}{asked}"


@dataclass(frozen=True, slots=True)
class Decision:
    """One decision.

    number, t: the cycle's, where they are numbers. now, finished: the clock at its arrival and when the verdict was there (NaN: no
    verdict), in s. safe: whether this cycle is. driven: None where nothing may be driven. fallback: the stored emergency
    trajectory; drive it when no decision has come by `valid_until`. lost: why nothing stored is driven, one of the names.
    """

    number: int | None
    t: float
    now: float
    finished: float
    state: str
    safe: bool
    driven: Plan | None
    fallback: Plan | None
    valid_until: float
    lost: str
    faults: tuple[Fault, ...]
    violations: tuple[Violation, ...]
    judged: tuple[Judged, Judged] | None

    @property
    def action(self) -> str:
        """What is driven, in the words of `replay`: drive, previous_emergency or no_safe_trajectory."""
        return NO_SAFE_TRAJECTORY if self.state == NO_EMERGENCY_YET else self.state

    @property
    def samples(self) -> Mapping[str, Any] | None:
        """Columns of what is driven, from the last sample that is due by now on."""
        return None if self.driven is None else self.driven.samples(self.now)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Everything that speaks against the cycle, for people."""
        found = [f"{name_of(f)} {f}" for f in self.faults] + [str(v) for v in self.violations]
        return (*found, *([f"stored emergency trajectory: {self.lost}"] if self.lost else []))
