"""Constants of a test, in SI: what it gives and what it expects is made of them."""

from __future__ import annotations

import math
from typing import ClassVar, NoReturn

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.constants import constant_value
from trackmarshal.ir.interning import Interner
from trackmarshal.ir.spec import FieldType
from trackmarshal.lowering.expressions import Lowering
from trackmarshal.semantics.compile import Compiled
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import unit_hint
from trackmarshal.semantics.values import Poison
from trackmarshal.semantics.warnings.numbers import BareAngle
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.ast import span_of
from trackmarshal.testing.errors import BadExpectation, BadGiven
from trackmarshal.testing.meant import Meant
from trackmarshal.units import NUMBER, Dimension, parse_shown, parse_unit, quantity, show


class Constants:
    """Reads the constants of one test, and tells what is wrong with them. meant: takes note of what they come to."""

    #: What is wrong with what is read.
    kind: ClassVar[type[BadGiven | BadExpectation]] = BadGiven

    def __init__(self, compiled: Compiled, module: str, found: list[Diagnostic], meant: Meant) -> None:
        self.spec = compiled.spec
        self.scope = compiled.scopes[module]
        self.expressions = compiled.expressions
        self.found = found
        self.meant = meant
        self._lowering = Lowering(Interner())
        self._ctx = Context(self.scope, {}, 0, typed.THE_RUN, None, ())

    def fail(
        self, span: Span, problem: str, hint: str = "", other: Span | None = None,
        declared: tuple[tuple[str, Span, str, str], ...] = (),
    ) -> NoReturn:  # fmt: skip
        given = BadGiven(span, problem, hint, other, declared=declared)
        self.found.append(given if other or declared else self.kind(span, problem, hint))
        raise Poison

    def number(self, value: ast.Expr, unit: str, what: str, field: FieldType | None = None) -> float:
        """A constant of a unit's dimension, in SI; `nan` and `inf` are allowed here and only here."""
        word = special(value)
        if word is not None:
            return word
        number = self.constant(value, what, parse_unit(unit)[2], unit, field)[0]
        literal = value.operand if isinstance(value, ast.Unary) else value
        if number != 0.0 and isinstance(literal, ast.Number) and not literal.unit and unit != "1":
            text = span_of(value).text
            if unit != "rad":  # of an angle, or a percentage: which other numbers look like
                self.fail(span_of(value), f"{what} is a number in {unit}", f"write the unit: `{text} {unit}`")
            self.found.append(BareAngle(span_of(value), None, f"write `{text} deg` or `{text} rad`", what))
        return number

    def truth(self, value: ast.Expr, what: str) -> bool:
        if not isinstance(value, ast.Boolean):
            self.fail(span_of(value), f"{what} is true or false")
        return value.value

    def constant(
        self, value: ast.Expr, what: str, wanted: Dimension | None = None, declared: str = "", field: FieldType | None = None
    ) -> tuple[float, Dimension]:  # fmt: skip
        """A constant in SI with its dimension, which may be given, and with that the unit in which it is declared."""
        if isinstance(value, (ast.ListValue, ast.RecordValue)):
            self.fail(
                span_of(value),
                f"{what} is one value, not a {'list' if isinstance(value, ast.ListValue) else 'record'}",
            )
        if isinstance(value, ast.Number):  # mostly; one of another dimension is told of below
            number, dimension = self.expressions.literal(value)
            if wanted is None or dimension == wanted:
                self.meant.number(value, None, number)
                return number, dimension
        checked = self.expressions.number(value, self._ctx)
        if wanted is not None and checked.dimension != wanted:
            problem = f"{what} is {quantity(wanted)}, not {quantity(checked.dimension)}"
            bare = checked.dimension == NUMBER
            things = () if bare or field is None else declaration(field.name, field, show(checked.dimension))
            self.fail(span_of(value), problem, unit_hint(checked, wanted, declared), declared=things)
        params = self.spec.params
        plain = typed.literal(checked)
        if plain is not None:
            self.meant.number(value, None, plain)
            return plain, checked.dimension
        core = self._lowering.number(checked)
        if any(isinstance(node, ir.Param) and node.name not in params for node in ir.below(core)):
            raise Poison  # a parameter whose declaration was reported
        found = constant_value(core, lambda qualified: params[qualified].value)
        if found is None:
            self.fail(span_of(value), "this depends on an input", "a test gives constants")
        self.meant.number(value, core, found)
        return found, checked.dimension


def index_of(text: str) -> int | None:
    """A whole number as written, or None."""
    number = float(text)
    return int(number) if math.isfinite(number) and number == int(number) else None


def special(value: ast.Expr) -> float | None:
    """`nan`, `inf`, `-inf`."""
    sign = 1.0
    if isinstance(value, ast.Unary) and value.op == "-":
        sign, value = -1.0, value.operand
    if isinstance(value, ast.Name) and value.name in ("nan", "inf"):
        return math.nan if value.name == "nan" else sign * math.inf
    return None


def declaration(name: str, field: FieldType, given: str) -> tuple[tuple[str, Span, str, str], ...]:
    """A field that is given in a unit of another dimension than it is declared in, as `DimensionMismatch` has it."""
    return ((name, field.span, quantity(parse_unit(field.unit)[2]), quantity(parse_shown(given))),)
