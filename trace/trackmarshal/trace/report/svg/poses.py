"""Where everybody is in which cycle, as far as a record says it in finite numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from trackmarshal.trace.report.reading import Run, number
from trackmarshal.trace.report.svg.axis import nice_step
from trackmarshal.trace.report.svg.view import Point

#: Vehicles farther away from the car than this (m) are not shown, so that the picture can be near.
FAR = 120.0
#: At most about so many poses are drawn; longer runs are drawn at a longer spacing than 1 s.
MOST_POSES = 60


@dataclass(frozen=True, slots=True)
class Pose:
    x: float
    y: float
    heading: float
    length: float | None
    width: float | None


def spacing(run: Run) -> float:
    """Seconds between the poses that are drawn."""
    return max(1.0, nice_step(run.end[-1] - run.t[0], MOST_POSES)) if run.cycles else 1.0


def marked_cycles(run: Run) -> list[int]:
    """The cycles nearest to whole multiples of the spacing, from the first cycle on."""
    step, found = spacing(run), []
    wanted = run.t[0] if run.cycles else 0.0
    for i, t in enumerate(run.t):
        if t >= wanted - 1e-6:
            found.append(i)
            wanted = run.t[0] + step * (math.floor((t - run.t[0]) / step + 1e-6) + 1)
    return found


def ego_pose(run: Run, index: int) -> Pose | None:
    """The car's pose in one cycle; None where its position is not finite."""
    ego, vehicle = run.record["ego"], run.record["vehicle"]
    return pose_of(
        ego["x"][index], ego["y"][index], ego["heading"][index], vehicle["length"], vehicle["width"]
    )


def object_poses(run: Run) -> dict[str, dict[int, Pose]]:
    """Poses by object and cycle; those without a finite position are left out."""
    found: dict[str, dict[int, Pose]] = {}
    for entry in run.record["objects"]:
        rows = zip(entry["cycles"], entry["x"], entry["y"], entry["heading"], entry["length"], entry["width"])
        found[entry["id"]] = {int(i): pose for i, *values in rows if (pose := pose_of(*values)) is not None}
    return found


def pose_of(x: Any, y: Any, heading: Any, length: Any, width: Any) -> Pose | None:
    px, py = number(x), number(y)
    if not known(px, py):
        return None
    sizes = [
        value if value is None or (math.isfinite(number(value)) and number(value) > 0) else None
        for value in (length, width)
    ]
    long, wide = (None if size is None else number(size) for size in sizes)
    angle = number(heading)
    return Pose(px, py, angle if math.isfinite(angle) else 0.0, long if math.isfinite(angle) else None, wide)


def near_only(poses: Mapping[int, Pose], egos: Mapping[int, Pose]) -> dict[int, Pose]:
    return {i: pose for i, pose in poses.items() if i not in egos or distance(pose, egos[i]) <= FAR}


def path_of(run: Run, candidate: str, index: int) -> list[Point]:
    path = run.record["candidates"][candidate]["paths"][index]
    if path is None:
        return []
    pairs = ((number(x), number(y)) for x, y in zip(path["x"], path["y"]))
    return [p for p in pairs if known(*p)]


def distance(a: Pose, b: Pose) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)


def around_pose(pose: Pose) -> list[Point]:
    """Points about a vehicle, so that it is in the picture as a whole."""
    room = 0.75 * (pose.length or 4.0)
    return [(pose.x + i * room, pose.y + j * room) for i in (-1, 1) for j in (-1, 1)]


def known(x: float, y: float) -> bool:
    return math.isfinite(x) and math.isfinite(y)
