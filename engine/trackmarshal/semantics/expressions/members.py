"""Members of enumerations: what is asked of them, and `case`, which has a value for each of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir.spec import Enumeration
from trackmarshal.semantics.errors.expressions import CaseProblem, WrongKind
from trackmarshal.semantics.errors.names import Hides, UnknownMember
from trackmarshal.semantics.expressions import machines
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import same
from trackmarshal.semantics.values import common, member_spoken, spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast

if TYPE_CHECKING:
    from trackmarshal.diagnostics.base import Diagnostic
    from trackmarshal.semantics.expressions.checking import Expressions


def unknown(enumeration: Enumeration, name: str, span: Span) -> UnknownMember:
    """What is said of a word that is no member."""
    known = ", ".join(enumeration.members)
    if name in ("default", "otherwise"):
        return UnknownMember(
            span, enumeration.name.rpartition(".")[2], name, known, "write `else: ...` for all others"
        )
    hint = close_matches(name, enumeration.members) or f"its members are {known}"
    return UnknownMember(span, enumeration.name.rpartition(".")[2], name, known, hint)


def hint(value: typed.AnyMember, asked_for: str = "", op: str = "==") -> str:
    """What to write in place of a member that stands where a number or a formula belongs, or is compared with a word."""
    written = value.span.in_line
    members = value.enumeration.members
    asks = f"{written} is {asked_for if asked_for in members else members[0]}"
    return (
        f"ask for a member: `{asks}`"
        if op in ("==", "<", "<=", ">", ">=")
        else f"ask for a member: `not ({asks})`"
    )


def asked(expr: ast.Infix, x: Expressions, ctx: Context) -> typed.Formula:
    """`race.flag is yellow`, `a.lane is b.lane`; or `role(o) is offence`, of a state."""
    left, truth = expr.left, isinstance(expr.right, ast.Boolean)
    named = isinstance(left, ast.Call) or (isinstance(left, ast.Name) and left.name not in ctx.local)
    if named and (not truth or machines.names_machine(left, ctx)):
        return machines.in_state(expr, x, ctx)
    value = x.value(left, ctx)
    if not isinstance(value, typed.MemberNode):
        wanted, span = "a state, or a field of an enumeration", left.__dict__["span"]
        x.fail(WrongKind(span, wanted, spoken(value), _otherwise(value, expr.right)))
    return typed.IsMember(value, _other(expr.right, value.enumeration, x, ctx), expr.span)


def _otherwise(left: typed.Value, right: ast.Expr) -> str:
    """What to write for `braking is true`, or false, for `ego.lane is 1`, and for `o is ego`."""
    written = left.span.in_line
    if isinstance(right, ast.Boolean) and isinstance(left, typed.FormulaNode):
        return f"write `{written}`" if right.value else f"write `not ({written})`"
    if isinstance(left, typed.NumberNode) and not isinstance(right, (ast.Boolean, ast.Name)):
        return f"numbers are compared: `{written} == {' '.join(ast.span_of(right).text.split())}`"
    if isinstance(left, typed.RecordNode):
        return f"`is` asks for a member: compare a field that tells which it is, such as a declared `number: 1`, `{written}.number`"
    return ""


def _other(expr: ast.Expr, enumeration: Enumeration, x: Expressions, ctx: Context) -> typed.AnyMember:
    """A member by its name, or another member of the same enumeration."""
    span: Span = expr.__dict__["span"]
    if isinstance(expr, ast.Name):
        local = ctx.local.get(expr.name)
        if local is None:
            if expr.name not in enumeration.members:
                x.fail(unknown(enumeration, expr.name, span))
            return typed.Member(enumeration, expr.name, span)
        if expr.name in enumeration.members and isinstance(local, typed.NamedMember):
            where, remedy = f" of `{enumeration.name.rpartition('.')[2]}`", "give the `let` a name of its own"
            x.fail(Hides(local.span, None, "the `let`", expr.name, "member", where, remedy))
        if expr.name in enumeration.members:
            return typed.Member(enumeration, expr.name, span)
    value = x.value(expr, ctx)
    if not isinstance(value, typed.MemberNode) or value.enumeration != enumeration:
        other = value.enumeration if isinstance(value, typed.MemberNode) else None
        found = spoken(value) if other is None else member_spoken(other, enumeration)
        wanted = member_spoken(enumeration, other)
        x.fail(WrongKind(span, wanted, found, f"its members are {', '.join(enumeration.members)}"))
    return value


# A value for each member ----------------------------------------------------------------------------------------


def case(expr: ast.Case, x: Expressions, ctx: Context) -> typed.NumberCase | typed.FormulaCase:
    """A number, or a formula, for each member."""
    subject, *values = x.all(
        lambda: _subject(expr.value, x, ctx),
        *(lambda b=branch: x.value(b.value, ctx) for branch in expr.branches),
    )
    members = _members(expr, subject.enumeration, x)
    formula = isinstance(values[0], typed.FormulaNode)
    for branch, value in zip(expr.branches, values):
        if not isinstance(value, typed.FormulaNode if formula else typed.NumberNode):
            at: Span = branch.value.__dict__["span"]
            wanted = "a formula" if formula else "a number"
            alike = "all branches of a `case` are numbers, or all are formulas"
            x.fail(WrongKind(at, wanted, spoken(value), alike))
    rows = list(zip(members, [not branch.members for branch in expr.branches], values, strict=True))
    spans = [branch.span for branch in expr.branches]
    if formula:
        cases = [typed.FormulaBranch(*row, span) for row, span in zip(rows, spans)]
        return typed.FormulaCase(subject, tuple(cases), expr.span)
    for value in values[1:]:
        same(x, "choose between", values[0], value)
    parts = [typed.NumberBranch(*row, span) for row, span in zip(rows, spans)]
    return typed.NumberCase(values[0].dimension, common(*values), subject, tuple(parts), expr.span)


def _subject(expr: ast.Expr, x: Expressions, ctx: Context) -> typed.AnyMember:
    value = x.value(expr, ctx)
    if not isinstance(value, typed.MemberNode):
        help_ = "`if c then a else b` chooses by a formula"
        x.fail(WrongKind(expr.__dict__["span"], "a field of an enumeration", spoken(value), help_))
    return value


def _members(expr: ast.Case, enumeration: Enumeration, x: Expressions) -> list[tuple[str, ...]]:
    """The members that each branch is for; fails where one is unknown, stands twice, or is left out."""
    called = enumeration.name.rpartition(".")[2]
    named: dict[str, Span] = {}
    problems: list[Diagnostic] = []
    other: ast.Branch | None = None
    for branch in expr.branches:
        for member in branch.members:
            if member.name not in enumeration.members:
                problems.append(unknown(enumeration, member.name, member.span))
            elif member.name in named:
                problem = f"`{member.name}` stands twice in this `case`"
                problems.append(CaseProblem(member.span, problem, "remove one of them", named[member.name]))
            named.setdefault(member.name, member.span)
        if not branch.members and other is not None:
            problems.append(
                CaseProblem(branch.span.head, "a second `else`", "remove one of them", other.span.head)
            )
        elif not branch.members:
            other = branch
    left = tuple(name for name in enumeration.members if name not in named)
    if not problems and other is None and left:
        listed = ", ".join(f"`{name}`" for name in left)
        problem = f"this `case` does not say what holds for {listed}"
        problems.append(CaseProblem(expr.span.head, problem, f"add `{', '.join(left)}: ...`, or `else: ...`"))
    if not problems and other is not None and not left:
        problem = f"nothing is left for this `else`: all members of `{called}` are named"
        problems.append(CaseProblem(other.span.head, problem, "remove it"))
    if not problems and len(expr.branches) < 2:
        problem = "a `case` of one branch is the same for all members"
        problems.append(CaseProblem(expr.span.head, problem, "write what it is without the `case`"))
    if problems:
        x.found += problems[1:]
        x.fail(problems[0])
    return [tuple(member.name for member in branch.members) or left for branch in expr.branches]
