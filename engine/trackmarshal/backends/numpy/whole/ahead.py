"""Formulas that look ahead, along the cycles of a run: when each is decided, and what it comes to in the cycle in which it is.

When a formula is surely true, and when surely false, is reckoned as margins are: of a conjunction the later and the earlier of both, of a
window the latest and the earliest of all. Times are places of cycles in a piece, never before the cycle itself; NEVER: not yet.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Never, assert_never

import numpy as np

from trackmarshal.backends.numpy import temporal
from trackmarshal.backends.numpy.logic import Value, negate
from trackmarshal.backends.numpy.temporal.blocks import Choice
from trackmarshal.backends.numpy.temporal.carrier import MARGIN, VERDICT, Carrier, Rows
from trackmarshal.backends.numpy.temporal.windows import Edge, Windows, edge_at
from trackmarshal.backends.numpy.whole import values
from trackmarshal.backends.numpy.whole.elements import Elements, Indices, Stamps, edge_of
from trackmarshal.backends.numpy.whole.firsts import NEVER, STAYS, Firsts
from trackmarshal.backends.numpy.whole.outcomes import agree
from trackmarshal.backends.numpy.whole.spans import Levels, Spans
from trackmarshal.backends.numpy.whole.values import Bools, Floats, Pair, pairs
from trackmarshal.backends.over_run.hoping import Hope, Hoping, Ids
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import leaves
from trackmarshal.runtime.kleene import UNDEFINED

#: The value of a formula that is settled in its own cycle, in all cycles of a piece.
Settled = Callable[[ir.Formula], Value]


@dataclass(eq=False)
class Times:
    """(cycles,) or (elements,) each: the place of the cycle in which a formula is surely true, and that of the one in which it is surely false."""

    true: Indices
    false: Indices


class Looking:
    """A piece of a run, from the oldest cycle that is open on, for formulas that look ahead.

    ended: nothing comes after it, which is known one place after its last cycle. parts: what formulas are put together from; None of settled ones.
    """

    def __init__(
        self, stamps: Stamps, elements: Elements, settled: Settled, ended: bool,
        parts: Callable[[ir.Formula], tuple[ir.Formula, ...] | None],
    ) -> None:  # fmt: skip
        self._stamps, self._elements, self._settled, self._ended, self._parts = (
            stamps,
            elements,
            settled,
            ended,
            parts,
        )
        self._count = len(stamps)
        self.places: Indices = np.arange(self._count)
        #: Where each cycle is among the elements.
        self._at: Indices = self.places if elements.cycles is None else elements.cycles
        self._times: dict[ir.Formula, Times] = {}
        self._whole: dict[ir.Formula, Value] = {}
        self._spans: dict[tuple[ir.Formula, int, int], Spans] = {}
        self._spread: dict[ir.Formula, Value] = {}
        self._closings: dict[ir.Formula, Indices] = {}
        self._agreeing: dict[ir.OverRun, bool] = {}
        #: Of an operator that is all of a formula, and of which nothing is undefined: whether it holds, in the cycle in which it is decided.
        self._holds: dict[ir.Formula, Bools] = {}

    # When -----------------------------------------------------------------------------------------------------

    def final(self, node: ir.Formula) -> Indices:
        """(cycles,): in which cycle nothing to come can change a formula any more."""
        below = self._parts(node)
        if below is None:
            return self.places
        if isinstance(node, ir.OverRun):
            return self._closed(node)
        found = self.final(below[0])
        for part in below[1:]:
            found = np.maximum(found, self.final(part))
        return found

    def first(self, node: ir.Formula) -> Indices:
        """(cycles,): in which cycle a whole formula is decided, or nothing to come can change it any more."""
        if isinstance(node, ir.OverRun) and node.op != "next" and self._elements.cycles is None:
            operands = list(map(self._operand, node.operands))
            if all(low is best for low, best in operands):
                # A window is closed behind its last element, at the latest: what comes after that decides nothing.
                first, self._holds[node] = self._settles(node, [low[0] for low, _ in operands])
                return np.minimum(first, self._closed(node), out=first)
        times = self.times(node)
        return np.minimum(np.minimum(times.true, times.false), self.final(node))

    def _settles(self, node: ir.OverRun, holds: list[Bools]) -> tuple[Indices, Bools]:
        """(cycles,): where an operator is decided of which nothing is undefined, before its window is closed, or NEVER or behind that window; and
        whether it holds. holds: (elements,) whether its operands do; there are no gaps."""
        firsts = Firsts(self._windows(node), self._elements)
        match node.op:
            case "eventually":
                return firsts.found(holds[0])
            case "always":
                fails, broken = firsts.found(~holds[0])
                return fails, ~broken
            case "until":
                return firsts.settles(*holds)
            case _:
                raise AssertionError(f"`{node.op}` does not look ahead")

    def times(self, node: ir.Formula) -> Times:
        """(cycles,): when a formula is decided."""
        known = self._times.get(node)
        if known is None:
            known = self._times[node] = self._when(node)
        return known

    def _when(self, node: ir.Formula) -> Times:
        if self._parts(node) is None:
            return _decided(self._settled(node), self.places)
        match node:
            case ir.Not():
                return _not(self.times(node.operand))
            case ir.Connective():
                a, b = self.times(node.left), self.times(node.right)
                match node.op:
                    case "and":
                        return _and(a, b)
                    case "or":
                        return _or(a, b)
                    case "xor":
                        return _or(_and(a, _not(b)), _and(_not(a), b))
                    case "iff":
                        return _not(_or(_and(a, _not(b)), _and(_not(a), b)))
                    case _:
                        assert_never(node.op)
            case ir.Guarded():
                return _or(_not(self.times(node.guard)), self.times(node.body))
            case ir.OverRun():
                return self._when_over_run(node)
            case _:
                raise AssertionError(f"{type(node).__name__} does not look ahead over the cycles of a piece")

    def _when_over_run(self, node: ir.OverRun) -> Times:
        closed = self._closed(node)
        if node.op == "next":
            of_each = self._of_elements(node.operands[0])
            found = self._next(of_each.true), self._next(of_each.false)
            if self._ended:  # there is no cycle after the last one
                found[0][-1:] = closed[-1:] if node.weak else NEVER
                found[1][-1:] = NEVER if node.weak else closed[-1:]
            return Times(*found)
        firsts = Firsts(self._windows(node), self._elements)
        match node.op:
            case "eventually":
                ((holds, _), (may, _)) = self._operand(node.operands[0])
                true, nowhere = firsts.decided(holds, may)
                return Times(true, np.where(nowhere, closed, NEVER))
            case "always":
                ((holds, _), (may, _)) = self._operand(node.operands[0])
                fails = ~may
                false, nowhere = firsts.decided(fails, fails if may is holds else ~holds)
                return Times(np.where(nowhere, closed, NEVER), false)
            case "until":
                held, goal = ((worst[0], best[0]) for worst, best in map(self._operand, node.operands))
                true, false = firsts.until(held, goal)
                return Times(true, np.where(false == STAYS, closed, false))
            case _:
                raise AssertionError(f"`{node.op}` does not look ahead")

    def _closed(self, node: ir.OverRun) -> Indices:
        """(cycles,): the cycle in which nothing comes into a window any more."""
        found = self._closings.get(node)
        if found is not None:
            return found
        if node.op == "next":
            found = self.places + 1
        else:
            assert node.upper is not None, "what looks ahead has a bound"
            found = self._first_after(node.upper)
        if not self._ended:
            found[np.searchsorted(found, self._count) :] = NEVER  # they never decrease
        self._closings[node] = found
        return found

    def _first_after(self, reach: int) -> Indices:
        """(cycles,): the first cycle that is at least so many nanoseconds after each; as many as there are: none."""
        stamps, count = self._stamps, self._count
        until = stamps + reach
        if self._elements.cycles is not None:
            edge = edge_of(stamps, until, "left")
            return edge_at(edge, 0, count, count).copy()
        # The windows of operators end behind the last cycle that is not after it.
        end = edge_at(self._elements.reached(reach), 0, count, count)
        reached = stamps.take(end - 1) == until
        # Seldom is a cycle just as much later.
        found: Indices = end - reached if reached.any() else end.copy()
        return found

    def _of_elements(self, node: ir.Formula) -> Times:
        """(elements,): nothing of a gap is ever decided."""
        times = self.times(node)
        if self._elements.cycles is None:
            return times
        made = [np.full(len(self._elements), NEVER) for _ in range(2)]
        made[0][self._at], made[1][self._at] = times.true, times.false
        return Times(*made)

    def hopeless(self, node: ir.Formula) -> Bools | None:
        """(cycles,): of which so much is undefined in the cycle itself that nothing to come can make a formula surely true; None: of none."""
        settled = [self._settled(leaf) for leaf in leaves(node, self._parts)]
        if all(value.best is value.worst for value in settled):
            return None

        def of(leaf: ir.Formula, _: Ids) -> Hope:
            worst, best = pairs(self._settled(leaf))
            return Hope(worst[0], ~best[0])

        def nobody(axis: ir.Axis) -> Never:
            raise AssertionError(f"`{axis.signal}` is not known over the cycles of a piece")

        return ~np.broadcast_to(Hoping(of, nobody).hope(node, {}).true, self._count)

    # What -----------------------------------------------------------------------------------------------------

    def value(self, node: ir.Formula, about: Indices, now: Indices) -> Value:
        """The values of a formula about some cycles, each as it is known in a later one."""
        if self._parts(node) is None:
            return values.taken(self._settled(node), about)
        match node:
            case ir.Not():
                return negate(self.value(node.operand, about, now))
            case ir.Connective():
                return values.connected(
                    node.op, self.value(node.left, about, now), self.value(node.right, about, now)
                )
            case ir.Guarded():
                return values.guarded(self.value(node.guard, about, now), self.value(node.body, about, now))
            case ir.OverRun():
                open_ = np.flatnonzero(now < self._closed(node).take(about))
                if not len(open_):
                    return values.taken(self._in_whole(node), about)
                if len(open_) == len(about):
                    return self._so_far(node, about, now)
                found = values.taken(self._in_whole(node), about)
                return values.put(found, open_, self._so_far(node, about.take(open_), now.take(open_)))
            case _:
                raise AssertionError(f"{type(node).__name__} does not look ahead over the cycles of a piece")

    def decided(self, node: ir.Formula, chosen: Choice, now: Indices) -> Value:
        """The values of a whole formula about some cycles, in which cycle it is decided. Of a side that has no say in that it may be anything that decides the same."""
        about = self.places[chosen]
        if not (isinstance(node, ir.OverRun) and node.op != "next" and self._agree(node)):
            return self.value(node, about, now)
        if node in self._holds:
            sat = self._holds[node][chosen]
            margins = self._decisive if node.op == "until" else self._extreme
            side = sat, margins(node, chosen, now, sat)
            return values.of(side, side)
        if node.op != "until":
            return self.value(node, about, now)
        times = self.times(node)
        sat, fails = _at(times.true, chosen) == now, _at(times.false, chosen) == now
        margin = self._decisive(node, chosen, now, sat)
        side = sat, margin
        found = values.of(side, side)
        if np.count_nonzero(sat) + np.count_nonzero(fails) == len(about):
            return found
        rest = np.flatnonzero(~(sat | fails))
        return values.put(found, rest, self.value(node, about.take(rest), now.take(rest)))

    def _decisive(self, node: ir.OverRun, chosen: Choice, now: Indices, sat: Bools) -> Floats:
        """The margins of `until` about some cycles, of operands that agree: where its goal is reached now (`sat`), and where now what had to hold does
        not, or the window is closed. Goals before the one that is reached have no margins above zero, nor have any where it fails; and what held until
        then has none below: of the former all but the last is left out, of the latter what held."""
        windows, last, first = self._windows(node), self._among(now), self._at[chosen]
        (held, may_hold), (goal, may_be) = (
            (low[1], best[1]) for low, best in map(self._operand, node.operands)
        )
        of, n = chosen if self._elements.cycles is None else first, windows.n
        mostly = bool(2 * np.count_nonzero(sat) > len(sat))
        most, few = (goal, may_hold) if mostly else (may_hold, goal)
        found: Floats = most.take(last)
        others = np.flatnonzero(sat != mostly)
        found[others] = few.take(last.take(others))
        found[np.flatnonzero((now >= _at(self._closed(node), chosen)) > sat)] = -np.inf
        # No goal says more than the greatest of all, and where the window has not begun there is none.
        begin = _edge_of(windows.begin, of, first, n)
        fails = np.flatnonzero(((found < may_be.max(initial=-np.inf)) & (begin <= last)) > sat)
        begin = begin.take(fails)
        end = np.minimum(_edge_of(windows.end, of, first, n).take(fails), last.take(fails) + 1)
        seen = Spans(None, may_be, MARGIN).until(Levels(begin, np.maximum(begin, end), n))
        found[fails] = np.maximum(found.take(fails), seen)
        # What has to hold until then has to on the way to the window, too.
        later = np.flatnonzero(sat & (last > first))
        later = later.compress(found.take(later) > held.min(initial=np.inf))
        before = Spans(held, None, MARGIN).all(Levels(first.take(later), last.take(later), n))
        found[later] = np.minimum(found.take(later), before)
        return found

    def _extreme(self, node: ir.OverRun, chosen: Choice, now: Indices, sat: Bools) -> Floats:
        """The margins of `always` and `eventually` about some cycles, of an operand that agrees and of which nothing is undefined, without gaps: where the
        present cycle decides it, no cycle before says as much; of all others the window is closed."""
        margins = self._operand(node.operands[0])[0][1]
        found: Floats = margins.take(now)
        rest = places_of(sat if node.op == "always" else ~sat)
        closed = found[rest]
        if closed.size:
            windows = self._windows(node)
            if isinstance(chosen, slice):  # those of later cycles are not closed
                windows = replace(windows, asked=chosen.stop)
            of_all = temporal.extrema([(margins, MARGIN)], windows, least=node.op == "always")[0]
            found[rest] = of_all[chosen][rest]
        return found

    def _among(self, places: Indices) -> Indices:
        """Where some cycles are among the elements."""
        return places if self._elements.cycles is None else self._at.take(places)

    def _in_whole(self, node: ir.OverRun) -> Value:
        """(cycles,): the values of an operator once its windows are closed; of others anything."""
        known = self._whole.get(node)
        if known is None:
            # Whether it holds is known: a closed window that has not surely decided it otherwise.
            times, given = self.times(node), [self._operand(operand) for operand in node.operands]
            worst = times.true != NEVER, self._margins(node, [low[1] for low, _ in given])
            known = values.of(worst, worst)
            if not all(low is best for low, best in given):
                best = times.false == NEVER, self._margins(node, [best[1] for _, best in given])
                known = values.of(worst, best)
            self._whole[node] = known
        return known

    def _margins(self, node: ir.OverRun, given: list[Floats]) -> Floats:
        """(cycles,): the margins of whole windows, given those of the operands."""
        match node.op:
            case "next":
                found = temporal.shift(given[0] >= 0.0, given[0], 1, node.weak)[1]
            case "eventually" | "always":
                found = temporal.extrema(
                    [(given[0], MARGIN)], self._windows(node), least=node.op == "always"
                )[0]
            case "until":
                found = temporal.held([(given[0], given[1], MARGIN)], self._windows(node))[0]
            case _:
                raise AssertionError(f"`{node.op}` does not look ahead")
        margins: Floats = self._elements.of_cycles(found)
        return margins

    def _so_far(self, node: ir.OverRun, about: Indices, now: Indices) -> Value:
        """The values of an operator while its windows are open: whatever comes may still be in them."""
        match node.op:
            case "next":
                return values.constant(UNDEFINED, len(about))
            case "always" | "eventually" if self._agree(node):
                # Where the present cycle decides it, no cycle before says as much.
                times = self.times(node)
                decided = times.false if node.op == "always" else times.true
                operand, at = self._operand(node.operands[0]), self._at.take(now)
                found = _halves(
                    node, lambda best: (operand[best][0].take(at), operand[best][1].take(at)), len(about)
                )
                rest = np.flatnonzero(decided.take(about) != now)
                return (
                    values.put(found, rest, self._seen(node, about[rest], now[rest])) if len(rest) else found
                )
            case "always" | "eventually" | "until":
                return self._seen(node, about, now)
            case _:
                raise AssertionError(f"`{node.op}` does not look ahead")

    def _seen(self, node: ir.OverRun, about: Indices, now: Indices) -> Value:
        """The same, from all that there has been in the windows."""
        windows, first, seen = self._windows(node), self._at[about], self._at[now] + 1
        n = windows.n
        end = np.minimum(edge_at(windows.end, 0, n, n)[first], seen)
        begin = np.minimum(edge_at(windows.begin, 0, n, n)[first], seen)
        inside, before, so_far = (
            Levels(begin, np.maximum(end, begin), n),
            Levels(first, begin, n),
            Levels(first, seen, n),
        )

        @cache
        def of_part(spans: Spans) -> Rows:
            found = spans.all(inside) if node.op == "always" else spans.until(inside)
            # What has to hold until then has to on the way to the window, too.
            return (
                spans.carrier.meet(found, spans.all(before)) if node.op == "until" and node.lower else found
            )

        def found(best: int) -> Pair:
            made = []
            for part, carrier in ((0, VERDICT), (1, MARGIN)):
                spans = self._spans_of(node, best, part, carrier)
                known = of_part(spans)
                if best and node.op == "until":  # the goal may come yet, if what has to hold does so far
                    known = carrier.join(known, spans.all(so_far))
                made.append(known)
            return made[0], made[1]

        return _halves(node, found, len(about))

    def _spans_of(self, node: ir.OverRun, best: int, part: int, carrier: Carrier) -> Spans:
        """Spans of the Booleans or the margins of one side of what an operator is about."""
        operands = [self._operand(operand) for operand in node.operands]
        if all(low is high for low, high in operands):
            best = 0
        spans = self._spans.get((node, best, part))
        if spans is None:
            held = None if node.op == "eventually" else operands[0][best][part]
            goal = None if node.op == "always" else operands[-1][best][part]
            spans = self._spans[node, best, part] = Spans(held, goal, carrier)
        return spans

    def _operand(self, node: ir.Formula) -> tuple[Pair, Pair]:
        """(elements,): both sides of what an operator is about, which is settled in its own cycle."""
        spread = self._spread.get(node)
        if spread is None:
            spread = self._spread[node] = self._elements.spread(self._settled(node))
        return pairs(spread)

    def _agree(self, node: ir.OverRun) -> bool:
        """Whether the margins of what an operator is about say whether it holds, but for those of zero."""
        known = self._agreeing.get(node)
        if known is None:
            sides = {id(side): side for operand in node.operands for side in self._operand(operand)}
            known = self._agreeing[node] = all(agree(*side) for side in sides.values())
        return known

    def _windows(self, node: ir.OverRun) -> Windows:
        assert node.upper is not None, "what looks ahead has a bound"
        return self._elements.ahead(node.lower or 0, node.upper)

    def _next(self, times: Indices) -> Indices:
        """(cycles,) of what stands in the element after each cycle; after the last one, NEVER."""
        return np.append(times, NEVER)[self._at + 1]


def places_of(where: Bools) -> Choice:
    """The places of some, as a slice where they are neighbours: mostly what is decided is all before something."""
    count = int(np.count_nonzero(where))
    begin = int(np.argmax(where)) if count else 0
    neighbours = slice(begin, begin + count)
    return neighbours if where[neighbours].all() else np.flatnonzero(where)


def _at(array: Indices, chosen: Choice) -> Indices:
    """Some of an array: no copy of what are neighbours."""
    return array[chosen] if isinstance(chosen, slice) else array.take(chosen)


def _edge_of(edge: Edge, chosen: Choice, elements: Indices, n: int) -> Indices:
    """The edges of the windows of some elements, which are chosen, too."""
    if isinstance(edge, int):
        return np.minimum(elements + edge, n) if edge else elements
    return _at(edge, chosen)


def _halves(node: ir.OverRun, side: Callable[[int], Pair], count: int) -> Value:
    """A value of an operator whose windows are open, from the worst (0) and the best (1) that has been seen: one counterexample refutes
    `always`, one example proves `eventually`; the other half stays unknown."""
    unknown = pairs(values.constant(UNDEFINED, count))
    match node.op:
        case "always":
            return values.of(unknown[0], side(1))
        case "eventually":
            return values.of(side(0), unknown[1])
        case "until":
            return values.of(side(0), side(1))
        case _:
            raise AssertionError(f"`{node.op}` has no windows")


def _decided(value: Value, places: Indices) -> Times:
    """When what is settled is decided: in its own cycle, or never."""
    worst, best = pairs(value)
    return Times(np.where(worst[0], places, NEVER), np.where(best[0], NEVER, places))


def _not(a: Times) -> Times:
    return Times(a.false, a.true)


def _and(a: Times, b: Times) -> Times:
    return Times(np.maximum(a.true, b.true), np.minimum(a.false, b.false))


def _or(a: Times, b: Times) -> Times:
    return Times(np.minimum(a.true, b.true), np.maximum(a.false, b.false))
