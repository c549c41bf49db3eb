"""Cycles among requirements: found without recursion, printed as a path."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

#: A longer cycle is printed with its middle left out.
SHOWN = 8
#: So many cycles are listed; mending them brings the others up, if there are any.
LISTED = 20


def cycles(parents: Mapping[str, Sequence[str]]) -> list[list[str]]:
    """One cycle for each way back that a depth-first search meets, up to LISTED; its members in order, none repeated."""
    state: dict[str, int] = {}  # 1: on the path, 2: done
    found: list[list[str]] = []
    for root in parents:
        if root in state:
            continue
        path = [root]
        ways = [iter(parents[root])]
        state[root] = 1
        while ways:
            target = next(ways[-1], None)
            if target is None:
                ways.pop()
                state[path.pop()] = 2
            elif state.get(target) == 1:
                if len(found) < LISTED:
                    found.append(path[path.index(target) :])
            elif target not in state and target in parents:
                state[target] = 1
                path.append(target)
                ways.append(iter(parents[target]))
    return found


def shown(cycle: Sequence[str]) -> str:
    """A cycle as a path that returns to its start."""
    names = [*cycle, cycle[0]]
    if len(names) > SHOWN:
        left_out = len(names) - SHOWN + 1
        names = [*names[: SHOWN // 2], f"({left_out} more)", *names[-(SHOWN // 2 - 1) :]]
    return " -> ".join(names)


def children_first(parents: Mapping[str, Sequence[str]]) -> list[str]:
    """All names so that each comes after those that refine it; members of cycles, and what is above them, come last."""
    waiting = dict.fromkeys(parents, 0)
    for above in parents.values():
        for name in dict.fromkeys(above):
            if name in waiting:
                waiting[name] += 1
    order = [name for name, number in waiting.items() if number == 0]
    for name in order:  # grows while it is read
        for above in dict.fromkeys(parents[name]):
            if above in waiting:
                waiting[above] -= 1
                if waiting[above] == 0:
                    order.append(above)
    return [*order, *_missing(parents, order)]


def _missing(all_names: Iterable[str], listed: Iterable[str]) -> list[str]:
    done = set(listed)
    return [name for name in all_names if name not in done]
