"""Where the origin of coordinates lies, which way they are turned, and whether the world is seen in a mirror: every decision is the same.

What moves is each cycle as a whole: the car, both trajectories, others, and the road, of which left and right change sides in a mirror.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support import any_planner
from support.length import AT_LENGTH, amount
from support.supervised import shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.decision import Decision

pytestmark = [
    pytest.mark.verifies("S-1-A-2", "S-1-A-3"),
    pytest.mark.skipif(compiler() is None, reason="no C compiler"),
]

RUNS = amount(12, 100)
#: All but that of a pit lane, which a spec declares, and which does not move.
RULES = [
    rule.name for rule in shipped().rules if rule.formula is not None and rule.name != "zone_speed_limit"
]


@dataclass(frozen=True)
class Moved:
    """About the x axis first, where it is mirrored; then turned about the origin, rad; then moved, m."""

    turn: float = 0.0
    x: float = 0.0
    y: float = 0.0
    mirrored: bool = False

    def points(self, x: Any, y: Any) -> tuple[Any, Any]:
        y = -y if self.mirrored else y
        c, s = math.cos(self.turn), math.sin(self.turn)
        return x * c - y * s + self.x, x * s + y * c + self.y

    def columns(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Of a trajectory, a set, or the car alone."""
        x, y = self.points(given["x"], given["y"])
        side = -1.0 if self.mirrored else 1.0
        bends = {"kappa": side * given["kappa"]} if "kappa" in given else {}
        return {**given, "x": x, "y": y, "heading": side * given["heading"] + self.turn, **bends}

    def line(self, given: Any) -> Any:
        return tm.line(np.stack(self.points(*np.asarray(given.points).T), axis=1))

    def track(self, given: Mapping[str, Any]) -> dict[str, Any]:
        left, right = self.line(given["left"]), self.line(given["right"])
        return {**given, "left": right if self.mirrored else left, "right": left if self.mirrored else right}

    def cycle(self, given: Cycle, track: Any) -> Cycle:
        signals = {name: self.columns(given.signals[name]) for name in ("ego", "objects", "obstacles")}
        return replace(
            given,
            signals={**signals, "track": track},
            driving=self.columns(given.driving),
            emergency=self.columns(given.emergency),
        )


WAYS = {
    "mirrored": Moved(mirrored=True),
    # As coordinates of a survey are, in which a micrometre is some thousand units in the last place.
    "all at once": Moved(turn=-1.1, x=691234.5, y=5334567.8, mirrored=True),
    "turned": Moved(turn=2.3),
    "surveyed": Moved(x=691234.5, y=5334567.8),
}


def alike(one: Decision, other: Decision, seen: Counter[int]) -> None:
    """Margins are the same but for rounding, and so is whatever follows from those that are not all but 0."""
    near = False
    for name, rated in one.judged.rated.items() if one.judged is not None else ():
        assert other.judged is not None
        there = other.judged.rated[name]
        here = np.array([rated.margins, there.margins])
        np.testing.assert_allclose(here[0], here[1], rtol=1e-5, atol=1e-5)
        touching = np.abs(here[0]) < 1e-5
        assert all(
            a == b or close for a, b, close in zip(rated.verdicts, there.verdicts, touching, strict=True)
        )
        near = near or bool(touching.any())
        seen.update(rated.verdicts)
    assert near or said(one) == said(other)


def said(decision: Decision) -> tuple[Any, ...]:
    faults = [(each.code, each.signal, each.field, each.index) for each in decision.faults]
    found = [(each.rule, each.candidate, each.verdict) for each in decision.violations]
    return decision.state, decision.safe, decision.lost, faults, found


class Both:
    """A Supervisor, and one beside it to which everything is moved."""

    def __init__(self, way: Moved, one: Any, other: Any, seen: Counter[int]) -> None:
        self._way, self._one, self._other, self._seen = way, one, other, seen
        self._moved: dict[int, Any] = {}

    def step(self, given: Cycle) -> Decision:
        track = given.signals["track"]
        moved = self._moved.setdefault(id(track), self._way.track(track))
        decision: Decision = self._one.step(given)
        alike(decision, self._other.step(self._way.cycle(given, moved)), self._seen)
        return decision


@pytest.mark.acceptance  # recordings moved and turned, every day
@pytest.mark.parametrize("way", WAYS if AT_LENGTH else ["all at once"])
def test_whatever_a_planner_proposes(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: Counter[int] = Counter()
    made = tm.supervisor
    monkeypatch.setattr(tm, "supervisor", lambda *a, **k: Both(WAYS[way], made(*a, **k), made(*a, **k), seen))
    cycles = sum(
        (any_planner.run(shipped(), seed, RULES, cycles=60).seen for seed in range(RUNS)), Counter[str]()
    )
    assert cycles["safe"] > 10 * RUNS
    assert cycles["unsafe"] > RUNS
    assert len(seen) > 2
