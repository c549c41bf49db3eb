"""The scene from above (the paper's Fig. 5): track, where everybody is every second, and where a rule first fires."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from trackmarshal.trace.report.reading import CANDIDATES, Run, number
from trackmarshal.trace.report.svg.axis import nice_step
from trackmarshal.trace.report.svg.element import points, svg, tag, text, text_width, thinned, title
from trackmarshal.trace.report.svg.labels import Places, around
from trackmarshal.trace.report.svg.view import FOOT, Frame, Point, View, fit, main_direction
from trackmarshal.trace.report.words import clock, count, interval, plain

#: Vehicles farther away from the car than this (m) are not shown, so that the picture can be near.
FAR = 120.0
#: A path that is so many times as long as broad is cut into strips.
ELONGATED = 5.0
#: At most about so many poses are drawn; longer runs are drawn at a longer spacing than 1 s.
MOST_POSES = 60
FONT = 11.0
#: Footprints that would be shorter than this in pixels are drawn this long, and the picture says so.
SHORTEST = 7.0


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


def scenes(run: Run, frame: Frame) -> list[str]:
    """The whole run: one picture, or, where it is long and straight, several below each other, so that cars can be seen."""
    egos = {i: pose for i in range(run.cycles) if (pose := ego_pose(run, i)) is not None}
    path = [(p.x, p.y) for p in egos.values()]
    turn = main_direction(path)
    along = [math.cos(turn) * x + math.sin(turn) * y for x, y in path]
    across = [math.cos(turn) * y - math.sin(turn) * x for x, y in path]
    length, breadth = max(along) - min(along), max(across) - min(across)
    if length < ELONGATED * max(breadth, 12.0):
        whole = _part(run, range(run.cycles))
        return [_scene(run, whole, fit(whole.shown, frame), True)]
    strips = min(frame.most_strips, math.ceil(length * frame.strip_scale / frame.width))
    low, size = min(along), max(length / strips, 1e-9)
    # By the way covered, each cycle once: a car that turns back does not reopen a strip.
    number, cut = 0, [list[int]() for _ in range(strips)]
    for i, s in zip(egos, along):
        number = max(number, min(strips - 1, int((s - low) / size)))
        cut[number].append(i)
    flat = replace(frame, upright=False)
    parts = [_part(run, range(numbers[0], numbers[-1] + 1)) for numbers in cut if numbers]
    scale = min(fit(part.shown, flat, turn).scale for part in parts)
    views = [fit(part.shown, flat, turn, scale) for part in parts]
    return [_scene(run, part, view, part is parts[-1]) for part, view in zip(parts, views)]


@dataclass(frozen=True, slots=True)
class _Part:
    """Consecutive cycles: the car's poses, and those of the vehicles that are near it."""

    cycles: range
    egos: Mapping[int, Pose]
    near: Mapping[str, Mapping[int, Pose]]

    @property
    def shown(self) -> list[Point]:
        return [(p.x, p.y) for poses in (self.egos, *self.near.values()) for p in poses.values()]


def _part(run: Run, cycles: range) -> _Part:
    egos = {i: pose for i in cycles if (pose := ego_pose(run, i)) is not None}
    near = {name: _near({i: p for i, p in poses.items() if i in cycles}, egos) for name, poses in object_poses(run).items()}
    return _Part(cycles, egos, near)


def _scene(run: Run, part: _Part, view: View, last: bool) -> str:
    """One picture; strips have one scale and one direction, which stand below the last of them."""
    cycles = [i for i in marked_cycles(run) if i in part.cycles]
    egos, near = part.egos, part.near
    places = Places(view.width, view.height)
    times = f"{interval(run.t[part.cycles[0]], run.t[part.cycles[-1]])} {run.time_unit}"
    parts = [*_road(run, view), *_obstacles(run, view)]
    if len(part.cycles) < run.cycles:
        places.block((0.0, 0.0, 12 + text_width(times, 12), 18))
        parts.append(text(8, 14, times, class_="tick"))
    for i in cycles:
        parts += _candidates(run, i, view, "faint")
    parts.append(tag("path", d=points(thinned(view.path((p.x, p.y) for p in egos.values()), 1.0)), class_="trail ego-line"))
    for poses in near.values():
        parts.append(tag("path", d=points(thinned(view.path((p.x, p.y) for p in poses.values()), 1.0)), class_="trail other-line"))
    labels: list[tuple[Point, float, str, str]] = []
    for i in cycles:
        words = clock(run.t[i])
        for name, poses in near.items():
            if i in poses:
                parts += _footprint(poses[i], view, "other", f"{name} at {words} s", places)
                labels.append((view.at(poses[i].x, poses[i].y), poses[i].heading, words, "other-label"))
        if i in egos:
            parts += _footprint(egos[i], view, "ego", f"car under test at {words} s", places)
            labels.append((view.at(egos[i].x, egos[i].y), egos[i].heading, words, "ego-label"))
    parts += _first_firing(run, egos, view, places)
    parts += _names(near, view, places)
    parts += _time_labels(labels, view, places)
    parts.append(tag("g", class_="now"))
    return _picture(view, parts, f"Scene of {run.name}, {times}", _described(run, near), last)


def moment(run: Run, index: int, where: Sequence[Mapping[str, Any]], frame: Frame) -> str | None:
    """One cycle from near: footprints, both candidates, and the points that decided; None where the car's pose is unknown."""
    ego = ego_pose(run, index)
    if ego is None:
        return None
    others = {name: p[index] for name, p in object_poses(run).items() if index in p and _distance(p[index], ego) <= FAR}
    decided = [(b, _finite(b["x"]), _finite(b["y"])) for b in where if b["x"] is not None and b["y"] is not None]
    shown = [(ego.x, ego.y), *((p.x, p.y) for p in others.values()), *((x, y) for _, x, y in decided if _known(x, y))]
    shown += [p for candidate in CANDIDATES for p in path_of(run, candidate, index) if math.dist(p, (ego.x, ego.y)) <= FAR]
    view = fit(shown, frame, ego.heading)
    places = Places(view.width, view.height)
    parts = [*_road(run, view), *_obstacles(run, view), *_candidates(run, index, view, "near")]
    for name, pose in others.items():
        parts += _footprint(pose, view, "other", name, places)
    parts += _footprint(ego, view, "ego", "car under test", places)
    for binder, x, y in decided:
        if _known(x, y):
            px, py = view.at(x, y)
            words = f"{binder['name']}: {binder['value']}" if isinstance(binder["value"], str) else f"{binder['name']}: sample {binder['value']}"
            parts.append(tag("circle", title(words), cx=px, cy=py, r=7.0, class_="deciding"))
            parts += _callout(px, py, words, "callout", places, 10.0)
    for name, pose in others.items():
        parts += _callout(*view.at(pose.x, pose.y), name, "other-label", places, 12.0)
    parts += _callout(*view.at(ego.x, ego.y), "car under test", "ego-label", places, 12.0)
    words = f"The car under test at {clock(run.t[index])} s with {len(others)} vehicles within {FAR:g} m."
    return _picture(view, parts, f"{run.name} at {clock(run.t[index])} s", words)


def ego_pose(run: Run, index: int) -> Pose | None:
    """The car's pose in one cycle; None where its position is not finite."""
    ego, vehicle = run.record["ego"], run.record["vehicle"]
    return _pose(ego["x"][index], ego["y"][index], ego["heading"][index], vehicle["length"], vehicle["width"])


def object_poses(run: Run) -> dict[str, dict[int, Pose]]:
    """Poses by object and cycle; those without a finite position are left out."""
    found: dict[str, dict[int, Pose]] = {}
    for entry in run.record["objects"]:
        rows = zip(entry["cycles"], entry["x"], entry["y"], entry["heading"], entry["length"], entry["width"])
        found[entry["id"]] = {int(i): pose for i, *values in rows if (pose := _pose(*values)) is not None}
    return found


def _pose(x: Any, y: Any, heading: Any, length: Any, width: Any) -> Pose | None:
    px, py = number(x), number(y)
    if not _known(px, py):
        return None
    sizes = [value if value is None or (math.isfinite(number(value)) and number(value) > 0) else None for value in (length, width)]
    long, wide = (None if size is None else number(size) for size in sizes)
    angle = number(heading)
    return Pose(px, py, angle if math.isfinite(angle) else 0.0, long if math.isfinite(angle) else None, wide)


def _near(poses: Mapping[int, Pose], egos: Mapping[int, Pose]) -> dict[int, Pose]:
    return {i: pose for i, pose in poses.items() if i not in egos or _distance(pose, egos[i]) <= FAR}


def _road(run: Run, view: View) -> Iterator[str]:
    """The surface between the borders, and the borders."""
    track = run.record["track"]
    sides = [[(number(x), number(y)) for x, y in track[side]] for side in ("left", "right")]
    lines = [thinned(view.path(p for p in side if _known(*p)), 0.7) for side in sides]
    near = [list(_visible(line + line[:1] if track["closed"] else line, view)) for line in lines]
    if all(len(pieces) == 1 for pieces in near):
        yield tag("path", d=points([*near[0][0], *reversed(near[1][0])], True), class_="road")
    elif all(lines) and track["closed"]:
        yield tag("path", d=points(lines[0], True) + points(lines[1], True), class_="road", fill_rule="evenodd")
    elif all(lines):
        yield tag("path", d=points([*lines[0], *reversed(lines[1])], True), class_="road")
    for pieces, side in zip(near, ("left", "right")):
        if pieces:
            yield tag("path", title(f"{side} border"), d="".join(points(piece) for piece in pieces), class_="border")


def _visible(line: Sequence[Point], view: View) -> Iterator[list[Point]]:
    """The pieces of a line whose segments may be in the picture, or near it: the surface between them must fill its corners."""
    room = max(view.width, view.height)
    piece: list[Point] = []
    for a, b in zip(line, line[1:]):
        apart = max(a[0], b[0]) < -room or min(a[0], b[0]) > view.width + room or max(a[1], b[1]) < -room or min(a[1], b[1]) > view.height + room
        if not apart:
            piece = piece or [a]
            piece.append(b)
        elif piece:
            yield piece
            piece = []
    if piece:
        yield piece


def _obstacles(run: Run, view: View) -> Iterator[str]:
    for entry in run.record["obstacles"]:
        pose = _pose(*(entry[name] for name in ("x", "y", "heading", "length", "width")))
        if pose is not None and pose.length is not None and pose.width is not None:
            corners = view.box(pose.x, pose.y, pose.heading, pose.length, pose.width)
            yield tag("path", title(f"obstacle {entry['id']}"), d=points(corners, True), class_="obstacle")


def _candidates(run: Run, index: int, view: View, style: str) -> Iterator[str]:
    for candidate in CANDIDATES:
        path = view.path(path_of(run, candidate, index))
        if path:
            note = title(f"{candidate} trajectory of {clock(run.t[index])} s")
            yield tag("path", note, d=points(thinned(path, 1.0)), class_=f"plan {candidate} {style}")


def path_of(run: Run, candidate: str, index: int) -> list[Point]:
    path = run.record["candidates"][candidate]["paths"][index]
    if path is None:
        return []
    pairs = ((number(x), number(y)) for x, y in zip(path["x"], path["y"]))
    return [p for p in pairs if _known(*p)]


def _footprint(pose: Pose, view: View, style: str, note: str, places: Places) -> Iterator[str]:
    """A rectangle with its front marked; a dot where the size is unknown."""
    px, py = view.at(pose.x, pose.y)
    if pose.length is None or pose.width is None:
        yield tag("circle", title(note), cx=px, cy=py, r=3.5, class_=f"foot {style}")
        places.block((px - 4, py - 4, px + 4, py + 4))
        return
    grow = max(1.0, SHORTEST / (pose.length * view.scale))
    corners = view.box(pose.x, pose.y, pose.heading, pose.length * grow, pose.width * grow)
    yield tag("path", title(note), d=points(corners, True), class_=f"foot {style}")
    yield tag("path", d=points(corners[:2]), class_=f"nose {style}")
    xs, ys = [x for x, _ in corners], [y for _, y in corners]
    places.block((min(xs) - 2, min(ys) - 2, max(xs) + 2, max(ys) + 2))


def _first_firing(run: Run, egos: Mapping[int, Pose], view: View, places: Places) -> Iterator[str]:
    found = run.first_firing()
    if found is None or (index := found[2]["cycles"][0]) not in egos:
        return
    px, py = view.at(egos[index].x, egos[index].y)
    others = len({r.name for r in run.rules for lane in r.lanes.values() for f in lane.firings if f["cycles"][0] == index}) - 1
    words = f"{clock(run.t[index])} {run.time_unit}: {found[0].name}" + (f" and {count(others, 'other')}" if others else "")
    yield tag("circle", title(f"{words} ({found[1]})"), cx=px, cy=py, r=9.0, class_="firing-ring")
    places.block((px - 9, py - 9, px + 9, py + 9))
    yield from _callout(px, py, words, "callout", places, 9.0)


def _callout(px: float, py: float, words: str, style: str, places: Places, reach: float) -> Iterator[str]:
    """Words near a point, with a line to it where they had to go far."""
    width, height = text_width(words, FONT + 1) + 8, FONT + 5
    gaps, angles = [reach + g for g in (3, 14, 30, 50, 80)], [i * math.pi / 8 for i in (-4, 4, -2, 2, -6, 6, 0, 8, -1, 1, -3, 3)]
    box = places.claim(around(px, py, width, height, gaps, angles))
    if box is None:
        return
    cx, cy = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    ex, ey = min(max(px, box[0]), box[2]), min(max(py, box[1]), box[3])
    far = math.hypot(ex - px, ey - py)
    if far > reach + 8:
        share = reach / far
        yield tag("line", x1=px + (ex - px) * share, y1=py + (ey - py) * share, x2=ex, y2=ey, class_="leader")
    yield text(cx, cy + 4, words, class_=f"{style} middle")


def _names(near: Mapping[str, Mapping[int, Pose]], view: View, places: Places) -> Iterator[str]:
    """Names of other vehicles, where each is last seen."""
    for name, poses in near.items():
        if poses:
            pose = poses[max(poses)]
            yield from _callout(*view.at(pose.x, pose.y), name[:24], "other-label", places, 6.0)


def _time_labels(labels: Iterable[tuple[Point, float, str, str]], view: View, places: Places) -> Iterator[str]:
    """Seconds beside footprints; one that finds no free place is left out, its neighbours tell."""
    for (px, py), heading, words, style in labels:
        width, height = text_width(words, FONT) + 2, FONT - 1
        ahead = math.atan2(view.b * math.cos(heading) + view.d * math.sin(heading), view.a * math.cos(heading) + view.c * math.sin(heading))
        side = math.pi / 2 if style == "ego-label" else -math.pi / 2
        angles = [ahead + side, ahead - side, ahead + side * 0.6, ahead + side * 1.4]
        box = places.claim(around(px, py, width, height, (6.0, 11.0, 17.0), angles))
        if box is not None:
            yield text((box[0] + box[2]) / 2, box[3] - 0.5, words, class_=f"{style} small middle")


def _picture(view: View, parts: Sequence[str], name: str, description: str, foot_strip: bool = True) -> str:
    """The parts, and below them the scale and the directions of x and y."""
    matrix = " ".join(f"{value:.6g}" for value in (view.a, view.b, view.c, view.d, view.e, view.f))
    if not foot_strip:
        return svg(view.width, view.height, name, description, parts, class_="scene", data_matrix=matrix)
    metres, pixels = view.scale_bar()
    y = view.height + FOOT - 10
    foot = [
        tag("rect", x=0.0, y=view.height, width=view.width, height=FOOT, class_="foot-strip"),
        tag("path", d=f"M12 {y - 4}v4h{pixels:.2f}v-4", class_="scale"),
        text(18 + pixels, y, f"{plain(metres)} m", class_="tick"),
    ]
    cx, cy = view.width - 34, view.height + FOOT / 2 + 2
    for axis, (dx, dy) in (("x", (view.a, view.b)), ("y", (view.c, view.d))):
        ux, uy = dx / view.scale, dy / view.scale
        foot.append(tag("line", x1=cx, y1=cy, x2=cx + 8 * ux, y2=cy + 8 * uy, class_="scale"))
        foot.append(text(cx + 15 * ux, cy + 12 * uy + 3.5, axis, class_="tick middle"))
    return svg(view.width, view.height + FOOT, name, description, [*parts, *foot], class_="scene", data_matrix=matrix)


def _described(run: Run, near: Mapping[str, Mapping[int, Pose]]) -> str:
    seen = [name for name, poses in near.items() if poses]
    found = run.first_firing()
    first = "" if found is None else f" {found[0].name} fires first, on the {found[1]} trajectory, at {clock(number(found[2]['from']))} s."
    others = f"{len(seen)} other vehicles" if len(seen) != 1 else f"one other vehicle ({seen[0]})"
    return f"The car under test and {others} every {plain(spacing(run))} s.{first} The table below has the positions."


def _distance(a: Pose, b: Pose) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)


def _finite(value: object) -> float:
    return number(value)


def _known(x: float, y: float) -> bool:
    return math.isfinite(x) and math.isfinite(y)
