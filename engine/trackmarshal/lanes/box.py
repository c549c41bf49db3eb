"""Boxes of vehicles, and what they touch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def corners(centre: Array, heading: Array, size: Array) -> Array:
    """(n, 4, 2): the corners of n boxes with a centre (n, 2), a heading (n,) and a length and a width (n, 2); front left, then clockwise."""
    cos, sin = np.cos(heading), np.sin(heading)
    along, beside = np.stack([cos, sin], axis=1), np.stack([-sin, cos], axis=1)
    signs = np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]) / 2.0
    reach = signs[None] * size[:, None]
    found: Array = centre[:, None] + reach[..., :1] * along[:, None] + reach[..., 1:] * beside[:, None]
    return found


def touches(centre: Array, heading: float, size: Array, outline: Array) -> bool:
    """Whether a box and the area inside a closed outline, (points, 2), have a point in common; their edges belong to them."""
    half, cos, sin = size / 2.0, np.cos(heading), np.sin(heading)
    turned = (outline - centre) @ np.array([[cos, -sin], [sin, cos]])
    if bool((turned.min(axis=0) > half).any() or (turned.max(axis=0) < -half).any()):
        return False
    following = np.roll(turned, -1, axis=0)
    return _meets(turned, following, half) or _surrounds(turned, following)


def _meets(start: Array, end: Array, half: Array) -> bool:
    """Whether a straight piece meets the box from -half to half: what is left of it between both pairs of sides is not nothing."""
    step = end - start
    still = step == 0.0
    safe = np.where(still, 1.0, step)
    first, second = (-half - start) / safe, (half - start) / safe
    inside = np.abs(start) <= half
    enters = np.where(still, np.where(inside, -np.inf, np.inf), np.minimum(first, second))
    leaves = np.where(still, np.where(inside, np.inf, -np.inf), np.maximum(first, second))
    return bool((np.maximum(enters.max(axis=1), 0.0) <= np.minimum(leaves.min(axis=1), 1.0)).any())


def _surrounds(start: Array, end: Array) -> bool:
    """Whether the origin is inside an outline that does not come near it: an odd number of pieces crosses the half line to its right."""
    over = (start[:, 1] > 0.0) != (end[:, 1] > 0.0)
    rise = np.where(over, end[:, 1] - start[:, 1], 1.0)
    crossing = start[:, 0] - start[:, 1] * (end[:, 0] - start[:, 0]) / rise
    return bool(np.count_nonzero(over & (crossing > 0.0)) % 2)
