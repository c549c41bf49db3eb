"""Formulas over the run, by their definitions: every cycle is kept, and every window is gone through. Slow, and meant to be obviously right.

Source: the language's sections on time over the run (docs/language.md). Stamps and windows are whole nanoseconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import product, zip_longest
from typing import assert_never

from trackmarshal.backends.over_run.counts import Range, compared
from trackmarshal.backends.over_run.machines import Possible, begun, is_in, kept, stepped, widened
from trackmarshal.backends.over_run.now import Now
from trackmarshal.backends.over_run.outcome import ALWAYS, Known
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.overrun import parts, recalled, recalls, sets
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.kleene import FALSE, TRUE, UNDEFINED, connect, greatest, least, negate
from trackmarshal.runtime.verdict import Bound, Truth

#: What variables of sets stand for, by the level of their axes: ids.
Ids = Mapping[int, str]
#: The value of a leaf for the elements that its variables stand for, in the order of its axes.
Leaf = Callable[[ir.Formula, tuple[str, ...]], Truth]


@dataclass(frozen=True, slots=True)
class Past:
    """One cycle: its stamp [ns], what it is called, which elements of each set were there, and the values of all leaves.

    missed: how many cycles between the one before and this one were refused, or did not come.
    """

    t: int
    name: object
    ids: Mapping[str, tuple[str, ...]]
    leaf: Leaf
    #: A number that no input changes.
    number: Callable[[ir.Num], float]
    missed: int = 0
    #: The cycle itself, for what is measured in it; None where that is not asked for.
    now: Now | None = None


@dataclass(frozen=True, slots=True)
class Element:
    """Something in an operator's window, or on the way to it: the operands' values in a cycle, in a gap, or in what is to come."""

    values: tuple[Truth, ...]
    inside: bool
    final: bool = True
    #: How many cycles this may be: of a gap, those that were missed.
    cycles: int = 1
    #: The cycle's place; None of a gap, of what is to come, and of what is no longer there.
    place: int | None = None


parts_of = cache(parts)
sets_of = cache(sets)
recalls_of = cache(recalls)
recalled_of = cache(recalled)


def parts_ahead(node: ir.Formula) -> tuple[ir.Formula, ...] | None:
    """The parts of a formula that looks ahead; None of one that looks back alone, or not at all: that is settled in its own cycle."""
    return parts_of(node) if looks_ahead(node) else None


@cache
def looks_ahead(node: ir.Formula) -> bool:
    """Whether a formula says something of cycles after its own."""
    return any(isinstance(part, ir.Remembered) and not part.past for part in ir.below(node))


#: What operators make of cycles that are no longer there, with what has to hold since then.
Earlier = Mapping[tuple[ir.OverRun, tuple[str, ...]], Truth]
#: What a formula is put together from; None: it is a leaf.
Parts = Callable[[ir.Formula], tuple[ir.Formula, ...] | None]


@dataclass(slots=True)
class History:
    """The cycles of a run up to now. ended: none will come after the last one. parts: down to which leaves formulas are taken apart."""

    cycles: Sequence[Past]
    ended: bool = False
    parts: Parts = parts_of
    #: What operators without a bound make of the cycles before the first one here, for the elements that were there until then.
    earlier: Earlier = field(default_factory=dict)
    _values: dict[tuple[ir.Formula, int, tuple[tuple[int, str], ...]], Known] = field(default_factory=dict)

    def value(self, node: ir.Formula, k: int, ids: Ids) -> Known:
        """The value of a formula about cycle k."""
        key = node, k, tuple(sorted(ids.items()))
        known = self._values.get(key)
        if known is None:
            known = self._values[key] = self._value(node, k, ids)
        return known

    def _value(self, node: ir.Formula, k: int, ids: Ids) -> Known:
        if self.parts(node) is None:
            return Known(self.cycles[k].leaf(node, tuple(ids[axis.level] for axis in sets_of(node))), True)
        if recalls_of(node):
            return Known(self._recalled(node, k, ids), True)
        match node:
            case ir.OverRun():
                return self._over_run(node, k, ids)
            case ir.Counted():
                return self._counted(node, k, ids)
            case ir.InState():
                # What its guards say is settled in their own cycles: they look back alone.
                return Known(is_in(self.possible(node.machine, k, ids), node.state), True)
            case ir.Not():
                operand = self.value(node.operand, k, ids)
                return Known(negate(operand.value), operand.final)
            case ir.Connective():
                left, right = self.value(node.left, k, ids), self.value(node.right, k, ids)
                return Known(connect(node.op, left.value, right.value), left.final and right.final)
            case ir.Guarded():
                guard, body = self.value(node.guard, k, ids), self.value(node.body, k, ids)
                worst = body.value.worst if guard.value.best.sat else TRUE.worst
                best = body.value.best if guard.value.worst.sat else TRUE.best
                return Known(Truth(worst, best), guard.final and body.final)
            case ir.Quantify():
                return self._quantify(node, k, ids)
            case _:
                raise AssertionError(f"{type(node).__name__} is no formula over the run")

    def _quantify(self, node: ir.Quantify, k: int, ids: Ids) -> Known:
        """As the reference does it in one cycle, over the elements that were there in cycle k."""
        every = node.extreme is Extreme.LEAST
        join = least if every else greatest
        worst = best = Bound(*node.extreme.neutral)
        final = True
        for name in self.cycles[k].ids[node.axis.signal]:
            inner = {**ids, node.axis.level: name}
            guard = Known(TRUE, True) if node.guard is None else self.value(node.guard, k, inner)
            body = self.value(node.body, k, inner)
            in_worst, in_best = guard.value.best.sat, guard.value.worst.sat
            if not every:
                in_worst, in_best = in_best, in_worst
            worst = join(worst, body.value.worst) if in_worst else worst
            best = join(best, body.value.best) if in_best else best
            final = final and guard.final and body.final
        return Known(Truth(worst, best), final)

    def _over_run(self, node: ir.OverRun, k: int, ids: Ids) -> Known:
        """From cycle k outwards: what the window holds, and of `since` and `until` what has to hold on the way there."""
        given = list(self.elements(node, k, ids))
        value, held = FALSE, TRUE
        match node.op:
            case "once" | "eventually":
                for element in given:
                    value = connect("or", value, element.values[0]) if element.inside else value
            case "historically" | "always":
                value = TRUE
                for element in given:
                    value = connect("and", value, element.values[0]) if element.inside else value
            case "since" | "until":
                for element in given:
                    left, right = element.values
                    value = connect("or", value, connect("and", held, right)) if element.inside else value
                    held = connect("and", held, left)
            case "previous" | "next":
                given = given[1:2]
                value = given[0].values[0] if given else TRUE if node.weak else FALSE
            case _:
                assert_never(node.op)
        return Known(value, all(element.final for element in given))

    def _counted(self, node: ir.Counted, k: int, ids: Ids) -> Known:
        """From cycle k backwards, up to the last one in which the count starts anew: that it surely does, or that it may."""
        given = list(self.elements(node, k, ids))
        sure = possible = 0
        surely_on = possibly_on = True
        for element in given:
            counted, *resets = element.values
            if element.inside:
                sure += surely_on * counted.worst.sat
                possible += possibly_on * counted.best.sat * element.cycles
            for reset in resets:
                surely_on, possibly_on = surely_on and not reset.best.sat, possibly_on and not reset.worst.sat
        limit = self.cycles[k].number(node.limit)
        return Known(compared(node, Range(sure, possible), limit), all(element.final for element in given))

    def possible(self, machine: ir.Machine, k: int, ids: Ids) -> Possible:
        """What a machine may be in after cycle k: from the first cycle of its life on, cycle by cycle."""
        members = self._members(machine, ids, k)[0]
        possible = begun(machine, self.cycles[members[0]].t)
        for before, this in zip((None, *members), members[: members.index(k) + 1]):
            if before is not None and self.cycles[this].missed:
                possible = widened(machine, possible)
            guards = [self._settled(guard, this, ids) for guard in machine.guards]
            now = self._now(this)
            possible = stepped(
                machine,
                possible,
                now.t,
                guards,
                lambda number, now=now: now.measured(number, _named(number, ids)),  # type: ignore[misc]
            )
        return possible

    def _recalled(self, node: ir.Formula, k: int, ids: Ids) -> Truth:
        now = self._now(k)
        known = {
            one: kept(one.machine, one.name, self.possible(one.machine, k, ids), now.t)
            for one in recalled_of(node)
        }
        return now.recalled(node, _named(node, ids), known)

    def _now(self, k: int) -> Now:
        now = self.cycles[k].now
        assert now is not None, "machines are folded where cycles are kept"
        return now

    def _settled(self, node: ir.Formula, k: int, ids: Ids) -> Truth:
        return self.value(node, k, {axis.level: ids[axis.level] for axis in sets_of(node)}).value

    def folded(self, nodes: Sequence[ir.OverRun], count: int) -> Earlier:
        """What operators make of the first cycles, when these are dropped: their values about the last of them, by element."""
        if not count:
            return self.earlier
        last, found = count - 1, dict[tuple[ir.OverRun, tuple[str, ...]], Truth]()
        for node in nodes:
            axes = sets_of(node)
            for key in product(*(self.cycles[last].ids[axis.signal] for axis in axes)):
                ids = {axis.level: name for axis, name in zip(axes, key)}
                found[node, key] = self.value(node, last, ids).value
        return found

    def elements(self, node: ir.Remembered, k: int, ids: Ids) -> Iterator[Element]:
        """What there is from cycle k outwards, as far as the window reaches: cycles, gaps between them, and what is to come."""
        lower, upper = node.lower or 0, math.inf if node.upper is None else node.upper
        t = self.cycles[k].t
        low, high = (t - upper, t - lower) if node.past else (t + lower, t + upper)
        unknown = (UNDEFINED,) * len(node.operands)
        members, open_ = self._members(node, ids, k)
        at = members.index(k)
        outwards = members[at::-1] if node.past else members[at:]
        for this, following in zip_longest(outwards, outwards[1:]):
            now = self.cycles[this].t
            if now < low if node.past else now > high:
                return
            known = [
                self.value(operand, this, {axis.level: ids[axis.level] for axis in sets_of(operand)})
                for operand in node.operands
            ]
            final = all(one.final for one in known)
            yield Element(tuple(one.value for one in known), low <= now <= high, final, place=this)
            if following is None:
                break
            between = range(this, following, -1) if node.past else range(this + 1, following + 1)
            for later in between:
                if self.cycles[later].missed:
                    begin, end = self.cycles[later - 1].t, self.cycles[later].t
                    yield Element(unknown, begin < high and end > low, cycles=self.cycles[later].missed)
        if open_ and not node.past and self.cycles[-1].t < high:
            yield Element(unknown, True, False)
        if (
            isinstance(node, ir.OverRun)
            and node.past
            and members[0] == 0
            and node.upper is None
            and node.op != "previous"
        ):
            earlier = self.earlier.get((node, tuple(ids[axis.level] for axis in sets_of(node))))
            if earlier is not None:
                if self.cycles[0].missed:
                    yield Element(unknown, True)
                # What `since` came to there is what it comes to from there on, as long as its left side holds.
                yield Element((TRUE, earlier)[-len(node.operands) :], True)

    def _members(self, node: ir.Remembered | ir.Machine, ids: Ids, k: int) -> tuple[Sequence[int], bool]:
        """The cycles of the life, around cycle k, of what an operator is about, and whether it may go on."""
        members: Sequence[int] = range(len(self.cycles))
        open_ = not self.ended
        for axis in sets_of(node):
            life = self._life(axis.signal, ids[axis.level], k)
            members = [j for j in members if j in life]
            open_ = open_ and len(self.cycles) - 1 in life
        return members, open_

    def _life(self, signal: str, name: str, k: int) -> set[int]:
        """The cycles around k in which an element was there without interruption."""
        life = {k}
        for step in (-1, 1):
            j = k + step
            while 0 <= j < len(self.cycles) and name in self.cycles[j].ids[signal]:
                life.add(j)
                j += step
        return life


def _named(node: ir.Formula | ir.Num, ids: Ids) -> tuple[str, ...]:
    return tuple(ids[axis.level] for axis in sets_of(node))


def values_of(history: History) -> Callable[[RuleInfo, int], tuple[Known, Known]]:
    """The values of a rule's formula, and of where it applies, about any cycle of a history."""

    def value(rule: RuleInfo, place: int) -> tuple[Known, Known]:
        assert rule.formula is not None
        active = ALWAYS if rule.active is None else history.value(rule.active, place, {})
        return history.value(rule.formula, place, {}), active

    return value
