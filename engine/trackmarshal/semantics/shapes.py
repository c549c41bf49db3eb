"""Record shapes that definitions ask for by name: which fields, of which dimensions."""

from __future__ import annotations

from trackmarshal.units import LENGTH, NUMBER, SPEED, Dimension

_POINT: dict[str, Dimension | None] = {"x": LENGTH, "y": LENGTH}
_POSE: dict[str, Dimension | None] = {**_POINT, "heading": NUMBER}

#: A record fits a shape when it has these fields; other fields of it cannot be read through the shape.
SHAPES: dict[str, dict[str, Dimension | None]] = {
    "point": _POINT,
    "pose": _POSE,
    "moving": {**_POSE, "v": SPEED},
    "body": {**_POSE, "length": LENGTH, "width": LENGTH},
    "vehicle": {**_POSE, "v": SPEED, "length": LENGTH, "width": LENGTH},
}
