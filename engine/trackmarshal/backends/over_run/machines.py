"""State machines over the run: which states one may be in, where guards are undefined and cycles are missing.

Source: the language's section on states (docs/language.md). In every cycle, each state that a machine may be in keeps all successors that
strong Kleene logic allows: the first transition whose guard surely holds ends the search, and those before it whose guards may hold stay possible.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.kleene import FALSE, TRUE, UNDEFINED
from trackmarshal.runtime.verdict import Truth

#: What is known of a machine if it is in a state: since when it is in it [ns]; None: not known.
Held = tuple[int | None]
#: The states that a machine may be in.
Possible = Mapping[str, Held]


def begun(machine: ir.Machine, t: int) -> Possible:
    """A machine before its first cycle, which has the stamp t."""
    return {machine.start: (t,)}


def stepped(machine: ir.Machine, before: Possible, t: int, guards: Sequence[Truth]) -> Possible:
    """A machine after a cycle with the stamp t, in which its guards have these values."""
    after: dict[str, Held] = {}
    for state, held in before.items():
        stays = True
        for target, sources, guard in zip(machine.targets, machine.sources, guards):
            if state not in sources or not guard.best.sat:
                continue
            _add(after, target, (t,))
            if guard.worst.sat:
                stays = False
                break
        if stays:
            _add(after, state, held)
    return after


def widened(machine: ir.Machine, before: Possible) -> Possible:
    """A machine after cycles of which nothing is known: any number of transitions may have been taken, or none."""
    reached: set[str] = set()
    stack = list(before)
    while stack:
        state = stack.pop()
        for target, sources in zip(machine.targets, machine.sources):
            if state in sources and target not in reached:
                reached.add(target)
                stack.append(target)
    return {**before, **{state: (None,) for state in machine.states if state in reached}}


def is_in(possible: Possible, state: str) -> Truth:
    """Whether a machine is in a state."""
    if state not in possible:
        return FALSE
    return TRUE if len(possible) == 1 else UNDEFINED


def _add(found: dict[str, Held], state: str, held: Held) -> None:
    """One more way into a state: what is known of it is what all ways agree on."""
    known = found.get(state)
    found[state] = held if known is None or known == held else (None,)
