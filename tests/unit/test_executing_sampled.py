"""Between which samples of a trajectory a time lies, whatever numbers they are made of: the layer that executes never raises."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from trackmarshal.process.executing import DECIDED, DRIVE, Executing, Setpoint


class Said:
    """A message's columns."""

    def __init__(self, **columns: list[float]) -> None:
        self._columns = columns

    def column(self, group: str, name: str) -> list[float]:
        return self._columns[name]


def sampled(now: float, due: list[float], x: list[float], heading: list[float]) -> Setpoint:
    layout: Any = SimpleNamespace(silence=1.0, plan=("x", "heading"))
    said: Any = Said(due=due, x=x, heading=heading)
    return Executing(layout)._sampled(said, "driving", now, DRIVE, DECIDED, 0)


#: A car's clock after eleven days, and a step that it cannot tell from none.
STAMP, NONE = 1e6, 1e-11


@pytest.mark.parametrize(
    ("now", "times", "expected"),
    [
        (STAMP - 0.01, [0.0, NONE, 1.0], 0.0),  # before the first sample, of which two are due at once
        (STAMP, [0.0, NONE, 1.0], 0.0),
        (STAMP + 1.0, [0.0, 1.0, 1.0 + NONE], 1.0),  # at the end, likewise
        (STAMP + 0.5, [0.0, 1.0, 1.0 + NONE], 0.5),
    ],
)
def test_two_samples_that_are_due_at_once(now: float, times: list[float], expected: float) -> None:
    due = [STAMP + t for t in times]
    assert len(set(due)) == 2
    found = sampled(now, due, times, [0.0, 0.0, 0.0])
    assert found.sample is not None
    assert found.sample["x"] == pytest.approx(expected, abs=1e-9)


def test_headings_that_cannot_be_subtracted() -> None:
    found = sampled(0.5, [0.0, 1.0], [0.0, 1.0], [1.7e308, -1.7e308])
    assert found.sample is not None
    assert (found.sample["x"], math.isnan(found.sample["heading"])) == (0.5, True)


@pytest.mark.parametrize(
    ("before", "after"), [(3.1, -3.1), (-3.1, 3.1), (3.1, 2.0 * math.pi - 3.1 + 4.0 * math.pi)]
)
def test_headings_go_the_shorter_way_round(before: float, after: float) -> None:
    """Halfway between two on both sides of pi, a car points there, and not the other way."""
    found = sampled(0.5, [0.0, 1.0], [0.0, 1.0], [before, after])
    assert found.sample is not None
    assert math.cos(found.sample["heading"]) == pytest.approx(-1.0)
