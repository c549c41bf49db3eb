"""Calls: built-in functions, tables, geometry, and definitions written out where they are used."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, assert_never

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import EDGES, FUNCTIONS, Dimensions, known
from trackmarshal.semantics.errors import (
    Recursive,
    TooLarge,
    UnknownReference,
    WrongArity,
    WrongDimension,
    WrongKind,
)
from trackmarshal.semantics.scope import Symbol, spoken
from trackmarshal.semantics.shapes import SHAPES
from trackmarshal.semantics.values import (
    AreaValue,
    FormulaValue,
    LineValue,
    NumberValue,
    Poison,
    RecordValue,
    RegionValue,
    SignalValue,
    Value,
    common,
    own_unit,
    written_unit,
)  # fmt: skip
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import LENGTH, NUMBER, SPEED, Dimension, name, over, parse_unit, power, quantity, show

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions import Context, Expressions

#: Built-in functions that are not plain functions of numbers: how many arguments, and which, for messages.
_SPECIAL: dict[str, tuple[tuple[int, ...], str]] = {
    "rising": ((1,), "1 argument (a formula)"), "falling": ((1,), "1 argument (a formula)"),
    "footprint": ((1, 3), "1 argument (a body) or 3 (a pose, length, width)"),
    "swept_footprint": ((3,), "3 arguments (a sample of a trajectory, length, width)"),
    "swept_hull": ((3,), "3 arguments (a sample of a trajectory, length, width)"),
    "swept": ((4,), "4 arguments (two poses, length, width)"), "inside": ((2,), "2 arguments (a footprint, an area)"),
    "clear_of": ((2,), "2 arguments (two footprints)"), "station": ((2,), "2 arguments (a point, a line)"),
    "offset": ((2,), "2 arguments (a point, a line)"), "direction": ((2,), "2 arguments (a point, a line)"),
    "distance_to": ((2,), "2 arguments (a point, a line)"), "station_gap": ((3,), "3 arguments (a line, two stations)"),
    "centre": ((1,), "1 argument (a corridor)"), "path": ((1,), "1 argument (a trajectory)"),
}  # fmt: skip
#: How many definitions one declaration may be made of, each counted where it is written out.
MOST_EXPANSIONS = 20_000
#: How many definitions may be inside each other.
DEEPEST = 50
#: What a sample needs for what is swept along a curve.
_CURVED: dict[str, Dimension | None] = {**SHAPES["pose"], "kappa": over(NUMBER, LENGTH)}
#: Numbers that are read off a line at a point.
_ON_LINE: dict[str, tuple[Callable[[ir.Line, ir.Num, ir.Num], ir.Num], Dimension]] = {
    "station": (ir.Station, LENGTH),
    "offset": (ir.Offset, LENGTH),
    "direction": (ir.Direction, NUMBER),
    "distance_to": (ir.Distance, LENGTH),
}


def built_in_names() -> set[str]:
    """Every function that needs no declaration."""
    return {*FUNCTIONS, *_SPECIAL}


def call(
    self: Expressions,
    function: str,
    args: tuple[ast.Expr, ...],
    names: tuple[str, ...],
    span: Span,
    ctx: Context,
) -> Value:
    """A call of anything by its name."""
    if any(names):
        self.fail(
            UnknownReference(
                span, "named arguments are for the builders of tests", "write the arguments in order"
            )
        )
    if function not in ctx.scope.names():
        if function in FUNCTIONS:
            return _numeric(self, function, args, span, ctx)
        if function in _SPECIAL:
            return _special(self, function, args, span, ctx)
    at = _name_of_call(function, args, span)
    found, item = _declared(self, function, args, at, ctx)
    wanted = 1 if isinstance(item, ast.Table) else len(item.parameters)
    fits = len(args) == wanted
    if not fits:
        comma, declared = decimal_comma(*(arg.__dict__["span"] for arg in args)), item.span.head
        self.found.append(WrongArity(at, function, _count(wanted), _given(len(args)), declared, comma))
    values = self.all(*(lambda arg=arg: self.value(arg, ctx) for arg in args))
    if not fits:
        raise Poison
    if isinstance(item, ast.Table):
        return _table(self, found, item, values, span)
    return expand(self, found, item, values, span, ctx)


def _declared(
    self: Expressions, function: str, args: tuple[ast.Expr, ...], at: Span, ctx: Context
) -> tuple[Symbol, ast.Table | ast.Define]:
    """What a call calls; where that is nothing, the errors of its arguments are reported all the same."""
    try:
        found = self.look_up(function, at, "function", built_in_names(), ctx)
        if isinstance(found.item, (ast.Table, ast.Define)):
            return found, found.item
        self.fail(WrongKind(at, "a function", f"the {spoken(found.item)} `{function}`"))
    except Poison:
        self.all(*(lambda arg=arg: self.value(arg, ctx) for arg in args))
        raise


def _name_of_call(function: str, args: tuple[ast.Expr, ...], span: Span) -> Span:
    """Where the name stands in `f(a, b)` and in `a f b`."""
    start = span.start
    if args and args[0].__dict__["span"].start == start:
        start = args[0].__dict__["span"].end
    match = re.compile(r"[^\W\d]\w*").search(span.file.text, start, span.end)
    return span if match is None else Span(span.file, *match.span())


def expand(
    self: Expressions, symbol: Symbol, item: ast.Define, args: list[Value], span: Span, ctx: Context
) -> Value:
    """A definition written out with its arguments in place of its parameters."""
    if symbol.qualified in ctx.stack:
        cycle = " -> ".join(
            q.rpartition(".")[2] for q in (*ctx.stack[ctx.stack.index(symbol.qualified) :], symbol.qualified)
        )
        self.fail(Recursive(span, item.name, cycle))
    if symbol.qualified in self.failed:
        raise Poison
    if len(ctx.stack) >= DEEPEST:
        self.fail(TooLarge(ctx.site or span, f"nested more than {DEEPEST} definitions deep"))
    self.expansions += 1
    if self.expansions > MOST_EXPANSIONS:
        self.fail(TooLarge(ctx.site or span, f"made of more than {MOST_EXPANSIONS} definitions"))
    bound = self.all(*(lambda p=p, v=v: _argument(self, p, v) for p, v in zip(item.parameters, args)))
    local = {p.name: value for p, value in zip(item.parameters, bound)}
    scope = self.scopes[symbol.module]
    inner = type(ctx)(scope, local, ctx.level, ctx.timeline, ctx.site or span, (*ctx.stack, symbol.qualified))
    if item.keyword == "predicate":
        return FormulaValue(self.formula(item.body, inner).node, span)
    value = self.number(item.body, inner)
    if item.result is not None:
        wanted = parse_unit(item.result)[2]
        if value.dimension != wanted:
            what = f"the value of `{item.name}`"
            self.fail(
                WrongDimension(value.span, item.span.head, what, quantity(wanted), quantity(value.dimension))
            )
        self.advise(self.advice.in_unit(value, item.result, f"the value of `{item.name}`", item.span.head))
    return NumberValue(value.node, value.dimension, span, written=value.written or own_unit(item.result))


def check_definition(self: Expressions, symbol: Symbol, item: ast.Define, ctx: Context) -> None:
    """Check the body of a definition that may never be called, with placeholders for its arguments."""
    args = [_placeholder(self, p) for p in item.parameters]
    expand(self, symbol, item, args, item.span, ctx)


def _placeholder(self: Expressions, parameter: ast.Parameter) -> Value:
    kind, span = parameter.type, parameter.span
    if kind in SHAPES:
        return RecordValue(
            f"`{parameter.name}`, a {kind}",
            None,
            SHAPES[kind],
            lambda f, at: self.make(ir.Const, 0.0),
            None,
            span,
        )
    if kind in ("trajectory", "polyline"):
        return LineValue(self.make(ir.Line, "place", "", ""), span)
    if kind == "corridor":
        return AreaValue(self.make(ir.Area, "corridor", ""), span)
    return NumberValue(self.make(ir.Param, f"{parameter.name}"), parse_unit(kind)[2], span)


def _argument(self: Expressions, parameter: ast.Parameter, value: Value) -> Value:
    """The argument as the body sees it: of the declared dimension, or through the declared shape."""
    kind, span = parameter.type, value.__dict__["span"]
    if kind in SHAPES:
        wanted_fields = f"something with {', '.join(SHAPES[kind])} for `{parameter.name}: {kind}`"
        if not isinstance(value, RecordValue):
            self.fail(WrongKind(span, wanted_fields, value.spoken))
        lacking = _lacking(value, SHAPES[kind])
        if lacking:
            self.fail(WrongKind(span, wanted_fields, value.spoken, lacking))
        return RecordValue(value.what, value.signal, SHAPES[kind], value.read, value.previous, span)
    if kind in ("trajectory", "polyline"):
        return LineValue(line(self, value, span), span)
    if kind == "corridor":
        return AreaValue(_area(self, value, span), span)
    if not isinstance(value, NumberValue):
        self.fail(WrongKind(span, f"a number for `{parameter.name}`", value.spoken))
    wanted = parse_unit(kind)[2]
    if value.dimension != wanted:
        what = f"argument `{parameter.name}`"
        self.fail(
            WrongDimension(
                span,
                parameter.span,
                what,
                quantity(wanted),
                quantity(value.dimension),
                unit_hint(value, wanted),
            )
        )
    self.advise(self.advice.in_unit(value, kind, f"argument `{parameter.name}`", parameter.span))
    return value


def _numeric(self: Expressions, function: str, args: tuple[ast.Expr, ...], span: Span, ctx: Context) -> Value:
    called = known(function, FUNCTIONS)
    wanted, dimensions, _, more = FUNCTIONS[called]
    fits = len(args) == wanted or (more and len(args) > wanted)
    if not fits:
        least = "at least " if more else ""
        self.found.append(
            WrongArity(
                _name_of_call(function, args, span),
                function,
                least + _count(wanted),
                _given(len(args)),
                None,
                decimal_comma(*(arg.__dict__["span"] for arg in args)),
            )
        )
    values = self.all(*(lambda arg=arg: self.number(arg, ctx) for arg in args))
    if not fits:
        raise Poison
    numbers = [v for v in values if isinstance(v, NumberValue)]
    dimension = _dimension(self, function, dimensions, numbers)
    if function in ("sin", "cos", "tan"):
        self.advise(self.advice.in_unit(numbers[0], "rad", "the angle", None))
    kept = common(*numbers) if dimensions is Dimensions.KEPT else ""
    if not more:
        made = self.make(ir.Func, called, tuple(v.node for v in numbers))
        return NumberValue(made, dimension, span, written=kept)
    node = numbers[0].node
    for other in numbers[1:]:
        node = self.make(ir.Func, called, (node, other.node))
    return NumberValue(node, dimension, span, written=kept)


def _dimension(
    self: Expressions, function: str, dimensions: Dimensions, numbers: list[NumberValue]
) -> Dimension:
    """The dimension of a function's value; fails for arguments of wrong ones."""
    first = numbers[0]
    match dimensions:
        case Dimensions.KEPT | Dimensions.DROPPED:
            for other in numbers[1:]:
                self.same(f"take the {function} of", first, other)
            return first.dimension if dimensions is Dimensions.KEPT else NUMBER
        case Dimensions.ROOT:
            return power(first.dimension, Fraction(1, 2))
        case Dimensions.PLAIN:
            for value in numbers:
                if value.dimension != NUMBER:
                    what, found = f"the argument of `{function}`", quantity(value.dimension)
                    hint = "divide it by a quantity of its own dimension"
                    self.fail(WrongDimension(value.span, None, what, "a plain number", found, hint))
            return NUMBER
        case _:
            assert_never(dimensions)


def _table(self: Expressions, symbol: Symbol, item: ast.Table, values: list[Value], span: Span) -> Value:
    value = values[0]
    argument, result = parse_unit(item.unit)[2], parse_unit(item.result)[2]
    if not isinstance(value, NumberValue) or value.dimension != argument:
        what = f"the argument of `{item.name}`"
        hint = unit_hint(value, argument) if isinstance(value, NumberValue) else ""
        declared = item.span.head.word(item.unit)
        self.fail(
            WrongDimension(value.__dict__["span"], declared, what, quantity(argument), _spoken(value), hint)
        )
    unit = written_unit((row for _, row in item.rows), item.result)
    return NumberValue(self.make(ir.Lookup, symbol.qualified, value.node), result, span, written=unit)


def _special(self: Expressions, function: str, args: tuple[ast.Expr, ...], span: Span, ctx: Context) -> Value:
    counts, wanted = _SPECIAL[function]
    fits = len(args) in counts
    if not fits:
        at = _name_of_call(function, args, span)
        comma = decimal_comma(*(arg.__dict__["span"] for arg in args))
        self.found.append(WrongArity(at, function, wanted, _given(len(args)), None, comma))
    if function in EDGES:
        operands = self.all(*(lambda arg=arg: self.formula(arg, ctx) for arg in args))
        if not fits:
            raise Poison
        assert isinstance(operands[0], FormulaValue)
        if ctx.timeline is None:
            return _edge_over_run(self, function, operands[0].node, span, ctx)
        return FormulaValue(self.make(ir.Edge, known(function, EDGES), ctx.timeline, operands[0].node), span)
    values = self.all(*(lambda arg=arg: self.value(arg, ctx) for arg in args))
    if not fits:
        raise Poison
    spans: list[Span] = [arg.__dict__["span"] for arg in args]
    if function == "footprint":
        return _footprint(self, values, spans, span, ctx)
    if function in ("swept_footprint", "swept_hull"):
        sample = values[0]
        if not isinstance(sample, RecordValue) or sample.previous is None:
            self.fail(WrongKind(spans[0], "a sample of a trajectory", sample.spoken))
        before = RecordValue(sample.what, sample.signal, sample.shape, sample.previous, None, sample.span)
        start, end = _pose(self, before, spans[0], ctx), _pose(self, sample, spans[0], ctx)
        curved = function == "swept_footprint"
        bend = tuple(_curvature(self, at, spans[0], ctx) for at in (before, sample)) if curved else ()
        return RegionValue(start, end, _length(self, values[1]), _length(self, values[2]), bend, span)
    if function == "swept":
        start, end = _pose(self, values[0], spans[0], ctx), _pose(self, values[1], spans[1], ctx)
        return RegionValue(start, end, _length(self, values[2]), _length(self, values[3]), (), span)
    if function == "inside":
        hull = _region(self, values[0], spans[0])
        inside = self.make(
            ir.SweptInside,
            start=hull.start, end=hull.end, length=hull.length, width=hull.width, bend=hull.bend,
            area=_area(self, values[1], spans[1]), span=ctx.site or span,
        )  # fmt: skip
        return FormulaValue(inside, span)
    if function == "clear_of":
        hull, box = _region(self, values[0], spans[0]), _region(self, values[1], spans[1])
        if box.start != box.end or box.bend:
            self.fail(WrongKind(spans[1], "a footprint at rest", "a swept footprint", "swap the two sides"))
        clear = self.make(
            ir.SweptClear,
            start=hull.start, end=hull.end, length=hull.length, width=hull.width,
            box=box.start, box_length=box.length, box_width=box.width, bend=hull.bend, span=ctx.site or span,
        )  # fmt: skip
        return FormulaValue(clear, span)
    if function in _ON_LINE:
        x, y = fields(self, values[0], "point", spans[0], ctx)
        kind, dimension = _ON_LINE[function]
        return NumberValue(self.make(kind, line(self, values[1], spans[1]), x, y), dimension, span)
    if function == "station_gap":
        first, second = (_length(self, v) for v in values[1:])
        gap = self.make(ir.StationGap, line(self, values[0], spans[0]), first, second)
        return NumberValue(gap, LENGTH, span)
    if function == "centre":
        area = _area(self, values[0], spans[0])
        if area.kind != "corridor":
            self.fail(WrongKind(spans[0], "a corridor", "a zone"))
        return LineValue(self.make(ir.Line, "centre", area.name, ""), span)
    if function == "path":
        return LineValue(line(self, values[0], spans[0]), span)
    raise AssertionError(f"unknown function {function}")


def _edge_over_run(self: Expressions, function: str, now: ir.Formula, span: Span, ctx: Context) -> Value:
    """rising: now, and not in the cycle before, false before the run; falling: in the cycle before, true before the run, and not now."""
    falls = function == "falling"
    before = self.over_run("previous", (now,), None, None, falls, span, ctx).node
    parts = (before, self.make(ir.Not, now)) if falls else (self.make(ir.Not, before), now)
    return FormulaValue(self.make(ir.Connective, "and", *parts), span)


def fields(self: Expressions, value: Value, shape: str, span: Span, ctx: Context) -> tuple[ir.Num, ...]:
    """The numbers of a record that a shape names."""
    if not isinstance(value, RecordValue):
        self.fail(WrongKind(span, f"something with {', '.join(SHAPES[shape])}", value.spoken))
    nodes = []
    for field, dimension in SHAPES[shape].items():
        node = value.read(field, ctx.site or span) if value.shape.get(field, "missing") == dimension else None
        if not isinstance(node, ir.Num):
            hint = _lacking(value, SHAPES[shape])
            self.fail(WrongKind(span, f"something with {', '.join(SHAPES[shape])}", value.spoken, hint))
        nodes.append(node)
    return tuple(nodes)


def _lacking(value: RecordValue, shape: Mapping[str, Dimension | None]) -> str:
    """Why a record does not fit a shape; empty when it does."""
    for field, dimension in shape.items():
        wanted = dimension or NUMBER
        if field not in value.shape:
            similar = close_matches(field, [name for name in value.shape if name not in shape])
            unit = "rad" if field == "heading" else show(wanted)
            return f"it has no `{field}`" + (f"; {similar}" if similar else f": declare `{field}: {unit}`")
        if value.shape[field] != dimension:
            found = value.shape[field]
            return f"its `{field}` is {'a Boolean' if found is None else quantity(found)}, not {quantity(wanted)}"
    return ""


def line(self: Expressions, value: Value, span: Span) -> ir.Line:
    """The polyline that a value is, or has: a line, the path of a trajectory, the centre line of a corridor."""
    if isinstance(value, LineValue):
        return value.line
    if isinstance(value, SignalValue) and value.signal.kind == "trajectory" and not value.signal.many:
        for column in SHAPES["point"]:
            field = value.signal.field(column)
            if field is None or field.kind != "number" or parse_unit(field.unit)[2] != LENGTH:
                self.fail(
                    WrongKind(
                        span, "a trajectory with a path", value.spoken, f"declare its column `{column}: m`"
                    )
                )
        return self.make(ir.Line, "path", value.signal.name, "")
    if isinstance(value, AreaValue) and value.area.kind == "corridor":
        return self.make(ir.Line, "centre", value.area.name, "")
    if isinstance(value, SignalValue) and value.signal.kind == "corridor":
        return self.make(ir.Line, "centre", value.signal.name, "")
    self.fail(WrongKind(span, "a line, a trajectory or a corridor", value.spoken))


def _area(self: Expressions, value: Value, span: Span) -> ir.Area:
    if isinstance(value, AreaValue):
        return value.area
    if isinstance(value, SignalValue) and value.signal.kind == "corridor":
        return self.make(ir.Area, "corridor", value.signal.name)
    self.fail(WrongKind(span, "a zone or a corridor", value.spoken))


def _region(self: Expressions, value: Value, span: Span) -> RegionValue:
    if not isinstance(value, RegionValue):
        self.fail(
            WrongKind(span, "a footprint", value.spoken, "write footprint(...) or swept_footprint(...)")
        )
    return value


def _footprint(
    self: Expressions, values: list[Value], spans: list[Span], span: Span, ctx: Context
) -> RegionValue:
    if len(values) == 1:
        x, y, heading, length, width = fields(self, values[0], "body", spans[0], ctx)
        return RegionValue(ir.Pose(x, y, heading), ir.Pose(x, y, heading), length, width, (), span)
    pose = _pose(self, values[0], spans[0], ctx)
    return RegionValue(pose, pose, _length(self, values[1]), _length(self, values[2]), (), span)


def _pose(self: Expressions, value: Value, span: Span, ctx: Context) -> ir.Pose:
    return ir.Pose(*fields(self, value, "pose", span, ctx))


def _curvature(self: Expressions, value: RecordValue, span: Span, ctx: Context) -> ir.Num:
    """The curvature of a sample: without it, nothing says how the way goes from one to the next."""
    node = value.read("kappa", ctx.site or span) if value.shape.get("kappa") == _CURVED["kappa"] else None
    if not isinstance(node, ir.Num):
        hint = (
            f"{_lacking(value, _CURVED)}, or write swept_hull(...), which goes straight from sample to sample"
        )
        self.fail(WrongKind(span, f"something with {', '.join(_CURVED)}", value.spoken, hint))
    return node


def _length(self: Expressions, value: Value) -> ir.Num:
    if not isinstance(value, NumberValue) or value.dimension != LENGTH:
        hint = unit_hint(value, LENGTH) if isinstance(value, NumberValue) else ""
        self.fail(
            WrongDimension(
                value.__dict__["span"], None, "this argument", quantity(LENGTH), _spoken(value), hint
            )
        )
    return value.node


def _count(number: int) -> str:
    return "no arguments" if number == 0 else "1 argument" if number == 1 else f"{number} arguments"


def _given(number: int) -> str:
    return f"{number} given" if number else "none given"


_LITERAL = re.compile(r"([-−]?\s*[0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(\S*)")


def decimal_comma(*spans: Span) -> str:
    """What to write where two arguments look like one number with a decimal comma, `f(1,5 m)`; empty where none do."""
    for first, second in pairwise(spans):
        text = first.file.text
        if first.text.isdecimal() and text[first.end : second.start] == "," and second.text[:1].isdecimal():
            return f"numbers have a decimal point: `{first.text}.{second.text}`"
    return ""


def unit_hint(value: NumberValue, wanted: Dimension) -> str:
    """How a literal gets the dimension that is wanted; empty for what is no literal, or has no such unit."""
    literal, unit = _LITERAL.fullmatch(value.span.text.strip()), show(wanted)
    if literal is None or not isinstance(value.node, ir.Const) or "*" in unit or "(" in unit:
        return ""
    if wanted == NUMBER:
        return f"leave the unit out: `{literal[1]}`"
    if not literal[2]:
        return f"write the unit: `{literal[1]} {unit}`"
    if literal[2] == "km" and wanted == SPEED:
        unit = "km/h"
    return f"write a unit of {name(wanted)}, such as `{literal[1]} {unit}`"


def _spoken(value: Value) -> str:
    return quantity(value.dimension) if isinstance(value, NumberValue) else value.spoken
