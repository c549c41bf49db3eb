"""Ids as C knows them: a number for each that was ever given, whatever it is made of."""

from __future__ import annotations

from array import array
from collections.abc import Sequence


class Numbering:
    """Numbers of the ids of one run."""

    def __init__(self) -> None:
        self._numbers: dict[str, dict[str, int]] = {}
        self._present: dict[str, frozenset[str]] = {}
        self._next = 1

    def of(self, signal: str, ids: Sequence[str]) -> array[int]:
        """The numbers of a set's ids, no two of them alike; never without memory, so that its address is one."""
        known = self._numbers.setdefault(signal, {})
        found = array("Q")
        present = set[str]()
        for name in ids:
            if name not in known or name in present:  # of two alike, each is one: whoever reads them was told
                known[name] = self._next
                self._next += 1
            present.add(name)
            found.append(known[name])
        self._present[signal] = frozenset(present)
        return found if found else array("Q", [0])

    def taken(self) -> tuple[dict[str, dict[str, int]], int]:
        """The numbers of the ids of each signal, and the one that comes next."""
        return {signal: dict(known) for signal, known in self._numbers.items()}, self._next

    def put(self, numbers: dict[str, dict[str, int]], following: int) -> None:
        """Go on from what another one had."""
        self._numbers = {signal: dict(known) for signal, known in numbers.items()}
        self._present, self._next = {}, following

    def settle(self) -> None:
        """The last cycle is remembered: those that were not in it are gone, and whatever comes back under their ids is another one."""
        for signal, present in self._present.items():
            known = self._numbers[signal]
            if len(known) > len(present):
                self._numbers[signal] = {name: known[name] for name in present}
