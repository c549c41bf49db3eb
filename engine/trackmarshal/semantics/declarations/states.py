"""State machines: states that are reached and left, transitions that are taken, and guards that wait for nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.interning import Interner
from trackmarshal.ir.overrun import over_run
from trackmarshal.lowering.expressions import Lowering
from trackmarshal.semantics.advice.vacuity import never_taken
from trackmarshal.semantics.errors.declarations import NeverTaken, NoReset, StateProblem, UnreachableState
from trackmarshal.semantics.errors.expressions import BadValue, OverRunProblem
from trackmarshal.semantics.errors.names import Duplicate
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.machines import bridged, no_such_state, sources, written_out
from trackmarshal.semantics.expressions.quantifiers import axis
from trackmarshal.semantics.overrun import misused
from trackmarshal.semantics.values import Broken, Local, Poison
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.typed import Symbol

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def check_state(item: ast.State, x: Expressions, ctx: Context) -> None:
    """Everything about a declaration; where it has an error, nothing more is said about its uses."""
    symbol = Symbol(item, ctx.scope.module, f"{ctx.scope.module}.{item.name}")
    before = len(x.found)
    failed = not _check_names(item, x)
    if not failed:
        _check_ways(item, x)
    try:
        bridged(item, x, ctx)
        _check_guards(item, symbol, x, ctx)
    except Poison:
        failed = True
    except RecursionError:
        x.too_deep(item.span.head)
    if failed or any(found.level == "error" for found in x.found[before:]):
        x.failed.add(symbol.qualified)


def _check_names(item: ast.State, x: Expressions) -> bool:
    """Whether all states that are named are listed, each once."""
    listed: dict[str, Span] = {}
    good = True
    for state in item.states:
        if state.name in listed:
            x.found.append(Duplicate(state.span, listed[state.name], "state", state.name))
            good = False
        listed.setdefault(state.name, state.span)
    for name in (item.start, *(name for one in item.transitions for name in (one.target, *one.sources))):
        if name.name not in listed:
            x.found.append(no_such_state(item, name))
            good = False
    for one in item.transitions:
        for source in one.sources:
            if source.name == one.target.name:
                problem = f"`{source.name}` does not become what it is"
                hint = "name the states that it leads from: all others"
                x.found.append(BadValue(source.span, problem, one.target.span, hint, "it leads here"))
                good = False
    return good


def _check_ways(item: ast.State, x: Expressions) -> None:
    """Every state can be reached and left, and every transition can be taken, as far as guards that are alike can tell."""
    taken: list[tuple[ast.Transition, set[str]]] = []
    for place, one in enumerate(item.transitions):
        left = set(sources(item, one))
        known = _conjuncts(one.condition)
        for earlier in item.transitions[:place]:
            if earlier.condition in known or earlier.condition == ast.Boolean(True):
                left -= set(sources(item, earlier))
            if not left:
                x.found.append(NeverTaken(one.span.head, earlier.span.head, one.target.name))
                break
        taken.append((one, left))
    if all(item.start.name not in left for _, left in taken):
        x.found.append(StateProblem(item.span.head, f"`{item.name}` is `{item.start.name}` for ever"))
        return
    reached, grown = {item.start.name}, True
    while grown:
        more = {one.target.name for one, left in taken if left & reached} - reached
        reached, grown = reached | more, bool(more)
    for state in item.states:
        leaving = next((one for one, left in taken if state.name in left), None)
        if state.name not in reached:
            x.found.append(UnreachableState(state.span, item.name, state.name))
        elif leaving is None and not state.final:
            hint = f"add a `becomes` that leads on, or write `final {state.name}`"
            x.found.append(NoReset(state.span, f"nothing leads out of `{state.name}`", hint))
        elif leaving is not None and state.final:
            hint = "name with `from` the states that it leads from, or remove `final`"
            problem = f"`{state.name}` is final, and is left"
            x.found.append(NoReset(state.span, problem, hint, leaving.span.head))


def _conjuncts(condition: ast.Expr) -> list[ast.Expr]:
    """A guard, and the parts of it all of which have to hold."""
    found: list[ast.Expr] = [condition]
    for part in found:
        if isinstance(part, ast.Binary) and part.op == "and":
            found += [part.left, part.right]
    return found


def _check_guards(item: ast.State, symbol: Symbol, x: Expressions, ctx: Context) -> None:
    """The guards, for any element: what they are about, and that they wait for nothing."""
    element: Local | None = None
    if item.domain:
        domain = ast.Name(item.domain, item.span.word(item.domain))
        try:
            range_, names = axis(domain, (item.binder,), False, item.span.head, x, ctx)
            element = names[item.binder]
            if not range_.signal.many:
                problem = (
                    f"a sample of `{item.domain}` has no history: it is not known again in another cycle"
                )
                x.found.append(OverRunProblem(domain.span, problem, "write `for each` of a set of objects"))
                element = Broken()
        except Poison:
            element = Broken()
    before = len(x.found)
    transitions = written_out(item, symbol, element, x, ctx.bind({}, 1))
    # Where a rule asks for the state, they are found again, and the rule may allow them.
    x.found[before:] = [found for found in x.found[before:] if not found.code.startswith("W")]
    if isinstance(element, Broken):
        raise Poison
    lowering = Lowering(Interner())
    for one in transitions:
        guard = lowering.formula(one.guard)
        problem_ = misused(guard)
        ahead = next((n for n in ir.below(guard) if isinstance(n, ir.Remembered) and not n.past), None)
        if problem_ is None and ahead is not None:
            hint = (
                "a guard speaks of now and of what was: `once`, `historically`, `since`, `previous`, `count`"
            )
            problem_ = OverRunProblem(ahead.span, f"`{item.name}` cannot wait for what will be", hint)
        if problem_ is not None:
            x.fail(problem_)
        never = never_taken(guard, one.guard.span, x.bounds)
        x.found += [] if never is None else [never]
        for keep in one.kept:
            if over_run(lowering.number(keep.value)):
                problem = "what is remembered is a number of the cycle of the transition alone"
                x.fail(OverRunProblem(keep.span, problem, "leave out what was, and what states keep"))
