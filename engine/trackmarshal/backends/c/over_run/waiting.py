"""The C of rules that look ahead: what is kept of the last cycles, and what is said of each of them as others come."""

from __future__ import annotations

from typing import Any

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.operators import compared
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import where
from trackmarshal.backends.c.over_run.future import Future, Operator, Table
from trackmarshal.backends.c.over_run.hoping import hope
from trackmarshal.backends.c.over_run.kept import Binds, entry, for_those_there
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme

_TRUE, _FALSE = c.Call("tm_true_any", ()), c.Call("tm_false_any", ())
#: Sorts of windows, by operator.
_KINDS = {
    "eventually": "TM_SOME", "once": "TM_SOME", "always": "TM_EVERY", "historically": "TM_EVERY", "until": "TM_HELD", "since": "TM_HELD",
}  # fmt: skip


def described(plan: Layout) -> dict[str, Any]:
    """What the templates ask about what is kept of the last cycles."""
    future = plan.future
    return {
        "room": future.room, "back": f"INT64_C({future.back})", "reach": f"INT64_C({future.reach + future.back})", "steps": f"{future.steps + 1}u",
        "rules": [
            {"c_name": plan.rule_names[rule.name], "active": rule.active is not None, "hopes": hope(plan, rule) is not None}
            for rule in future.rules
        ],
        "sets": [plan.input(name).c_name for name in future.sets],
        "lasting": [plan.input(name).c_name for name in future.sets if plan.spec.signals[name].forget],
        "pairs": [
            {"c_name": pair.c_name, "first": plan.input(pair.first).c_name, "second": plan.input(pair.second).c_name, "pair": True}
            for pair in plan.pairs_ahead.values()
        ],
        "leaves": [_table(plan, each) for each in future.leaves.values()],
        "given": [_table(plan, each) for each in future.given.values()],
        "operators": [_operator(plan, each) for each in future.operators.values()],
        "steps_of": list(_order(plan)), "looks_back": any(each.node.past for each in future.operators.values()),
        "counts": any(isinstance(each.node, ir.Counted) for each in future.operators.values()),
    }  # fmt: skip


#: How far values of the same element, or pair, are apart from cycle to cycle, by how many elements they are about.
_STRIDES = ("1u", "TM_MAX_ELEMENTS", "TM_MAX_ELEMENTS * TM_MAX_ELEMENTS")


def _table(plan: Layout, each: Table, of: Table | None = None) -> dict[str, Any]:
    """A table, as it is asked in loops over what another one is about."""
    around = (each if of is None else of).axes
    return {
        "c_name": each.c_name, "set": plan.places_of(each.axes), "pair": len(each.axes) == 2, "stride": _STRIDES[len(each.axes)],
        "at": "".join(f"[{'ik'[around.index(axis)]}]" for axis in each.axes),
    }  # fmt: skip


def _operator(plan: Layout, each: Operator) -> dict[str, Any]:
    node = each.node
    operands = [_table(plan, one, each.table) for one in each.operands]
    op = node.op if isinstance(node, ir.OverRun) else "count"
    own = {
        **_table(plan, each.table), "about": f"`{op}`: {where(node.span)}", "op": op, "past": node.past, "lower": f"INT64_C({node.lower or 0})",
        "upper": None if node.upper is None else f"INT64_C({node.upper})", "p": operands[0], "q": operands[-1],
        "waits": op in ("eventually", "always", "until"), "kind": _KINDS.get(op, ""),
    }  # fmt: skip
    if isinstance(node, ir.Counted):
        return {**own, "weak": False, "compared": f"tm_count_{compared(node.op, node.turned)}"}
    return {**own, "compared": "", "weak": node.weak}


def _order(plan: Layout) -> list[dict[str, Any]]:
    """Tables in the order in which they are worked out: operands before their operators."""
    found: list[dict[str, Any]] = []
    done: set[str] = set()
    future = plan.future
    staged = {table.c_name: table for table in future.given.values()}
    for operator in future.operators.values():
        for operand in operator.operands:
            if operand.c_name in staged and operand.c_name not in done:
                done.add(operand.c_name)
                found.append({"staged": True, **_table(plan, operand)})
        found.append({"staged": False, **_operator(plan, operator)})
    return found


def put_together(plan: Layout) -> list[str]:
    """Functions of formulas that are put together from tables: operands of operators, and what rules say and where they apply."""
    future = plan.future
    made = [
        _function(plan, future, each.node, f"tm_{each.c_name}", each.axes) for each in future.given.values()
    ]
    for rule in future.rules:
        name = plan.rule_names[rule.name]
        assert rule.formula is not None
        made.append(_function(plan, future, plan.same(rule.formula), f"tm_rule_{name}_said", ()))
        if rule.active is not None:
            made.append(_function(plan, future, plan.same(rule.active), f"tm_rule_{name}_applies", ()))
        hoping = hope(plan, rule)
        made += [] if hoping is None else [hoping]
    return ["\n".join([*c.printed(each), ""]) for each in made]


def _function(
    plan: Layout, future: Future, node: ir.Formula, name: str, axes: tuple[ir.Axis, ...]
) -> c.Function:
    body: list[c.Statement] = []
    writing = _Writing(plan, future)
    names = ("place",) if len(axes) == 1 else ("first", "second")
    binds: Binds = {axis: c.Name(name) for axis, name in zip(axes, names)}
    value = writing.value(node, body, binds, whole=True)
    body.append(c.Return(value))
    places = tuple(("size_t", name) for _, name in zip(axes, names))
    parameters = (("const tm_future *", "future"), ("size_t", "slot"), *places)
    said = ("Put together from what is known about one cycle.",)
    return c.Function(said, "tm_known", name, parameters, tuple(body))


class _Writing:
    """Writes one function."""

    def __init__(self, plan: Layout, future: Future) -> None:
        self._plan, self._future, self._names = plan, future, 0

    def value(self, node: ir.Formula, body: list[c.Statement], binds: Binds, whole: bool = False) -> c.Expr:
        """The value of a formula. whole: it is what the function is about, and so is no table to it."""
        table = self._future.table(node)
        if table is not None and not (whole and node in self._future.given):
            return entry(table, binds)
        match node:
            case ir.Not():
                return c.Call("tm_not_known", (self.value(node.operand, body, binds),))
            case ir.Connective():
                both = (self.value(node.left, body, binds), self.value(node.right, body, binds))
                if node.op == "iff":
                    return c.Call("tm_not_known", (c.Call("tm_xor_known", both),))
                return c.Call(f"tm_{node.op}_known", both)
            case ir.Guarded():
                parts = (self.value(node.guard, body, binds), self.value(node.body, body, binds))
                return c.Call("tm_whenever_known", parts)
            case ir.Quantify():
                return self._all(node, body, binds)
            case _:
                raise AssertionError(f"{type(node).__name__} is put together from nothing")

    def _all(self, node: ir.Quantify, body: list[c.Statement], binds: Binds) -> c.Expr:
        """Over the elements that were there in that cycle."""
        self._names += 1
        every = node.extreme is Extreme.LEAST
        name, index = f"{'all' if every else 'some'}_{self._names}", c.Name(f"i_{self._names}")
        start = c.Call("tm_known_now", (_TRUE if every else _FALSE,))
        body.append(c.Declare("tm_known", name, start, False))
        inner: list[c.Statement] = []
        inside = {**binds, node.axis: index}
        guard: c.Expr = c.Call("tm_known_now", (_TRUE,))
        if node.guard is not None:
            guard = self.value(node.guard, inner, inside)
        value = self.value(node.body, inner, inside)
        function = "tm_for_all_known" if every else "tm_exists_known"
        inner.append(c.Evaluate(c.Call(function, (c.Address(c.Name(name)), guard, value))))
        body.append(for_those_there(self._plan, node.axis, index, inner))
        return c.Name(name)
