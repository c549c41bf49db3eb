"""Several supervised cars on one road, whose planners propose whatever they like: what rules count on of others is what they hold the car itself to, as far
as its fallback brakes about as hard as others count on (docs/assumptions.md).
"""

from __future__ import annotations

from collections import Counter

import pytest

from support.length import amount
from support.several_cars import run
from support.supervised import shipped
from trackmarshal.backends.c.build import compiler

pytestmark = [
    pytest.mark.verifies("S-1-A-2"),
    pytest.mark.skipif(compiler() is None, reason="no C compiler"),
]

#: Of 13 m/s^2 that others count on (b_rear), in m/s^2; in bends, what is left of the tyres.
BRAKES = (11.0, 12.6)
RUNS = amount(6, 400)


def test_nobody_meets_anybody_when_all_fall_back_at_once() -> None:
    """In the first of these runs, two moved over into the room between them, before each left half of it to the other one."""
    found = {seed: run(shipped(), seed, BRAKES) for seed in (165, *range(RUNS))}
    assert {seed: one.wrong for seed, one in found.items() if one.wrong} == {}
    seen = sum((one.seen for one in found.values()), Counter[str]())
    assert seen["cars"] > 1.5 * RUNS
    assert seen["safe"] > 15 * RUNS
