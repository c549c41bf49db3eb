"""What formulas that look back remember: per operator a cell, for the run, or for each element of a set while it is there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, assert_never

from trackmarshal.backends.over_run.counts import Range, compared
from trackmarshal.backends.over_run.history import looks_ahead, parts_of, recalled_of, recalls_of, sets_of
from trackmarshal.backends.over_run.machines import Possible, begun, is_in, kept, stepped, widened
from trackmarshal.backends.over_run.now import Now
from trackmarshal.backends.over_run.windows import Item, Sliding, folding
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.runtime.kleene import FALSE, TRUE, UNDEFINED, connect, greatest, least, negate
from trackmarshal.runtime.verdict import Bound, Truth

#: What variables of sets stand for, by the level of their axes: ids.
Ids = Mapping[int, str]
Key = tuple[str, ...]
#: What has a memory of its own: an operator, or a state machine, of which there is one whatever is asked of it.
Holder = ir.OverRun | ir.Counted | ir.Machine


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


class Cells:
    """The memory of some operators. Cycles are looked at with `at`, and then remembered, or missed."""

    def __init__(self, holders: Sequence[Holder]) -> None:
        self._holders = holders
        self._held: dict[Holder, dict[Key, Any]] = {holder: {} for holder in holders}
        #: The last stamp, None before the first, and how many cycles were missed since.
        self._last: int | None = None
        self._missed = 0

    def at(self, now: Now) -> Present:
        """The present cycle, after all that is remembered."""
        return Present(self, now)

    def missed(self) -> None:
        """A gap, unless nothing came before it."""
        self._missed += self._last is not None

    def gap(self, now: Now) -> tuple[int, int] | None:
        """The first and the last nanosecond of what lies between the last cycle and this one, where cycles were missed."""
        return None if not self._missed or self._last is None else (self._last + 1, now.t - 1)

    def before(self, machine: ir.Machine, key: Key, now: Now) -> Possible:
        """What a state machine may be in when the present cycle begins."""
        held: Possible | None = self._held[machine].get(key)
        if held is None:
            return begun(machine, now.t)
        return widened(machine, held) if self._missed else held

    def value(self, node: ir.OverRun | ir.Counted, key: Key, now: Now, values: tuple[Truth, ...]) -> Any:
        """The value of an operator in the present cycle, for which `values` are its operands."""
        held = self._held[node].get(key)
        if isinstance(node, ir.OverRun) and node.op == "previous":
            return (TRUE if node.weak else FALSE) if held is None else UNDEFINED if self._missed else held
        known: Sliding[Any] = _empty(node) if held is None else held
        return known.value(now.t, self._items(node, now, values, held is not None))

    def remember(self, now: Now, present: Present) -> None:
        """The present cycle is past. All values are looked at before anything is changed."""
        found = [
            (holder, [(key, present.brought(holder, key)) for key in now.combinations(sets_of(holder))])
            for holder in self._holders
        ]
        for node, values in found:
            held, later = self._held[node], dict[Key, Any]()
            for key, operands in values:
                if isinstance(node, ir.Machine):
                    later[key] = operands
                    continue
                if isinstance(node, ir.OverRun) and node.op == "previous":
                    later[key] = operands[0]
                    continue
                known = held.get(key)
                items = self._items(node, now, operands, known is not None)
                later[key] = _empty(node) if known is None else known
                later[key].add(now.t, items)
            self._held[node] = later
        self._last, self._missed = now.t, 0

    def taken(self) -> tuple[int | None, int, list[tuple[int, Key, Any]]]:
        """All that is remembered, as it is now: the last stamp, the cycles missed since, and by the number of each holder what it holds of
        which elements; of a window what `Sliding.taken` gives."""
        held = [
            (number, key, one.taken() if isinstance(one, Sliding) else one)
            for number, holder in enumerate(self._holders)
            for key, one in self._held[holder].items()
        ]
        return self._last, self._missed, held

    def put(self, last: int | None, missed: int, held: Sequence[tuple[int, Key, Any]]) -> None:
        """Remember what others of the same holders did: as `taken` gave it."""
        self._last, self._missed = last, missed
        for number, key, one in held:
            holder = self._holders[number]
            if isinstance(holder, ir.Machine) or (isinstance(holder, ir.OverRun) and holder.op == "previous"):
                self._held[holder][key] = one
            else:
                window = _empty(holder)
                window.put(*one)
                self._held[holder][key] = window

    def _items(
        self, node: ir.OverRun | ir.Counted, now: Now, values: tuple[Truth, ...], before: bool
    ) -> list[Item[Any]]:
        fold = folding(node)
        items = [Item(now.t, now.t, fold.item(values))]
        gap = self.gap(now) if before else None
        return items if gap is None else [Item(*gap, fold.gap(len(values), self._missed)), *items]


def _empty(node: ir.OverRun | ir.Counted) -> Sliding[Any]:
    return Sliding(folding(node), node.lower or 0, node.upper)


@dataclass(slots=True)
class Present:
    """The values of formulas that look back, in the present cycle."""

    cells: Cells
    now: Now
    _known: dict[tuple[ir.Formula, Key], Truth] = field(default_factory=dict)
    _machines: dict[tuple[ir.Machine, Key], Possible] = field(default_factory=dict)

    def leaf(self, node: ir.Formula, key: Key) -> Truth:
        """The value of a formula for elements of the sets that its variables are of."""
        known = self._known.get((node, key))
        if known is None:
            known = self._known[node, key] = self._value(node, key)
        return known

    def brought(self, holder: Holder, key: Key) -> Any:
        """What this cycle brings to what has a memory: the operands of an operator, the states that a machine may be in now."""
        return self.possible(holder, key) if isinstance(holder, ir.Machine) else self.operands(holder, key)

    def operands(self, node: ir.OverRun | ir.Counted, key: Key) -> tuple[Truth, ...]:
        """The operands of an operator in this cycle."""
        ids = _ids(node, key)
        return tuple(self._of(operand, ids) for operand in node.operands)

    def possible(self, machine: ir.Machine, key: Key) -> Possible:
        """The states that a machine may be in after this cycle."""
        known = self._machines.get((machine, key))
        if known is None:
            ids = _ids(machine, key)
            guards = [self._of(guard, ids) for guard in machine.guards]
            before = self.cells.before(machine, key, self.now)
            known = self._machines[machine, key] = stepped(
                machine,
                before,
                self.now.t,
                guards,
                lambda number: self.now.measured(number, _named(number, ids)),
            )
        return known

    def _recalled(self, node: ir.Formula, key: Key) -> Truth:
        ids = _ids(node, key)
        known = {
            one: kept(one.machine, one.name, self.possible(one.machine, _named(one.machine, ids)), self.now.t)
            for one in recalled_of(node)
        }
        return self.now.recalled(node, key, known)

    def _of(self, node: ir.Formula, ids: Ids) -> Truth:
        return self.leaf(node, _named(node, ids))

    def _value(self, node: ir.Formula, key: Key) -> Truth:
        if parts_of(node) is None:
            return self.now.leaf(node, key)
        if recalls_of(node):
            return self._recalled(node, key)
        ids = _ids(node, key)
        match node:
            case ir.OverRun():
                value: Truth = self.cells.value(node, key, self.now, self.operands(node, key))
                return value
            case ir.Counted():
                count: Range = self.cells.value(node, key, self.now, self.operands(node, key))
                return compared(node, count, self.now.number(node.limit))
            case ir.InState():
                return is_in(self.possible(node.machine, key), node.state)
            case ir.Not():
                return negate(self._of(node.operand, ids))
            case ir.Connective():
                return connect(node.op, self._of(node.left, ids), self._of(node.right, ids))
            case ir.Guarded():
                guard, body = self._of(node.guard, ids), self._of(node.body, ids)
                worst = body.worst if guard.best.sat else TRUE.worst
                return Truth(worst, body.best if guard.worst.sat else TRUE.best)
            case ir.Quantify():
                return self._quantify(node, ids)
            case _:
                raise AssertionError(f"{type(node).__name__} is no formula over the run")

    def _quantify(self, node: ir.Quantify, ids: Ids) -> Truth:
        """Elements that may be in range count in the worst case of `for all` and in the best of `exists`; those that surely are, in the other."""
        match node.extreme:
            case Extreme.LEAST:
                join = least
            case Extreme.GREATEST:
                join = greatest
            case _:
                assert_never(node.extreme)
        worst = best = Bound(*node.extreme.neutral)
        for name in self.now.ids[node.axis.signal]:
            inner = {**ids, node.axis.level: name}
            guard = TRUE if node.guard is None else self._of(node.guard, inner)
            body = self._of(node.body, inner)
            surely, possibly = guard.worst.sat, guard.best.sat
            if possibly if join is least else surely:
                worst = join(worst, body.worst)
            if surely if join is least else possibly:
                best = join(best, body.best)
        return Truth(worst, best)


def _named(node: ir.Formula | ir.Num | ir.Machine, ids: Ids) -> Key:
    return tuple(ids[axis.level] for axis in sets_of(node))


def _ids(node: ir.Formula | ir.Machine, key: Key) -> dict[int, str]:
    return {axis.level: name for axis, name in zip(sets_of(node), key)}
