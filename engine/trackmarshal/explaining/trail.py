"""What decided a formula over the run: from operator to operator, cycle to cycle, down to a comparison in one of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, TypeVar, assert_never

from trackmarshal.backends.over_run.history import (
    Element,
    History,
    Ids,
    parts_of,
    recalled_of,
    recalls_of,
    sets_of,
)
from trackmarshal.backends.over_run.machines import kept
from trackmarshal.backends.witness import Descent
from trackmarshal.explaining.numbers import Env
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.reads import reads_itself
from trackmarshal.runtime.kleene import TRUE, connect
from trackmarshal.runtime.verdict import Truth, Witness
from trackmarshal.source import Span
from trackmarshal.units import moment

if TYPE_CHECKING:
    from trackmarshal.backends.reference.evaluator import Reference

T = TypeVar("T")
#: The most characters of a formula that a line repeats.
_WIDTH = 80


class Found(NamedTuple):
    """The comparison that decided, where it was evaluated, and the cycle's values."""

    node: ir.Formula
    env: Env
    values: Reference
    witness: Witness


@dataclass(slots=True)
class Trail:
    """One way down. said: a line for each operator on it; binders: what variables stand for."""

    history: History
    said: list[str] = field(default_factory=list)
    binders: dict[str, str | int] = field(default_factory=dict)

    def find(self, node: ir.Formula, k: int, ids: Ids) -> Found | None:
        """What decided a formula about cycle k; None where no comparison did: then the last line says what."""
        while parts_of(node) is not None and not recalls_of(node):
            step = self._step(node, k, ids)
            if step is None:
                return None
            node, k, ids = step
        return self._leaf(node, k, ids)

    def _leaf(self, node: ir.Formula, k: int, ids: Ids) -> Found | None:
        now = self.history.cycles[k].now
        assert now is not None, "cycles are kept whole where they are explained"
        missing = now.frame.unusable(reads_itself(node))
        if missing is not None:
            self.said.append(f"at {at(now.t)}: {missing}")
            return None
        known = {
            one: kept(one.machine, one.name, self.history.possible(one.machine, k, ids), now.t)
            for one in recalled_of(node)
        }
        values = now.reference(known)
        env = now.env(node, tuple(ids[axis.level] for axis in sets_of(node)))
        descent = Descent(values)
        witness = descent.find(node, env)
        if witness is None or descent.decisive is None:
            return None
        self.binders |= witness.binders
        return Found(*descent.decisive, values, witness)

    def _step(self, node: ir.Formula, k: int, ids: Ids) -> tuple[ir.Formula, int, Ids] | None:
        match node:
            case ir.OverRun():
                return self._over_run(node, k, ids)
            case ir.Counted():
                self._counted(node, k, ids)
                return None
            case ir.InState():
                self._in_state(node, k, ids)
                return None
            case ir.Not():
                return node.operand, k, ids
            case ir.Connective():
                return self._connective(node, k, ids), k, ids
            case ir.Guarded():
                guard, body = self._value(node.guard, k, ids), self._value(node.body, k, ids)
                doubtful = self._value(node, k, ids).verdict == "undefined" and body.verdict != "undefined"
                return (node.guard if doubtful or not guard.best.sat else node.body), k, ids
            case ir.Quantify():
                return self._quantify(node, k, ids)
            case _:
                raise AssertionError(f"{type(node).__name__} is no formula over the run")

    def _value(self, node: ir.Formula, k: int, ids: Ids) -> Truth:
        return self.history.value(node, k, {axis.level: ids[axis.level] for axis in sets_of(node)}).value

    def _connective(self, node: ir.Connective, k: int, ids: Ids) -> ir.Formula:
        sides = [(self._value(side, k, ids), side) for side in (node.left, node.right)]
        wanted = self._value(node, k, ids).verdict
        match node.op:
            case "and" | "or":
                found = _deciding(sides, wanted, node.op == "and")
            case "xor" | "iff":
                found = next((side for value, side in sides if value.verdict == "undefined"), node.left)
            case _:
                assert_never(node.op)
        return sides[0][1] if found is None else found

    def _quantify(self, node: ir.Quantify, k: int, ids: Ids) -> tuple[ir.Formula, int, Ids] | None:
        wanted = self._value(node, k, ids).verdict
        found: list[tuple[Truth, tuple[ir.Formula, str]]] = []
        doubtful: list[tuple[ir.Formula, str]] = []
        for name in self.history.cycles[k].ids[node.axis.signal]:
            inner = {**ids, node.axis.level: name}
            guard = TRUE if node.guard is None else self._value(node.guard, k, inner)
            if not guard.best.sat:
                continue
            body = self._value(node.body, k, inner)
            if guard.worst.sat or wanted != node.extreme.decisive:  # see `witness.Descent`
                found.append((body, (node.body, name)))
            if node.guard is not None and not guard.worst.sat and body.verdict == node.extreme.decisive:
                doubtful.append((node.guard, name))
        chosen = _deciding(found, wanted, node.extreme is Extreme.LEAST)
        if chosen is None and wanted == "undefined" and doubtful:
            chosen = doubtful[0]
        if chosen is None:
            self.said.append(
                f"{node.quantifier} {', '.join(node.names)} in {node.axis.signal}: there is none in range"
            )
            return None
        self.binders[node.names[0]] = chosen[1]
        return chosen[0], k, {**ids, node.axis.level: chosen[1]}

    def _placeless(self, node: ir.Remembered, k: int, ids: Ids) -> bool:
        """Say it where nothing is remembered of an element, as there was no place for it."""
        axis = self.history.without(node, ids, k) if node.past else None
        if axis is not None:
            name = ids[axis.level]
            self.said.append(
                f"nothing is remembered of {axis.signal} {name}: `capacity {axis.capacity}` leaves no place for it"
            )
        return axis is not None

    def _over_run(self, node: ir.OverRun, k: int, ids: Ids) -> tuple[ir.Formula, int, Ids] | None:
        if self._placeless(node, k, ids):
            return None
        given = list(self.history.elements(node, k, ids))
        value = self.history.value(node, k, {axis.level: ids[axis.level] for axis in sets_of(node)})
        wanted = value.value.verdict
        inside = [one for one in given if one.inside]
        match node.op:
            case "once" | "eventually" | "historically" | "always":
                every = node.op in ("historically", "always")
                chosen = _deciding([(one.values[0], one) for one in inside], wanted, every)
                of_all = wanted == ("satisfied" if every else "violated")
                return self._at(node, 0, chosen, inside, ids, of_all)
            case "since" | "until":
                side, chosen = _of_two(given, wanted)
                return self._at(node, side, chosen, inside, ids, False)
            case "previous" | "next":
                chosen = given[1] if len(given) > 1 else None
                return self._at(node, 0, chosen, given[1:2], ids, False)
            case _:
                assert_never(node.op)

    def _at(
        self, node: ir.OverRun, side: int, chosen: Element | None, inside: Sequence[Element], ids: Ids, of_all: bool
    ) -> tuple[ir.Formula, int, Ids] | None:  # fmt: skip
        """On to the cycle that decided. of_all: as all of them would have, it the least of them."""
        text, operand = shortened(node.span), node.operands[side]
        if chosen is None:
            where = (
                "there is no such cycle" if node.op in ("previous", "next") else "no cycle is in its window"
            )
            self.said.append(f"{text}: {where}")
            return None
        if chosen.place is None:
            self.said.append(
                f"{text}: {'cycles are missing there, and nothing is known of them' if chosen.final else 'what is to come decides'}"
            )
            return None
        times = [self.history.cycles[one.place].t for one in inside if one.place is not None]
        when = at(self.history.cycles[chosen.place].t)
        if of_all and len(times) > 1:
            self.said.append(
                f"{text}: the same in all {len(times)} cycles from {at(min(times))} to {at(max(times))}, nearest to its limit at {when}"
            )
        else:
            self.said.append(f"{text}: by the cycle at {when}")
        return operand, chosen.place, {axis.level: ids[axis.level] for axis in sets_of(operand)}

    def _counted(self, node: ir.Counted, k: int, ids: Ids) -> None:
        if self._placeless(node, k, ids):
            return
        sure: list[int] = []
        doubtful, surely_on = 0, True
        for one in self.history.elements(node, k, ids):
            counted, *resets = one.values
            if one.inside and counted.worst.sat and one.place is not None and surely_on:
                sure.append(self.history.cycles[one.place].t)
            elif one.inside and counted.best.sat:
                doubtful += one.cycles
            if any(reset.worst.sat for reset in resets):
                break
            surely_on = surely_on and not any(reset.best.sat for reset in resets)
        limit = self.history.cycles[k].number(node.limit)
        times = ", ".join(map(at, reversed(sure))) or "in none"
        more = f", and perhaps in {doubtful} more" if doubtful else ""
        self.said.append(
            f"{shortened(node.span)}: {len(sure)} ({times}{more}), to be compared with {limit:g}"
        )

    def _in_state(self, node: ir.InState, k: int, ids: Ids) -> None:
        now = self.history.cycles[k].t
        states = []
        for state, held in self.history.possible(node.machine, k, ids).items():
            begun = held[0]
            states.append(state if begun is None else f"{state} for {(now - begun) / 1e9:g} s")
        self.said.append(f"{node.machine.name} at {at(now)}: {' or '.join(states)}")


def _of_two(given: Sequence[Element], wanted: str) -> tuple[int, Element | None]:
    """Of `since` and `until`: what decided is the right side in the cycle that is best, or the left side where it did not hold until there."""
    held, ways = TRUE, list[tuple[Truth, int]]()
    for number, one in enumerate(given):
        left, right = one.values
        if one.inside:
            ways.append((connect("and", held, right), number))
        held = connect("and", held, left)
    best = _deciding(ways, wanted, False)
    if best is None:
        return 1, None
    sides = [(given[best].values[1], (1, given[best]))]
    sides += [(one.values[0], (0, one)) for one in given[:best]]
    return _deciding(sides, wanted, True) or (1, given[best])


def _deciding(values: Sequence[tuple[Truth, T]], wanted: str, least: bool) -> T | None:
    """The first with a verdict and, of those with it, the least or the greatest margin."""
    fitting = [(value.margin, one) for value, one in values if value.verdict == wanted]
    if not fitting:
        return None
    if wanted == "undefined":
        return fitting[0][1]
    return (min if least else max)(fitting, key=lambda each: each[0])[1]


def shortened(span: Span) -> str:
    """A stretch of a spec in one line."""
    text = span.in_line
    return text if len(text) <= _WIDTH else f"{text[: _WIDTH - 3]}..."


def at(t: int) -> str:
    """A stamp [ns] as people read it."""
    return f"{moment(t / 1e9)} s"
