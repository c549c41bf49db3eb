"""The other cars: who touches the car now, whom a candidate will meet where they really will be, and the gaps of RSS along the road."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from support.dense import curve, rss
from support.dense.car import Car
from support.dense.recording import Columns, Cycle, Floats, Recording
from support.dense.sweep import corners

Body = Mapping[str, Any]


def box(body: Body, length: float, width: float) -> shapely.Polygon:
    """A car's rectangle."""
    x, y, heading = (np.array([body[name]], dtype=np.float64) for name in ("x", "y", "heading"))
    return shapely.Polygon(corners(x, y, heading, length, width)[0])


def touching(cycle: Cycle, car: Car) -> list[str]:
    """Who touches or overlaps the car now."""
    own = box(cycle.ego, car.length, car.width)
    return [o["id"] for o in cycle.objects if own.intersects(box(o, o["length"], o["width"]))]


def meets(recording: Recording, cycle: Cycle, columns: Columns, car: Car) -> float | None:
    """When, in s from the cycle on, a candidate first touches another car where that one really was then; None for never.

    Looked at every 0.05 s until the candidate or the recording ends; positions of others are linear between cycles. The candidate begins
    where the car is: the columns' own time at the place of its path that is nearest to the car.
    """
    due = columns["t"] - at_car(cycle, columns)
    last = min(float(due[-1]), recording.cycles[-1].t - cycle.t)
    times = np.arange(0.0, last, 0.05)
    if not cycle.objects or not len(times):
        return None
    x, y = np.interp(times, due, columns["x"]), np.interp(times, due, columns["y"])
    heading = np.interp(times, due, np.unwrap(columns["heading"]))
    own = shapely.polygons(corners(x, y, heading, car.length, car.width))
    first: float | None = None
    for body in cycle.objects:
        there = _seen(recording, cycle.index, body["id"], cycle.t + times)
        count = len(there[0])
        hit = shapely.intersects(
            own[:count], shapely.polygons(corners(*there, body["length"], body["width"]))
        )
        if hit.any() and (first is None or times[hit.argmax()] < first):
            first = float(times[hit.argmax()])
    return first


def at_car(cycle: Cycle, columns: Columns) -> float:
    """The columns' time at the place of the path that is nearest to the car."""
    if curve.chords(columns).max() <= curve.SAME:
        return float(columns["t"][0])
    line = shapely.LineString(np.stack([columns["x"], columns["y"]], axis=-1))
    way = line.project(shapely.Point(cycle.ego["x"], cycle.ego["y"]))
    along = np.concatenate([[0.0], np.cumsum(curve.chords(columns))])
    i = int(np.clip(np.searchsorted(along, way, side="right") - 1, 0, len(along) - 2))
    step, v, w = along[i + 1] - along[i], columns["v"][i], columns["v"][i + 1]
    share = (way - along[i]) / step if step > 0.0 else 0.0
    # Constant acceleration over the step: the mean speed from its beginning to the place.
    here = np.sqrt(max(0.0, v * v + share * (w * w - v * v)))
    mean, whole = (v + here) / 2.0, (v + w) / 2.0
    lasts = columns["t"][i + 1] - columns["t"][i]
    return float(columns["t"][i] + (lasts * share * whole / mean if mean > 0.0 else 0.0))


def _seen(recording: Recording, index: int, name: str, times: Floats) -> tuple[Floats, Floats, Floats]:
    """x, y, heading of another car at the times up to the last one at which it is reported without a gap."""
    rows = []
    for cycle in recording.cycles[index:]:
        found = [o for o in cycle.objects if o["id"] == name]
        if not found or cycle.t > times[-1] + 1.0:
            break
        rows.append((cycle.t, found[0]["x"], found[0]["y"], found[0]["heading"]))
    t, x, y, heading = np.array(rows).T
    known = times[times <= t[-1]]
    return np.interp(known, t, x), np.interp(known, t, y), np.interp(known, t, np.unwrap(heading))


class Lane:
    """Stations and offsets along the middle of the road: midpoints of pairs of border points, as the project's geometry has it."""

    def __init__(self, recording: Recording) -> None:
        assert recording.closed
        assert recording.left.shape == recording.right.shape
        self.points = (recording.left + recording.right) / 2.0
        self.line = shapely.LinearRing(self.points)

    def place(self, body: Body) -> tuple[float, float, float]:
        """Station [m], offset to the left [m], direction of the road there [rad]."""
        point = np.array([body["x"], body["y"]])
        begin = self.points
        step = np.roll(begin, -1, axis=0) - begin
        share = np.clip(((point - begin) * step).sum(axis=1) / (step * step).sum(axis=1), 0.0, 1.0)
        away = point - (begin + share[:, None] * step)
        k = int(np.hypot(*away.T).argmin())
        side = step[k, 0] * away[k, 1] - step[k, 1] * away[k, 0]
        station = float(self.line.project(shapely.Point(point)))
        offset = float(np.copysign(np.hypot(*away[k]), side))
        return station, offset, float(np.arctan2(step[k, 1], step[k, 0]))


@dataclass(frozen=True)
class Gaps:
    """Of one other car: what is left over along and across, by which rule it would be unsafe; m."""

    behind: bool
    #: How fast our car closes in on it sideways, and how much faster it is along the road [m/s].
    closing: float
    faster: float
    oncoming: bool
    along: float
    across: float
    needed_along: float
    needed_across: float
    printed: float
    #: How much further away it is once it stands: less where it comes towards our car.
    room: float


def gaps(lane: Lane, cycle: Cycle, car: Car, r: rss.Response) -> Sequence[Gaps]:
    """Bumper to bumper along the road, flank to flank across it."""
    result = []
    station, offset, road = lane.place(cycle.ego)
    turn = cycle.ego["heading"] - road
    own_along, own_across = cycle.ego["v"] * np.cos(turn), cycle.ego["v"] * np.sin(turn)
    for body in cycle.objects:
        its_station, its_offset, its_road = lane.place(body)
        its_turn = body["heading"] - its_road
        along, across = body["v"] * np.cos(its_turn), body["v"] * np.sin(its_turn)
        whole = lane.line.length
        ahead = float(np.remainder(its_station - station + whole / 2.0, whole) - whole / 2.0)
        gap = (
            abs(ahead) - _reach(car.length, car.width, turn) - _reach(body["length"], body["width"], its_turn)
        )
        flank = abs(its_offset - offset) - _reach(car.width, car.length, turn)
        flank -= _reach(body["width"], body["length"], its_turn)
        left = 1.0 if its_offset >= offset else -1.0
        ahead_of = along < 0.0
        result.append(
            Gaps(
                behind=ahead < 0.0,
                closing=left * own_across,
                faster=own_along - along,
                oncoming=ahead_of,
                along=gap,
                across=flank,
                needed_along=rss.opposite(own_along, -along, r)
                if ahead_of
                else rss.same_direction(own_along, along, r),
                needed_across=rss.aside(left * own_across, -left * across, r),
                printed=rss.as_printed(gap, own_along, along, r),
                room=-rss.stopping(-along, r) if ahead_of else along * along / (2.0 * r.brake),
            )
        )
    return result


def way_left(cycle: Cycle, columns: Columns) -> float:
    """How far it is along a candidate from where the car is to its end [m]."""
    if curve.chords(columns).max() <= curve.SAME:
        return 0.0
    line = shapely.LineString(np.stack([columns["x"], columns["y"]], axis=-1))
    return float(line.length - line.project(shapely.Point(cycle.ego["x"], cycle.ego["y"])))


def reached(gap: Gaps, way: float, slack: float) -> bool:
    """Whether the car, so much way from its rest, gets as far as where the other one stands; slack in m."""
    return not gap.behind and gap.across <= gap.needed_across + slack and gap.along + gap.room <= way + slack


def in_its_way(cycle: Cycle, columns: Columns, gaps: Sequence[Gaps], car: Car, slack: float) -> bool:
    """Whether a candidate leads over where another car is now, with more of its way to its rest left than that one goes on, braking; slack in m.

    Looked at every 0.1 m of the way, on straight steps. Who is behind and drives answers for what happens.
    """
    chords = curve.chords(columns)
    ends = np.concatenate([[0.0], np.cumsum(chords)])
    if ends[-1] <= curve.SAME:
        return False
    going = np.concatenate([[True], chords > 0.0])
    s = np.linspace(0.0, ends[-1], max(2, int(ends[-1] / 0.1) + 1))
    x, y, heading = (
        np.interp(s, ends[going], column[going])
        for column in (columns["x"], columns["y"], np.unwrap(columns["heading"]))
    )
    bodies = shapely.polygons(corners(x, y, heading, car.length + slack / 50, car.width + slack / 50))
    for body, gap in zip(cycle.objects, gaps, strict=True):
        if gap.behind and abs(body["v"]) > 0.5:
            continue
        meant = ends[-1] - s >= max(0.0, gap.room) - slack
        if shapely.intersects(bodies[meant], box(body, body["length"], body["width"])).any():
            return True
    return False


def _reach(length: float, width: float, angle: float) -> float:
    """Half of what a rectangle takes up in a direction."""
    return float(abs(np.cos(angle)) * length + abs(np.sin(angle)) * width) / 2.0


def too_near(gap: Gaps, slack: float) -> set[str]:
    """By which distance the other car is too near: `ahead`, `oncoming`, `beside`, `printed`; slack in m, or in m/s, is on top of what is needed."""
    if gap.behind:
        # It answers for what happens, unless it is beside our car and that passes it, or moves over.
        ours = gap.along < slack and max(gap.closing, gap.faster) > -slack
        return {"beside"} if ours and gap.across <= gap.needed_across + slack else set()
    near_along = gap.along <= gap.needed_along + slack
    near_across = gap.across <= gap.needed_across + slack
    found = set()
    if near_along and near_across:
        found |= {"beside", "oncoming" if gap.oncoming else "ahead"}
    if near_across and not gap.oncoming and gap.printed <= slack:
        found.add("printed")
    return found
