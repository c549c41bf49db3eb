"""Errors of expressions: of the wrong kind, dimension or number, too large, or without a meaning over the run."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.source import Span


class WrongArity(Diagnostic):
    code = "E209"
    title = "wrong number of arguments"
    text = "`{name}` takes {wanted}; {given}"
    label = "{given}"
    other_label = "declared here"
    remedy = "{hint}"
    explanation = "The number of arguments differs from the number of parameters of the definition or the built-in function."

    span: Span
    name: str
    wanted: str
    given: str
    other: Span | None = None
    hint: str = ""


class WrongKind(Diagnostic):
    code = "E211"
    title = "the wrong kind of thing"
    text = "expected {wanted}, found {found}"
    label = "this is {found}"
    remedy = "{hint}"
    explanation = "Numbers, formulas, records, regions and lines are different kinds of values; each place takes one of them."

    span: Span
    wanted: str
    found: str
    hint: str = ""


class CaseProblem(Diagnostic):
    code = "E248"
    title = "a case that does not say what holds for each member"
    text = "{problem}"
    other_label = "it is here already"
    remedy = "{hint}"
    explanation = (
        "A `case` has a value for each member of the enumeration, once: by name, or by `else` for all that are not named. Whoever adds a member "
        "is shown every `case` that does not say yet what it means there; an `else` says that no further member could matter."
    )

    span: Span
    problem: str
    hint: str = ""
    other: Span | None = None


class DimensionMismatch(Diagnostic):
    code = "E301"
    title = "dimensions do not match"
    text = "cannot {action} {left} and {right}"
    label = "this is {left}"
    other_label = "this is {right}"
    remedy = "{hint}"
    explanation = (
        "Every quantity has a dimension over metre, second and kilogram (an angle is a plain number). Only equal dimensions can be "
        "compared, added or chosen between. The check happens once, when the spec is compiled; it costs nothing at run time."
    )

    span: Span
    other: Span
    action: str
    left: str
    right: str
    hint: str = ""
    others: tuple[Span, ...] = ()
    #: What is declared, on either side: its name, where, as what, and what it meets.
    declared: tuple[tuple[str, Span, str, str], ...] = ()


class WrongDimension(Diagnostic):
    code = "E302"
    title = "the wrong dimension"
    text = "{what} must be {wanted}, not {found}"
    label = "this is {found}"
    other_label = "{wanted} is declared here"
    remedy = "{hint}"
    explanation = "The place has a declared dimension, and the value has another one."

    span: Span
    other: Span | None
    what: str
    wanted: str
    found: str
    hint: str = ""


class BadValue(Diagnostic):
    code = "E306"
    title = "a value that cannot stand here"
    text = "{problem}"
    other_label = "{about}"
    remedy = "{hint}"
    explanation = (
        "Numbers are finite, parameters lie inside their range, ranges run from low to high, table knots ascend, windows of temporal "
        "operators are constant, not negative and run from low to high, exponents of quantities with a dimension are whole numbers."
    )

    span: Span
    problem: str
    other: Span | None = None
    hint: str = ""
    about: str = "the range is declared here"


class Recursive(Diagnostic):
    code = "E212"
    title = "a definition that needs itself"
    text = "`{name}` is defined by itself"
    label = "{cycle}"
    remedy = "{how}"
    explanation = "Definitions are written out where they are used, so that every evaluation is bounded; recursion has no bound."

    span: Span
    name: str
    cycle: str
    how: str = "write it out without itself"


class TooLarge(Diagnostic):
    code = "E221"
    title = "a formula that is too large"
    text = "written out, this is {size}"
    remedy = "{hint}"
    explanation = (
        "Definitions are written out where they are used. A chain of definitions of which each uses the one before twice doubles with "
        "every link; a bound keeps every pass and every evaluation predictable."
    )

    span: Span
    size: str
    hint: str = "let fewer definitions build on each other"


class OverRunProblem(Diagnostic):
    code = "E223"
    title = "a formula over the run that has no meaning"
    text = "{problem}"
    remedy = "{hint}"
    explanation = (
        "Temporal operators in a rule without `along SIGNAL as NAME` range over the run, cycle by cycle. What they speak of has to be there in "
        "every cycle: the elements of a set have ids, by which they are known again; the samples of a trajectory have none. Whatever they say "
        "about a cycle has to be decided some time: operators that look ahead have a bound."
    )

    span: Span
    problem: str
    hint: str = ""
