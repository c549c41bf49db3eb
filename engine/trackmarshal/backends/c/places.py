"""Tracks, zones and lines of a program: their place in the context, and how they get there."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.backends.c.layout import Layout


def types(plan: Layout) -> Iterator[str]:
    yield from ()


def members(plan: Layout) -> list[str]:
    return []


def initial(plan: Layout) -> Iterator[str]:
    yield from ()


def setters(plan: Layout) -> Iterator[str]:
    yield from ()


def glue(plan: Layout) -> Iterator[str]:
    yield from ()


def prototypes(plan: Layout) -> Iterator[str]:
    yield from ()


class PlaceSetter:
    def __init__(self, plan: Layout, library: object) -> None:
        pass
