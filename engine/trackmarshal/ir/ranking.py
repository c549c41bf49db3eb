"""Who outranks whom: what the relations of a rulebook come to, taken together."""

from __future__ import annotations

from collections.abc import Iterable

#: `a > b`: a outranks b. `a ~ b`: they rank equal. `a & b`: they rank equal, and count as one.
Relation = tuple[str, str, str]


def at_or_below(names: Iterable[str], relations: Iterable[Relation]) -> dict[str, frozenset[str]]:
    """By name, whatever it reaches downwards: itself, its equals, and all that these outrank."""
    steps: dict[str, set[str]] = {name: set() for name in names}
    for upper, relation, lower in relations:
        match relation:
            case ">":
                steps[upper].add(lower)
            case "~" | "&":
                steps[upper].add(lower)
                steps[lower].add(upper)
            case _:
                raise AssertionError(f"unknown relation {relation}")
    return {name: _reached(name, steps) for name in steps}


def _reached(start: str, steps: dict[str, set[str]]) -> frozenset[str]:
    seen, waiting = {start}, [start]
    while waiting:
        for name in steps[waiting.pop()] - seen:
            seen.add(name)
            waiting.append(name)
    return frozenset(seen)


def above(names: Iterable[str], relations: Iterable[Relation]) -> dict[str, frozenset[str]]:
    """By name, the names that strictly outrank it: those that reach it, and that it does not reach."""
    down = at_or_below(names, relations)
    return {
        name: frozenset(other for other in down if name in down[other] and other not in down[name])
        for name in down
    }
