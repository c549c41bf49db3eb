"""A lanelet: a stretch of road between two bounds, as maps have them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.door.lines import LineReader, NoLineError
from trackmarshal.runtime.door.values import is_array

if TYPE_CHECKING:
    from numpy.typing import NDArray

Points = Sequence[Sequence[float]]
#: Numbers of lanelets and vehicles are compared as doubles: up to here each whole number is one.
MOST = 2**53


@dataclass(frozen=True, slots=True)
class Lanelet:
    """A lanelet, in m and m/s.

    left, right: its bounds, as many points [x, y] of each, in the direction of travel. successors: numbers of lanelets that it leads to.
    beside_left, beside_right: the number of the neighbour there, or None; along_left, along_right: whether that leads the same way. main: of the main
    carriageway; ramp: of an access ramp; shoulder: a hard shoulder. limit: the speed limit, or None.
    """

    number: int
    left: Points
    right: Points
    successors: tuple[int, ...] = ()
    beside_left: int | None = None
    beside_right: int | None = None
    along_left: bool = True
    along_right: bool = True
    main: bool = False
    ramp: bool = False
    shoulder: bool = False
    limit: float | None = None


def bounds(lanelet: Lanelet, where: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Its left and its right bound, (points, 2) each; raises TrackmarshalError D185."""
    name = lanelet.number
    if isinstance(name, bool) or not isinstance(name, int) or not 0 <= name < MOST:
        raise _none(f"`{name!s:.40}` is no number of a lanelet", where, "numbers are whole, from 0 on")
    left, right = (_bound(lanelet, side, where) for side in ("left", "right"))
    if len(left) != len(right):
        raise _none(
            f"lanelet {name}: {len(left)} points on the left, {len(right)} on the right",
            where,
            "points of both bounds stand in pairs",
        )
    if lanelet.limit is not None and not (math.isfinite(lanelet.limit) and lanelet.limit > 0.0):
        raise _none(f"lanelet {name}: a limit of {lanelet.limit} m/s", where, "None stands for no limit")
    along = np.einsum("ij,ij->i", np.diff(left, axis=0), np.diff(right, axis=0))
    if float(np.dot(left[-1] - left[0], right[-1] - right[0])) < 0.0 or bool((along < 0.0).any()):
        k = int(np.argmin(along))
        raise _none(
            f"lanelet {name}: the bounds lead opposite ways, after point {k}",
            where,
            "both go in the direction of travel: turn one round",
        )
    crossing = _crossing(left, right)
    if crossing is not None:
        raise _none(
            f"lanelet {name}: the bounds cross, the left one after point {crossing[0]}, the right one after point {crossing[1]}",
            where,
            "bounds may touch, where a lane begins or ends; they do not cross",
        )
    middle, across = np.diff((left + right) / 2, axis=0), left - right
    if bool((np.hypot(middle[:, 0], middle[:, 1]) == 0.0).any()):
        raise _none(f"lanelet {name}: two pairs of points with one middle", where, "leave one of them out")
    at_begin = middle[:, 0] * across[:-1, 1] - middle[:, 1] * across[:-1, 0]
    at_end = middle[:, 0] * across[1:, 1] - middle[:, 1] * across[1:, 0]
    if bool((at_begin < 0.0).any() or (at_end < 0.0).any()) or not bool(
        (at_begin > 0.0).any() or (at_end > 0.0).any()
    ):
        raise _none(
            f"lanelet {name}: the left bound is not on the left",
            where,
            "left and right are seen in the direction of travel: swap the bounds, or turn both round",
        )
    return left, right


def _bound(lanelet: Lanelet, side: str, where: str) -> NDArray[np.float64]:
    given: Any = getattr(lanelet, side)
    try:
        # As the door reads borders: texts are no numbers, and what short floats have rounded is no bound.
        points = LineReader().read(given if is_array(given) else list(given)).points
    except (TypeError, NoLineError) as error:
        why = f": {error.message}" if isinstance(error, NoLineError) else ""
        raise _none(
            f"lanelet {lanelet.number}: the {side} bound is no list of points{why}",
            where,
            "points are [x, y], in m",
        ) from error
    if len(points) < 2:
        raise _none(
            f"lanelet {lanelet.number}: the {side} bound has {len(points)} points", where, "two at least"
        )
    if not bool(np.isfinite(points).all()):
        k = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise _none(
            f"lanelet {lanelet.number}: point {k} of the {side} bound is not finite",
            where,
            "points are [x, y], in m",
        )
    return points


def _crossing(left: NDArray[np.float64], right: NDArray[np.float64]) -> tuple[int, int] | None:
    """The first piece of the left bound that passes from one side of a piece of the right bound to the other, and back: both properly."""
    p, q, r, s = left[:-1, None], left[1:, None], right[None, :-1], right[None, 1:]
    over = (_turn(p, q, r) * _turn(p, q, s) < 0.0) & (_turn(r, s, p) * _turn(r, s, q) < 0.0)
    found = np.argwhere(over)
    return (int(found[0][0]), int(found[0][1])) if len(found) else None


def _turn(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """Twice the signed area of triangles: positive where c lies left of the way from a to b."""
    found: NDArray[np.float64] = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (
        b[..., 1] - a[..., 1]
    ) * (c[..., 0] - a[..., 0])
    return found


def _none(message: str, where: str, way_out: str) -> TrackmarshalError:
    return TrackmarshalError("D185", message, file=where or None, help=way_out)
