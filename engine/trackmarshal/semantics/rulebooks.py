"""Rulebooks, states and the targets of tests: checked by name."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir.spec import RulebookInfo
from trackmarshal.semantics.errors import RulebookCycle, RunAxis, StateProblem, UnknownReference
from trackmarshal.syntax import ast


def check_rulebook(item: ast.Item, rules: set[str], found: list[Diagnostic]) -> RulebookInfo:
    """The order of a rulebook; every name is a rule, and no rule outranks itself."""
    assert isinstance(item, ast.Rulebook)
    above: dict[str, list[tuple[str, bool]]] = {}
    relations: list[tuple[str, str, str]] = []
    for chain in item.chains:
        for name in chain.names:
            if name.name not in rules:
                found.append(UnknownReference(name.span, f"no rule `{name.name}`", close_matches(name.name, rules)))
        for left, relation, right in zip(chain.names, chain.relations, chain.names[1:]):
            relations.append((left.name, relation, right.name))
            above.setdefault(left.name, []).append((right.name, relation == ">"))
            if relation == "~":
                above.setdefault(right.name, []).append((left.name, False))
    for name in above:
        path = _strict_cycle(name, above)
        if path:
            found.append(RulebookCycle(item.span, name, " > ".join(path)))
            break
    return RulebookInfo(item.name, item.title, tuple(relations), item.span)


def _strict_cycle(start: str, above: dict[str, list[tuple[str, bool]]]) -> list[str] | None:
    """A way from a rule back to itself with at least one strict step."""
    seen: set[tuple[str, bool]] = set()
    stack: list[tuple[str, bool, tuple[str, ...]]] = [(start, False, (start,))]
    while stack:
        name, strict, path = stack.pop()
        for target, step in above.get(name, []):
            now = strict or step
            if target == start and now:
                return [*path, target]
            if (target, now) not in seen:
                seen.add((target, now))
                stack.append((target, now, (*path, target)))
    return None


def check_state(item: ast.Item, found: list[Diagnostic]) -> None:
    """Memory over the run parses, and is refused: this version has no evaluator for it."""
    assert isinstance(item, ast.State)
    if any(t.state == item.start for t in item.transitions) or len(item.transitions) > 0:
        found.append(RunAxis(item.span, f"state `{item.name}`"))
    else:
        found.append(StateProblem(item.span, f"`{item.name}` never changes"))


def check_test_target(item: ast.Item, rules: set[str], found: list[Diagnostic]) -> None:
    """A test names a rule or an assumption."""
    assert isinstance(item, ast.Test)
    if item.rule not in rules:
        found.append(UnknownReference(item.span, f"no rule `{item.rule}` to test", close_matches(item.rule, rules)))
