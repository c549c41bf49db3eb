"""Errors in the tests that specs hold."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class BadGiven(Diagnostic):
    code = "E421"
    title = "a test that gives something impossible"
    text = "{problem}"
    other_label = "{about}"
    remedy = "{hint}"
    explanation = (
        "`given NAME = VALUE` gives a signal, an event, a parameter, a table or a place that the test's module can see: builders "
        "(arc, line, ...), records `{ field: value }`, lists, and `with column[index] = value` to change what a builder made. Values "
        "have the declared dimension. `after 3 s` begins the next cycle of a run, for rules that speak of more than one: signals and events may be given anew, "
        "parameters, tables and places stay. Every test of a rule has its own title."
    )

    span: Span
    problem: str
    hint: str = ""
    other: Span | None = None
    about: str = "declared here"
    others: tuple[Span, ...] = ()
    #: As of `DimensionMismatch`: what is declared in another dimension than is given.
    declared: tuple[tuple[str, Span, str, str], ...] = ()


class BadExpectation(Diagnostic):
    code = "E422"
    title = "a test that expects something impossible"
    text = "{problem}"
    remedy = "{hint}"
    explanation = (
        "`expect VERDICT` names satisfied, violated, undefined, inactive or open; `margin X` expects it exactly, `margin about X within Y` "
        "nearly, in a unit of the margin's dimension (0 needs none where a rule compares in several); `at NAME = INDEX` names the variable and the sample or object that decides."
    )

    span: Span
    problem: str
    hint: str = ""


class UnknownRuleOfTest(Diagnostic):
    code = "E423"
    title = "a test of something without a condition"
    text = "`{name}` has no condition to test"
    explanation = "An assumption without a `monitor` cannot be evaluated, so it cannot be tested."

    span: Span
    name: str
