"""What the Supervisor says in a cycle: what is driven, and why."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from trackmarshal.runtime.faults import Fault, name_of
from trackmarshal.runtime.machine import NO_EMERGENCY_YET, NO_SAFE_TRAJECTORY
from trackmarshal.runtime.plan import Plan
from trackmarshal.runtime.program import Judged
from trackmarshal.runtime.verdict import RuleResult, Witness

#: The most reasons that a decision lists: first the door's, then rules as declared, then the watchdog's.
MOST_REASONS = 64


class Violation(NamedTuple):
    """A rule that makes a candidate unsafe, or is advisory and would; the margin is in `unit` (`mixed` for a rule of several dimensions, `scaled` where scales are declared)."""

    rule: str
    requirements: tuple[str, ...]
    candidate: str
    verdict: str
    margin: float
    unit: str
    #: Looks for what decided; takes longer than a cycle has.
    explain: Callable[[], RuleResult]

    def __copy__(self) -> Violation:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Violation:
        return self

    def __reduce__(self) -> str:
        raise _not_pickled("violation")

    @property
    def witness(self) -> Witness | None:
        """What decided, and where; looked for when it is asked for. None of a rule over the run."""
        return self.explain().witness

    @property
    def reason(self) -> str:
        """Why a rule is undefined: which input, where, or which operation; looked for when it is asked for. Empty where it is violated; of a
        rule over the run, only of an element that found no place."""
        return self.explain().reason

    def __str__(self) -> str:
        asked = f" ({', '.join(self.requirements)})" if self.requirements else ""
        if self.verdict == "undefined":  # over the run, often nobody knows why; there is no margin
            reason = f": {found}" if (found := self.reason) else ""
            return f"{self.candidate}: {self.rule} undefined{reason}{asked}"
        return f"{self.candidate}: {self.rule} {self.verdict}, margin {self.margin:.6g} {self.unit}{asked}"


class Decision(NamedTuple):
    """One decision.

    number, t: the cycle's, where they are numbers. now, finished: the clock at its arrival and when the verdict was there (NaN: no
    verdict), in s. safe: whether this cycle is. driven: None where nothing may be driven. fallback: the stored emergency
    trajectory; drive it when no decision has come by `valid_until`. lost: why nothing stored is driven, one of the names. more: whether
    there are more reasons than are listed. advisories: what rules say that warn and never decide.
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
    more: bool
    judged: Judged | None
    advisories: tuple[Violation, ...] = ()

    def __copy__(self) -> Decision:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Decision:
        return self  # nobody changes it, or what it refers to

    def __reduce__(self) -> str:
        raise _not_pickled("decision")

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
        found += ["and more"] if self.more else []
        return (*found, *([f"stored emergency trajectory: {self.lost}"] if self.lost else []))

    @property
    def feedback(self) -> list[dict[str, Any]]:
        """The same for a planner, as data that JSON can say: which candidate, which rule, where, by how much (`runtime.feedback`).

        Worked out when it is asked for, which takes longer than a cycle has: ask in another thread, or where there is time.
        """
        from trackmarshal.runtime.feedback import feedback

        return feedback(self)


def _not_pickled(what: str) -> TypeError:
    """The error of who pickles what looks for its witnesses in the evaluator that it is from."""
    return TypeError(
        f"a {what} is not pickled, as its evaluator explains it: keep `decision.feedback`, which is plain data, or let the Supervisor "
        "write its record (`record=`)"
    )
