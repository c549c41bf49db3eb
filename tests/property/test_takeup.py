"""The take-up rule on generated cycles: whatever it approves can be taken up in any moment of the window, driven in time."""

from __future__ import annotations

import numpy as np

from support.dense.congruence import apart, seen
from support.dense.driven import drive
from support.dense.generated import CAR, generated
from support.dense.takeup import Terms, take_up, window


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
        x, y, heading = (float(on.at(name, begin[i])) for name in ("x", "y", "heading"))
        assert apart(on, seen(on, x, y, heading, v[i]), taken, terms) == ""


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
    x, y, heading = (float(on.at(name, on.end + taken.overrun + 1.0)) for name in ("x", "y", "heading"))
    assert apart(on, seen(on, x, y, heading, 0.0), taken, terms) == "beyond"
