"""A map of lanelets that fit together: its lanes, and which lanelets lie beside each other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from trackmarshal.errors import TrackmarshalError
from trackmarshal.lanes.curve import Curve
from trackmarshal.lanes.lanelet import Lanelet, bounds

Array = NDArray[np.float64]
#: The most lanes of a map: where many ways part and join again, there are more of them than anyone can look at.
MOST_LANES = 1000
#: How far a successor may begin from where its lanelet ends, in m: what maps round to.
JOINT = 0.1


@dataclass(frozen=True, slots=True)
class Lane:
    """One way through the map: its lanelets by number, from one that none leads to up to one that leads nowhere, and its lines."""

    number: int
    lanelets: tuple[int, ...]
    middle: Curve
    left: Array
    right: Array


class Network:
    """Lanelets by number, checked. where: what the map is called in errors. Raises TrackmarshalError D185 or D186."""

    def __init__(self, lanelets: Iterable[Lanelet], where: str = "") -> None:
        self.where = where
        self.lanelets: dict[int, Lanelet] = {}
        self.bounds: dict[int, tuple[Array, Array]] = {}
        for lanelet in lanelets:
            self.bounds[lanelet.number] = bounds(lanelet, where)
            if lanelet.number in self.lanelets:
                raise self._unfit(f"lanelet {lanelet.number} stands twice", "a number is that of one lanelet")
            self.lanelets[lanelet.number] = lanelet
        if not self.lanelets:
            raise self._unfit("there is no lanelet", "a map without lanes has no rules")
        for lanelet in self.lanelets.values():
            self._beside(lanelet)
            self._onwards(lanelet)
        self.lanes = self._lanes()
        #: By lanelet: closed outlines.
        self.outlines = {n: np.concatenate([left, right[::-1]]) for n, (left, right) in self.bounds.items()}

    @cached_property
    def roads(self) -> dict[int, int]:
        """By lanelet, the least number of those that lie beside it, across any number of neighbours."""
        found: dict[int, int] = {}
        for start in sorted(self.lanelets):
            waiting = [start]
            while waiting:
                number = waiting.pop()
                if number not in found:
                    found[number] = start
                    one = self.lanelets[number]
                    waiting += [n for n in (one.beside_left, one.beside_right) if n is not None]
        return found

    def width(self, number: int, point: Array) -> float:
        """How wide a lanelet is beside a point, in m: between its bounds, at the place of its middle that is nearest."""
        left, right = self.bounds[number]
        middle, wide = (left + right) / 2, np.hypot(*(left - right).T)
        step = np.diff(middle, axis=0)
        share = np.clip(
            np.einsum("ij,ij->i", point - middle[:-1], step) / np.einsum("ij,ij->i", step, step), 0.0, 1.0
        )
        rest = point - middle[:-1] - share[:, None] * step
        piece = int(np.argmin(np.hypot(rest[:, 0], rest[:, 1])))
        return float((1.0 - share[piece]) * wide[piece] + share[piece] * wide[piece + 1])

    def _beside(self, lanelet: Lanelet) -> None:
        sides = (
            ("left", lanelet.beside_left, lanelet.along_left),
            ("right", lanelet.beside_right, lanelet.along_right),
        )
        for side, number, along in sides:
            if number is None:
                continue
            other = self.lanelets.get(number)
            if other is None:
                raise self._unfit(
                    f"lanelet {lanelet.number} has {number} on its {side}, which the map does not have",
                    "add it, or say None",
                )
            if number == lanelet.number or lanelet.beside_left == lanelet.beside_right:
                raise self._unfit(
                    f"lanelet {lanelet.number} has {'itself' if number == lanelet.number else number} on "
                    f"{'its ' + side if number == lanelet.number else 'both sides'}",
                    "name the lanelet that lies there, or say None",
                )
            if (side == "left") == along:
                back, same = other.beside_right, other.along_right
            else:
                back, same = other.beside_left, other.along_left
            if back != lanelet.number or same != along:
                raise self._unfit(
                    f"lanelet {lanelet.number} has {number} on its {side}, {'the same' if along else 'the opposite'} way, "
                    f"which {number} does not say of {lanelet.number}",
                    "of two neighbours each names the other; of opposite ones, both on the same side",
                )

    def _onwards(self, lanelet: Lanelet) -> None:
        for number in lanelet.successors:
            if number not in self.lanelets:
                raise self._unfit(
                    f"lanelet {lanelet.number} leads to {number}, which the map does not have",
                    "add it, or leave it out",
                )
            for own, others in zip(self.bounds[lanelet.number], self.bounds[number]):
                gap = float(np.hypot(*(others[0] - own[-1])))
                if gap > JOINT:
                    raise self._unfit(
                        f"lanelet {lanelet.number} leads to {number}, which begins {gap:.3g} m from where it ends",
                        f"bounds go on within {JOINT} m",
                    )

    def _lanes(self) -> tuple[Lane, ...]:
        led_to = {n for lanelet in self.lanelets.values() for n in lanelet.successors}
        ways: list[tuple[int, ...]] = []
        waiting: list[tuple[int, ...]] = [
            (n,) for n in sorted(self.lanelets, reverse=True) if n not in led_to
        ]
        while waiting:
            way = waiting.pop()
            onwards = sorted(set(self.lanelets[way[-1]].successors), reverse=True)
            again = next((n for n in onwards if n in way), None)
            if again is not None:
                raise self._circle(again)
            waiting += [(*way, n) for n in onwards]
            ways += [] if onwards else [way]
            if len(ways) + len(waiting) > MOST_LANES:
                raise self._unfit(
                    f"there are more than {MOST_LANES} lanes", "take the part of the map that is driven on"
                )
        missed = set(self.lanelets) - {n for way in ways for n in way}
        if missed:
            raise self._circle(min(missed))
        return tuple(self._lane(number, way) for number, way in enumerate(ways))

    def _lane(self, number: int, way: tuple[int, ...]) -> Lane:
        left, right = (np.concatenate([self.bounds[n][side] for n in way]) for side in (0, 1))
        middle = (left + right) / 2
        moved = np.hypot(*np.diff(middle, axis=0).T) > 0.0  # where lanelets join, points stand twice
        return Lane(number, way, Curve(middle[np.concatenate([[True], moved])]), left, right)

    def _circle(self, number: int) -> TrackmarshalError:
        return self._unfit(
            f"lanelet {number} is in a circle, or led to by one",
            "a lane has a beginning and an end: cut the circle where nobody drives",
        )

    def _unfit(self, message: str, way_out: str) -> TrackmarshalError:
        return TrackmarshalError("D186", message, file=self.where or None, help=way_out)
