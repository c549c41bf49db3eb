"""The nodes of the IR. Numbers are floats in SI units; formulas have a truth and a margin.

Nodes are compared by identity: the `Interner` makes equal numeric nodes one node, so that whatever two rules
compute alike is computed once. Evaluators must handle every class here and raise on any other.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, TypeVar

from trackmarshal.node import Node
from trackmarshal.source import Span


class IR(Node):
    """A node of the IR; equal only to itself."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__


class Axis(IR):
    """What a variable ranges over: the samples of a timeline, or the elements of a set.

    `width` consecutive samples are bound at once; `level` is the nesting depth inside the rule, from 0.
    """

    signal: str
    kind: str  # "samples" or "elements"
    width: int
    level: int


class Num(IR):
    """A number."""


class Const(Num):
    """A number of the spec, in SI."""

    value: float


class Param(Num):
    """A parameter, by its qualified name."""

    name: str


class Column(Num):
    """A field of the variable of an axis; `offset` counts samples from the first bound one, clamped at the start."""

    axis: Axis
    field: str
    offset: int = 0


class Sample(Num):
    """A field of one sample of a timeline, by index (-1: the last)."""

    signal: str
    field: str
    index: int


class Scalar(Num):
    """A field of a single record."""

    signal: str
    field: str


class Arith(Num):
    """`+ - * /`, IEEE double, in the order written."""

    op: str
    left: Num
    right: Num


class Neg(Num):
    """Minus a number."""

    operand: Num


class Func(Num):
    """A built-in function of numbers: see `FUNCTIONS`."""

    name: str
    args: tuple[Num, ...]


class Choose(Num):
    """One of two numbers by a formula; undefined (NaN) where the formula is."""

    condition: Formula
    then: Num
    otherwise: Num


class Lookup(Num):
    """A table, linear between knots and clamped outside; NaN for a non-finite argument."""

    table: str
    argument: Num


class Line(IR):
    """A polyline: `place` (a `line` of a spec), a field of a signal (`track.left`), or the path of a trajectory."""

    kind: str  # "place", "signal", "path" or "centre"
    name: str
    field: str


class Area(IR):
    """A region: a `zone` of a spec, or a corridor signal."""

    kind: str  # "zone" or "corridor"
    name: str


class Along(Num):
    """A number read off a line: station, offset, direction or distance of a point; station_gap of two stations."""

    what: str
    line: Line
    args: tuple[Num, ...]


class Formula(IR):
    """Something true, false or undefined, with a margin."""


class Truth(Formula):
    """`true`, `false`."""

    value: bool


class Flag(Formula):
    """A Boolean of the input: an event (no field), a field of a record, or of the variable of an axis."""

    signal: str
    field: str | None
    axis: Axis | None
    offset: int
    span: Span


class Compare(Formula):
    """A comparison; `unit` is the SI unit of its margin, `shown` the one in which its limit is written ("": in SI)."""

    op: str
    left: Num
    right: Num
    unit: str
    span: Span
    shown: str = ""


class Geometry(Formula):
    """A geometric predicate; its margin is a signed distance in metres, and it holds where that is not negative.

    `swept_inside`: x0 y0 heading0 x1 y1 heading1 length width, in an area; `swept_clear`: the same, of the
    box x y heading length width; `in_area`: a point x y, in a zone.
    """

    what: str
    args: tuple[Num, ...]
    area: Area | None
    span: Span


class Not(Formula):
    operand: Formula


class Connective(Formula):
    """and, or, implies, iff, xor."""

    op: str
    left: Formula
    right: Formula


class Quantify(Formula):
    """`for all` or `exists` over an axis; elements whose guard does not hold are not in its range."""

    quantifier: str
    axis: Axis
    guard: Formula | None
    body: Formula
    names: tuple[str, ...]


class Guarded(Formula):
    """`whenever guard require body`: only the cycles in which the guard holds count."""

    guard: Formula
    body: Formula


class Temporal(Formula):
    """always, eventually (future), historically, once (past), along an axis; no bounds means to the end."""

    op: str
    axis: Axis
    operand: Formula
    lower: float | None
    upper: float | None


class Until(Formula):
    """until (future), since (past), along an axis."""

    op: str
    axis: Axis
    left: Formula
    right: Formula
    lower: float | None
    upper: float | None


class Shift(Formula):
    """next (step 1), previous (step -1); weak ones hold outside the trace."""

    axis: Axis
    operand: Formula
    step: int
    weak: bool


class Edge(Formula):
    """rising, falling."""

    op: str
    axis: Axis
    operand: Formula


class First(Formula):
    """The value at the first sample of the timeline."""

    axis: Axis
    name: str
    operand: Formula


#: Built-in functions and how many arguments they take.
FUNCTIONS = {
    "abs": 1, "sqrt": 1, "sin": 1, "cos": 1, "tan": 1, "exp": 1, "log": 1, "floor": 1,
    "min": 2, "max": 2, "atan2": 2, "pow": 2,
}  # fmt: skip

T = TypeVar("T", bound=IR)


def below(root: IR) -> Iterator[IR]:
    """A node and all below it, each shared one once."""
    seen: set[IR] = set()
    stack: list[IR] = [root]
    while stack:
        node = stack.pop()
        if node not in seen:
            seen.add(node)
            yield node
            stack.extend(child for child in node.children() if isinstance(child, IR))


class Interner:
    """Makes nodes; numeric nodes and axes with equal parts are the same node."""

    def __init__(self) -> None:
        self._known: dict[tuple[Any, ...], IR] = {}

    def make(self, kind: type[T], *parts: Any) -> T:
        """A node of a class, with all of its fields in order."""
        # repr tells -0.0 from 0.0 and joins equal NaNs; children are interned, so identity is equality.
        key = (kind, *(part if not isinstance(part, float) else repr(part) for part in parts))
        known = self._known.get(key)
        if known is None:
            known = self._known[key] = kind(*parts)
        return known  # type: ignore[return-value]
