"""The way of a vehicle between two samples: where it passes, in pieces, and how far beside these it may be.

What is assumed, why nothing that the vehicle covers is left out, and how much is covered beyond it: docs/geometry.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from trackmarshal.points import Pose, sized, usable

#: A way is cut into so many pieces at most.
MOST = 32
#: A way is cut until the hull of a piece exceeds what is swept by no more than this for turning, or into `MOST` pieces [m].
WANTED = 0.007
#: A square of a way's length that is one of no direction [m^2].
NOWHERE = 1e-12
#: What is added to a way is left out where it is less than this: that is rounding [m].
ROUNDING = 1e-9
#: How much less the ends of a way that bends both ways count, for pieces of the whole: of 1, all but 0.26 (docs/geometry.md).
EVEN = 0.74
#: By how much the slope of a clothoid grows unevenly, of its lean times the square of what it turns (docs/geometry.md).
WINDING = 0.03125


class Placed(NamedTuple):
    """A pose with the cosine and the sine of its heading."""

    x: float
    y: float
    ahead: float
    aside: float


def placed(pose: Pose) -> Placed:
    """A pose in place."""
    return Placed(pose[0], pose[1], math.cos(pose[2]), math.sin(pose[2]))


class Curve(NamedTuple):
    """The poses where the pieces of a way begin and end, and how far beyond the pieces' hulls a vehicle may reach [m]."""

    poses: tuple[Placed, ...]
    more: float


def curve_between(
    pose0: Pose, pose1: Pose, bend: Sequence[float], length: float, width: float
) -> Curve | None:
    """The same between poses, for messages; None without curvatures, or where a number is none."""
    if not bend or not usable(*pose0, *pose1, *bend) or not sized(length, width):
        return None
    return curve(placed(pose0), placed(pose1), bend, length, width)


def curve(first: Placed, second: Placed, bend: Sequence[float], length: float, width: float) -> Curve:
    """The way from one pose to another, with the curvatures [1/m] at both."""
    dx, dy = second.x - first.x, second.y - first.y
    square = dx * dx + dy * dy
    along0, aside0 = dx * first.ahead + dy * first.aside, dx * first.aside - dy * first.ahead
    along1, aside1 = dx * second.ahead + dy * second.aside, dx * second.aside - dy * second.ahead
    way = math.sqrt(square)
    corner = math.sqrt(0.5 * length * (0.5 * length) + 0.5 * width * (0.5 * width))
    fits = (
        square > NOWHERE
        and along0 * along1 > 0.0
        and abs(aside0) <= abs(along0)
        and abs(aside1) <= abs(along1)
    )
    if not fits:
        return Curve((first, second), _at_random(first, second, way, corner))
    # All that follows is seen along the chord. Slopes of the heading at both ends; slopes grow along the way by so much.
    slope0, slope1 = aside0 / along0, aside1 / along1
    grow0, grow1 = 1.0 + slope0 * slope0, 1.0 + slope1 * slope1
    bent0 = bend[0] * way * (grow0 * math.sqrt(grow0))
    bent1 = bend[1] * way * (grow1 * math.sqrt(grow1))
    turn = slope1 - slope0
    lean = 0.5 * (bent0 - bent1)
    sway = -3.0 * (slope0 + slope1)
    slip = abs(lean - sway)
    steep = abs(turn) + abs(lean)
    off = abs(0.5 * (bent0 + bent1) - turn) + WINDING * abs(lean) * (steep * steep)
    count = 1
    while count < MOST and 2.0 * WANTED * count < corner * steep:
        count += 1
    bulge = way * (abs(turn) + abs(sway) * (1.0 - EVEN / count)) + corner * (2.0 * abs(lean) + steep * steep)
    more = bulge / (8.0 * count * count) + (0.0625 * (off + slip) * way + 0.5 * corner * off)
    poses = [first]
    for j in range(1, count):
        t = j / count
        rest, bump = 1.0 - t, t * (1.0 - t)
        slope = (slope0 * rest + slope1 * t) + lean * bump
        left = bump * (slope0 * rest - slope1 * t)
        ex, ey = dx - slope * dy, dy + slope * dx
        size = math.copysign(math.sqrt(ex * ex + ey * ey), along0)
        poses.append(
            Placed(first.x + (t * dx - left * dy), first.y + (t * dy + left * dx), ex / size, ey / size)
        )
    return Curve((*poses, second), more if more > ROUNDING else 0.0)


def _at_random(first: Placed, second: Placed, way: float, corner: float) -> float:
    """How far beyond the hull of both footprints a vehicle reaches that passes anywhere in the circle around the chord, and points
    anywhere between both headings [m]."""
    gx, gy = second.ahead - first.ahead, second.aside - first.aside
    sx, sy = second.ahead + first.ahead, second.aside + first.aside
    turned = gx * gx + gy * gy
    swing = corner * (turned / (4.0 + 2.0 * math.sqrt(sx * sx + sy * sy)))
    more = swing + (min(way, corner * math.sqrt(turned)) + 0.5 * way)
    return more if more > ROUNDING else 0.0
