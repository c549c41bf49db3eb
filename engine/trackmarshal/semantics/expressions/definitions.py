"""Definitions: their bodies, checked and written out wherever they are called, with the arguments in place of the parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.semantics.errors.expressions import Recursive, TooLarge, WrongDimension, WrongKind
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import of_dimension
from trackmarshal.semantics.expressions.geometry import area, line
from trackmarshal.semantics.expressions.shapes import is_shape, lacking, one_of, shape_named
from trackmarshal.semantics.expressions.sharing import Made, Place
from trackmarshal.semantics.values import Local, Poison, circle, own_unit, span_of, spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import parse_unit, quantity

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

#: How many definitions one declaration may be made of, each counted where it is written out.
MOST_EXPANSIONS = 10_000
#: How many definitions may be inside each other.
DEEPEST = 50


def expand(
    x: Expressions,
    symbol: typed.Symbol,
    item: ast.Define,
    args: Sequence[typed.Value | None],
    infix: bool,
    span: Span,
    ctx: Context,
) -> typed.CalledNumber | typed.CalledFormula:
    """A definition written out with its arguments in place of its parameters; None: the parameter's default."""
    if symbol.qualified in ctx.stack:
        x.fail(Recursive(span, item.name, circle(ctx.stack, symbol.qualified)))
    if symbol.qualified in x.failed:
        raise Poison
    if len(ctx.stack) >= DEEPEST:
        x.fail(TooLarge(ctx.site or span, f"nested more than {DEEPEST} definitions deep"))
    count_definitions(x, 1, span, ctx)
    inner = ctx.inside(x.scopes[symbol.module], {}, span, symbol.qualified)
    given_ = x.each(
        lambda one: _default(x, one[0], inner) if one[1] is None else one[1], zip(item.parameters, args)
    )
    kept = [x.shared.argument(value) for value in given_]
    place = Place(symbol.qualified, ctx.level, ctx.timeline, tuple(kept))
    known_ = x.shared.made.get(place)
    if known_ is not None and len(ctx.stack) + known_.depth < DEEPEST:
        return _again(x, known_, infix, span, ctx)
    before = len(x.found), x.expansions, x.deepest
    x.deepest = len(ctx.stack)
    bound = x.each(
        lambda one: _argument(x, one[0], one[1], one[2], inner), zip(item.parameters, given_, kept)
    )
    value = _body(x, symbol, item, (tuple(kept), tuple(bound)), infix, span, ctx)
    found, expansions, deepest = before
    if len(x.found) == found:
        x.shared.made[place] = Made(value, x.expansions - expansions, x.deepest - len(ctx.stack))
    x.deepest = max(x.deepest, deepest)
    return value


def count_definitions(x: Expressions, number: int, span: Span, ctx: Context) -> None:
    """So many more definitions are part of the declaration at hand; fails where those are too many."""
    x.expansions += number
    if x.expansions > MOST_EXPANSIONS:
        x.fail(TooLarge(ctx.site or span, f"made of more than {MOST_EXPANSIONS} definitions"))


def _again(
    x: Expressions, known: Made, infix: bool, span: Span, ctx: Context
) -> typed.CalledNumber | typed.CalledFormula:
    """What was made of the same arguments, where it is called now; it counts as often as it is written out."""
    count_definitions(x, known.expansions, span, ctx)
    x.deepest = max(x.deepest, len(ctx.stack) + known.depth)
    made = known.value
    if isinstance(made, typed.CalledNumber):
        return typed.CalledNumber(
            made.dimension, made.written, made.symbol, made.arguments, infix, made.body, span
        )
    return typed.CalledFormula(made.symbol, made.arguments, infix, made.body, span)


def _default(x: Expressions, parameter: ast.Parameter, inner: Context) -> typed.Value:
    """What a parameter is where nothing is given: it sees what the definition's module sees, and no other parameter."""
    assert parameter.default is not None
    return x.value(parameter.default, inner)


def _body(
    x: Expressions,
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
    inner = ctx.inside(x.scopes[symbol.module], local, span, symbol.qualified)
    if item.keyword == "predicate":
        return typed.CalledFormula(symbol, given, infix, x.formula(item.body, inner), span)
    value = x.number(item.body, inner)
    if item.result is not None:
        wanted = parse_unit(item.result)[2]
        if value.dimension != wanted:
            what = f"the value of `{item.name}`"
            x.fail(
                WrongDimension(value.span, item.span.head, what, quantity(wanted), quantity(value.dimension))
            )
        x.advise(x.advice.in_unit(value, item.result, f"the value of `{item.name}`", item.span.head))
    written = value.written or own_unit(item.result)
    return typed.CalledNumber(value.dimension, written, symbol, given, infix, value, span)


def check_body(x: Expressions, symbol: typed.Symbol, item: ast.Define, ctx: Context) -> None:
    """Check the body of a definition that may never be called, and its defaults: nothing is given for its parameters."""
    inner = ctx.inside(x.scopes[symbol.module], {}, item.span, symbol.qualified)
    for one in item.parameters:
        if one.default is not None:
            default = _default(x, one, inner)
            _argument(x, one, default, default, inner)
    bound = tuple(x.each(lambda parameter: _open(x, parameter, inner), item.parameters))
    _body(x, symbol, item, ((), bound), False, item.span, ctx)


def _open(x: Expressions, parameter: ast.Parameter, inner: Context) -> Local:
    """A parameter that nothing is given for."""
    kind, name, span = parameter.type, parameter.name, parameter.span
    if is_shape(kind):
        return typed.NamedRecord(_shape(x, parameter, inner), None, name, None, kind, span)
    if kind in ("trajectory", "polyline"):
        return typed.NamedLine(name, None, span)
    if kind == "corridor":
        return typed.NamedArea(name, None, span)
    return typed.NamedNumber(parse_unit(kind)[2], "", name, None, kind, span)


def _shape(x: Expressions, parameter: ast.Parameter, inner: Context) -> typed.Shape:
    """What a definition asks for, by the name that its module gives it."""
    return shape_named(x, parameter.type, parameter.span.word(parameter.type), inner.scope)


def _argument(
    x: Expressions, parameter: ast.Parameter, value: typed.Value, kept: typed.Value, inner: Context
) -> Local:
    """The argument as the body sees it: of the declared dimension, or through the declared shape; kept: the first one that says the same."""
    kind, name, span = parameter.type, parameter.name, span_of(value)
    if is_shape(kind):
        shape = _shape(x, parameter, inner)
        if isinstance(value, typed.RecordNode):
            problem = lacking(value, shape)
            if not problem:
                assert isinstance(kept, typed.RecordNode)
                return typed.NamedRecord(shape, value.signal, name, kept, kind, span)
        else:
            problem = one_of(value)
        asked = f"something with {', '.join(shape)} for `{name}: {kind}`"
        x.fail(WrongKind(span, asked, spoken(value), problem))
    if kind in ("trajectory", "polyline"):
        return typed.NamedLine(name, line(x, value, span), span)
    if kind == "corridor":
        return typed.NamedArea(name, area(x, value, span), span)
    if not isinstance(value, typed.NumberNode):
        x.fail(WrongKind(span, f"a number for `{name}`", spoken(value)))
    what = f"argument `{name}`"
    of_dimension(x, value, parse_unit(kind)[2], what, parameter.span, kind)
    x.advise(x.advice.in_unit(value, kind, what, parameter.span))
    assert isinstance(kept, typed.NumberNode)
    return typed.NamedNumber(value.dimension, value.written, name, kept, kind, span)
