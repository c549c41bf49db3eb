"""Supervisors out of specs, and records of their runs again."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.errors import TrackmarshalError, wrong_type
from trackmarshal.evaluation import BACKENDS, Evaluator, broken_constraints
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime import declared
from trackmarshal.runtime.contract import of_cycles
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.frame import NO_SETTINGS, Settings
from trackmarshal.runtime.record import Record
from trackmarshal.runtime.record.decided import Difference, differences
from trackmarshal.runtime.record.reading import Run
from trackmarshal.runtime.record.snapshots import EVERY, Snapshot
from trackmarshal.runtime.saving import damaged
from trackmarshal.runtime.settings import as_plain
from trackmarshal.runtime.supervisor import Supervisor

if TYPE_CHECKING:
    from trackmarshal.backends.c.supervisor import CSupervisor
    from trackmarshal.runtime.contract import Contract


@dataclass(frozen=True)
class Rulebox:
    """Rules ready to supervise by: an evaluator, the values in force, and both in words for the record."""

    evaluator: Evaluator
    settings: Settings
    identity: Mapping[str, Any]

    def supervisor(
        self, limits: Limits | None = None, clock: Callable[[], float] = time.monotonic
    ) -> Supervisor:
        """A Supervisor for one run, in Python, whatever judges; raises E403 where limits break a constraint of the spec."""
        evaluator = self.evaluator
        held, settings = self._in_force(limits)
        return Supervisor(evaluator.spec, evaluator.program, held, clock, settings, self._contract)

    def _in_force(self, limits: Limits | None) -> tuple[Limits, Settings]:
        spec = self.evaluator.spec
        held = limits_with(spec, {}, self.settings) if limits is None else limits
        return held, with_limits(spec, held, self.settings)

    @property
    def open_loop(self) -> Limits:
        """The limits of recordings (`Limits.open_loop`), with the values in force."""
        return Limits.open_loop(self.evaluator.spec, self.settings.params)

    @cached_property
    def _contract(self) -> Contract:
        return of_cycles(self.evaluator.spec, self.evaluator.program.rules)

    def running(
        self, limits: Limits | None = None, clock: Callable[[], float] = time.monotonic
    ) -> Supervisor | CSupervisor:
        """The Supervisor that drives along: all of it generated C where C is asked for; raises E403 as `supervisor`."""
        if self.evaluator.asked != "c":
            return self.supervisor(limits, clock)
        from trackmarshal.backends.c.supervisor import CSupervisor

        held, settings = self._in_force(limits)
        return CSupervisor(self.evaluator.spec, self.evaluator.rules, held, clock, settings)


def rulebox(
    evaluator: Evaluator, params: Mapping[str, float] | None = None, tables: Mapping[str, Any] | None = None
) -> Rulebox:
    """An evaluator's rules with parameters and tables in declared units; raises E403 where they break a constraint."""
    given = {"params": dict(params or {}), "tables": dict(tables or {})}
    settings = evaluator.reader.settings(given)
    if settings.broken:
        raise TrackmarshalError("E403", settings.broken[0], help="change the parameters")
    spec = evaluator.spec
    own = evaluator.identity
    units = [*own["units"], *declared.listed(declared.units_of_values(spec, **given))]
    return Rulebox(evaluator, settings, {**own, **as_plain(given), "units": units})


def limits_with(spec: Spec, changes: Mapping[str, Any], settings: Settings = NO_SETTINGS) -> Limits:
    """The limits that a spec declares, as parameters in settings have them, with some changed by name; raises E481 or E485, and E403 where
    they break a constraint of the spec."""
    given = Limits.given(spec, settings.params)
    held = Limits.of(spec, **{**given, **changes})
    for name, value in given.items():
        if getattr(held, name) != value:
            raise TrackmarshalError(
                "E481",
                f"the limit `{name}` is {changes[name]!r:.40}, and {value!r} by the parameter that declares it",
                help="give one of them, or both alike",
            )
    with_limits(spec, held, settings, named=changes)
    return held


def with_limits(spec: Spec, limits: Limits, settings: Settings, named: Container[str] = ()) -> Settings:
    """Settings in which the parameters that declare limits are those limits; raises E403 where they break a constraint of the spec.

    An infinite limit is none (`Limits.open_loop`), but where it is one of `named`: then it is held like any other.
    """
    values = {name: settings.params.get(name, info.value) for name, info in spec.params.items()}
    others = {
        name: value
        for name, value in limits.declared(spec).items()
        if value != values[name] and (value < math.inf or name.rpartition(".")[2] in named)
    }
    if not others:
        return settings
    found = replace(settings, params={**settings.params, **others})
    broken = broken_constraints(spec, found)
    if broken:
        raise TrackmarshalError("E403", broken[0], help="change the limits, or the parameters with them")
    return found


def supervisor(
    spec: Spec,
    rules: Sequence[str] | None = None,
    backend: str = "numpy",
    limits: Limits | Mapping[str, Any] | None = None,
    clock: Callable[[], float] = time.monotonic,
    record: str | Path | None = None,
    params: Mapping[str, float] | None = None,
    tables: Mapping[str, Any] | None = None,
    snapshots: int = EVERY,
) -> Supervisor | CSupervisor:
    """A Supervisor for a spec, or for some of its rules.

    limits: those of the spec (`Limits.of`) with these changed, by name; or `Limits`, which stand for all of them. params and tables
    override the spec's, in declared units; clock gives s on the clock of the cycles' stamps; record is a new file that
    keeps the run, and snapshots after how many cycles it also keeps what a replay from the middle starts with (0: never). Raises TrackmarshalError D203, D204, E401, E403, E404, E405, E481, E482, E483 or E485; E470 to E473 for what generated C
    cannot do, where it is asked for.
    """
    for name, values in (("params", params), ("tables", tables)):
        if values is not None and not isinstance(values, Mapping):
            raise wrong_type(f"`{name}` are values by name", values)
    if limits is not None and not isinstance(limits, Limits | Mapping):
        raise wrong_type("`limits` are `Limits`, or values by name", limits)
    if not callable(clock):
        raise wrong_type("`clock` is a function that gives seconds", clock)
    if record is not None and not isinstance(record, str | Path):
        raise wrong_type("`record` is the path of a file", record)
    box = rulebox(Evaluator(spec, rules, backend), params, tables)
    held = limits if isinstance(limits, Limits) else limits_with(spec, limits or {}, box.settings)
    made = box.running(held, clock)
    if record is not None:
        if snapshots:
            with suppress(TrackmarshalError):  # the first one says why there is none
                made.saving()  # what it is of is worked out now, and not in a step
        made.recorder = Record(
            record, made.contract, made.limits, box.identity, saving=made.saving, every=snapshots
        )
    return made


def rerun(
    run: Run, box: Rulebox, begin: Snapshot | None = None
) -> Iterator[tuple[Decision, list[Difference]]]:
    """The cycles of a record again, at the recorded times: each decision, and where it is not the recorded one.

    begin: a snapshot of the record, after whose cycles it begins (`nearest`). Where the run went on from one, so does this. Raises TrackmarshalError
    D163, D164 or E486 where one of these cannot be used.
    """
    ticks: list[float] = []

    def clock() -> float:
        return ticks.pop(0)

    again = box.running(run.limits, clock)
    first, went_on = 0, run.restored
    if begin is not None:
        again.restore(begin.lines())
        first = begin.after
    for place, recorded in enumerate(run.cycles[first:], first):
        if place in went_on:
            _go_on(again, went_on[place], run.source)
        ticks[:] = recorded.readings
        decision = again.step(recorded.cycle)
        yield decision, differences(place, recorded, decision)


def _go_on(again: Supervisor | CSupervisor, begin: Snapshot, shown: str) -> None:
    """Go on from where the run did; without it, other decisions would say nothing of the run. Raises TrackmarshalError D163, D164 or E486."""
    try:
        again.restore(begin.lines(), shown)
    except ValueError as error:
        raise damaged(str(error), shown) from error
    except TrackmarshalError as error:
        error.file = error.file or shown
        error.help = "the run went on from it: replay it with the evaluator that wrote it, and the spec and values of the run"
        raise


def nearest(run: Run, box: Rulebox, place: int) -> tuple[Snapshot | None, TrackmarshalError | None]:
    """The last snapshot of a record by a place in it that can be used, None where the replay has to start at the beginning; and why
    the first one that was looked at cannot."""
    refused: TrackmarshalError | None = None
    for one in reversed(run.snapshots):
        if one.after > place:
            continue
        try:
            box.running(run.limits).restore(one.lines())
        except ValueError as error:
            refused = refused or damaged(str(error))
        except TrackmarshalError as error:
            if error.code not in ("D163", "D164", "E486"):
                raise
            refused = refused or error
            if error.code != "D163":
                break  # the others are no more of these rules than this one
        else:
            return one, refused
    return None, refused


def box_of(run: Run, spec: Spec, backend: str | None = None) -> Rulebox:
    """Rules as those of a record, with another backend where one is given, or the recorded one is none of ours.

    Raises E401 and others for another spec, and D162 where numbers of the record would be taken in its units, or for places of its members.
    """
    identity = run.identity
    own = str(identity.get("backend"))
    try:
        evaluator = Evaluator(
            spec, identity.get("rules"), backend or (own if own in BACKENDS else BACKENDS[0])
        )
    except TrackmarshalError as error:
        if error.file is None:  # of a rule that nobody named here but the record
            error.file = run.source or None
        raise
    declared.check_numbers(run, spec, of_cycles(spec, evaluator.rules))
    return rulebox(evaluator, identity.get("params"), identity.get("tables"))
