"""Cycles in SI, as arrays, straight into a Supervisor in C: no adapter in between."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from trackmarshal.backends.c.said import Said
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.backends.c.step import Stepper
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.door.lines import line
from trackmarshal.runtime.frame import Columns, Names

#: Limits that tests begin with. Capacities are those that hold by default, so that programs are those of other tests.
LIMITS: Mapping[str, float] = {
    "samples": 128, "elements": 32, "border": 2048, "rate": 50, "shortest_gap": 0.001, "longest_gap": 0.15, "oldest": 0.1, "clock_tolerance": 0.01,
    "budget": 0.05, "start_distance": 0.1, "start_turn": 0.05, "start_speed": 0.5, "rest_speed": 0.01, "apart": 4.0, "beside": 1.5, "turned": 0.35, "overspeed": 5.0,
    "blind": 0.5,
}  # fmt: skip


def program(spec: Spec) -> Source:
    """The whole Supervisor of a spec."""
    return generate(spec, [rule for rule in spec.rules if rule.formula is not None], doored=True)


class Driver:
    """A Supervisor in C and the clock that it reads: `took` after the arrival of each cycle."""

    def __init__(self, source: Source, make: Callable[..., Stepper] = Stepper, **limits: float) -> None:
        self.source = source
        self.now, self.took = 0.0, 0.01
        self.made = make(source, {**LIMITS, **limits}, lambda: self.now + self.took)
        self._defaults = {
            name: {info.name: info.default for info, _ in item.fields}
            for name, item in source.plan.inputs.items()
        }

    def step(self, given: Cycle | None, now: float, **more: Any) -> Said:
        """A cycle of `support.cycles`, None for one that did not come; a signal that is not there is missing."""
        self.now = now
        if given is None:
            return self.made.none_came(now)
        columns = [self._entry("plan", given.driving), self._entry("plan", given.emergency)]
        columns += [self._entry(name, given.signals.get(name)) for name in self.made.words.columns[2:]]
        lines = [
            line(np.asarray(given.signals[signal][side], dtype=float))
            for signal, side in self.made.words.lines
        ]
        closed = [bool(given.signals[signal].get("closed", False)) for signal in self.made.words.closed]
        events = [int(given.signals[name]) for name in self.made.words.events]
        return self.made.step(given.number, given.t, now, columns, lines, closed, events, **more)

    def _entry(self, name: str, data: Any) -> Columns | None:
        if data is None:
            return None
        defaults = self._defaults[name]
        count = np.size(data["x"])
        columns = [
            np.full(count, default)
            if data.get(field) is None
            else np.atleast_1d(np.asarray(data[field], dtype=float))
            for field, default in defaults.items()
        ]
        return Columns(Names(tuple(defaults)), np.array(columns), None, tuple(data.get("id", ())))
