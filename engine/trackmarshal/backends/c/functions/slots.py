"""Series of the context for the temporal operators of a function: few, though each is written as if it had one of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from trackmarshal.backends.c import tree as c

#: First and last place of a series' use, in the order of the statements.
Range = tuple[int, int]


def assign(body: tuple[c.Statement, ...]) -> tuple[tuple[c.Statement, ...], int]:
    """The statements with places of the context for all series, no two in use at once alike; and how many places there are.

    Done when the function is written, since what is computed once for all of a scope stands before scopes that were begun earlier.
    """
    ranges = _ranges(body, [0])
    free: list[int] = []
    places: dict[int, int] = {}
    busy: list[tuple[int, int]] = []  # (last use, place)
    count = 0
    for number, (first, last) in sorted(ranges.items(), key=lambda item: item[1]):
        free += [place for end, place in busy if end < first]
        busy = [(end, place) for end, place in busy if end >= first]
        if free:
            place = min(free)
            free.remove(place)
        else:
            place = count
            count += 1
        places[number] = place
        busy.append((last, place))
    return tuple([_placed(each, places) for each in body]), count


def _ranges(body: Sequence[c.Statement], position: list[int]) -> dict[int, Range]:
    """Where each series is in use: what is used in several parts of a body is so through the whole of the loops among them."""
    found: dict[int, Range] = {}
    parts: dict[int, list[Range]] = {}
    for item in body:
        begin = position[0]
        if isinstance(item, c.For | c.If):
            inner = _ranges(item.body, position)
        else:
            inner = {
                each.number: (begin, begin)
                for expr in c.expressions(item)
                for each in c.within(expr)
                if isinstance(each, c.Slot)
            }
            position[0] += 1
        whole = (begin, position[0] - 1)
        for number, own in inner.items():
            found[number] = own
            parts.setdefault(number, []).append(whole)
    for number, ranges in parts.items():
        if len(ranges) > 1:
            found[number] = (ranges[0][0], ranges[-1][1])
    return found


def _placed(node: Any, places: dict[int, int]) -> Any:
    """A node with places in place of numbers."""
    if isinstance(node, c.Slot):
        return c.Literal(f"{places[node.number]}u")
    made = {
        name: _placed(value, places) if isinstance(value, c.Tree)
        else tuple([_placed(each, places) if isinstance(each, c.Tree) else each for each in value]) if isinstance(value, tuple)
        else value
        for name, value in node.__dict__.items()
    }  # fmt: skip
    return type(node)(**made)
