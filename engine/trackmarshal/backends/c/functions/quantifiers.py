"""Quantifiers: a loop over all of an axis for as many of them as can share it."""

from __future__ import annotations

from collections.abc import Sequence

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.facts import Value
from trackmarshal.backends.c.functions import several
from trackmarshal.backends.c.functions.operators import called
from trackmarshal.backends.c.functions.sweeps import sweeps
from trackmarshal.backends.c.functions.writer import ZERO, Writer
from trackmarshal.backends.c.names import identifier
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.spec import RuleInfo

#: What takes so long that it is asked first whether it is needed; of functions, those of libm.
_LONG_WAY = (
    ir.Lookup,
    ir.GridLookup,
    ir.Along,
    ir.OnLane,
    ir.Fold,
    ir.Quantify,
    ir.SweptInside,
    ir.SweptClear,
    ir.InArea,
)
#: What is not computed where it is not needed.
_WORTH = (ir.Arith, ir.Func, *_LONG_WAY)
#: What is computed whether it is needed or not: series of a timeline, and what goes with memories of the run.
_EVERY_CYCLE = (ir.Temporal, ir.Until, ir.Shift, ir.Tallied, ir.At, ir.OverRun, ir.Counted, ir.InState, ir.Kept)  # fmt: skip


def quantify(
    writer: Writer,
    nodes: Sequence[ir.Quantify],
    at: c.Scope,
    owners: Sequence[RuleInfo | None] = (),
    names: Sequence[str] = (),
) -> list[c.Expr]:
    """Quantifiers over one axis, in one loop; of several rules, where `owners` says whose each is. names: of their values."""
    found: dict[ir.Quantify, c.Expr] = {}
    for node in nodes:
        count = _counted(writer, node)
        if count is not None:
            found[node] = writer.over("told", count)
    at_once = several.chosen(writer, [node for node in nodes if node not in found])
    looping: list[several.Asked] = []
    for place, node in enumerate(nodes):
        if node in found:
            continue
        owner = owners[place] if owners else None
        looping.append((node, owner))
        writer.of(owner)
        every = node.extreme is Extreme.LEAST
        wanted = names[place] if names else "all" if every else "some"
        name = at.take(wanted, f"{wanted}_{identifier(node.names[0])}")
        if node in at_once:
            empty = writer.over("several_true" if every else "several_false", writer.count(node.axis))
            writer.add(at, c.Declare("tm_several", name, empty, False))
        else:
            writer.add(at, c.Declare(writer.type, name, writer.over("true" if every else "false"), False))
        found[node] = c.Name(name)
    whole = sweeps(writer, looping[0][0], at) if len(looping) == 1 else None
    once = {node for node, _ in looping if whole is not None or _alike(writer, node)}
    several.passes(writer, [each for each in looping if each[0] in at_once], at, found)
    differing = [each for each in looping if each[0] not in once and each[0] not in at_once]
    # What is the same for all is asked behind the loop, and only once.
    for some in (differing, [each for each in looping if each[0] in once]):
        if some:
            first = some[0][0]
            scope = (
                _if_any(writer, first.axis, at) if first in once else writer.loop(first.axis, at, first.names)
            )
            for together in _together(some):
                writer.of(together[0][1])
                inner = _where(writer, [node for node, _ in together], scope)
                _nested(writer, together, inner)
                for node, owner in together:
                    writer.of(owner)
                    _one_more(writer, node, found[node], inner, whole)
                inner.end(scope)
            at.close(scope)
    return [found[node] for node in nodes]


def _together(some: Sequence[several.Asked]) -> list[list[several.Asked]]:
    """Quantifiers in their order, those that ask something of the same elements beside the first of them."""
    asking: dict[ir.Formula | None, list[several.Asked]] = {}
    for each in some:
        asking.setdefault(each[0].guard, []).append(each)
    return list(asking.values())


def _nested(writer: Writer, together: Sequence[several.Asked], inner: c.Scope) -> None:
    """Quantifiers right within some, over one axis, in one loop: whether a rule holds, and whether it applies."""
    bodies = [(node.body, owner) for node, owner in together if isinstance(node.body, ir.Quantify)]
    for axis in dict.fromkeys(body.axis for body, _ in bodies):
        same = [(body, owner) for body, owner in bodies if body.axis is axis]
        if len(same) > 1 and all(writer.home_of(body, inner) is inner for body, _ in same):
            made = [body for body, _ in same]
            owners = [owner for _, owner in same]
            inner.known.update(zip(made, quantify(writer, made, inner, owners)))


def _where(writer: Writer, nodes: Sequence[ir.Quantify], scope: c.Scope) -> c.Scope:
    """The scope for what some quantifiers ask of elements in range: an `if` of its own where anything is computed that nobody else reads,
    and one before each part of the guard that takes long, for what stands before it."""
    guard, bodies = nodes[0].guard, [node.body for node in nodes]
    if guard is None:
        return scope
    inner, parts = scope, _conjuncts(guard)
    for place in range(1, len(parts)):
        own = writer.usage.only_in([*(part for _, part in parts[place:]), *bodies])
        if any(node in own and _takes_long(node) for node in ir.below(parts[place][1])) and not any(
            isinstance(node, _EVERY_CYCLE) for node in own
        ):
            inner = _if_may(writer, parts[place - 1][0], inner, own | {whole for whole, _ in parts[place:]})
    own = writer.usage.only_in(bodies)
    if any(isinstance(node, _EVERY_CYCLE) for node in own) or not any(
        isinstance(node, _WORTH) for node in own
    ):
        return inner
    return _if_may(writer, guard, inner, own)


def _if_may(writer: Writer, guard: ir.Formula, scope: c.Scope, own: frozenset[Value]) -> c.Scope:
    """A scope for what is computed only where a formula may hold."""
    condition = writer.over("may_hold", writer.formula(guard, scope, "guard", named=True))
    inner = scope.open(lambda body: c.If(condition, body))
    inner.own = own
    return inner


def _alike(writer: Writer, node: ir.Quantify) -> bool:
    """Whether a quantifier says the same of all that it goes through."""
    return node.axis not in writer.facts.free(node.body) and (
        node.guard is None or node.axis not in writer.facts.free(node.guard)
    )


def _one_more(
    writer: Writer, node: ir.Quantify, accumulated: c.Expr, scope: c.Scope, whole: c.Expr | None
) -> None:
    """What one sample or element adds to a quantifier's value. whole: the margin of all of them, where it is told at once."""
    every = node.extreme is Extreme.LEAST
    guard: c.Expr | None = None if node.guard is None else writer.formula(node.guard, scope, "guard")
    body: c.Expr
    if whole is not None:
        body = writer.over("apart_by", whole)
    elif guard is not None and several.asks_range(writer, node):
        body, guard = guard, None  # there is one in range
    else:
        least = (
            writer.known
            and every
            and isinstance(node.body, ir.Geometry)
            and node.axis in writer.facts.free(node.body)
        )
        if least and writer.usage.readers[node.body] == 1:
            # The least margin is asked for: one that is greater than the least so far need not be exact.
            writer.bounds[node.body] = c.Member(accumulated, "margin", False)
        body = writer.formula(node.body, scope)
    function = "for_all" if every else "exists"
    if guard is None:
        writer.add(scope, c.Evaluate(writer.over(function, c.Address(accumulated), body)))
    else:
        writer.add(scope, c.Evaluate(writer.over(f"{function}_where", c.Address(accumulated), guard, body)))


def _counted(writer: Writer, node: ir.Formula) -> c.Expr | None:
    """Whether there is anything, where no more than that is asked."""
    if not isinstance(node, ir.Quantify) or node.guard is not None or node.extreme is not Extreme.GREATEST:
        return None
    some = c.Binary(">", writer.count(node.axis), ZERO)
    if several.is_true(node.body):
        return some
    inner = _counted(writer, node.body)
    return None if inner is None else c.Binary("&&", some, inner)


def _if_any(writer: Writer, axis: ir.Axis, at: c.Scope) -> c.Scope:
    """A scope for what is the same for all of an axis."""
    condition = c.Binary(">", writer.count(axis), ZERO)
    return at.open(lambda body: c.If(condition, body))


def _conjuncts(formula: ir.Formula) -> list[tuple[ir.Formula, ir.Formula]]:
    """What has to hold, part by part, each after the formula that says it and all that stands before it."""
    if isinstance(formula, ir.Connective) and formula.op == "and":
        return [*_conjuncts(formula.left), (formula, formula.right)]
    return [(formula, formula)]


def _takes_long(node: ir.IR) -> bool:
    return isinstance(node, _LONG_WAY) or (isinstance(node, ir.Func) and bool(called(node.name)[1]))
