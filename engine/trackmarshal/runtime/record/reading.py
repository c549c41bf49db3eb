"""Records read: the cycles of a run as they came in, and what was decided in them."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime import declared
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.record.arrow import END, Layout, layout_of
from trackmarshal.runtime.record.columns import DECISION, FORMAT, KNOWN, TIMES, Input, columns_of
from trackmarshal.runtime.record.left_out import without
from trackmarshal.runtime.record.members import by_name
from trackmarshal.runtime.record.raw import unplain
from trackmarshal.runtime.record.snapshots import Parts, Snapshot

#: The borders that the rows before have, by signal and line with its axis.
_Borders = dict[tuple[str, str], Any]


@dataclass(frozen=True, slots=True)
class Recorded:
    """One cycle of a record: what came in (None: nothing did), the clock's readings, and the decision as `decided` gives it."""

    cycle: Any
    readings: tuple[float, float]
    decision: list[Any]

    @property
    def by_name(self) -> dict[str, Any]:
        """The decision by the names of its columns."""
        return {name: value for (name, _), value in zip(DECISION, self.decision)}

    def value(self, column: str) -> Any:
        """A value of the decision by its column."""
        return self.by_name[column]


@dataclass(frozen=True, slots=True)
class Run:
    """A record that was read. ended: whether it was closed; rest: bytes behind the last whole cycle; missed: cycles that could not be
    written; snapshots: the whole ones, in order; damage: what is gone from it or changed in it, in words, empty for nothing.

    members: those of the enumerations of then, which its cycles have by name; units: those in which its numbers are; None where it does not
    say them. source: its path."""

    identity: dict[str, Any]
    limits: Limits
    cycles: tuple[Recorded, ...]
    ended: bool
    rest: int
    missed: int = 0
    snapshots: tuple[Snapshot, ...] = ()
    damage: str = ""
    members: declared.Members | None = None
    units: declared.Units | None = None
    source: str = ""

    def other_spec(self, spec: Spec) -> str:
        """What is said where the spec at hand is not that of the run; empty where it is."""
        if self.identity.get("fingerprint") == spec.fingerprint:
            return ""
        return "another spec was in force than the one given here; its decisions may differ"

    @property
    def restored(self) -> dict[int, Snapshot]:
        """Where the run went on from, by how many of its cycles came before; of several in one place, the last one."""
        return {one.after: one for one in self.snapshots if one.restored}

    @property
    def went_on(self) -> str:
        """What is said where the run went on from where another one was saved; empty where it did not."""
        places = ", ".join(map(str, self.restored))
        return places and f"before cycle {places} it went on from where another run had been saved"


def is_record(data: bytes) -> bool:
    """Whether these may be the first bytes of a record."""
    return data.startswith(b"\xff\xff\xff\xff")


def _head(data: bytes, shown: str) -> tuple[Layout, dict[str, Any], list[Input], Run]:
    """The layout of a record, its head and input columns, and the run without its cycles; raises D161 and D162."""
    found = layout_of(data)
    if found is None:
        raise TrackmarshalError(
            "D161",
            "the head of the record is damaged or cut off",
            file=shown,
            help="nothing can be read from it",
        )
    layout, head = found
    version = head.get("version")
    if head.get("format") != FORMAT or type(version) is not int or version not in KNOWN:
        message = f"{head.get('format')!r:.40}, version {version!r:.40}"
        known = ", ".join(map(str, KNOWN))
        raise TrackmarshalError("D162", message, file=shown, help=f"known is {FORMAT}, version {known}")
    try:
        given: dict[str, Any] = {n: float(v) if isinstance(v, str) else v for n, v in head["limits"].items()}
        limits = Limits(**given)
        identity = _identity(head["identity"])
        inputs = [
            (str(part), str(signal), str(field), str(kind)) for part, signal, field, kind in head["inputs"]
        ]
        members = declared.unlisted_members(identity.get("members"))
        units = declared.unlisted(identity.get("units"))
        if layout.columns != tuple(columns_of(inputs, version)):
            raise ValueError("its columns are not those of its inputs")
    except (KeyError, TypeError, ValueError, TrackmarshalError) as error:
        raise TrackmarshalError(
            "D162", "the head of the record lacks what it should say", file=shown, help=str(error)
        ) from error
    run = Run(identity, limits, (), False, 0, members=members, units=units, source=shown)
    return layout, head, inputs, run


def read(data: bytes, shown: str) -> Run:
    """All whole cycles of a record; raises D161 where not even its head is whole, D162 for another version."""
    layout, head, inputs, run = _head(data, shown)
    version: int = head["version"]
    cycles: list[Recorded] = []
    end = len(layout.schema)
    kept: _Borders = {}
    missed = 0
    snapshots = Parts()
    counted: int | None = None
    gone = ""
    places = version > 2
    for place, row in enumerate(layout.rows(data)):
        values = row.values[1:] if places else row.values
        if version < 4:
            values.insert(len(TIMES) + 1, "")
        if places and row.values[0] != place and not gone:
            gone = f"where row {place} should be, behind {len(cycles)} cycles, is row {row.values[0]}: rows are gone, or not its own"
        try:
            missed += int(values[len(TIMES) - 1])
            if values[-len(DECISION)]:
                cycles.append(_recorded(values, inputs, kept, version))
                if run.members and type(cycles[-1].cycle) is Cycle:
                    by_name(cycles[-1].cycle, run.members)
            elif not values[len(TIMES)]:
                counted = int(values[0])
            elif not gone:  # what comes after a gap is of cycles that are counted otherwise
                snapshots.add(values[len(TIMES)], len(cycles))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            message = f"cycle {len(cycles)} of the record cannot be read: {error}"
            help_ = gone or "it was not written here"
            raise TrackmarshalError("D162", message, file=shown, help=help_) from error
        end = row.end
    rest = data[end:]
    ended = rest == END
    if not ended and rest and not layout.torn(rest):
        damage = f"behind {len(cycles)} cycles it is damaged: what comes there was not cut off, but changed"
    elif ended and head.get("counted") is True and counted != len(cycles) + missed:
        closed = (
            "does not say after how many it was closed" if counted is None else f"was closed after {counted}"
        )
        damage = f"it has {len(cycles) + missed} cycles, and {closed}: rows are gone, or not its own"
    else:
        damage = gone
    return replace(
        run, cycles=tuple(cycles), ended=ended, rest=0 if ended else len(rest), missed=missed,
        snapshots=tuple(snapshots.whole), damage=damage,
    )  # fmt: skip


def _identity(given: Any) -> dict[str, Any]:
    """What a judge is made of again; raises ValueError for another shape."""
    shapes = {"fingerprint": str, "backend": str, "rules": list, "params": dict, "tables": dict}
    if type(given) is not dict or any(
        name in given and type(given[name]) is not s for name, s in shapes.items()
    ):
        raise ValueError("its judge is not described as one")
    if any(type(rule) is not str for rule in given.get("rules", [])):
        raise ValueError("its rules are no names")
    return given


def _recorded(values: list[Any], inputs: list[Input], kept: _Borders, version: int) -> Recorded:
    """A row as what it says; borders that it does not have are those that are kept."""
    times, (raw, left_out) = values[: len(TIMES)], values[len(TIMES) : len(TIMES) + 2]
    columns = values[len(TIMES) + 2 : len(TIMES) + 2 + len(inputs)]
    if raw:
        cycle = unplain(json.loads(raw))
    else:
        lacking = json.loads(left_out) if left_out else []
        candidates, signals = _passed(columns, inputs, lacking, kept, version)
        cycle = Cycle(times[0], times[1], candidates[DRIVING], candidates[EMERGENCY], signals)
    return Recorded(cycle, (times[2], times[3]), values[-len(DECISION) :])


def _passed(
    columns: list[Any], inputs: list[Input], lacking: list[Any], kept: _Borders, version: int
) -> tuple[dict[str, dict[str, Any]], dict[str, Any]]:
    """Candidates and signals of a cycle that passed the door; lacking: what it did not have."""
    plans: dict[str, dict[str, Any]] = {DRIVING: {}, EMERGENCY: {}}
    signals: dict[str, Any] = {}
    for (part, signal, field, _), value in zip(inputs, columns):
        if f"{signal}.{field}" in lacking:
            if part not in ("plan", "name"):
                signals.setdefault(signal, {})
        elif part == "plan":
            plans[signal][field] = value
        elif part == "event":
            signals[signal] = bool(value)
        elif part in ("x", "y"):
            if len(value):
                kept[signal, f"{field}.{part}"] = value
            if part == "y":
                points = np.column_stack([kept[signal, f"{field}.x"], kept[signal, f"{field}.y"]])
                if field:
                    signals.setdefault(signal, {})[field] = points
                else:
                    signals[signal] = points
        elif part == "closed":
            signals.setdefault(signal, {})["closed"] = bool(value)
        elif part == "name":
            if value or version > 4:
                signals.setdefault(signal, {})["name"] = value
        else:
            signals.setdefault(signal, {})["id" if part == "ids" else field] = value
    without(signals, [one for one in lacking if type(one) is list])
    return plans, signals
