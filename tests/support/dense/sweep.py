"""Whether a footprint leaves the road along the curve, footprint by footprint, with shapely.

Between two samples all footprints lie within the hull of the first and the last one, widened by how far any corner departs from the straight way
between its ends: a point of a rectangle departs by no more than the corners do. Where the borders stay clear of that, twice over, nothing needs
to be looked at more closely; elsewhere every footprint of the curve, 2 cm apart, is held against the road.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from support.dense import curve
from support.dense.car import Car
from support.dense.recording import Columns, Floats, Recording


@dataclass(frozen=True)
class Road:
    """The road as an area, and its borders as lines."""

    area: shapely.Polygon
    borders: shapely.MultiLineString


def road(recording: Recording) -> Road:
    """Of a closed track: what lies between its two rings, either of which may be the outer one."""
    assert recording.closed, "open tracks do not occur in these recordings"
    inner, outer = sorted(map(shapely.Polygon, (recording.left, recording.right)), key=lambda ring: ring.area)
    assert inner.is_valid
    assert outer.is_valid
    assert outer.contains(inner)
    area = shapely.Polygon(outer.exterior, [inner.exterior])
    borders = shapely.MultiLineString([outer.exterior, inner.exterior])
    shapely.prepare(area)
    shapely.prepare(borders)
    return Road(area, borders)


def corners(x: Floats, y: Floats, heading: Floats, length: float, width: float) -> Floats:
    """(..., 4, 2): corners of footprints, in a row around each."""
    along = np.stack([np.cos(heading), np.sin(heading)], axis=-1)[..., None, :] * (length / 2.0)
    across = np.stack([-np.sin(heading), np.cos(heading)], axis=-1)[..., None, :] * (width / 2.0)
    ends = np.array([1.0, 1.0, -1.0, -1.0])[:, None]
    sides = np.array([1.0, -1.0, -1.0, 1.0])[:, None]
    return np.asarray(np.stack([x, y], axis=-1)[..., None, :] + along * ends + across * sides)


def along(part: curve.Pieces, car: Car) -> Floats:
    """(steps, points, 4, 2): corners of the car along pieces."""
    return corners(part.x, part.y, part.heading, car.length, car.width)


@dataclass(frozen=True)
class Left:
    """Where a candidate leaves the road most: after which sample, m^2 outside, and m from the border to what is furthest out."""

    sample: int
    area: float
    depth: float


def leaves(columns: Columns, place: Road, car: Car) -> Left | None:
    """The worst footprint that is not wholly on the road; None where all are on it."""
    near = _near(columns, place, car)
    worst: Left | None = None
    if not near.any():
        return None
    dense = along(curve.pieces(columns, curve.points_for(columns), near), car)
    prints = shapely.polygons(dense)
    out = ~shapely.covers(place.area, prints)
    for row, sample in enumerate(np.flatnonzero(near)):
        if out[row].any():
            beyond = shapely.difference(prints[row][out[row]], place.area)
            areas = shapely.area(beyond)
            k = int(areas.argmax())
            if worst is None or areas[k] > worst.area:
                points = shapely.points(shapely.get_coordinates(beyond[k]))
                depth = float(shapely.distance(place.borders, points).max())
                worst = Left(int(sample), float(areas[k]), depth)
    return worst


def _near(columns: Columns, place: Road, car: Car) -> Floats:
    """The steps at which the borders are near enough to look at every footprint."""
    rough = along(curve.pieces(columns, 11), car)
    share = np.linspace(0.0, 1.0, 11)[:, None, None]
    astray = rough - ((1.0 - share) * rough[:, :1] + share * rough[:, -1:])
    departs = np.hypot(astray[..., 0], astray[..., 1]).max(axis=(1, 2))
    hulls = shapely.convex_hull(shapely.multipoints(np.concatenate([rough[:, 0], rough[:, -1]], axis=1)))
    within = shapely.covers(place.area, hulls)
    clear = ~shapely.dwithin(place.borders, hulls, 2.0 * departs + 1e-6)
    return np.asarray(~(within & clear))
