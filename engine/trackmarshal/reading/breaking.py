"""Formulas that are wider than their place, on several lines: broken at signs and commas, never inside a term that fits.

Of a fraction or a root that is too wide, the one with a bar becomes the one with a sign: `( .. ) / ( .. )`, `sqrt( .. )`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias, assert_never

from trackmarshal.reading import layout as at
from trackmarshal.reading.layout import Layout, Line

#: How wide a piece is, in letters.
Measure: TypeAlias = Callable[[Layout], int]
#: Letters that a step to the right takes, and that a line has at least, however far to the right it begins.
STEP, LEAST = 2, 24


def lines(piece: Layout, width: int, measure: Measure) -> tuple[Line, ...]:
    """A piece on lines of a width, in letters, as far as it can be broken."""
    return tuple(_Breaking(width, measure).lines(piece, 0))


def broad(piece: Layout) -> int:
    """About how many letters wide a piece is where fractions have a bar and indices are small."""
    match piece:
        case at.Digits():
            return len(piece.text) + (len(piece.unit) + 1 if piece.unit else 0)
        case at.Name() | at.Word():
            return len(piece.text)
        case at.Sign():
            return len(piece.text) + 2
        case at.Row():
            return sum(map(broad, piece.parts))
        case at.Index():
            return broad(piece.base) + _small(broad(piece.index))
        case at.Power():
            return broad(piece.base) + _small(broad(piece.exponent))
        case at.Fraction():
            return max(broad(piece.over), broad(piece.under)) + 1
        case at.Root():
            return broad(piece.inside) + 2
        case at.Fence():
            return broad(piece.inside) + 2
        case at.Call():
            return broad(piece.head) + sum(broad(one) + 2 for one in piece.arguments)
        case at.Prefix():
            return broad(piece.sign) + broad(piece.operand)
        case at.Chain():
            return broad(piece.first) + sum(_between(one.sign) + broad(one.operand) for one in piece.rest)
        case at.Binder():
            where = 0 if piece.where is None else broad(piece.where) + 7
            return broad(piece.head) + where + 2 + broad(piece.body)
        case at.Fold():
            if piece.body is None:
                return broad(piece.head) + 2 + broad(piece.range)
            return max(broad(piece.head), _small(broad(piece.range))) + 1 + broad(piece.body)
        case at.Branches():
            return 2 + max(
                broad(one.value) + 4 + (6 if one.condition is None else broad(one.condition))
                for one in piece.branches
            )
        case _:
            assert_never(piece)


def _between(sign: at.Sign | at.Word | at.Index) -> int:
    """A sign with the room around it, which a product has little of."""
    return (
        broad(sign)
        if isinstance(sign, at.Sign) and sign.text != "·"
        else 2
        if isinstance(sign, at.Sign)
        else broad(sign) + 2
    )


def _small(letters: int) -> int:
    return -(-letters * 2 // 3)


def _with_sign(piece: Layout) -> Layout:
    """A fraction whose bar would be too wide."""
    assert isinstance(piece, at.Fraction)
    over, under = at.Fence("(", piece.over), at.Fence("(", piece.under)
    return at.Chain(over, (at.Joined(at.Sign("/"), under),))


class _Breaking:
    def __init__(self, width: int, measure: Measure) -> None:
        self._width = width
        self._measure = measure

    def _fits(self, piece: Layout, indent: int, more: int = 0) -> bool:
        return self._measure(piece) + more <= max(self._width - STEP * indent, LEAST)

    def lines(self, piece: Layout, indent: int) -> list[Line]:
        if self._fits(piece, indent):
            return [Line(indent, (piece,))]
        match piece:
            case at.Digits() | at.Name() | at.Word() | at.Sign() | at.Index():
                return [Line(indent, (piece,))]
            case at.Chain():
                return self._chain(piece, indent)
            case at.Row():
                made = self.lines(piece.parts[0], indent)
                for part in piece.parts[1:]:
                    made = self._after(made, part)
                return made
            case at.Fence():
                return self._fenced(
                    (at.Sign(piece.opening),), (piece.inside,), at.CLOSING[piece.opening], indent
                )
            case at.Call():
                if not piece.arguments:
                    return [Line(indent, (piece,))]
                return self._fenced((piece.head, at.Sign("(")), piece.arguments, ")", indent)
            case at.Fraction():
                return self.lines(at.Fence("(", _with_sign(piece)), indent)
            case at.Root():
                return self.lines(at.Call(at.Word("sqrt"), (piece.inside,)), indent)
            case at.Power():
                *others, last = self.lines(piece.base, indent)
                raised = at.Power(last.parts[-1], piece.exponent)
                return [*others, Line(last.indent, (*last.parts[:-1], raised))]
            case at.Prefix():
                return self._before((piece.sign,), self.lines(piece.operand, indent))
            case at.Binder():
                return self._binder(piece, indent)
            case at.Fold():
                return self._fold(piece, indent)
            case at.Branches():
                return self._branches(piece, indent)
            case _:
                assert_never(piece)

    def _before(self, parts: Sequence[Layout], made: list[Line]) -> list[Line]:
        return [Line(made[0].indent, (*parts, *made[0].parts)), *made[1:]]

    def _after(self, made: list[Line], part: Layout) -> list[Line]:
        """Lines, and a part after the last of them, or below it."""
        last = made[-1]
        used = sum(map(self._measure, last.parts))
        if self._fits(part, last.indent, used + 1):
            return [*made[:-1], Line(last.indent, (*last.parts, part))]
        return [*made, *self.lines(part, made[0].indent + 1)]

    def _chain(self, piece: at.Chain, indent: int) -> list[Line]:
        """Terms fill lines; formulas have a line each. A sign stands before what it joins."""
        made = self.lines(piece.first, indent)
        for one in piece.rest:
            last, joined = made[-1], (one.sign, one.operand)
            used = sum(map(self._measure, last.parts)) + sum(map(self._measure, joined)) + 2
            if not piece.logic and used <= max(self._width - STEP * last.indent, LEAST):
                made[-1] = Line(last.indent, (*last.parts, *joined))
            else:
                made += self._before((one.sign,), self.lines(one.operand, indent + 1))
        return made

    def _fenced(
        self, before: Sequence[Layout], inside: Sequence[Layout], closing: at.Closing, indent: int
    ) -> list[Line]:
        """What stands in parentheses begins on a line of its own, further to the right. What fits on a line stands beside others there."""
        made = [Line(indent, tuple(before))]
        filling = False
        for number, part in enumerate(inside):
            comma = (at.Sign(","),) if number < len(inside) - 1 else ()
            fits = self._fits(part, indent + 1, 2 * len(comma))
            last = made[-1]
            if fits and filling and self._fits(at.Row((*last.parts, part, *comma)), indent + 1):
                made[-1] = Line(last.indent, (*last.parts, part, *comma))
                continue
            wide = isinstance(part, at.Fraction) and not self._fits(part, indent + 1)
            below = self.lines(_with_sign(part) if wide else part, indent + 1)
            below[-1] = Line(below[-1].indent, (*below[-1].parts, *comma))
            made += below
            filling = fits
        return [*made, Line(indent, (at.Sign(closing),))]

    def _binder(self, piece: at.Binder, indent: int) -> list[Line]:
        colon = at.Sign(":")
        whole = piece.head if piece.where is None else at.Row((piece.head, at.Word(" where "), piece.where))
        if self._fits(whole, indent, 2):
            head = [Line(indent, (whole, colon))]
        elif piece.where is None:
            head = [Line(indent, (piece.head, colon))]
        else:
            head = [Line(indent, (piece.head, at.Word("where")))]
            where = self.lines(piece.where, indent + 2)
            where[-1] = Line(where[-1].indent, (*where[-1].parts, colon))
            head += where
        return [*head, *self.lines(piece.body, indent + 1)]

    def _fold(self, piece: at.Fold, indent: int) -> list[Line]:
        if piece.body is None:
            return self._fenced((piece.head, at.Sign("{")), (piece.range,), "}", indent)
        inside = at.Chain(piece.body, (at.Joined(at.Word("for"), piece.range),), True)
        return self._fenced((piece.head, at.Sign("(")), (inside,), ")", indent)

    def _branches(self, piece: at.Branches, indent: int) -> list[Line]:
        """`if c then a else b`, in words."""
        made: list[Line] = []
        for number, one in enumerate(piece.branches):
            if one.condition is None:
                made.append(Line(indent, (at.Word("else"),)))
            else:
                opening = at.Word("else if" if number else "if")
                condition = self._before((opening,), self.lines(one.condition, indent))
                condition[-1] = Line(condition[-1].indent, (*condition[-1].parts, at.Word("then")))
                made += condition
            made += self.lines(one.value, indent + 1)
        return made
