"""Whatever the take-up rule approves can be fallen back from: docs/takeup.md, held on a real planner's cycles by cars driven in time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
import pytest
import shapely

from support.dense import car as cars
from support.dense import recording, sweep
from support.dense.delayed import delayed
from support.dense.driven import Driven, drive
from support.dense.path import Path
from support.dense.recording import Cycle, Floats
from support.dense.sweep import Road
from support.dense.takeup import TakeUp, Terms, take_up, window
from support.shared import shared

SOME, ALL = 83, 1
TERMS = (Terms(ds=20.0, dv=8.0), Terms(ds=20.0, dv=8.0, slip=0.2, push=0.2))
#: What driving in steps of a millisecond, along points 10 cm apart, may differ by: m, m^2/s^2, and the share of the grip that the path asks for
#: between samples, where rules do not look.
NEAR, SQUARE, ABOUT = 0.1, 5.0, 0.065


@cache
def read(name: str) -> tuple[recording.Recording, Road]:
    data = recording.read(shared("data", "planner"), name)
    return data, sweep.road(data)


def limits() -> cars.Car:
    return cars.read(shared("data", "planner", "ltpl_car.spec"))


def approved(name: str, every: int, terms: Terms, *, late: bool) -> list[tuple[Cycle, TakeUp]]:
    """Cycles that the rule approves; late: with an emergency trajectory that brakes as late as it may."""
    data, road = read(name)
    cycles: Iterator[Cycle] = iter(data.cycles[::every])
    if late:
        cycles = (delayed(cycle, limits(), terms.window) for cycle in cycles)
    judged = [(cycle, take_up(cycle, road, limits().allowed(0.01), terms)) for cycle in cycles]
    return [(cycle, taken) for cycle, taken in judged if not taken.causes(terms)]


def taken_up(
    some: Sequence[tuple[Cycle, TakeUp]], terms: Terms, seed: int
) -> tuple[list[Path], Floats, Floats, Driven]:
    """Each at five moments of the window, wherever and as fast as the disturbance has it; paths, overruns and excesses allowed, how it went."""
    chance = np.random.default_rng(seed)
    paths: list[Path] = []
    begin, v, allowed, excess = [], [], [], []
    for cycle, taken in some:
        seen = window(cycle, Terms(terms.period, terms.longest_gap), moments=5)
        for station, speed in zip(seen.stations, seen.speeds):
            paths.append(seen.on)
            begin.append(max(0.0, station + chance.uniform(-terms.slip, terms.slip)))
            v.append(max(0.0, speed + chance.uniform(-terms.push, terms.push)))
            allowed.append(taken.overrun)
            excess.append(taken.excess)
    went = drive(paths, np.array(begin), np.array(v), limits().allowed(0.01))
    return paths, np.array(allowed), np.array(excess), went


@pytest.mark.parametrize("late", [False, True], ids=["as planned", "braking later"])
@pytest.mark.parametrize(
    ("name", "terms", "every"),
    [
        ("modena_cars", TERMS[1], SOME),
        *(
            pytest.param(name, terms, ALL, marks=pytest.mark.acceptance)
            for name in recording.NAMES
            for terms in TERMS
        ),
    ],
)
def test_what_is_approved_can_be_taken_up(name: str, terms: Terms, late: bool, every: int) -> None:
    """In every moment until the decision is overdue: within the grip, at rest where the rule says, on the road until there."""
    some = approved(name, every, terms, late=late)
    assert some
    _, road = read(name)
    paths, allowed, excess, went = taken_up(some, terms, seed=9)
    ends = np.array([on.end for on in paths])
    assert (went.rest <= ends + np.minimum(allowed, terms.ds) + NEAR).all()
    assert (went.grip <= 1.0 + ABOUT).all()
    assert (went.excess <= excess + SQUARE).all()
    further = np.flatnonzero(went.rest > ends)
    on_road = [_stands_on(paths[i], float(went.rest[i]) - NEAR, road) for i in further]
    assert all(on_road)


def _stands_on(on: Path, station: float, road: Road) -> bool:
    car = limits()
    x, y, heading = (np.array([on.at(name, station)]) for name in ("x", "y", "heading"))
    return bool(
        shapely.covers(road.area, shapely.Polygon(sweep.corners(x, y, heading, car.length, car.width)[0]))
    )


@pytest.mark.parametrize(
    ("name", "every"),
    [
        ("berlin", SOME),
        *(pytest.param(name, ALL, marks=pytest.mark.acceptance) for name in recording.ALONE),
    ],
)
def test_a_planner_that_brakes_later_needs_no_reserve(name: str, every: int) -> None:
    """Emergency trajectories that drive as the driving ones until the window is over are taken up as they are."""
    data, _ = read(name)
    some = approved(name, every, Terms(ds=0.01, dv=0.01), late=True)
    assert len(some) == len(data.cycles[::every])


def test_without_a_reserve_the_planner_is_refused() -> None:
    """Its emergency trajectories brake from a sample behind the car on."""
    name = "berlin"
    data, _ = read(name)
    assert len(approved(name, SOME, Terms(ds=0.01, dv=0.01), late=False)) < len(data.cycles[::SOME]) / 2
