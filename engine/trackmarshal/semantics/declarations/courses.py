"""Courses: timelines of what was driven and what is planned, and where along a timeline rules are judged."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, NoReturn, get_args

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir.nodes import JudgedAt
from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.ir.spec import COURSE, CourseInfo, FieldType, SignalType
from trackmarshal.semantics.errors.declarations import CourseProblem, SignalConflict
from trackmarshal.semantics.errors.rules import JudgedNowhere
from trackmarshal.semantics.expressions.temporal import bound
from trackmarshal.semantics.expressions.values import spoken
from trackmarshal.semantics.overrun import LONGEST
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import TIME, in_full, parse_unit

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Context, Expressions

#: The words for where a rule is judged.
_PLACES: tuple[JudgedAt, ...] = get_args(JudgedAt)


def check_course(item: ast.Course, x: Expressions, ctx: Context) -> None:
    """Declare a course; what a module declares anew is the same as what another one says."""
    made = _made(item, x, ctx)
    known = x.courses.setdefault(item.name, made)
    own = ctx.scope.own[item.name].item is item
    if own and (known.lived, known.planned, known.back) != (made.lived, made.planned, made.back):
        x.fail(SignalConflict(item.span.head, known.signal.span.head, item.name))
    if item.name in x.signals:
        x.fail(SignalConflict(item.span.head, x.signals[item.name].span.head, item.name))


def _made(item: ast.Course, x: Expressions, ctx: Context) -> CourseInfo:
    lived, planned, (number, seconds) = x.all(
        partial(_record, item.lived, x, ctx),
        partial(_trajectory, item.planned, x, ctx),
        lambda: bound(item.bound, x, ctx),
    )
    if seconds <= 0.0 or nanoseconds(seconds) > LONGEST:
        problem = (
            f"a course goes back for some time, and a thousand hours at most, not for {in_full(seconds, 's')}"
        )
        _fail(x, number.span, problem, "write how much of what was driven counts: `for 10 s`")
    time = planned.field("t")
    assert time is not None
    shared = [field for field in planned.fields_ if _agrees(field, lived.field(field.name))]
    if not shared:
        hint = f"`{lived.name}` has {_listed(lived)}; `{planned.name}` has {_listed(planned)}"
        _fail(x, item.span.head, f"`{lived.name}` and `{planned.name}` have no field in common", hint)
    other = [field for field in lived.fields_ if field.name == "t"]
    if other:
        _fail(
            x,
            item.lived.span,
            f"`{lived.name}` has a field `t` of its own",
            "rename it: in a course, `t` counts from now",
        )
    fields = (time, *(field for field in shared if field.name != "t"))
    signal = SignalType(item.name, COURSE, False, fields, item.span)
    return CourseInfo(signal, lived.name, planned.name, nanoseconds(seconds))


def _record(name: ast.Name, x: Expressions, ctx: Context) -> SignalType:
    value = x.value(name, ctx)
    if not isinstance(value, typed.State):
        _fail(
            x,
            name.span,
            f"{spoken(value)} is no record of a cycle",
            "what was driven is a `state`, such as `ego`",
        )
    return value.signal


def _trajectory(name: ast.Name, x: Expressions, ctx: Context) -> SignalType:
    value = x.value(name, ctx)
    if not isinstance(value, typed.Signal) or value.signal.kind != "trajectory" or value.signal.many:
        _fail(
            x,
            name.span,
            f"{spoken(value)} is no trajectory",
            "what is planned is a `trajectory`, such as `plan`",
        )
    signal = value.signal
    field = signal.field("t")
    if field is None or field.kind != "number" or not field.increasing or parse_unit(field.unit)[2] != TIME:
        _fail(
            x, name.span, f"`{name.name}` does not say when its samples are due", "declare `t: s increasing`"
        )
    return signal


def _agrees(field: FieldType, other: FieldType | None) -> bool:
    """Whether a field is one of both signals: of a kind and of a dimension, or of one enumeration."""
    if other is None or field.kind != other.kind or field.kind == "polyline":
        return False
    if field.enumeration != other.enumeration:
        return False
    return field.kind == "bool" or parse_unit(field.unit)[2] == parse_unit(other.unit)[2]


def _listed(signal: SignalType) -> str:
    return ", ".join(field.name for field in signal.fields_)


def judged_at(clause: ast.Along, signal: SignalType, x: Expressions) -> JudgedAt:
    """At which sample of its timeline a rule is judged."""
    course = signal.kind == COURSE
    if clause.at is None:
        return "now" if course else "first"
    word = next((word for word in _PLACES if word == clause.at.name), None)
    if word is None:
        hint = close_matches(clause.at.name, _PLACES) or f"write {', '.join(_PLACES[:-1])} or {_PLACES[-1]}"
        x.fail(JudgedNowhere(clause.at.span, f"no rule is judged at `{clause.at.name}`", hint))
    if word == "now" and not course:
        hint = "judge it at the first sample, which needs no word, or declare a `course`"
        x.fail(JudgedNowhere(clause.at.span, f"no sample of `{signal.name}` is the one that is now", hint))
    if word == "first" and course:
        hint = "judge it at the sample that is now, which needs no word, or at the last one"
        x.fail(
            JudgedNowhere(clause.at.span, f"where `{signal.name}` begins is moving on with every cycle", hint)
        )
    return word


def _fail(x: Expressions, span: Span, problem: str, hint: str) -> NoReturn:
    x.fail(CourseProblem(span, problem, hint))
