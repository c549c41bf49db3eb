"""Which parameter of a definition each argument of a call is for: in order, by name, or its default."""

from __future__ import annotations

from itertools import takewhile
from typing import TYPE_CHECKING

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.semantics.errors.expressions import WrongArity
from trackmarshal.semantics.errors.names import UnknownReference
from trackmarshal.source import Span
from trackmarshal.syntax import ast

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def in_order(
    self: Expressions, item: ast.Define, args: tuple[ast.Expr, ...], names: tuple[str, ...], at: Span, hint: str
) -> list[ast.Expr | None] | None:  # fmt: skip
    """For each parameter what is given for it, None: its default. None where the arguments do not fit, which is reported.

    at: the definition's name in the call; hint: what to say where there are too many or too few.
    """
    parameters = item.parameters
    placed = [arg for arg, _ in takewhile(lambda one: not one[1], zip(args, names))]
    least = sum(one.default is None for one in parameters)
    if len(args) > len(parameters) or (len(placed) == len(args) and len(args) < least):
        wanted = counted(least, len(parameters))
        self.found.append(WrongArity(at, item.name, wanted, given(len(args)), item.span.head, hint))
        return None
    found: dict[str, ast.Expr] = {one.name: arg for one, arg in zip(parameters, placed)}
    errors = len(self.found)

    def report(arg: ast.Expr, problem: str, hint: str = "") -> None:
        self.found.append(UnknownReference(arg.__dict__["span"], problem, hint))

    for place, (arg, name) in enumerate(zip(args, names)):
        if not name:
            if any(names[:place]):
                report(arg, "what is given in order comes before what is given by name")
        elif name not in {one.name for one in parameters}:
            takes = f"`{item.name}` takes " + ", ".join(one.name for one in parameters)
            known = [one.name for one in parameters]
            report(arg, f"`{item.name}` has no parameter `{name}`", close_matches(name, known) or takes)
        elif name in found:
            report(arg, f"`{name}` is given twice")
        else:
            found[name] = arg
    if len(self.found) == errors:
        lacking = [one for one in parameters if one.default is None and one.name not in found]
        if lacking:
            shown = ", ".join(f"{one.name}: {one.type}" for one in lacking)
            self.found.append(
                WrongArity(at, item.name, counted(least, len(parameters)), given(len(args)), item.span.head, f"nothing is given for {shown}")
            )  # fmt: skip
    if len(self.found) > errors:
        return None
    return [found.get(one.name) for one in parameters]


def counted(least: int, most: int | None = None) -> str:
    """How many arguments, in words."""
    if most is not None and most != least:
        return f"{least} to {counted(most)}"
    return "no arguments" if least == 0 else "1 argument" if least == 1 else f"{least} arguments"


def given(number: int) -> str:
    """How many were given, in words."""
    return f"{number} given" if number else "none given"
