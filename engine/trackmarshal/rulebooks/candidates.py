"""Violations of candidates out of what evaluations say of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence, Sized
from typing import Protocol, runtime_checkable

from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.rulebooks import choosing, comparing
from trackmarshal.rulebooks.choosing import Choice
from trackmarshal.rulebooks.comparing import Comparison, Violations
from trackmarshal.rulebooks.order import Order
from trackmarshal.rulebooks.violation import UNKNOWN, Violation, violation, worst
from trackmarshal.runtime.faults import FAULTS, Fault
from trackmarshal.runtime.verdict import CaseResult

CODES = {
    "E408": ("no such rulebook", "A rulebook is named as the spec, or a module that it uses, declares it."),
    "E409": (
        "candidates that cannot be compared",
        "A rulebook compares candidates of each of which every one of its rules says something, advisory ones included. Of a rule that was left out "
        "nothing is known, and of no candidate none can be chosen.",
    ),
}  # fmt: skip

#: Breaches of the input contract of which verdicts speak already: what reads them is undefined.
_SPOKEN = {
    FAULTS[name]
    for name in ("missing", "wrong_type", "wrong_length", "too_short", "not_increasing", "not_finite", "bad_border")
}  # fmt: skip

#: What is said of a candidate: of one case, of the cycles of a run, or by rule its verdict and its margin in SI.
Candidate = CaseResult | Sequence[CaseResult] | Mapping[str, tuple[str, float]]


@runtime_checkable
class Outcomes(Sized, Protocol):
    """Many cases at once, each of which is a candidate: a `Batch`."""

    @property
    def verdicts(self) -> Mapping[str, Iterable[str]]: ...
    @property
    def margins(self) -> Mapping[str, Iterable[float]]: ...
    @property
    def faults(self) -> Mapping[int, tuple[Fault, ...]]: ...
    @property
    def broken(self) -> Mapping[int, object]: ...


def compare(order: Order, first: Candidate, second: Candidate) -> Comparison:
    """What a rulebook says of one candidate beside another one; raises TrackmarshalError E409."""
    return comparing.compare(order, violations(order, first), violations(order, second))


def choose(order: Order, candidates: Sequence[Candidate] | Outcomes) -> Choice:
    """The candidates that no other one beats; of a batch, each case is one. Raises TrackmarshalError E409."""
    if isinstance(candidates, Outcomes):
        _check_order(order)
        return choosing.choose(order, _of_batch(order, candidates))
    if not isinstance(candidates, Iterable) or isinstance(candidates, Mapping | str):
        raise wrong_type("candidates are a list of them, or a `Batch`", candidates)
    return choosing.choose(order, [violations(order, candidate) for candidate in candidates])


def violations(order: Order, candidate: Candidate) -> Violations:
    """By rule of a rulebook, the violation of a candidate; over a run, the worst of its cycles.

    Where a candidate breaks the input contract and rules are evaluated all the same (a value outside its range), or where a constraint of the spec does not hold, they
    say nothing that could be relied on: all of them count as undefined. Raises TrackmarshalError E409 for a rule that was left out, and for a run of no cycles.
    """
    _check_order(order)
    if isinstance(candidate, CaseResult):
        return _of_case(order, candidate)
    if isinstance(candidate, Mapping):
        _complete(order, candidate)
        for rule in order.rules:
            if not isinstance(candidate[rule], tuple | list) or len(candidate[rule]) != 2:
                raise wrong_type("of each rule, a candidate has a verdict and a margin", candidate[rule])
        return {rule: violation(*candidate[rule]) for rule in order.rules}
    results = list(candidate) if isinstance(candidate, Iterable) else [candidate]
    for result in results:
        if not isinstance(result, CaseResult):
            raise wrong_type("a candidate is what `Evaluator.case` returns, or a list of that", result)
    cycles = [_of_case(order, result) for result in results]
    if not cycles:
        raise TrackmarshalError("E409", "a candidate is a run of no cycles", help="give at least one cycle")
    return {rule: worst(cycle[rule] for cycle in cycles) for rule in order.rules}


def _check_order(order: Order) -> None:
    if not isinstance(order, Order):
        raise wrong_type("an order is what `rulebook` returns", order)


def _of_case(order: Order, result: CaseResult) -> Violations:
    _complete(order, result.rules)
    if unreliable(result):
        return dict.fromkeys(order.rules, UNKNOWN)
    return {rule: violation(result.rules[rule].verdict, result.rules[rule].margin) for rule in order.rules}


def unreliable(result: CaseResult) -> bool:
    """Whether rules say of a case what cannot be relied on, and do not know it."""
    return bool(result.broken) or any(str(fault).partition(" ")[0] not in _SPOKEN for fault in result.faults)


def _of_batch(order: Order, batch: Outcomes) -> list[Violations]:
    _complete(order, batch.verdicts)
    columns: dict[str, list[Violation]] = {
        rule: [violation(str(v), float(m)) for v, m in zip(batch.verdicts[rule], batch.margins[rule])]
        for rule in order.rules
    }
    unknown = {
        place for place, faults in batch.faults.items() if any(fault.code not in _SPOKEN for fault in faults)
    }
    unknown |= batch.broken.keys()
    return [
        {rule: UNKNOWN if place in unknown else column[place] for rule, column in columns.items()}
        for place in range(len(batch))
    ]


def _complete(order: Order, rules: Mapping[str, object]) -> None:
    missing = [rule for rule in order.rules if rule not in rules]
    if missing:
        listed = ", ".join(f"`{rule}`" for rule in missing)
        raise TrackmarshalError(
            "E409",
            f"of a candidate, nothing is said of {listed} of the rulebook `{order.name}`",
            help="evaluate all rules of the rulebook; an assumption takes part by its `monitor`",
        )
