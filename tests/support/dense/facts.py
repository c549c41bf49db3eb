"""All that is so in a recording, by the dense computation: for every cycle and candidate what is wrong with it, in words."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from support.dense import columns, in_line, physics, place, rss, sweep, traffic
from support.dense.car import Car
from support.dense.recording import Columns, Cycle, Recording

#: Two ways to a distance along the road may differ by as much, m: both are right on the middle of the road.
SLACK = 0.01
#: The same of a way along a candidate's path, which is beside the middle of the road and bends otherwise.
ALONG = 1.0
#: The longest step of a planner: rules look at whole steps.
STEP = 2.6


@dataclass(frozen=True)
class Facts:
    """What is wrong for certain (who does not see it misses it), and what is possibly wrong too (who says so is confirmed)."""

    certain: frozenset[str]
    possible: frozenset[str]


def facts(
    recording: Recording, car: Car, cycles: Iterable[Cycle] | None = None, near: place.Near | None = None
) -> dict[tuple[int, str], Facts]:
    """By index of the cycle and candidate. car: with the allowances that the rules have."""
    road = sweep.road(recording)
    lane = traffic.Lane(recording)
    result = {}
    for cycle in recording.cycles if cycles is None else cycles:
        at_most, at_least = _others(lane, cycle, car)
        both = {"starts elsewhere"} if place.apart(*(cycle.candidates[name] for name in _BOTH)) else set()
        for name, candidate in cycle.candidates.items():
            certain = at_least | both | _of_itself(name, candidate, car)
            if sweep.leaves(candidate, road, car):
                certain.add("off the road")
            possible = (
                at_most | _true(physics.between(candidate, car)) | _true(columns.disagreements(candidate))
            )
            if name == "emergency":
                gaps, way = traffic.gaps(lane, cycle, car, rss.Response()), traffic.way_left(cycle, candidate)
                certain |= {"stops too late" for gap in gaps if traffic.reached(gap, way, -ALONG)}
                possible |= {"stops too late" for gap in gaps if traffic.reached(gap, way, ALONG)}
                if traffic.in_its_way(cycle, candidate, gaps, car, -ALONG):
                    certain.add("somebody in its way")
                if traffic.in_its_way(cycle, candidate, gaps, car, STEP):
                    possible.add("somebody in its way")
                if in_line.meets(lane, cycle, candidate, gaps, car, rss.Response(), -STEP):
                    certain.add("into a line")
                if in_line.meets(lane, cycle, candidate, gaps, car, rss.Response(), STEP):
                    possible.add("into a line")
            possible |= _true(place.astray(cycle, candidate, near or place.Near()))
            result[cycle.index, name] = Facts(frozenset(certain), frozenset(certain | possible))
    return result


_BOTH = ("driving", "emergency")


def _of_itself(name: str, candidate: Columns, car: Car) -> set[str]:
    """What is wrong at a candidate's samples."""
    found = _true(physics.at_samples(candidate, car))
    if name == "emergency" and physics.ends_moving(candidate):
        found.add("does not stop")
    if columns.out_of_range(candidate):
        found.add("out of range")
    return found


def _true(said: dict[str, bool]) -> set[str]:
    return {fact for fact, so in said.items() if so}


def _others(lane: traffic.Lane, cycle: Cycle, car: Car) -> tuple[set[str], set[str]]:
    """What is possibly, and what is certainly so of the other cars."""
    near: set[str] = set()
    nearer: set[str] = set()
    for gap in traffic.gaps(lane, cycle, car, rss.Response()):
        near |= traffic.too_near(gap, SLACK)
        nearer |= traffic.too_near(gap, -SLACK)
    if traffic.touching(cycle, car):
        near.add("touches")
        nearer.add("touches")
    return near, nearer
