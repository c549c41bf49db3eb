"""Whatever a planner proposes, a car that drives what the Supervisor decides stays on the road and hits nobody who keeps to his line."""

from __future__ import annotations

from collections import Counter

import pytest

from support.any_planner import Outcome, run
from support.length import amount
from support.supervised import shipped
from trackmarshal.backends.c.build import compiler

pytestmark = [
    pytest.mark.verifies("S-1-A-2"),
    pytest.mark.skipif(compiler() is None, reason="no C compiler"),
]

RUNS = amount(40, 1500)
RULES = [rule for rule in shipped().rules if rule.kind == "rule"]


def outcomes(rules: list[str] | None = None, count: int = RUNS) -> list[Outcome]:
    return [run(shipped(), seed, rules) for seed in range(count)]


def test_nothing_is_hit_whatever_is_proposed() -> None:
    found = outcomes()
    assert {seed: one.wrong for seed, one in enumerate(found) if one.wrong} == {}
    seen = sum((one.seen for one in found), Counter[str]())
    assert seen["safe"] > 15 * RUNS
    assert seen["unsafe"] > 3 * RUNS
    assert seen["driven"] > RUNS / 2


@pytest.mark.acceptance
def test_without_the_rules_about_others_somebody_is() -> None:
    kept = [r.name for r in RULES if r.module != "supervisor.collision" or r.name == "static_collision"]
    assert sum(one.wrong.startswith("in contact") for one in outcomes(kept, 42)) >= 3


@pytest.mark.acceptance
def test_without_the_rule_about_the_road_it_is_left() -> None:
    kept = [rule.name for rule in RULES if rule.name != "static_collision"]
    assert sum(one.wrong == "off the road" for one in outcomes(kept, 42)) >= 2
