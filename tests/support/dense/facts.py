"""All that is so in a recording, by the dense computation: for every cycle and candidate the set of what is wrong with it, in words."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from support.dense import columns, physics, place, rss, sweep, traffic
from support.dense.car import Car
from support.dense.recording import Cycle, Recording

#: Two ways to a distance along the road may differ by as much, m: both are right on the middle of the road.
SLACK = 0.01


@dataclass(frozen=True)
class Facts:
    """What is wrong: certainly (a rule that does not fire misses it), and possibly (a rule that fires is confirmed by it)."""

    certain: frozenset[str]
    possible: frozenset[str]


def facts(recording: Recording, car: Car, cycles: Iterable[Cycle] | None = None) -> dict[tuple[int, str], Facts]:
    """By index of the cycle and candidate. car: with the allowances that the rules have."""
    road = sweep.road(recording)
    lane = traffic.Lane(recording)
    result = {}
    for cycle in recording.cycles if cycles is None else cycles:
        near, nearer = _others(lane, cycle, car)
        for name, candidate in cycle.candidates.items():
            certain = set(nearer)
            possible = set(near)
            if sweep.leaves(candidate, road, car):
                certain.add("off the road")
            certain |= {fact for fact, so in physics.at_samples(candidate, car).items() if so}
            possible |= {fact for fact, so in physics.between(candidate, car).items() if so}
            if name == "emergency" and physics.ends_moving(candidate):
                certain.add("does not stop")
            possible |= {fact for fact, so in columns.disagreements(candidate).items() if so}
            possible |= place.astray(cycle, candidate)
            if traffic.meets(recording, cycle, candidate, car) is not None:
                possible.add("meets")
            result[cycle.index, name] = Facts(frozenset(certain), frozenset(certain | possible))
    return result


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
