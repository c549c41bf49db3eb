"""What an expression can stand for while it is checked; only numbers and formulas reach the IR."""

from __future__ import annotations

from collections.abc import Callable

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import SignalType
from trackmarshal.node import Node
from trackmarshal.source import Span
from trackmarshal.units import Dimension, name


class Poison(Exception):
    """An error was reported; what depends on the expression is not checked further."""


class Value(Node):
    """Anything an expression can stand for."""

    @property
    def spoken(self) -> str:
        raise NotImplementedError(type(self).__name__)


class NumberValue(Value):
    """A number with a dimension."""

    node: ir.Num
    dimension: Dimension
    span: Span

    @property
    def spoken(self) -> str:
        return name(self.dimension)


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
    """A footprint: the hull of a box at two poses."""

    start: ir.Pose
    end: ir.Pose
    length: ir.Num
    width: ir.Num
    span: Span

    @property
    def spoken(self) -> str:
        return "a footprint"
