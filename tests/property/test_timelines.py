"""Windows along a timeline are those of times in whole nanoseconds, as they were written, whatever sums of doubles say; all evaluators."""

from __future__ import annotations

from itertools import accumulate
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import trackmarshal as tm
from support.agreement import said_of
from support.length import amount

#: ms: nothing is lost where times are multiples of these.
WINDOWS = [(0, 0), (0, 100), (100, 100), (100, 300), (200, 700), (300, 300), (0, 700)]
SPEC = """module windows
signal plan : trajectory { t: s increasing, n: 1 }
signal asked : state { here: 1, there: 1 }
""" + "".join(
    f"""
rule ahead_{low}_{high} "x"
  along plan as p
  require eventually (p.n == asked.here and eventually[{low} ms, {high / 1000!r} s] p.n == asked.there)
rule until_{low}_{high} "x"
  along plan as p
  require eventually (p.n == asked.here and (p.n >= 0 until[{low} ms, {high} ms] p.n == asked.there))
rule back_{low}_{high} "x"
  along plan as p
  require eventually (p.n == asked.here and once[{low / 1000!r} s, {high} ms] p.n == asked.there)
rule since_{low}_{high} "x"
  along plan as p
  require eventually (p.n == asked.here and (p.n >= 0 since[{low} ms, {high} ms] p.n == asked.there))
rule count_{low}_{high} "x"
  along plan as p
  require eventually (p.n == asked.here and count(p.n == asked.there, last: {high} ms) == 1)
"""
    for low, high in WINDOWS
)  # fmt: skip


@pytest.fixture(scope="module", params=["numpy", "reference", "c"])
def evaluator(request: pytest.FixtureRequest) -> tm.Evaluator:
    return tm.Evaluator(tm.loads(SPEC), backend=request.param)


def inside(evaluator: tm.Evaluator, t: list[float], here: int, there: int) -> dict[str, bool]:
    signals = {"plan": {"t": t, "n": list(range(len(t)))}, "asked": {"here": here, "there": there}}
    return {
        name: verdict == "satisfied"
        for name, (verdict, _) in said_of(evaluator, {"signals": signals}).items()
    }


@settings(deadline=None, max_examples=amount(25, 300))
@given(
    st.sampled_from([0, -700, 300, 86_400_300, -1_000_000_100]),
    st.lists(st.sampled_from([100, 100, 100, 200, 300, 10, 1]), min_size=1, max_size=12),
    st.integers(0, 12),
    st.integers(0, 12),
)
@example(0, [100] * 8, 7, 8)
@example(0, [100] * 8, 8, 7)
def test_windows_along_a_timeline(
    evaluator: tm.Evaluator, start: int, steps: list[int], here: int, there: int
) -> None:
    """start, steps: ms."""
    stamps = list(accumulate(steps, initial=start))
    here, there = min(here, len(steps)), min(there, len(steps))
    later, expected = stamps[there] - stamps[here], dict[str, Any]()
    for low, high in WINDOWS:
        ahead, back = low <= later <= high, low <= -later <= high
        expected |= {
            f"ahead_{low}_{high}": ahead, f"until_{low}_{high}": ahead, f"back_{low}_{high}": back, f"since_{low}_{high}": back,
            f"count_{low}_{high}": 0 <= -later <= high,
        }  # fmt: skip
    assert inside(evaluator, [stamp / 1000 for stamp in stamps], here, there) == expected


def test_samples_within_a_nanosecond(evaluator: tm.Evaluator) -> None:
    """They are at one time, and each has itself and what comes behind it ahead, and not what is before it."""
    t = [0.0, 0.1, 0.1 + 2e-10, 0.1 + 4e-10, 0.2]
    for here, there, ahead, back in (
        (1, 3, True, False),
        (3, 1, False, True),
        (2, 2, True, True),
        (3, 4, False, False),
    ):
        found = inside(evaluator, t, here, there)
        assert (found["ahead_0_0"], found["back_0_0"], found["count_0_0"]) == (ahead, back, back)
    assert inside(evaluator, t, 0, 3)["ahead_100_100"]
    assert inside(evaluator, t, 3, 4)["until_100_100"]
    assert not inside(evaluator, t, 3, 2)["ahead_0_100"]


def test_times_that_are_infinite_in_nanoseconds(evaluator: tm.Evaluator) -> None:
    t = [-1.7e308, -1e305, 0.0, 1e305, 1.7e308]
    assert inside(evaluator, t, 0, 1)["ahead_0_0"]  # no double has the difference
    assert not inside(evaluator, t, 1, 2)["ahead_0_700"]
