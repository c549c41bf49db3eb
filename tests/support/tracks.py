"""Tracks of our own making: borders with bulges, figures of eight, and the borders of shared recordings."""

from __future__ import annotations

import ast
import csv
import math
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

Point = tuple[float, float]
Borders = tuple[list[Point], list[Point]]


def offset_borders(
    centre: Sequence[Point], directions: Sequence[float], left: float, right: float
) -> Borders:
    """Borders at constant distances left and right of a line."""
    return (
        [(x - left * math.sin(h), y + left * math.cos(h)) for (x, y), h in zip(centre, directions)],
        [(x + right * math.sin(h), y - right * math.cos(h)) for (x, y), h in zip(centre, directions)],
    )


def loop(
    way: Callable[[float], Point], count: int, left: float, right: float
) -> tuple[Borders, list[tuple[float, float, float]]]:
    """Borders along a closed curve over [0, 1), and the poses on the curve."""
    step = 1e-6
    centre = [way(k / count) for k in range(count)]
    ahead = [way(k / count + step) for k in range(count)]
    headings = [math.atan2(q[1] - p[1], q[0] - p[0]) for p, q in zip(centre, ahead)]
    return offset_borders(centre, headings, left, right), [(*p, h) for p, h in zip(centre, headings)]


def oval(t: float) -> Point:
    """A track with bends to both sides."""
    a = 2.0 * math.pi * t
    r = 120.0 * (1.0 + 0.25 * math.cos(3.0 * a))
    return r * math.cos(a), 0.8 * r * math.sin(a)


def eight(t: float) -> Point:
    """A figure of eight that crosses itself at the origin."""
    a = 2.0 * math.pi * (t + 0.013)
    return 150.0 * math.sin(a), 90.0 * math.sin(2.0 * a)


def scenario_borders(path: Path) -> Borders:
    """The borders in a recording: two comment lines in the text file inside the archive."""
    with zipfile.ZipFile(path) as archive:
        name = next(name for name in archive.namelist() if name.endswith(".scn"))
        with archive.open(name) as lines:
            left, right = (lines.readline().decode().split(":", 1)[1] for _ in range(2))
    return [tuple(p) for p in ast.literal_eval(left.strip())], [
        tuple(p) for p in ast.literal_eval(right.strip())
    ]


def race_line(path: Path) -> tuple[Borders, list[tuple[float, float, float]]]:
    """Borders and the poses of the race line of a shared track.

    The normal vector points to the right of the reference line: the right border lies along it, the left one against it, and
    the race line `alpha` along it. Its heading is 0 along +y in the file.
    """
    with path.open(encoding="utf-8") as lines:
        rows = [
            [float(cell) for cell in row]
            for row in csv.reader(lines, delimiter=";")
            if not row[0].startswith("#")
        ]
    left = [(x - w * nx, y - w * ny) for x, y, _, w, nx, ny, *_ in rows]
    right = [(x + w * nx, y + w * ny) for x, y, w, _, nx, ny, *_ in rows]
    poses = [(x + a * nx, y + a * ny, psi + math.pi / 2) for x, y, _, _, nx, ny, a, _, psi, *_ in rows]
    return (left, right), poses
