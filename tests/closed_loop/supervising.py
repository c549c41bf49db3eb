"""The seam where a Supervisor is put in: in this process, or one of its own behind the same three calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import trackmarshal as tm
from closed_loop import places
from closed_loop.executing import Columns, Given
from closed_loop.message import Message
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.faults import name_of

#: 115 points a trajectory; two cycles of 0.1 s may be 0.15 s apart.
LIMITS: Mapping[str, Any] = {"samples": 128, "elements": 32, "border": 1024}


@dataclass(frozen=True)
class Said:
    """A decision: what the layer below gets, whether the cycle was safe, every reason in words, and the names of what was found."""

    given: Given
    safe: bool
    reasons: tuple[str, ...]
    found: tuple[str, ...]
    lost: str


class Supervising(Protocol):
    """What the loop asks of a Supervisor. Times are simulated."""

    def step(self, message: Message, now: float) -> Said:
        """A cycle has arrived."""

    def silence(self, now: float) -> Said:
        """No cycle has come although one was due."""

    def close(self) -> None:
        """The run is over."""


class InProcess:
    """The Supervisor in this process, all of it generated C, by simulated time."""

    def __init__(self, track: Mapping[str, Any], backend: str = "c", record: Path | None = None) -> None:
        self._now = 0.0
        self._track = track
        spec = tm.load([places.RULES], [places.CAR_SPEC, places.TRACK_SPEC])
        self._supervisor = tm.supervisor(
            spec, backend=backend, limits=tm.Limits(**LIMITS), clock=lambda: self._now, record=record
        )

    def step(self, message: Message, now: float) -> Said:
        self._now = now
        ego = message.ego
        signals: dict[str, Any] = {
            "track": self._track,
            "ego": {"x": ego.x, "y": ego.y, "heading": ego.heading, "v": ego.v, "age": ego.age},
            "obstacles": list(message.obstacles),
        }
        if message.objects is not None:
            signals["objects"] = list(message.objects)
        return said(
            self._supervisor.step(
                Cycle(message.number, message.t, message.driving, message.emergency, signals)
            )
        )

    def silence(self, now: float) -> Said:
        self._now = now
        return said(self._supervisor.step(None))

    def close(self) -> None:
        self._supervisor.close()


def said(decision: Any) -> Said:
    """A decision of `tm.supervisor`, as the loop takes it."""
    found = dict.fromkeys(name_of(fault) for fault in decision.faults)
    found.update(dict.fromkeys(violation.rule for violation in decision.violations))
    given = Given(
        decision.state, _columns(decision.driven), _columns(decision.fallback), decision.valid_until
    )
    return Said(given, decision.safe, decision.reasons, tuple(found), decision.lost)


def _columns(plan: Any) -> Columns | None:
    if plan is None:
        return None
    return {name: row.tolist() for name, row in zip(plan.names, plan.matrix)}
