"""When a sample is due: the Supervisor in one process, the one that is a process of its own, and whoever executes say the same.

Times of a trajectory count from the stamp of its cycle, wherever they begin; the car is where an approved trajectory has it by them.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from functools import cache
from itertools import count
from typing import Any

import pytest

import trackmarshal as tm
from support.processes import PATIENCE, Served
from trackmarshal.evaluation import Evaluator
from trackmarshal.process.client import Client
from trackmarshal.process.executing import DRIVE, FALLBACK, Executing
from trackmarshal.process.serving import Built, build

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
#: Speed of the car, m/s; a stamp of which the times of no sample are a whole number of bits away.
SPEED, STAMP = 30.0, 1234.7
#: When a trajectory may begin, s from the stamp: a planner's own stamp, a sample behind the car, the tolerance of `stamp_match`.
BEGINS = (-0.13, -0.04, 0.0, 0.0099)


@cache
def program() -> Built:
    spec = tm.loads("""
module due
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }

rule speed "Speed"
  for all p in plan
  require p.v <= 60 m/s
""")
    return build(spec, Evaluator(spec, None, "c").rules)


def plan(begin: float, braking: float) -> dict[str, list[float]]:
    """Columns of a car that is at 0 m at the stamp; after it, it brakes."""
    times = [begin, 0.05, 0.2, 0.5, SPEED / braking] if braking else [begin, 0.05, 0.2, 0.5, 1.5]
    v = [SPEED - braking * max(t, 0.0) for t in times]
    x = [SPEED * t - braking * max(t, 0.0) ** 2 / 2 for t in times]
    return {
        "t": times,
        "x": x,
        "y": [0.0] * 5,
        "heading": [0.0] * 5,
        "v": [*v[:-1], 0.0 if braking else v[-1]],
    }


@pytest.fixture(scope="module")
def served() -> Iterator[Served]:
    with Served(program()) as one:
        yield one


#: One Supervisor hears them all, in whichever order they come.
NUMBERS = count()


@pytest.mark.parametrize("begin", BEGINS)
def test_samples_are_due_by_the_stamp(begin: float, served: Served) -> None:
    number = next(NUMBERS)
    stamp = now = STAMP + 0.1 * number
    ear = served.listening()
    client = Client(program().layout, served.channel(), lambda: now)
    executing = Executing(program().layout, simulated=True)
    driving, emergency = plan(begin, 0.0), plan(begin, 10.0)
    ego: dict[str, Any] = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": SPEED}
    message = client.answer(client.send(number, stamp, driving, emergency, {"ego": ego}), PATIENCE)
    assert message is not None
    assert message["safe"] == 1
    due = [t + stamp for t in driving["t"]]
    assert message.due("driving").tolist() == due
    assert message.due("fallback").tolist() == [t + stamp for t in emergency["t"]]
    assert executing.hear(message.data) == "none"
    for later in (0.0, 0.02, 0.1):
        found = executing.at(stamp + later)
        assert (found.action, found.sample is None) == (DRIVE if later < 0.05 else FALLBACK, False)
        assert found.sample is not None
        passed = max(later, begin)  # before the first sample, that one counts
        along = SPEED * passed - (10.0 * passed**2 / 2 if found.action == FALLBACK else 0.0)
        # Straight between samples 0.15 s apart: a braking car is up to 3 cm from there.
        assert found.sample["x"] == pytest.approx(along, abs=0.03 if found.action == FALLBACK else 1e-6)
    client.close()
    ear.close()
