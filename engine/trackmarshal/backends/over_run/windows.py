"""Windows that slide over the cycles of a run, each with what its operator makes of all that is in it, in a few steps a cycle.

Whatever is folded is folded by an associative operation, the newer one first: a window is held in two stacks, of which the older one
knows what every rest of it comes to. Times are whole nanoseconds.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Sequence
from typing import Any, Generic, NamedTuple, Protocol, TypeVar, assert_never

from trackmarshal.backends.over_run.counts import Range
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.kleene import FALSE, TRUE, UNDEFINED, connect
from trackmarshal.runtime.verdict import Truth

M = TypeVar("M")


class Item(NamedTuple, Generic[M]):
    """Something of the past: in a window from `low` to `high` if it begins by `high` and does not end before `low`."""

    first: int
    last: int
    value: M


class Folding(Protocol[M]):
    """What an operator makes of the past. `nothing` is what an empty window comes to."""

    nothing: M

    def item(self, values: Sequence[Truth]) -> M:
        """What one cycle contributes from inside the window."""

    def beside(self, values: M) -> M:
        """What it contributes from between the window and now."""

    def joined(self, newer: M, older: M) -> M: ...

    def gap(self, operands: int, missed: int) -> M:
        """What cycles contribute of which nothing is known."""

    def value(self, folded: M) -> Truth | Range: ...


class Extremum:
    """once, historically: the greatest, or the least; what lies beside the window does not matter."""

    def __init__(self, op: str) -> None:
        self.nothing = FALSE if op == "once" else TRUE
        self._greatest = op == "once"

    def item(self, values: Sequence[Truth]) -> Truth:
        return values[0]

    def beside(self, values: Truth) -> Truth:
        return self.nothing

    def gap(self, operands: int, missed: int) -> Truth:
        return UNDEFINED

    def joined(self, newer: Truth, older: Truth) -> Truth:
        return connect("or" if self._greatest else "and", newer, older)

    def value(self, folded: Truth) -> Truth:
        return folded


class Steps:
    """since: cycles as steps x -> goal or (hold and x), one after the other."""

    nothing = (FALSE, TRUE)

    def item(self, values: Sequence[Truth]) -> tuple[Truth, Truth]:
        left, right = values
        return right, left

    def beside(self, values: tuple[Truth, Truth]) -> tuple[Truth, Truth]:
        return FALSE, values[1]

    def gap(self, operands: int, missed: int) -> tuple[Truth, Truth]:
        return UNDEFINED, UNDEFINED

    def joined(self, newer: tuple[Truth, Truth], older: tuple[Truth, Truth]) -> tuple[Truth, Truth]:
        (goal, hold), (before, held) = newer, older
        return connect("or", goal, connect("and", hold, before)), connect("and", hold, held)

    def value(self, folded: tuple[Truth, Truth]) -> Truth:
        return folded[0]


class Tally(NamedTuple):
    """How many cycles count, surely and possibly, and whether the count starts anew with them."""

    sure: int
    possible: int
    surely_anew: bool
    possibly_anew: bool


class Counting:
    """count: of what comes before a cycle in which it starts anew, nothing counts."""

    nothing = Tally(0, 0, False, False)

    def item(self, values: Sequence[Truth]) -> Tally:
        counted, *resets = values
        return Tally(
            int(counted.worst.sat), int(counted.best.sat), any(reset.worst.sat for reset in resets),
            any(reset.best.sat for reset in resets),
        )  # fmt: skip

    def beside(self, values: Tally) -> Tally:
        raise AssertionError("the window of a count ends now")

    def gap(self, operands: int, missed: int) -> Tally:
        return Tally(0, missed, False, operands > 1)

    def joined(self, newer: Tally, older: Tally) -> Tally:
        return Tally(
            newer.sure + (0 if newer.possibly_anew else older.sure),
            newer.possible + (0 if newer.surely_anew else older.possible),
            newer.surely_anew or older.surely_anew, newer.possibly_anew or older.possibly_anew,
        )  # fmt: skip

    def value(self, folded: Tally) -> Range:
        return Range(folded.sure, folded.possible)


def folding(node: ir.OverRun | ir.Counted) -> Folding[Any]:
    """What an operator that looks back makes of a window."""
    if isinstance(node, ir.Counted):
        return Counting()
    match node.op:
        case "once" | "historically":
            return Extremum(node.op)
        case "since":
            return Steps()
        case "previous" | "always" | "eventually" | "until" | "next":
            raise AssertionError(f"`{node.op}` has no window in the past")
        case _:
            assert_never(node.op)


class Sliding(Generic[M]):
    """The window of one operator, for one element of a set, or for the run. upper: None where nothing ever leaves it."""

    __slots__ = ("_folding", "_lower", "_newer", "_newer_fold", "_older", "_upper", "_young")

    def __init__(self, folding: Folding[M], lower: int, upper: int | None) -> None:
        self._folding, self._lower, self._upper = folding, lower, upper
        #: What is too young for the window yet.
        self._young: deque[Item[M]] = deque()
        #: The older part, the oldest last: when each item ends, and what it and all newer ones of this part come to.
        self._older: list[tuple[int, M]] = []
        #: The newer part, the oldest first, and what it comes to.
        self._newer: list[Item[M]] = []
        self._newer_fold = folding.nothing

    def value(self, t: int, now: Sequence[Item[M]]) -> Any:
        """The operator's value at a time, with items that are not in the window yet: those of the present cycle."""
        join, low, high = self._folding.joined, self._low(t), t - self._lower
        folded = self._fold(low)
        for item in (*self._young, *now):
            if item.first > high:
                folded = join(self._folding.beside(item.value), folded)
            elif low is None or item.last >= low:
                folded = join(item.value, folded)
        return self._folding.value(folded)

    def add(self, t: int, now: Sequence[Item[M]]) -> None:
        """Move on to a time, with the items of its cycle."""
        low, high = self._low(t), t - self._lower
        if low is not None:
            self._leave(low)
        self._young.extend(now)
        while self._young and self._young[0].first <= high:
            item = self._young.popleft()
            if low is None or item.last >= low:
                self._newer_fold = self._folding.joined(item.value, self._newer_fold)
                if low is not None:
                    self._newer.append(item)

    def taken(self) -> tuple[list[Item[M]], list[tuple[int, M]], list[Item[M]], M]:
        """All that it holds, as it is now: what is too young, the older part, the newer part, and what that comes to."""
        return list(self._young), list(self._older), list(self._newer), self._newer_fold

    def put(
        self, young: Sequence[Item[M]], older: Sequence[tuple[int, M]], newer: Sequence[Item[M]], fold: M
    ) -> None:
        """Hold what another one of the same operator held."""
        self._young, self._older, self._newer, self._newer_fold = (
            deque(young),
            list(older),
            list(newer),
            fold,
        )

    def _low(self, t: int) -> int | None:
        return None if self._upper is None else t - self._upper

    def _fold(self, low: int | None) -> M:
        """What all in the window comes to that does not end before a time."""
        if low is None:
            return self._newer_fold
        for last, fold in reversed(self._older):
            if last >= low:
                return self._folding.joined(self._newer_fold, fold)
        if not self._newer or self._newer[0].last >= low:
            return self._newer_fold
        folded = self._folding.nothing
        for item in self._newer[bisect_left(self._newer, low, key=_end) :]:
            folded = self._folding.joined(item.value, folded)
        return folded

    def _leave(self, low: int) -> None:
        """Drop what ends before a time; when the older part is used up, the newer one takes its place."""
        older = self._older
        while older and older[-1][0] < low:
            older.pop()
        if older or not self._newer or self._newer[0].last >= low:
            return
        fold: M | None = None
        for item in reversed(self._newer[bisect_left(self._newer, low, key=_end) :]):
            fold = item.value if fold is None else self._folding.joined(fold, item.value)
            older.append((item.last, fold))
        self._newer.clear()
        self._newer_fold = self._folding.nothing


def _end(item: Item[M]) -> int:
    return item.last
