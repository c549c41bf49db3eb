"""Whether borders lie on the sides that they are called after: where they do not, they are exchanged, or the frame is mirrored."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: Of fewer poses nothing is said, and of exchanged borders where nine of ten show it.
FEWEST, MOST = 5, 0.9


def exchanged(x: Floats, y: Floats, heading: Floats, left: Floats, right: Floats) -> tuple[int, int]:
    """How many poses have the left border on their right and the right one on their left, and how many were looked at.

    x, y: m, heading: rad, (n,); left, right: (points, 2), m. Looked at are those that point where the left border leads: against it,
    somebody drives the wrong way, which is for a rule to say, and has the left border on his right.
    """
    wrong = looked = 0
    for here, angle in zip(np.column_stack([x, y]), heading):
        ahead = np.array([np.cos(angle), np.sin(angle)])
        offsets = []
        for border in (left, right):
            away = border - here
            offsets.append(away[int(np.argmin(np.hypot(away[:, 0], away[:, 1])))])
        place = int(np.argmin(np.hypot(*(left - here).T)))
        along = left[min(place + 1, len(left) - 1)] - left[max(place - 1, 0)]
        if not along @ ahead > 0.0:
            continue
        looked += 1
        to_left, to_right = (ahead[0] * off[1] - ahead[1] * off[0] for off in offsets)
        wrong += bool(to_left < 0.0 < to_right)
    return wrong, looked


def are_exchanged(wrong: int, looked: int) -> bool:
    return looked >= FEWEST and wrong >= MOST * looked
