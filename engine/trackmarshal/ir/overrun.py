"""Formulas over the run: what they are made of, and how far they look ahead.

A formula over the run is put together, by connectives, guards, quantifiers over sets and temporal operators, from leaves: formulas
that speak of one cycle alone. Whoever knows the leaves of every cycle knows the formula.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from weakref import WeakKeyDictionary

from trackmarshal.ir import nodes as ir


def nanoseconds(seconds: float) -> int:
    """A time in whole nanoseconds, to the nearest: so that thirty times 0.1 s are 3 s. Raises ValueError or OverflowError where it is none."""
    return round(seconds * 1e9)


#: Stamps of a run stay below this, for every evaluator: times of generated C are whole nanoseconds in 64 bits, and sums with windows fit.
FURTHEST = 4_000_000_000_000_000_000


def stamped(seconds: float) -> int:
    """The stamp of a cycle in whole nanoseconds. Raises ValueError or OverflowError for one that no run has."""
    stamp = nanoseconds(seconds)
    if not -FURTHEST < stamp < FURTHEST:
        raise ValueError(f"a run has stamps within {FURTHEST / 1e9:g} s of 0, not {seconds!r} s")
    return stamp


#: What `sets` and `over_run` found, as long as a formula is there.
_SETS: WeakKeyDictionary[ir.AnyNode, tuple[ir.Axis, ...]] = WeakKeyDictionary()
_OVER_RUN: WeakKeyDictionary[ir.AnyNode, bool] = WeakKeyDictionary()


def over_run(formula: ir.Formula | ir.Num | None) -> bool:
    """Whether a formula speaks of other cycles than the present one."""
    if formula is None:
        return False
    found = _OVER_RUN.get(formula)
    if found is None:
        found = any(isinstance(node, (ir.Remembered, ir.Kept)) for node in ir.below(formula))
        _OVER_RUN[formula] = found
    return found


def recalls(node: ir.Formula) -> bool:
    """Whether a formula is about one cycle but for numbers in it that state machines keep: it is evaluated as a whole, once they are known."""
    return _whole(node) and any(isinstance(part, ir.Kept) for part in ir.below(node))


def _whole(node: ir.Formula) -> bool:
    if isinstance(node, ir.Quantify):
        return node.axis.kind == "samples"
    return isinstance(node, (ir.Compare, ir.SweptInside, ir.SweptClear, ir.InArea, ir.Scaled))


def recalled(node: ir.Formula) -> tuple[ir.Kept, ...]:
    """The numbers in a formula that state machines keep."""
    return tuple(part for part in outside_machines(node) if isinstance(part, ir.Kept))


def outside_machines(node: ir.Formula | ir.Num) -> Iterator[ir.AnyNode]:
    """A formula and all below it, but for what decides the states that machines are in; each shared one once."""
    seen: set[ir.AnyNode] = set()
    stack: list[ir.AnyNode] = [node]
    while stack:
        part = stack.pop()
        if part not in seen and not isinstance(part, ir.Machine):
            seen.add(part)
            yield part
            stack.extend(child for child in part.children() if isinstance(child, ir.IR))  # type: ignore[misc]


def parts(node: ir.Formula) -> tuple[ir.Formula, ...] | None:
    """The formulas of which a formula over the run is put together; None for a leaf.

    Of a cycle in which nothing was driven, nothing is known of what was, and all else: what joins both is put together, too.
    """
    if not over_run(node):
        return _joined(node)
    match node:
        case _ if recalls(node):
            return tuple(guard for kept in recalled(node) for guard in kept.machine.guards)
        case ir.OverRun() | ir.Counted() | ir.InState():
            return node.operands
        case ir.Not():
            return (node.operand,)
        case ir.Connective():
            return node.left, node.right
        case ir.Guarded():
            return node.guard, node.body
        case ir.Quantify():
            return (node.body,) if node.guard is None else (node.guard, node.body)
        case _:
            raise AssertionError(f"{type(node).__name__} is put together from no formulas over the run")


@lru_cache(maxsize=4096)
def _joined(node: ir.Formula) -> tuple[ir.Formula, ...] | None:
    from trackmarshal.ir.reads import asks_what_was_driven  # which looks for what this module knows

    match node:
        case ir.Not():
            return None if _joined(node.operand) is None else (node.operand,)
        case ir.Connective():
            sides = node.left, node.right
            apart = asks_what_was_driven(node.left) != asks_what_was_driven(node.right)
            return sides if apart or any(_joined(side) is not None for side in sides) else None
        case _:
            return None


def leaves(
    formula: ir.Formula, taken_apart: Callable[[ir.Formula], tuple[ir.Formula, ...] | None] = parts
) -> Iterator[ir.Formula]:
    """The formulas about one cycle alone from which a formula is put together, each once, in order; or whatever is not `taken_apart`."""
    seen: set[ir.Formula] = set()
    stack = [formula]
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        below = taken_apart(node)
        if below is None:
            yield node
        else:
            stack.extend(reversed(below))


#: What depends on the variable of an axis by itself.
_ABOUT = (ir.Column, ir.Flag, ir.Ordinal, ir.Temporal, ir.Until, ir.Shift, ir.Tallied, ir.Machine)


def sets(node: ir.AnyNode) -> tuple[ir.Axis, ...]:
    """The axes of variables that are free in a formula, the outermost first."""
    found = _SETS.get(node)
    if found is None:  # asked in every cycle
        found = _SETS[node] = tuple(sorted(_free(node), key=lambda axis: axis.level))
    return found


def _free(root: ir.AnyNode) -> set[ir.Axis]:
    """The axes of variables that are free below a node. What is nearest is looked for along the axis of its own variable.

    A quantifier binds what is within it and nothing beside it: guards of a state machine may have one of the axis of a rule's own variable.
    """
    found: set[ir.Axis] = set()
    seen: set[ir.AnyNode] = set()
    stack = [root]
    while stack:
        part = stack.pop()
        if part in seen:
            continue
        seen.add(part)
        if isinstance(part, _ABOUT) and part.axis is not None:
            found.add(part.axis)
        axis, within, beside = _scope(part)
        found |= {free for each in within for free in _free(each)} - {axis}
        stack += beside
    return found


def _scope(part: ir.AnyNode) -> tuple[ir.Axis | None, list[ir.AnyNode], list[ir.AnyNode]]:
    """The axis of the variable that a node binds, what is directly below it within the scope of that, and what is beside it."""
    match part:
        case ir.At():
            return part.axis, [part.operand], []
        case ir.Quantify():
            return part.axis, [each for each in (part.guard, part.body) if each is not None], []
        case ir.Fold():
            within: list[ir.AnyNode] = [each for each in (part.guard, part.body) if each is not None]
            return part.axis, within, [] if part.otherwise is None else [part.otherwise]
        case _:
            return None, [], [child for child in part.children() if isinstance(child, ir.IR)]  # type: ignore[misc]


@lru_cache(maxsize=4096)
def unbound(root: ir.Formula | ir.Num) -> tuple[ir.AnyNode, ...]:
    """A formula and all below it, each once, but for what decides the states that machines are in, and for what is about a variable that is bound inside.

    Such a one may have the level of a variable that the formula is about, as where a `let` before `for all` names a number of many.
    """
    found: dict[ir.AnyNode, None] = {}
    seen: set[tuple[ir.AnyNode, frozenset[ir.Axis]]] = set()
    stack: list[tuple[ir.AnyNode, frozenset[ir.Axis]]] = [(root, frozenset())]
    while stack:
        part, bound = stack.pop()
        if (part, bound) in seen or isinstance(part, ir.Machine):
            continue
        seen.add((part, bound))
        if not bound or bound.isdisjoint(sets(part)):
            found[part] = None
        axis, within, beside = _scope(part)
        stack += [(each, bound if axis is None else bound | {axis}) for each in within]
        stack += [(each, bound) for each in beside]
    return tuple(found)


@lru_cache(maxsize=4096)
def looks_ahead(node: ir.Formula) -> bool:
    """Whether a formula says something of cycles after its own."""
    return any(isinstance(part, ir.Remembered) and not part.past for part in ir.below(node))


def ahead(node: ir.Formula) -> int | None:
    """How many nanoseconds after a cycle a formula about it can still change; None: for ever. Cycles that `next` waits for are not counted."""
    below = parts(node)
    if below is None:
        return 0
    reaches = [ahead(part) for part in below]
    own = 0 if not isinstance(node, ir.OverRun) or node.past or node.op == "next" else node.upper
    if own is None or None in reaches:
        return None
    return own + max(reach for reach in reaches if reach is not None)


def back(node: ir.Formula) -> tuple[int, int]:
    """How far before a cycle the operators over others that look ahead look for a formula about it: nanoseconds, and cycles of `previous`.

    Those that look back alone do not count: what they say is settled in its own cycle. Of those without a bound, what they make of earlier
    cycles is kept.
    """
    below = parts(node)
    if below is None or not any(isinstance(part, ir.OverRun) and not part.past for part in ir.below(node)):
        return 0, 0
    inside = [back(part) for part in below]
    reach, steps = max(reach for reach, _ in inside), max(steps for _, steps in inside)
    if isinstance(node, ir.Remembered) and node.past:
        return reach + (node.upper or 0), steps + (isinstance(node, ir.OverRun) and node.op == "previous")
    return reach, steps
