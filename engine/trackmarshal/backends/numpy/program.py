"""Compiled rules, and what they come to for a batch of cases."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy import logic, places
from trackmarshal.backends.numpy.batch import Batch, Tables
from trackmarshal.backends.numpy.code import Code
from trackmarshal.backends.numpy.logic import AT_LEAST, NEITHER, Value, value
from trackmarshal.backends.numpy.views import CaseView, Reading
from trackmarshal.backends.results import Outcomes, Stateless, rule_result
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Rated, advisory
from trackmarshal.runtime.verdict import VERDICTS, RuleResult

#: Codes of verdicts: their places in VERDICTS.
_SATISFIED, _VIOLATED, _UNDEFINED, _INACTIVE = (
    np.uint8(VERDICTS.index(name)) for name in ("satisfied", "violated", "undefined", "inactive")
)


#: Cases that are worked on at once, so that arrays of their samples stay in the processor's cache.
TOGETHER = 500
#: What a batch has that no case changes, and the rest of a batch.
Fixed = Callable[[Batch], tuple[Any, ...]]
Varying = Callable[[Batch, Any], tuple[Any, ...]]


class NumpyProgram(Stateless):
    """The compiled rules; `run` evaluates them on a batch of frames."""

    backend = "numpy"

    def __init__(
        self, spec: Spec, rules: Sequence[RuleInfo], leaves: Sequence[ir.Formula] = (), rank: int = 1
    ) -> None:
        """rank: of arrays, at least: for formulas within others."""
        super().__init__(spec, rules, leaves)
        formulas = [rule.formula for rule in self.rules if rule.formula is not None]
        ranges = [rule.active for rule in self.rules if rule.active is not None]
        self.code, self._fixed, self._varying = _compiled((*formulas, *leaves), tuple(ranges), rank)
        outputs = {name: place for place, name in enumerate(self.code.outputs)}
        #: By formula: what its margins say, and where they and whether it holds are among the values of a run.
        self.places = {
            node: (formula.says, tuple(outputs[name] for name in formula.names))
            for node, formula in self.code.formulas.items()
        }
        #: Which of the rules has a range that may be empty.
        ranged = [row for row, rule in enumerate(self.rules) if rule.active is not None]
        self.ranged = np.array(ranged, dtype=np.intp)
        of_rules = [self.places[formula] for formula in formulas]
        #: Where the worst and the best margin of each rule are.
        self.margins = [(at[0], at[1]) for _, at in of_rules]
        #: What every verdict needs: each rule in its worst case, each range in its best; and what a doubtful one needs.
        self.settled = _Cases(
            [_side(place, 0) for place in of_rules] + [_side(self.places[f], 1) for f in ranges]
        )
        self.possible = _Cases([_side(place, 1) for place in of_rules])
        self.never_decide = advisory(self.rules)
        self._tables = Tables(spec)
        self._recalling: dict[ir.Formula, NumpyProgram] = {}
        self._alone: dict[ir.Formula, NumpyProgram] = {}
        with np.errstate(all="ignore"):
            # numpy takes arrays without axes faster than numbers.
            self._left = tuple(map(_without_axes, self._fixed(self._batch(()))))

    def outcomes(self, frames: Sequence[Frame]) -> list[Outcomes]:
        if not frames:
            return []
        run = self.run(frames)
        return [Outcomes(one, partial(CaseView, run, index)) for index, one in enumerate(run.rated())]

    def rate_all(self, frames: Sequence[Frame]) -> list[Rated]:
        chunks = (frames[first : first + TOGETHER] for first in range(0, len(frames), TOGETHER))
        return [one for chunk in chunks for one in self.run(chunk).rated()]

    def run(self, cases: Sequence[Frame]) -> Run:
        """Evaluate all rules on all frames, cases or seen by one candidate."""
        return self.run_on(self._batch(cases))

    def run_on(self, batch: Batch) -> Run:
        """Evaluate all rules on a batch."""
        # Undefined values are part of the language: divisions by zero and NaN are no cause for warnings.
        with np.errstate(all="ignore"):
            left = self._fixed(batch) if batch.overridden else self._left
            return Run(self, batch, self._varying(batch, left))

    def recalling(self, node: ir.Formula) -> NumpyProgram:
        """The program of one formula about numbers that state machines keep."""
        made = self._recalling.get(node)
        if made is None:
            made = self._recalling[node] = NumpyProgram(self.spec, [], [node], self.code.rank)
        return made

    def alone(self, node: ir.Formula) -> NumpyProgram:
        """The program of one formula by itself, of which everything is worked out."""
        made = self._alone.get(node)
        if made is None:
            made = self._alone[node] = NumpyProgram(self.spec, [], [node], self.code.rank)
        return made

    @property
    def tables(self) -> Tables:
        """The spec's own tables as functions of arrays."""
        return self._tables

    def _batch(self, cases: Sequence[Frame]) -> Batch:
        return Batch(self.spec, cases, self.code.rank, self._tables)


@lru_cache(maxsize=64)
def _compiled(
    formulas: tuple[ir.Formula, ...], ranges: tuple[ir.Formula, ...], rank: int
) -> tuple[Code, Fixed, Varying]:
    """Code and its functions, which are those of its formulas alone: specs that differ by values have the same."""
    code = Code(formulas, ranges, rank)
    return code, *code.functions()


def _without_axes(value: Any) -> Any:
    return np.array(value) if isinstance(value, np.float64) else value


class _Cases:
    """Sides of formulas without free variables: where they are among the values of a run."""

    def __init__(self, sides: Sequence[tuple[int, int, int]]) -> None:
        """By side what the margin says, where it is, and, unless it says it, where whether it holds is."""
        self._margins = [margin for _, margin, _ in sides]
        #: Whether they hold where the margin is 0.
        self._at_zero = np.array([[bool(says & AT_LEAST)] for says, _, _ in sides])
        self._sats = {side: sat for side, (says, _, sat) in enumerate(sides) if says == NEITHER}

    def read(
        self, values: Sequence[Any], size: int, chosen: Sequence[int] | None = None
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """(sides, cases) of whether they hold, and of their margins; of all sides, or of chosen ones."""
        sides = range(len(self._margins)) if chosen is None else chosen
        margins = (
            _by_case([values[self._margins[side]] for side in sides], size) + 0.0
        )  # a margin of zero is 0.0 by definition
        at_zero = self._at_zero if chosen is None else self._at_zero.take(chosen, axis=0)
        sat = logic.where(at_zero, margins >= 0.0, margins > 0.0)
        for row, side in enumerate(sides if self._sats else ()):
            if side in self._sats:
                sat[row] = _of_cases(values[self._sats[side]], size).ravel()
        return sat, margins


def _side(place: tuple[int, tuple[int, ...]], best: int) -> tuple[int, int, int]:
    says, at = place
    return says, at[best], at[2 + best] if says == NEITHER else -1


def _by_case(rows: Sequence[Any], size: int) -> NDArray[np.float64]:
    """(rows, cases) of arrays without other axes, some of which have one value for all."""
    # For a few numbers each, three times as fast as asking numpy.
    pieces = b"".join([row.tobytes() if row.size == size else row.tobytes() * size for row in rows])
    return np.frombuffer(pieces, dtype=np.float64).reshape(-1, size)


def _of_cases(array: Any, size: int) -> Any:
    """A value for every case, of an array without other axes or of one value for all."""
    return array if array.size == size else array.repeat(size)


#: For so many of the numbers that state machines keep a formula is worked out for all cases of a batch; after that, they are hardly the same twice.
_ALIKE = 4


class Run:
    """The values of a program for one batch."""

    def __init__(self, program: NumpyProgram, batch: Batch, values: tuple[Any, ...]) -> None:
        self.program = program
        self.batch = batch
        self._values = values
        self._made: dict[ir.IR, Value] = {}
        #: What has been asked of single cases.
        self.readings: dict[ir.IR, Reading] = {}
        self._recalled: dict[ir.IR, dict[tuple[str, ...], Run]] = {}
        self._whole: dict[ir.IR, Run] = {}
        self._wholly: dict[tuple[ir.IR, int], CaseView] = {}

    def of(self, node: ir.Formula) -> Value:
        """The value of a formula."""
        made = self._made.get(node)
        if made is None:
            says, at = self.program.places[node]
            worst, best, *sats = (self._values[place] for place in at)
            made = self._made[node] = value(worst, best, says, *sats)
        return made

    def whole(self, node: ir.Formula, index: int) -> CaseView | None:
        """One case, for a formula of which this run has only worked out what verdicts take; None where it has all. Of a long run mostly the
        worst cycles are asked, by themselves."""
        place = self.program.code.partly.get(node)
        if place is None or not self._values[place]:
            return None
        found = self._wholly.get((node, index))
        if found is None:
            run, at = self._whole.get(node), index
            if run is None and len(self._wholly) < places.ASKED < self.batch.size:
                run, at = self._of_one(node, self.batch.cases[index : index + 1]), 0
            elif run is None:
                run = self._whole[node] = self._of_one(node, self.batch.cases)
            found = self._wholly[node, index] = CaseView(run, at)
        return found

    def _of_one(self, node: ir.Formula, cases: Sequence[Frame]) -> Run:
        program = self.program.alone(node)
        batch = program._batch(cases)
        batch.remembered = self.batch.remembered
        return program.run_on(batch)

    def recalled(self, node: ir.Formula, kept: Mapping[ir.Kept, float], index: int) -> CaseView:
        """One case, for a formula about numbers that state machines keep, with those given. Mostly cases have the same ones, so it is worked out for
        many at once."""
        known = self._recalled.setdefault(node, {})
        key = tuple(value.hex() for value in kept.values())  # NaN is no key
        if key not in known and len(known) >= _ALIKE:
            return CaseView(self._recalling(node, kept, [self.batch.cases[index]]), 0)
        if key not in known:
            known[key] = self._recalling(node, kept, self.batch.cases)
        return CaseView(known[key], index)

    def _recalling(self, node: ir.Formula, kept: Mapping[ir.Kept, float], cases: Sequence[Frame]) -> Run:
        program = self.program.recalling(node)
        batch = program._batch(cases)
        batch.remembered = kept
        return program.run_on(batch)

    def rated(self) -> list[Rated]:
        """The outcome of every frame; witnesses are looked for when they are asked for."""
        codes, margins = self.verdicts
        by_frame = codes.T.tobytes()
        width, never_decide, explain = len(self.program.rules), self.program.never_decide, self._explain
        # Of thousands of cases each one has few objects of its own: the more there are, the longer Python looks for some that nobody has.
        return [
            Rated(by_frame[index * width : (index + 1) * width], own, partial(explain, index), never_decide)
            for index, own in enumerate(zip(*margins.tolist()) if width else [()] * self.batch.size)
        ]

    def _explain(self, index: int, number: int, series: bool = False) -> RuleResult:
        """The whole result of a rule in a case."""
        codes, margins = self.verdicts
        said = VERDICTS[codes[number, index]], float(margins[number, index])
        rule, frame = self.program.rules[number], self.batch.cases[index]
        return rule_result(rule, frame, CaseView(self, index), said, series)

    @cached_property
    def verdicts(self) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
        """(rules, frames) codes of verdicts, their places in VERDICTS, and margins."""
        program, values, size = self.program, self._values, self.batch.size
        rules = len(program.rules)
        if not rules:  # leaves of other rules alone
            return np.zeros((0, size), dtype=np.uint8), np.zeros((0, size))
        sat, margins = program.settled.read(values, size)
        occupied = sat[rules:]
        sat, margins = sat[:rules], margins[:rules]
        code = logic.where(sat, _SATISFIED, _VIOLATED)
        unsure = [
            row for row, (worst, best) in enumerate(program.margins) if values[worst] is not values[best]
        ]
        if unsure and not logic.full(surely := sat.take(unsure, axis=0)):
            possible, best = program.possible.read(values, size, unsure)
            code[unsure] = np.where(surely, _SATISFIED, np.where(possible, _UNDEFINED, _VIOLATED))
            own = margins.take(unsure, axis=0)
            margins[unsure] = np.where(surely, own, np.where(possible, np.nan, best))
        if not logic.full(occupied):
            row, case = (~occupied).nonzero()
            code[program.ranged[row], case], margins[program.ranged[row], case] = _INACTIVE, np.inf
        for index in self.batch.faulty:
            frame = self.batch.cases[index]
            blocked = [frame.unusable(rule.reads) is not None for rule in self.program.rules]
            code[blocked, index], margins[blocked, index] = _UNDEFINED, np.nan
        return code, margins
