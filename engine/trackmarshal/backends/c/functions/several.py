"""Quantifiers over timelines that are worked out for several samples at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.facts import Value
from trackmarshal.backends.c.functions.margins import all_of, always_finite, told_by_margin
from trackmarshal.backends.c.functions.writer import Writer
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import identifier
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme, FunctionName
from trackmarshal.ir.spec import RuleInfo

#: A quantifier, and whose it is where it stands beside those of other rules.
Asked = tuple[ir.Quantify, RuleInfo | None]
#: Functions that take their arguments as they come, without a branch or a call.
_IN_LINE: frozenset[FunctionName] = frozenset(["abs", "sqrt", "hypot", "floor", "min", "max"])


def takes_several(plan: Layout, rules: Sequence[RuleInfo]) -> bool:
    """Whether rules have anything that may be worked out for several samples at once."""
    return any(
        isinstance(node, ir.Quantify) and _simple(plan, node)
        for rule in rules
        for root in rule.roots
        for node in ir.below(root)
    )


def _simple(plan: Layout, node: ir.Quantify) -> bool:
    """Whether a quantifier over a timeline is of simple arithmetic, and of nothing that is called, or entered only sometimes: it is worked
    out for several samples as it is for one."""
    axis = node.axis
    if axis.kind != "samples" or axis.signal in plan.courses:
        return False
    if node.guard is not None and is_true(node.body):
        if node.extreme is Extreme.LEAST:
            return False  # it asks nothing
        asked = [node.guard]
    else:
        asked = [node.body] if node.guard is None else [node.guard, node.body]
    differs = any(axis in plan.facts.free(each) for each in asked)
    if not (told_by_margin(asked[-1]) and always_finite(asked[-1])):
        return False
    return differs and all(_straight(plan, each) for each in asked)


def _straight(plan: Layout, value: Value) -> bool:
    """Whether all of a value that differs from sample to sample is arithmetic in a line."""

    def parts(node: Value) -> Iterable[Value] | None:
        match node:
            case _ if not plan.facts.free(node):
                return () if isinstance(node, ir.Num) else None
            case ir.Column():
                return () if node.offset >= 0 else None
            case ir.Func() if node.name not in _IN_LINE:
                return None
            case ir.Arith() | ir.Neg() | ir.Func() | ir.Choose() | ir.Compare() | ir.Connective() | ir.Not():
                return plan.facts.operands(node)
            case _:
                return None

    return all_of(value, parts)


def chosen(writer: Writer, nodes: Sequence[ir.Quantify]) -> frozenset[ir.Quantify]:
    """Those quantifiers that are worked out for several samples at once. What asks something of the same samples stays together."""
    if not writer.several:
        return frozenset()
    simple = [node for node in nodes if _simple(writer.plan, node)]
    apart = {node.guard for node in nodes if node.guard is not None and node not in simple}
    return frozenset(node for node in simple if node.guard not in apart)


def asks_range(writer: Writer, node: ir.Quantify) -> bool:
    """Whether a quantifier asks no more than whether there is anything in range."""
    return node.extreme is Extreme.GREATEST and node not in writer.margins and is_true(node.body)


def passes(
    writer: Writer,
    some: Sequence[Asked],
    at: c.Scope,
    found: dict[ir.Quantify, c.Expr],
) -> None:
    """These quantifiers over one axis, for several samples at once, in one loop."""
    if not some:
        return
    loop, inner, n = _loop(writer, some[0][0].axis, at, some[0][0].names)
    added = list[c.Statement]()
    for node, owner in some:
        writer.of(owner)
        kind = "for_all" if node.extreme is Extreme.LEAST else "exists"
        given = [c.Address(found[node]), n]
        where = ""
        if node.guard is not None:
            given.append(writer.formula(node.guard, inner, "guard"))
            where = "" if asks_range(writer, node) else "_where"
        if node.guard is None or where:
            given.append(writer.formula(node.body, inner))
        writer.add(inner, c.Evaluate(writer.over(f"put{where}", *given)))
        added.append(c.Evaluate(writer.over(f"{kind}_put{where}", c.Address(found[node]))))
        told = "all_put" if node.extreme is Extreme.LEAST else "some_put"
        found[node] = writer.over(told, c.Address(found[node]))
    loop.close(inner)
    for each in added:
        loop.add(each)
    at.close(loop)


def _loop(
    writer: Writer, axis: ir.Axis, at: c.Scope, names: tuple[str, ...]
) -> tuple[c.Scope, c.Scope, c.Expr]:
    """A scope for each pass over several values of an axis, in it one that goes through them, and the place among them."""
    count = writer.declare(at, "size_t", writer.count(axis), "windows" if axis.width > 1 else "count")
    number, first, place = c.Name("pass"), c.Name("first"), c.Name("n")
    passes, several = writer.over("passes", count), c.Name("TM_SEVERAL")

    def outer(body: tuple[c.Statement, ...]) -> c.Statement:
        begin = c.Declare("size_t", first.name, writer.over("pass_first", number, count))
        step = c.Unary("++", number)
        return c.For(number.name, c.Binary("<", number, passes), step, (begin, *body), axis.signal)

    def head(body: tuple[c.Statement, ...]) -> c.Statement:
        own = c.Declare("size_t", index, c.Binary("+", first, place))
        return c.For(place.name, c.Binary("<", place, several), c.Unary("++", place), (own, *body))

    loop = at.open(outer)
    number, first = c.Name(loop.take("pass")), c.Name(loop.take("first"))
    inner = loop.open(head)
    place, index = c.Name(inner.take("n")), inner.take(identifier(names[0]))
    inner.binds[axis] = c.Name(index)
    inner.binders[axis] = names
    return loop, inner, place


def either(one: c.Function, several: c.Function | None) -> list[str]:
    """The text of a function that takes one sample after the other, and of the one beside it where there is one that takes several."""
    text = [] if several is None else list(c.printed(several))
    if not any("tm_several " in line for line in text):
        return list(c.printed(one))
    return ["#if TM_SEVERAL > 1u", *text, "#else", *c.printed(one), "#endif"]


def is_true(formula: ir.Formula) -> bool:
    return isinstance(formula, ir.Truth) and formula.value
