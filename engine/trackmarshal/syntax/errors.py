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
    label = "expected {expected}"
    explanation = "The next declaration, or the end of the file, comes before this one is complete."

    span: Span
    expected: str


class StrayText(Diagnostic):
    code = "E103"
    title = "text before the first declaration"
    text = "`{word}` does not start a declaration"
    label = "a declaration starts with its keyword in column 1"
    remedy = "{hint}"
    explanation = "Before the first declaration there may be comments only. Declarations start with their keyword in column 1."

    span: Span
    word: str
    hint: str = ""


class TooDeep(Diagnostic):
    code = "E104"
    title = "nested too deeply"
    text = "this expression is nested more than {limit} levels deep"
    label = "too deep"
    remedy = "name its parts with `let` or `define`"
    explanation = "Deeply nested expressions cannot be read by people, and a bound keeps every pass predictable."

    span: Span
    limit: int


class BadText(Diagnostic):
    code = "E105"
    title = "a string that does not end"
    text = "this string does not end on its line"
    label = "starts here"
    remedy = 'close it with "; inside a string, write \\" for a quote'
    explanation = "Strings stand on one line, between double quotes."

    span: Span
