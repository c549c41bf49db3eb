"""The seam where a Supervisor is put in: in this process, or one of its own behind the same three calls."""

from __future__ import annotations

import itertools
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol

import trackmarshal as tm
from closed_loop import places
from closed_loop.executing import Columns, Given
from closed_loop.message import Message
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.process.client import Client
from trackmarshal.process.serving import Built, build, remove, shared_path, start
from trackmarshal.process.shared_memory import SharedMemory
from trackmarshal.process.supervisor import RemoteSupervisor
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.faults import name_of

#: 115 points a trajectory; two cycles of 0.1 s may be 0.15 s apart.
LIMITS: Mapping[str, Any] = {"samples": 128, "elements": 32, "border": 1024}
#: Real seconds that a decision may take on a busy machine.
PATIENCE = 20.0
_numbers = itertools.count(1)


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

    def __init__(self, track: Mapping[str, Any]) -> None:
        self._now = 0.0
        self._track = track
        self._supervisor = self._made()

    def _made(self) -> Any:
        return tm.supervisor(_spec(), backend="c", limits=tm.Limits(**LIMITS), clock=lambda: self._now)

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


class AsProcess(InProcess):
    """The Supervisor as a process of its own, over shared memory: what is shipped, by the time of the messages that it gets."""

    def _made(self) -> Any:
        built, spec = _built(), _spec()
        self._name = f"trackmarshal-loop-{os.getpid()}-{next(_numbers)}"
        self._process = start(built, shm=self._name, simulated=True)
        channel = SharedMemory(built.layout, shared_path(self._name))
        client = Client(built.layout, channel, lambda: self._now)
        return RemoteSupervisor(
            spec, _rules(spec), client, tm.Limits(**LIMITS), lambda: self._now, patience=PATIENCE
        )

    def close(self) -> None:
        super().close()
        self._process.kill()
        self._process.communicate()
        remove(self._name)


@cache
def _spec() -> Spec:
    return tm.load([places.RULES], [places.CAR_SPEC, places.TRACK_SPEC])


def _rules(spec: Spec) -> list[RuleInfo]:
    return [rule for rule in spec.rules if rule.formula is not None]


@cache
def _built() -> Built:
    return build(_spec(), _rules(_spec()), tm.Limits(**LIMITS))


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
