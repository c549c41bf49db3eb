"""Enumerations: members that stand once, and a name that is no unit."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir.spec import Enumeration
from trackmarshal.semantics.errors.names import Duplicate, Hides
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import UNITS


def declared(item: ast.Enum, module: str) -> Enumeration:
    """What a declaration declares; members that stand twice count once."""
    return Enumeration(f"{module}.{item.name}", tuple(dict.fromkeys(member.name for member in item.members)))


def check_enum(item: ast.Enum, found: list[Diagnostic]) -> None:
    """Report members that stand twice, and a name that a field would take for a unit."""
    first: dict[str, Span] = {}
    for member in item.members:
        if member.name in first:
            found.append(Duplicate(member.span, first[member.name], "member", member.name))
        first.setdefault(member.name, member.span)
    if item.name in UNITS:
        found.append(Hides(item.span.head, None, "enumeration", item.name, "unit", " of the language"))
