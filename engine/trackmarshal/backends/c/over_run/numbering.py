"""Ids as C knows them: a number for each that was ever given, whatever it is made of."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.ir.spec import Spec


class Numbering:
    """Numbers of the ids of one run. forget: of signals whose elements are known again after an absence, for how long [ns]."""

    def __init__(self, forget: Mapping[str, int] = MappingProxyType({})) -> None:
        self._forget = forget
        #: Of such signals, at which stamp one was absent first.
        self._absent: dict[str, dict[str, int]] = {}
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
        self._present, self._absent, self._next = {}, {}, following

    def settle(self, t: float | None) -> None:
        """The last cycle, which had the stamp t [s], is remembered: those that were not in it are gone, or will be after a while, and whatever
        comes back under their ids is another one then."""
        for signal, present in self._present.items():
            known, forget = self._numbers[signal], self._forget.get(signal, 0)
            if forget and t is not None:
                now, before = nanoseconds(t), self._absent.get(signal, {})
                absent = {name: before.get(name, now) for name in known if name not in present}
                self._absent[signal] = {name: at for name, at in absent.items() if now - at < forget}
                self._numbers[signal] = {
                    name: n for name, n in known.items() if name in present or name in self._absent[signal]
                }
            elif len(known) > len(present):
                self._numbers[signal] = {name: known[name] for name in present}


def lasting(spec: Spec) -> dict[str, int]:
    """For how long elements of sets may be absent and are known again [ns], of those that may."""
    return {name: signal.forget for name, signal in spec.signals.items() if signal.forget}
