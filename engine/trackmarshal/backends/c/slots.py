"""Series of the context for the temporal operators of a function: few, though each is written as if it had one of its own."""

from __future__ import annotations

import re

from trackmarshal.backends.c.statements import Block

_MARK = re.compile(r"@(\d+)@")
#: First and last place of a series' use, in the order of the text.
Range = tuple[int, int]


def mark(number: int) -> str:
    """The name of a series in a statement, until `assign` gives it a place."""
    return f"@{number}@"


def assign(root: Block) -> int:
    """Put places of the context for all marks of a function, no two in use at once alike; returns how many there are.

    Done when the function is written, since what is computed once for all of a block stands before blocks that were begun earlier.
    """
    marked = [statement for statement in root.statements() if "@" in statement.text]
    if not marked:
        return 0
    ranges = _ranges(root, [0])
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
    for statement in marked:
        statement.text = _MARK.sub(lambda match: str(places[int(match.group(1))]), statement.text)
    return count


def _ranges(block: Block, position: list[int]) -> dict[int, Range]:
    """Where each series is in use: what is used in several parts of a block is so through the whole of the loops among them."""
    found: dict[int, Range] = {}
    parts: dict[int, list[Range]] = {}
    for item in block.body:
        begin = position[0]
        if isinstance(item, Block):
            inner = _ranges(item, position)
        else:
            inner = {int(number): (begin, begin) for number in _MARK.findall(item.text)}
            position[0] += 1
        whole = (begin, position[0] - 1)
        for number, own in inner.items():
            found[number] = own
            parts.setdefault(number, []).append(whole)
    for number, ranges in parts.items():
        if len(ranges) > 1:
            found[number] = (ranges[0][0], ranges[-1][1])
    return found
