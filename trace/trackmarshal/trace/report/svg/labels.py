"""Labels that stay out of each other's way."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

Box = tuple[float, float, float, float]


@dataclass(slots=True)
class Places:
    """What is taken on a picture of some size; `claim` takes the first free place out of several."""

    width: float
    height: float
    taken: list[Box] = field(default_factory=list)

    def block(self, box: Box) -> None:
        self.taken.append(box)

    def free(self, box: Box) -> bool:
        x0, y0, x1, y1 = box
        if x0 < 0 or y0 < 0 or x1 > self.width or y1 > self.height:
            return False
        return not any(x0 < b[2] and b[0] < x1 and y0 < b[3] and b[1] < y1 for b in self.taken)

    def claim(self, boxes: Iterable[Box]) -> Box | None:
        for box in boxes:
            if self.free(box):
                self.taken.append(box)
                return box
        return None


def around(
    x: float, y: float, width: float, height: float, gaps: Iterable[float], angles: Iterable[float]
) -> Iterable[Box]:
    """Boxes about a point at several distances and directions (rad, 0 to the right, clockwise on the screen)."""
    from math import cos, sin

    directions = list(angles)
    for gap in gaps:
        for angle in directions:
            # The box's centre is moved until the box as a whole is `gap` away.
            cx = x + cos(angle) * (gap + width / 2)
            cy = y + sin(angle) * (gap + height / 2)
            yield cx - width / 2, cy - height / 2, cx + width / 2, cy + height / 2
