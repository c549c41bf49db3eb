"""What formulas about one cycle alone come to in many cycles: of frames, or of arrays without frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.batch import Batch, Tables
from trackmarshal.backends.numpy.logic import NEITHER, Side, Value
from trackmarshal.backends.numpy.program import NumpyProgram, Run
from trackmarshal.backends.numpy.whole.outcomes import UNDEFINED
from trackmarshal.backends.numpy.whole.values import Bools, Floats, undefined_where
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.constants import constant_value
from trackmarshal.ir.reads import reads
from trackmarshal.ir.spec import ParamInfo, Spec
from trackmarshal.runtime.door.stacked import Stacked
from trackmarshal.runtime.frame import Columns, Frame, Settings

Unusable = Callable[[Iterable[tuple[str, str]]], Bools | None]
_reads = lru_cache(maxsize=4096)(reads)


class Leaves:
    """Formulas in the cycles of one batch. unusable: in which cycles what reads something has no verdict; settings: of every cycle, or one for all."""

    def __init__(self, run: Run, unusable: Unusable, settings: Sequence[Settings]) -> None:
        self.run, self.unusable, self._settings = run, unusable, settings

    def value(self, node: ir.Formula) -> Value:
        """(cycles,)."""
        worst, best = self.run.of(node)
        side = self._flat(worst)
        found = Value(side, side if best is worst else self._flat(best))
        return undefined_where(found, self.unusable(_reads(node)))

    def number(self, node: ir.Num) -> Any:
        """A number that no input changes: one, or (cycles,)."""
        own = self.run.program.spec.params
        found = []
        for settings in self._settings:
            given = settings.params
            number = constant_value(node, partial(_param, own, given))
            assert number is not None, "an input changes it"
            found.append(number)
        return found[0] if found.count(found[0]) == len(found) else np.array(found)

    def verdicts(self) -> tuple[NDArray[np.uint8], Floats]:
        """(rules, cycles) codes of verdicts, and margins, of the rules that remember nothing."""
        codes, margins = self.run.verdicts
        for row, rule in enumerate(self.run.program.rules):
            blocked = self.unusable(rule.reads)
            if blocked is not None:
                codes[row, blocked], margins[row, blocked] = UNDEFINED, np.nan
        return codes, margins

    def _flat(self, side: Side) -> Side:
        size = self.run.batch.size
        return Side(_of_cycles(side.margin, size), NEITHER, _of_cycles(side.sat, size))


def _param(own: Mapping[str, ParamInfo], given: Mapping[str, float], name: str) -> float:
    return given.get(name, own[name].value)


def _of_cycles(array: Any, size: int) -> Any:
    return array.reshape(size) if array.size == size else np.repeat(array, size)


def of_frames(program: NumpyProgram, frames: Sequence[Frame]) -> Leaves:
    """Of cycles that are frames."""

    def unusable(asked: Iterable[tuple[str, str]]) -> Bools | None:
        asked = list(asked)
        found = [bool(frame.faults) and frame.unusable(asked) is not None for frame in frames]
        return np.array(found) if any(found) else None

    settings = list({id(frame.settings): frame.settings for frame in frames}.values())
    return Leaves(
        program.run(frames),
        unusable,
        settings if len(settings) == 1 else [frame.settings for frame in frames],
    )


def of_arrays(program: NumpyProgram, stacked: Stacked) -> Leaves:
    """Of cycles that are arrays."""
    batch = _Arrays(program.spec, stacked, program.code.rank, program.tables)
    return Leaves(program.run_on(batch), stacked.unusable, [stacked.shared.settings])


class _Arrays(Batch):
    """Cycles without frames: what differs among them is taken from arrays, all else from what they share."""

    def __init__(self, spec: Spec, stacked: Stacked, rank: int, tables: Tables) -> None:
        super().__init__(spec, [stacked.shared], rank, tables)
        self._given = stacked
        self._columns: dict[tuple[str, str], Floats] = {}
        self.size = stacked.size
        self.cases = [stacked.shared] * stacked.size

    @property
    def faulty(self) -> list[int]:
        return list(range(self.size)) if self._given.shared.faults else []

    def param(self, name: str) -> Any:
        own = self.spec.params[name].value
        return np.float64(self._given.shared.settings.params.get(name, own))

    def own(self, signal: str) -> list[Columns]:
        if signal not in self._given.names:
            return [self._given.shared.columns[signal]] * self.size
        common, ids = self._given.names[signal], self._given.names[signal].ids
        numbers, flags = self._given.numbers[signal], self._given.flags[signal]
        return [
            Columns(common.names, numbers[place], None if flags is None else flags[place], ids)
            for place in range(self.size)
        ]

    def counts(self, signal: str) -> list[int]:
        given = self._given.numbers.get(signal)
        count = self._given.shared.columns[signal].count if given is None else given.shape[2]
        return [count] * self.size

    def count(self, axis: ir.Axis) -> int:
        given = self._given.numbers.get(axis.signal)
        count = self._given.shared.columns[axis.signal].count if given is None else given.shape[2]
        return max(0, count - axis.width + 1)

    def table(self, signal: str, field: str) -> Floats:
        known = self._columns.get((signal, field))
        if known is None:
            given = self._given.numbers.get(signal)
            if given is None:
                shared = np.asarray(self._given.shared.columns[signal].column(field), dtype=np.float64)
                known = np.broadcast_to(shared, (self.size, len(shared)))
            else:
                row = self._given.names[signal].names.rows[field]
                known = np.ascontiguousarray(given[:, row])
            self._columns[signal, field] = known
        return known

    def scalar(self, signal: str, field: str) -> Any:
        if signal not in self._given.numbers:
            return np.array(self._given.shared.value(signal, field))
        return self._shaped(self.table(signal, field)[:, 0])

    def sample(self, signal: str, field: str, index: int) -> Any:
        return self._shaped(self.table(signal, field)[:, index])

    def event(self, signal: str, field: str, index: int) -> Any:
        if field and signal in self._given.names:
            return self._shaped(self.flags(signal, field)[:, index])
        if not field and signal in self._given.events:
            codes = self._given.events[signal]
            return self._shaped(_coded(codes))
        flag = self._given.shared.flag(signal, field, index)
        return np.array(np.nan if flag is None else float(flag))

    def flags(self, signal: str, field: str) -> Floats:
        if signal not in self._given.names:
            own = _coded(np.asarray(self._given.shared.columns[signal].column(field)))
            return np.broadcast_to(own, (self.size, len(own)))
        given, row = self._given.flags[signal], self._given.names[signal].names.rows[field]
        assert given is not None, "a column of Booleans"
        return _coded(given[:, row])

    def _shaped(self, values: NDArray[Any]) -> NDArray[Any]:
        """(cycles,) shaped for broadcasting."""
        return values.reshape(self.by_case)


def _coded(codes: NDArray[Any]) -> Floats:
    """1, 0 and NaN of 1, 0 and -1."""
    return np.where(codes < 0, np.nan, codes.astype(np.float64))
