"""Functions of places: footprints, what is swept, lines and areas, and what of a value is one of these."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, assert_never

from trackmarshal import typed
from trackmarshal.ir.operators import known
from trackmarshal.semantics.errors.expressions import WrongKind
from trackmarshal.semantics.expressions.dimensions import of_dimension
from trackmarshal.semantics.expressions.shapes import SHAPES, Kind, lacking, shaped
from trackmarshal.semantics.values import same_record, sample_of, spoken
from trackmarshal.source import Span
from trackmarshal.units import LENGTH, NUMBER, Dimension, over, parse_unit

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

#: What a sample needs for what is swept along a curve.
_CURVED: dict[str, Kind] = {**SHAPES["pose"], "kappa": over(NUMBER, LENGTH)}
#: Numbers that are read off a line at a point.
_ON_LINE: dict[typed.LineFunction, Dimension] = {
    "station": LENGTH,
    "offset": LENGTH,
    "direction": NUMBER,
    "distance_to": LENGTH,
}
#: Ways of a sample from the one before it.
_SWEPT: tuple[Literal["swept_footprint", "swept_hull"], ...] = ("swept_footprint", "swept_hull")


def geometric(
    x: Expressions, function: str, values: Sequence[typed.Value], spans: Sequence[Span], span: Span
) -> typed.Value:
    """What a function of places comes to; spans: where its arguments stand."""
    if function == "footprint" and len(values) == 1:
        return typed.Footprint(shaped(x, values[0], "body", spans[0]), span)
    if function == "footprint":
        pose = shaped(x, values[0], "pose", spans[0])
        return typed.FootprintAt(pose, _length(x, values[1]), _length(x, values[2]), span)
    if function in _SWEPT:
        sample, way = values[0], known(function, _SWEPT)
        if not isinstance(sample, typed.RecordNode) or sample_of(sample) is None:
            x.fail(WrongKind(spans[0], "a sample of a trajectory", spoken(sample)))
        shaped(x, sample, "pose", spans[0])
        if way == "swept_footprint":
            _check_curved(x, sample, spans[0])
        return typed.SweptSample(way, sample, _length(x, values[1]), _length(x, values[2]), span)
    if function == "swept":
        start, end = shaped(x, values[0], "pose", spans[0]), shaped(x, values[1], "pose", spans[1])
        return typed.Swept(start, end, _length(x, values[2]), _length(x, values[3]), span)
    if function == "inside":
        region = _region(x, values[0], spans[0])
        return typed.Inside(region, area(x, values[1], spans[1]), span)
    if function == "meets":
        region, lane = _region(x, values[0], spans[0]), values[1]
        if not isinstance(lane, typed.RecordNode) or not is_lane(lane):
            hint = "bind one first: `exists l in lanes: footprint(o) meets l`"
            x.fail(WrongKind(spans[1], "a lane", spoken(lane), hint))
        return typed.Meets(region, typed.Lane(lane, spans[1]), span)
    if function == "clear_of":
        region, other = _region(x, values[0], spans[0]), _region(x, values[1], spans[1])
        if not _at_rest(other):
            x.fail(WrongKind(spans[1], "a footprint at rest", "a swept footprint", "swap the two sides"))
        return typed.ClearOf(region, other, span)
    if function in _ON_LINE:
        point, called = shaped(x, values[0], "point", spans[0]), known(function, _ON_LINE)
        return typed.OnLine(_ON_LINE[called], "", called, point, line(x, values[1], spans[1]), span)
    if function == "station_gap":
        first, second = (_length(x, v) for v in values[1:])
        return typed.StationGap(LENGTH, "", line(x, values[0], spans[0]), first, second, span)
    if function == "centre":
        of = area(x, values[0], spans[0])
        if not _is_corridor(of):
            x.fail(WrongKind(spans[0], "a corridor", "a zone"))
        return typed.CalledLine("centre", typed.Centre(of, spans[0]), span)
    if function == "path":
        return typed.CalledLine("path", line(x, values[0], spans[0]), span)
    raise AssertionError(f"unknown function {function}")


def line(x: Expressions, value: typed.Value, span: Span) -> typed.Line:
    """The polyline that a value is, or has: a line, the path of a trajectory, the centre line of a corridor."""
    if isinstance(value, typed.LineNode):
        return value
    if isinstance(value, typed.SignalNode) and value.signal.kind == "trajectory" and not value.signal.many:
        for column in SHAPES["point"]:
            field = value.signal.field(column)
            if field is None or field.kind != "number" or parse_unit(field.unit)[2] != LENGTH:
                said, hint = spoken(value), f"declare its column `{column}: m`"
                x.fail(WrongKind(span, "a trajectory with a path", said, hint))
        return typed.Path(value, span)
    if isinstance(value, typed.SignalNode) and value.signal.kind == "corridor":
        return typed.Centre(typed.Corridor(value, span), span)
    if isinstance(value, typed.AreaNode) and _is_corridor(value):
        return typed.Centre(value, span)
    if isinstance(value, typed.RecordNode) and is_lane(value):
        return typed.Centre(typed.Lane(value, span), span)
    between = "the distance between two points is `distance(a, b)`, with `use prelude.frames`"
    hint = between if isinstance(value, typed.RecordNode) else ""
    x.fail(WrongKind(span, "a line, a trajectory or a corridor", spoken(value), hint))


def area(x: Expressions, value: typed.Value, span: Span) -> typed.Area:
    """The area that a value is: a zone, a corridor, a lane."""
    if isinstance(value, typed.AreaNode):
        return value
    if isinstance(value, typed.SignalNode) and value.signal.kind == "corridor":
        return typed.Corridor(value, span)
    if isinstance(value, typed.RecordNode) and is_lane(value):
        return typed.Lane(value, span)
    x.fail(WrongKind(span, "a zone or a corridor", spoken(value)))


def is_lane(record: typed.Record) -> bool:
    """Whether a record is an element of a set of lanes, with its borders: not what a definition asks for by a shape."""
    while isinstance(record, typed.NamedRecord) and record.value is not None and not record.kind:
        record = record.value
    return isinstance(record, typed.Variable) and record.signal.kind == "lane"


def _is_corridor(area: typed.Area) -> bool:
    """Whether an area is a corridor, as parameters always are."""
    while isinstance(area, typed.NamedArea) and area.value is not None:
        area = area.value
    return not isinstance(area, typed.Zone)


def _region(x: Expressions, value: typed.Value, span: Span) -> typed.Region:
    if not isinstance(value, typed.RegionNode):
        hint = "write footprint(...) or swept_footprint(...)"
        x.fail(WrongKind(span, "a footprint", spoken(value), hint))
    return value


def _at_rest(region: typed.Region) -> bool:
    """Whether a footprint is that of something that stands."""
    match region:
        case typed.Footprint() | typed.FootprintAt():
            return True
        case typed.Swept():
            return same_record(region.start, region.end)
        case typed.SweptSample():
            return False
        case typed.NamedRegion():
            return _at_rest(region.value)
        case _:
            assert_never(region)


def _check_curved(x: Expressions, sample: typed.Record, span: Span) -> None:
    """Refuse a sample without a curvature: nothing says how the way goes from one to the next."""
    if sample.shape.get("kappa") != _CURVED["kappa"]:
        hint = (
            f"{lacking(sample, _CURVED)}, or write swept_hull(...), which goes straight from sample to sample"
        )
        wanted = f"something with {', '.join(_CURVED)}"
        x.fail(WrongKind(span, wanted, spoken(sample), hint))


def _length(x: Expressions, value: typed.Value) -> typed.Number:
    return of_dimension(x, value, LENGTH, "this argument")
