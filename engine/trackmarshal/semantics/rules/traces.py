"""What a rule traces to, and what is said of it beside its condition."""

from __future__ import annotations

from typing import NamedTuple

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir.spec import ADVISORY
from trackmarshal.semantics.errors.names import Ambiguous, UnknownName, UnknownReference
from trackmarshal.semantics.rules.placement import SCENE
from trackmarshal.semantics.scope import Scope
from trackmarshal.source import Span
from trackmarshal.syntax import ast

SEVERITIES = (ADVISORY, "minor", "major", "critical")


class Traces(NamedTuple):
    """Requirements and assumptions with the places where they are named, and texts; in the order of a RuleInfo."""

    satisfies: tuple[tuple[str, Span], ...]
    assuming: tuple[tuple[str, Span], ...]
    source: str
    because: str
    severity: str
    evidence: str
    owner: str


def traces(
    item: ast.Rule | ast.Assume, assumptions: set[str], scope: Scope, found: list[Diagnostic]
) -> Traces:
    """What the clauses of a rule say of it; names that nothing declares are reported."""
    text = {"source": "", "because": "", "severity": "major", "evidence": "", "owner": ""}
    satisfies: list[tuple[str, Span]] = []
    assuming: list[tuple[str, Span]] = []
    for clause in item.clauses:
        match clause:
            case ast.Satisfies():
                satisfies += [(name.name, name.span) for name in clause.ids]
            case ast.Assuming():
                assuming += [(name.name, name.span) for name in clause.ids]
            case ast.SourceClause():
                text["source"] = "; ".join(filter(None, (text["source"], _source(clause, scope, found))))
            case ast.Because():
                text["because"] = clause.text
            case ast.Severity():
                text["severity"] = clause.word
                if clause.word not in SEVERITIES:
                    hint = (
                        close_matches(clause.word, SEVERITIES)
                        or f"write {', '.join(SEVERITIES[:-1])} or {SEVERITIES[-1]}"
                    )
                    found.append(
                        UnknownReference(
                            _last_word(clause.span, clause.word), f"`{clause.word}` is no severity", hint
                        )
                    )
            case ast.Evidence():
                text["evidence"] = clause.path
            case ast.Owner():
                text["owner"] = clause.text
            case _ if not isinstance(clause, (*SCENE, ast.Require, ast.Allow)):  # which others read
                raise AssertionError(f"unknown clause {type(clause).__name__}")
    for name, span in assuming:
        if name not in assumptions:
            unknown = scope.unknown(name, span, "assumption", "")
            if unknown.modules:
                found.append(unknown)
                continue
            problem = f"no assumption `{name}` is declared in what is checked together"
            hint = (
                close_matches(name, assumptions)
                or f"declare it: `assume {name}`, or add a `use` of its module"
            )
            found.append(UnknownReference(span, problem, hint))
    return Traces(tuple(satisfies), tuple(assuming), **text)


def _source(clause: ast.SourceClause, scope: Scope, found: list[Diagnostic]) -> str:
    """Where a rule comes from: a declared reference, a place in it, or a text."""
    if clause.reference is None:
        return clause.locator
    name, span = clause.reference.name, clause.reference.span
    symbol = scope.look_up(name, span, "reference", set())
    if isinstance(symbol, typed.Symbol) and isinstance(symbol.item, ast.Reference):
        return f"{symbol.item.text}, {clause.locator}" if clause.locator else symbol.item.text
    if isinstance(symbol, Ambiguous) or (isinstance(symbol, UnknownName) and symbol.modules):
        found.append(symbol)
    elif symbol is not None:
        hint = close_matches(name, scope.names_of(ast.Reference)) or f'declare it: `reference {name} = "..."`'
        found.append(
            UnknownReference(span, f"no reference `{name}` is declared here or in a used module", hint)
        )
    return ""


def _last_word(span: Span, word: str) -> Span:
    """Where the word stands that ends a clause."""
    return Span(span.file, span.end - len(word), span.end) if span.text.endswith(word) else span.head
