"""Expressions of sympy as layouts. What a rule says is never printed this way: sympy orders terms as it likes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from trackmarshal.reading import layout as at
from trackmarshal.reading.formulas import PRODUCT, RAISED, SIGNED, SUM, WHOLE
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.solving.algebra import Unsolvable

if TYPE_CHECKING:
    from sympy import Expr, Symbol


def printed(made: Expr, shown: Mapping[Symbol, Layout]) -> Layout:
    """An expression; shown: its symbols. Raises Unsolvable for what sympy wrote that no rule could say, such as a choice between cases."""
    return _Printing(shown).at(made, 0)


class _Printing:
    def __init__(self, shown: Mapping[Symbol, Layout]) -> None:
        self._shown = shown

    def at(self, made: Expr, least: int) -> Layout:
        piece, level = self._piece(made)
        return piece if level >= least else at.Fence("(", piece)

    def _piece(self, made: Expr) -> tuple[Layout, int]:
        import sympy

        if isinstance(made, sympy.Symbol):
            return self._shown[made], WHOLE
        if made.is_Number or made is sympy.pi:
            return self._number(made)
        if isinstance(made, sympy.Abs):
            return at.Fence("|", self.at(made.args[0], 0)), WHOLE
        if isinstance(made, sympy.floor):
            return at.Fence("⌊", self.at(made.args[0], 0)), WHOLE
        if made is sympy.E:
            return at.Call(at.Word("exp"), (at.Digits("1"),)), WHOLE
        if isinstance(made, sympy.Add):
            return self._sum(made)
        numerator, denominator = sympy.fraction(made)
        if denominator != 1:
            if isinstance(-numerator, sympy.Add):  # its terms as they are, those with a minus last
                numerator = sympy.Add(*[sympy.Mul(-1, one) for one in (-numerator).args])
            negative = numerator.could_extract_minus_sign() and not isinstance(numerator, sympy.Add)
            over = self.at(-numerator if negative else numerator, 0)
            fraction = at.Fraction(over, self.at(denominator, 0))
            return (at.Prefix(at.Sign("−"), fraction), SIGNED) if negative else (fraction, RAISED)
        if isinstance(made, sympy.Mul):
            return self._product(made)
        if isinstance(made, sympy.Pow):
            return self._power(made)
        for kind, name in (
            (sympy.Min, "min"),
            (sympy.Max, "max"),
            (sympy.sin, "sin"),
            (sympy.cos, "cos"),
            (sympy.tan, "tan"),
            (sympy.asin, "asin"),
            (sympy.acos, "acos"),
            (sympy.atan2, "atan2"),
            (sympy.tanh, "tanh"),
            (sympy.exp, "exp"),
            (sympy.log, "log"),
            (sympy.sign, "sign"),
        ):
            if isinstance(made, kind):
                return at.Call(at.Word(name), tuple(self.at(one, 0) for one in made.args)), WHOLE
        raise Unsolvable("function")

    def _number(self, made: Expr) -> tuple[Layout, int]:
        import sympy

        if made is sympy.pi:
            return at.Name("π"), WHOLE
        if made < 0:
            return at.Prefix(at.Sign("−"), self.at(-made, RAISED)), SIGNED
        if made.is_Integer:
            return at.Digits(str(made)), WHOLE
        for decimal in (f"{float(made):.15g}", repr(float(made))):
            if sympy.Rational(decimal) == made:
                return at.Digits(decimal), WHOLE
        return at.Fraction(at.Digits(str(made.p)), at.Digits(str(made.q))), RAISED

    def _sum(self, made: Expr) -> tuple[Layout, int]:
        terms = sorted(made.as_ordered_terms(), key=lambda one: bool(one.could_extract_minus_sign()))
        first, *others = terms
        rest = []
        for term in others:
            negative = term.could_extract_minus_sign()
            rest.append(
                at.Joined(at.Sign("−" if negative else "+"), self.at(-term if negative else term, PRODUCT))
            )
        return at.Chain(self.at(first, SUM), tuple(rest)), SUM

    def _product(self, made: Expr) -> tuple[Layout, int]:
        import sympy

        if isinstance(-made, sympy.Add):
            return self._sum(sympy.Add(*[sympy.Mul(-1, one) for one in (-made).args]))
        if made.could_extract_minus_sign():
            return at.Prefix(at.Sign("−"), self.at(-made, PRODUCT)), SIGNED
        first, *others = made.as_ordered_factors()
        rest = tuple(at.Joined(at.Sign("·"), self.at(one, RAISED)) for one in others)
        return at.Chain(self.at(first, PRODUCT), rest), PRODUCT

    def _power(self, made: Expr) -> tuple[Layout, int]:
        import sympy

        if made.exp == sympy.Rational(1, 2):
            return at.Root(self.at(made.base, 0)), WHOLE
        if made.exp.is_Integer:
            return at.Power(self.at(made.base, WHOLE), at.Digits(str(made.exp))), RAISED
        if made.exp.is_Rational:  # of a root of a root, or of a power of one
            exponent = at.Fraction(at.Digits(str(made.exp.p)), at.Digits(str(made.exp.q)))
            return at.Power(self.at(made.base, WHOLE), exponent), RAISED
        raise Unsolvable("exponent")
