"""Geometry in generated specs and inputs: predicates and numbers on lines, tracks of all kinds, broken ones too."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from support.generated.choices import Choices
from support.generated.formulas import FormulaWriter, Scope
from support.generated.vocabulary import LENGTH, NUMBER, SHAPES, Dimension

Points = list[list[float]]


class PlaceWriter(FormulaWriter):
    """Writes expressions that ask where things are."""

    def known(self, kind: str, scope: Scope) -> list[str]:
        if kind == "corridor":
            return ["track", *scope.corridors]
        if kind == "trajectory":
            return ["plan"]
        if kind == "polyline":
            return self._lines(scope)
        return super().known(kind, scope)

    def on_lines(self, dimension: Dimension, depth: int, scope: Scope) -> list[Callable[[], str]]:
        points = self.known("point", scope)
        if dimension == LENGTH:
            return [
                *(
                    lambda f=f: f"{f}({self._one(points)}, {self._one(self._lines(scope))})"
                    for f in ("station", "offset", "distance_to")
                ),
                lambda: (
                    f"station_gap({self._one(self._lines(scope))}, {self.number(LENGTH, depth - 1, scope, False)}, {self._leaf(LENGTH, scope)})"
                ),
            ]
        return (
            [lambda: f"direction({self._one(points)}, {self._one(self._lines(scope))})"]
            if dimension == NUMBER
            else []
        )

    def in_places(self, depth: int, scope: Scope) -> list[Callable[[], str]]:
        zones = self.world.zones
        return [
            lambda: f"({self._one(self.known('point', scope))} in zone {self._one(zones)})",
            lambda: (
                f"({self._one(self.known('point', scope))} in stretch({self._one(self._lines(scope))}, "
                f"{self.number(LENGTH, depth - 1, scope, False)}, {self._leaf(LENGTH, scope)}))"
            ),
            lambda: (
                f"({self._hull(depth, scope)} inside {self._one([*zones, *self.known('corridor', scope)])})"
            ),
            lambda: f"({self._hull(depth, scope)} clear_of {self._box(depth, scope)})",
        ]

    def _one(self, names: list[str]) -> str:
        return self.choices.pick(names)

    def _lines(self, scope: Scope) -> list[str]:
        lines = [
            "fence",
            "track",
            "plan",
            "track.left",
            "centre(track)",
            "path(plan)",
            *self.world.lines,
            *scope.lines,
        ]
        return [*lines, *scope.corridors, *(f"centre({name})" for name in scope.corridors)]

    def _sides(self, depth: int, scope: Scope) -> str:
        """A vehicle's length and width: mostly those of one."""
        if self.choices.chance(70):
            return self.choices.pick(
                ("4.7 m, 2 m", "0.5 m, 0.3 m", "1 m, 1 m", "ego.length, ego.width", "12 m, 3 m")
            )
        return f"{self.number(LENGTH, depth - 1, scope, False)}, {self._leaf(LENGTH, scope)}"

    def _box(self, depth: int, scope: Scope) -> str:
        """A footprint at rest."""
        if self.choices.chance(40):
            return f"footprint({self._one(self.known('body', scope))})"
        return f"footprint({self._one(self.known('pose', scope))}, {self._sides(depth, scope)})"

    def _hull(self, depth: int, scope: Scope) -> str:
        """A footprint, mostly a swept one."""
        moving = [name for name in scope.samples if SHAPES["pose"].keys() <= dict(scope.records)[name].keys()]
        if moving and self.choices.chance(70):
            one = self._one(moving)
            curved = "kappa" in dict(scope.records)[one] and self.choices.chance(60)
            return f"{'swept_footprint' if curved else 'swept_hull'}({one}, {self._sides(depth, scope)})"
        if self.choices.chance(50):
            poses = self.known("pose", scope)
            return f"swept({self._one(poses)}, {self._one(poses)}, {self._sides(depth, scope)})"
        return self._box(depth, scope)


class Road:
    """Makes points of lines, rings and tracks; a track is often the very object of an earlier case, as in a run."""

    def __init__(self, choices: Choices) -> None:
        self.choices = choices
        self._tracks: list[dict[str, Any]] = []
        self._fences: list[Points] = []

    def signals(self, dirt: int) -> dict[str, Any]:
        """The signals `track` and `fence` of one case."""
        if not self._tracks or self.choices.chance(40):
            self._tracks.append(self.track(dirt))
        if not self._fences or self.choices.chance(40):
            self._fences.append(self._broken(self.line()) if self.choices.chance(dirt) else self.line())
        return {
            "track": self.choices.pick(self._tracks[::-1]),
            "fence": self.choices.pick(self._fences[::-1]),
        }

    def line(self) -> Points:
        """An open line of a few segments, straight or not."""
        x, y = self.choices.pick((-10.0, 0.0, -3.0)), self.choices.pick((0.0, 1.0, -2.5))
        points = [[x, y]]
        for _ in range(self.choices.integer(1, 5)):
            x += self.choices.pick((5.0, 2.0, 0.0, 7.5))
            y += self.choices.pick((0.0, 0.0, 1.0, -2.0))
            points.append([x, y])
        if all(point == points[0] for point in points):
            points.append([x + 1.0, y])
        return points

    def mark(self) -> Points:
        """A line that goes on to the right, and so lies nowhere twice: what a spec may declare."""
        first, *others = self.line()
        points = [first]
        for point in others:
            if point[0] > points[-1][0]:
                points.append(point)
        return points if len(points) > 1 else [first, [first[0] + 1.0, first[1]]]

    def ring(self) -> Points:
        """A simple polygon around some point, or a box."""
        x, y = self.choices.pick((0.0, 1.0, -5.0)), self.choices.pick((0.0, 2.0))
        if self.choices.chance(40):
            a, b = self.choices.pick((3.0, 10.0, 0.5)), self.choices.pick((2.0, 15.0))
            return [[x - a, y - b], [x + a, y - b], [x + a, y + b], [x - a, y + b]]
        return _circle(x, y, [self.choices.pick((3.0, 8.0, 20.0)) for _ in range(self.choices.integer(3, 9))])

    def track(self, dirt: int) -> dict[str, Any]:
        """A corridor: open or closed, round, straight or crossing itself; with dirt it may be broken."""
        kind = self.choices.integer(0, 3)
        count = self.choices.integer(4, 9)
        closed = kind >= 2
        if kind == 0:  # straight, with borders of unequal numbers of points
            width = self.choices.pick((6.0, 3.0, 20.0))
            left = [[-20.0 + 10.0 * k, width / 2] for k in range(5)]
            right = [[-20.0 + 5.0 * k, -width / 2] for k in range(9)]
        elif kind == 1:  # a bend
            left, right = (
                [[r * math.cos(k * 0.3), r * math.sin(k * 0.3) - 15.0] for k in range(count)]
                for r in (12.0, 18.0)
            )
        elif kind == 2:  # a ring
            left, right = (
                _circle(0.0, 0.0, [6.0] * count),
                _circle(0.0, 0.0, [14.0] * (count + self.choices.integer(0, 2))),
            )
        else:  # a figure of eight: a bridge
            middle = [
                [12.0 * math.sin(2 * math.pi * k / 24), 9.0 * math.sin(4 * math.pi * k / 24)]
                for k in range(24)
            ]
            left, right = _beside(middle, 1.5), _beside(middle, -1.5)
        if self.choices.chance(dirt):
            left = self._broken(left)
        result: dict[str, Any] = {"left": left, "right": right}
        if self.choices.chance(dirt // 4):
            result[self.choices.pick(("left", "right"))] = None
        return result | ({"closed": True} if closed else {})

    def _broken(self, points: Points) -> Points:
        kind = self.choices.integer(0, 3)
        if kind == 0:
            return points[:1]
        if kind == 1:
            return [*points[:1], [math.nan, 0.0], *points[1:]]
        if kind == 2:
            return points[::-1]
        return [*points[:2], [1e300, -1e12], *points[2:]]


def _circle(x: float, y: float, radii: list[float]) -> Points:
    step = 2 * math.pi / len(radii)
    return [[x + r * math.cos(k * step), y + r * math.sin(k * step)] for k, r in enumerate(radii)]


def _beside(ring: Points, offset: float) -> Points:
    """Points beside those of a ring, `offset` to the left of its direction."""
    result = []
    for before, here, after in zip([ring[-1], *ring], ring, [*ring[1:], ring[0]]):
        dx, dy = after[0] - before[0], after[1] - before[1]
        length = math.sqrt(dx * dx + dy * dy)
        result.append([here[0] - offset * dy / length, here[1] + offset * dx / length])
    return result
