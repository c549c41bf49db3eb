"""The words of the spec language: what starts a declaration, what starts a clause, what can never be a name."""

from __future__ import annotations

#: Words that start a declaration, in column 1.
DECLARATIONS = (
    "module", "use", "reference", "enum", "signal", "event", "param", "constrain", "scale", "table", "zone", "line", "stretch", "shape", "define",
    "predicate", "assume", "rule", "state", "rulebook", "test",
)  # fmt: skip

#: Words that start a clause, by the declarations that have it.
CLAUSES = {
    "rule": (
        "satisfies", "assuming", "source", "because", "severity", "allow", "for", "exists", "except", "let", "along", "whenever",
        "within", "require",
    ),
    "assume": (
        "satisfies", "assuming", "source", "because", "severity", "allow", "evidence", "owner", "for", "exists", "except", "let",
        "along", "whenever", "within", "monitor",
    ),
    "state": ("becomes", "remember"),
    "test": ("given", "after", "expect"),
}  # fmt: skip

#: Words of expressions.
OPERATORS = (
    "and", "or", "not", "implies", "iff", "xor", "in", "where", "if", "then", "else", "case", "true", "false", "with",
    "always", "eventually", "historically", "once", "next", "previous", "weak", "until", "since", "consecutive", "by", "nearest", "all",
)  # fmt: skip

#: Words that are never names, so that a forgotten expression is noticed where it is missing.
RESERVED = frozenset(OPERATORS).union(*CLAUSES.values())
