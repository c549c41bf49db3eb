"""The take-up rule on generated cycles: whatever it approves can be taken up in any moment of the window, driven in time."""

from __future__ import annotations

import numpy as np

from support.dense.car import Car
from support.dense.congruence import apart, seen
from support.dense.driven import drive
from support.dense.recording import Columns, Cycle, Floats
from support.dense.takeup import Terms, take_up, window

CAR = Car(4.7, 2.8, 1160.0, 7.0, 13.0, 0.854, np.array([[0.0, 6.0], [80.0, 6.0]]), 80.0)
STEP = 2.5


def bend(length: float, first: float, last: float) -> Columns:
    """A clothoid from the origin along +x, with samples every 2.5 m."""
    fine = np.linspace(0.0, length, 1 + 50 * int(length / STEP))
    kappa = first + (last - first) * fine / length
    heading = np.concatenate([[0.0], np.cumsum((kappa[1:] + kappa[:-1]) / 2.0 * np.diff(fine))])
    middle = (heading[1:] + heading[:-1]) / 2.0
    x = np.concatenate([[0.0], np.cumsum(np.cos(middle) * np.diff(fine))])
    y = np.concatenate([[0.0], np.cumsum(np.sin(middle) * np.diff(fine))])
    return {"s": fine[::50], "x": x[::50], "y": y[::50], "heading": heading[::50], "kappa": kappa[::50]}


def timed(path: Columns, square: Floats) -> Columns:
    """With the squares of speed at the samples; accelerations hold until the next one."""
    v = np.sqrt(square)
    a = np.append(np.diff(square) / (2.0 * np.diff(path["s"])), 0.0)
    lasts = 2.0 * np.diff(path["s"]) / np.maximum(v[1:] + v[:-1], 1e-3)
    return {**path, "v": v, "a": a, "t": np.concatenate([[0.0], np.cumsum(lasts)])}


def generated(chance: np.random.Generator) -> Cycle:
    """A bend that is driven up to its limit; an emergency trajectory that brakes more or less late, and more or less hard."""
    path = bend(250.0, *chance.uniform(-0.02, 0.02, 2))
    sharpest = float(np.abs(path["kappa"]).max())
    v = min(chance.uniform(10.0, 60.0), chance.uniform(0.6, 0.98) * np.sqrt(CAR.grip / sharpest))
    driving = timed(
        path, np.maximum(0.0, v * v + 2.0 * chance.uniform(-3.0, 3.0) * path["s"] * (path["s"] < 50.0))
    )
    turn = int(chance.integers(0, 8))
    square = [*np.square(driving["v"][: turn + 1])]
    share = chance.uniform(0.5, 1.0)
    for kappa in path["kappa"][turn + 1 :]:
        along = share * np.sqrt(max(0.0, CAR.grip**2 - (square[-1] * kappa) ** 2))
        square.append(max(0.0, square[-1] - 2.0 * STEP * along))
        if square[-1] == 0.0:
            break
    rest = len(square)
    emergency = timed({name: column[:rest] for name, column in path.items()}, np.array(square))
    at = chance.uniform(0.0, 2.5)
    ego = {name: float(np.interp(at, path["s"], driving[name])) for name in ("x", "y", "heading", "v")}
    return Cycle(0, 0.0, ego, [], {"driving": driving, "emergency": emergency}, "", "")


def test_what_is_approved_can_be_taken_up() -> None:
    chance = np.random.default_rng(20)
    causes: set[str] = set()
    approved = []
    for _ in range(100):
        ds, dv, slip, push = chance.uniform((3.0, 2.0, 0.0, 0.0), (20.0, 8.0, 0.3, 0.3))
        terms = Terms(ds=ds, dv=dv, slip=slip, push=push)
        cycle = generated(chance)
        taken = take_up(cycle, None, CAR, terms)
        causes |= taken.causes(terms)
        if not taken.causes(terms):
            approved.append((cycle, terms, taken))
    assert causes >= {"speed", "friction", "rest"}, "the generator makes what is refused, too"
    assert len(approved) > 20
    paths, begin, v, of = [], [], [], []
    for cycle, terms, taken in approved:
        follows = window(cycle, Terms(terms.period, terms.longest_gap), moments=4)
        for station, speed in zip(follows.stations, follows.speeds):
            paths.append(follows.on)
            begin.append(max(0.0, station + chance.uniform(-terms.slip, terms.slip)))
            v.append(max(0.0, speed + chance.uniform(-terms.push, terms.push)))
            of.append((taken, terms))
    went = drive(paths, np.array(begin), np.array(v), CAR)
    for i, (on, (taken, terms)) in enumerate(zip(paths, of)):
        assert went.rest[i] <= on.end + taken.overrun + 0.1
        assert went.grip[i] <= 1.01
        assert went.excess[i] <= taken.excess + 1.0
        place = [float(on.at(name, begin[i])) for name in ("x", "y", "heading")]
        assert apart(on, seen(on, *place, v[i]), taken, terms) == ""


def test_a_car_that_is_too_fast_or_elsewhere_is_apart() -> None:
    cycle = generated(np.random.default_rng(1))
    terms = Terms(ds=100.0, dv=100.0)
    taken = take_up(cycle, None, CAR, terms)
    on = window(cycle, terms).on
    x, y, heading, v = (float(on.at(name, 10.0)) for name in ("x", "y", "heading", "v"))
    most = float(np.sqrt(v * v + taken.excess))
    assert apart(on, seen(on, x, y, heading, most), taken, terms) == ""
    assert apart(on, seen(on, x, y, heading, most + 1.0), taken, terms) == "faster"
    assert (
        apart(on, seen(on, x - 0.5 * np.sin(heading), y + 0.5 * np.cos(heading), heading, v), taken, terms)
        == "beside"
    )
    assert apart(on, seen(on, x, y, heading + 0.2, v), taken, terms) == "turned"
    far = [float(on.at(name, on.end + taken.overrun + 1.0)) for name in ("x", "y", "heading")]
    assert apart(on, seen(on, *far, 0.0), taken, terms) == "beyond"
