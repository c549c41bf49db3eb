"""A cycle on its way to the Supervisor, with all around it that a fault can change."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from trackmarshal.runtime.cycle import Cycle
from trackmarshal.scenarios.fields import ELSEWHERE

#: Time that a verdict takes when nothing is wrong, s.
USUAL_DELAY = 0.005


@dataclass(slots=True)
class Moment:
    """One cycle as it will be handed over. Everything in it is its own and may be changed.

    arrival: when it comes, s; delay: how long the verdict takes, s; clock: by how much the clock is wrong, s. lost: it never comes; silent: the caller
    says that it did not come. judge: what goes wrong with the verdicts ("" for nothing).
    """

    number: Any
    t: Any
    candidates: dict[str, dict[str, Any]]
    signals: dict[str, Any]
    arrival: float
    delay: float = USUAL_DELAY
    clock: float = 0.0
    lost: bool = False
    silent: bool = False
    judge: str = ""
    also: frozenset[str] = frozenset()

    @classmethod
    def of(cls, cycle: Cycle) -> Moment:
        """A copy of a recording's cycle, deep enough to be changed."""
        plans = {"driving": cycle.driving, "emergency": cycle.emergency}
        there = {name: plan for name, plan in plans.items() if plan is not None}
        shared = cls(cycle.number, cycle.t, there, dict(cycle.signals), cycle.t, also=cycle.also)
        return shared.copied()

    def copied(self) -> Moment:
        """As it is: what is changed from here on is not changed in the other."""
        candidates = {
            name: {field: list(column) for field, column in plan.items()}
            for name, plan in self.candidates.items()
        }
        signals = {name: _copied(name, value) for name, value in self.signals.items()}
        return replace(self, candidates=candidates, signals=signals)

    @property
    def cycle(self) -> Cycle:
        """What the Supervisor gets."""
        plans = self.candidates
        return Cycle(
            self.number, self.t, plans.get("driving"), plans.get("emergency"), self.signals, self.also
        )

    def beside_the_car(self, ahead: float, left: float, turn: float) -> dict[str, float]:
        """A pose relative to the car's: m ahead, m to the left, rad turned."""
        ego = self.signals["ego"]
        c, s = math.cos(ego["heading"]), math.sin(ego["heading"])
        return {
            "x": ego["x"] + ahead * c - left * s,
            "y": ego["y"] + ahead * s + left * c,
            "heading": math.remainder(ego["heading"] + turn, math.tau),
        }


def _copied(name: str, value: Any) -> Any:
    """A signal that a fault can change; of a track, nobody changes a line: another one takes its place."""
    if name not in ELSEWHERE:
        return value
    return dict(value) if name in ("ego", "track") else [dict(each) for each in value]
