"""The scene from above (the paper's Fig. 5): track, where everybody is every second, and where a rule first fires."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from trackmarshal.trace.report.reading import CANDIDATES, Run, number
from trackmarshal.trace.report.svg import scenery
from trackmarshal.trace.report.svg.element import points, tag, text, text_width, thinned, title
from trackmarshal.trace.report.svg.labels import Places
from trackmarshal.trace.report.svg.poses import (
    FAR,
    Pose,
    around_pose,
    distance,
    ego_pose,
    known,
    marked_cycles,
    near_only,
    object_poses,
    path_of,
    spacing,
)
from trackmarshal.trace.report.svg.view import Frame, Point, View, fit, main_direction
from trackmarshal.trace.report.words import clock, count, interval, plain

#: A path that is so many times as long as broad is cut into strips.
ELONGATED = 7.0
#: Pixels between two numbers.
NEAREST = 24.0
#: At most so many first firings of rules are marked, the earliest ones.
MOST_MARKS = 6


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
        return [
            point
            for poses in (self.egos, *self.near.values())
            for pose in poses.values()
            for point in around_pose(pose)
        ]


def _part(run: Run, cycles: range) -> _Part:
    egos = {i: pose for i in cycles if (pose := ego_pose(run, i)) is not None}
    near = {
        name: near_only({i: p for i, p in poses.items() if i in cycles}, egos)
        for name, poses in object_poses(run).items()
    }
    return _Part(cycles, egos, near)


def _scene(run: Run, part: _Part, view: View, last: bool) -> str:
    """One picture; strips have one scale and one direction, which stand below the last of them."""
    cycles = [i for i in marked_cycles(run) if i in part.cycles]
    egos, near = part.egos, part.near
    places = Places(view.width, view.height)
    times = f"{interval(run.t[part.cycles[0]], run.t[part.cycles[-1]])} {run.time_unit}"
    parts = [*scenery.road(run, view), *scenery.places_of_rules(run, view), *scenery.obstacles(run, view)]
    if len(part.cycles) < run.cycles:
        places.block((0.0, 0.0, 12 + text_width(times, 12), 18))
        parts.append(text(8, 14, times, class_="tick"))
    for i in cycles:
        parts += scenery.candidates(run, i, view, "faint")
    parts.append(
        tag(
            "path",
            d=points(thinned(view.path((p.x, p.y) for p in egos.values()), 1.0)),
            class_="trail ego-line",
        )
    )
    for poses in near.values():
        parts.append(
            tag(
                "path",
                d=points(thinned(view.path((p.x, p.y) for p in poses.values()), 1.0)),
                class_="trail other-line",
            )
        )
    labels: list[tuple[Point, float, str, str]] = []
    labelled = _apart([egos[i] for i in cycles if i in egos], [i for i in cycles if i in egos], view)
    for i in cycles:
        words = clock(run.t[i])
        ego = egos.get(i)
        at = None if ego is None else view.at(ego.x, ego.y)
        for name, poses in near.items():
            if i in poses:
                parts += scenery.footprint(poses[i], view, "other", f"{name} at {words} s", places)
                place = view.at(poses[i].x, poses[i].y)
                # Beside the car's own number the same number again says nothing.
                if at is None or (i in labelled and math.dist(place, at) > 0.6 * NEAREST):
                    labels.append((place, poses[i].heading, words, "other-label"))
        if ego is not None and at is not None:
            parts += scenery.footprint(ego, view, "ego", f"car under test at {words} s", places)
            if i in labelled:
                labels.append((at, ego.heading, words, "ego-label"))
    parts += _beginnings(run, egos, view, places)
    parts += _names(near, view, places)
    parts += scenery.time_labels(labels, view, places)
    parts += scenery.place_names(run, view, places)
    parts.append(tag("g", class_="now"))
    return scenery.picture(view, parts, f"Scene of {run.name}, {times}", _described(run, near), last)


def _apart(poses: Sequence[Pose], cycles: Sequence[int], view: View) -> set[int]:
    """Cycles whose numbers are written: evenly many, so that mostly NEAREST pixels are between two of them."""
    places = [view.at(pose.x, pose.y) for pose in poses]
    way = sum(math.dist(a, b) for a, b in pairwise(places))
    usual = way / max(1, len(places) - 1)
    every = next((n for n in (1, 2, 5, 10, 20) if n * usual >= NEAREST), 50)
    return set(cycles[::every])


def moment(run: Run, index: int, where: Sequence[Mapping[str, Any]], frame: Frame) -> str | None:
    """One cycle from near: footprints, both candidates, and the points that decided; None where the car's pose is unknown."""
    ego = ego_pose(run, index)
    if ego is None:
        return None
    others = {
        name: p[index]
        for name, p in object_poses(run).items()
        if index in p and distance(p[index], ego) <= FAR
    }
    decided = [
        (b, number(b["x"]), number(b["y"])) for b in where if b["x"] is not None and b["y"] is not None
    ]
    shown = [corner for pose in (ego, *others.values()) for corner in around_pose(pose)]
    shown += [(x, y) for _, x, y in decided if known(x, y)]
    shown += [
        p
        for candidate in CANDIDATES
        for p in path_of(run, candidate, index)
        if math.dist(p, (ego.x, ego.y)) <= FAR
    ]
    view = fit(shown, frame, ego.heading)
    places = Places(view.width, view.height)
    parts = [
        *scenery.road(run, view),
        *scenery.places_of_rules(run, view),
        *scenery.obstacles(run, view),
        *scenery.candidates(run, index, view, "near"),
    ]
    for name, pose in others.items():
        parts += scenery.footprint(pose, view, "other", name, places)
    parts += scenery.footprint(ego, view, "ego", "car under test", places)
    for binder, x, y in decided:
        if known(x, y):
            px, py = view.at(x, y)
            words = (
                f"{binder['name']}: {binder['value']}"
                if isinstance(binder["value"], str)
                else f"{binder['name']}: sample {binder['value']}"
            )
            parts.append(tag("circle", title(words), cx=px, cy=py, r=7.0, class_="deciding"))
            parts += scenery.callout(px, py, words, "callout", places, 10.0)
    for name, pose in others.items():
        parts += scenery.callout(*view.at(pose.x, pose.y), name, "other-label", places, 12.0)
    parts += scenery.callout(*view.at(ego.x, ego.y), "car under test", "ego-label", places, 12.0)
    parts += scenery.place_names(run, view, places)
    words = f"The car under test at {clock(run.t[index])} s with {len(others)} vehicles within {FAR:g} m."
    return scenery.picture(view, parts, f"{run.name} at {clock(run.t[index])} s", words)


def _beginnings(run: Run, egos: Mapping[int, Pose], view: View, places: Places) -> Iterator[str]:
    """Rings where a rule fires for the first time, with what it is."""
    marked = [(i, found) for i, found in list(run.beginnings().items())[:MOST_MARKS] if i in egos]
    for i, _ in marked:
        px, py = view.at(egos[i].x, egos[i].y)
        places.block((px - 9, py - 9, px + 9, py + 9))
    for i, found in marked:
        px, py = view.at(egos[i].x, egos[i].y)
        names = list(dict.fromkeys(rule.name for rule, _, _ in found))
        words = f"{clock(run.t[i])} {run.time_unit}: {names[0]}" + (
            f" and {count(len(names) - 1, 'other')}" if len(names) > 1 else ""
        )
        yield tag(
            "circle",
            title(f"{clock(run.t[i])} {run.time_unit}: {', '.join(names)} fires"),
            cx=px,
            cy=py,
            r=9.0,
            class_="firing-ring",
        )
        yield from scenery.callout(px, py, words, "callout", places, 9.0)


def _names(near: Mapping[str, Mapping[int, Pose]], view: View, places: Places) -> Iterator[str]:
    """Names of other vehicles, where each is last seen."""
    for name, poses in near.items():
        if poses:
            pose = poses[max(poses)]
            yield from scenery.callout(*view.at(pose.x, pose.y), name[:24], "other-label", places, 6.0)


def _described(run: Run, near: Mapping[str, Mapping[int, Pose]]) -> str:
    seen = [name for name, poses in near.items() if poses]
    found = run.first_firing()
    first = (
        ""
        if found is None
        else f" {found[0].name} fires first, on the {found[1]} trajectory, at {clock(number(found[2]['from']))} s."
    )
    others = f"{len(seen)} other vehicles" if len(seen) != 1 else f"one other vehicle ({seen[0]})"
    return f"The car under test and {others} every {plain(spacing(run))} s.{first} The table below has the positions."
