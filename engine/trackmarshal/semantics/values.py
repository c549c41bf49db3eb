"""What an expression can stand for while it is checked; only numbers and formulas reach the IR."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import SignalType
from trackmarshal.node import Node
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import NUMBER, Dimension, name


class Poison(Exception):
    """An error was reported; what depends on the expression is not checked further."""


class Value(Node):
    """Anything an expression can stand for."""

    @property
    def spoken(self) -> str:
        raise NotImplementedError(type(self).__name__)


class NumberValue(Value):
    """A number with a dimension; `written` is the unit in which it stands in the spec, "" where it is in none of its own."""

    node: ir.Num
    dimension: Dimension
    span: Span
    #: Whether it is a literal other than 0 without a unit, or arithmetic on such literals.
    bare: bool = False
    #: The unit in which it is written, where it has one of its own.
    written: str = ""

    @property
    def spoken(self) -> str:
        return name(self.dimension)


def common(*values: NumberValue) -> str:
    """The unit in which several numbers are written; "" where they disagree."""
    units = {value.written for value in values} - {""}
    return units.pop() if len(units) == 1 else ""


def product(op: str, left: NumberValue, right: NumberValue) -> str:
    """The unit in which a product or a quotient is written: that of the quantity which a plain factor scales."""
    if right.dimension == NUMBER and (left.dimension != NUMBER or not right.written):
        return left.written
    if op == "*" and left.dimension == NUMBER and (right.dimension != NUMBER or not left.written):
        return right.written
    return ""


def of_limit(left: NumberValue, right: NumberValue) -> str:
    """The unit in which a comparison's limit is written: that of the side which depends on no input, else of the right one."""
    for side in (right, left):
        if all(isinstance(node, _FIXED) for node in ir.below(side.node)):
            return side.written
    return right.written or left.written


def own_unit(unit: str | None) -> str:
    """A unit as written; "" for a plain number."""
    return "" if unit in (None, "1") else str(unit)


def written_unit(values: Iterable[ast.Expr], declared: str) -> str:
    """The unit in which the values of a declaration are written, where all are numbers in one unit, else the declared one."""
    units = set()
    for value in values:
        literal = value.operand if isinstance(value, ast.Unary) else value
        units.add(own_unit(literal.unit) if isinstance(literal, ast.Number) else "")
    unit = units.pop() if len(units) == 1 else ""
    return unit or own_unit(declared)


_FIXED = (ir.Const, ir.Param, ir.Arith, ir.Neg, ir.Func)


class FormulaValue(Value):
    """A formula."""

    node: ir.Formula
    span: Span

    @property
    def spoken(self) -> str:
        return "a formula"


class RecordValue(Value):
    """Something with fields: the state of the car, an object, one sample of a trajectory."""

    what: str
    signal: SignalType | None
    #: Dimension of a number field, None for a Boolean one.
    shape: dict[str, Dimension | None]
    read: Callable[[str, Span], ir.Num | ir.Formula]
    #: For a sample of a timeline: the same sample's predecessor (itself for the first one).
    previous: Callable[[str, Span], ir.Num | ir.Formula] | None
    span: Span

    @property
    def spoken(self) -> str:
        return self.what


class SignalValue(Value):
    """A whole signal: a timeline, a set, a corridor, a polyline."""

    signal: SignalType
    span: Span

    @property
    def spoken(self) -> str:
        return f"the {'set' if self.signal.many else self.signal.kind} `{self.signal.name}`"


class LineValue(Value):
    """A polyline."""

    line: ir.Line
    span: Span

    @property
    def spoken(self) -> str:
        return "a line"


class AreaValue(Value):
    """A zone or a corridor."""

    area: ir.Area
    span: Span

    @property
    def spoken(self) -> str:
        return "an area"


class Broken(Value):
    """What a name stands for whose own declaration has an error: nothing is said about its uses."""

    @property
    def spoken(self) -> str:
        return "something with an error of its own"


class RegionValue(Value):
    """A footprint: what a box covers between two poses, straight or, where `bend` has curvatures, along a curve."""

    start: ir.Pose
    end: ir.Pose
    length: ir.Num
    width: ir.Num
    bend: tuple[ir.Num, ...]
    span: Span

    @property
    def spoken(self) -> str:
        return "a footprint"
