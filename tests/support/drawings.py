"""A drawing of a boundary read back from its SVG: numbers on its axes, regions, lines and marks. Nothing of what draws it is used."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field

SVG = "{http://www.w3.org/2000/svg}"
NUMBER = r"-?\d*\.?\d+(?:e-?\d+)?"
Point = tuple[float, float]


@dataclass
class Drawn:
    """In pixels: regions by name, each as closed lines; lines of boundaries; tests by shape; samples."""

    text: str
    regions: dict[str, list[list[Point]]] = field(default_factory=dict)
    boundary: list[list[Point]] = field(default_factory=list)
    others: list[list[list[Point]]] = field(default_factory=list)
    tests: list[tuple[str, Point, str, bool]] = field(default_factory=list)
    held: list[Point] = field(default_factory=list)
    broken: list[Point] = field(default_factory=list)
    words: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        root = ET.fromstring(self.text)
        ticks: tuple[list[tuple[float, float]], list[tuple[float, float]]] = ([], [])
        for one in root.iter():
            kind, d = one.get("class", ""), one.get("d", "")
            if kind.startswith("region "):
                self.regions[kind.partition(" ")[2]] = lines(d)
            elif kind == "boundary":
                self.boundary = lines(d)
            elif kind == "other":
                self.others.append(lines(d))
            elif kind == "held":
                self.held = [(float(x), float(y)) for x, y in re.findall(rf"M({NUMBER}) ({NUMBER})h", d)]
            elif kind == "against":
                self.broken = [
                    (float(x) + 2.5, float(y) + 2.5)
                    for x, y in re.findall(rf"M({NUMBER}) ({NUMBER})l5 5m0-5", d)
                ]
            elif kind.startswith("test "):
                x, y = map(float, re.findall(NUMBER, one.get("transform", "")))
                said = one.find(f"{SVG}title")
                assert said is not None
                assert said.text
                self.tests.append((kind.partition(" ")[2], (x, y), said.text, one.get("fill") != "#ffffff"))
            elif one.tag == f"{SVG}text" and one.text:
                self.words.append(one.text)
                if re.fullmatch(NUMBER.replace(r"\d*\.?\d+", r"\d+(?:\.\d+)?"), one.text):
                    which = 0 if one.get("text-anchor") == "middle" else 1
                    place = float(one.get("xy"[which], ""))
                    ticks[which].append((place - (3.6 if which else 0.0), float(one.text)))
        box = next(one for one in root.iter(f"{SVG}rect") if one.get("fill") == "none")
        self.left, self.top = float(box.get("x", "")), float(box.get("y", ""))
        self.right, self.low = (
            self.left + float(box.get("width", "")),
            self.top + float(box.get("height", "")),
        )
        self._scales = [scale(one) for one in ticks if one]

    def value(self, point: Point) -> list[float]:
        """The numbers on the axes."""
        return [at + slope * place for (at, slope), place in zip(self._scales, point)]

    def pixel(self, *values: float) -> list[float]:
        return [(value - at) / slope for (at, slope), value in zip(self._scales, values)]

    def inside(self, name: str, point: Point) -> bool:
        """By the even-odd rule."""
        return sum(crossed(point, line) for line in self.regions.get(name, [])) % 2 == 1

    def region(self, point: Point) -> str:
        """The one region in which a point is."""
        found = [name for name in self.regions if self.inside(name, point)]
        assert len(found) == 1, (point, found)
        return found[0]

    def near(self, point: Point) -> float:
        """How many pixels it is to the nearest line around a region."""
        return min(
            away(point, a, b)
            for around in self.regions.values()
            for line in around
            for a, b in zip(line, line[1:])
        )


def lines(d: str) -> list[list[Point]]:
    """The lines of a path of straight pieces; closed ones end where they begin."""
    found = []
    for part in re.findall(r"M[^M]*", d):
        points = [(float(x), float(y)) for x, y in re.findall(rf"({NUMBER}) ({NUMBER})", part)]
        found.append([*points, points[0]] if part.endswith("Z") else points)
    return found


def scale(ticks: list[tuple[float, float]]) -> tuple[float, float]:
    """The line through ticks that are farthest apart; all others lie on it."""
    (p, a), (q, b) = min(ticks), max(ticks)
    slope = (b - a) / (q - p)
    assert all(abs(a + slope * (place - p) - value) < 0.02 * abs(slope) + 1e-9 for place, value in ticks), (
        ticks
    )
    return a - slope * p, slope


def crossed(point: Point, line: list[Point]) -> int:
    """How often a ray to the right crosses a line."""
    x, y = point
    return sum(
        (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay)
        for (ax, ay), (bx, by) in zip(line, line[1:])
    )


def away(point: Point, a: Point, b: Point) -> float:
    """The distance from a point to a piece of a line."""
    (x, y), (ax, ay), (bx, by) = point, a, b
    way = (bx - ax) ** 2 + (by - ay) ** 2
    share = 0.0 if way == 0.0 else min(max(((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / way, 0.0), 1.0)
    return float(((x - ax - share * (bx - ax)) ** 2 + (y - ay - share * (by - ay)) ** 2) ** 0.5)
