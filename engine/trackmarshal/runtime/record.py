"""The record of a run: every cycle as it came in, and what was decided about it, appended before the decision is returned.

An Arrow IPC stream (`arrow.py`), one batch a cycle. Columns by name:

- `row`: how many rows come before it in the file, whatever they are (records of version 2 do not say it);
- `number`, `t`: the cycle's, where they are numbers; `arrived`, `finished`: the clock's readings, NaN where there was none;
- `driving.F`, `emergency.F`, `SIGNAL.F`: what passed the door, in SI, members of enumerations by the places that the head names; borders as `SIGNAL.LINE.x` and `.y`, empty where they are those of
  the row before that has any; `SIGNAL.name`: what the track is called, empty too where it has no name;
- `raw`: JSON of the cycle as it came in, where it did not pass the door; its columns are empty then. `null` stands for no cycle;
- `left_out`: JSON of the columns that the cycle did not have, in which the spec's defaults stand, with the places of the elements of a set that did not, where others did
  (records before version 4 do not say it, those before version 5 not that a track has no name);
- `missed`: how many cycles before this one could not be written (a full disk), or were not decided as their steps were stopped; a row without a `state` is no cycle: it says only that, or has
  in `raw` a part of a snapshot (`snapshots.py`), from which a replay can start;
- the decision: `state`, `safe`, `driven`, `driven_number`, `driven_t`, `lost`, `faults` and `violations` (JSON), `verdicts.CANDIDATE` (a letter a
  rule: s, v, u, i, o) and `margins.CANDIDATE`.
"""

from __future__ import annotations

import json
import math
import os
import struct
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime import declared
from trackmarshal.runtime.arrow import END, FLOAT, FLOATS, INT, TEXT, TEXTS, Column, Layout, layout_of
from trackmarshal.runtime.contract import EVENT, LINES, RECORD, SET, Contract, Signal
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.door.lines import line
from trackmarshal.runtime.door.values import entries, is_a, is_masked, mapping
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.frame import Frame, Packed
from trackmarshal.runtime.lines import Line
from trackmarshal.runtime.members import by_name
from trackmarshal.runtime.saving import Saving
from trackmarshal.runtime.snapshots import EVERY, Parts, Snapshot, Snapshots
from trackmarshal.runtime.stencil import Stencils, letters
from trackmarshal.units import is_si

FORMAT = "trackmarshal-record"
VERSION = 5
#: Of version 2, rows do not say their places; of version 3, not what cycles did not have; of version 4, an empty name of a track is none.
_KNOWN = (2, 3, 4, VERSION)
#: Endings of other formats: what opens a file by its name would find no file of its own under them.
_OTHERS = (".mcap", ".jsonl", ".json", ".csv", ".saa", ".gz", ".zip", ".parquet", ".feather", ".yaml", ".yml")
_ROW: Column = ("row", INT)
_TIMES: tuple[Column, ...] = (
    ("number", INT),
    ("t", FLOAT),
    ("arrived", FLOAT),
    ("finished", FLOAT),
    ("missed", INT),
)
_DECISION: tuple[Column, ...] = (
    ("state", TEXT), ("safe", INT), ("driven", TEXT), ("driven_number", INT), ("driven_t", FLOAT), ("lost", TEXT), ("faults", TEXT),
    ("violations", TEXT), ("verdicts.driving", TEXT), ("verdicts.emergency", TEXT), ("margins.driving", FLOATS), ("margins.emergency", FLOATS),
)  # fmt: skip


class Record:
    """A record that is being written; satisfies `Recorder`. Close it, or let the process die: what was appended stays.

    identity: the judge's. saving: what a replay from the middle needs (`Supervisor.saving`), saved after so many cycles (`every`; 0: never),
    a little of it in each of the next ones; without it, a replay starts at the beginning. sync waits in every cycle until the disk has the data (against a power failure; a process that is killed loses
    nothing either way). Raises E483 where the file cannot be made or is there already, or has the ending of another format.
    """

    def __init__(
        self,
        path: str | Path,
        contract: Contract,
        limits: Limits,
        identity: Mapping[str, Any],
        sync: bool = False,
        saving: Callable[[], Saving] | None = None,
        every: int = EVERY,
    ) -> None:
        _refuse_ending(path)
        self._sync = sync
        self._snapshots = Snapshots(saving, every)
        self._inputs = _inputs(contract)
        #: The same with all numbers of a signal, which stand one after the other, as one part, and how many these are.
        self._parts = [
            (*one, count)
            for one, count in Counter(
                (part, signal, "" if part in ("plan", "column", "number") else field)
                for part, signal, field, _ in self._inputs
            ).items()
        ]
        #: Numbers come in as they are kept: then what passed the door is what came in.
        self._plain = _all_si(contract)
        #: The signals that may name the track.
        self._corridors = [signal for part, signal, *_ in self._inputs if part == "name"]
        #: By candidate and signal, the fields that need not be there.
        self._spare: _Spare = [
            (name, fields)
            for name, signal in _called(contract)
            if (
                fields := tuple((f.name, f"{name}.{f.name}") for f in signal.fields_ if f.default is not None)
            )
        ]
        self._kept: dict[tuple[str, str], Any] = {}
        #: How long the file is up to its last whole row, and cycles since then that have none.
        self._end = 0
        self._missed = 0
        #: How many rows the file has.
        self._rows = 0
        #: How many cycles there were, which the last row says.
        self._cycles = 0
        #: Whether the file may be longer than that.
        self._longer = False
        head = {
            "format": FORMAT,
            "version": VERSION,
            "counted": True,
            "identity": dict(identity),
            "limits": {name: _spelt(value) for name, value in asdict(limits).items()},
        }
        head["inputs"] = [list(one) for one in self._inputs]
        self._layout = Layout(_columns(self._inputs), head)
        # Behind the row, what came in, and what did not.
        places = enumerate(self._inputs, len(_TIMES) + 3)
        self._stencils = Stencils(
            self._layout,
            {at: (part == "plan", signal, field) for at, (part, signal, field, _) in places if part in ("plan", "column", "number")},
            [signal for part, signal, *_ in self._inputs if part == "closed"],
            [signal for part, signal, *_ in self._inputs if part == "event"],
        )  # fmt: skip
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o644)
            self._write(self._layout.schema)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            message = f"the record cannot be made: {reason}"
            raise TrackmarshalError(
                "E483", message, file=str(path), help="records are never overwritten; name a new file"
            ) from error

    def append(
        self, cycle: object, frame: Frame | None, decision: Decision, readings: tuple[float, float]
    ) -> None:
        """One more row. Raises OSError where the disk refuses it; the file then ends with the row before, and the next row that can be
        written says how many are missing."""
        number = -1 if decision.number is None else decision.number
        times = [self._rows, number, decision.t, *readings, self._missed]
        self._missed += 1  # until it is written
        self._cycles += 1
        row: bytes | bytearray = b""
        kept = self._kept
        if frame is not None and self._plain and not decision.faults:
            names = _track_names(cycle, self._corridors)
            left_out = None if names is None else _left_out(cycle, self._spare, names)
            if names is not None and left_out is not None:
                row = self._row(times, left_out, [name or "" for name in names.values()], frame, decision)
            kept = frame.lines if row else kept
        if not row:
            raw = json.dumps(_plain(cycle))
            row = self._layout.batch([*times, raw, "", *_empty(self._inputs), *decided(decision)])
        try:
            self._add(row)
        except OSError:
            self._kept = {}  # whoever reads the next row has no border from this one
            raise
        self._kept, self._missed = kept, 0
        part = self._snapshots.next()
        if part:
            self._beside(part)

    def stopped(self) -> None:
        """A cycle that has no row: what comes behind it rests on it, and nobody knows what would have been decided."""
        self._missed += 1
        self._cycles += 1

    @property
    def snapshot_error(self) -> str:
        """Why the record has no snapshots any more; empty where it has."""
        return self._snapshots.error

    def _beside(self, part: str) -> None:
        """A part of a snapshot, in a row that is no cycle. Where the disk refuses it, that snapshot is none: the cycles are whole."""
        try:
            self._add(self._no_cycle(-1, 0, part))
        except OSError:
            self._snapshots.drop()

    def close(self) -> None:
        """End the stream; nothing can be appended any more."""
        if self._file >= 0:
            for part in self._snapshots.rest():
                self._beside(part)
            self._add(self._no_cycle(self._cycles, self._missed, ""))
            self._write(END)
            os.close(self._file)
            self._file = -1

    def _no_cycle(self, number: int, missed: int, raw: str) -> bytes:
        """A row without a decision."""
        times = [self._rows, number, math.nan, math.nan, math.nan, missed]
        return self._layout.batch([*times, raw, "", *_empty(self._inputs), *_empty_decision()])

    def _add(self, row: bytes | bytearray) -> None:
        self._write(row)
        self._rows += 1

    def _write(self, data: bytes | bytearray) -> None:
        """Write all of it, or nothing: what was written of it is cut off again."""
        if self._longer:
            os.ftruncate(self._file, self._end)  # that could not be done when it was written
        self._longer = True
        view = memoryview(data)
        try:
            while view:
                view = view[os.write(self._file, view) :]
            if self._sync:  # what the disk may not have counts as not written
                os.fsync(self._file)
        except OSError:
            with suppress(OSError):
                os.ftruncate(self._file, self._end)
            raise
        self._end += len(data)
        self._longer = False

    def _row(
        self, times: list[Any], left_out: str, names: list[str], frame: Frame, decision: Decision
    ) -> bytes | bytearray:
        """The row of a cycle that passed the door; empty for one with an id that is no text, which JSON can spell."""

        def whole() -> bytes:
            outcome = decided(decision)
            try:
                return self._layout.batch([*times, "", left_out, *self._passed(frame, names), *outcome])
            except ValueError:
                return b""

        lines, kept = frame.lines, self._kept
        same = lines is kept or all(line is kept.get(place) for place, line in lines.items())
        if not same:
            return whole()
        return self._stencils.row(times, (left_out, *names), frame, decision, _violations(decision), whole)

    def _passed(self, frame: Frame, names: Sequence[str]) -> list[Any]:
        """The columns of what passed the door; names: those of its tracks."""
        passed: list[Any] = []
        named = iter(names)
        candidates, columns = _packed(frame)
        for part, signal, field, fields in self._parts:
            if part in ("plan", "column"):
                count, _, data = (candidates if part == "plan" else columns)[signal]
                width = 8 * count
                passed += [data[i * width : (i + 1) * width] for i in range(fields)]
            elif part == "number":
                passed += struct.unpack(f"<{fields}d", columns[signal].numbers)
            elif part == "ids":
                passed.append(columns[signal].ids)
            elif part in ("x", "y"):
                line = frame.line(signal, field)
                same = line is self._kept.get((signal, field))
                passed.append(b"" if same else line.points[:, 0 if part == "x" else 1])
            elif part == "closed":
                passed.append(int(frame.closed.get(signal, False)))
            elif part == "name":
                passed.append(next(named))
            elif part == "event":
                passed.append(frame.events[signal])
            else:
                raise AssertionError(f"unknown part {part}")
        return passed


_NOTHING = np.zeros(0)


def _track_names(cycle: Any, corridors: Sequence[str]) -> dict[str, str | None] | None:
    """What a cycle which passed the door calls its tracks; None where what was handed in cannot be asked."""
    found: dict[str, str | None] = {}
    try:
        for signal in corridors:
            given = cycle.signals.get(signal)
            name = given.get("name") if is_a(given, Mapping) else None
            found[signal] = None if name is None else str.__str__(name)
    except Exception:  # what was handed in has a say in how it is read
        return None
    return found


#: By candidate or signal, the fields that need not be there, each with its column.
_Spare = list[tuple[str, tuple[tuple[str, str], ...]]]


def _left_out(cycle: Any, spare: _Spare, names: Mapping[str, str | None]) -> str | None:
    """JSON of the columns that a cycle which passed the door does not have, empty for none; each with the places of elements where only some lack
    it. names: of its tracks. None where what was handed in cannot be asked."""
    found: list[_Lacking] = [f"{signal}.name" for signal, name in names.items() if name is None]
    try:
        for name, fields in spare:
            given: Any = (
                cycle.driving
                if name == DRIVING
                else cycle.emergency
                if name == EMERGENCY
                else cycle.signals[name]
            )
            if type(given) is not dict and not is_a(given, Mapping):
                elements = entries(given)
                for field, column in fields:
                    places = tuple([place for place, one in enumerate(elements) if field not in one])
                    if places:
                        found.append(column if len(places) == len(elements) else (column, places))
            else:
                found += [column for field, column in fields if field not in given]
    except Exception:  # what was handed in has a say in how it is read
        return None
    return _listed(tuple(found)) if found else ""


#: A column that a cycle does not have; or that elements at these places do not.
_Lacking = str | tuple[str, tuple[int, ...]]


@lru_cache(maxsize=64)
def _listed(columns: tuple[_Lacking, ...]) -> str:
    return json.dumps(columns)


def _refuse_ending(path: str | Path) -> None:
    """Raise E483 for a name that says that the file is of another format."""
    ending = Path(path).suffix
    if ending.lower() not in _OTHERS:
        return
    name = f"{Path(path).stem.removesuffix('.arrows')}.arrows"
    after = (
        f", from which `trackmarshal replay {name} --mcap FILE` makes MCAP"
        if ending.lower() == ".mcap"
        else ""
    )
    raise TrackmarshalError(
        "E483", f"the record cannot be made: it is a stream of Arrow, and no {ending}", file=str(path),
        help=f"its ending is .arrows: `{name}`{after}",
    )  # fmt: skip


def _packed(frame: Frame) -> tuple[dict[str, Packed], dict[str, Packed]]:
    """Candidates and columns of a frame as memory; where they are in an arena, nothing is made of them for that."""
    if frame.arena is not None:
        driving, emergency, *others = frame.arena.packed()
        return {DRIVING: driving, EMERGENCY: emergency}, dict(zip(frame.arena.shape.called, others))
    candidates, columns = (
        {name: Packed(one.count, one.ids, one.packed()) for name, one in held.items()}
        for held in (frame.candidates, frame.columns)
    )
    return candidates, columns


def decided(decision: Decision) -> list[Any]:
    """A decision as the values of its columns: two decisions are the same when these are, to the bit."""
    driven = decision.driven
    judged = decision.judged
    faults = [[name_of(f), f.code, f.signal, f.field, f.index, f.message] for f in decision.faults]
    rated = [judged.rated[name] for name in (DRIVING, EMERGENCY)] if judged else []
    verdicts = [letters(one.verdicts) for one in rated] or ["", ""]
    margins = [one.margins for one in rated] or [(), ()]
    return [
        decision.state, int(decision.safe), "" if driven is None else driven.candidate, -1 if driven is None else driven.number,
        math.nan if driven is None else driven.t, decision.lost, _dumped(faults), _violations(decision), *verdicts, *margins,
    ]  # fmt: skip


def _violations(decision: Decision) -> str:
    return _dumped([
        {
            "rule": v.rule, "requirements": list(v.requirements), "candidate": v.candidate, "verdict": v.verdict,
            "margin": _spelt(v.margin), "unit": v.unit,
        }
        for v in decision.violations
    ])  # fmt: skip


def _dumped(reasons: list[Any]) -> str:
    return json.dumps(reasons) if reasons else "[]"


def decided_by_name(decision: Decision) -> dict[str, Any]:
    """A decision by the names of its columns."""
    return {name: value for (name, _), value in zip(_DECISION, decided(decision))}


# Reading ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Recorded:
    """One cycle of a record: what came in (None: nothing did), the clock's readings, and the decision as `decided` gives it."""

    cycle: Any
    readings: tuple[float, float]
    decision: list[Any]

    @property
    def by_name(self) -> dict[str, Any]:
        """The decision by the names of its columns."""
        return {name: value for (name, _), value in zip(_DECISION, self.decision)}

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


def is_record(data: bytes) -> bool:
    """Whether these may be the first bytes of a record."""
    return data.startswith(b"\xff\xff\xff\xff")


def read(data: bytes, shown: str) -> Run:
    """All whole cycles of a record; raises D161 where not even its head is whole, D162 for another version."""
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
    if head.get("format") != FORMAT or type(version) is not int or version not in _KNOWN:
        message = f"{head.get('format')!r:.40}, version {version!r:.40}"
        known = ", ".join(map(str, _KNOWN))
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
        if layout.columns != tuple(_columns(inputs, version)):
            raise ValueError("its columns are not those of its inputs")
    except (KeyError, TypeError, ValueError, TrackmarshalError) as error:
        raise TrackmarshalError(
            "D162", "the head of the record lacks what it should say", file=shown, help=str(error)
        ) from error
    cycles: list[Recorded] = []
    end = len(layout.schema)
    kept: dict[tuple[str, str], Any] = {}
    missed = 0
    snapshots = Parts()
    counted: int | None = None
    gone = ""
    places = version > 2
    for place, row in enumerate(layout.rows(data)):
        values = row.values[1:] if places else row.values
        if version < 4:
            values.insert(len(_TIMES) + 1, "")
        if places and row.values[0] != place and not gone:
            gone = f"where row {place} should be, behind {len(cycles)} cycles, is row {row.values[0]}: rows are gone, or not its own"
        try:
            missed += int(values[len(_TIMES) - 1])
            if values[-len(_DECISION)]:
                cycles.append(_recorded(values, inputs, kept, version))
                if members and type(cycles[-1].cycle) is Cycle:
                    by_name(cycles[-1].cycle, members)
            elif not values[len(_TIMES)]:
                counted = int(values[0])
            elif not gone:  # what comes after a gap is of cycles that are counted otherwise
                snapshots.add(values[len(_TIMES)], len(cycles))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            message = f"cycle {len(cycles)} of the record cannot be read: {error}"
            help_ = gone or "it was not written here"
            raise TrackmarshalError("D162", message, file=shown, help=help_) from error
        end = row.end
    rest = data[end:]
    ended = rest == END
    damage = ""
    if not ended and rest and not layout.torn(rest):
        damage = f"behind {len(cycles)} cycles it is damaged: what comes there was not cut off, but changed"
    elif ended and head.get("counted") is True and counted != len(cycles) + missed:
        closed = (
            "does not say after how many it was closed" if counted is None else f"was closed after {counted}"
        )
        damage = f"it has {len(cycles) + missed} cycles, and {closed}: rows are gone, or not its own"
    else:
        damage = gone
    return Run(
        identity, limits, tuple(cycles), ended, 0 if ended else len(rest), missed, tuple(snapshots.whole), damage,
        members, units, shown,
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


def _recorded(
    values: list[Any], inputs: list[_Input], kept: dict[tuple[str, str], Any], version: int
) -> Recorded:
    times, (raw, left_out) = values[: len(_TIMES)], values[len(_TIMES) : len(_TIMES) + 2]
    columns = values[len(_TIMES) + 2 : len(_TIMES) + 2 + len(inputs)]
    lacking = json.loads(left_out) if left_out else ()
    some = [one for one in lacking if type(one) is list]
    if raw:
        cycle = _unplain(json.loads(raw))
    else:
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
        _without(signals, some)
        cycle = Cycle(times[0], times[1], plans[DRIVING], plans[EMERGENCY], signals)
    return Recorded(cycle, (times[2], times[3]), values[-len(_DECISION) :])


def _without(signals: dict[str, Any], some: list[Any]) -> None:
    """Give sets of which only some elements have a field as records, without it where they do not."""
    for column, places in some:
        signal, _, field = column.rpartition(".")
        given = signals[signal]
        if type(given) is dict:
            listed = {name: part if name == "id" else part.tolist() for name, part in given.items()}
            given = signals[signal] = [
                dict(zip(listed, one, strict=True)) for one in zip(*listed.values(), strict=True)
            ]
        for place in places:
            del given[place][field]


# Columns ----------------------------------------------------------------------------------------------------------

#: What an input column is: plan, column, number, ids, x, y, closed, name or event; its signal (or candidate), field, and kind.
_Input = tuple[str, str, str, str]


def _inputs(contract: Contract) -> list[_Input]:
    found: list[_Input] = []
    assert contract.plan is not None
    for candidate in (DRIVING, EMERGENCY):
        found += [("plan", candidate, name, FLOATS) for name in _numbers(contract.plan)]
    for signal in contract.signals:
        if signal.form == LINES:
            found += [(axis, signal.name, line.name, FLOATS) for line in signal.lines for axis in ("x", "y")]
            found += [] if signal.lines[0].name == "" else [("closed", signal.name, "closed", INT)]
        elif signal.form == RECORD:
            found += [("number", signal.name, name, FLOAT) for name in _numbers(signal)]
        elif signal.form != EVENT:
            found += [("ids", signal.name, "id", TEXTS)] if signal.form == SET else []
            found += [("column", signal.name, name, FLOATS) for name in _numbers(signal)]
    found += [
        ("name", signal, "name", TEXT) for signal in contract.corridors
    ]  # also where no rule reads its borders
    return found + [("event", signal.name, "", INT) for signal in contract.signals if signal.form == EVENT]


def _called(contract: Contract) -> list[tuple[str, Signal]]:
    """All that a cycle has, by what it is called there: both candidates, and the signals."""
    assert contract.plan is not None
    plans = [(name, contract.plan) for name in (DRIVING, EMERGENCY)]
    return plans + [(signal.name, signal) for signal in contract.signals]


def _numbers(signal: Signal) -> list[str]:
    return [field.name for field in signal.numbers]


def _all_si(contract: Contract) -> bool:
    """Whether all fields are numbers in SI units, or borders of the road; anything else, lanes too, is kept as it came in, in `raw`."""
    assert contract.plan is not None
    fields = [(s, f) for s in (contract.plan, *contract.signals) if s.form != EVENT for f in s.fields_]
    return all(
        signal.form == LINES if field.kind == "polyline" else field.kind == "number" and is_si(field.unit)
        for signal, field in fields
    )


def _columns(inputs: list[_Input], version: int = VERSION) -> list[Column]:
    """All columns of a record of a version."""
    return [
        *([_ROW] if version > 2 else []),
        *_TIMES,
        ("raw", TEXT),
        *([("left_out", TEXT)] if version > 3 else []),
        *((_name(one), one[3]) for one in inputs),
        *_DECISION,
    ]


def _name(one: _Input) -> str:
    part, signal, field, _ = one
    return ".".join(filter(None, (signal, field, part if part in ("x", "y") else "")))


def _empty(inputs: list[_Input]) -> list[Any]:
    empty: dict[str, Any] = {FLOATS: _NOTHING, TEXT: "", TEXTS: (), FLOAT: math.nan, INT: -1}
    return [empty[kind] for *_, kind in inputs]


def _empty_decision() -> list[Any]:
    empty: dict[str, Any] = {FLOATS: _NOTHING, TEXT: "", FLOAT: math.nan, INT: -1}
    return [empty[kind] for _, kind in _DECISION]


# What did not pass the door -----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Opaque:
    """Stands for something that JSON has no word for."""

    kind: str


def _spelt(value: Any) -> Any:
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def _plain(value: Any, depth: int = 0) -> Any:
    """Anything as strict JSON data: what JSON does not have is {"$": kind, ...}. What the door takes comes back as what it takes alike."""
    kind = type(value)
    if value is None or kind in (bool, str):
        return value
    if isinstance(value, str):  # whatever is derived from it is taken as the text that it is
        return str.__str__(value)
    if is_a(value, int) and kind is not bool:
        whole = int.__pos__(value)
        return whole if abs(whole) < 2**63 else {"$": "int", "of": hex(whole)}
    if is_a(value, (float, np.floating)):
        number = float.__pos__(value) if is_a(value, float) else float(value)
        if not math.isfinite(number):
            return {"$": str(number)}
        # Of a length, a short one may have lost what a float of the same number has: the door asks.
        short = is_a(value, np.floating) and value.dtype.itemsize < 8
        return {"$": "scalar", "type": value.dtype.str, "of": number} if short else number
    if (
        isinstance(value, np.bool_ | np.integer) and value.dtype.kind in "biu"
    ):  # spans of time are whole numbers to numpy
        return {"$": "scalar", "type": value.dtype.str, "of": value.item()}
    if depth < 8:
        try:
            return _composed(value, depth + 1)
        except Exception:  # what was handed in has a say in how it is read
            pass
    return {"$": "opaque", "kind": kind.__name__}


def _composed(value: Any, depth: int) -> Any:
    """The same of what is made of others."""
    kind = type(value)
    if is_a(value, Cycle):
        given = [getattr(value, name, None) for name in _CYCLE] + [sorted(value.also)]
        return {"$": "cycle", "of": [_plain(item, depth) for item in given]}
    if is_a(value, Mapping):
        held = mapping(value)
        pairs = [(key, _plain(item, depth)) for key, item in held.items()]
        if all(type(key) is str for key in held) and "$" not in held:
            return dict(pairs)
        return {"$": "dict", "of": [(_plain(key, depth), item) for key, item in pairs]}
    if kind is Line:
        return {"$": "line", "of": value.points.tolist()}
    if is_a(value, (list, tuple)):
        items = [_plain(item, depth) for item in entries(value)]
        return items if is_a(value, list) else {"$": "tuple", "of": items}
    if is_masked(value):
        parts = [_plain(part, depth) for part in (np.ma.getdata(value), np.ma.getmaskarray(value))]
        return {"$": "masked", "of": parts}
    if kind in (np.ndarray, np.memmap) and value.dtype.kind in "iufbU":
        wide = value.dtype.itemsize > 8 and value.dtype.kind != "U"
        array = value.astype(np.float64) if wide else value
        items = _plain(array.ravel().tolist(), depth)
        return {"$": "array", "type": array.dtype.str, "shape": array.shape, "of": items}
    if kind is np.ndarray and value.dtype == object:
        items = [_plain(item, depth) for item in value.ravel().tolist()]
        return {"$": "objects", "shape": value.shape, "of": items}
    return {"$": "opaque", "kind": kind.__name__}


_CYCLE = ("number", "t", "driving", "emergency", "signals")


def _unplain(value: Any) -> Any:
    if type(value) is list:
        return [_unplain(item) for item in value]
    if type(value) is not dict:
        return value
    kind = value.get("$")
    of: Any = value.get("of")
    match kind:
        case None:
            return {key: _unplain(item) for key, item in value.items()}
        case "nan" | "inf" | "-inf":
            return float(kind)
        case "int":
            return int(of, 16)
        case "cycle":
            number, t, driving, emergency, signals = (_unplain(item) for item in of[:-1])
            return Cycle(number, t, driving, emergency, signals, frozenset(of[-1]))
        case "dict":
            return {_unplain(key): _unplain(item) for key, item in of}
        case "line":
            return line(np.array(of, dtype=np.float64).reshape(-1, 2))
        case "tuple":
            return tuple(_unplain(item) for item in of)
        case "array":
            return np.array(_unplain(of), dtype=value["type"]).reshape(value["shape"])
        case "masked":
            data, mask = (_unplain(part) for part in of)
            return np.ma.MaskedArray(data, mask)
        case "objects":
            held = np.empty(len(of), dtype=object)
            held[:] = [_unplain(item) for item in of]
            return held.reshape(value["shape"])
        case "scalar":
            return np.dtype(value["type"]).type(of)
        case "opaque":
            return Opaque(value["kind"])
        case _:
            raise ValueError(f"unknown kind {kind!r:.40}")


# Running it again -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Difference:
    """A cycle (its place in the record) whose decision is another one now: which column, what was and what is."""

    place: int
    t: float
    column: str
    recorded: Any
    now: Any


def differences(place: int, recorded: Recorded, decision: Decision) -> list[Difference]:
    """Where a decision is not bit for bit the recorded one."""
    return [
        Difference(place, decision.t, name, old, new)
        for (name, kind), old, new in zip(_DECISION, recorded.decision, decided(decision))
        if _bits(kind, old) != _bits(kind, new)
    ]


def _bits(kind: str, value: Any) -> Any:
    return np.asarray(value, dtype="<f8").tobytes() if kind in (FLOAT, FLOATS) else value
