"""State machines once more, from docs/memory.md alone: what they are in, and what they keep, in every way that is possible.

A machine is the set of all histories that it may have had, each as a place: its state, since when, and what it remembers.
Nothing is merged; what is asked is asked of every place.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from support.fourth.meaning import FALSE, TRUE, UNKNOWN, Dim, Env, Formula, Num, Value, timeline


class Place(NamedTuple):
    """Since when in ns, None where that is not known; numbers by name, `math.nan` where they are not (the one object, equal to itself in a tuple)."""

    state: str
    since: int | None
    kept: tuple[tuple[str, float], ...]


Places: TypeAlias = frozenset[Place]


@dataclass(frozen=True)
class Way:
    """`becomes to from a, b when guard`, and what it remembers."""

    to: str
    sources: tuple[str, ...]
    guard: Formula
    remembers: tuple[tuple[str, Num], ...] = ()

    def leads_from(self, state: str) -> bool:
        return state in self.sources if self.sources else state != self.to

    @property
    def text(self) -> str:
        origin = f" from {', '.join(self.sources)}" if self.sources else ""
        return f"  becomes {self.to}{origin} when {self.guard.text}" + "".join(
            f"\n    remember {name} = {number.text}" for name, number in self.remembers
        )


@dataclass(frozen=True)
class Machine:
    """The first state is the one in which it starts. `each`: the variable of an element of `objects`, or none of the run."""

    name: str
    states: tuple[str, ...]
    ways: tuple[Way, ...]
    each: str = ""
    bridges: tuple[str, float] | None = None  # as it is written, and in ns

    @property
    def text(self) -> str:
        final = [s for s in self.states if not any(way.leads_from(s) for way in self.ways)]
        states = ", ".join(f"final {s}" if s in final else s for s in self.states)
        element = f" for each {self.each} in objects" if self.each else ""
        bridges = f" bridges {self.bridges[0]}" if self.bridges else ""
        head = f"state {self.name} : {{ {states} }}{element} starts {self.states[0]}{bridges}"
        return "\n".join([head, *(way.text for way in self.ways)])

    @property
    def numbers(self) -> dict[str, Dim]:
        return {name: number.dim for way in self.ways for name, number in way.remembers}

    def places(self, env: Env, element: Any) -> Places:
        """In which it may be in the cycle `k`: the rules see it after its transition."""
        known = env["places"]
        key = self.name, element, env["k"]
        if key not in known:
            bare = {n: env[n] for n in ("cycles", "k", "forget", "places")} | {"scales": {}}
            known[key] = self._places({**bare, **({self.each: element} if self.each else {})})
        return known[key]  # type: ignore[no-any-return]

    def _places(self, env: Env) -> Places:
        items, here = timeline(env, frozenset([self.each]))
        found: Places = frozenset()
        for item in items[: here + 1]:
            if item.env is None:
                bridged = self.bridges is not None and item.ends - item.begins <= self.bridges[1]
                found = found if bridged else self._anywhere(found)
                continue
            if not found:
                nothing = tuple((name, math.nan) for name in self.numbers)
                found = frozenset([Place(self.states[0], item.begins, nothing)])
            found = frozenset(after for one in found for after in self._after(one, item.env, item.begins))
        return found

    def _after(self, one: Place, env: Env, now: int) -> list[Place]:
        """The first guard that holds is taken; one of which that is not known may have been, or not."""
        found = []
        for way in self.ways:
            if not way.leads_from(one.state):
                continue
            guard = way.guard.of(env)
            if guard.possible:
                kept = {**dict(one.kept), **{name: number.of(env) for name, number in way.remembers}}
                found.append(Place(way.to, now, tuple(kept.items())))
            if guard.sure:
                return found
        return [*found, one]

    def _anywhere(self, before: Places) -> Places:
        """What transitions lead to in a gap, in any number; of what was entered there nothing is known."""
        found, more = before, before
        while more:
            more = (
                frozenset(
                    Place(way.to, None, tuple((name, math.nan) for name, _ in one.kept))
                    for one in found
                    for way in self.ways
                    if way.leads_from(one.state)
                )
                - found
            )
            found |= more
        return found

    # What rules ask.

    def _asked(self, given: str) -> tuple[str, frozenset[str], Callable[[Env], Places]]:
        text = f"{self.name}({given})" if self.each else self.name
        return (
            text,
            frozenset([given] if self.each else []),
            lambda env: self.places(env, env[given] if self.each else None),
        )

    def is_in(self, given: str, state: str) -> Formula:
        text, free, places = self._asked(given)

        def of(env: Env) -> Value:
            found = {one.state for one in places(env)}
            return TRUE if found == {state} else UNKNOWN if state in found else FALSE

        return Formula(f"{text} is {state}", 5, of, free)

    def time_in(self, given: str) -> Num:
        text, free, places = self._asked(given)

        def of(env: Env) -> float:
            found = {one.since for one in places(env)}
            since = found.pop()
            if found or since is None:
                return math.nan
            return float(env["cycles"][env["k"]]["stamp"] - since) / 1e9

        return Num(f"time_in({text})", 5, (0, 1, 0), of, free)

    def kept(self, given: str, name: str) -> Num:
        text, free, places = self._asked(given)

        def of(env: Env) -> float:
            found = {dict(one.kept)[name] for one in places(env)}
            return found.pop() if len(found) == 1 else math.nan

        return Num(f"{text}.{name}", 5, self.numbers[name], of, free)
