"""Why a step is not safe, as decisions say it: rules that are against it, and parts of the Supervisor that gave no answer."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.decision import MOST_REASONS, Decision, Violation
from trackmarshal.runtime.faults import Fault, fault
from trackmarshal.runtime.machine import NO_SAFE_TRAJECTORY
from trackmarshal.runtime.program import SAFE_CODES, Judged
from trackmarshal.runtime.verdict import VERDICTS

#: A rule's name, requirements and the unit of its margin; whether it is advisory.
Named = tuple[str, tuple[str, ...], str, bool]


def named_rules(rules: Sequence[RuleInfo]) -> list[Named]:
    """Rules as decisions speak of them."""
    return [
        (rule.name, tuple(dict.fromkeys(name for name, _ in rule.satisfies)), rule.unit, rule.advisory)
        for rule in rules
    ]


@dataclass(frozen=True, slots=True)
class Found:
    """The rules that make a candidate unsafe in one step."""

    about: int
    violations: tuple[Violation, ...]


def violations(about: int, rules: list[Named], judged: Judged) -> Found:
    """The rules that make a candidate unsafe."""
    if all(rated.safe for rated in judged.rated.values()):
        return Found(about, ())
    return Found(about, _against(rules, judged, False))


def advisories(rules: list[Named], judged: Judged | None) -> tuple[Violation, ...]:
    """What rules are against a candidate that never make it unsafe."""
    if judged is None or not any(rated.advisory for rated in judged.rated.values()):
        return ()
    return _against(rules, judged, True)


def _against(rules: list[Named], judged: Judged, advisory: bool) -> tuple[Violation, ...]:
    return tuple(
        Violation(
            *rules[place][:2], candidate, VERDICTS[code], float(rated.margins[place]), rules[place][2],
            partial(rated.explain, place, False),
        )
        for candidate, rated in judged.rated.items()
        for place, code in enumerate(rated.verdicts)
        if code not in SAFE_CODES and rules[place][3] == advisory
    )  # fmt: skip


def listed(
    faults: list[Fault], found: tuple[Violation, ...], late: list[Fault]
) -> tuple[tuple[Fault, ...], tuple[Violation, ...], bool]:
    """As many reasons as a decision has room for: the door's, the rules', and what went wrong after the door."""
    first = faults[:MOST_REASONS]
    second = found[: MOST_REASONS - len(first)]
    third = late[: MOST_REASONS - len(first) - len(second)]
    more = len(faults) + len(found) + len(late) > MOST_REASONS
    return (*first, *third), second, more


def incomplete(part: str, message: str = "it did not run") -> Fault:
    """The fault of a part that gave no answer for this step."""
    return fault("incomplete", "supervisor", part, None, message)


def internal(error: Exception) -> Fault:
    """The fault of an error in the Supervisor's own code."""
    return fault("internal", "supervisor", "", None, shown(error))


def shown(error: Exception) -> str:
    """An error in one line; its own text may fail."""
    try:
        return f"{type(error).__name__}: {error}"[:200]
    except Exception:
        return type(error).__name__


def overlapping() -> Decision:
    """What is decided of a cycle that comes while another step of the same Supervisor is taken, by another thread or by code of what was handed in:
    nothing. It is no step, and neither counted nor recorded; the other one goes on."""
    found = (incomplete("step", "another step of this Supervisor is being taken"),)
    return Decision(
        None, math.nan, math.nan, math.nan, NO_SAFE_TRAJECTORY, False, None, None, math.nan, "none_stored", found, (), False, None
    )  # fmt: skip
