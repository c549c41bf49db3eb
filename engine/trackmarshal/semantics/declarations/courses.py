"""Courses: timelines of what was driven and what is planned."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, NoReturn

from trackmarshal import typed
from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.ir.spec import COURSE, CourseInfo, FieldType, SignalType
from trackmarshal.semantics.errors.declarations import CourseProblem, SignalConflict
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.temporal import bound
from trackmarshal.semantics.overrun import LONGEST
from trackmarshal.semantics.values import spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import TIME, in_full, parse_unit

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


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
        hint = "rename it: in a course, `t` counts from now"
        _fail(x, item.lived.span, f"`{lived.name}` has a field `t` of its own", hint)
    fields = (time, *(field for field in shared if field.name != "t"))
    signal = SignalType(item.name, COURSE, False, fields, item.span)
    return CourseInfo(signal, lived.name, planned.name, nanoseconds(seconds))


def _record(name: ast.Name, x: Expressions, ctx: Context) -> SignalType:
    value = x.value(name, ctx)
    if not isinstance(value, typed.State):
        hint = "what was driven is a `state`, such as `ego`"
        _fail(x, name.span, f"{spoken(value)} is no record of a cycle", hint)
    return value.signal


def _trajectory(name: ast.Name, x: Expressions, ctx: Context) -> SignalType:
    value = x.value(name, ctx)
    if not isinstance(value, typed.Signal) or value.signal.kind != "trajectory" or value.signal.many:
        hint = "what is planned is a `trajectory`, such as `plan`"
        _fail(x, name.span, f"{spoken(value)} is no trajectory", hint)
    signal = value.signal
    if not has_time(signal):
        problem = f"`{name.name}` does not say when its samples are due"
        _fail(x, name.span, problem, "declare `t: s increasing`")
    return signal


def has_time(signal: SignalType) -> bool:
    """Whether a timeline has a column of times that the input contract holds to increase."""
    field = signal.field("t")
    return (
        field is not None
        and field.kind == "number"
        and field.increasing
        and parse_unit(field.unit)[2] == TIME
    )


def _agrees(field: FieldType, other: FieldType | None) -> bool:
    """Whether a field is one of both signals: of a kind and of a dimension, or of one enumeration."""
    if other is None or field.kind != other.kind or field.kind == "polyline":
        return False
    if field.enumeration != other.enumeration:
        return False
    return field.kind == "bool" or parse_unit(field.unit)[2] == parse_unit(other.unit)[2]


def _listed(signal: SignalType) -> str:
    return ", ".join(field.name for field in signal.fields_)


def _fail(x: Expressions, span: Span, problem: str, hint: str) -> NoReturn:
    x.fail(CourseProblem(span, problem, hint))
