"""State machines, as formulas ask for them: in which state they are, for how long, and what they keep."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.semantics.errors.expressions import (
    BadValue,
    OverRunProblem,
    Recursive,
    WrongArity,
    WrongKind,
)
from trackmarshal.semantics.errors.names import Duplicate, UnknownField, UnknownReference
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.definitions import count_definitions
from trackmarshal.semantics.expressions.dimensions import same
from trackmarshal.semantics.expressions.temporal import bound
from trackmarshal.semantics.overrun import LONGEST
from trackmarshal.semantics.scope import spoken
from trackmarshal.semantics.values import Local, Poison, circle, record_behind
from trackmarshal.semantics.values import spoken as value_spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.typed import Symbol
from trackmarshal.units import TIME, in_full

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

#: What asks whether a machine is in a state.
IS = "is"
#: How long a machine has been in its state.
TIME_IN = "time_in"
_WHAT_LED_THERE = (
    "a guard cannot ask where its own machine is, nor for how long: `from a` says where it comes from, and `historically[0 s, 3 s] (...)` "
    "or `not once[0 s, 3 s] (...)` of what led there, for how long"
)


def no_such_state(item: ast.State, name: ast.Name) -> UnknownReference:
    states = dict.fromkeys(state.name for state in item.states)
    hint = close_matches(name.name, states) or f"its states are {', '.join(states)}"
    return UnknownReference(name.span, f"`{item.name}` has no state `{name.name}`", hint)


def sources(item: ast.State, one: ast.Transition) -> tuple[str, ...]:
    """The states that a transition leads from, in the order in which they are listed."""
    named = {name.name for name in one.sources} or {state.name for state in item.states}
    return tuple(state.name for state in item.states if state.name in named - {one.target.name})


def bridged(item: ast.State, x: Expressions, ctx: Context) -> float:
    """How long a gap is that leaves a machine as it was [s]; 0 where it says nothing of gaps."""
    if item.bridges is None:
        return 0.0
    number, seconds = bound(item.bridges, x, ctx)
    if not 0.0 <= seconds <= LONGEST / 1e9:
        hint = "write for how long: `bridges 1 s`, a thousand hours at most"
        x.fail(BadValue(number.span, f"no gap lasts for {in_full(seconds, 's')}", None, hint))
    return seconds


def written_out(
    item: ast.State, symbol: Symbol, element: Local | None, x: Expressions, ctx: Context
) -> tuple[typed.Transition, ...]:
    """The transitions of a machine, with what stands for its element; the errors of all of them are reported."""
    local = {} if element is None else {item.binder: element}
    stack, scope = (*ctx.stack, symbol.qualified), x.scopes[symbol.module]
    inner = Context(scope, local, ctx.level, typed.THE_RUN, None, stack)
    made: list[typed.Transition] = x.all(
        *(lambda one=one: _transition(item, one, x, inner) for one in item.transitions)
    )
    _check_kept(made, x)
    return tuple(made)


def _transition(item: ast.State, one: ast.Transition, x: Expressions, ctx: Context) -> typed.Transition:
    guard, *numbers = x.all(
        lambda: x.formula(one.condition, ctx),
        *(lambda keep=keep: x.number(keep.value, ctx) for keep in one.kept),
    )
    kept = tuple(typed.Keep(keep.name, value, keep.span) for keep, value in zip(one.kept, numbers))
    return typed.Transition(one.target.name, sources(item, one), guard, kept, one.span)


def _check_kept(transitions: list[typed.Transition], x: Expressions) -> None:
    """What is remembered by one name has one dimension, and a transition remembers it once."""
    first: dict[str, typed.Keep] = {}
    for one in transitions:
        own: dict[str, typed.Keep] = {}
        for keep in one.kept:
            if keep.name in own:
                x.fail(Duplicate(keep.span, own[keep.name].span, "remembered number", keep.name))
            own[keep.name] = keep
            same(x, "remember by one name", first.setdefault(keep.name, keep).value, keep.value)


def in_state(expr: ast.Infix, x: Expressions, ctx: Context) -> typed.InState:
    """`role(o) is offence`, `flag is yellow`."""
    machine = machine_of(expr.left, x, ctx)
    item = machine.symbol.item
    assert isinstance(item, ast.State)
    at: Span = expr.right.__dict__["span"]
    if not isinstance(expr.right, ast.Name):
        hint = f"its states are {', '.join(state.name for state in item.states)}"
        x.fail(UnknownReference(at, f"this is no state of `{item.name}`", hint))
    if expr.right.name not in {state.name for state in item.states}:
        x.fail(no_such_state(item, expr.right))
    return typed.InState(machine, expr.right.name, expr.span)


def names_machine(expr: ast.Expr, ctx: Context) -> bool:
    """Whether an expression looks like a machine, of the run or of an element."""
    name = expr.function if isinstance(expr, ast.Call) else expr.name if isinstance(expr, ast.Name) else ""
    symbol = None if name in ctx.local else ctx.scope.find(name)
    return symbol is not None and isinstance(symbol.item, ast.State)


def kept(expr: ast.Attribute, x: Expressions, ctx: Context) -> typed.Kept:
    """`role(o).entry`: what a machine remembers."""
    machine = machine_of(expr.value, x, ctx)
    known = {keep.name: keep.value for one in machine.transitions for keep in one.kept}
    if expr.name not in known:
        hint = close_matches(expr.name, known) or f"ask for its state: `{_text(expr.value)} is ...`"
        what, shown = f"the state `{machine.symbol.name}`", ", ".join(known) or "nothing to read"
        x.fail(UnknownField(expr.span, what, expr.name, shown, hint))
    value = known[expr.name]
    return typed.Kept(value.dimension, value.written, machine, expr.name, expr.span)


def time_in(expr: ast.Call, x: Expressions, ctx: Context) -> typed.Kept:
    """`time_in(role(o))`: how long a machine has been in its state."""
    if len(expr.args) != 1 or any(expr.names):
        given = f"{len(expr.args)} given" if expr.args else "none given"
        x.fail(WrongArity(expr.span, TIME_IN, "1 argument (a state)", given))
    return typed.Kept(TIME, "s", machine_of(expr.args[0], x, ctx), "", expr.span)


def _text(expr: ast.Expr) -> str:
    span: Span = expr.__dict__["span"]
    return span.text


def machine_of(expr: ast.Expr, x: Expressions, ctx: Context) -> typed.Machine:
    """The machine that is asked: `flag`, or `role(o)`, that of an element."""
    span: Span = expr.__dict__["span"]
    args: tuple[ast.Expr, ...] = ()
    if isinstance(expr, ast.Name) and expr.name not in ctx.local:
        name, at = expr.name, span
    elif isinstance(expr, ast.Call) and not any(expr.names):
        name, args = expr.function, expr.args
        at = Span(span.file, span.start, span.start + len(name))
    else:
        asked = re.fullmatch(r"(.+?)\s+is\s+\w+", span.text, re.DOTALL)  # `time_in(flag is caution)`
        found = value_spoken(x.value(expr, ctx))
        x.fail(WrongKind(span, "a state", found, f"write `{asked[1]}` alone" if asked else ""))
    symbol = x.look_up(name, at, "state", set(), ctx)
    item = symbol.item
    if not isinstance(item, ast.State):
        hint = ""
        if isinstance(item, ast.Enum):
            asked_of = ctx.scope.field_of(name)
            hint = f"ask the field that is one of it: `{asked_of or '...'} is ...`"
        if isinstance(item, ast.Signal) and item.many:
            hint = f"how many there are is `count(o in {name})`: of none, it is 0"
        x.fail(WrongKind(at, "a state", f"the {spoken(item)} `{name}`", hint))
    x.asked.add(symbol.qualified)
    wanted = 1 if item.domain else 0
    if len(args) != wanted:
        takes = f"an element of `{item.domain}`: `{name}({item.binder})`" if wanted else "no element"
        given = f"{len(args)} given" if args else "none given"
        x.fail(WrongArity(at, name, takes, given, item.span.head))
    _check_axis(name, at, x, ctx)
    if symbol.qualified in x.failed:
        raise Poison
    element = _element(item, args[0], x, ctx) if args else None
    if symbol.qualified in ctx.stack:
        x.fail(Recursive(at, name, circle(ctx.stack, symbol.qualified), _WHAT_LED_THERE))
    count_definitions(x, 1, span, ctx)
    before = len(x.found)
    transitions = written_out(item, symbol, element, x, ctx)
    # What is never used was told of its declaration, once; the others the rule may allow.
    x.found[before:] = [
        found for found in x.found[before:] if found.code.startswith("W") or found.level == "error"
    ]
    return typed.Machine(symbol, element, transitions, bridged(item, x, ctx), span)


def _check_axis(name: str, at: Span, x: Expressions, ctx: Context) -> None:
    timeline = ctx.timeline
    if isinstance(timeline, typed.Range) and timeline.signal.name:
        problem = f"`{name}` is a state of the run, and this rule lives along `{timeline.signal.name}`"
        x.fail(OverRunProblem(ctx.site or at, problem, "write two rules, one for each"))


def _element(item: ast.State, arg: ast.Expr, x: Expressions, ctx: Context) -> typed.NamedRecord:
    """What stands for the element whose machine is meant, as the guards see it: with all that its set declares."""
    value, span = x.value(arg, ctx), arg.__dict__["span"]
    bare = record_behind(value) if isinstance(value, typed.RecordNode) else value
    shape = x.shape(x.signals[item.domain])
    if isinstance(
        bare, typed.NamedRecord
    ):  # of a definition that is checked by itself: nothing is given for it yet
        return typed.NamedRecord(shape, None, item.binder, None, bare.kind, span)
    known = isinstance(bare, typed.Variable) and bare.signal.name == item.domain
    if not known or not isinstance(value, (typed.Variable, typed.NamedRecord)):
        x.fail(WrongKind(span, f"an element of `{item.domain}`", value_spoken(value)))
    return typed.NamedRecord(shape, value.signal, item.binder, value, "", span)
