"""Memory that every step reads, wherever the car is: a planner has had all caches since the last one, so it is fetched while nothing waits for it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

#: Bytes of a type that are looked at where an object of it is made and let go, and of any other object.
_OF_TYPES, _OF_OTHERS = 320, 64


def objects(*all_: object) -> Iterator[tuple[int, int]]:
    """Address and bytes of the beginning of each object."""
    for one in all_:
        yield id(one), _OF_TYPES if isinstance(one, type) else _OF_OTHERS


def libraries(*paths: Path) -> Iterator[tuple[int, int]]:
    """Address and bytes of the code of loaded libraries; of none where the system does not tell. (Of their constants, a step reads too few.)"""
    maps = Path("/proc/self/maps")
    lines = maps.read_text(encoding="utf-8").splitlines() if maps.exists() else []
    found = [(line.split(maxsplit=5)[-1], line.split()) for line in lines]
    for path in map(str, paths):
        for place, (reach, kinds, *_) in found:
            if place == path and "x" in kinds:
                begin, end = (int(one, 16) for one in reach.split("-"))
                yield begin, end - begin
