"""What verdicts of rules rest on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TypeAlias, assert_never

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.description import describe
from trackmarshal.ir.margins import SCALED
from trackmarshal.ir.spec import (
    ConstraintInfo,
    ParamInfo,
    PlaceInfo,
    RulebookInfo,
    RuleInfo,
    SignalType,
    Spec,
    TableInfo,
)
from trackmarshal.meaning.inputs import Inputs, key, sha256
from trackmarshal.node import Node

Declared: TypeAlias = ParamInfo | TableInfo | PlaceInfo | SignalType | ConstraintInfo | RulebookInfo

#: The hash of a parameter or a table whose declaration has an error.
_NOTHING = sha256("nothing")


class Meaning:
    """What the rules of a spec rest on, each worked out once."""

    def __init__(self, spec: Spec) -> None:
        self.spec = spec
        self._rules: dict[str, Inputs] = {}
        #: By kind and name, the hashes of declarations: many rules read the same ones.
        self._declared: dict[tuple[str, str], str] = {}

    def rule(self, rule: RuleInfo) -> Inputs:
        """What a rule means, and all that it reads: `rule NAME`, and `param`, `table`, `place`, `signal`, `constraints` where it has any."""
        if rule.name not in self._rules:
            self._rules[rule.name] = self._inputs(rule)
        return self._rules[rule.name]

    def fingerprint(self, rule: RuleInfo) -> str:
        """One hash for all that a rule rests on."""
        return key(self.rule(rule))

    def run(self, rules: Iterable[RuleInfo], others: Inputs) -> Inputs:
        """What a run of these rules rests on: each of them as one hash of all that it rests on, and the `others`."""
        return {**{f"rule {rule.name}": self.fingerprint(rule) for rule in rules}, **others}

    def _inputs(self, rule: RuleInfo) -> Inputs:
        spec, of = self.spec, self._of
        formulas = [formula for formula in (rule.formula, rule.active) if formula is not None]
        nodes = [node for formula in formulas for node in ir.below(formula)]
        said = [
            rule.kind,
            "advisory" if rule.advisory else "",
            repr(rule.along and (rule.along.signal, rule.along.kind, rule.along.width)),
            *(describe(formula, names=False) for formula in formulas),
            repr(rule.active is None),
            repr(rule.course),
            repr(spec.scales) if rule.unit == SCALED else "",
        ]
        params = sorted({node.name for node in nodes if isinstance(node, ir.Param)})
        tables = sorted({node.table for node in nodes if isinstance(node, ir.Lookup | ir.GridLookup)})
        named = {node.name for node in nodes if isinstance(node, ir.Area | ir.Line | ir.StretchRoom)}
        found = {f"rule {rule.name}": sha256(*said)}
        found |= {f"param {name}": of("param", name, spec.params) for name in params}
        found |= {f"table {name}": of("table", name, spec.tables) for name in tables}
        found |= {
            f"place {name}": of("place", name, spec.places) for name in sorted(named & spec.places.keys())
        }
        for name in sorted({signal for signal, _ in rule.reads}):
            if name in spec.signals:
                found[f"signal {name}"] = of("signal", name, spec.signals)
            elif name not in spec.events and all(course.signal.name != name for course in spec.courses):
                raise ValueError(f"`{rule.name}` reads `{name}`, which is no signal")
        demands = sorted(_constraints(spec, {*params, *tables}))
        if demands:
            found["constraints"] = sha256(*demands)
        return found

    def _of(self, kind: str, name: str, declared: Mapping[str, Declared]) -> str:
        """The hash of a declaration. What has an error of its own is missing in the spec, which nobody evaluates: it means nothing yet."""
        if (kind, name) not in self._declared:
            self._declared[kind, name] = of(declared[name]) if name in declared else _NOTHING
        return self._declared[kind, name]


def whole(spec: Spec, rule: RuleInfo) -> bool:
    """Whether everything that a rule reads is declared; what has an error of its own is not."""
    return spec.declares(*(formula for formula in (rule.formula, rule.active) if formula is not None))


def restricted(constraint: ConstraintInfo) -> tuple[str, ...]:
    """The parameters and tables that a constraint is about."""
    nodes = list(ir.below(constraint.formula))
    params = {node.name for node in nodes if isinstance(node, ir.Param)}
    return tuple(
        sorted(params | {node.table for node in nodes if isinstance(node, ir.Lookup | ir.GridLookup)})
    )


def of(info: Declared) -> str:
    """The hash of a declaration: what it is called and says, not where it stands, nor where a value comes from."""
    match info:
        case ConstraintInfo():
            return sha256(describe(info.formula))
        case RulebookInfo():
            return sha256(
                *sorted(info.rules), "", *(" ".join(relation) for relation in sorted(info.relations))
            )
        case ParamInfo():
            return sha256(_told(ParamInfo(**{**info.__dict__, "source": None, "made_of": ()})))
        case TableInfo() | PlaceInfo() | SignalType():
            return sha256(_told(info))
        case _:
            assert_never(info)


def in_order(signal: SignalType) -> SignalType:
    """A signal with its fields in the order of their names: rules and recordings call them by these."""
    return SignalType(
        **{**signal.__dict__, "fields_": tuple(sorted(signal.fields_, key=lambda field: field.name))}
    )


def _told(value: object) -> str:
    """A record as text, without what it leaves open or as it is by default: what later versions can say more does not change what is said now."""
    if isinstance(value, Node):
        said = [(name, value.__dict__[name]) for name in value.compared]
        told = [
            (name, part)
            for name, part in said
            if part is not None and part != getattr(type(value), name, None)
        ]
        inner = ", ".join(f"{name}={_told(part)}" for name, part in told)
        return f"{type(value).__name__}({inner})"
    if isinstance(value, tuple):
        return f"({', '.join(map(_told, value))})"
    return repr(value)


def _constraints(spec: Spec, read: set[str]) -> Iterable[str]:
    """The constraints on any of these parameters and tables, and on those that they join them with, as texts."""
    return (describe(one.formula) for one in spec.constraints if not read.isdisjoint(restricted(one)))
