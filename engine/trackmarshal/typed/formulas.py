"""Formulas as written."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from trackmarshal.ir.operators import Quantifier, TemporalOp, UntilOp
from trackmarshal.source import Span
from trackmarshal.typed.base import Changing, Comparing, Joining, Stepping, Typed
from trackmarshal.typed.numbers import Number
from trackmarshal.typed.symbol import Symbol
from trackmarshal.typed.things import AnyMember, Area, Line, Range, Record, Region, TimeAxis, Zone

if TYPE_CHECKING:
    from trackmarshal.typed import Value


class FormulaNode(Typed):
    """Something true, false or undefined."""


class Boolean(FormulaNode):
    """`true`, `false`."""

    value: bool
    span: Span


class Event(FormulaNode):
    """An `event` of the input."""

    symbol: Symbol
    span: Span


class BooleanField(FormulaNode):
    """`o.braking`."""

    record: Record
    name: str
    span: Span


class Comparison(FormulaNode):
    """Two numbers of one dimension compared."""

    op: Comparing
    left: Number
    right: Number
    span: Span


class Chained(FormulaNode):
    """`0 m <= a <= b`: neighbours compared, all in one direction; one operand more than operators."""

    operands: tuple[Number, ...]
    ops: tuple[Comparing, ...]
    span: Span


class Within(FormulaNode):
    """`x in [a, b]`, both ends included."""

    value: Number
    lower: Number
    upper: Number
    span: Span


class InZone(FormulaNode):
    """`p in zone pit_lane`."""

    point: Record
    zone: Zone
    span: Span


class InStretch(FormulaNode):
    """`p in stretch chicane`, `s in stretch(track, 4900 m, 120 m)`: along a line, ahead of one station and not ahead of the other.

    place: what is asked about, a point or a station. symbol: the declaration; None where line and ends stand here.
    """

    place: Record | Number
    symbol: Symbol | None
    line: Line
    start: Number
    end: Number
    span: Span


class Inside(FormulaNode):
    """`inside(footprint, area)`."""

    region: Region
    area: Area
    span: Span


class Meets(FormulaNode):
    """`footprint(o) meets l`: a footprint and a lane have a point in common."""

    region: Region
    area: Area
    span: Span


class ClearOf(FormulaNode):
    """`clear_of(footprint, other)`, of which the other one is at rest."""

    region: Region
    other: Region
    span: Span


class IsMember(FormulaNode):
    """`race.flag is yellow`, `a.lane is b.lane`."""

    left: AnyMember
    right: AnyMember
    span: Span


class FormulaBranch(Typed):
    """`green, blue: p`; `rest`: it is written `else`, and these are all members that are not named."""

    members: tuple[str, ...]
    rest: bool
    value: Formula
    span: Span


class FormulaCase(FormulaNode):
    """`case race.flag { green: p, else: q }`: a formula for each member, two branches at least."""

    subject: AnyMember
    branches: tuple[FormulaBranch, ...]
    span: Span


class Not(FormulaNode):
    """`not p`."""

    operand: Formula
    span: Span


class Connective(FormulaNode):
    """`p and q` and its like."""

    op: Joining
    left: Formula
    right: Formula
    span: Span


class Quantified(FormulaNode):
    """`for all p in plan where c: body` inside a formula; `by`: of all these, only the one of which this is least."""

    quantifier: Quantifier
    range: Range
    where: Formula | None
    by: Number | None
    body: Formula
    span: Span


class Window(Typed):
    """`[0 s, 0.5 s]`, with the bounds in s."""

    lower: Number
    upper: Number
    seconds: tuple[float, float]
    span: Span


class Temporal(FormulaNode):
    """always, eventually, historically, once; without a window to the axis's end."""

    op: TemporalOp
    axis: TimeAxis
    window: Window | None
    operand: Formula
    span: Span


class Until(FormulaNode):
    """`p until[a, b] q`, `p since[a, b] q`."""

    op: UntilOp
    axis: TimeAxis
    window: Window | None
    left: Formula
    right: Formula
    span: Span


class Step(FormulaNode):
    """`next p`, `previous p`; weak ones hold outside the axis."""

    op: Stepping
    weak: bool
    axis: TimeAxis
    operand: Formula
    span: Span


class Edge(FormulaNode):
    """`rising(p)`, `falling(p)`."""

    op: Changing
    axis: TimeAxis
    operand: Formula
    span: Span


class Count(Typed):
    """`count(p)`, `count(p, last: 10 s)`, `count(p, reset: q)`: in how many cycles of the run, or at how many samples of a timeline, p held up to now.

    window: only those; reset: only those since the last one in which this held, that one included. It is compared, and nothing else: a
    cycle of which nothing is known makes it a range of numbers.
    """

    axis: TimeAxis
    counted: Formula
    window: Window | None
    reset: Formula | None
    span: Span


class CountComparison(FormulaNode):
    """`count(p) <= 3`; turned: `3 >= count(p)`."""

    op: Comparing
    count: Count
    limit: Number
    turned: bool
    span: Span


class Keep(Typed):
    """`remember entry = ego.v`."""

    name: str
    value: Number
    span: Span


class Transition(Typed):
    """`becomes offence from neutral when p`; sources: all states that it leads from, in the order in which they are listed."""

    target: str
    sources: tuple[str, ...]
    guard: Formula
    kept: tuple[Keep, ...]
    span: Span


class Machine(Typed):
    """A `state`, as it is of the run or of an element of a set, and the transitions written out for it; bridges: how long a gap is that leaves it as it was [s]."""

    symbol: Symbol
    element: Record | None
    transitions: tuple[Transition, ...]
    bridges: float
    span: Span


class InState(FormulaNode):
    """`role(o) is offence`."""

    machine: Machine
    state: str
    span: Span


class CalledFormula(FormulaNode):
    """A call of a `predicate`, and what that comes to with these arguments; infix: `a f b`."""

    symbol: Symbol
    arguments: tuple[Value, ...]
    infix: bool
    body: Formula
    span: Span


class NamedFormula(FormulaNode):
    """A formula by the name that a `let` gave it."""

    name: str
    value: Formula
    span: Span


#: A formula.
Formula: TypeAlias = (
    Boolean | Event | BooleanField | Comparison | Chained | Within | InZone | InStretch | Inside | Meets | ClearOf | Not | Connective | Quantified
    | Temporal | Until | Step | Edge | CountComparison | InState | IsMember | FormulaCase | CalledFormula | NamedFormula
)  # fmt: skip
