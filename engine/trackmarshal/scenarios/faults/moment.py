"""A cycle on its way to the Supervisor, with all around it that a fault can change."""

from __future__ import annotations

import math
from dataclasses import dataclass
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
        candidates = {
            name: {field: list(column) for field, column in plan.items()}
            for name, plan in (("driving", cycle.driving), ("emergency", cycle.emergency))
            if plan is not None
        }
        signals = {
            "ego": dict(cycle.signals["ego"]),
            "objects": [dict(each) for each in cycle.signals["objects"]],
            "obstacles": [dict(each) for each in cycle.signals["obstacles"]],
            **{name: value for name, value in cycle.signals.items() if name not in ELSEWHERE},
            "track": dict(cycle.signals["track"]),  # nobody changes a line: another one takes its place
        }
        return cls(cycle.number, cycle.t, candidates, signals, cycle.t, also=cycle.also)

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
