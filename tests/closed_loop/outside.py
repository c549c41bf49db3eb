"""What became of the car, by shapely and nothing of the engine's: on the road or off it, contact or none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from closed_loop.adapter import _on_curve
from closed_loop.car import Build
from closed_loop.executing import Columns
from closed_loop.loop import Trace
from closed_loop.road import Road
from closed_loop.traffic import LENGTH, WIDTH


def surface(road: Road) -> shapely.Polygon:
    """The road between its two closed borders."""
    left, right = shapely.Polygon(road.left), shapely.Polygon(road.right)
    outer, inner = (left, right) if left.area > right.area else (right, left)
    found = shapely.Polygon(outer.exterior.coords, [inner.exterior.coords])
    if not found.is_valid:
        raise ValueError(f"the borders of {road.name} cross")
    return found


def boxes(poses: Sequence[tuple[float, float, float]], length: float, width: float) -> list[shapely.Polygon]:
    """Footprints at poses x, y, heading."""
    found = []
    for x, y, heading in poses:
        c, s = math.cos(heading), math.sin(heading)
        corners = ((length, width), (-length, width), (-length, -width), (length, -width))
        found.append(
            shapely.Polygon([(x + (a * c - b * s) / 2, y + (a * s + b * c) / 2) for a, b in corners])
        )
    return found


def clearance(road: Road, footprints: Sequence[shapely.Polygon]) -> float:
    """The least distance to a border, m; negative: how far the body is off the road."""
    ground = surface(road)
    shapely.prepare(ground)
    inside = shapely.covers(ground, np.array(footprints))
    if inside.all():
        return float(shapely.distance(shapely.boundary(ground), np.array(footprints)).min())
    out = shapely.segmentize(np.array(footprints)[~inside], 0.1)
    return -float(shapely.distance(ground, shapely.points(shapely.get_coordinates(out))).max()) or -1e-9


def swept(path: Columns) -> list[tuple[float, float, float]]:
    """Poses along a trajectory, 0.1 m apart, on the cubics between its samples."""
    poses = []
    for i in range(len(path["s"]) - 1):
        way = path["s"][i + 1] - path["s"][i]
        turn = math.remainder(path["heading"][i + 1] - path["heading"][i], math.tau)
        count = max(math.ceil(way / 0.1), 1)
        for k in range(count):
            poses.append((*_on_curve(path, i, k / count), path["heading"][i] + turn * k / count))
    return [*poses, (path["x"][-1], path["y"][-1], path["heading"][-1])]


@dataclass(frozen=True)
class Outcome:
    """rest: whether the car stood in the end. clearance: of the body, m, all along; negative: off the road. gap: the least one to another
    car, m, 0 for contact, infinite where there was none; `contact` says with whom and when."""

    rest: bool
    clearance: float
    gap: float
    contact: str
    stopped: float
    way: float


def outcome(trace: Trace, road: Road, build: Build) -> Outcome:
    """What a run came to."""
    bodies = boxes([pose[1:4] for pose in trace.poses], build.length, build.width)
    gap, contact = math.inf, ""
    for body, (t, *_), others in zip(bodies, trace.poses, trace.others):
        for (name, *_), box in zip(others, boxes([o[1:] for o in others], LENGTH, WIDTH)):
            apart = shapely.distance(body, box)
            if apart < gap:
                gap = float(apart)
                contact = f"{name} at {t:.2f} s" if apart == 0.0 else ""
    way = sum(math.dist(p[1:3], q[1:3]) for p, q in zip(trace.poses, trace.poses[1:]))
    last = trace.poses[-1]
    return Outcome(last[4] == 0.0, clearance(road, bodies), gap, contact, last[0], way)
