"""From values of formulas to results of rules: the same for every evaluator."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from trackmarshal.backends.undefined import in_gap, of_reads, why
from trackmarshal.backends.witness import Descent, Values
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.margins import MIXED, undecided
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime import declared
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import NOTHING, Judged, Memory, Rated, advisory
from trackmarshal.runtime.verdict import VERDICTS, About, RuleResult, Truth, Witness

if TYPE_CHECKING:
    from trackmarshal.runtime.decision import Decision


class CaseValues(Values, Protocol):
    """What a result needs to know of one case from an evaluator."""

    @property
    def spec(self) -> Spec: ...

    def along(self, node: ir.Formula, axis: ir.Axis, env: dict[int, int]) -> Sequence[Truth]: ...

    def recalled(self, node: ir.Formula, env: dict[int, int], kept: Mapping[ir.Kept, float]) -> Truth:
        """The value of a formula about numbers that state machines keep, with those given."""

    def geometry_fault(self, formula: ir.Formula) -> str | None: ...


class Outcomes(NamedTuple):
    """The outcome of all rules on one frame, and the values of formulas there, made when they are asked for."""

    rated: Rated
    values: Callable[[], CaseValues]


def identity(spec: Spec, backend: str, rules: Sequence[RuleInfo]) -> dict[str, Any]:
    """How a record names what rated: the spec, the evaluator, and the rules in order; and in which units numbers are, and which members places are of."""
    return {
        "fingerprint": spec.fingerprint,
        "backend": backend,
        "rules": [rule.name for rule in rules],
        "members": declared.listed_members(spec),
        "units": declared.listed(declared.units_of_fields(spec.signals.values())),
    }


class Stateless(ABC):
    """A program whose rules remember nothing: it rates every frame by itself.

    leaves: formulas besides those of the rules whose values are asked for.
    """

    backend = ""

    def __init__(self, spec: Spec, rules: Sequence[RuleInfo], leaves: Sequence[ir.Formula] = ()) -> None:
        self.spec = spec
        self.rules: Sequence[RuleInfo] = [rule for rule in rules if rule.formula is not None]
        self.leaves = leaves

    @cached_property
    def identity(self) -> Mapping[str, Any]:
        return identity(self.spec, self.backend, self.rules)

    @abstractmethod
    def outcomes(self, frames: Sequence[Frame]) -> list[Outcomes]:
        """Rate frames that are cases, or seen by one candidate; in order."""

    def rate_all(self, frames: Sequence[Frame]) -> list[Rated]:
        """The same without values."""
        return [found.rated for found in self.outcomes(frames)]

    def start(self) -> Memory:
        return NOTHING

    def missed(self, memory: Memory, cycles: int = 1) -> Memory:
        return memory

    def end(self, memory: Memory) -> dict[str, tuple[About, ...]]:
        return {}

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        return self.judge_all([frame])[0]

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        if not any(frame.candidates for frame in frames):
            return [Judged(frame, {"": one}) for frame, one in zip(frames, self.rate_all(frames))]
        seen = [frame.seen() for frame in frames]
        rated = iter(self.rate_all([one for each in seen for _, one in each]))
        return [Judged(frame, {name: next(rated) for name, _ in each}) for frame, each in zip(frames, seen)]

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        return memory


def rated(
    rules: Sequence[RuleInfo], frame: Frame, values: Callable[[], CaseValues], verdicts: bytes | None = None,
    margins: Sequence[float] = (),
) -> Rated:  # fmt: skip
    """The outcome of rules on one frame: as given, or as the values of their formulas say."""
    if verdicts is None:
        outcomes = [outcome(rule, frame, values()) for rule in rules]
        own = [
            type(found) is Outcome and found.rule is rule and found.frame is frame
            for rule, found in zip(rules, outcomes)
        ]
        verdicts = bytes(
            VERDICTS.index(found.verdict) if fits else NOT_EVALUATED for found, fits in zip(outcomes, own)
        )
        margins = [found.margin if fits else math.nan for found, fits in zip(outcomes, own)]
    codes = verdicts

    def explain(number: int, series: bool = False) -> RuleResult:
        said = VERDICTS[codes[number]], float(margins[number])
        return rule_result(rules[number], frame, values(), said, series)

    return Rated(codes, margins, explain, advisory(rules))


#: A code that no verdict has: a rule that did not run is never taken for one that said something.
NOT_EVALUATED = 255


class Outcome(NamedTuple):
    """Verdict and margin of a rule on one frame."""

    verdict: str
    margin: float
    rule: RuleInfo
    frame: Frame


def outcome(rule: RuleInfo, frame: Frame, values: CaseValues) -> Outcome:
    """Verdict and margin of a rule on one frame."""
    assert rule.formula is not None
    if frame.unusable(rule.reads) is not None:
        return Outcome("undefined", math.nan, rule, frame)
    if rule.active is not None and not values.truth(rule.active, {}).best.sat:
        return Outcome("inactive", math.inf, rule, frame)
    truth = values.truth(rule.formula, {})
    return Outcome(truth.verdict, truth.margin, rule, frame)


def rule_result(
    rule: RuleInfo, frame: Frame, values: CaseValues, said: tuple[str, float], series: bool = False
) -> RuleResult:
    """The result of one rule on one frame, given verdict and margin: with what decided, and where."""
    formula = rule.formula
    assert formula is not None
    blocked = frame.unusable(rule.reads)
    if blocked is not None:
        return RuleResult(
            rule.name, "undefined", math.nan, undecided(rule.unit), None, str(blocked), _no_series(rule, frame, series),
            advisory=rule.advisory,
        )  # fmt: skip
    verdict, margin = said
    along = _series(rule, values, series)
    if verdict == "inactive":
        return RuleResult(
            rule.name,
            verdict,
            margin,
            undecided(rule.unit),
            None,
            "nothing in its range",
            along,
            advisory=rule.advisory,
        )
    descent = Descent(values)
    witness = descent.find(formula)
    unit = witness.unit if rule.unit == MIXED and witness is not None else undecided(rule.unit)
    reason = _why(rule, frame, values, descent) if verdict == "undefined" else ""
    shown = shown_unit(witness, unit)
    unmet = verdict == "violated" and margin == -math.inf and witness is None
    return RuleResult(
        rule.name, verdict, margin, unit, witness, reason, along, shown, advisory=rule.advisory, unmet=unmet
    )


def _why(rule: RuleInfo, frame: Frame, values: CaseValues, descent: Descent) -> str:
    """Why a rule that could be computed is undefined: cycles that are missing, an area that is none, an input without a value, or an operation on
    some that have one."""
    assert rule.formula is not None
    if descent.gap is not None:
        return in_gap(*descent.gap, frame)
    unusable = values.geometry_fault(rule.formula)
    if unusable:
        return unusable
    if descent.decisive is None:
        return of_reads(rule.reads, frame)
    return why(*descent.decisive, values.spec, frame)


def shown_unit(witness: Witness | None, unit: str) -> str:
    """The unit in which a rule's margin is shown: the one of the limit that decided, where it measures the same."""
    return witness.shown if witness is not None and witness.unit == unit else ""


def _series(rule: RuleInfo, values: CaseValues, wanted: bool) -> tuple[list[str], list[float]] | None:
    """The formula's value at every sample, for rules that live along a timeline."""
    if not wanted or rule.along is None:
        return None
    assert isinstance(rule.formula, ir.At)
    truths = values.along(rule.formula.operand, rule.along, {})
    return [t.verdict for t in truths], [t.margin for t in truths]


def _no_series(rule: RuleInfo, frame: Frame, wanted: bool) -> tuple[list[str], list[float]] | None:
    if not wanted or rule.along is None:
        return None
    signal = rule.along.signal
    count = frame.count(signal) if signal in frame.columns else 0
    return ["undefined"] * count, [math.nan] * count


def chosen_rules(spec: Spec, names: Sequence[str] | None) -> list[RuleInfo]:
    """All rules and monitors of a spec, or the named ones, each once; raises KeyError for an unknown name."""
    if names is None:
        return [rule for rule in spec.rules if rule.formula is not None]
    chosen = dict.fromkeys(_named(spec, name) for name in names)
    return [rule for rule in chosen if rule.formula is not None]


def _named(spec: Spec, name: str) -> RuleInfo:
    rule = spec.rule(name)
    if rule is None:
        raise KeyError(name)
    return rule
