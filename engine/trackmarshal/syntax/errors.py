"""Errors of syntax."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class UnexpectedText(Diagnostic):
    code = "E101"
    title = "unexpected text"
    text = "unexpected {found}"
    label = "expected {expected}"
    remedy = "{hint}"
    explanation = (
        "The declaration cannot go on with this text. The message lists what could stand here. The parser starts afresh at the "
        "next declaration keyword in column 1, so other declarations are checked all the same."
    )

    span: Span
    found: str
    expected: str
    hint: str = ""


class UnexpectedEnd(Diagnostic):
    code = "E102"
    title = "the declaration is not finished"
    text = "the declaration ends too early"
    label = "expected {expected} after this"
    remedy = "{hint}"
    explanation = "The next declaration, or the end of the file, comes before this one is complete."

    span: Span
    expected: str
    hint: str = ""


class StrayText(Diagnostic):
    code = "E103"
    title = "this does not start a declaration"
    text = "{found} does not start a declaration"
    label = "{expected}"
    remedy = "{hint}"
    explanation = (
        "Declarations start with their keyword in column 1. Before the first one there may be comments only, and a line that "
        "reads `word name` in column 1 is taken for a declaration with a misspelt keyword. Continued lines are indented."
    )

    span: Span
    found: str
    expected: str
    hint: str = ""


class TooDeep(Diagnostic):
    code = "E104"
    title = "nested too deeply"
    text = "this expression is nested more than {limit} levels deep"
    label = "too deep"
    remedy = "name its parts with `let` or `define`"
    explanation = (
        "Deeply nested expressions cannot be read by people, and a bound keeps every pass predictable."
    )

    span: Span
    limit: int


class BadText(Diagnostic):
    code = "E105"
    title = "a string that cannot be read"
    text = "{problem}"
    label = "{pointed}"
    remedy = "{hint}"
    explanation = (
        'Strings stand on one line, between double quotes. Inside, a quote is written \\" and a backslash \\\\; there are no '
        "other escapes."
    )

    span: Span
    problem: str
    pointed: str
    hint: str = ""


class UnknownUnit(Diagnostic):
    code = "E106"
    title = "unknown unit"
    text = "unknown {what} `{unit}`"
    label = "not a unit"
    remedy = "{hint}"
    explanation = (
        "Units are a closed list: m, km, cm, mm, s, ms, us, min, h, kg, t, N, kN, J, W, kW, Hz, rad, deg, %, each with an exponent "
        "if need be, and quotients of them without blanks (`5 m/s^2`). To divide a quantity by a name, put blanks around `/`."
    )

    span: Span
    what: str
    unit: str
    hint: str = ""


class UnknownClause(Diagnostic):
    code = "E107"
    title = "unknown clause"
    text = "unknown clause `{word}`"
    label = "no clause starts with this word"
    remedy = "{hint}"
    explanation = (
        "A line inside a declaration starts with a word that is almost, but not quite, the keyword of a clause. It is refused "
        "even where it could be read as the name of a predicate."
    )

    span: Span
    word: str
    hint: str


class Unclosed(Diagnostic):
    code = "E108"
    title = "a bracket that is not closed"
    text = "`{bracket}` is not closed"
    label = "opened here"
    other_label = "expected {expected} {where}"
    explanation = "Every (, [ and { has its closing counterpart in the same clause."

    span: Span
    bracket: str
    expected: str
    where: str
    other: Span


class MixedChain(Diagnostic):
    code = "E109"
    title = "comparisons in a row that lead different ways"
    text = "`{op}` cannot follow `{first}`"
    label = "breaks the row"
    other_label = "which begins here"
    remedy = "only `<` and `<=`, or `>` and `>=`, stand in a row; else write `a {first} b and b {op} c`"
    explanation = (
        "`a <= b < c` means `a <= b and b < c`, and `a >= b > c` the same downwards. Of other comparisons in a row, people read different "
        "things into one text: whether `a < b > c` compares a and c, or `a == b == c` compares a formula with a number."
    )

    span: Span
    op: str
    first: str
    other: Span
