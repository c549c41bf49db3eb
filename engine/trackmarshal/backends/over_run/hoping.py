"""Whether anything that is to come can still make a formula surely true, or surely false, of a cycle in which so much is undefined as is known in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple, assert_never

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.overrun import looks_ahead


class Hope(NamedTuple):
    """Of one cycle Booleans, of many arrays of them: whether a formula may yet be surely true, and surely false. Neither: it stays undefined."""

    true: Any
    false: Any


ANYTHING = Hope(True, True)
#: What the variables of sets stand for, by the level of their axes.
Ids = Mapping[int, str]


class Hoping:
    """What formulas about one cycle, or about each of many, may yet be, given what is settled in it, of elements; and which of these there are.

    Of an operator that looks ahead, the cycle itself is all that has been seen of its window. Of one that looks back at what looks ahead, and of
    counts of that, nothing is claimed.
    """

    def __init__(
        self, settled: Callable[[ir.Formula, Ids], Hope], elements: Callable[[ir.Axis], Iterable[str]]
    ) -> None:
        self._settled, self._elements = settled, elements
        self._known: dict[tuple[ir.Formula, tuple[tuple[int, str], ...]], Hope] = {}

    def hope(self, node: ir.Formula, ids: Ids) -> Hope:
        key = node, tuple(ids.items())
        known = self._known.get(key)
        if known is None:
            known = self._known[key] = self._hope(node, ids)
        return known

    def _hope(self, node: ir.Formula, ids: Ids) -> Hope:
        if not looks_ahead(node):
            return self._settled(node, ids)
        match node:
            case ir.Not():
                return _not(self.hope(node.operand, ids))
            case ir.Connective():
                a, b = self.hope(node.left, ids), self.hope(node.right, ids)
                match node.op:
                    case "and":
                        return _and(a, b)
                    case "or":
                        return _or(a, b)
                    case "xor":
                        return _differ(a, b)
                    case "iff":
                        return _not(_differ(a, b))
                    case _:
                        assert_never(node.op)
            case ir.Guarded():
                return _or(_not(self.hope(node.guard, ids)), self.hope(node.body, ids))
            case ir.Quantify():
                return self._quantified(node, ids)
            case ir.OverRun() if not node.past:
                return self._ahead(node, ids)
            case ir.OverRun() | ir.Counted():
                return ANYTHING
            case _:
                raise AssertionError(f"{type(node).__name__} is no formula over the run")

    def _quantified(self, node: ir.Quantify, ids: Ids) -> Hope:
        every = node.extreme is Extreme.LEAST
        found = Hope(every, not every)
        for name in self._elements(node.axis):
            inner = {**ids, node.axis.level: name}
            body = self.hope(node.body, inner)
            if node.guard is not None:
                guard = self.hope(node.guard, inner)
                body = _or(_not(guard), body) if every else _and(guard, body)
            found = _and(found, body) if every else _or(found, body)
        return found

    def _ahead(self, node: ir.OverRun, ids: Ids) -> Hope:
        if node.op == "next":
            return ANYTHING
        #: Whether the cycle itself is in the window, and whether others may come into it.
        inside, goes_on = not node.lower, node.upper != 0
        held, goal = self.hope(node.operands[0], ids), self.hope(node.operands[-1], ids)
        match node.op:
            case "always":
                return Hope(held.true if inside else True, True if goes_on else held.false)
            case "eventually":
                return Hope(True if goes_on else goal.true, goal.false if inside else True)
            case "until":
                reached = goal.true if inside else False
                return Hope(reached | held.true if goes_on else reached, goal.false if inside else True)
            case "once" | "historically" | "since" | "previous":
                raise AssertionError(f"`{node.op}` does not look ahead")
            case _:
                assert_never(node.op)


def _not(a: Hope) -> Hope:
    return Hope(a.false, a.true)


def _and(a: Hope, b: Hope) -> Hope:
    return Hope(a.true & b.true, a.false | b.false)


def _or(a: Hope, b: Hope) -> Hope:
    return Hope(a.true | b.true, a.false & b.false)


def _differ(a: Hope, b: Hope) -> Hope:
    return Hope((a.true & b.false) | (a.false & b.true), (a.true & b.true) | (a.false & b.false))
