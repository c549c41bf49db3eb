"""Supervisors out of specs, and records of their runs again."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import BACKENDS, Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.frame import Settings
from trackmarshal.runtime.record import Difference, Record, Run, differences
from trackmarshal.runtime.supervisor import Supervisor

if TYPE_CHECKING:
    from trackmarshal.backends.c.supervisor import CSupervisor


@dataclass(frozen=True)
class Rulebox:
    """Rules ready to supervise by: an evaluator, the values in force, and both in words for the record."""

    evaluator: Evaluator
    settings: Settings
    identity: Mapping[str, Any]

    def supervisor(
        self, limits: Limits | None = None, clock: Callable[[], float] = time.monotonic
    ) -> Supervisor:
        """A Supervisor for one run, in Python, whatever judges."""
        return Supervisor(self.evaluator.spec, self.evaluator.program, limits, clock, self.settings)

    def running(
        self, limits: Limits | None = None, clock: Callable[[], float] = time.monotonic
    ) -> Supervisor | CSupervisor:
        """The Supervisor that drives along: all of it generated C where C is asked for."""
        if self.evaluator.asked != "c":
            return self.supervisor(limits, clock)
        from trackmarshal.backends.c.supervisor import CSupervisor

        return CSupervisor(self.evaluator.spec, self.evaluator.rules, limits, clock, self.settings)


def rulebox(
    evaluator: Evaluator, params: Mapping[str, float] | None = None, tables: Mapping[str, Any] | None = None
) -> Rulebox:
    """An evaluator's rules with parameters and tables in declared units; raises E403 where they break a constraint."""
    given = {"params": dict(params or {}), "tables": dict(tables or {})}
    settings = evaluator.reader.settings(given)
    if settings.broken:
        raise TrackmarshalError("E403", settings.broken[0], help="change the parameters")
    return Rulebox(evaluator, settings, {**evaluator.program.identity, **given})


def supervisor(
    spec: Spec,
    rules: Sequence[str] | None = None,
    backend: str = "numpy",
    limits: Limits | Mapping[str, Any] | None = None,
    clock: Callable[[], float] = time.monotonic,
    record: str | Path | None = None,
    params: Mapping[str, float] | None = None,
    tables: Mapping[str, Any] | None = None,
) -> Supervisor | CSupervisor:
    """A Supervisor for a spec, or for some of its rules.

    limits: those of the spec (`Limits.of`) with these changed, by name; or `Limits`, which stand for all of them. params and tables
    override the spec's, in declared units; clock gives s on the clock of the cycles' stamps; record is a new file that
    keeps the run. Raises TrackmarshalError D203, D204, E401, E403, E404, E405, E481, E482, E483 or E485; E470 to E473 for what generated C
    cannot do, where it is asked for.
    """
    box = rulebox(Evaluator(spec, rules, backend), params, tables)
    held = limits if isinstance(limits, Limits) else Limits.of(spec, **(limits or {}))
    made = box.running(held, clock)
    if record is not None:
        made.recorder = Record(record, made.contract, made.limits, box.identity)
    return made


def rerun(run: Run, box: Rulebox) -> Iterator[tuple[Decision, list[Difference]]]:
    """The cycles of a record again, at the recorded times: each decision, and where it is not the recorded one."""
    ticks: list[float] = []

    def clock() -> float:
        return ticks.pop(0)

    again = box.running(run.limits, clock)
    for place, recorded in enumerate(run.cycles):
        ticks[:] = recorded.readings
        decision = again.step(recorded.cycle)
        yield decision, differences(place, recorded, decision)


def box_of(run: Run, spec: Spec, backend: str | None = None) -> Rulebox:
    """Rules as those of a record, with another backend where one is given, or the recorded one is none of ours.

    Raises E401 and others for another spec.
    """
    identity = run.identity
    own = str(identity.get("backend"))
    evaluator = Evaluator(spec, identity.get("rules"), backend or (own if own in BACKENDS else BACKENDS[0]))
    return rulebox(evaluator, identity.get("params"), identity.get("tables"))
