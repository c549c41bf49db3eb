"""How many elements of a set are known, and for how long: what `capacity` and `forget` of a signal come to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.semantics.declarations.ranges import finite
from trackmarshal.semantics.errors.declarations import LifetimeProblem
from trackmarshal.semantics.overrun import LONGEST
from trackmarshal.semantics.values import Poison
from trackmarshal.source import Span
from trackmarshal.syntax import ast

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

#: The most elements of a set that can be declared: memory for all of them is there before a run.
MOST = 1000


def lifetimes(x: Expressions, item: ast.Signal) -> tuple[int | None, int]:
    """The capacity of a signal, None where it declares none, and for how long an element may be absent [ns]."""
    capacity, forget = None, 0
    if item.capacity is not None:
        at = ast.span_of(item.capacity)
        value = _value(x, item.capacity, "1")
        if not item.many:
            x.found.append(_no_set(item, at, "capacity"))
        elif value is not None and not (1 <= value <= MOST and value == int(value)):
            hint = f"write a whole number from 1 to {MOST}, with no unit"
            x.found.append(LifetimeProblem(at, f"a set has no capacity of {value:g}", hint))
        elif value is not None:
            capacity = int(value)
    if item.forget is not None:
        at = ast.span_of(item.forget)
        seconds = _value(x, item.forget, "s")
        if not item.many:
            x.found.append(_no_set(item, at, "forget"))
        elif seconds is not None and not 0.0 <= seconds <= LONGEST / 1e9:
            hint = "write for how long: `forget 2 s`, a thousand hours at most"
            x.found.append(LifetimeProblem(at, f"no element can be absent for {seconds:g} s", hint))
        elif seconds and item.capacity is None:
            hint = "say of how many elements something is remembered: `capacity 32` before it"
            x.found.append(
                LifetimeProblem(at, "memory for those that are absent is there before the run", hint)
            )
        elif seconds is not None:
            forget = nanoseconds(seconds)
    return capacity, forget


def _value(x: Expressions, expr: ast.Expr, unit: str) -> float | None:
    """A literal in SI; None for one that is none, of which was told."""
    try:
        return finite(x, expr, unit)
    except Poison:
        return None


def _no_set(item: ast.Signal, at: Span, word: str) -> LifetimeProblem:
    hint = "leave it out: other signals have no elements that come and go"
    return LifetimeProblem(at, f"`{word}` is of sets, and `{item.name}` is a {item.kind}", hint)
