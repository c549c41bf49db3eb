"""Formulas as one line of text for a terminal: fractions with a sign, roots as √( ), indices after an underscore."""

from __future__ import annotations

from typing import assert_never

from trackmarshal.reading import layout as at
from trackmarshal.reading.breaking import STEP, lines
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.units import factors

#: Signs with a space after them alone.
_BEFORE = ("∀", "∃")
#: Digits as exponents.
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
#: Signs without a space before them, and those without any.
_CLOSE = (",", ":")
_BARE = ("∑", "(", ")", "[", "]", "{", "}", "|", "⌊", "⌋", "⌈", "⌉")


def text(piece: Layout) -> str:
    """A piece as text that can be read in one way only."""
    match piece:
        case at.Digits():
            return f"{piece.text} {_unit(piece.unit)}" if piece.unit else piece.text
        case at.Name() | at.Word():
            return piece.text
        case at.Sign():
            return _sign(piece.text)
        case at.Row():
            return "".join(map(text, piece.parts))
        case at.Index():
            index = text(piece.index)
            small = (
                index
                if index.replace("_", "").replace(".", "").replace("′", "").isalnum()
                else f"{{{index}}}"
            )
            return (
                f"{text(piece.base)}_{small}"
                if not isinstance(piece.index, at.Fence)
                else f"{text(piece.base)}{index}"
            )
        case at.Power():
            exponent = text(piece.exponent)
            if exponent.lstrip("-").isdigit():
                return text(piece.base) + exponent.translate(_RAISED)
            return f"{text(piece.base)}^{_enclosed(piece.exponent, text(piece.exponent))}"
        case at.Fraction():
            return f"{_enclosed(piece.over, text(piece.over))}/{_enclosed(piece.under, text(piece.under))}"
        case at.Root():
            return f"√({text(piece.inside)})"
        case at.Fence():
            return f"{piece.opening}{text(piece.inside)}{at.CLOSING[piece.opening]}"
        case at.Call():
            given = ", ".join(map(text, piece.arguments))
            return f"{text(piece.head)}({given})" if piece.arguments else text(piece.head)
        case at.Prefix():
            space = "" if isinstance(piece.sign, at.Sign) else " "
            sign = piece.sign.text if isinstance(piece.sign, at.Sign) else text(piece.sign)
            operand = text(piece.operand)
            return (
                f"{sign}{space}({operand})"
                if isinstance(piece.operand, at.Fraction)
                else f"{sign}{space}{operand}"
            )
        case at.Chain():
            return text(piece.first) + "".join(_joined(one) for one in piece.rest)
        case at.Binder():
            where = "" if piece.where is None else f" where {text(piece.where)}"
            return f"{text(piece.head)}{where}: {text(piece.body)}"
        case at.Fold():
            head = piece.head.text
            below = (
                f"{head} {{{text(piece.range)}}}" if piece.body is None else f"{head}_{{{text(piece.range)}}}"
            )
            return below if piece.body is None else f"{below} {text(piece.body)}"
        case at.Branches():
            return " ".join(_branches(piece))
        case _:
            assert_never(piece)


def block(piece: Layout, width: int = 100, indent: int = 0) -> list[str]:
    """A piece on lines of a width, moved in by as many steps."""
    made = lines(piece, width - STEP * indent, lambda one: len(text(one)))
    return [" " * STEP * (indent + line.indent) + _beside(line.parts) for line in made]


def _beside(parts: tuple[Layout, ...]) -> str:
    """Pieces of a broken formula beside each other: one space between two words."""
    made = ""
    for part in parts:
        shown = text(part)
        if isinstance(part, at.Word):
            shown = f" {shown} " if made else f"{shown} "
        made += shown.lstrip() if made.endswith((" ", "(")) else shown
    return made.strip()


def _unit(unit: str) -> str:
    """`m/s²`."""
    return "".join(sign + name + exponent.translate(_RAISED) for sign, name, exponent in factors(unit))


def _sign(sign: str) -> str:
    if sign in _BARE:
        return sign
    if sign in _BEFORE:
        return f"{sign} "
    return f"{sign} " if sign in _CLOSE else f" {sign} "


def _joined(one: at.Joined) -> str:
    """A fraction after a product's sign is one thing: it stands in parentheses."""
    product = isinstance(one.sign, at.Sign) and one.sign.text == "·"
    operand = text(one.operand)
    shown = f"({operand})" if product and isinstance(one.operand, at.Fraction) else operand
    return f" {text(one.sign).strip()} {shown}"


def _enclosed(piece: Layout, shown: str) -> str:
    """A part of a fraction or an exponent: in parentheses where it has parts, as a number with a unit has: `(3 m)/s` is no speed."""
    match piece:
        case at.Digits() if piece.unit:
            return f"({shown})"
        case (
            at.Digits() | at.Name() | at.Word() | at.Index() | at.Power() | at.Root() | at.Fence() | at.Call()
        ):
            return shown
        case (
            at.Sign()
            | at.Row()
            | at.Fraction()
            | at.Prefix()
            | at.Chain()
            | at.Binder()
            | at.Fold()
            | at.Branches()
        ):
            return f"({shown})"
        case _:
            assert_never(piece)


def _branches(piece: at.Branches) -> list[str]:
    made = []
    for number, one in enumerate(piece.branches):
        if one.condition is None:
            made.append(f"else {text(one.value)}")
        else:
            made.append(f"{'else if' if number else 'if'} {text(one.condition)} then {text(one.value)}")
    return made
