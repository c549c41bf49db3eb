"""Formulas as Typst's mathematics, for PDF. Everything that an author wrote stands in strings: nothing of it is code."""

from __future__ import annotations

from typing import assert_never

from trackmarshal.reading import layout as at
from trackmarshal.reading.breaking import STEP, broad, lines
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.units import factors

#: Letters on a line of a page of paper.
WIDTH = 78
#: Signs that mean something to Typst, and those that stretch.
_SIGNS = {
    ",": "comma",
    ":": "colon",
    "/": "slash",
    "#": '"#"',
    "(": "paren.l",
    ")": "paren.r",
    "[": "bracket.l",
    "]": "bracket.r",
}
_FENCES = {
    "(": ("paren.l", "paren.r"), "[": ("bracket.l", "bracket.r"), "{": ("brace.l", "brace.r"), "|": ("bar.v", "bar.v"),
    "⌊": ("floor.l", "floor.r"), "⌈": ("ceil.l", "ceil.r"),
}  # fmt: skip


def formula(piece: Layout, width: int = WIDTH) -> str:
    """A block of mathematics, `$ .. $`; what is wider than the width, in letters, has several lines."""
    made = lines(piece, width, broad)
    if len(made) == 1:
        return f"$ {beside(made[0].parts)} $"
    rows = " \\\n  ".join(f"& {_moved(line.indent)}{beside(line.parts)}" for line in made)
    return f"$ {rows} $"


def _moved(indent: int) -> str:
    return f"#h({0.6 * STEP * indent:g}em) " if indent else ""


def beside(parts: tuple[Layout, ...]) -> str:
    """Pieces beside each other."""
    return " ".join(
        f"med {content(part)} med" if isinstance(part, at.Word) else content(part) for part in parts
    )


def string(text: str) -> str:
    """A string of Typst, which is shown as it is."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def content(piece: Layout) -> str:
    """A piece, with nothing in it that its neighbours could be taken for a part of."""
    match piece:
        case at.Digits():
            return string(piece.text) + (f" thin {unit(piece.unit)}" if piece.unit else "")
        case at.Name():
            return (
                f"italic({string(piece.text)})" if len(piece.text) == 1 else f"upright({string(piece.text)})"
            )
        case at.Word():
            return f"upright({string(piece.text)})"
        case at.Sign():
            return _SIGNS.get(piece.text) or string_sign(piece.text)
        case at.Row():
            return " ".join(map(content, piece.parts))
        case at.Index():
            return f"attach({content(piece.base)}, b: {_one(piece.index)})"
        case at.Power():
            return f"attach({content(piece.base)}, t: {_one(piece.exponent)})"
        case at.Fraction():
            return f"frac({_one(piece.over)}, {_one(piece.under)})"
        case at.Root():
            return f"sqrt({_one(piece.inside)})"
        case at.Fence():
            return _fenced(piece.opening, content(piece.inside))
        case at.Call():
            if not piece.arguments:
                return content(piece.head)
            return content(piece.head) + " " + _fenced("(", " comma ".join(map(content, piece.arguments)))
        case at.Prefix():
            space = " " if isinstance(piece.sign, at.Sign) else " thin "
            return f"{content(piece.sign)}{space}{content(piece.operand)}"
        case at.Chain():
            return content(piece.first) + "".join(
                f" {_between(one.sign)} {content(one.operand)}" for one in piece.rest
            )
        case at.Binder():
            where = "" if piece.where is None else f' med upright("where") med {content(piece.where)}'
            return f"{content(piece.head)}{where} colon med {content(piece.body)}"
        case at.Fold():
            if piece.body is None:
                return f"{content(piece.head)} {_fenced('{', content(piece.range))}"
            return f"attach(limits({content(piece.head)}), b: {_one(piece.range)}) thin {content(piece.body)}"
        case at.Branches():
            rows = [_branch(one, "else if" if number else "if") for number, one in enumerate(piece.branches)]
            return f"cases({', '.join(rows)})"
        case _:
            assert_never(piece)


def string_sign(sign: str) -> str:
    """A sign that is one character of mathematics to Typst too, with its own spacing."""
    if len(sign) != 1:
        raise AssertionError(sign)
    return sign


def _one(piece: Layout) -> str:
    """A piece as one argument: a comma in it is no comma between arguments, as all of them are spelled out."""
    return content(piece)


def _fenced(opening: at.Opening, inside: str) -> str:
    left, right = _FENCES[opening]
    return f"lr({left} {inside} {right})"


def _between(sign: at.Sign | at.Word | at.Index) -> str:
    return content(sign) if isinstance(sign, at.Sign) else f"med {content(sign)} med"


def _branch(one: at.Branch, word: str) -> str:
    """A row of a choice; word: before its condition, as several may be so, and the first of them counts."""
    condition = 'upright("else")' if one.condition is None else f'upright("{word} ") {content(one.condition)}'
    return f"{content(one.value)} quad & {condition}"


def unit(text: str) -> str:
    """A unit, upright."""
    made = []
    for sign, name, exponent in factors(text):
        shown = f"upright({string(name)})"
        if exponent:
            shown = f"attach({shown}, t: {string(exponent)})"
        made.append({"": "", "/": 'class("normal", slash) ', "·": "dot.op "}[sign] + shown)
    return " ".join(made)
