"""Calls: what is called, by its name, and of how many arguments; functions of numbers, and tables."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import TYPE_CHECKING, assert_never

from trackmarshal import typed
from trackmarshal.ir.operators import FUNCTIONS, Dimensions, known
from trackmarshal.semantics.advice.formulas import same_everywhere
from trackmarshal.semantics.errors.expressions import WrongArity, WrongDimension, WrongKind
from trackmarshal.semantics.errors.names import UnknownReference
from trackmarshal.semantics.expressions.arguments import counted, given, in_order
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.definitions import expand
from trackmarshal.semantics.expressions.dimensions import decimal_comma, of_dimension, same
from trackmarshal.semantics.expressions.geometry import geometric
from trackmarshal.semantics.expressions.temporal import count
from trackmarshal.semantics.scope import spoken
from trackmarshal.semantics.values import Poison, common, written_unit
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import NUMBER, Dimension, parse_unit, power, quantity

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

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
_NAME = re.compile(r"[^\W\d]\w*")


def built_in_names() -> set[str]:
    """Every function that needs no declaration."""
    return {*FUNCTIONS, *_SPECIAL, COUNT, "is", "time_in"}


def call(
    x: Expressions,
    function: str,
    args: tuple[ast.Expr, ...],
    names: tuple[str, ...],
    infix: bool,
    span: Span,
    ctx: Context,
) -> typed.Value:
    """A call of anything by its name; infix: `a f b`."""
    if function == COUNT and not ctx.scope.knows(COUNT):
        return count(args, names, span, x, ctx)
    meant = ctx.scope.find(function)
    if any(names) and (meant is None or not isinstance(meant.item, ast.Define)):
        problem = "named arguments are for definitions and the builders of tests"
        x.fail(UnknownReference(span, problem, "write the arguments in order"))
    if not ctx.scope.knows(function):
        if function in FUNCTIONS:
            return _numeric(x, function, args, span, ctx)
        if function in _SPECIAL:
            return _special(x, function, args, span, ctx)
    at = _name_of_call(args, span)
    found, item = _declared(x, function, args, at, ctx)
    comma = decimal_comma(*(arg.__dict__["span"] for arg in args))
    if isinstance(item, ast.Define):
        placed = in_order(x, item, args, names, at, comma)
    elif len(args) == (1 if item.second is None else 2):
        placed = list(args)
    else:
        wanted = counted(1 if item.second is None else 2)
        x.found.append(WrongArity(at, function, wanted, given(len(args)), item.span.head, comma))
        placed = None
    values = {id(arg): value for arg, value in zip(args, x.each(lambda arg: x.value(arg, ctx), args))}
    if placed is None:
        raise Poison
    ordered = [None if arg is None else values[id(arg)] for arg in placed]
    if isinstance(item, ast.Table):
        return _table(x, found, item, [value for value in ordered if value is not None], span)
    return expand(x, found, item, ordered, infix, span, ctx)


def _declared(
    x: Expressions, function: str, args: tuple[ast.Expr, ...], at: Span, ctx: Context
) -> tuple[typed.Symbol, ast.Table | ast.Define]:
    """What a call calls; where that is nothing, the errors of its arguments are reported all the same."""
    try:
        found = x.look_up(function, at, "function", built_in_names(), ctx)
        if isinstance(found.item, (ast.Table, ast.Define)):
            return found, found.item
        hint = (
            f"ask for it: `{at.text}(...) is {found.item.start.name}`"
            if isinstance(found.item, ast.State)
            else ""
        )
        x.fail(WrongKind(at, "a function", f"the {spoken(found.item)} `{function}`", hint))
    except Poison:
        x.each(lambda arg: x.value(arg, ctx), args)
        raise


def _name_of_call(args: tuple[ast.Expr, ...], span: Span) -> Span:
    """Where the name stands in `f(a, b)` and in `a f b`."""
    start = span.start
    if args and args[0].__dict__["span"].start == start:
        start = args[0].__dict__["span"].end
    match = _NAME.search(span.file.text, start, span.end)
    return span if match is None else Span(span.file, *match.span())


def _numeric(
    x: Expressions, function: str, args: tuple[ast.Expr, ...], span: Span, ctx: Context
) -> typed.Value:
    called = known(function, FUNCTIONS)
    wanted, dimensions, _, more = FUNCTIONS[called]
    fits = len(args) == wanted or (more and len(args) > wanted)
    if not fits:
        least = "at least " if more else ""
        of_many = f"of many it is written `{function}(p.v for p in plan)`" if more and len(args) == 1 else ""
        x.found.append(
            WrongArity(
                _name_of_call(args, span),
                function,
                least + counted(wanted),
                given(len(args)),
                None,
                of_many or decimal_comma(*(arg.__dict__["span"] for arg in args)),
            )
        )
    values = x.each(lambda arg: x.number(arg, ctx), args)
    if not fits:
        raise Poison
    numbers: tuple[typed.Number, ...] = tuple(values)
    dimension = _dimension(x, function, dimensions, numbers)
    if function in ("sin", "cos", "tan"):
        x.advise(x.advice.in_unit(numbers[0], "rad", "the angle", None))
    kept = common(*numbers) if dimensions is Dimensions.KEPT else ""
    return typed.Function(dimension, kept, called, numbers, span)


def _dimension(
    x: Expressions, function: str, dimensions: Dimensions, numbers: tuple[typed.Number, ...]
) -> Dimension:
    """The dimension of a function's value; fails for arguments of wrong ones."""
    first = numbers[0]
    match dimensions:
        case Dimensions.KEPT | Dimensions.DROPPED:
            for other in numbers[1:]:
                same(x, f"take the {function} of", first, other)
            return first.dimension if dimensions is Dimensions.KEPT else NUMBER
        case Dimensions.ROOT:
            return power(first.dimension, Fraction(1, 2))
        case Dimensions.PLAIN:
            for value in numbers:
                if value.dimension != NUMBER:
                    what, found = f"the argument of `{function}`", quantity(value.dimension)
                    hint = "divide it by a quantity of its own dimension"
                    x.fail(WrongDimension(value.span, None, what, "a plain number", found, hint))
            return NUMBER
        case _:
            assert_never(dimensions)


def _table(
    x: Expressions, symbol: typed.Symbol, item: ast.Table, values: list[typed.Value], span: Span
) -> typed.Number:
    units = [item.unit] if item.second is None else [item.unit, item.second.unit]
    names = [""] if item.second is None else [f" `{item.argument}`", f" `{item.second.name}`"]
    numbers: list[typed.Number] = []
    for value, unit, called_ in zip(values, units, names, strict=True):
        what, declared = f"the argument{called_} of `{item.name}`", item.span.head.word(unit)
        number = of_dimension(x, value, parse_unit(unit)[2], what, declared, unit)
        x.advise(x.advice.in_unit(number, unit, what, declared))
        numbers.append(number)
    written = written_unit((cell for row in item.rows for cell in row[1:]), item.result)
    return typed.TableValue(parse_unit(item.result)[2], written, symbol, tuple(numbers), span)


def _special(
    x: Expressions, function: str, args: tuple[ast.Expr, ...], span: Span, ctx: Context
) -> typed.Value:
    counts, wanted = _SPECIAL[function]
    fits = len(args) in counts
    if not fits:
        at = _name_of_call(args, span)
        comma = decimal_comma(*(arg.__dict__["span"] for arg in args))
        x.found.append(WrongArity(at, function, wanted, given(len(args)), None, comma))
    if function in typed.EDGES:
        operands = x.each(lambda arg: x.formula(arg, ctx), args)
        if not fits:
            raise Poison
        x.advise(same_everywhere(function, ctx.timeline, operands[0]))
        return typed.Edge(known(function, typed.EDGES), ctx.timeline, operands[0], span)
    values: list[typed.Value] = x.each(lambda arg: x.value(arg, ctx), args)
    if not fits:
        raise Poison
    return geometric(x, function, values, [ast.span_of(arg) for arg in args], span)
