"""Arrays of many cases through the same door: each signal is read, and checked, once for all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.contract import RECORD, SET, TIMELINE, Signal
from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.cases import CasesReader
from trackmarshal.runtime.door.columns import NAMELESS, ColumnsReader
from trackmarshal.runtime.door.stacked import Stacked
from trackmarshal.runtime.door.values import WrongTypeError
from trackmarshal.runtime.faults import Fault, fault, name_of
from trackmarshal.runtime.frame import Columns, Frame, Settings


@dataclass(frozen=True, slots=True)
class _Stack:
    """A signal of all cases: values (cases, numbers, count) and flags (cases, flags, count), and what all have in common."""

    common: Columns
    values: NDArray[np.float64]
    flags: NDArray[np.int8] | None
    ids: tuple[str, ...]
    #: What is wrong with a case that its numbers do not say, by case.
    faults: Mapping[int, list[Fault]]

    @property
    def count(self) -> int:
        return int(self.values.shape[2])


class Arrays:
    """Cases that have been read: `size` of them, as frames when they are asked for."""

    def __init__(
        self, cases: CasesReader, size: int, settings: list[Settings], template: Frame, stacks: Mapping[str, _Stack],
        events: Mapping[str, NDArray[np.int8]],
    ) -> None:  # fmt: skip
        self.size = size
        self._cases, self._settings, self._template, self._stacks, self._events = (
            cases, settings, template, stacks, events,
        )  # fmt: skip
        self._passed = self._shared()
        self._records = {s.name for s in cases.contract.signals if s.form == RECORD}

    def frames(self, start: int, stop: int) -> list[Frame]:
        """The cases from start to before stop, checked; their ids are their numbers."""
        parts = {
            name: (s.values[start:stop], None if s.flags is None else s.flags[start:stop])
            for name, s in self._stacks.items()
        }
        passed = self._passed | {
            name for name, (numbers, flags) in parts.items() if self._cases.fine(name, numbers, self._stacks[name].count, flags)
        }  # fmt: skip
        found = []
        for place, index in enumerate(range(start, min(stop, self.size))):
            frame = self._frame(index)
            for name, (numbers, flags) in parts.items():
                stack = self._stacks[name]
                own = None if flags is None else flags[place]
                frame.columns[name] = made = Columns(stack.common.names, numbers[place], own, stack.ids)
                made.absent = stack.common.absent
                made.stack, made.row = numbers, place
            self._cases.check(frame, passed)
            found.append(frame)
        return found

    def stacked(self, start: int, stop: int) -> Stacked | None:
        """The same cases without a frame for each; None where something is wrong with one by itself that only its frame can say: with how
        samples or elements follow one another, or how many there are."""
        stop = min(stop, self.size)
        if len(self._settings) > 1 or any(one.signal in self._stacks for one in self._template.faults):
            return None
        if any(stack.faults for stack in self._stacks.values()):
            return None
        numbers = {name: s.values[start:stop] for name, s in self._stacks.items()}
        flags = {name: None if s.flags is None else s.flags[start:stop] for name, s in self._stacks.items()}
        events = {name: codes[start:stop] for name, codes in self._events.items()}
        fine = np.ones(stop - start, dtype=bool)
        for name, stack in self._stacks.items():
            if self._cases.fine(name, numbers[name], stack.count, flags[name]):
                continue
            if name not in self._records or stack.common.absent:
                return None
            fine &= self._cases.each_fine(name, numbers[name], stack.count, flags[name])
        for codes in events.values():
            fine &= codes >= 0
        shared = self._frame(0)
        shared.faults, shared.events = list(self._template.faults), dict(self._template.events)
        self._cases.check(shared, frozenset(self._stacks))
        fine &= not shared.faults
        names = {name: stack.common for name, stack in self._stacks.items()}
        return Stacked(stop - start, shared, names, numbers, flags, events, fine)

    def _frame(self, index: int) -> Frame:
        """A case with what all share."""
        shared = self._template
        faults = list(shared.faults)
        events = dict(shared.events)
        for name, codes in self._events.items():
            events[name] = int(codes[index])
            if codes[index] < 0:
                faults.append(fault("missing", name, "", None, "it is not there"))
        for stack in self._stacks.values():
            faults += stack.faults.get(index, ())
        settings = self._settings[index if len(self._settings) > 1 else 0]
        return Frame(
            index,
            settings,
            dict(shared.columns),
            events,
            shared.lines,
            shared.closed,
            {},
            faults,
            shared.orders,
            lanes=shared.lanes,
        )

    def _shared(self) -> frozenset[str]:
        """The signals that all share and that are as they should be: they need not be looked at in every case."""
        probe = self._frame(0)
        probe.faults = [one for one in probe.faults if one.signal not in self._stacks]
        before = len(probe.faults)
        self._cases.check(probe, frozenset(self._stacks))
        found = {one.signal for one in probe.faults[before:]}
        return frozenset(s.name for s in self._cases.contract.signals) - found - self._stacks.keys()


class ArraysReader:
    """Reads arrays for the rules that a reader of cases is for."""

    def __init__(self, cases: CasesReader) -> None:
        self._cases = cases
        signals = [s for s in cases.contract.signals if s.name in cases.reader.columns]
        self._signals = {signal.name: signal for signal in signals}
        # All entries of all cases are read as one long column.
        self._readers = {signal.name: ColumnsReader(_long(signal), spelt=True) for signal in signals}

    def read(self, signals: Any, shared: Any, overrides: Mapping[str, Any]) -> Arrays:
        """The cases that arrays stand for; see `Evaluator.batch`. Raises TrackmarshalError D202 to D205."""
        given, common = _mapping("signals", signals), _mapping("shared", shared)
        twice = sorted(str(name) for name in given.keys() & common.keys())
        if twice:
            raise TrackmarshalError(
                "D205", f"`{twice[0]}` is among the signals, and shared", help="leave one of the two out"
            )
        reader, together, known = self._cases.reader, {**common, **given}, self._cases.contract.known
        if "signals" in given and "signals" not in known:
            raise TrackmarshalError(
                "D203", "no signal is called `signals`", help="a case has them under `signals`; a batch is given them by their names"
            )  # fmt: skip
        faults = list[Fault]()
        reader.refuse_unknown(together, faults, known)
        faults = self._cases.refused(
            faults
        )  # before shapes are asked for: of a signal of another name there are none
        size = self._size(given, overrides)
        template = Frame(orders=self._cases.orders)
        stacks: dict[str, _Stack] = {}
        for name, columns in reader.columns.items():
            if name in given and self._varies(name, given[name]):
                stacks[name] = self._stack(name, given[name], size, faults)
            else:
                template.columns[name] = columns.read(together.get(name), faults)
        for name, lines in reader.lines.items():
            lines.read(together.get(name), template, faults)
        for name, lanes in reader.lanes.items():
            lanes.read(together.get(name), template, faults)
        events: dict[str, NDArray[np.int8]] = {}
        for name in reader.events:
            raw = together.get(name)
            if name in given and raw is not None and _axes(raw) == 1:
                found = list[Fault]()
                codes = [reader.event(name, one, found) for one in raw.tolist()]
                events[name] = np.array(codes, dtype=np.int8)
                faults += [
                    one for one in found if name_of(one) != "missing"
                ]  # what is missing is so in one case
            else:
                template.events[name] = reader.event(name, raw, faults)
        template.faults = self._cases.refused(faults)
        settings = self._settings(overrides, size)
        of_track = list[Fault]()
        reader.same_track(together, settings[0], of_track)  # places are the same in all cases
        template.faults += self._cases.refused(of_track)
        return Arrays(self._cases, size, settings, template, stacks, events)

    # Shapes ---------------------------------------------------------------------------------------------------

    def _size(self, given: Mapping[Any, Any], overrides: Mapping[str, Any]) -> int:
        """How many cases there are: what all arrays with an axis for them say; raises D205."""
        sizes: dict[str, int] = {}
        for name, raw in given.items():
            if name in self._cases.reader.events and _axes(raw) == 1:
                sizes[str(name)] = len(raw)
            elif name in self._signals and isinstance(raw, Mapping):
                for field, column in raw.items():
                    if field != "id" and _axes(column) == self._wanted(name):
                        sizes[f"{name}.{field}"] = len(column)
        for name, value in _params(overrides).items():
            if _axes(value) == 1:
                sizes[f"params.{name}"] = len(value)
        if not sizes:
            raise TrackmarshalError(
                "D205", "no array says how many cases there are",
                help="timelines and sets are arrays (cases, samples), fields of records and events (cases,)",
            )  # fmt: skip
        first, size = next(iter(sizes.items()))
        for name, other in sizes.items():
            if other != size:
                raise TrackmarshalError(
                    "D205", f"`{first}` has {size} cases, `{name}` has {other}", help="the first axis counts the cases"
                )  # fmt: skip
        if size == 0:
            raise TrackmarshalError("D205", f"`{first}` has no cases", help="of nothing, nothing can be said")
        return size

    def _wanted(self, name: str) -> int:
        """The axes of the arrays of a signal."""
        return 1 if self._signals[name].form == RECORD else 2

    def _varies(self, name: str, raw: Any) -> bool:
        """Whether any column of a signal has an axis for cases."""
        return isinstance(raw, Mapping) and any(
            _axes(column) == self._wanted(name) for field, column in raw.items() if field != "id"
        )

    def _stack(self, name: str, raw: Mapping[Any, Any], size: int, faults: list[Fault]) -> _Stack:
        signal, reader = self._signals[name], self._readers[name]
        data = values.mapping(raw)
        record = signal.form == RECORD
        ids, named = data.get("id") if signal.form == SET else None, {}
        counts: dict[str, int] = {}
        for field, column in data.items():
            if field == "id" and signal.form == SET:
                continue
            whole = _repeated(f"{name}.{field}", column, size, record)
            if whole is not None and not record:
                counts[str(field)] = whole.shape[1]
            # Those that no rule reads say how long the signal is, as with one case.
            named[field] = None if whole is None else whole.reshape(-1)
        first, count = next(iter(counts.items()), ("", 1))
        what = "elements" if signal.form == SET else "samples"
        for field, other in counts.items():
            if other != count:
                raise TrackmarshalError(
                    "D205", f"`{name}.{first}` has {count} {what}, `{name}.{field}` has {other}",
                    help=f"the second axis counts the {what}; cases of different lengths are for `evaluate`",
                )  # fmt: skip
        if count == 0 and signal.form == TIMELINE:
            raise TrackmarshalError(
                "D205", f"`{name}.{first}` has no samples", help="of nothing, nothing can be said"
            )
        own = list[Fault]()
        read = reader.read(named, own)
        for one in own:
            _refuse(one, count, record)
        # A name that is no member's is in one case, or in some.
        unknown = [one.field for one in own if name_of(one) == "no_member"]
        faults += self._cases.refused([one for one in own if name_of(one) != "no_member"])
        wrong: dict[int, list[Fault]] = {}
        for field in unknown:
            for case, entries in groupby(reader.no_members(field, named[field]), lambda one: one[0] // count):
                places = [(index % count, said) for index, said in entries]
                wrong.setdefault(case, []).append(reader.no_member(field, places, record))
        spoken = self._ids(name, ids, count, faults) if signal.form == SET else ()
        if read.values.shape[1] != size * count:
            raise AssertionError(f"{name}: {read.values.shape[1]} entries of {size} x {count}")
        numbers = read.values.reshape(len(reader.names.numbers), size, count).transpose(1, 0, 2)
        flags = (
            None
            if read.flags is None
            else read.flags.reshape(len(reader.names.flags), size, count).transpose(1, 0, 2)
        )
        numbers.flags.writeable = False
        return _Stack(read, numbers, flags, spoken, wrong)

    def _ids(self, name: str, raw: Any, count: int, faults: list[Fault]) -> tuple[str, ...]:
        """Ids of elements, the same in all cases; counted where there are none."""
        counted = tuple(map(str, range(count)))
        if raw is None:
            if count and self._signals[name].named:
                faults.append(fault("missing", name, "id", None, NAMELESS))
            return counted
        try:
            found = values.ids(raw)
        except WrongTypeError as error:
            faults.append(fault(error.name, name, "id", error.index, error.message))
            return counted
        if len(found) != count:
            raise TrackmarshalError(
                "D205", f"`{name}.id` has {len(found)} entries for {count} elements", help="ids are the same in all cases"
            )  # fmt: skip
        return found

    def _settings(self, overrides: Mapping[str, Any], size: int) -> list[Settings]:
        """The overrides of every case; one for all where no parameter varies."""
        params = _params(overrides)
        varying = {name: value.tolist() for name, value in params.items() if _axes(value) == 1}
        if not varying:
            return [self._cases.settings(overrides)]
        made: dict[str, Settings] = {}
        found = []
        for index in range(size):
            own = {name: column[index] for name, column in varying.items()}
            key = repr(own)
            if key not in made:
                made[key] = self._cases.settings({**overrides, "params": {**params, **own}})
            found.append(made[key])
        return found


def _long(signal: Signal) -> Signal:
    """A signal whose records are read as columns too."""
    form = TIMELINE if signal.form == RECORD else signal.form
    return Signal(signal.name, form, signal.fields_, signal.checks, signal.declared)


def _mapping(what: str, raw: Any) -> dict[Any, Any]:
    if raw is None:
        return {}
    if not isinstance(raw, Mapping):
        raise TrackmarshalError(
            "D202", f"`{what}` is an object, not {values.worded(raw)}", help="give signals by their names"
        )
    return values.mapping(raw)


def _params(overrides: Mapping[str, Any]) -> Mapping[str, Any]:
    """Parameters by name; none where they are no object, which the reader of settings refuses."""
    params = overrides.get("params")
    return params if isinstance(params, Mapping) else {}


def _axes(raw: Any) -> int | None:
    """How many axes an array has; None for anything else."""
    return raw.ndim if values.is_array(raw) else None


def _repeated(place: str, column: Any, size: int, record: bool) -> Any:
    """A column with its axis of cases: one that has none is the same in all of them; raises D205."""
    if column is None and not record:
        return None
    wanted = 1 if record else 2
    if (
        record
        and (_axes(column) is None or column.ndim == 0)
        and not isinstance(column, list | tuple | Mapping)
    ):
        column = np.asarray(column)
    if _axes(column) == wanted:
        return column
    if _axes(column) == wanted - 1:
        return column[np.newaxis].repeat(size, axis=0)
    what = values.worded(column) if _axes(column) is None else f"an array of {column.ndim} axes"
    shape = "(cases,), or one value for all" if record else "(cases, samples), or (samples,) for all"
    raise TrackmarshalError("D205", f"`{place}` is {what}", help=f"it is an array of shape {shape}")


def _refuse(one: Fault, count: int, record: bool) -> None:
    """Raise for an entry of a wrong type, in words for arrays."""
    if name_of(one) == "wrong_type" and one.index is not None:
        case, entry = divmod(one.index, count)
        at = f"[{case}]" if record else f"[{case}, {entry}]"
        help_ = "use arrays of numbers, and of bool for what is true or false"
        raise TrackmarshalError("D202", f"{one.signal}.{one.field}{at}: {one.message}", help=help_)
