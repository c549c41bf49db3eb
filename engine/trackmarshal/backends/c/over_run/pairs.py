"""Pairs of elements of which something is remembered: each has a place for itself, made of the places of its two elements."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from trackmarshal.ir import nodes as ir


@dataclass(frozen=True)
class Pairs:
    """All pairs of the elements of two sets, or of one twice. forget: whether a pair may be apart for a while and is known again."""

    first: str
    second: str
    c_name: str
    forget: bool


def pairs_of(about: Iterable[tuple[ir.Axis, ...]]) -> dict[tuple[str, ...], Pairs]:
    """By signals, the pairs that some operators are about."""
    found: dict[tuple[str, ...], Pairs] = {}
    for axes in about:
        if len(axes) == 2:
            first, second = signals = tuple(axis.signal for axis in axes)
            forget = any(axis.forget for axis in axes)
            found.setdefault(signals, Pairs(first, second, f"pairs_{len(found) + 1}", forget))
    return found
