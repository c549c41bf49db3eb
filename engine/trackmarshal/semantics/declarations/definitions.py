"""Definitions by themselves, whether anything calls them or not."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.semantics.errors.names import Duplicate
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.definitions import check_body
from trackmarshal.semantics.expressions.quantifiers import check_used
from trackmarshal.source import Span
from trackmarshal.syntax import ast

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def check_definition(item: ast.Define, x: Expressions, ctx: Context) -> None:
    """Report what is wrong with a definition, and parameters that it does not look at."""
    start = len(x.found)
    seen: dict[str, Span] = {}
    for parameter in item.parameters:
        if parameter.name in seen:
            x.found.append(Duplicate(parameter.span, seen[parameter.name], "parameter", parameter.name))
        seen.setdefault(parameter.name, parameter.span)
        ctx.scope.check_bound(parameter.name, parameter.span, "parameter")
    symbol, before = typed.Symbol(item, ctx.scope.module, f"{ctx.scope.module}.{item.name}"), len(x.found)
    if not x.attempt(partial(check_body, x, symbol, item, ctx), item.span.head):
        x.failed.add(symbol.qualified)
    # Where a rule uses it, they are found again, and the rule may allow them.
    x.found[before:] = [found for found in x.found[before:] if not found.code.startswith("W")]
    if not any(found.level == "error" for found in x.found[start:]):
        for parameter in item.parameters:
            check_used(x, (parameter.name,), (item.body,), parameter.span)
