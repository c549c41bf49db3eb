"""The C of what may still come of a rule that looks ahead: as `backends.over_run.hoping` has it, a function a rule."""

from __future__ import annotations

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.over_run.kept import Binds, entry, for_those_there
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.overrun import looks_ahead
from trackmarshal.ir.spec import RuleInfo

_ANYTHING = c.Call("tm_any_hope", ())
#: What has a name already.
Made = dict[ir.Formula, c.Expr | None]


def hope(plan: Layout, rule: RuleInfo) -> c.Function | None:
    """What may still come of a rule about the present cycle; None where that is anything."""
    assert rule.formula is not None
    body: list[c.Statement] = []
    value = _Writing(plan).hope(plan.same(rule.formula), body, {}, {})
    if value is None:
        return None
    body.append(c.Return(value))
    said = ("Whether anything that is to come can make it surely true, or surely false.",)
    parameters = (("const tm_future *", "future"), ("size_t", "slot"))
    return c.Function(said, "tm_hope", f"tm_rule_{plan.rule_names[rule.name]}_hope", parameters, tuple(body))


class _Writing:
    """Writes one function. None stands for anything."""

    def __init__(self, plan: Layout) -> None:
        self._plan, self._names = plan, 0

    def hope(self, node: ir.Formula, body: list[c.Statement], binds: Binds, made: Made) -> c.Expr | None:
        """A name for what may come of a formula, which is worked out once."""
        if node not in made:
            value = self._hope(node, body, binds, made)
            if isinstance(value, c.Call):
                value = self._named(value, body)
            made[node] = value
        return made[node]

    def _named(self, value: c.Expr, body: list[c.Statement]) -> c.Expr:
        self._names += 1
        name = f"hope_{self._names}"
        body.append(c.Declare("tm_hope", name, value))
        return c.Name(name)

    def _hope(self, node: ir.Formula, body: list[c.Statement], binds: Binds, made: Made) -> c.Expr | None:
        def of(part: ir.Formula) -> c.Expr | None:
            return self.hope(part, body, binds, made)

        if not looks_ahead(node):
            return c.Call("tm_hope_of", (self._settled(node, binds),))
        match node:
            case ir.Not():
                return _call("tm_not_hope", of(node.operand))
            case ir.Connective():
                both = of(node.left), of(node.right)
                if node.op == "iff":
                    different = _call("tm_xor_hope", *both)
                    return None if different is None else c.Call("tm_not_hope", (different,))
                return _call(f"tm_{node.op}_hope", *both)
            case ir.Guarded():
                spared = _call("tm_not_hope", of(node.guard))
                return _call("tm_or_hope", spared, of(node.body))
            case ir.Quantify():
                return self._all(node, body, binds, made)
            case ir.OverRun() if not node.past:
                return _ahead(node, [of(operand) for operand in node.operands])
            case ir.OverRun() | ir.Counted():
                return None
            case _:
                raise AssertionError(f"{type(node).__name__} is put together from nothing")

    def _settled(self, node: ir.Formula, binds: Binds) -> c.Expr:
        table = self._plan.future.table(node)
        assert table is not None, "what is settled is kept"
        return entry(table, binds)

    def _all(self, node: ir.Quantify, body: list[c.Statement], binds: Binds, made: Made) -> c.Expr:
        """Over the elements that are there."""
        self._names += 1
        every = node.extreme is Extreme.LEAST
        name, index = f"{'all' if every else 'some'}_{self._names}", c.Name(f"i_{self._names}")
        start = c.Call("tm_certain_hope", (c.Literal("true" if every else "false"),))
        body.append(c.Declare("tm_hope", name, start, False))
        inner: list[c.Statement] = []
        inside, known = {**binds, node.axis: index}, dict(made)
        guard: c.Expr | None = c.Call("tm_certain_hope", (c.Literal("true"),))
        if node.guard is not None:
            guard = self.hope(node.guard, inner, inside, known)
        value = self.hope(node.body, inner, inside, known)
        function = "tm_for_all_hope" if every else "tm_exists_hope"
        inner.append(
            c.Evaluate(c.Call(function, (c.Address(c.Name(name)), guard or _ANYTHING, value or _ANYTHING)))
        )
        body.append(for_those_there(self._plan, node.axis, index, inner))
        return c.Name(name)


def _ahead(node: ir.OverRun, operands: list[c.Expr | None]) -> c.Expr | None:
    """Of an operator: the present cycle is in its window if that begins with it, and nothing else is yet."""
    inside, goes_on = not node.lower, node.upper != 0
    match node.op:
        case "next":
            return None
        case "always" | "eventually":
            if not inside:
                return None
            return _call(f"tm_{node.op}_hope", operands[0]) if goes_on else operands[0]
        case "until" if not goes_on:
            return operands[1]
        case "until":
            return _call("tm_until_hope", *operands) if inside else _call("tm_always_hope", operands[0])
        case _:
            raise AssertionError(f"`{node.op}` does not look ahead")


def _call(function: str, *given: c.Expr | None) -> c.Expr | None:
    """Of what may be anything in all its parts, anything comes."""
    return c.Call(function, tuple(one or _ANYTHING for one in given)) if any(given) else None
