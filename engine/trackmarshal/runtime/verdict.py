"""What an evaluation says: verdict, margin, and which comparison decided it, where."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from trackmarshal.source import Span
from trackmarshal.units import beside

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from trackmarshal.ir.nodes import Formula

VERDICTS = ("satisfied", "violated", "undefined", "inactive", "open")
#: Verdicts that make a trajectory unsafe. What is `open` is decided in a later cycle, which it makes unsafe if it turns out to be one of these.
UNSAFE = ("violated", "undefined")


class Bound(NamedTuple):
    """One side of a value: whether the formula holds, and its margin."""

    sat: bool
    margin: float


class Truth(NamedTuple):
    """The value of a formula between its worst and its best case over everything undefined in it.

    An undefined comparison may hold or not, by any margin: its worst case is (False, -inf), its best (True, +inf).
    Conjunction, disjunction and the rest are applied to both sides; that is strong Kleene logic.
    """

    worst: Bound
    best: Bound

    @property
    def verdict(self) -> str:
        if self.worst.sat:
            return "satisfied"
        return "undefined" if self.best.sat else "violated"

    @property
    def margin(self) -> float:
        """The margin that is sure: the worst case of what holds, the best case of what doesn't, else NaN.

        A margin of zero is 0.0 by definition, whichever zero was computed.
        """
        if self.worst.sat:
            return self.worst.margin + 0.0
        return math.nan if self.best.sat else self.best.margin + 0.0


@dataclass(frozen=True, slots=True)
class Witness:
    """The comparison that decided, with the sample, object or element at which it did."""

    binders: dict[str, int | str]
    margin: float
    unit: str
    span: Span | None
    #: The unit in which the limit is written; "" for `unit`.
    shown: str = ""
    #: The samples and elements that it reads: signal and number (-1: the last of a timeline).
    places: tuple[tuple[str, int], ...] = ()
    #: The comparison itself, and where it was evaluated: by the level of each axis the place of its variable.
    at: tuple[Formula, Mapping[int, int]] | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class About:
    """What a rule says about one cycle of a run, by the cycle's name. final: nothing to come can change the margin. The verdict is open, or stands;
    of one that is undefined and not final, it may still turn out to be violated."""

    cycle: object
    verdict: str
    margin: float
    final: bool


@dataclass(frozen=True, slots=True)
class RuleResult:
    """The outcome of one rule for one case."""

    rule: str
    verdict: str
    margin: float
    unit: str
    witness: Witness | None = None
    #: Why a rule is undefined: the fault of an input, the input that has no value and where, or the operation that has no result.
    reason: str = ""
    series: tuple[list[str], list[float]] | None = None
    #: The unit in which the limit that decided is written; "" for `unit`.
    shown: str = ""
    #: Of a rule over the run: what it says of this cycle, and of earlier ones that were decided in it.
    about: tuple[About, ...] = ()
    #: Whether it is of a rule that warns and never decides.
    advisory: bool = False
    #: Whether it is violated since there is nothing that could fulfil it. Not known of a rule over the run.
    unmet: bool = False

    @property
    def fired(self) -> bool:
        """Whether the rule is against what it was asked about."""
        return self.verdict in UNSAFE

    @property
    def unsafe(self) -> bool:
        """Whether it makes what it was asked about unsafe."""
        return self.fired and not self.advisory


class Said(NamedTuple):
    """Verdict and margin of a rule in one case, which is all that most of a long run is asked for."""

    verdict: str
    margin: float

    @property
    def fired(self) -> bool:
        """Whether the rule is against what it was asked about."""
        return self.verdict in UNSAFE


def decides(result: RuleResult) -> str:
    """What is said after a margin that is a number of scales: the comparison that decided, with its own unit; empty of any other margin."""
    witness = result.witness
    if witness is None or result.unit != "1" or witness.unit == "1" or not math.isfinite(result.margin):
        return ""
    return f" of a scale, by {beside(witness.margin, witness.unit, witness.shown)}"


class Briefly(Mapping[str, RuleResult]):
    """Results by the names of rules: of those that are not against a case the verdict and the margin, made when they are asked for, since of a
    long run hardly any of them is. `against` has all others.

    idle: by name each rule's number, and its result where it does not apply.
    """

    __slots__ = ("_codes", "_idle", "_margins", "against")

    def __init__(
        self,
        idle: Mapping[str, tuple[int, RuleResult]],
        codes: bytes,
        margins: Sequence[float] | NDArray[np.float64],
        against: Mapping[str, RuleResult],
    ) -> None:
        if not len(idle) == len(codes) == len(margins):
            raise ValueError(f"{len(codes)} verdicts and {len(margins)} margins of {len(idle)} rules")
        self._idle, self._codes, self._margins, self.against = idle, codes, margins, against

    def __getitem__(self, name: str) -> RuleResult:
        found = self.against.get(name)
        if found is not None:
            return found
        number, idle = self._idle[name]
        verdict, margin = VERDICTS[self._codes[number]], float(self._margins[number])
        if verdict == idle.verdict and margin == idle.margin:
            return idle
        return RuleResult(name, verdict, margin, idle.unit, advisory=idle.advisory)

    def said(self, name: str) -> Said:
        """Verdict and margin of a rule: as in its result, which is not made."""
        found = self.against.get(name)
        if found is not None:
            return Said(found.verdict, found.margin)
        number, _ = self._idle[name]
        return Said(VERDICTS[self._codes[number]], float(self._margins[number]))

    def __iter__(self) -> Iterator[str]:
        return iter(self._idle)

    def __len__(self) -> int:
        return len(self._idle)


@dataclass(frozen=True, slots=True)
class CaseResult:
    """All chosen rules on one case; safe only when none is violated or undefined, but for advisory ones, the input contract holds, and so
    does every constraint of the spec: where one is broken, the rules are unsound, whatever they say. By advisory rules alone nothing is safe."""

    id: object
    rules: Mapping[str, RuleResult]
    faults: tuple[str, ...] = field(default=())
    #: Constraints that do not hold with the case's parameters.
    broken: tuple[str, ...] = field(default=())

    @property
    def against(self) -> Collection[RuleResult]:
        """The results of rules that are against it, advisory ones too."""
        if isinstance(self.rules, Briefly):
            return self.rules.against.values()
        return [result for result in self.rules.values() if result.fired]

    def said(self, rule: str) -> Said:
        """Verdict and margin of a rule."""
        if isinstance(self.rules, Briefly):
            return self.rules.said(rule)
        result = self.rules[rule]
        return Said(result.verdict, result.margin)

    @property
    def safe(self) -> bool:
        return (
            any(not result.advisory for result in self.rules.values())
            and not self.faults
            and not self.broken
            and not any(result.unsafe for result in self.against)
        )
