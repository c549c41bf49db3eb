"""Rules for data without curvatures: what follows a curve where there are any goes straight from sample to sample."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.reads import reads
from trackmarshal.ir.spec import RuleInfo

F = TypeVar("F", bound=ir.Formula)
#: (signal, field) pairs.
Fields = frozenset[tuple[str, str]]
_BENDS: WeakKeyDictionary[ir.Formula, Fields] = WeakKeyDictionary()


def curvatures(rules: Iterable[RuleInfo]) -> Fields:
    """The fields that rules read for the curves along which something is swept, and for nothing but their curvature."""
    formulas = (formula for rule in rules for formula in (rule.formula, rule.active))
    return frozenset().union(*(_bends(formula) for formula in formulas if formula is not None))


def _bends(formula: ir.Formula) -> Fields:
    """Those of one formula, which many evaluators are made of."""
    found = _BENDS.get(formula)
    if found is None:
        swept = [node for node in ir.below(formula) if isinstance(node, (ir.SweptInside, ir.SweptClear))]
        found = _BENDS[formula] = frozenset().union(*(_read(node.bend) for node in swept))
    return found


def straightened(rule: RuleInfo, absent: Fields) -> RuleInfo:
    """A rule that sweeps straight wherever a curvature is one of `absent`; the same rule where it does so nowhere."""
    formula, active = (
        part if part is None or _bends(part).isdisjoint(absent) else _straight(part, absent)
        for part in (rule.formula, rule.active)
    )
    if formula is rule.formula and active is rule.active:
        return rule
    said = {name: getattr(rule, name) for name in RuleInfo.fields}
    names = " ".join(sorted(f"{signal}.{field}" for signal, field in absent))
    digest = hashlib.sha256(f"{rule.fingerprint} straight without {names}".encode()).hexdigest()
    return RuleInfo(
        **{**said, "formula": formula, "active": active, "reads": reads(formula), "fingerprint": digest}
    )


def _read(bend: tuple[ir.Num, ...]) -> set[tuple[str, str]]:
    return {
        (node.axis.signal, node.field)
        for kappa in bend
        for node in ir.below(kappa)
        if isinstance(node, ir.Column)
    }


def _straight(root: F, absent: Fields) -> F:
    """A formula with straight sweeps; nodes that stay as they are stay the same nodes, and shared ones shared."""
    made: dict[int, Any] = {}

    def again(value: Any) -> Any:
        if isinstance(value, tuple):
            parts = tuple(map(again, value))
            return parts if any(a is not b for a, b in zip(parts, value)) else value
        if not isinstance(value, ir.IR):
            return value
        if id(value) not in made:
            fields = {name: again(getattr(value, name)) for name in value.fields}
            if isinstance(value, (ir.SweptInside, ir.SweptClear)) and _read(value.bend) & absent:
                fields["bend"] = ()
            same = all(fields[name] is getattr(value, name) for name in value.fields)
            made[id(value)] = value if same else type(value)(**fields)
        return made[id(value)]

    found: F = again(root)
    return found
