"""Formulas as MathML Core, for HTML: no script, no style that it cannot do without."""

from __future__ import annotations

from html import escape
from typing import assert_never

from trackmarshal.reading import layout as at
from trackmarshal.reading.breaking import broad, lines
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.units import factors

#: Letters on a line, where a page is as wide as paper.
WIDTH = 96
#: What a function's name and its arguments are joined by, unseen.
_APPLY = "<mo>&#x2061;</mo>"
_THIN = '<mspace width="0.18em"></mspace>'
#: Signs that a name follows.
_BEFORE = ("∀", "∃")
#: Parentheses that stand alone where a formula is broken.
_FENCES = "()[]{}|⌊⌋⌈⌉"
_SPACE = '<mspace width="0.28em"></mspace>'


def formula(piece: Layout, width: int = WIDTH, display: bool = True) -> str:
    """A `math` element; what is wider than the width, in letters, has several lines."""
    made = lines(piece, width, broad)
    if len(made) == 1:
        inside = row(made[0].parts)
    else:
        rows = "".join(
            f'<mtr><mtd style="text-align: left; padding-left: {1.2 * line.indent:g}em"><mrow displaystyle="true">{row(line.parts)}</mrow></mtd></mtr>' for line in made
        )  # fmt: skip
        inside = f'<mtable class="lines">{rows}</mtable>'
    return f'<math display="{"block" if display else "inline"}">{inside}</math>'


def row(parts: tuple[Layout, ...]) -> str:
    """Pieces beside each other."""
    return f"<mrow>{''.join(_spaced(part) for part in parts)}</mrow>"


def _spaced(piece: Layout) -> str:
    """A word between others has room on both sides."""
    return f"{_SPACE}{element(piece)}{_SPACE}" if isinstance(piece, at.Word) else element(piece)


def element(piece: Layout) -> str:
    """One element for a piece."""
    match piece:
        case at.Digits():
            return _digits(piece)
        case at.Name():
            return f"<mi>{escape(piece.text)}</mi>"
        case at.Word():
            return f"<mtext>{_text(piece.text)}</mtext>"
        case at.Sign():
            alone = ' stretchy="false"' if piece.text in _FENCES else ""  # what it holds is on other lines
            sign = f"<mo{alone}>{escape(piece.text)}</mo>"
            return f"{sign}{_THIN}" if piece.text in _BEFORE else sign
        case at.Row():
            return f"<mrow>{''.join(map(element, piece.parts))}</mrow>"
        case at.Index():
            return f"<msub>{element(piece.base)}{element(piece.index)}</msub>"
        case at.Power():
            return f"<msup>{element(piece.base)}{element(piece.exponent)}</msup>"
        case at.Fraction():
            return f"<mfrac>{element(piece.over)}{element(piece.under)}</mfrac>"
        case at.Root():
            return f"<msqrt>{element(piece.inside)}</msqrt>"
        case at.Fence():
            return _fenced(
                piece.opening, element(piece.inside), at.CLOSING[piece.opening], _tall(piece.inside)
            )
        case at.Call():
            if not piece.arguments:
                return element(piece.head)
            given = "<mo>,</mo>".join(map(element, piece.arguments))
            tall = any(map(_tall, piece.arguments))
            return f"<mrow>{_head(piece.head)}{_APPLY}{_fenced('(', given, ')', tall)}</mrow>"
        case at.Prefix():
            space = "" if isinstance(piece.sign, at.Sign) else _SPACE
            sign = (
                f'<mo form="prefix">{escape(piece.sign.text)}</mo>'
                if isinstance(piece.sign, at.Sign)
                else element(piece.sign)
            )
            return f"<mrow>{sign}{space}{element(piece.operand)}</mrow>"
        case at.Chain():
            rest = "".join(f"{_between(one.sign)}{element(one.operand)}" for one in piece.rest)
            return f"<mrow>{element(piece.first)}{rest}</mrow>"
        case at.Binder():
            where = (
                "" if piece.where is None else f"{_SPACE}<mtext>where</mtext>{_SPACE}{element(piece.where)}"
            )
            return f"<mrow>{element(piece.head)}{where}<mo>:</mo>{element(piece.body)}</mrow>"
        case at.Fold():
            if piece.body is None:
                return f"<mrow>{element(piece.head)}{_fenced('{', element(piece.range), '}', _tall(piece.range))}</mrow>"
            return f"<mrow><munder>{element(piece.head)}{element(piece.range)}</munder>{_SPACE}{element(piece.body)}</mrow>"
        case at.Branches():
            return _branches(piece)
        case _:
            assert_never(piece)


def _digits(piece: at.Digits) -> str:
    number = f"<mn>{escape(piece.text)}</mn>"
    if not piece.unit:
        return number
    return f"<mrow>{number}{_THIN}{unit(piece.unit)}</mrow>"


def unit(text: str) -> str:
    """A unit, upright."""
    made = ""
    for sign, name, exponent in factors(text):
        shown = f'<mi mathvariant="normal">{escape(name)}</mi>'
        if exponent:
            shown = f"<msup>{shown}<mn>{escape(exponent)}</mn></msup>"
        made += f'<mo lspace="0" rspace="0">{escape(sign)}</mo>{shown}' if sign else shown
    return f'<mrow class="unit">{made}</mrow>'


def _head(piece: Layout) -> str:
    """The name of a function: an identifier, whatever it is called by."""
    return f"<mi>{escape(piece.text)}</mi>" if isinstance(piece, at.Word) else element(piece)


def _fenced(opening: str, inside: str, closing: str, tall: bool) -> str:
    """Parentheses grow with what is tall: with indices alone, fonts without mathematics would make them twice as high as the line."""
    grows = "" if tall else ' stretchy="false"'
    return f'<mrow><mo form="prefix"{grows}>{opening}</mo>{inside}<mo form="postfix"{grows}>{closing}</mo></mrow>'


def _tall(piece: Layout) -> bool:
    """Whether something in a piece takes more than a line."""
    return any(isinstance(part, at.Fraction | at.Branches | at.Fold) for part in (piece, *piece.walk()))


def _between(sign: at.Sign | at.Word | at.Index) -> str:
    return element(sign) if isinstance(sign, at.Sign) else f"{_SPACE}{element(sign)}{_SPACE}"


def _branches(piece: at.Branches) -> str:
    rows = ""
    for number, one in enumerate(piece.branches):
        word = "else if" if number else "if"  # several may be so, and the first of them counts
        when = (
            "<mtext>else</mtext>"
            if one.condition is None
            else f"<mrow><mtext>{_text(word)}&#xa0;</mtext>{element(one.condition)}</mrow>"
        )
        rows += (
            f'<mtr><mtd style="text-align: left">{element(one.value)}</mtd>'
            f'<mtd style="text-align: left; padding-left: 1em">{when}</mtd></mtr>'
        )
    return f'<mrow><mo form="prefix" stretchy="true">{{</mo><mtable class="cases">{rows}</mtable></mrow>'


def _text(text: str) -> str:
    """Spaces at the ends of a text are dropped where they are not made hard."""
    return escape(text).replace(" ", "&#xa0;")
