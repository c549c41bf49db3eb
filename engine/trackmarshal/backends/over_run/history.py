"""Formulas over the run, by their definitions: every cycle is kept, and every window is gone through. Slow, and meant to be obviously right.

Source: the language's sections on time over the run (docs/language.md). Stamps and windows are whole nanoseconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import product, zip_longest
from typing import NamedTuple, assert_never

from trackmarshal.backends.over_run.counts import Range, compared
from trackmarshal.backends.over_run.hoping import Hope, Hoping
from trackmarshal.backends.over_run.lives import ANY_CYCLES
from trackmarshal.backends.over_run.machines import Possible, begun, is_in, kept, stepped, unknown, widened
from trackmarshal.backends.over_run.now import Now
from trackmarshal.backends.over_run.outcome import ALWAYS, Known, Values
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.overrun import back, looks_ahead, parts, recalled, recalls, sets
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


class Element(NamedTuple):
    """Something in an operator's window, or on the way to it: the operands' values in a cycle, in a gap, or in what is to come."""

    values: tuple[Truth, ...]
    inside: bool
    final: bool = True
    #: How many cycles this may be: of a gap, those that were missed.
    cycles: int = 1
    #: The cycle's place; None of a gap, of what is to come, and of what is no longer there.
    place: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Life:
    """One life of an element; sure: it is known that nothing was before it."""

    sure: bool


parts_of = cache(parts)
sets_of = cache(sets)
recalls_of = cache(recalls)
recalled_of = cache(recalled)


def parts_ahead(node: ir.Formula) -> tuple[ir.Formula, ...] | None:
    """The parts of a formula that looks ahead; None of one that looks back alone, or not at all: that is settled in its own cycle."""
    return parts_of(node) if looks_ahead(node) else None


#: What operators make of cycles that are no longer there, with what has to hold since then.
Earlier = Mapping[tuple[ir.OverRun, tuple[str, ...]], Truth]
#: What a formula is put together from; None: it is a leaf.
Parts = Callable[[ir.Formula], tuple[ir.Formula, ...] | None]


@dataclass(slots=True)
class Settled:
    """What was found out of the cycles with which several histories begin: what machines may be in after each of them, and what formulas that look
    back alone come to about it, by the node, the place of the cycle and what variables stand for.

    No cycle that comes later changes any of it: windows that look back end in their own cycle, a machine is folded from the first cycle of a life up
    to the one that is asked about, its guards look back alone, and which life an element lives in a cycle (`lived`) is known from those up to it.
    """

    values: dict[tuple[ir.Formula, int, tuple[tuple[int, str], ...]], Known] = field(default_factory=dict)
    possible: dict[tuple[ir.Machine, int, tuple[tuple[int, str], ...]], Possible] = field(
        default_factory=dict
    )


@cache
def _looks_back(node: ir.OverRun) -> tuple[int, int]:
    """How far before a cycle the operands of an operator look for their values about it: nanoseconds, and cycles."""
    each = [back(operand) for operand in node.operands]
    return max(reach for reach, _ in each), max(steps for _, steps in each)


def _first_known(node: ir.OverRun, cycles: Sequence[Past]) -> int:
    """The first cycle about which the operands of an operator can be known when there is none before these."""
    reach, steps = _looks_back(node)
    return next(place for place in range(steps, len(cycles)) if cycles[place].t - cycles[0].t >= reach)


@dataclass(slots=True)
class History:
    """The cycles of a run up to now. ended: none will come after the last one. parts: down to which leaves formulas are taken apart.

    common: with how many cycles all others begin that share `settled` with it; they have the same `parts`, and nothing `earlier`.
    """

    cycles: Sequence[Past]
    ended: bool = False
    parts: Parts = parts_of
    #: What operators without a bound make of the cycles before the first one here, for the elements that were there until then.
    earlier: Earlier = field(default_factory=dict)
    common: int = 0
    settled: Settled = field(default_factory=Settled)
    #: The same of cycles that no other history has, and of formulas that look ahead.
    _own: Settled = field(default_factory=Settled)
    _known_lives: dict[ir.Axis, list[dict[str, Life | None]]] = field(default_factory=dict)

    def value(self, node: ir.Formula, k: int, ids: Ids) -> Known:
        """The value of a formula about cycle k."""
        key = node, k, _sorted(ids)
        values = (self.settled if k < self.common and not looks_ahead(node) else self._own).values
        known = values.get(key)
        if known is None:
            known = values[key] = self._value(node, k, ids)
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
        if node.past and self.without(node, ids, k):
            return Known(UNDEFINED, True)
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
        limit = self.cycles[k].number(node.limit)
        if self.without(node, ids, k):
            return Known(compared(node, Range(0, ANY_CYCLES), limit), True)
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
        return Known(compared(node, Range(sure, possible), limit), all(element.final for element in given))

    def possible(self, machine: ir.Machine, k: int, ids: Ids) -> Possible:
        """What a machine may be in after cycle k: from the first cycle of its life on, cycle by cycle, each of which is gone through once."""
        own = _sorted(ids)
        found = self._stepped(k).get((machine, k, own))
        if found is not None:
            return found
        if self.without(machine, ids, k):
            return unknown(machine)
        members = self._members(machine, ids, k)[0]
        sure = self._sure(machine, ids, k)
        possible = begun(machine, self.cycles[members[0]].t) if sure else unknown(machine)
        for before, this in zip((None, *members), members[: members.index(k) + 1]):
            known = self._stepped(this).get((machine, this, own))
            if known is None:
                if before is not None and self._between(before, this):
                    gap = self.cycles[this].t - self.cycles[before].t
                    possible = widened(machine, possible, gap)
                guards = [self._settled(guard, this, ids) for guard in machine.guards]
                now = self._now(this)
                known = self._stepped(this)[machine, this, own] = stepped(
                    machine,
                    possible,
                    now.t,
                    guards.__getitem__,
                    lambda number, now=now: now.measured(number, _named(number, ids)),  # type: ignore[misc]
                )
            possible = known
        return possible

    def _stepped(self, k: int) -> dict[tuple[ir.Machine, int, tuple[tuple[int, str], ...]], Possible]:
        """Where it is kept what machines may be in after cycle k."""
        return (self.settled if k < self.common else self._own).possible

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
        """What operators make of the first cycles, when `count` of these are dropped, by element: their values about the first one of which
        they can still be known."""
        if not count:
            return self.earlier
        found = dict[tuple[ir.OverRun, tuple[str, ...]], Truth]()
        for node in nodes:
            last = count + _first_known(node, self.cycles[count:])
            for ids in self.combinations(node, last):
                found[node, tuple(ids.values())] = self.value(node, last, ids).value
        return found

    def combinations(self, node: ir.Formula, k: int) -> Iterator[Ids]:
        """The elements of a cycle that the variables of a formula can stand for."""
        axes = sets_of(node)
        for key in product(*(self.cycles[k].ids[axis.signal] for axis in axes)):
            yield {axis.level: name for axis, name in zip(axes, key)}

    def elements(self, node: ir.Remembered, k: int, ids: Ids) -> Iterator[Element]:
        """What there is from cycle k outwards, as far as the window reaches: cycles, gaps between them, and what is to come."""
        lower, upper = node.lower or 0, math.inf if node.upper is None else node.upper
        t = self.cycles[k].t
        low, high = (t - upper, t - lower) if node.past else (t + lower, t + upper)
        unknown = (UNDEFINED,) * len(node.operands)
        members, open_ = self._members(node, ids, k)
        at = members.index(k)
        outwards = members[at::-1] if node.past else members[at:]
        before = self._before(node, ids, members)
        if before is not None:
            if k < before:
                raise AssertionError("nothing is asked about what is folded")
            if k == before:
                yield Element(self._came_to(node, ids), True)
                return
            outwards = [j for j in outwards if j >= before]
        for this, following in zip_longest(outwards, outwards[1:]):
            if this == before:
                # What `since` came to there is what it comes to from there on, as long as its left side holds.
                yield Element(self._came_to(node, ids), True)
                return
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
            if node.past:
                if many := self._between(following, this):
                    begin, end = self.cycles[following].t, now
                    yield Element(unknown, begin < high and end > low, cycles=many)
                continue
            for later in range(this + 1, following + 1):
                if self.cycles[later].missed:
                    begin, end = self.cycles[later - 1].t, self.cycles[later].t
                    yield Element(unknown, begin < high and end > low, cycles=self.cycles[later].missed)
        if open_ and not node.past and self.cycles[-1].t < high:
            yield Element(unknown, True, False)
        if node.past and not self._sure(node, ids, k):
            # So many cycles as may be, up to the first one.
            yield Element(unknown, self.cycles[members[0]].t > low, cycles=ANY_CYCLES)

    def _before(self, node: ir.Remembered, ids: Ids, members: Sequence[int]) -> int | None:
        """The cycle about which it is known what an operator without a bound came to, as those before it are dropped; None where it has to be
        looked at all of them."""
        if not isinstance(node, ir.OverRun) or self._folded(node, ids) is None:
            return None
        place = _first_known(node, self.cycles)
        return place if place in members else None

    def _folded(self, node: ir.OverRun, ids: Ids) -> Truth | None:
        return self.earlier.get((node, tuple(ids[axis.level] for axis in sets_of(node))))

    def _came_to(self, node: ir.Remembered, ids: Ids) -> tuple[Truth, ...]:
        """Operands with which an operator comes to what it came to."""
        assert isinstance(node, ir.OverRun)
        earlier = self._folded(node, ids)
        assert earlier is not None
        return (TRUE, earlier)[-len(node.operands) :]

    def _members(self, node: ir.Remembered | ir.Machine, ids: Ids, k: int) -> tuple[Sequence[int], bool]:
        """The cycles of the life, around cycle k, of what an operator is about, and whether it may go on."""
        members: Sequence[int] = range(len(self.cycles))
        open_ = not self.ended
        for axis in sets_of(node):
            name = ids[axis.level]
            if axis.forget and (isinstance(node, ir.Machine) or node.past):
                known = self._lives(axis)
                own = known[k][name]
                life = {j for j, each in enumerate(known) if own is not None and each.get(name) is own}
            else:
                life = self._life(axis.signal, name, k)
            members = [j for j in members if j in life]
            open_ = open_ and len(self.cycles) - 1 in life
        return members, open_

    def _between(self, before: int, this: int) -> int:
        """How many cycles lie between two: those that were missed, and those in which what an operator is about was not there."""
        missed = sum(self.cycles[later].missed for later in range(before + 1, this + 1))
        return this - before - 1 + missed

    def without(self, node: ir.Remembered | ir.Machine, ids: Ids, k: int) -> ir.Axis | None:
        """The set of an element that an operator is about, and for which there was no place in cycle k; None where there is none."""
        for axis in sets_of(node):
            if axis.forget and self._lives(axis)[k][ids[axis.level]] is None:
                return axis
        return None

    def placeless(self, axis: ir.Axis) -> list[str]:
        """The elements of the last cycle for which there is no place."""
        return [name for name, life in self._lives(axis)[-1].items() if life is None]

    def _sure(self, node: ir.Remembered | ir.Machine, ids: Ids, k: int) -> bool:
        """Whether it is known that nothing was before the lives of the elements that an operator is about."""
        lives = [self._lives(axis)[k][ids[axis.level]] for axis in sets_of(node) if axis.forget]
        return all(life is not None and life.sure for life in lives)

    def _lives(self, axis: ir.Axis) -> list[dict[str, Life | None]]:
        """In every cycle, which life the elements of a set live that may be absent; None: there was no place for it."""
        known = self._known_lives.get(axis)
        if known is None:
            cycles = [(cycle.t, cycle.ids[axis.signal]) for cycle in self.cycles]
            known = self._known_lives[axis] = lived(cycles, axis.forget, axis.capacity or 0)
        return known

    def _life(self, signal: str, name: str, k: int) -> set[int]:
        """The cycles around k in which an element was there without interruption."""
        life = {k}
        for step in (-1, 1):
            j = k + step
            while 0 <= j < len(self.cycles) and name in self.cycles[j].ids[signal]:
                life.add(j)
                j += step
        return life


def lived(
    cycles: Sequence[tuple[int, Sequence[str]]], forget: int, capacity: int
) -> list[dict[str, Life | None]]:
    """Which life each element lives in which cycle, of their stamps [ns] and who is there; None: there is no place for it.

    A life goes on after an absence of up to `forget`; as long as it may, it has one of so many places, which are given in the order of the input.
    """
    found: list[dict[str, Life | None]] = []
    held: dict[str, tuple[Life, int]] = {}
    lost: int | None = None
    for k, (t, ids) in enumerate(cycles):
        for name, (_, last) in list(held.items()):
            absence = t - cycles[last][0]
            back = name in ids and (last == k - 1 or absence <= forget)
            if not back and (name in ids or absence >= forget):
                del held[name]
        sure = lost is None or (lost != k - 1 and t - cycles[lost][0] > forget)
        now: dict[str, Life | None] = {}
        for name in ids:
            life = held[name][0] if name in held else Life(sure) if len(held) < capacity else None
            now[name] = life
            if life is None:
                lost = k
            else:
                held[name] = life, k
        found.append(now)
    return found


def _sorted(ids: Ids) -> tuple[tuple[int, str], ...]:
    return tuple(ids.items()) if len(ids) < 2 else tuple(sorted(ids.items()))


def _named(node: ir.Formula | ir.Num, ids: Ids) -> tuple[str, ...]:
    return tuple(ids[axis.level] for axis in sets_of(node))


def values_of(history: History) -> Values:
    """What rules come to about any cycle of a history."""

    def value(rule: RuleInfo, place: int) -> tuple[Known, Known]:
        assert rule.formula is not None
        active = ALWAYS if rule.active is None else history.value(rule.active, place, {})
        return history.value(rule.formula, place, {}), active

    def may_hold(rule: RuleInfo, place: int) -> bool:
        assert rule.formula is not None

        def settled(node: ir.Formula, ids: Ids) -> Hope:
            found = history.value(node, place, ids).value
            return Hope(found.worst.sat, not found.best.sat)

        hoping = Hoping(settled, lambda axis: history.cycles[place].ids[axis.signal])
        return bool(hoping.hope(rule.formula, {}).true)

    return Values(value, may_hold)
