"""What rules say of many cycles of one run at once: rules over the run along the cycles, piece by piece, with numpy."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.numpy.whole.engine import Engine, why_by_cycle
from trackmarshal.backends.numpy.whole.leaves import Leaves, of_arrays, of_frames
from trackmarshal.backends.numpy.whole.outcomes import Outcome, Said, Saying, following
from trackmarshal.backends.over_run.program import explained
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.overrun import FURTHEST, leaves, nanoseconds
from trackmarshal.ir.spec import RuleInfo, Spec, remembers
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import SAFE_CODES
from trackmarshal.runtime.stamps import stamp_after
from trackmarshal.runtime.verdict import VERDICTS, About, CaseResult, RuleResult

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator
    from trackmarshal.over_run import Run

Floats = NDArray[np.float64]
Codes = NDArray[np.uint8]
Stamps = NDArray[np.int64]
_NAMES = np.array(VERDICTS)
_SAFE = np.isin(np.arange(len(VERDICTS)), list(SAFE_CODES))
#: Cycles that are evaluated together: so many that calls of numpy cost little beside what they do, so few that columns stay in the caches.
BLOCK = 65536


class Rules:
    """Chosen rules on pieces of a run: those without a memory, and those over the run that need no single cycles. `slow`: all others, with why."""

    def __init__(self, spec: Spec, rules: Sequence[RuleInfo]) -> None:
        self.rules = rules
        over = [rule for rule in rules if remembers(rule)]
        self.slow: dict[str, str] = {rule.name: why for rule in over if (why := why_by_cycle(rule))}
        self._over = [rule for rule in over if rule.name not in self.slow]
        plain = [rule for rule in rules if not remembers(rule)]
        formulas = [f for rule in self._over for f in (rule.formula, rule.active) if f is not None]
        self.program = NumpyProgram(
            spec, plain, tuple(dict.fromkeys(leaf for formula in formulas for leaf in leaves(formula)))
        )
        self._engine = Engine(self._over)

    def step(
        self, stamps: Stamps, missed: NDArray[np.intp], doubt: NDArray[np.bool_], given: Leaves
    ) -> dict[str, Outcome]:
        """By rule, what it says in the cycles of a piece; those that are `slow` are left out."""
        plain = self.program.rules
        codes, margins = given.verdicts()
        found = {rule.name: Outcome(codes[row], margins[row], None) for row, rule in enumerate(plain)}
        first = self._engine.count
        for rule, outcome in zip(self._over, self._engine.step(stamps, missed, doubt, given)):
            blocked = given.unusable(rule.reads)
            found[rule.name] = outcome if blocked is None else outcome.blocked(blocked, first)
        return found

    @property
    def count(self) -> int:
        """How many cycles there were."""
        return self._engine.count

    @property
    def oldest(self) -> int:
        """The number of the oldest cycle of which something may still be said."""
        return self._engine.oldest

    def missed(self, count: int) -> None:
        """Cycles that were refused, or did not come."""
        self._engine.missed(count)

    def end(self) -> dict[str, Saying]:
        """By rule, what is said of cycles that were open, after the last one."""
        return {rule.name: said for rule, said in zip(self._over, self._engine.end()) if said is not None}


class Frames:
    """A run whose cycles are frames, many at a time: what `Run.step` says of each, in the same order. `end` says what was open after the last one."""

    def __init__(self, evaluator: Evaluator) -> None:
        self._evaluator = evaluator
        self._rules = Rules(evaluator.spec, evaluator.rules)
        self._slow = evaluator.only(list(self._rules.slow)).over_run() if self._rules.slow else None
        self._last: int | None = None
        #: What cycles are called, by their numbers: of those of which something may still be said.
        self._names: dict[int, object] = {}

    def step(
        self, cycles: Sequence[Frame | TrackmarshalError], series: bool = False
    ) -> list[CaseResult | TrackmarshalError]:
        """The results of the next cycles, or what is wrong with one: it could not be read, or has no stamp after the last one (D206). That is a gap."""
        found: list[CaseResult | TrackmarshalError | None] = []
        frames: list[Frame] = []
        gaps: list[int] = []
        before = 0
        for cycle in cycles:
            if isinstance(cycle, Frame):
                try:
                    self._evaluator.refuse_straight(cycle)
                    self._last = stamp_after(cycle, self._last)
                except TrackmarshalError as error:
                    cycle = error
            if isinstance(cycle, Frame):
                frames.append(cycle)
                gaps.append(before)
                found.append(None)
                before = 0
            else:
                found.append(cycle)
                before += 1
        results = iter(list(self._results(frames, gaps, series)) if frames else [])
        self._missed(before)
        return [next(results) if one is None else one for one in found]

    def end(self) -> dict[str, tuple[About, ...]]:
        """By rule, what is said of cycles that were open."""
        said = {
            name: tuple(one for _, one in saying.listed(self._names.__getitem__))
            for name, saying in self._rules.end().items()
        }
        if self._slow is not None:
            said |= self._slow.end()
        return {rule.name: said[rule.name] for rule in self._evaluator.rules if said.get(rule.name)}

    def _missed(self, count: int) -> None:
        self._rules.missed(count)
        for _ in range(count if self._slow is not None else 0):
            assert self._slow is not None
            self._slow.missed()

    def _results(self, frames: Sequence[Frame], gaps: Sequence[int], series: bool) -> Iterator[CaseResult]:
        first = self._rules.count
        self._names |= {first + place: frame.number for place, frame in enumerate(frames)}
        given = of_frames(self._rules.program, frames)
        stamps = np.array([nanoseconds(frame.t) for frame in frames if frame.t is not None], dtype=np.int64)
        doubt = np.array([bool(frame.faults) for frame in frames])
        outcomes = self._rules.step(stamps, np.array(gaps, dtype=np.intp), doubt, given)
        said = {name: self._said(one, first, len(frames)) for name, one in outcomes.items()}
        self._names = {number: name for number, name in self._names.items() if number >= self._rules.oldest}
        plain = {rule.name: place for place, rule in enumerate(self._rules.program.rules)}
        for place, (frame, rated) in enumerate(zip(frames, given.run.rated())):
            slow = self._of_slow(frame, gaps[place], series)
            rules: dict[str, RuleResult] = {}
            for rule in self._evaluator.rules:
                name = rule.name
                if name in slow:
                    rules[name] = slow[name]
                elif name in plain:
                    rules[name] = rated.explain(plain[name], series)
                else:
                    code, margin = outcomes[name].codes[place], float(outcomes[name].margins[place])
                    rules[name] = explained(rule, frame, VERDICTS[code], margin, said[name][place])
            yield CaseResult(frame.id, rules, tuple(map(str, frame.faults)), frame.settings.broken)

    def _said(self, outcome: Outcome, first: int, count: int) -> list[tuple[About, ...]]:
        """By cycle, what is said in it."""
        found: list[list[About]] = [[] for _ in range(count)]
        saying = at_once(outcome, first) if outcome.said is None else outcome.said()
        for cycle, one in saying.listed(self._names.__getitem__):
            found[cycle - first].append(one)
        return [tuple(each) for each in found]

    def _of_slow(self, frame: Frame, gap: int, series: bool) -> Mapping[str, RuleResult]:
        if self._slow is None:
            return {}
        for _ in range(gap):
            self._slow.missed()
        return self._slow.step(frame, series).rules


def at_once(outcome: Outcome, first: int) -> Saying:
    """What a rule says that is decided in its own cycle: of each about itself."""
    own = np.arange(first, first + len(outcome.codes))
    return Saying(own, own, outcome.codes, outcome.margins, np.ones(len(own), dtype=bool))


class Piece:
    """What rules say in some cycles of a run, one after the other; made by `WholeRun.step`.

    first: the number of its first cycle, counted from 0. codes: rule -> (size,) places of verdicts in VERDICTS; margins: rule -> (size,) float64 in
    SI, NaN where undefined or open, inf where nothing was demanded. safe: (size,) bool, as `CaseResult.safe`.
    """

    def __init__(
        self, first: int, codes: Mapping[str, Codes], margins: Mapping[str, Floats], said: Mapping[str, Said],
        safe: NDArray[np.bool_],
    ) -> None:  # fmt: skip
        self.first, self.codes, self.margins, self._said, self.safe = first, codes, margins, said, safe
        self.size = len(safe)

    def __len__(self) -> int:
        return self.size

    @cached_property
    def verdicts(self) -> Mapping[str, NDArray[np.str_]]:
        """Rule -> (size,) names of verdicts."""
        return {name: _NAMES[codes] for name, codes in self.codes.items()}

    def about(self, rule: str) -> Saying:
        """What a rule over the run says in these cycles about which cycles: about each itself, and about earlier ones that are decided, or
        whose margin becomes final, in one of these. Raises KeyError for a rule that there is not."""
        said = self._said[rule]
        if said is not None:
            return said()
        return at_once(Outcome(self.codes[rule], self.margins[rule], None), self.first)


class WholeRun:
    """A run that is read in pieces of many cycles; made by `Evaluator.whole_run`.

    by_cycle: the rules that are evaluated cycle by cycle all the same, and why.
    """

    def __init__(self, evaluator: Evaluator, constant: Mapping[str, Any], read: Callable[..., Any]) -> None:
        self._evaluator, self._constant, self._read = evaluator, constant, read
        self._rules = Rules(evaluator.spec, evaluator.rules)
        self.by_cycle: Mapping[str, str] = dict(self._rules.slow)
        self.rules: tuple[str, ...] = tuple(rule.name for rule in evaluator.rules)
        self._slow: Run | None = evaluator.only(list(self.by_cycle)).over_run() if self.by_cycle else None
        self._origin: int | None = None
        self._last: int | None = None
        self._count = 0

    def step(
        self, t: Any, signals: Mapping[str, Any], shared: Mapping[str, Any] | None = None, missed: Any = None
    ) -> Piece:
        """The next cycles. t: (cycles,) int64, their stamps in ns, ascending; signals, shared: as `Evaluator.batch` takes them; missed: (cycles,)
        whole numbers, how many cycles are missing before each. Raises TrackmarshalError D202 to D206.
        """
        stamps = self._stamps(t)
        gaps = _missed(missed, len(stamps))
        arrays = self._read(signals, shared, self._constant)
        if arrays.size != len(stamps):
            raise TrackmarshalError(
                "D205", f"there are {len(stamps)} stamps, and {arrays.size} cycles", help="give one stamp for each cycle"
            )  # fmt: skip
        if self._origin is None:
            self._origin = int(stamps[0])
        before = self._count
        try:
            parts = [self._block(arrays, stamps, gaps, at) for at in range(0, len(stamps), BLOCK)]
        except TrackmarshalError:
            taken = self._count - before
            if taken:  # what is left of the piece no rule was asked about
                self.missed(len(stamps) - taken + int(gaps[taken:].sum()))
                self._last = int(stamps[-1])
            raise
        self._last = int(stamps[-1])
        return parts[0] if len(parts) == 1 else _joined(parts)

    def missed(self, count: int = 1) -> None:
        """Cycles that were refused, or did not come."""
        self._rules.missed(count)
        for _ in range(count if self._slow is not None else 0):
            assert self._slow is not None
            self._slow.missed()

    def end(self) -> dict[str, Saying]:
        """By rule, what is said of cycles that were open, after the last one."""
        found = self._rules.end()
        if self._slow is not None:
            found |= {name: _saying([(self._count, said)]) for name, said in self._slow.end().items()}
        return {name: found[name] for name in self.rules if name in found}

    def _block(self, arrays: Any, stamps: Stamps, gaps: NDArray[np.intp], begin: int) -> Piece:
        stamps, gaps = stamps[begin : begin + BLOCK], gaps[begin : begin + BLOCK]
        stacked, stop = arrays.stacked(begin, begin + BLOCK), begin + len(stamps)
        frames: list[Frame] = [] if stacked is not None and self._slow is None else arrays.frames(begin, stop)
        if stacked is not None:
            given, fine, broken = (
                of_arrays(self._rules.program, stacked),
                stacked.fine,
                bool(stacked.shared.settings.broken),
            )
        else:
            given = of_frames(self._rules.program, frames)
            fine, broken = (
                np.array([not frame.faults for frame in frames]),
                any(frame.settings.broken for frame in frames),
            )
        found = self._rules.step(stamps, gaps, ~fine, given)
        if self._slow is not None:
            found |= self._by_cycle(self._slow, frames, stamps, gaps)
        safe = fine & (not broken) & (not all(rule.advisory for rule in self._evaluator.rules))
        for rule in self._evaluator.rules:
            if not rule.advisory:
                safe &= _SAFE.take(found[rule.name].codes)
        first, self._count = self._count, self._count + len(stamps)
        return Piece(
            first, {name: found[name].codes for name in self.rules}, {name: found[name].margins for name in self.rules},
            {name: found[name].said for name in self.rules}, safe,
        )  # fmt: skip

    def _by_cycle(
        self, run: Run, frames: Sequence[Frame], stamps: Stamps, gaps: NDArray[np.intp]
    ) -> dict[str, Outcome]:
        """The same of rules that need single cycles."""
        assert self._origin is not None
        results = []
        for place, frame in enumerate(frames):
            for _ in range(int(gaps[place])):
                run.missed()
            # Counted from the first stamp: seconds as floating-point numbers would not tell stamps since 1970 apart.
            frame.t, frame.number = (int(stamps[place]) - self._origin) / 1e9, self._count + place
            try:
                results.append(run.step(frame).rules)
            except TrackmarshalError:
                # Generated C does not hold it: to these rules, it and those behind it are a gap.
                for _ in range(len(frames) - place + int(gaps[place + 1 :].sum())):
                    run.missed()
                self._count += len(frames)
                raise
        made = {}
        for name in self.by_cycle:
            own = [each[name] for each in results]
            codes = np.array([VERDICTS.index(one.verdict) for one in own], dtype=np.uint8)
            said = [(self._count + place, one.about) for place, one in enumerate(own)]
            made[name] = Outcome(codes, np.array([one.margin for one in own]), partial(_saying, said))
        return made

    def _stamps(self, t: Any) -> Stamps:
        stamps = np.asarray(t)
        if stamps.ndim != 1 or stamps.dtype.kind not in "iu" or not len(stamps):
            raise TrackmarshalError(
                "D206", "the stamps of the cycles are no array of whole nanoseconds",
                help="give `t` as an int64 array (cycles,), such as np.rint(seconds * 1e9).astype(np.int64)",
            )  # fmt: skip
        if (
            not -FURTHEST < int(stamps.min()) <= int(stamps.max()) < FURTHEST
        ):  # with windows added, they would leave 64 bits
            raise TrackmarshalError(
                "D206", f"stamps of cycles are within {FURTHEST / 1e9:g} s of 0, and one is not",
                help="they are in ns; `NaT` of numpy's times is -2^63: leave such a cycle out, and count it in `missed`",
            )  # fmt: skip
        stamps = stamps.astype(np.int64)
        before = stamps[:1] - 1 if self._last is None else np.array([self._last])
        late = np.concatenate((before, stamps[:-1])) >= stamps
        if late.any():
            number = int(np.argmax(late))
            raise TrackmarshalError(
                "D206", f"the cycle {self._count + number} has a stamp that does not come after the one before", help="stamps ascend"
            )  # fmt: skip
        return stamps


def _missed(given: Any, count: int) -> NDArray[np.intp]:
    if given is None:
        return np.zeros(count, np.intp)
    missed = np.asarray(given)
    if missed.shape != (count,) or missed.dtype.kind not in "iu" or (missed < 0).any():
        raise TrackmarshalError(
            "D205", f"`missed` is no array of {count} whole numbers, none below 0", help="how many cycles are missing before each"
        )  # fmt: skip
    return missed.astype(np.intp)


def _joined(parts: Sequence[Piece]) -> Piece:
    names = parts[0].codes.keys()
    return Piece(
        parts[0].first,
        {name: np.concatenate([part.codes[name] for part in parts]) for name in names},
        {name: np.concatenate([part.margins[name] for part in parts]) for name in names},
        {name: following([part._said[name] for part in parts]) for name in names},
        np.concatenate([part.safe for part in parts]),
    )


def _saying(parts: Sequence[tuple[int, Sequence[About]]]) -> Saying:
    """What was said cycle by cycle: in which cycle, about which."""
    every = [(number, one) for number, said in parts for one in said]
    return Saying(
        np.array([number for number, _ in every], dtype=np.intp), np.array([one.cycle for _, one in every], dtype=np.intp),
        np.array([VERDICTS.index(one.verdict) for _, one in every], dtype=np.uint8),
        np.array([one.margin for _, one in every], dtype=np.float64), np.array([one.final for _, one in every], dtype=bool),
    )  # fmt: skip
