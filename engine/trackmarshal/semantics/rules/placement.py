"""Which clauses may stand in a rule or an assumption, how often, and in what order."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir.spec import ADVISORY
from trackmarshal.semantics.errors.rules import ClauseProblem
from trackmarshal.source import Span
from trackmarshal.syntax import ast

#: The clauses that set the scene for a rule's condition.
SCENE = (ast.Bind, ast.Except, ast.Let, ast.Along, ast.Whenever, ast.WithinTime)
#: The clauses that stand once, besides the condition.
_SINGLE = (ast.Along, ast.Because, ast.Severity, ast.Evidence, ast.Owner, ast.Whenever, ast.WithinTime)


def check_placement(item: ast.Rule | ast.Assume, found: list[Diagnostic]) -> None:
    """Report clauses that are missing, double or misplaced."""
    rule = isinstance(item, ast.Rule)
    called, word = ("a rule", "require") if rule else ("an assumption", "monitor")

    def report(clause: ast.Clause, problem: str, hint: str, first: Span | None = None) -> None:
        found.append(ClauseProblem(clause.__dict__["span"].head, problem, hint, first))

    for kind in (ast.Require, *_SINGLE):
        clauses = [clause for clause in item.clauses if isinstance(clause, kind)]
        condition = kind is ast.Require
        hint = "join the conditions with `and`, or write two rules" if condition else "keep one of them"
        name = word if condition else "within" if kind is ast.WithinTime else kind.__name__.lower()
        for extra in clauses[1:]:
            report(extra, f"`{name}` stands once in {called}", hint, clauses[0].__dict__["span"].head)
    requires = [clause for clause in item.clauses if isinstance(clause, ast.Require)]
    if rule and not requires:
        problem = f"rule `{item.name}` requires nothing"
        found.append(ClauseProblem(item.span.head, problem, "add a `require` clause"))
    for require in requires:
        if require.keyword != word:
            report(require, f"{called} states its condition with `{word}`", f"write `{word}`")
    bound = False
    for clause in item.clauses:
        if rule and isinstance(clause, (ast.Evidence, ast.Owner)):
            problem = "evidence and owner belong to an assumption"
            report(clause, problem, "move it to the `assume` it is about")
        if not rule and isinstance(clause, ast.Severity) and clause.word == ADVISORY:
            hint = "leave `severity` out, or make a rule of the monitor"
            report(clause, "rules rely on an assumption: its monitor decides", hint)
        if isinstance(clause, SCENE) and not rule and not requires:
            problem = "there is no `monitor` that this clause would be about"
            report(clause, problem, "add a `monitor`, or remove the clause")
        if isinstance(clause, SCENE) and requires and clause.span.start > requires[0].span.start:
            problem = "this clause comes after the condition that it is about"
            report(clause, problem, "move it before the condition")
        elif isinstance(clause, ast.Bind):
            bound = True
        elif isinstance(clause, ast.Along) and bound:
            report(clause, "`along` comes before the quantifiers", "move it up")
        elif isinstance(clause, ast.Except) and not bound:
            problem = "`except` leaves elements out of a quantifier's range"
            report(clause, problem, "put a `for all` before it, or use `whenever`")
        elif isinstance(clause, ast.WithinTime):
            if not any(isinstance(c, ast.Whenever) for c in item.clauses):
                hint = "add a `whenever` before it"
                report(clause, "`within` is the deadline of a `whenever`", hint)
            if any(isinstance(c, ast.Along) for c in item.clauses):
                problem = "`within` counts the cycles of the run, not the samples of a timeline"
                report(clause, problem, "along a timeline, write `eventually[0 s, ...]`")
        elif isinstance(clause, ast.Whenever) and bound:
            report(clause, "`whenever` comes before the quantifiers", "move it up, or use `where`")
