"""Rulebooks, signals and the targets of tests: what must hold of a declaration beyond its syntax."""

from __future__ import annotations

from itertools import pairwise

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir.spec import RulebookInfo
from trackmarshal.semantics.errors import BadValue, RulebookCycle, UnknownReference
from trackmarshal.source import Span
from trackmarshal.syntax import ast


def check_rulebook(item: ast.Item, rules: set[str], found: list[Diagnostic]) -> RulebookInfo:
    """The order of a rulebook; every name is a rule, and no rule outranks itself."""
    assert isinstance(item, ast.Rulebook)
    above: dict[str, list[tuple[str, bool]]] = {}
    relations: list[tuple[str, str, str]] = []
    for chain in item.chains:
        for name in chain.names:
            if name.name not in rules:
                hint = (
                    close_matches(name.name, rules)
                    or "a rulebook orders the rules that are checked together with it"
                )
                found.append(UnknownReference(name.span, f"no rule `{name.name}`", hint))
        for left, relation, right in zip(chain.names, chain.relations, chain.names[1:]):
            relations.append((left.name, relation, right.name))
            above.setdefault(left.name, []).append((right.name, relation == ">"))
            if relation == "~":
                above.setdefault(right.name, []).append((left.name, False))
    for rule in above:
        path = _strict_cycle(rule, above)
        if path:
            found.append(RulebookCycle(_step(item, path), rule, _told(path, relations)))
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


def _step(item: ast.Rulebook, path: list[str]) -> Span:
    """Where the last relation of a circle is written."""
    for chain in item.chains:
        for left, right in zip(chain.names, chain.names[1:]):
            if {left.name, right.name} == set(path[-2:]):
                return left.span.to(right.span)
    return item.span.head


def _told(path: list[str], relations: list[tuple[str, str, str]]) -> str:
    """A circle with the relations as they are written."""
    strict = {(left, right) for left, relation, right in relations if relation == ">"}
    return path[0] + "".join(f" {'>' if (a, b) in strict else '~'} {b}" for a, b in pairwise(path))


def check_signal(item: ast.Signal, found: list[Diagnostic]) -> None:
    """What a signal of a kind may hold."""
    head, kind = item.span.head, item.kind
    if item.many != (kind == "object"):
        problem = f"there is no set of {kind}s" if item.many else "objects come in sets"
        found.append(
            BadValue(
                head,
                problem,
                None,
                "write `set of object`" + ("" if item.many else ", or `state` for a single record"),
            )
        )
    if kind == "polyline" and item.fields_:
        found.append(
            BadValue(item.fields_[0].span, "a polyline has no fields", None, "it is a list of points")
        )
    if kind == "corridor" and item.fields_:
        sides = {field.name for field in item.fields_ if field.type == "polyline"}
        for field in item.fields_:
            if field.type != "polyline" or field.name not in ("left", "right"):
                found.append(
                    BadValue(
                        field.span, f"a corridor has no field `{field.name}: {field.type}`", None, _CORRIDOR
                    )
                )
        for side in ("left", "right"):
            if side not in sides:
                found.append(
                    BadValue(head, f"the corridor `{item.name}` lacks `{side}: polyline`", None, _CORRIDOR)
                )
    for field in item.fields_ if kind not in ("corridor", "polyline") else ():
        if field.type == "polyline":
            found.append(
                BadValue(
                    field.span, f"a {kind} has no polylines", None, "polylines stand in a corridor, or alone"
                )
            )
        if field.increasing and kind not in ("trajectory", "series"):
            found.append(
                BadValue(
                    field.span,
                    f"a field of a {kind} has no order",
                    None,
                    "only columns of a timeline increase",
                )
            )


_CORRIDOR = "its fields are `left: polyline` and `right: polyline`"


def check_test_target(item: ast.Item, rules: set[str], found: list[Diagnostic]) -> None:
    """A test names a rule or an assumption."""
    assert isinstance(item, ast.Test)
    if item.rule not in rules:
        at = item.span.head.word(item.rule)
        hint = (
            close_matches(item.rule, rules) or "a test follows the rule that it is about, or uses its module"
        )
        found.append(UnknownReference(at, f"no rule `{item.rule}` to test", hint))
