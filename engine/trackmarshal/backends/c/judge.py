"""Generated C in a Supervisor: its door and its rules in one call a cycle. Python looks closer only at what C refuses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from trackmarshal.backends.c.door import LIMITS
from trackmarshal.backends.c.places import sources
from trackmarshal.backends.c.program import CProgram
from trackmarshal.backends.c.step import Stepper
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.case import Case, Fault
from trackmarshal.runtime.columns import scaling
from trackmarshal.runtime.contract import EGO, contract_of
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.door import Door, Pose
from trackmarshal.runtime.judge import Judged
from trackmarshal.runtime.plan import Plan


class SteppedDoor(Door):
    """The generated door, and behind it, for what it refuses, the one in Python, which finds every fault and not just the first.

    A cycle passes when C lets it pass. Raises TrackmarshalError E470 to E473 for what generated C cannot do,
    ValueError for a spec whose signals are not all in SI units.
    """

    def __init__(
        self, spec: Spec, rules: Sequence[RuleInfo], limits: Limits, settings: Case | None = None
    ) -> None:
        super().__init__(contract_of(spec, rules), limits)
        for signal in (self.contract.plan, *self.contract.shared):
            for kind in signal.fields_:
                if kind.kind == "number" and scaling(kind) is not None:
                    raise ValueError(f"`{signal.name}.{kind.name}` is not in an SI unit")
        program = CProgram(spec, rules, doored=True)
        given = asdict(limits)
        self.stepper = Stepper(
            program, limits.samples, limits.elements, limits.border, settings, **{name: given[name] for name, _, _ in LIMITS}
        )  # fmt: skip
        #: What the program's borders and lines were last set to.
        self._placed: dict[str, Any] = dict.fromkeys(sources(program.source.plan))

    def check(self, cycle: Cycle, now: float) -> tuple[list[Fault], Pose | None]:
        refused: list[Fault] = []
        shown = type(cycle.number) is int and type(cycle.t) is float and type(cycle.signals) is dict
        if shown:
            signals = self._in_columns(cycle.signals, refused)
            self._place(signals, refused)
            self._name(signals, refused)
            fault = self.stepper.step(cycle.number, cycle.t, now, cycle.driving, cycle.emergency, signals)
            if fault is not None:
                refused.append(fault)
            if not refused:
                self._number, self._stamp = cycle.number, cycle.t
                return [], self._seen(cycle)
        stamp = self._stamp
        faults, pose = super().check(cycle, now)
        if not shown and self._stamp != stamp and self._number is not None:
            self.stepper.refuse(self._number, self._stamp)
        return faults or refused, pose

    def plans(self, cycle: Cycle) -> tuple[Plan, Plan]:
        t = float(cycle.t)
        driving, emergency = (
            Plan(name, cycle.number, t, *self.stepper.candidate(side))
            for side, name in enumerate((DRIVING, EMERGENCY))
        )
        return driving, emergency

    def hold(self, cycle: Cycle) -> None:
        faults: list[Fault] = []
        self.driving.fill(cycle.driving, faults)
        self.emergency.fill(cycle.emergency, faults)
        self._fill_shared(cycle.signals, faults)
        if faults:
            raise ValueError(f"the two doors do not agree: {faults[0]}")

    def _in_columns(self, signals: dict[str, Any], faults: list[Fault]) -> Mapping[str, Any]:
        """The signals, sets that came as records put in columns; this takes longer than columns do."""
        made: dict[str, dict[str, Any]] = {}
        for name, block in self._blocks.items():
            given = signals.get(name)
            if block.many and type(given) in (list, tuple):
                before = len(faults)
                block.fill(given, faults)
                if len(faults) == before:
                    columns = block.view().columns.items()
                    made[name] = {field: c.astype(bool) if c.dtype == np.int8 else c for field, c in columns}
                    made[name]["id"] = list(block.ids)
        return {**signals, **made} if made else signals

    def _place(self, signals: Mapping[str, Any], faults: list[Fault]) -> None:
        """Borders and lines, where they have changed."""
        for name, borders in self._borders.items():
            self._fill_borders(name, borders, signals.get(name), faults)
            if faults or name not in self._placed:
                continue
            lines: list[Any] = [
                borders[line].points for line in (("",) if "" in borders else ("left", "right"))
            ]
            content = (*map(id, lines), self.closed[name])
            kept = self._placed[name]
            if kept is None or kept[0] != content:
                self._placed[name] = None
                left, right = lines[0], lines[-1] if len(lines) > 1 else ()
                fault = self.stepper.track(name, left, right, self.closed[name])
                if fault is not None:
                    faults.append(fault)
                else:
                    self._placed[name] = (content, lines)  # the arrays, so that their ids stay theirs

    def _name(self, signals: Mapping[str, Any], faults: list[Fault]) -> None:
        """Ids of the elements of sets: these are Python's business."""
        for name, block in self._blocks.items():
            given = signals.get(name)
            if block.many and type(given) is dict and "id" in given:
                block.take_ids(given["id"], {}, faults)

    @staticmethod
    def _seen(cycle: Cycle) -> Pose:
        ego = cycle.signals[EGO]
        x, y, heading = (float(ego[name]) for name in ("x", "y", "heading"))
        return Pose(cycle.t - float(ego.get("age", 0.0)), x, y, heading)


class SteppedJudge:
    """The verdicts of the cycle that a SteppedDoor has let pass. They come without witnesses: these take longer than a cycle has."""

    def __init__(self, rules: Sequence[RuleInfo], identity: Mapping[str, Any]) -> None:
        self.rules, self.identity = rules, identity

    def judge(self, door: Door) -> tuple[Judged, Judged]:
        if not isinstance(door, SteppedDoor):
            raise TypeError("the generated rules go with the generated door")
        verdicts, margins = door.stepper.verdicts, door.stepper.margins.copy()
        return Judged(verdicts[0].tobytes(), margins[0]), Judged(verdicts[1].tobytes(), margins[1])
