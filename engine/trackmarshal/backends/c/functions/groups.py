"""One C function for rules over one timeline or set: what they compute alike is computed once, and the loop runs once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.expressions import Expressions
from trackmarshal.backends.c.functions.quantifiers import quantify
from trackmarshal.backends.c.functions.rules import PARAMETERS, concluded, constant
from trackmarshal.backends.c.functions.several import either, takes_several
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import comment
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo


@dataclass(frozen=True)
class GroupCode:
    """Rules over one timeline or set whose functions for known values are joined in one loop."""

    rules: tuple[RuleInfo, ...]
    c_name: str
    text: str


def group_codes(plan: Layout) -> list[GroupCode]:
    """The groups of rules that can share a loop: what they compute alike is computed once, and the loop runs once."""
    found: dict[ir.Axis, list[RuleInfo]] = {}
    for rule in plan.rules:
        axis = _axis(rule)
        if axis is not None:
            found.setdefault(axis, []).append(rule)
    groups = [(axis, rules) for axis, rules in found.items() if len(rules) > 1]
    return [
        _group(plan, f"{plan.input(axis.signal).c_name}_{i}", rules) for i, (axis, rules) in enumerate(groups)
    ]


def _axis(rule: RuleInfo) -> ir.Axis | None:
    """The timeline or set that a rule quantifies over, if it does nothing else that loops; a projection on a prepared line does not."""
    formula, active = rule.formula, rule.active
    if not isinstance(formula, ir.Quantify) or rule.over_run:
        return None
    if active is not None and not (isinstance(active, ir.Quantify) and active.axis is formula.axis):
        return None
    looping = ir.Quantify | ir.Fold | ir.At | ir.Timed | ir.Geometry
    inner = [
        node
        for root in rule.roots
        for node in ir.below(root)
        if (isinstance(node, looping) and node is not root)
        or (isinstance(node, ir.Along) and node.line.kind == "path")
    ]
    return None if inner else formula.axis


def _group(plan: Layout, name: str, rules: Sequence[RuleInfo]) -> GroupCode:
    one = _joined(plan, name, rules)
    several = _joined(plan, name, rules, True) if takes_several(plan, rules) else None
    return GroupCode(tuple(rules), one.name, "\n".join([*either(one, several), ""]))


def _joined(plan: Layout, name: str, rules: Sequence[RuleInfo], several: bool = False) -> c.Function:
    """The function of a group. several: it takes several samples at once."""
    formulas = [rule.formula for rule in rules if rule.formula is not None]
    guards = [rule.active for rule in rules if rule.active is not None]
    writer = Expressions(plan, rules, True, formulas, guards, several)
    owners: list[RuleInfo] = []
    names: list[str] = []
    nodes: list[ir.Quantify] = []
    waiting = iter(writer.guards)
    for rule, formula in zip(rules, writer.formulas):
        for root, ending in ((formula, ""), (None if rule.active is None else next(waiting), "_applies")):
            if isinstance(root, ir.Quantify):
                nodes.append(root)
                owners.append(rule)
                names.append(plan.rule_names[rule.name] + ending)
    values = dict(zip(names, quantify(writer, nodes, writer.root, owners, names)))
    for rule in rules:
        writer.of(rule)
        c_name = plan.rule_names[rule.name]
        place = c.Member(writer.name("out"), "rule", True)
        result = c.Address(c.Element(place, c.Name(constant(c_name))))
        applies = values.get(f"{c_name}_applies", writer.over("true"))
        said = concluded(writer, rule, result, applies, values[c_name])
        full = writer.call(f"tm_rule_{c_name}_any", writer.name("context"), writer.name("in"), result)
        writer.add(writer.root, c.If(c.Unary("!", said), (c.Evaluate(full),)))
    body, _ = writer.finished()
    comment_ = (
        f"In one loop: {comment(', '.join(rule.name for rule in rules))}; each by itself where something that it needs is not known.",
    )
    parameters = (*PARAMETERS[:2], ("tm_output *", "out"))
    return c.Function(comment_, "void", f"tm_rules_{name}", parameters, body)
