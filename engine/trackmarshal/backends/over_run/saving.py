"""What rules over the run remember as pieces of plain data, and again from them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, NamedTuple

from trackmarshal.backends.over_run.asking import Key
from trackmarshal.backends.over_run.cells import Cells, Holder, Taken
from trackmarshal.backends.over_run.history import Earlier, Past, sets_of
from trackmarshal.backends.over_run.lives import Lives, Seen
from trackmarshal.backends.over_run.machines import Held, Possible
from trackmarshal.backends.over_run.outcome import Pending
from trackmarshal.backends.over_run.windows import Item, Tally
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.description import describe
from trackmarshal.runtime.saving import Piece, Pieces, checked, count, spelt, unsaved, unspelt
from trackmarshal.runtime.verdict import Bound, Truth

#: The most values of a piece: what is saved, is saved a little in each step.
MOST = 8


@dataclass(frozen=True, slots=True)
class LookedUp:
    """The values of leaves in a cycle that is past."""

    known: Mapping[tuple[ir.Formula, Key], Truth]

    def __call__(self, leaf: ir.Formula, key: Key) -> Truth:
        return self.known[leaf, key]


class Made(NamedTuple):
    """What cycles are kept for: leaves and numbers that are asked of them, operators without a bound, and so many rules."""

    leaves: tuple[ir.Formula, ...]
    limits: tuple[ir.Num, ...]
    unbounded: tuple[ir.OverRun, ...]
    rules: int


class Cycles(NamedTuple):
    """The cycles that may still matter; see `streaming`."""

    cycles: Sequence[Past]
    dropped: int
    missed: int
    pending: Sequence[tuple[Pending, ...]]
    earlier: Earlier


def described(holders: Sequence[Holder], made: Made) -> str:
    """In words, what is remembered: equal words, equal meanings."""
    parts = (("holds", holders), ("leaf", made.leaves), ("limit", made.limits), ("unbounded", made.unbounded))
    found = [f"{name} {type(node).__name__}\n{describe(node)}" for name, nodes in parts for node in nodes]
    return "\n\n".join((*found, f"{made.rules} rules"))


# Cells ----------------------------------------------------------------------------------------------------------------


def saved_cells(cells: Cells, holders: Sequence[Holder]) -> Iterator[Piece]:
    """The pieces of what looks back, of what it holds now."""
    last, missed, held, lives, since = cells.taken()

    def made() -> Iterator[Piece]:
        yield ["cells", last, missed, len(held)]
        for signal, one in sorted(lives.items()):
            yield ["lives", signal, len(one.seen), None if one.lost is None else list(one.lost)]
            yield from _many("seen", ([name, *known] for name, known in one.seen.items()))
        if lives:
            yield ["since", len(since)]
            yield from _many("ago", ([number, list(key), t, cycles] for number, key, t, cycles in since))
        for number, key, one in held:
            holder = holders[number]
            if isinstance(holder, ir.Machine):
                states = [[state, *map(_kept, kept)] for state, kept in one.items()]
                yield ["machine", number, list(key), states]
            elif isinstance(holder, ir.OverRun) and holder.op == "previous":
                yield ["before", number, list(key), _truth(one)]
            else:
                young, older, newer, fold = one
                yield ["window", number, list(key), len(young), len(older), len(newer), _value(holder, fold)]
                yield from _many("items", ([i.first, i.last, _value(holder, i.value)] for i in young))
                yield from _many("folds", ([end, _value(holder, fold)] for end, fold in older))
                yield from _many("items", ([i.first, i.last, _value(holder, i.value)] for i in newer))

    return made()


def loaded_cells(pieces: Pieces, holders: Sequence[Holder]) -> Cells:
    """The cells of these holders with what was saved."""
    last, missed, many = pieces.next("cells", 3)
    cells = Cells(holders)
    lives = {signal: _lives(pieces, signal, one) for signal, one in sorted(cells.taken().lives.items())}
    since: list[tuple[int, Key, int, int]] = []
    if lives:
        (ago,) = pieces.next("since", 1)
        since = [
            (count(number), _key(key, len(sets_of(holders[number]))), checked(t, int), count(cycles))
            for number, key, t, cycles in _listed(pieces, "ago", count(ago))
        ]
    held: list[tuple[int, Key, Any]] = []
    for _ in range(count(many)):
        held.append(_loaded(pieces, holders))
    places = {(number, key) for number, key, _ in held}
    if len(places) != len(held) or (last is None and (held or missed)):
        raise ValueError("what is remembered of no cycle, or twice")
    lasting = {
        (number, key) for number, key, _ in held if any(axis.forget for axis in sets_of(holders[number]))
    }
    if {(number, key) for number, key, _, _ in since} != lasting or len(since) != len(lasting):
        raise ValueError("it is not known since when something is remembered")
    cells.put(Taken(None if last is None else checked(last, int), count(missed), held, lives, since))
    return cells


def _lives(pieces: Pieces, signal: str, empty: Lives) -> Lives:
    """Who of a set is known again after an absence."""
    name, many, lost = pieces.next("lives", 3)
    if name != signal:
        raise ValueError(f"`{name}` is not the set whose elements are known again")
    seen = {
        checked(one, str): Seen(checked(t, int), count(since), checked(sure, bool))
        for one, t, since, sure in _listed(pieces, "seen", count(many))
    }
    if len(seen) != many or many > empty.capacity:
        raise ValueError("more elements than there is room for, or one of them twice")
    if lost is not None:
        at, ago = checked(lost, list)
        lost = checked(at, int), count(ago)
    return Lives(empty.forget, empty.capacity, seen, lost)


def _loaded(pieces: Pieces, holders: Sequence[Holder]) -> tuple[int, Key, Any]:
    kind, rest = pieces.any()
    number = count(rest[0])
    holder = holders[number]
    key = _key(rest[1], len(sets_of(holder)))
    match kind, holder:
        case "machine", ir.Machine():
            (states,) = rest[2:]
            return number, key, _possible(holder, checked(states, list))
        case "before", ir.OverRun(op="previous"):
            (value,) = rest[2:]
            return number, key, _untruth(value)
        case "window", ir.OverRun() | ir.Counted() if not (
            isinstance(holder, ir.OverRun) and holder.op == "previous"
        ):
            young, older, newer, fold = rest[2:]
            return number, key, (
                _items(pieces, holder, count(young)),
                [(checked(end, int), _unvalue(holder, value)) for end, value in _listed(pieces, "folds", count(older))],
                _items(pieces, holder, count(newer)),
                _unvalue(holder, fold),
            )  # fmt: skip
        case _:
            raise ValueError(f"{kind} is not what a {type(holder).__name__} remembers")


def _items(pieces: Pieces, holder: Holder, many: int) -> list[Item[Any]]:
    return [
        Item(checked(first, int), checked(last, int), _unvalue(holder, value))
        for first, last, value in _listed(pieces, "items", many)
    ]


def _possible(machine: ir.Machine, states: list[Any]) -> Possible:
    found: dict[str, Held] = {}
    for state, *held in states:
        if state not in machine.states or state in found or len(held) != 1 + len(machine.names):
            raise ValueError(f"the machine `{machine.name}` is in no such state")
        since, *names = held
        known = None if since is None else checked(since, int)
        found[state] = (known, *(None if value is None else unspelt(value) for value in names))
    if not found:
        raise ValueError(f"the machine `{machine.name}` is in no state")
    return found


def _kept(value: float | None) -> Any:
    """When a state was entered [ns], or a number that is remembered; None: not known."""
    return value if value is None or type(value) is int else spelt(value)


def _value(holder: Holder, value: Any) -> Any:
    """What an operator makes of cycles."""
    match holder:
        case ir.Counted():
            return [int(value.sure), int(value.possible), bool(value.surely_anew), bool(value.possibly_anew)]
        case ir.OverRun(op="since"):
            return [_truth(value[0]), _truth(value[1])]
        case ir.OverRun(op="once" | "historically"):
            return _truth(value)
        case _:
            raise AssertionError(f"{type(holder).__name__} has no window in the past")


def _unvalue(holder: Holder, value: Any) -> Any:
    match holder:
        case ir.Counted():
            sure, possible, surely, possibly = value
            return Tally(count(sure), count(possible), checked(surely, bool), checked(possibly, bool))
        case ir.OverRun(op="since"):
            goal, hold = value
            return _untruth(goal), _untruth(hold)
        case ir.OverRun(op="once" | "historically"):
            return _untruth(value)
        case _:
            raise ValueError(f"{type(holder).__name__} has no window in the past")


# Cycles that may still matter -----------------------------------------------------------------------------------------


def saved_cycles(given: Cycles, made: Made) -> Iterator[Piece]:
    """The pieces of what looks ahead. Nothing in it changes later."""
    names = [one.name for each in given.pending for one in each] + [past.name for past in given.cycles]
    for name in names:
        if name is not None and type(name) not in (int, str):
            raise unsaved(f"a cycle is called {name!r:.40}, which is neither a number nor a text")

    def pieces() -> Iterator[Piece]:
        yield ["cycles", len(given.cycles), given.dropped, given.missed, len(given.earlier)]
        for each in given.pending:
            yield ["pending", len(each)]
            yield from _many("open", ([one.place, one.name, one.decided] for one in each))
        for past in given.cycles:
            yield from _past(past, made)
        place = {node: number for number, node in enumerate(made.unbounded)}
        known = ([place[node], list(key), _truth(value)] for (node, key), value in given.earlier.items())
        yield from _many("earlier", known)

    return pieces()


def _past(past: Past, made: Made) -> Iterator[Piece]:
    leaf = past.leaf
    assert isinstance(leaf, LookedUp), "what is kept is looked up"
    ids = {name: list(each) for name, each in past.ids.items() if each}
    numbers = [spelt(past.number(node)) for node in made.limits]
    yield ["past", past.t, past.name, sorted(past.ids), ids, past.missed, numbers, len(leaf.known)]
    place = {node: number for number, node in enumerate(made.leaves)}
    yield from _many(
        "leaves", ([place[node], list(key), _truth(value)] for (node, key), value in leaf.known.items())
    )


def loaded_cycles(pieces: Pieces, made: Made) -> Cycles:
    """The cycles that were saved."""
    many, dropped, missed, known = pieces.next("cycles", 4)
    pending = []
    for _ in range(made.rules):
        (each,) = pieces.next("pending", 1)
        listed = _listed(pieces, "open", count(each))
        pending.append(
            tuple(Pending(count(place), _name(name), checked(said, bool)) for place, name, said in listed)
        )
    cycles = [_loaded_past(pieces, made) for _ in range(count(many))]
    if any(
        one.place - count(dropped) >= len(cycles) or one.place < dropped for each in pending for one in each
    ):
        raise ValueError("a cycle is open that is not there")
    earlier = {
        (made.unbounded[count(node)], _key(key, len(sets_of(made.unbounded[node])))): _untruth(value)
        for node, key, value in _listed(pieces, "earlier", count(known))
    }
    return Cycles(cycles, dropped, count(missed), pending, earlier)


def _loaded_past(pieces: Pieces, made: Made) -> Past:
    t, name, signals, ids, missed, numbers, many = pieces.next("past", 7)
    known = {
        (made.leaves[count(leaf)], _key(key, len(sets_of(made.leaves[leaf])))): _untruth(value)
        for leaf, key, value in _listed(pieces, "leaves", count(many))
    }
    there = {checked(signal, str): _key(ids.get(signal, [])) for signal in signals}
    if not there.keys() >= ids.keys():
        raise ValueError("elements of what is no signal")
    limits = dict(zip(made.limits, map(unspelt, numbers), strict=True))
    return Past(checked(t, int), _name(name), there, LookedUp(known), limits.__getitem__, count(missed))


def _name(value: Any) -> Any:
    return None if value is None else checked(value, int, str)


# Values ---------------------------------------------------------------------------------------------------------------


def _truth(value: Truth) -> list[Any]:
    worst, best = value.worst, value.best
    return [bool(worst.sat), spelt(worst.margin), bool(best.sat), spelt(best.margin)]


def _untruth(value: Any) -> Truth:
    worst, low, best, high = value
    return Truth(Bound(checked(worst, bool), unspelt(low)), Bound(checked(best, bool), unspelt(high)))


def _key(value: Any, many: int | None = None) -> Key:
    """Ids of elements; raises ValueError where there are not so many."""
    found = tuple(checked(each, str) for each in checked(value, list))
    if many is not None and len(found) != many:
        raise ValueError("not one id for each variable")
    return found


def _many(name: str, values: Iterable[Any]) -> Iterator[Piece]:
    """Values, a few a piece."""
    rest = iter(values)
    while some := list(islice(rest, MOST)):
        yield [name, some]


def _listed(pieces: Pieces, name: str, many: int) -> Iterator[Any]:
    """So many values that `_many` gave."""
    left = many
    while left > 0:
        (some,) = pieces.next(name, 1)
        if len(checked(some, list)) != min(left, MOST):
            raise ValueError(f"not as many {name} as there should be")
        left -= len(some)
        yield from some
