"""The two implementations of geometry behind one face, for tests that hold for both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from trackmarshal.backends.reference import geometry as reference
from trackmarshal.runtime import geometry as fast

Points = Sequence[tuple[float, float]]
Pose = tuple[float, float, float]
Body = tuple[float, float]


class Geometry(Protocol):
    """What both implementations answer, one question at a time."""

    def inside(
        self, left: Points, right: Points, pose0: Pose, pose1: Pose, body: Body, closed: bool = False
    ) -> float: ...

    def inside_polygon(self, points: Points, pose0: Pose, pose1: Pose, body: Body) -> float: ...

    def fault(self, left: Points, right: Points, closed: bool = False) -> str | None: ...

    def zone(self, point: tuple[float, float], points: Points) -> float: ...

    def zone_fault(self, points: Points) -> str | None: ...

    def clear(self, pose0: Pose, pose1: Pose, body: Body, box: Pose, size: Body) -> float: ...

    def clear_of_sweep(
        self, pose0: Pose, pose1: Pose, body: Body, other0: Pose, other1: Pose, size: Body
    ) -> float: ...

    def project(
        self, point: tuple[float, float], line: Points, closed: bool = False
    ) -> tuple[float, float, float]: ...

    def distance(self, point: tuple[float, float], line: Points, closed: bool = False) -> float: ...

    def gap(self, line: Points, start: float, end: float, closed: bool = False) -> float: ...

    def centre(self, left: Points, right: Points, closed: bool = False) -> Points: ...


class Reference:
    """Plain Python."""

    def inside(
        self, left: Points, right: Points, pose0: Pose, pose1: Pose, body: Body, closed: bool = False
    ) -> float:
        return reference.hull_inside_margin(left, right, closed, pose0, pose1, *body)

    def inside_polygon(self, points: Points, pose0: Pose, pose1: Pose, body: Body) -> float:
        return reference.hull_margin_in(reference.region_of(points), pose0, pose1, *body)

    def fault(self, left: Points, right: Points, closed: bool = False) -> str | None:
        return reference.corridor_fault(left, right, closed)

    def zone(self, point: tuple[float, float], points: Points) -> float:
        return reference.in_zone_margin(*point, points)

    def zone_fault(self, points: Points) -> str | None:
        return reference.zone_fault(points)

    def clear(self, pose0: Pose, pose1: Pose, body: Body, box: Pose, size: Body) -> float:
        return reference.clear_margin(pose0, pose1, *body, box, *size)

    def clear_of_sweep(
        self, pose0: Pose, pose1: Pose, body: Body, other0: Pose, other1: Pose, size: Body
    ) -> float:
        return reference.swept_clearance(pose0, pose1, *body, other0, other1, *size)

    def project(
        self, point: tuple[float, float], line: Points, closed: bool = False
    ) -> tuple[float, float, float]:
        return reference.project(*point, line, closed)

    def distance(self, point: tuple[float, float], line: Points, closed: bool = False) -> float:
        return reference.distance_to_line(*point, line, closed)

    def gap(self, line: Points, start: float, end: float, closed: bool = False) -> float:
        return reference.station_gap(line, start, end, closed)

    def centre(self, left: Points, right: Points, closed: bool = False) -> Points:
        return reference.centre_line(left, right, closed)


class Fast:
    """numpy."""

    def inside(
        self, left: Points, right: Points, pose0: Pose, pose1: Pose, body: Body, closed: bool = False
    ) -> float:
        return float(fast.Corridor(left, right, closed).margin_inside(*pose0, *pose1, *body)[0])

    def inside_polygon(self, points: Points, pose0: Pose, pose1: Pose, body: Body) -> float:
        return float(fast.Polygon(points).margin_inside(*pose0, *pose1, *body)[0])

    def fault(self, left: Points, right: Points, closed: bool = False) -> str | None:
        return fast.Corridor(left, right, closed).fault

    def zone(self, point: tuple[float, float], points: Points) -> float:
        return float(fast.Polygon(points).signed_distance(*point)[0])

    def zone_fault(self, points: Points) -> str | None:
        return fast.Polygon(points).fault

    def clear(self, pose0: Pose, pose1: Pose, body: Body, box: Pose, size: Body) -> float:
        return float(fast.boxes_clear(*pose0, *pose1, *body, *box, *size))

    def clear_of_sweep(
        self, pose0: Pose, pose1: Pose, body: Body, other0: Pose, other1: Pose, size: Body
    ) -> float:
        return float(fast.sweeps_clear(*pose0, *pose1, *body, *other0, *other1, *size))

    def project(
        self, point: tuple[float, float], line: Points, closed: bool = False
    ) -> tuple[float, float, float]:
        station, offset, direction = fast.Polyline(line, closed).project(*point)
        return float(station[0]), float(offset[0]), float(direction[0])

    def distance(self, point: tuple[float, float], line: Points, closed: bool = False) -> float:
        return float(fast.Polyline(line, closed).distance(*point)[0])

    def gap(self, line: Points, start: float, end: float, closed: bool = False) -> float:
        return float(fast.Polyline(line, closed).gap(start, end)[0])

    def centre(self, left: Points, right: Points, closed: bool = False) -> Points:
        return [(float(x), float(y)) for x, y in fast.Corridor(left, right, closed).centre.points]


BOTH = {"reference": Reference(), "fast": Fast()}


def same_trigonometry(*headings: float) -> bool:
    """Whether numpy and the platform's libm give the same sine and cosine of some angles, to the last bit."""
    return all(math.cos(h) == np.cos(h) and math.sin(h) == np.sin(h) for h in headings)
