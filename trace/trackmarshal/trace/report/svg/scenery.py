"""What a scene is made of: road, obstacles, trajectories, footprints, and words that keep apart."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence

from trackmarshal.trace.report.reading import CANDIDATES, Run, number
from trackmarshal.trace.report.svg.element import points, svg, tag, text, text_width, thinned, title
from trackmarshal.trace.report.svg.labels import Places, around
from trackmarshal.trace.report.svg.poses import Pose, path_of, pose_of
from trackmarshal.trace.report.svg.view import FOOT, Point, View
from trackmarshal.trace.report.words import clock, plain

FONT = 11.0
#: Footprints that would be shorter than this in pixels are drawn this long, and the picture says so.
SHORTEST = 7.0


def road(run: Run, view: View) -> Iterator[str]:
    """The surface between the borders, and the borders."""
    closed = run.record["track"]["closed"]
    lines = [thinned(view.path(run.track[side]), 0.7) for side in ("left", "right")]
    near = [list(_visible(line + line[:1] if closed else line, view)) for line in lines]
    if all(len(pieces) == 1 for pieces in near):
        yield tag("path", d=points([*near[0][0], *reversed(near[1][0])], True), class_="road")
    elif all(lines) and closed:
        yield tag(
            "path", d=points(lines[0], True) + points(lines[1], True), class_="road", fill_rule="evenodd"
        )
    elif all(lines):
        yield tag("path", d=points([*lines[0], *reversed(lines[1])], True), class_="road")
    for pieces, side in zip(near, ("left", "right")):
        if pieces:
            yield tag(
                "path", title(f"{side} border"), d="".join(points(piece) for piece in pieces), class_="border"
            )


def _visible(line: Sequence[Point], view: View) -> Iterator[list[Point]]:
    """The pieces of a line whose segments may be in the picture, or near it: the surface between them must fill its corners."""
    room = max(view.width, view.height)
    least, right, low = -room, view.width + room, view.height + room
    piece: list[Point] = []
    for a, b in itertools.pairwise(line):
        (ax, ay), (bx, by) = a, b
        apart = ax < least > bx or ax > right < bx or ay < least > by or ay > low < by
        if not apart:
            piece = piece or [a]
            piece.append(b)
        elif piece:
            yield piece
            piece = []
    if piece:
        yield piece


def obstacles(run: Run, view: View) -> Iterator[str]:
    for entry in run.record["obstacles"]:
        pose = pose_of(*(entry[name] for name in ("x", "y", "heading", "length", "width")))
        if pose is not None and pose.length is not None and pose.width is not None:
            corners = view.box(pose.x, pose.y, pose.heading, pose.length, pose.width)
            yield tag("path", title(f"obstacle {entry['id']}"), d=points(corners, True), class_="obstacle")


def places_of_rules(run: Run, view: View) -> Iterator[str]:
    """The zones and lines that the rules speak of, below everything else that is on the road."""
    for entry in run.record.get("places", ()):  # records of older versions have none
        line = view.path((number(x), number(y)) for x, y in entry["points"])
        kind = entry["kind"]
        yield tag(
            "path", title(f"{kind} {entry['name']}"), d=points(line, kind == "zone"), class_=f"place {kind}"
        )


def place_names(run: Run, view: View, places: Places) -> Iterator[str]:
    """Names of zones and lines beside the part of their outline that is in the picture."""
    for entry in run.record.get("places", ()):
        line = view.path((number(x), number(y)) for x, y in entry["points"])
        closing = line[:1] if entry["kind"] == "zone" else []
        seen = [
            p for p in _stepped([*line, *closing]) if 0.0 < p[0] < view.width and 0.0 < p[1] < view.height
        ]
        if seen:
            yield from callout(*seen[len(seen) // 2], entry["name"], "place-label", places, 3.0)


def _stepped(line: Sequence[Point]) -> Iterator[Point]:
    """Points along a line, at most 20 pixels apart."""
    for (ax, ay), (bx, by) in itertools.pairwise(line):
        steps = max(1, math.ceil(min(math.dist((ax, ay), (bx, by)), 1e5) / 20.0))
        for i in range(steps + 1):
            yield ax + (bx - ax) * i / steps, ay + (by - ay) * i / steps


def candidates(run: Run, index: int, view: View, style: str) -> Iterator[str]:
    for candidate in CANDIDATES:
        path = view.path(path_of(run, candidate, index))
        if path:
            note = title(f"{candidate} trajectory of {clock(run.t[index])} s")
            yield tag("path", note, d=points(thinned(path, 1.0)), class_=f"plan {candidate} {style}")


def footprint(pose: Pose, view: View, style: str, note: str, places: Places) -> Iterator[str]:
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


def callout(px: float, py: float, words: str, style: str, places: Places, reach: float) -> Iterator[str]:
    """Words near a point, with a line to it where they had to go far."""
    width, height = text_width(words, FONT + 1) + 8, FONT + 5
    gaps, angles = (
        [reach + g for g in (3, 14, 30, 50, 80)],
        [i * math.pi / 8 for i in (-4, 4, -2, 2, -6, 6, 0, 8, -1, 1, -3, 3)],
    )
    box = places.claim(around(px, py, width, height, gaps, angles))
    if box is None:
        return
    cx, cy = (box[0] + box[2]) / 2, (box[1] + box[3]) / 2
    ex, ey = min(max(px, box[0]), box[2]), min(max(py, box[1]), box[3])
    far = math.hypot(ex - px, ey - py)
    if far > reach + 8:
        share = reach / far
        leader = "leader red" if style == "callout" else "leader"
        yield tag("line", x1=px + (ex - px) * share, y1=py + (ey - py) * share, x2=ex, y2=ey, class_=leader)
    yield text(cx, cy + 4, words, class_=f"{style} middle")


def time_labels(labels: Iterable[tuple[Point, float, str, str]], view: View, places: Places) -> Iterator[str]:
    """Seconds beside footprints; one that finds no free place is left out, its neighbours tell."""
    for (px, py), heading, words, style in labels:
        width, height = text_width(words, FONT) + 2, FONT - 1
        ahead = math.atan2(
            view.b * math.cos(heading) + view.d * math.sin(heading),
            view.a * math.cos(heading) + view.c * math.sin(heading),
        )
        side = math.pi / 2 if style == "ego-label" else -math.pi / 2
        angles = [ahead + side * turn for turn in (1.0, -1.0, 0.7, 1.3, -0.7, -1.3)]
        box = places.claim(around(px, py, width, height, (6.0, 10.0, 14.0, 19.0, 24.0), angles))
        if box is not None:
            yield text((box[0] + box[2]) / 2, box[3] - 0.5, words, class_=f"{style} small middle")


def picture(view: View, parts: Sequence[str], name: str, description: str, foot_strip: bool = True) -> str:
    """The parts, and below them the scale and the directions of x and y."""
    # In full: of coordinates far from the origin, as those of a survey, the products all but cancel out.
    matrix = " ".join(f"{value:.17g}" for value in (view.a, view.b, view.c, view.d, view.e, view.f))
    if not foot_strip:
        return svg(view.width, view.height, name, description, parts, class_="scene", data_matrix=matrix)
    metres, pixels = view.scale_bar()
    y = view.height + FOOT - 10
    foot = [
        tag("rect", x=0.0, y=view.height, width=view.width, height=FOOT + 2, class_="foot-strip"),
        tag("path", d=f"M12 {y - 4}v4h{pixels:.2f}v-4", class_="scale"),
        text(18 + pixels, y, f"{plain(metres)} m", class_="tick"),
    ]
    cx, cy = view.width - 34, view.height + FOOT / 2 + 2
    for axis, (dx, dy) in (("x", (view.a, view.b)), ("y", (view.c, view.d))):
        ux, uy = dx / view.scale, dy / view.scale
        foot.append(tag("line", x1=cx, y1=cy, x2=cx + 8 * ux, y2=cy + 8 * uy, class_="scale"))
        foot.append(text(cx + 15 * ux, cy + 12 * uy + 3.5, axis, class_="tick middle"))
    return svg(
        view.width, view.height + FOOT, name, description, [*parts, *foot], class_="scene", data_matrix=matrix
    )
