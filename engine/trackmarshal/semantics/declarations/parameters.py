"""Parameters: their values and ranges, and what is to hold between them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, NoReturn

from trackmarshal import typed
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.constants import constant_value
from trackmarshal.ir.interning import Interner
from trackmarshal.ir.spec import ConstraintInfo, ParamInfo
from trackmarshal.lowering.expressions import Lowering
from trackmarshal.semantics.declarations.ranges import inside, limits, outside
from trackmarshal.semantics.declarations.records import check_field, record_params
from trackmarshal.semantics.errors.expressions import BadValue, WrongDimension
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import unit_hint
from trackmarshal.semantics.values import Poison
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import NUMBER, in_full, name, parse_unit, quantity

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

#: What the formula of a `constrain` may be made of: everything that parameters and tables decide.
_SETTLED = (
    ir.Const, ir.Param, ir.Arith, ir.Neg, ir.Func, ir.Choose, ir.Lookup, ir.GridLookup, ir.Truth, ir.Compare, ir.Not, ir.Connective,
)  # fmt: skip


class Parameters:
    """Those of all modules, by their qualified names, each as soon as its value is known."""

    def __init__(self, x: Expressions, interner: Interner) -> None:
        self.known: dict[str, ParamInfo] = {}
        self._x = x
        self._interner = interner

    def declare(self, items: Iterable[ast.Item], ctx: Context) -> None:
        """Declare those of a module, those of which its records are made included, in the order of their declarations."""
        x, params = self._x, list[ast.Param]()
        for item in items:
            if isinstance(item, ast.ParamRecord):
                x.attempt(partial(record_params, x, item, ctx.scope, params), item.span.head)
            elif isinstance(item, ast.Param):
                check_field(x, item, ctx.scope)
                params.append(item)
        for param in params:
            qualified = f"{ctx.scope.module}.{param.name}"
            x.params.setdefault(qualified, parse_unit(param.unit)[2])
            x.advice.units.setdefault(qualified, param.unit)
        for param in params:
            x.attempt(partial(self._declare, param, ctx), param.span.head)

    def _declare(self, item: ast.Param, ctx: Context) -> None:
        x, unit = self._x, item.unit
        (number, made_of), (lower, upper) = x.all(
            lambda: self._value(item, ctx), lambda: limits(x, item.range, unit)
        )
        if not inside(number, lower, upper):
            assert item.range is not None
            problem = f"the value of `{item.name}`, {in_full(number, unit)}, is {outside(lower, upper, unit)}"
            x.fail(BadValue(ast.span_of(item.value), problem, item.range.span))
        qualified, record = f"{ctx.scope.module}.{item.name}", item.name.rpartition(".")[0]
        info = ParamInfo(qualified, number, unit, lower, upper, item.source, item.span, record, made_of)
        self.known.setdefault(qualified, info)

    def _value(self, item: ast.Param, ctx: Context) -> tuple[float, tuple[str, ...]]:
        x, dimension = self._x, parse_unit(item.unit)[2]
        value, what = x.number(item.value, ctx), f"parameter `{item.name}`"
        if value.dimension != dimension:
            hint = unit_hint(value, dimension, item.unit)
            if value.dimension == NUMBER and isinstance(item.value, ast.Number) and not item.value.unit:
                hint = f"write the unit: `{item.value.text} {item.unit}`"
            wanted = f"{name(dimension)} [{item.unit}]" if dimension != NUMBER else name(dimension)
            declared = item.span.word(item.unit)
            x.fail(WrongDimension(value.span, declared, what, wanted, quantity(value.dimension), hint))
        x.advise(x.advice.in_unit(value, item.unit, what, item.span.word(item.unit)))
        return self.constant(value, ctx)

    def constant(self, number: typed.Number, ctx: Context) -> tuple[float, tuple[str, ...]]:
        """The value of a number made of literals and parameters declared before, and the names of these."""
        node, span = Lowering(self._interner).number(number), number.span
        made_of = tuple([part.name for part in ir.below(node) if isinstance(part, ir.Param)])
        for each in made_of:
            if each not in self.known:
                self._without_value(each, span, ctx)
        value = constant_value(node, lambda name: self.known[name].value)
        if value is None:
            hint = "use literals and parameters that are declared before"
            self._x.fail(BadValue(span, "this is not constant", None, hint))
        if not math.isfinite(value):
            problem = f"this value is {in_full(value, '1')}, which is not finite"
            self._x.fail(BadValue(span, problem, None, "its arithmetic divides by zero or overflows"))
        return value, made_of

    def _without_value(self, qualified: str, span: Span, ctx: Context) -> NoReturn:
        """Fail for a parameter that has no value yet; where its own error was reported, silently."""
        module, x = ctx.scope.module, self._x
        own = ctx.scope.own.items()
        symbol, short = next(
            ((known, name) for name, known in own if f"{qualified}.".startswith(f"{module}.{name}.")),
            (None, ""),
        )
        if symbol is not None:
            declared: Span = symbol.item.__dict__["span"]
            at = span.word(short)
            if declared.start < span.start < declared.end:
                x.fail(BadValue(at, f"the value of `{short}` needs itself", None, "write its value"))
            if declared.start > span.start:
                problem, hint = f"`{short}` is declared further down", "move its declaration up"
                x.fail(BadValue(at, problem, declared.head, hint, "it is declared here"))
        raise Poison


def constraint(item: ast.Constrain, x: Expressions, ctx: Context, interner: Interner) -> ConstraintInfo:
    """What is to hold between parameters; fails for what depends on an input."""
    formula = Lowering(interner).formula(x.formula(item.condition, ctx))
    if not all(isinstance(node, _SETTLED) for node in ir.below(formula)):
        problem = "a constraint is about parameters and tables, not about inputs"
        hint = "what the input must fulfil is an `assume` with a `monitor`, or a `rule`"
        x.fail(BadValue(ast.span_of(item.condition), problem, None, hint))
    return ConstraintInfo(formula, item.because, item.span)
