"""What formulas that look back remember: per operator a cell, for the run, or for each element of a set while it is there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from trackmarshal.backends.over_run.asking import Key, asking, operands_of, stepping
from trackmarshal.backends.over_run.history import parts_of, recalled_of, recalls_of, sets_of
from trackmarshal.backends.over_run.lives import ANY_CYCLES, Arrivals, Lives
from trackmarshal.backends.over_run.machines import Possible, begun, unknown, widened
from trackmarshal.backends.over_run.now import Now
from trackmarshal.backends.over_run.outcome import Outcome
from trackmarshal.backends.over_run.windows import Item, Sliding, folding
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import looks_ahead
from trackmarshal.runtime.kleene import FALSE, TRUE, UNDEFINED
from trackmarshal.runtime.verdict import Truth

#: What has a memory of its own: an operator, or a state machine, of which there is one whatever is asked of it.
Holder = ir.OverRun | ir.Counted | ir.Machine
#: Before all stamps [ns]; generated C has the same.
EVER = -4_000_000_000_000_000_000


def looks_back(node: ir.Formula) -> bool:
    """Whether a formula says nothing of cycles after its own."""
    return not looks_ahead(node)


def cells_of(
    formulas: Iterable[ir.Formula], which: Callable[[ir.Formula], bool] = looks_back
) -> list[Holder]:
    """The operators of some formulas that look back alone, or others, and all state machines."""
    found: dict[Holder, None] = {}
    stack: list[tuple[ir.Formula, bool]] = [(formula, False) for formula in formulas]
    seen: set[ir.Formula] = set()
    while stack:
        node, ready = stack.pop()
        if ready:
            if isinstance(node, ir.InState):
                found[node.machine] = None
            elif recalls_of(node):
                found |= dict.fromkeys(one.machine for one in recalled_of(node))
            elif isinstance(node, ir.Remembered) and which(node):
                found[node] = None
            continue
        if node in seen:
            continue
        seen.add(node)
        stack.append((node, True))
        stack.extend((part, False) for part in parts_of(node) or ())
    return list(found)


class Taken(NamedTuple):
    """All that is remembered: the last stamp, the cycles missed since, by the number of each holder what it holds of which elements (of a
    window what `Sliding.taken` gives), who of sets is known again after an absence, and for what is remembered of them the last stamp, and the cycles
    since."""

    last: int | None
    missed: int
    held: list[tuple[int, Key, Any]]
    lives: Mapping[str, Lives]
    since: list[tuple[int, Key, int, int]]


class Cells:
    """The memory of some operators. Cycles are looked at with `at`, and then remembered, or missed."""

    def __init__(self, holders: Sequence[Holder]) -> None:
        self._holders = holders
        self._held: dict[Holder, dict[Key, Any]] = {holder: {} for holder in holders}
        #: The last stamp, None before the first, and how many cycles were missed since.
        self._last: int | None = None
        self._missed = 0
        #: Of sets whose elements are known again after an absence: who is, and for what is remembered of them the last stamp, and the
        #: cycles since.
        self._lives = {
            axis.signal: Lives(axis.forget, axis.capacity or 0)
            for holder in holders
            for axis in sets_of(holder)
            if axis.forget
        }
        self._since: dict[tuple[Holder, Key], tuple[int, int]] = {}
        #: Of which something is remembered of elements that are absent.
        self._lasting = {holder for holder in holders if any(axis.forget for axis in sets_of(holder))}

    def at(self, now: Now) -> Present:
        """The present cycle, after all that is remembered."""
        found = {name: one.arrivals(now.t, now.ids[name], self._missed) for name, one in self._lives.items()}
        return Present(self, now, found)

    @property
    def lasting(self) -> bool:
        """Whether elements of any set are known again after an absence."""
        return bool(self._lives)

    def missed(self, cycles: int) -> None:
        """A gap of so many cycles, unless nothing came before it."""
        self._missed += 0 if self._last is None else cycles

    def before(self, machine: ir.Machine, key: Key, present: Present) -> Possible:
        """What a state machine may be in when the present cycle begins."""
        held: Possible | None = None if present.over(machine, key) else self._held[machine].get(key)
        if held is None:
            return begun(machine, present.now.t) if present.sure(machine, key) else unknown(machine)
        gap = self._gap(machine, key, present)
        return held if gap is None else widened(machine, held, gap[1] - gap[0] + 2)

    def value(
        self, node: ir.OverRun | ir.Counted, key: Key, present: Present, values: tuple[Truth, ...]
    ) -> Any:
        """The value of an operator in the present cycle, for which `values` are its operands."""
        held = None if present.over(node, key) else self._held[node].get(key)
        if isinstance(node, ir.OverRun) and node.op == "previous":
            if held is None:
                first = TRUE if node.weak else FALSE
                return first if present.sure(node, key) else UNDEFINED
            return UNDEFINED if self._gap(node, key, present) else held
        known: Sliding[Any] = _empty(node) if held is None else held
        return known.value(present.now.t, self._items(node, key, present, values, held is not None))

    def remember(self, now: Now, present: Present) -> None:
        """The present cycle is past. All values are looked at before anything is changed."""
        found = [
            (
                holder,
                [
                    (key, present.brought(holder, key))
                    for key in now.combinations(sets_of(holder))
                    if not present.without(holder, key)
                ],
            )
            for holder in self._holders
        ]
        since: dict[tuple[Holder, Key], tuple[int, int]] = {}
        for node, values in found:
            held = self._held[node]
            if present.lives:
                held = {key: one for key, one in held.items() if not present.over(node, key)}
            later = dict[Key, Any]()
            for key, operands in values:
                if isinstance(node, ir.Machine):
                    later[key] = operands
                elif isinstance(node, ir.OverRun) and node.op == "previous":
                    later[key] = operands[0]
                else:
                    known = held.get(key)
                    items = self._items(node, key, present, operands, known is not None)
                    later[key] = _empty(node) if known is None else known
                    later[key].add(now.t, items)
            if node in self._lasting:
                since |= {(node, key): (now.t, 0) for key in later}
                for key in held.keys() - later.keys():
                    if _gone(node, key, now):
                        continue
                    later[key] = held[key]
                    last, cycles = self._since[node, key]
                    since[node, key] = last, cycles + 1 + self._missed
            self._held[node] = later
        self._lives = {name: one for name, (one, _) in present.lives.items()}
        self._since = since
        self._last, self._missed = now.t, 0

    def taken(self) -> Taken:
        """All that is remembered, as it is now."""
        held = [
            (number, key, one.taken() if isinstance(one, Sliding) else one)
            for number, holder in enumerate(self._holders)
            for key, one in self._held[holder].items()
        ]
        numbers = {holder: number for number, holder in enumerate(self._holders)}
        since = [
            (numbers[holder], key, last, cycles) for (holder, key), (last, cycles) in self._since.items()
        ]
        return Taken(self._last, self._missed, held, dict(self._lives), since)

    def put(self, taken: Taken) -> None:
        """Remember what others of the same holders did: as `taken` gave it."""
        self._last, self._missed, held = taken.last, taken.missed, taken.held
        self._lives = {name: taken.lives[name] for name in self._lives}
        self._since = {
            (self._holders[number], key): (last, cycles) for number, key, last, cycles in taken.since
        }
        for number, key, one in held:
            holder = self._holders[number]
            if isinstance(holder, ir.Machine) or (isinstance(holder, ir.OverRun) and holder.op == "previous"):
                self._held[holder][key] = one
            else:
                window = _empty(holder)
                window.put(*one)
                self._held[holder][key] = window

    def _gap(self, holder: Holder, key: Key, present: Present) -> tuple[int, int, int] | None:
        """The first and the last nanosecond of what lies between the last cycle that an operator has of some elements and this one, and how
        many cycles were missed there, or had them not; None where there were none."""
        last, cycles = self._since.get((holder, key), (self._last, 0))
        cycles += self._missed
        return None if not cycles or last is None else (last + 1, present.now.t - 1, cycles)

    def _items(
        self,
        node: ir.OverRun | ir.Counted,
        key: Key,
        present: Present,
        values: tuple[Truth, ...],
        before: bool,
    ) -> list[Item[Any]]:
        """What the present cycle brings to a window; `before`: something is remembered already."""
        fold, t = folding(node), present.now.t
        items = [Item(t, t, fold.item(values))]
        gap = self._gap(node, key, present) if before else None
        if not before and not present.sure(node, key):
            gap = EVER, t - 1, ANY_CYCLES
        return items if gap is None else [Item(*gap[:2], fold.gap(len(values), gap[2])), *items]


def _gone(holder: Holder, key: Key, now: Now) -> bool:
    """Whether one of these elements is not there, and its set knows nobody again."""
    return any(
        not axis.forget and name not in now.ids[axis.signal] for axis, name in zip(sets_of(holder), key)
    )


def _empty(node: ir.OverRun | ir.Counted) -> Sliding[Any]:
    return Sliding(folding(node), node.lower or 0, node.upper)


@dataclass(slots=True)
class Present:
    """The values of formulas that look back, in the present cycle."""

    cells: Cells
    now: Now
    #: Of sets whose elements are known again after an absence: who will be, and what happens in this cycle.
    lives: Mapping[str, tuple[Lives, Arrivals]]
    #: After the same past, what `now` is like.
    like: Present | None = None
    #: What each rule says, where it was asked for.
    outcomes: Sequence[Outcome] = ()
    _known: dict[tuple[ir.Formula, Key], Truth] = field(default_factory=dict)
    _machines: dict[tuple[ir.Machine, Key], Possible] = field(default_factory=dict)

    def leaf(self, node: ir.Formula, key: Key) -> Truth:
        """The value of a formula for elements of the sets that its variables are of."""
        return self.now.leaf(node, key) if parts_of(node) is None else self.over_run(node, key)

    def over_run(self, node: ir.Formula, key: Key) -> Truth:
        """The same of a formula that is no leaf."""
        known = self._known.get((node, key))
        if known is None:
            like = self.like
            if like is not None and self.now.shares(node):
                known = like.over_run(node, key)
            else:
                known = asking(node)(self, key)
            self._known[node, key] = known
        return known

    def over(self, holder: Holder, key: Key) -> bool:
        """Whether what was remembered is of elements of which nothing is any more."""
        return bool(self.lives) and any(name in one.over for name, (_, one) in self._lasting(holder, key))

    def without(self, holder: Holder, key: Key) -> bool:
        """Whether there is no place for one of these elements."""
        return bool(self.lives) and any(name in one.without for name, (_, one) in self._lasting(holder, key))

    def sure(self, holder: Holder, key: Key) -> bool:
        """Whether nothing came before the first cycle of these elements."""
        return not self.lives or all(after.seen[name].sure for name, (after, _) in self._lasting(holder, key))

    def _lasting(self, holder: Holder, key: Key) -> list[tuple[str, tuple[Lives, Arrivals]]]:
        return [(name, self.lives[axis.signal]) for axis, name in zip(sets_of(holder), key) if axis.forget]

    def brought(self, holder: Holder, key: Key) -> Any:
        """What this cycle brings to what has a memory: the operands of an operator, the states that a machine may be in now."""
        return (
            self.possible(holder, key) if isinstance(holder, ir.Machine) else operands_of(holder)(self, key)
        )

    def possible(self, machine: ir.Machine, key: Key) -> Possible:
        """The states that a machine may be in after this cycle."""
        known = self._machines.get((machine, key))
        if known is None:
            if self.like is not None and self.now.shares(machine):
                known = self.like.possible(machine, key)
            else:
                known = unknown(machine) if self.without(machine, key) else stepping(machine)(self, key)
            self._machines[machine, key] = known
        return known
