"""The functions that take note of a cycle once it is driven: the operands of what is remembered, as trees of C."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.expressions import Expressions
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import identifier
from trackmarshal.backends.c.over_run.cells import Cell
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import parts, recalls
from trackmarshal.ir.reads import DRIVEN, reads_itself


class _Noting(Expressions):
    """Operands as they are of what was driven: where nothing was, what reads it is not known."""

    _inside = False

    def formula(self, node: ir.Formula, scope: c.Scope, role: str = "holds", named: bool = False) -> c.Expr:
        if self._inside or (parts(node) is not None and not recalls(node)):
            return super().formula(node, scope, role, named)
        self._inside = True
        made = super().formula(node, scope, role, named)
        self._inside = False
        return self.call("tm_if_driven", self.name("driven"), made) if _of_plan(node) else made

    def states(self, machine: ir.Machine, scope: c.Scope) -> c.Expr:
        before, self._inside = self._inside, False
        made = super().states(machine, scope)
        self._inside = before
        return made

    def noted(self, node: ir.Num, scope: c.Scope) -> c.Expr:
        before, self._inside = self._inside, True
        made = super().noted(node, scope)
        self._inside = before
        return c.Conditional(self.name("driven"), made, c.Name("TM_NAN")) if _of_plan(node) else made


def _of_plan(node: ir.Formula | ir.Num) -> bool:
    """Whether something reads the trajectory that is driven, but for what decides the states of machines."""
    return any(signal in DRIVEN for signal, _ in reads_itself(node))


def note(plan: Layout) -> c.Function:
    """The operands of all operators over the run, and the states of all machines, in the cycle that is about to be past."""
    rules = [rule for rule in plan.rules if rule.over_run]
    operands = [operand for each in plan.kept.values() for operand in _operands(each)]
    writer = _Noting(plan, rules, False, operands)
    writer.root.names |= {"driven"}
    waiting = iter(writer.formulas)
    for each in plan.kept.values():
        given = [next(waiting) for _ in _operands(each)]
        scope = writer.root
        for axis in each.axes:
            scope = writer.loop(axis, scope, (identifier(next(_names(axis, rules), axis.signal)),))
        place = writer.place_of(each.axes, scope, "next")
        values = [writer.formula(operand, scope) for operand in given]
        if isinstance(each.node, ir.Machine):
            values = [c.Address(writer.states(each.node, scope))]
        noted = writer.call(f"tm_{each.c_name}_note", writer.name("context"), *place, *values)
        writer.add(scope, c.Evaluate(noted))
        scope.end(writer.root)
    body, _ = writer.finished(("context", "in", "driven"))
    said = (
        "What operators over the run are about, and the states of machines, in the cycle that is about to be past.",
    )
    parameters = (("tm_context *", "context"), ("const tm_input *", "in"), ("bool", "driven"))
    return c.Function(said, "void", "tm_note", parameters, body)


def settle(plan: Layout) -> c.Function:
    """What is settled in the present cycle, for rules that look ahead: it goes into their tables."""
    leaves = list(plan.future.leaves.values())
    writer = _Noting(plan, plan.future.rules, False, [each.node for each in leaves])
    writer.root.names |= {"driven"}
    future = c.Member(c.Member(writer.name("context"), "run", True), "future", False)
    slot = c.Member(future, "slot", False)
    for each, node in zip(leaves, writer.formulas):
        row: c.Expr = c.Element(c.Member(future, each.c_name, False), slot)
        scope = writer.root
        for axis in each.axes:
            scope = writer.loop(axis, scope, (identifier(axis.signal),))
            places = c.Member(future, f"{plan.input(axis.signal).c_name}_place", False)
            row = c.Element(row, c.Element(places, writer.index(axis, scope)))
        writer.add(scope, c.Assign(row, c.Call("tm_known_now", (writer.formula(node, scope),))))
        scope.end(writer.root)
    for operator in plan.future.operators.values():
        if isinstance(operator.node, ir.Counted):
            limit = c.Element(c.Member(future, f"{operator.table.c_name}_limit", False), slot)
            writer.add(writer.root, c.Assign(limit, writer.number(operator.node.limit, writer.root, "limit")))
    body, _ = writer.finished(("context", "in", "driven"))
    said = ("What is settled in the present cycle, for rules that look ahead.",)
    parameters = (("tm_context *", "context"), ("const tm_input *", "in"), ("bool ", "driven"))
    done = c.Evaluate(c.Unary("++", c.Member(future, "ready", False)))
    return c.Function(said, "void", "tm_settle", parameters, (*body, done))


def _operands(each: Cell) -> tuple[ir.Formula, ...]:
    return () if isinstance(each.node, ir.Machine) else each.node.operands


def _names(axis: ir.Axis, rules: list[Any]) -> Iterator[str]:
    """What rules call an element of a set."""
    for rule in rules:
        for root in rule.roots:
            for node in ir.below(root):
                if isinstance(node, ir.Quantify) and node.axis is axis:
                    yield node.names[0]
