"""Records, lines, areas and footprints to what numbers of the core are read off."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, assert_never

from trackmarshal import typed
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.interning import Interner
from trackmarshal.node import Node
from trackmarshal.source import Span


class Swept(Node):
    """What a box sweeps from one pose to another; `bend`: the curvatures at both, where it follows a curve."""

    start: ir.Pose
    end: ir.Pose
    length: ir.Num
    width: ir.Num
    bend: tuple[ir.Num, ...]


class Things:
    """Lowers everything but numbers and formulas; `number` lowers the numbers in them."""

    def __init__(self, interner: Interner) -> None:
        self.make = interner.make

    def axis(self, range_: typed.Range) -> ir.Axis:
        """What a range's variables take their values from."""
        kind: Literal["samples", "elements"] = "samples" if range_.signal.sequence else "elements"
        signal = range_.signal
        capacity = signal.capacity if signal.forget else None
        return self.make(ir.Axis, signal.name, kind, len(range_.names), range_.depth, signal.forget, capacity)

    def element(self, record: typed.Record) -> ir.Axis:
        """The axis of the variable that a record is, whatever its name is here."""
        while isinstance(record, typed.NamedRecord) and record.value is not None:
            record = record.value
        assert isinstance(record, typed.Variable)
        return self.axis(record.range)

    # Records --------------------------------------------------------------------------------------------------

    def column(self, record: typed.Record, name: str, back: int = 0) -> ir.Num:
        """A number field of a record; `back`: of the sample that is so many before it."""
        match record:
            case typed.State():
                return self.make(ir.Scalar, record.signal.name, name)
            case typed.ParameterRecord():
                return self.make(ir.Param, f"{record.symbol.qualified}.{name}")
            case typed.Sample():
                return self.make(ir.Sample, record.signal.name, name, record.index)
            case typed.Variable():
                return self.make(ir.Column, self.axis(record.range), name, record.offset - back)
            case typed.NamedRecord():
                if record.value is None:
                    raise nothing_given(record.name)
                return self.column(record.value, name, back)
            case _:
                assert_never(record)

    def member(self, member: typed.AnyMember) -> ir.Num:
        """The place of a member in its enumeration."""
        match member:
            case typed.Member():
                return self.make(ir.Const, float(member.enumeration.members.index(member.name)))
            case typed.MemberField():
                return self.column(member.record, member.name)
            case typed.NamedMember():
                return self.member(member.value)
            case _:
                assert_never(member)

    def flag(self, record: typed.Record, name: str, at: Span) -> ir.Flag:
        """A Boolean field of a record."""
        match record:
            case typed.State():
                return self.make(ir.Flag, record.signal.name, name, None, 0, at)
            case typed.ParameterRecord():
                raise AssertionError("parameters are numbers")
            case typed.Sample():
                return self.make(ir.Flag, record.signal.name, name, None, record.index, at)
            case typed.Variable():
                return self.make(
                    ir.Flag, record.signal.name, name, self.axis(record.range), record.offset, at
                )
            case typed.NamedRecord():
                if record.value is None:
                    raise nothing_given(record.name)
                return self.flag(record.value, name, at)
            case _:
                assert_never(record)

    def point(self, record: typed.Record) -> tuple[ir.Num, ir.Num]:
        return self.column(record, "x"), self.column(record, "y")

    def pose(self, record: typed.Record, back: int = 0) -> ir.Pose:
        return ir.Pose(*(self.column(record, name, back) for name in ir.Pose._fields))

    # Lines and areas --------------------------------------------------------------------------------------------

    def line(self, line: typed.Line) -> ir.Line:
        match line:
            case typed.PlacedLine():
                return self.make(ir.Line, "place", line.symbol.qualified, "")
            case typed.SignalLine():
                return self.make(ir.Line, "signal", line.signal.name, "")
            case typed.Border():
                return self.make(ir.Line, "signal", line.of.signal.name, line.field)
            case typed.LaneSide():
                raise AssertionError("a line of a lane is none of the cycle's")
            case typed.Path():
                return self.make(ir.Line, "path", line.of.signal.name, "")
            case typed.Centre():
                return self.make(ir.Line, "centre", self.area(line.of).name, "")
            case typed.CalledLine():
                return self.line(line.line)
            case typed.NamedLine():
                if line.value is None:
                    raise nothing_given(line.name)
                return self.line(line.value)
            case _:
                assert_never(line)

    def lane(self, place: typed.Line | typed.Area) -> tuple[ir.LaneSide, str, ir.Num] | None:
        """Which line of which lane something is, or the lane itself: its side, the set, and its place in it; None for what is no lane's."""
        match place:
            case typed.LaneSide():
                side: ir.LaneSide = "left" if place.field == "left" else "right"
                return (side, *self._element(place.of))
            case typed.Lane():
                return ("centre", *self._element(place.of))
            case typed.Centre():
                return self.lane(place.of)
            case typed.CalledLine():
                return self.lane(place.line)
            case typed.NamedLine() | typed.NamedArea():
                return None if place.value is None else self.lane(place.value)
            case (
                typed.PlacedLine()
                | typed.SignalLine()
                | typed.Border()
                | typed.Path()
                | typed.Zone()
                | typed.Corridor()
            ):
                return None
            case _:
                assert_never(place)

    def _element(self, record: typed.Record) -> tuple[str, ir.Num]:
        axis = self.element(record)
        return axis.signal, self.make(ir.Ordinal, axis)

    def area(self, area: typed.Area) -> ir.Area:
        match area:
            case typed.Zone():
                return self.make(ir.Area, "zone", area.symbol.qualified)
            case typed.Corridor():
                return self.make(ir.Area, "corridor", area.of.signal.name)
            case typed.Lane():
                raise AssertionError("a lane is no area of the cycle's")
            case typed.NamedArea():
                if area.value is None:
                    raise nothing_given(area.name)
                return self.area(area.value)
            case _:
                assert_never(area)

    # Footprints -------------------------------------------------------------------------------------------------

    def region(self, region: typed.Region, number: Callable[[typed.Number], ir.Num]) -> Swept:
        """What a footprint covers; it stands still where both poses are one."""
        match region:
            case typed.Footprint():
                pose = self.pose(region.body)
                length, width = self.column(region.body, "length"), self.column(region.body, "width")
                return Swept(pose, pose, length, width, ())
            case typed.FootprintAt():
                pose = self.pose(region.pose)
                return Swept(pose, pose, number(region.length), number(region.width), ())
            case typed.SweptSample():
                start, end = self.pose(region.sample, 1), self.pose(region.sample)
                curved = region.function == "swept_footprint"
                bend = tuple(self.column(region.sample, "kappa", back) for back in (1, 0)) if curved else ()
                return Swept(start, end, number(region.length), number(region.width), bend)
            case typed.Swept():
                start, end = self.pose(region.start), self.pose(region.end)
                return Swept(start, end, number(region.length), number(region.width), ())
            case typed.NamedRegion():
                return self.region(region.value, number)
            case _:
                assert_never(region)


def nothing_given(parameter: str) -> AssertionError:
    """What is wrong with a definition that is lowered by itself, and not where it is called."""
    return AssertionError(f"nothing is given for `{parameter}`")
