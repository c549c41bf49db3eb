"""State machines over the run: which states one may be in, where guards are undefined and cycles are missing.

Source: the language's section on states (docs/language.md). In every cycle, each state that a machine may be in keeps all successors that
strong Kleene logic allows: the first transition whose guard surely holds ends the search, and those before it whose guards may hold stay possible.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping

from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.kleene import FALSE, TRUE, UNDEFINED
from trackmarshal.runtime.verdict import Truth

#: What is known of a machine if it is in a state: since when it is in it [ns], and what it remembers, by its names; None: not known.
Held = tuple[int | float | None, ...]
#: The states that a machine may be in.
Possible = Mapping[str, Held]


def begun(machine: ir.Machine, t: int) -> Possible:
    """A machine before its first cycle, which has the stamp t."""
    return {machine.start: (t, *[None] * len(machine.names))}


def stepped(
    machine: ir.Machine,
    before: Possible,
    t: int,
    guards: Callable[[int], Truth],
    measured: Callable[[ir.Num], float],
) -> Possible:
    """A machine after a cycle with the stamp t. guards: the values of its guards there, by their places: asked for where a state that it may be in
    has that way out; measured: the numbers that it remembers."""
    after: dict[str, Held] = {}
    for state, held in before.items():
        stays = True
        for number, (target, sources) in enumerate(zip(machine.targets, machine.sources)):
            if state not in sources:
                continue
            guard = guards(number)
            if not guard.best.sat:
                continue
            _add(after, target, (t, *_remembered(machine, number, held, measured)))
            if guard.worst.sat:
                stays = False
                break
        if stays:
            _add(after, state, held)
    return after


def widened(machine: ir.Machine, before: Possible, gap: int) -> Possible:
    """A machine after cycles of which nothing is known: any number of transitions may have been taken, or none.

    gap: from the stamp of the last cycle that it knows to that of the next [ns]. One that it bridges leaves it as it was.
    """
    if gap <= machine.bridges:
        return before
    unknown: Held = (None,) * (1 + len(machine.names))
    return {**before, **dict.fromkeys(reached(machine, before), unknown)}


def reached(machine: ir.Machine, states: Iterable[str]) -> list[str]:
    """The states that some number of transitions, at least one, may lead to from any of these, in the order of the machine's."""
    found: set[str] = set()
    stack = list(states)
    while stack:
        state = stack.pop()
        for target, sources in zip(machine.targets, machine.sources):
            if state in sources and target not in found:
                found.add(target)
                stack.append(target)
    return [state for state in machine.states if state in found]


def unknown(machine: ir.Machine) -> Possible:
    """A machine of which nothing is known."""
    return {state: (None,) * (1 + len(machine.names)) for state in machine.states}


def is_in(possible: Possible, state: str) -> Truth:
    """Whether a machine is in a state."""
    if state not in possible:
        return FALSE
    return TRUE if len(possible) == 1 else UNDEFINED


def kept(machine: ir.Machine, name: str, possible: Possible, t: int) -> float:
    """What a machine keeps, at the stamp t, where it is the same in all states that it may be in, and else NaN. name: "" for the duration [s]."""
    place = 1 + machine.names.index(name) if name else 0
    values = {held[place] for held in possible.values()}
    value = values.pop()
    if values or value is None:
        return math.nan
    return float(value) if name else (t - value) / 1e9


def _remembered(
    machine: ir.Machine, number: int, held: Held, measured: Callable[[ir.Num], float]
) -> list[int | float | None]:
    """What a machine remembers after a transition: what that one takes note of, and else what it knew before."""
    values = dict(zip(machine.names, held[1:]))
    for (taker, name), noted in zip(machine.kept, machine.numbers):
        if taker == number:
            value = measured(noted)
            values[name] = value if math.isfinite(value) else None
    return list(values.values())


def _add(found: dict[str, Held], state: str, held: Held) -> None:
    """One more way into a state: what is known of it is what all ways agree on."""
    known = found.get(state)
    found[state] = held if known is None else tuple(a if a == b else None for a, b in zip(known, held))
