"""How formulas that look back are put together of their parts in a cycle: worked out once for each formula, since it is asked for in every cycle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, assert_never

from trackmarshal.backends.over_run.counts import Range, compared
from trackmarshal.backends.over_run.history import parts_of, recalled_of, recalls_of, sets_of
from trackmarshal.backends.over_run.lives import ANY_CYCLES
from trackmarshal.backends.over_run.machines import Possible, is_in, kept, stepped
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.runtime.kleene import TRUE, UNDEFINED, connect, greatest, least, negate
from trackmarshal.runtime.verdict import Bound, Truth

if TYPE_CHECKING:
    from trackmarshal.backends.over_run.cells import Present

#: The elements that the variables of sets stand for, by their ids, in the order of their levels.
Key = tuple[str, ...]
#: A value in the present cycle, for some elements.
Asking = Callable[["Present", Key], Truth]


@cache
def _levels(node: ir.Formula | ir.Num | ir.Machine) -> tuple[int, ...]:
    """The levels of the variables of sets that are free in a node, in the order of keys."""
    return tuple(axis.level for axis in sets_of(node))


@cache
def _picking(node: ir.Formula | ir.Num | ir.Machine, levels: tuple[int, ...]) -> Callable[[Key], Key]:
    """A node's key out of one for variables of these levels."""
    own = _levels(node)
    if own == levels:
        return lambda key: key
    places = [levels.index(level) for level in own]
    return lambda key: tuple([key[place] for place in places])


def _part(part: ir.Formula, levels: tuple[int, ...]) -> Asking:
    """What asks for a part of something with variables of these levels."""
    if parts_of(part) is None:
        if _levels(part) == levels:
            return lambda present, key: present.now.leaf(part, key)
        pick = _picking(part, levels)
        return lambda present, key: present.now.leaf(part, pick(key))
    if _levels(part) == levels:
        return lambda present, key: present.over_run(part, key)
    pick = _picking(part, levels)
    return lambda present, key: present.over_run(part, pick(key))


@cache
def operands_of(node: ir.OverRun | ir.Counted) -> Callable[[Present, Key], tuple[Truth, ...]]:
    """What asks for the operands of an operator."""
    parts = _parts(node.operands, node)
    return lambda present, key: tuple([part(present, key) for part in parts])


@cache
def stepping(machine: ir.Machine) -> Callable[[Present, Key], Possible]:
    """What asks for the states that a machine may be in after the present cycle."""
    levels = _levels(machine)
    guards = _parts(machine.guards, machine)

    def after(present: Present, key: Key) -> Possible:
        return stepped(
            machine,
            present.cells.before(machine, key, present),
            present.now.t,
            lambda place: guards[place](present, key),
            lambda number: present.now.measured(number, _picking(number, levels)(key)),
        )

    return after


@cache
def asking(node: ir.Formula) -> Asking:
    """What asks for the value of a formula over the run that looks back."""
    if recalls_of(node):
        return _recalling(node)
    match node:
        case ir.OverRun():
            return _remembered(node)
        case ir.Counted():
            return _counted(node)
        case ir.InState():
            pick = _picking(node.machine, _levels(node))
            return lambda present, key: is_in(present.possible(node.machine, pick(key)), node.state)
        case ir.Not():
            (operand,) = _parts([node.operand], node)
            return lambda present, key: negate(operand(present, key))
        case ir.Connective():
            left, right = _parts([node.left, node.right], node)
            return lambda present, key: connect(node.op, left(present, key), right(present, key))
        case ir.Guarded():
            return _guarded(node)
        case ir.Quantify():
            return _quantified(node)
        case _:
            raise AssertionError(f"{type(node).__name__} is no formula over the run")


def _parts(parts: Sequence[ir.Formula], node: ir.Formula | ir.Machine) -> list[Asking]:
    return [_part(part, _levels(node)) for part in parts]


def _recalling(node: ir.Formula) -> Asking:
    levels = _levels(node)
    numbers = [(one, _picking(one.machine, levels)) for one in recalled_of(node)]

    def value(present: Present, key: Key) -> Truth:
        t = present.now.t
        known = {
            one: kept(one.machine, one.name, present.possible(one.machine, pick(key)), t)
            for one, pick in numbers
        }
        return present.now.recalled(node, key, known)

    return value


def _remembered(node: ir.OverRun) -> Asking:
    operands = operands_of(node)

    def value(present: Present, key: Key) -> Truth:
        if present.without(node, key):
            return UNDEFINED
        found: Truth = present.cells.value(node, key, present, operands(present, key))
        return found

    return value


def _counted(node: ir.Counted) -> Asking:
    operands = operands_of(node)

    def value(present: Present, key: Key) -> Truth:
        count: Any = Range(0, ANY_CYCLES)
        if not present.without(node, key):
            count = present.cells.value(node, key, present, operands(present, key))
        return compared(node, count, present.now.number(node.limit))

    return value


def _guarded(node: ir.Guarded) -> Asking:
    guarding, inside = _parts([node.guard, node.body], node)

    def value(present: Present, key: Key) -> Truth:
        guard = guarding(present, key)
        if not (guard.worst.sat or guard.best.sat):
            return TRUE
        body = inside(present, key)
        worst = body.worst if guard.best.sat else TRUE.worst
        return Truth(worst, body.best if guard.worst.sat else TRUE.best)

    return value


def _quantified(node: ir.Quantify) -> Asking:
    """Elements that may be in range count in the worst case of `for all` and in the best of `exists`; those that surely are, in the other."""
    match node.extreme:
        case Extreme.LEAST:
            join = least
        case Extreme.GREATEST:
            join = greatest
        case _:
            assert_never(node.extreme)
    signal, nothing, of_all = node.axis.signal, Bound(*node.extreme.neutral), join is least
    levels = (*_levels(node), node.axis.level)
    guarding = None if node.guard is None else _part(node.guard, levels)
    inside = _part(node.body, levels)

    def value(present: Present, key: Key) -> Truth:
        worst = best = nothing
        for name in present.now.ids[signal]:
            inner = (*key, name)
            guard = TRUE if guarding is None else guarding(present, inner)
            surely, possibly = guard.worst.sat, guard.best.sat
            if not (surely or possibly):
                continue  # nobody asks for the body, which may take long
            body = inside(present, inner)
            if possibly if of_all else surely:
                worst = join(worst, body.worst)
            if surely if of_all else possibly:
                best = join(best, body.best)
        return Truth(worst, best)

    return value
