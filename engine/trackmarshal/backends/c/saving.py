"""What a Supervisor in generated C leaves to its next step as pieces of plain data: bytes of its context, which only the same program reads."""

from __future__ import annotations

import sys
from base64 import b64decode, b64encode
from collections.abc import Iterator, Mapping
from typing import Any

from trackmarshal.runtime.plan import Plan
from trackmarshal.runtime.saving import Piece, Pieces, checked, count, spelt, unsaved, unspelt
from trackmarshal.runtime.stored import plan_of, plan_pieces

#: The bytes of a piece, and how many pages of zeros are one.
_PAGE, _ZEROS = 4096, 64
#: The most bytes that are saved: they are copied in one step.
MOST_BYTES = 4 << 20
#: Of rules by themselves, which nobody waits for.
MOST_OF_RULES = 128 << 20
_NONE = bytes(_PAGE)


def words(
    program: str, lasting: list[tuple[int, int]], sizes: Mapping[str, int], most: int = MOST_BYTES
) -> str:
    """What the bytes are of. Raises TrackmarshalError E486 where they are too many, as they are to be copied in a step."""
    total = sum(size for _, size in lasting)
    if total > most:
        raise unsaved(
            f"the memory of its rules takes {-(-total >> 10)} KiB, and at most {most >> 10} are saved"
        )
    return f"{program} {sorted(sizes.items())} {lasting} {sys.byteorder}"


def pieces(
    steps: int, last: float, stored: Plan | None, saved: tuple[bytes, dict[str, dict[str, int]], int]
) -> Iterator[Piece]:
    """Of what was taken. last: the clock's last reading that words speak of."""
    data, numbers, following = saved
    yield ["c", steps, spelt(last), stored is not None, len(data), following]
    yield from plan_pieces(stored)
    yield ["ids", numbers]
    yield from pages(data)


def pages(data: bytes) -> Iterator[Piece]:
    """Bytes, page by page; of zeros, how many pages."""
    at = 0
    while at < len(data):
        zeros = 0
        while zeros < _ZEROS and data.startswith(_NONE, at + zeros * _PAGE):
            zeros += 1
        if zeros:
            yield ["zeros", zeros]
            at += zeros * _PAGE
        else:
            yield ["bytes", b64encode(data[at : at + _PAGE]).decode("ascii")]
            at += _PAGE


def loaded(given: Pieces) -> tuple[int, float, Plan | None, bytes, dict[str, dict[str, int]], int]:
    """Steps, the last reading, what is stored, the bytes, and the numbers of ids. Raises ValueError, or what else comes of data that nobody saved."""
    steps, last, stored, size, following = given.next("c", 5)
    plan = plan_of(given) if checked(stored, bool) else None
    numbers = numbers_of(given, following)
    return count(steps), unspelt(last), plan, bytes_of(given, count(size)), numbers, count(following)


def numbers_of(given: Pieces, following: Any) -> dict[str, dict[str, int]]:
    """The numbers of ids, each below the one that comes next."""
    (numbers,) = given.next("ids", 1)
    used = [
        _number(number, following)
        for known in checked(numbers, dict).values()
        for number in checked(known, dict).values()
    ]
    if len(set(used)) != len(used):
        raise ValueError("two elements have one number")
    return dict(numbers)


def bytes_of(given: Pieces, size: int) -> bytes:
    """So many bytes, as `pages` gives them."""
    data = bytearray()
    while len(data) < size:
        kind, (value,) = given.any()
        if kind == "zeros" and 0 < count(value) <= _ZEROS:
            data += _NONE * value
        elif kind == "bytes":
            page = b64decode(value, validate=True)
            if not 0 < len(page) <= _PAGE:
                raise ValueError("no page")
            data += page
        else:
            raise ValueError("bytes should come")
    if len(data) != size:
        raise ValueError("more bytes than there should be")
    return bytes(data)


def _number(value: Any, following: Any) -> int:
    if not 0 < count(value) < count(following):
        raise ValueError("an element has a number that is not given yet")
    found: int = value
    return found
