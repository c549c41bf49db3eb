"""What is neither number nor formula: ranges, signals, records, lines, areas and footprints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal, TypeAlias

from trackmarshal.ir.spec import Enumeration, SignalType
from trackmarshal.source import Span
from trackmarshal.typed.base import Typed
from trackmarshal.typed.symbol import Symbol
from trackmarshal.units import Dimension

if TYPE_CHECKING:
    from trackmarshal.typed.numbers import Number


#: What can be read of a record: names of fields with the dimensions of numbers, enumerations, and None for Booleans.
Shape: TypeAlias = Mapping[str, Dimension | Enumeration | None]


class Range(Typed):
    """What variables range over: the samples of a timeline, or the elements of a set.

    names: those of consecutive samples where there are several. depth: how many ranges stand around it, 0 for none.
    """

    domain: WholeSignal
    names: tuple[str, ...]
    depth: int
    span: Span

    @property
    def signal(self) -> SignalType:
        """What the domain is."""
        return self.domain.signal


class TheRun(Typed):
    """The cycles of the run: what temporal operators range over in a rule without a timeline."""


#: There is one.
THE_RUN = TheRun()
#: What a temporal operator ranges over: a rule's timeline, or the run.
TimeAxis: TypeAlias = Range | TheRun


# Signals ------------------------------------------------------------------------------------------------------


class SignalNode(Typed):
    """A whole signal: a timeline, a set, a corridor."""

    signal: SignalType


class Signal(SignalNode):
    """A signal by its own name."""

    span: Span


class NamedSignal(SignalNode):
    """A signal by the name that a `let` gave it."""

    name: str
    value: WholeSignal
    span: Span


# Records ------------------------------------------------------------------------------------------------------


class RecordNode(Typed):
    """Something with fields. shape: those that can be read, with the dimension of a number, the enumeration of a
    member, and None for a Boolean.

    signal: the one whose record it is; None for a parameter of a definition that nothing is given for.
    """

    shape: Shape
    signal: SignalType | None


class State(RecordNode):
    """A single record: `ego`."""

    signal: SignalType
    span: Span


class ParameterRecord(RecordNode):
    """A record of parameters: `limits`. Its fields are parameters of their own."""

    symbol: Symbol
    span: Span


class Sample(RecordNode):
    """`plan.first` (index 0) or `plan.last` (-1)."""

    signal: SignalType
    of: WholeSignal
    index: Literal[0, -1]
    span: Span


class Variable(RecordNode):
    """What a quantifier or `along` binds; offset: of several that are consecutive, how many come before it."""

    signal: SignalType
    name: str
    range: Range
    offset: int
    span: Span


class NamedRecord(RecordNode):
    """A record by the name of a `let`, or of a parameter of a definition, of which `kind` is the declared shape ("": a `let`).

    value: None for a parameter that nothing is given for.
    """

    name: str
    value: Record | None
    kind: str
    span: Span


# Members of enumerations --------------------------------------------------------------------------------------


class MemberNode(Typed):
    """A member of an enumeration."""

    enumeration: Enumeration


class Member(MemberNode):
    """`yellow`, where a member of an enumeration is asked for."""

    name: str
    span: Span


class MemberField(MemberNode):
    """`race.flag`."""

    record: Record
    name: str
    span: Span


class NamedMember(MemberNode):
    """A member by the name that a `let` gave it."""

    name: str
    value: AnyMember
    span: Span


# Lines --------------------------------------------------------------------------------------------------------


class LineNode(Typed):
    """A polyline."""


class PlacedLine(LineNode):
    """A `line` of a spec."""

    symbol: Symbol
    span: Span


class SignalLine(LineNode):
    """A signal that is a polyline."""

    signal: SignalType
    span: Span


class Border(LineNode):
    """`track.left`: a polyline of a signal."""

    of: WholeSignal
    field: str
    span: Span


class LaneSide(LineNode):
    """`l.left`: a border of a lane, which is an element of a set of lanes."""

    of: Record
    field: str
    span: Span


class Path(LineNode):
    """The path of a trajectory that stands where a line is wanted."""

    of: WholeSignal
    span: Span


class Centre(LineNode):
    """The centre line of a corridor that stands where a line is wanted."""

    of: Area
    span: Span


class CalledLine(LineNode):
    """`path(plan)`, `centre(track)`: a line asked for by a function's name."""

    function: Literal["path", "centre"]
    line: Line
    span: Span


class NamedLine(LineNode):
    """A line by the name of a `let` or of a parameter (None: nothing is given for it)."""

    name: str
    value: Line | None
    span: Span


# Areas --------------------------------------------------------------------------------------------------------


class AreaNode(Typed):
    """A zone or a corridor."""


class Zone(AreaNode):
    """A `zone` of a spec."""

    symbol: Symbol
    span: Span


class Corridor(AreaNode):
    """What lies between the borders of a corridor of the input."""

    of: WholeSignal
    span: Span


class Lane(AreaNode):
    """What lies between the borders of a lane, which is an element of a set of lanes."""

    of: Record
    span: Span


class NamedArea(AreaNode):
    """An area by the name of a `let` or of a parameter (None: nothing is given for it)."""

    name: str
    value: Area | None
    span: Span


# Footprints ---------------------------------------------------------------------------------------------------


class RegionNode(Typed):
    """What a box of a length and a width covers, at rest or on its way from one pose to another."""


class Footprint(RegionNode):
    """`footprint(o)`: a body has its length and width itself."""

    body: Record
    span: Span


class FootprintAt(RegionNode):
    """`footprint(pose, length, width)`."""

    pose: Record
    length: Number
    width: Number
    span: Span


class SweptSample(RegionNode):
    """`swept_footprint(p, length, width)` and `swept_hull(..)`: from the sample before to this one, along a curve or straight."""

    function: Literal["swept_footprint", "swept_hull"]
    sample: Record
    length: Number
    width: Number
    span: Span


class Swept(RegionNode):
    """`swept(a, b, length, width)`: straight from one pose to another."""

    start: Record
    end: Record
    length: Number
    width: Number
    span: Span


class NamedRegion(RegionNode):
    """A footprint by the name that a `let` gave it."""

    name: str
    value: Region
    span: Span


#: A whole signal.
WholeSignal: TypeAlias = Signal | NamedSignal
#: Something with fields.
Record: TypeAlias = State | ParameterRecord | Sample | Variable | NamedRecord
#: A member of an enumeration.
AnyMember: TypeAlias = Member | MemberField | NamedMember
#: A polyline.
Line: TypeAlias = PlacedLine | SignalLine | Border | LaneSide | Path | Centre | CalledLine | NamedLine
#: A zone or a corridor.
Area: TypeAlias = Zone | Corridor | Lane | NamedArea
#: A footprint.
Region: TypeAlias = Footprint | FootprintAt | SweptSample | Swept | NamedRegion
