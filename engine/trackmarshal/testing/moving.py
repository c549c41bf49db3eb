"""A rule with its limits moved: what its margin is where they are a little looser, or stricter."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeVar, assert_never

from trackmarshal.ir import nodes as ir

N = TypeVar("N", bound=ir.IR)


class Move(NamedTuple):
    """By how much the margin of a formula is to grow, in distances of each unit (1 or -1), and where the points of `inside` go, in distances [m].

    A zone has no one direction in which it grows at a point: whoever moves its border moves the point, each way.
    """

    sign: int
    x: int = 0
    y: int = 0


def moves(formula: ir.Formula) -> Iterator[tuple[Move, ...]]:
    """What is to be tried: first all that makes a formula looser, then all that makes it stricter."""
    places = any(isinstance(node, ir.InArea) for node in ir.below(formula))
    sides = ((1, 0), (-1, 0), (0, 1), (0, -1)) if places else ((0, 0),)
    for sign in (1, -1):
        yield tuple(Move(sign, x, y) for x, y in sides)


def moved(formula: ir.Formula, move: Move, distance: Callable[[str], float]) -> ir.Formula:
    """The formula with every limit in it moved; `distance` says by how much in a unit, in SI.

    Limits are those of comparisons, the sizes of what has to fit or to keep clear, and numbers of cycles or samples, which move by one. Guards,
    and what state machines go by, choose what is demanded and are no limits of it.
    """
    return _Moving(move, distance).formula(formula, move.sign)


class _Moving:
    def __init__(self, move: Move, distance: Callable[[str], float]) -> None:
        self._move, self._distance = move, distance
        self._done: dict[tuple[ir.Formula, int], ir.Formula] = {}

    def formula(self, node: ir.Formula, sign: int) -> ir.Formula:
        """A formula whose margin grows by a distance (sign 1), or shrinks."""
        if (node, sign) not in self._done:
            self._done[node, sign] = self._made(node, sign)
        return self._done[node, sign]

    def _made(self, node: ir.Formula, sign: int) -> ir.Formula:
        match node:
            case ir.Compare():
                return (
                    node
                    if node.op == "is"
                    else _with(node, right=_plus(node.right, sign * self._distance(node.unit)))
                )
            case ir.SweptInside() | ir.SweptClear():
                by = -2.0 * sign * self._distance("m")  # on both sides of it
                return _with(node, length=_plus(node.length, by), width=_plus(node.width, by))
            case ir.InArea():
                step = self._distance("m")
                return _with(node, x=_plus(node.x, self._move.x * step), y=_plus(node.y, self._move.y * step))
            case ir.Not():
                return _with(node, operand=self.formula(node.operand, -sign))
            case ir.Connective():
                # Of `iff` and `xor` the difference of both sides' margins counts: they go apart, and do not follow each other.
                other = sign if node.op in ("and", "or") else -sign
                return _with(node, left=self.formula(node.left, sign), right=self.formula(node.right, other))
            case ir.Until():
                return _with(node, left=self.formula(node.left, sign), right=self.formula(node.right, sign))
            case ir.Quantify() | ir.Guarded():
                return _with(node, body=self.formula(node.body, sign))
            case ir.Scaled() | ir.Temporal() | ir.Shift() | ir.At():
                return _with(node, operand=self.formula(node.operand, sign))
            case ir.OverRun():
                return _with(node, operands=tuple(self.formula(one, sign) for one in node.operands))
            case ir.Counted() | ir.Tallied():  # one more, or one less, is allowed
                return _with(node, limit=_plus(node.limit, -sign if node.turned else sign))
            case ir.Truth() | ir.Flag() | ir.InState():
                return node
            case _:
                assert_never(node)


def _with(node: N, **parts: object) -> N:
    return type(node)(**{**node.__dict__, **parts})


def _plus(number: ir.Num, by: float) -> ir.Num:
    return ir.Arith("+", number, ir.Const(by)) if by else number
