"""Calls: built-in functions, tables, geometry, and definitions, whose bodies are checked wherever they are used."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, assert_never

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir.operators import FUNCTIONS, Dimensions, known
from trackmarshal.ir.spec import Enumeration
from trackmarshal.semantics.advice.formulas import met_by_others, same_everywhere
from trackmarshal.semantics.arguments import counted, given, in_order
from trackmarshal.semantics.errors.expressions import (
    Recursive,
    TooLarge,
    WrongArity,
    WrongDimension,
    WrongKind,
)
from trackmarshal.semantics.errors.names import UnknownReference
from trackmarshal.semantics.scope import spoken
from trackmarshal.semantics.shapes import SHAPES, Kind, is_shape, shape_named
from trackmarshal.semantics.sharing import Made, Place
from trackmarshal.semantics.values import (
    Local,
    Poison,
    common,
    own_unit,
    same_record,
    sample_of,
    span_of,
    written_unit,
)
from trackmarshal.semantics.values import spoken as value_spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.build import is_unit
from trackmarshal.units import LENGTH, NUMBER, SPEED, Dimension, name, over, parse_unit, power, quantity, show

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions import Context, Expressions

#: What counts cycles.
COUNT = "count"
#: Built-in functions that are not plain functions of numbers: how many arguments, and which, for messages.
_SPECIAL: dict[str, tuple[tuple[int, ...], str]] = {
    "rising": ((1,), "1 argument (a formula)"), "falling": ((1,), "1 argument (a formula)"),
    "footprint": ((1, 3), "1 argument (a body) or 3 (a pose, length, width)"),
    "swept_footprint": ((3,), "3 arguments (a sample of a trajectory, length, width)"),
    "swept_hull": ((3,), "3 arguments (a sample of a trajectory, length, width)"),
    "swept": ((4,), "4 arguments (two poses, length, width)"), "inside": ((2,), "2 arguments (a footprint, an area)"),
    "meets": ((2,), "2 arguments (a footprint, a lane)"),
    "clear_of": ((2,), "2 arguments (two footprints)"), "station": ((2,), "2 arguments (a point, a line)"),
    "offset": ((2,), "2 arguments (a point, a line)"), "direction": ((2,), "2 arguments (a point, a line)"),
    "distance_to": ((2,), "2 arguments (a point, a line)"), "station_gap": ((3,), "3 arguments (a line, two stations)"),
    "centre": ((1,), "1 argument (a corridor)"), "path": ((1,), "1 argument (a trajectory)"),
}  # fmt: skip
#: How many definitions one declaration may be made of, each counted where it is written out.
MOST_EXPANSIONS = 10_000
#: How many definitions may be inside each other.
DEEPEST = 50
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
_NAME = re.compile(r"[^\W\d]\w*")


def built_in_names() -> set[str]:
    """Every function that needs no declaration."""
    return {*FUNCTIONS, *_SPECIAL, COUNT, "is", "time_in"}


def call(
    self: Expressions,
    function: str,
    args: tuple[ast.Expr, ...],
    names: tuple[str, ...],
    infix: bool,
    span: Span,
    ctx: Context,
) -> typed.Value:
    """A call of anything by its name; infix: `a f b`."""
    if function == COUNT and not ctx.scope.knows(COUNT):
        return _count_of_cycles(self, args, names, span, ctx)
    meant = ctx.scope.find(function)
    if any(names) and (meant is None or not isinstance(meant.item, ast.Define)):
        problem = "named arguments are for definitions and the builders of tests"
        self.fail(UnknownReference(span, problem, "write the arguments in order"))
    if not ctx.scope.knows(function):
        if function in FUNCTIONS:
            return _numeric(self, function, args, span, ctx)
        if function in _SPECIAL:
            return _special(self, function, args, span, ctx)
    at = _name_of_call(args, span)
    found, item = _declared(self, function, args, at, ctx)
    comma = decimal_comma(*(arg.__dict__["span"] for arg in args))
    if isinstance(item, ast.Define):
        placed = in_order(self, item, args, names, at, comma)
    elif len(args) == (1 if item.second is None else 2):
        placed = list(args)
    else:
        wanted = counted(1 if item.second is None else 2)
        self.found.append(WrongArity(at, function, wanted, given(len(args)), item.span.head, comma))
        placed = None
    values = {id(arg): value for arg, value in zip(args, self.each(lambda arg: self.value(arg, ctx), args))}
    if placed is None:
        raise Poison
    ordered = [None if arg is None else values[id(arg)] for arg in placed]
    if isinstance(item, ast.Table):
        return _table(self, found, item, [value for value in ordered if value is not None], span)
    return expand(self, found, item, ordered, infix, span, ctx)


def _count_of_cycles(
    self: Expressions, args: tuple[ast.Expr, ...], names: tuple[str, ...], span: Span, ctx: Context
) -> typed.Count:
    """`count(p)`, with `last: 10 s` or `reset: q`."""
    given = dict(zip(names, args))
    wrong = next((arg for name, arg in zip(names, args) if name not in ("", "last", "reset")), None)
    if len(given) != len(args) or "" not in given or wrong is not None or names[0] or len(args) > 2:
        hint = "write `count(p)`, `count(p, last: 10 s)` or `count(p, reset: q)`"
        at = span if wrong is None else wrong.__dict__["span"]
        self.fail(UnknownReference(at, "`count` takes a formula, and `last` or `reset`", hint))
    self.advise(met_by_others("count", given[""]))
    self.advise(met_by_others("reset", given.get("reset")))
    counted, window, reset = self.all(
        lambda: self.formula(given[""], ctx),
        lambda: self.last(given["last"], ctx) if "last" in given else None,
        lambda: self.formula(given["reset"], ctx) if "reset" in given else None,
    )
    self.advise(same_everywhere("count", ctx.timeline, counted, reset))
    return typed.Count(ctx.timeline, counted, window, reset, span)


def _declared(
    self: Expressions, function: str, args: tuple[ast.Expr, ...], at: Span, ctx: Context
) -> tuple[typed.Symbol, ast.Table | ast.Define]:
    """What a call calls; where that is nothing, the errors of its arguments are reported all the same."""
    try:
        found = self.look_up(function, at, "function", built_in_names(), ctx)
        if isinstance(found.item, (ast.Table, ast.Define)):
            return found, found.item
        hint = (
            f"ask for it: `{at.text}(...) is {found.item.start.name}`"
            if isinstance(found.item, ast.State)
            else ""
        )
        self.fail(WrongKind(at, "a function", f"the {spoken(found.item)} `{function}`", hint))
    except Poison:
        self.each(lambda arg: self.value(arg, ctx), args)
        raise


def _name_of_call(args: tuple[ast.Expr, ...], span: Span) -> Span:
    """Where the name stands in `f(a, b)` and in `a f b`."""
    start = span.start
    if args and args[0].__dict__["span"].start == start:
        start = args[0].__dict__["span"].end
    match = _NAME.search(span.file.text, start, span.end)
    return span if match is None else Span(span.file, *match.span())


def expand(
    self: Expressions,
    symbol: typed.Symbol,
    item: ast.Define,
    args: Sequence[typed.Value | None],
    infix: bool,
    span: Span,
    ctx: Context,
) -> typed.CalledNumber | typed.CalledFormula:
    """A definition written out with its arguments in place of its parameters; None: the parameter's default."""
    if symbol.qualified in ctx.stack:
        cycle = " -> ".join(
            q.rpartition(".")[2] for q in (*ctx.stack[ctx.stack.index(symbol.qualified) :], symbol.qualified)
        )
        self.fail(Recursive(span, item.name, cycle))
    if symbol.qualified in self.failed:
        raise Poison
    if len(ctx.stack) >= DEEPEST:
        self.fail(TooLarge(ctx.site or span, f"nested more than {DEEPEST} definitions deep"))
    count_definitions(self, 1, span, ctx)
    inner = _inside(self, symbol, {}, span, ctx)
    given_ = self.each(
        lambda one: _default(self, one[0], inner) if one[1] is None else one[1], zip(item.parameters, args)
    )
    kept = [self.shared.argument(value) for value in given_]
    place = Place(symbol.qualified, ctx.level, ctx.timeline, tuple(kept))
    known_ = self.shared.made.get(place)
    if known_ is not None and len(ctx.stack) + known_.depth < DEEPEST:
        return _again(self, known_, infix, span, ctx)
    before = len(self.found), self.expansions, self.deepest
    self.deepest = len(ctx.stack)
    bound = self.each(
        lambda one: _argument(self, one[0], one[1], one[2], inner), zip(item.parameters, given_, kept)
    )
    value = _body(self, symbol, item, (tuple(kept), tuple(bound)), infix, span, ctx)
    found, expansions, deepest = before
    if len(self.found) == found:
        self.shared.made[place] = Made(value, self.expansions - expansions, self.deepest - len(ctx.stack))
    self.deepest = max(self.deepest, deepest)
    return value


def count_definitions(self: Expressions, number: int, span: Span, ctx: Context) -> None:
    """So many more definitions are part of the declaration at hand; fails where those are too many."""
    self.expansions += number
    if self.expansions > MOST_EXPANSIONS:
        self.fail(TooLarge(ctx.site or span, f"made of more than {MOST_EXPANSIONS} definitions"))


def _again(
    self: Expressions, known: Made, infix: bool, span: Span, ctx: Context
) -> typed.CalledNumber | typed.CalledFormula:
    """What was made of the same arguments, where it is called now; it counts as often as it is written out."""
    count_definitions(self, known.expansions, span, ctx)
    self.deepest = max(self.deepest, len(ctx.stack) + known.depth)
    made = known.value
    if isinstance(made, typed.CalledNumber):
        return typed.CalledNumber(
            made.dimension, made.written, made.symbol, made.arguments, infix, made.body, span
        )
    return typed.CalledFormula(made.symbol, made.arguments, infix, made.body, span)


def _default(self: Expressions, parameter: ast.Parameter, inner: Context) -> typed.Value:
    """What a parameter is where nothing is given: it sees what the definition's module sees, and no other parameter."""
    assert parameter.default is not None
    return self.value(parameter.default, inner)


def _inside(
    self: Expressions, symbol: typed.Symbol, local: dict[str, Local], span: Span, ctx: Context
) -> Context:
    """Where the body of a definition stands that is called from a context."""
    scope, stack = self.scopes[symbol.module], (*ctx.stack, symbol.qualified)
    return type(ctx)(scope, local, ctx.level, ctx.timeline, ctx.site or span, stack)


def _body(
    self: Expressions,
    symbol: typed.Symbol,
    item: ast.Define,
    args: tuple[tuple[typed.Value, ...], tuple[Local, ...]],
    infix: bool,
    span: Span,
    ctx: Context,
) -> typed.CalledNumber | typed.CalledFormula:
    """What a definition comes to with these arguments: as they are, and as its body sees them."""
    given, bound = args
    local = {p.name: value for p, value in zip(item.parameters, bound)}
    inner = _inside(self, symbol, local, span, ctx)
    if item.keyword == "predicate":
        return typed.CalledFormula(symbol, given, infix, self.formula(item.body, inner), span)
    value = self.number(item.body, inner)
    if item.result is not None:
        wanted = parse_unit(item.result)[2]
        if value.dimension != wanted:
            what = f"the value of `{item.name}`"
            self.fail(
                WrongDimension(value.span, item.span.head, what, quantity(wanted), quantity(value.dimension))
            )
        self.advise(self.advice.in_unit(value, item.result, f"the value of `{item.name}`", item.span.head))
    written = value.written or own_unit(item.result)
    return typed.CalledNumber(value.dimension, written, symbol, given, infix, value, span)


def check_definition(self: Expressions, symbol: typed.Symbol, item: ast.Define, ctx: Context) -> None:
    """Check the body of a definition that may never be called, and its defaults: nothing is given for its parameters."""
    inner = _inside(self, symbol, {}, item.span, ctx)
    for one in item.parameters:
        if one.default is not None:
            default = _default(self, one, inner)
            _argument(self, one, default, default, inner)
    bound = tuple(self.each(lambda parameter: _open(self, parameter, inner), item.parameters))
    _body(self, symbol, item, ((), bound), False, item.span, ctx)


def _open(self: Expressions, parameter: ast.Parameter, inner: Context) -> Local:
    """A parameter that nothing is given for."""
    kind, name, span = parameter.type, parameter.name, parameter.span
    if is_shape(kind):
        return typed.NamedRecord(_shape(self, parameter, inner), None, name, None, kind, span)
    if kind in ("trajectory", "polyline"):
        return typed.NamedLine(name, None, span)
    if kind == "corridor":
        return typed.NamedArea(name, None, span)
    return typed.NamedNumber(parse_unit(kind)[2], "", name, None, kind, span)


def _shape(self: Expressions, parameter: ast.Parameter, inner: Context) -> typed.Shape:
    """What a definition asks for, by the name that its module gives it."""
    return shape_named(self, parameter.type, parameter.span.word(parameter.type), inner.scope)


def _argument(
    self: Expressions, parameter: ast.Parameter, value: typed.Value, kept: typed.Value, inner: Context
) -> Local:
    """The argument as the body sees it: of the declared dimension, or through the declared shape; kept: the first one that says the same."""
    kind, name, span = parameter.type, parameter.name, span_of(value)
    if is_shape(kind):
        shape = _shape(self, parameter, inner)
        if isinstance(value, typed.RecordNode):
            problem = _lacking(value, shape)
            if not problem:
                assert isinstance(kept, typed.RecordNode)
                return typed.NamedRecord(shape, value.signal, name, kept, kind, span)
        else:
            problem = _one_of(value)
        asked = f"something with {', '.join(shape)} for `{name}: {kind}`"
        self.fail(WrongKind(span, asked, value_spoken(value), problem))
    if kind in ("trajectory", "polyline"):
        return typed.NamedLine(name, line(self, value, span), span)
    if kind == "corridor":
        return typed.NamedArea(name, _area(self, value, span), span)
    if not isinstance(value, typed.NumberNode):
        self.fail(WrongKind(span, f"a number for `{name}`", value_spoken(value)))
    wanted = parse_unit(kind)[2]
    if value.dimension != wanted:
        what = f"argument `{name}`"
        self.fail(
            WrongDimension(
                span,
                parameter.span,
                what,
                quantity(wanted),
                quantity(value.dimension),
                unit_hint(value, wanted, kind),
            )
        )
    self.advise(self.advice.in_unit(value, kind, f"argument `{name}`", parameter.span))
    assert isinstance(kept, typed.NumberNode)
    return typed.NamedNumber(value.dimension, value.written, name, kept, kind, span)


def _numeric(
    self: Expressions, function: str, args: tuple[ast.Expr, ...], span: Span, ctx: Context
) -> typed.Value:
    called = known(function, FUNCTIONS)
    wanted, dimensions, _, more = FUNCTIONS[called]
    fits = len(args) == wanted or (more and len(args) > wanted)
    if not fits:
        least = "at least " if more else ""
        of_many = f"of many it is written `{function}(p.v for p in plan)`" if more and len(args) == 1 else ""
        self.found.append(
            WrongArity(
                _name_of_call(args, span),
                function,
                least + counted(wanted),
                given(len(args)),
                None,
                of_many or decimal_comma(*(arg.__dict__["span"] for arg in args)),
            )
        )
    values = self.each(lambda arg: self.number(arg, ctx), args)
    if not fits:
        raise Poison
    numbers: tuple[typed.Number, ...] = tuple(values)
    dimension = _dimension(self, function, dimensions, numbers)
    if function in ("sin", "cos", "tan"):
        self.advise(self.advice.in_unit(numbers[0], "rad", "the angle", None))
    kept = common(*numbers) if dimensions is Dimensions.KEPT else ""
    return typed.Function(dimension, kept, called, numbers, span)


def _dimension(
    self: Expressions, function: str, dimensions: Dimensions, numbers: tuple[typed.Number, ...]
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


def _table(
    self: Expressions, symbol: typed.Symbol, item: ast.Table, values: list[typed.Value], span: Span
) -> typed.Number:
    result = parse_unit(item.result)[2]
    units = [item.unit] if item.second is None else [item.unit, item.second.unit]
    names = [""] if item.second is None else [f" `{item.argument}`", f" `{item.second.name}`"]
    numbers: list[typed.Number] = []
    for value, argument_unit, called_ in zip(values, units, names, strict=True):
        argument = parse_unit(argument_unit)[2]
        what, declared = f"the argument{called_} of `{item.name}`", item.span.head.word(argument_unit)
        if not isinstance(value, typed.NumberNode) or value.dimension != argument:
            hint = unit_hint(value, argument, argument_unit) if isinstance(value, typed.NumberNode) else ""
            self.fail(
                WrongDimension(span_of(value), declared, what, quantity(argument), _spoken(value), hint)
            )
        self.advise(self.advice.in_unit(value, argument_unit, what, declared))
        numbers.append(value)
    unit = written_unit((cell for row in item.rows for cell in row[1:]), item.result)
    return typed.TableValue(result, unit, symbol, tuple(numbers), span)


def _special(
    self: Expressions, function: str, args: tuple[ast.Expr, ...], span: Span, ctx: Context
) -> typed.Value:
    counts, wanted = _SPECIAL[function]
    fits = len(args) in counts
    if not fits:
        at = _name_of_call(args, span)
        comma = decimal_comma(*(arg.__dict__["span"] for arg in args))
        self.found.append(WrongArity(at, function, wanted, given(len(args)), None, comma))
    if function in typed.EDGES:
        operands = self.each(lambda arg: self.formula(arg, ctx), args)
        if not fits:
            raise Poison
        self.advise(same_everywhere(function, ctx.timeline, operands[0]))
        return typed.Edge(known(function, typed.EDGES), ctx.timeline, operands[0], span)
    values: list[typed.Value] = self.each(lambda arg: self.value(arg, ctx), args)
    if not fits:
        raise Poison
    spans: list[Span] = [arg.__dict__["span"] for arg in args]
    if function == "footprint" and len(values) == 1:
        return typed.Footprint(shaped(self, values[0], "body", spans[0]), span)
    if function == "footprint":
        pose = shaped(self, values[0], "pose", spans[0])
        return typed.FootprintAt(pose, _length(self, values[1]), _length(self, values[2]), span)
    if function in _SWEPT:
        sample, way = values[0], known(function, _SWEPT)
        if not isinstance(sample, typed.RecordNode) or sample_of(sample) is None:
            self.fail(WrongKind(spans[0], "a sample of a trajectory", value_spoken(sample)))
        shaped(self, sample, "pose", spans[0])
        if way == "swept_footprint":
            _check_curved(self, sample, spans[0])
        return typed.SweptSample(way, sample, _length(self, values[1]), _length(self, values[2]), span)
    if function == "swept":
        start, end = shaped(self, values[0], "pose", spans[0]), shaped(self, values[1], "pose", spans[1])
        return typed.Swept(start, end, _length(self, values[2]), _length(self, values[3]), span)
    if function == "inside":
        region = _region(self, values[0], spans[0])
        return typed.Inside(region, _area(self, values[1], spans[1]), span)
    if function == "meets":
        region, lane = _region(self, values[0], spans[0]), values[1]
        if not isinstance(lane, typed.RecordNode) or not is_lane(lane):
            hint = "bind one first: `exists l in lanes: footprint(o) meets l`"
            self.fail(WrongKind(spans[1], "a lane", value_spoken(lane), hint))
        return typed.Meets(region, typed.Lane(lane, spans[1]), span)
    if function == "clear_of":
        region, other = _region(self, values[0], spans[0]), _region(self, values[1], spans[1])
        if not _at_rest(other):
            self.fail(WrongKind(spans[1], "a footprint at rest", "a swept footprint", "swap the two sides"))
        return typed.ClearOf(region, other, span)
    if function in _ON_LINE:
        point, called = shaped(self, values[0], "point", spans[0]), known(function, _ON_LINE)
        return typed.OnLine(_ON_LINE[called], "", called, point, line(self, values[1], spans[1]), span)
    if function == "station_gap":
        first, second = (_length(self, v) for v in values[1:])
        return typed.StationGap(LENGTH, "", line(self, values[0], spans[0]), first, second, span)
    if function == "centre":
        area = _area(self, values[0], spans[0])
        if not _is_corridor(area):
            self.fail(WrongKind(spans[0], "a corridor", "a zone"))
        return typed.CalledLine("centre", typed.Centre(area, spans[0]), span)
    if function == "path":
        return typed.CalledLine("path", line(self, values[0], spans[0]), span)
    raise AssertionError(f"unknown function {function}")


def shaped(self: Expressions, value: typed.Value, shape: str, span: Span) -> typed.Record:
    """A value that is a record with the fields that a shape names."""
    if not isinstance(value, typed.RecordNode):
        self.fail(
            WrongKind(span, f"something with {', '.join(SHAPES[shape])}", value_spoken(value), _one_of(value))
        )
    hint = _lacking(value, SHAPES[shape])
    if hint:
        self.fail(WrongKind(span, f"something with {', '.join(SHAPES[shape])}", value_spoken(value), hint))
    return value


def _one_of(value: typed.Value) -> str:
    """How one of a whole set, or a sample of a timeline, is named; empty for what is neither."""
    if not isinstance(value, typed.SignalNode) or not (value.signal.many or value.signal.sequence):
        return ""
    each = "o" if value.signal.many else "p"
    return (
        f"this is all of them: bind each by `for all {each} in {value.signal.name}`, and write `{each}` here"
    )


def _lacking(value: typed.Record, shape: typed.Shape) -> str:
    """Why a record does not fit a shape; empty when it does."""
    for field, kind in shape.items():
        if field not in value.shape:
            similar = close_matches(field, [name for name in value.shape if name not in shape])
            unit = "rad" if field == "heading" else _declared_as(kind)
            return f"it has no `{field}`" + (f"; {similar}" if similar else f": declare `{field}: {unit}`")
        if value.shape[field] != kind:
            return f"its `{field}` is {_kind_spoken(value.shape[field])}, not {_kind_spoken(kind)}"
    return ""


def _declared_as(kind: Kind) -> str:
    """How a field of a kind is declared."""
    if isinstance(kind, Enumeration):
        return kind.name.rpartition(".")[2]
    return "bool" if kind is None else show(kind)


def _kind_spoken(kind: Kind) -> str:
    if isinstance(kind, Enumeration):
        return f"a member of `{kind.name.rpartition('.')[2]}`"
    return "a Boolean" if kind is None else quantity(kind)


def line(self: Expressions, value: typed.Value, span: Span) -> typed.Line:
    """The polyline that a value is, or has: a line, the path of a trajectory, the centre line of a corridor."""
    if isinstance(value, typed.LineNode):
        return value
    if isinstance(value, typed.SignalNode) and value.signal.kind == "trajectory" and not value.signal.many:
        for column in SHAPES["point"]:
            field = value.signal.field(column)
            if field is None or field.kind != "number" or parse_unit(field.unit)[2] != LENGTH:
                spoken_, hint = value_spoken(value), f"declare its column `{column}: m`"
                self.fail(WrongKind(span, "a trajectory with a path", spoken_, hint))
        return typed.Path(value, span)
    if isinstance(value, typed.SignalNode) and value.signal.kind == "corridor":
        return typed.Centre(typed.Corridor(value, span), span)
    if isinstance(value, typed.AreaNode) and _is_corridor(value):
        return typed.Centre(value, span)
    if isinstance(value, typed.RecordNode) and is_lane(value):
        return typed.Centre(typed.Lane(value, span), span)
    between = "the distance between two points is `distance(a, b)`, with `use prelude.frames`"
    hint = between if isinstance(value, typed.RecordNode) else ""
    self.fail(WrongKind(span, "a line, a trajectory or a corridor", value_spoken(value), hint))


def _area(self: Expressions, value: typed.Value, span: Span) -> typed.Area:
    if isinstance(value, typed.AreaNode):
        return value
    if isinstance(value, typed.SignalNode) and value.signal.kind == "corridor":
        return typed.Corridor(value, span)
    if isinstance(value, typed.RecordNode) and is_lane(value):
        return typed.Lane(value, span)
    self.fail(WrongKind(span, "a zone or a corridor", value_spoken(value)))


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


def _region(self: Expressions, value: typed.Value, span: Span) -> typed.Region:
    if not isinstance(value, typed.RegionNode):
        hint = "write footprint(...) or swept_footprint(...)"
        self.fail(WrongKind(span, "a footprint", value_spoken(value), hint))
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


def _check_curved(self: Expressions, sample: typed.Record, span: Span) -> None:
    """Refuse a sample without a curvature: nothing says how the way goes from one to the next."""
    if sample.shape.get("kappa") != _CURVED["kappa"]:
        lacking = _lacking(sample, _CURVED)
        hint = f"{lacking}, or write swept_hull(...), which goes straight from sample to sample"
        wanted = f"something with {', '.join(_CURVED)}"
        self.fail(WrongKind(span, wanted, value_spoken(sample), hint))


def _length(self: Expressions, value: typed.Value) -> typed.Number:
    if not isinstance(value, typed.NumberNode) or value.dimension != LENGTH:
        hint = unit_hint(value, LENGTH) if isinstance(value, typed.NumberNode) else ""
        self.fail(
            WrongDimension(span_of(value), None, "this argument", quantity(LENGTH), _spoken(value), hint)
        )
    return value


_LITERAL = re.compile(r"([-−]?\s*[0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(\S*)")


def decimal_comma(*spans: Span) -> str:
    """What to write where two arguments look like one number with a decimal comma, `f(1,5 m)`; empty where none do."""
    for first, second in pairwise(spans):
        text = first.file.text
        if first.text.isdecimal() and text[first.end : second.start] == "," and second.text[:1].isdecimal():
            return f"numbers have a decimal point: `{first.text}.{second.text}`"
    return ""


def unit_hint(value: typed.Number, wanted: Dimension, declared: str = "") -> str:
    """How a literal gets the dimension that is wanted; empty for what is no literal, or has no such unit.

    declared: the unit of what it meets. Of a limit for a speed in km/h, whoever writes m/s as told has one that is 3.6 times as high.
    """
    literal, unit = _LITERAL.fullmatch(value.span.text.strip()), show(wanted)
    if declared and is_unit(declared) and parse_unit(declared)[2] == wanted:
        unit = declared
    if literal is None or typed.literal(value) is None or "*" in unit or "(" in unit:
        return ""
    if wanted == NUMBER:  # of what is declared in deg or %, a bare number is another one
        other = f"write a number in {unit}, such as `{literal[1]} {unit}`"
        return f"leave the unit out: `{literal[1]}`" if unit == "1" else other
    if not literal[2]:
        return f"write the unit: `{literal[1]} {unit}`"
    if literal[2] == "%":
        return f"say of what it is a share: `{literal[1]}% * NAME`"
    if literal[2] == "km" and wanted == SPEED:
        unit = "km/h"
    return f"write a unit of {name(wanted)}, such as `{literal[1]} {unit}`"


def unit_of_factor(value: typed.Number, wanted: Dimension) -> str:
    """What to write for `pit * 1.1 km/h`, where a speed is wanted and `pit` is one; empty for what is no such product."""
    if not isinstance(value, typed.Arithmetic) or value.op not in ("*", "/"):
        return ""
    factors = ((value.right, value.left), (value.left, value.right))[: 2 if value.op == "*" else 1]
    for factor, other in factors:
        literal = _LITERAL.fullmatch(factor.span.text.strip())
        if literal and literal[2] and isinstance(factor, typed.Literally) and other.dimension == wanted:
            return f"a factor has no unit: `{literal[1]}`"
    return ""


def _spoken(value: typed.Value) -> str:
    return quantity(value.dimension) if isinstance(value, typed.NumberNode) else value_spoken(value)
