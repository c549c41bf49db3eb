"""Numbers, each with its dimension."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, TypeAlias, assert_never

from trackmarshal.ir.operators import ArithmeticOp, FunctionName
from trackmarshal.source import Span
from trackmarshal.typed.base import Typed
from trackmarshal.typed.symbol import Symbol
from trackmarshal.units import Dimension

if TYPE_CHECKING:
    from trackmarshal.typed import Value
    from trackmarshal.typed.formulas import Formula, Machine
    from trackmarshal.typed.things import AnyMember, Line, Range, Record

#: Functions of a point and a line.
LineFunction = Literal["station", "offset", "direction", "distance_to"]
#: What becomes one number of many.
Folding = Literal["count", "sum", "min", "max"]
FOLDINGS: tuple[Folding, ...] = ("count", "sum", "min", "max")


class NumberNode(Typed):
    """A number with a dimension; `written` is the unit in which it stands in the spec, "" where it is in none of its own."""

    dimension: Dimension
    written: str


class Literally(NumberNode):
    """`1160 kg`: digits and unit as written (no unit: ""), and the value in SI."""

    text: str
    unit: str
    value: float
    span: Span


class Pi(NumberNode):
    """`pi`."""

    span: Span


class Parameter(NumberNode):
    """A `param` of a spec. record: of a field of a record of parameters, that record by the name that it has there; None for a number of its own."""

    symbol: Symbol
    record: Record | None
    span: Span


class Field(NumberNode):
    """`p.v`."""

    record: Record
    name: str
    span: Span


class Negative(NumberNode):
    """`-x`."""

    operand: Number
    span: Span


class Arithmetic(NumberNode):
    """`+ - * /`."""

    op: ArithmeticOp
    left: Number
    right: Number
    span: Span


class Power(NumberNode):
    """`x^2`: a product where `whole_exponent` says so, else the function `pow` of plain numbers."""

    base: Number
    exponent: Number
    span: Span


class Function(NumberNode):
    """`sqrt(x)`, `min(a, b, c)`: a function of numbers; of those that take pairs, there may be more arguments."""

    name: FunctionName
    arguments: tuple[Number, ...]
    span: Span


class Choice(NumberNode):
    """`if c then a else b`."""

    condition: Formula
    then: Number
    otherwise: Number
    span: Span


class NumberBranch(Typed):
    """`green, blue: 30 m/s`; `rest`: it is written `else`, and these are all members that are not named."""

    members: tuple[str, ...]
    rest: bool
    value: Number
    span: Span


class NumberCase(NumberNode):
    """`case race.flag { green: 30 m/s, else: 10 m/s }`: a number for each member, two branches at least."""

    subject: AnyMember
    branches: tuple[NumberBranch, ...]
    span: Span


class TableValue(NumberNode):
    """`ax_max(v)`: a table's value; it has one argument, or two."""

    symbol: Symbol
    arguments: tuple[Number, ...]
    span: Span


class OnLine(NumberNode):
    """`station(p, line)` and its like: what a line is at the place nearest to a point."""

    function: LineFunction
    point: Record
    line: Line
    span: Span


class StationGap(NumberNode):
    """`station_gap(line, a, b)`."""

    line: Line
    start: Number
    end: Number
    span: Span


class Kept(NumberNode):
    """`role(o).entry`: a number that a state machine remembers; no name: `time_in(role(o))`, how long it has been in its state."""

    machine: Machine
    name: str
    span: Span


class Folded(NumberNode):
    """`sum(E for o in objects where c)`: of all in a range one number; a count has no body.

    otherwise: what it is where there is nothing in the range; None: 0 of a sum or a count, and of others the range is never empty.
    """

    op: Folding
    range: Range
    where: Formula | None
    body: Number | None
    otherwise: Number | None
    span: Span


class CalledNumber(NumberNode):
    """A call of a `define`, and what that comes to with these arguments; infix: `a f b`. Without parentheses, there are no arguments."""

    symbol: Symbol
    arguments: tuple[Value, ...]
    infix: bool
    body: Number
    span: Span


class NamedNumber(NumberNode):
    """A number by the name of a `let`, or of a parameter of a definition (None: nothing is given for it). unit: of a parameter, as declared; "" of a `let`."""

    name: str
    value: Number | None
    unit: str
    span: Span


#: A number.
Number: TypeAlias = (
    Literally | Pi | Parameter | Field | Negative | Arithmetic | Power | Function | Choice | NumberCase | TableValue | OnLine | StationGap
    | Folded | Kept | CalledNumber | NamedNumber
)  # fmt: skip


def literal(number: Number) -> float | None:
    """The value in SI of a literal, of one with a minus, and of a name for one; None for any other number."""
    match number:
        case Literally():
            return number.value
        case Pi():
            return math.pi
        case Negative():
            operand = literal(number.operand)
            return None if operand is None else -operand
        case CalledNumber():
            return literal(number.body)
        case NamedNumber():
            return None if number.value is None else literal(number.value)
        case (
            Parameter()
            | Field()
            | Arithmetic()
            | Power()
            | Function()
            | Choice()
            | NumberCase()
            | TableValue()
        ):
            return None
        case OnLine() | StationGap() | Folded() | Kept():
            return None
        case _:
            assert_never(number)


def whole_exponent(exponent: Number) -> int | None:
    """The exponent of a power that is a product of as many factors, from 1 to 8, or 1 through one; None for any other."""
    value = literal(exponent)
    return int(value) if value is not None and value == int(value) and 1 <= abs(value) <= 8 else None
