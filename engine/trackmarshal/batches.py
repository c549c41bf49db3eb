"""What rules say of many cases at once, as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.door.arrays import Arrays
from trackmarshal.runtime.faults import Fault
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import SAFE_CODES
from trackmarshal.runtime.verdict import VERDICTS, CaseResult

if TYPE_CHECKING:
    from trackmarshal.evaluation import Evaluator

Floats = NDArray[np.float64]
_NAMES = np.array(VERDICTS)


class Batch:
    """The outcome of rules on `size` cases; made by `Evaluator.batch`.

    verdicts: rule -> (size,) names of verdicts. margins: rule -> (size,) float64 in SI, in the unit that `units` names; NaN where undefined,
    inf where nothing was demanded. safe: (size,) bool, as `CaseResult.safe`. faults, broken: case -> breaches of the input contract, and
    constraints of the spec that do not hold with its parameters; cases without any are left out.
    """

    def __init__(self, evaluator: Evaluator, arrays: Arrays, chunk: int) -> None:
        self._evaluator, self._arrays, self._chunk = evaluator, arrays, chunk
        self.size = arrays.size
        self.rules: tuple[str, ...] = tuple(rule.name for rule in evaluator.rules)
        self.units: Mapping[str, str] = {rule.name: rule.unit for rule in evaluator.rules}
        self.faults: Mapping[int, tuple[Fault, ...]]
        self.broken: Mapping[int, tuple[str, ...]]
        faults, broken = dict[int, tuple[Fault, ...]](), dict[int, tuple[str, ...]]()
        codes = np.empty((self.size, len(self.rules)), dtype=np.uint8)
        margins = np.empty((self.size, len(self.rules)))
        for start, frames in self._frames():
            judged = evaluator.judge_all(frames)
            rated = [one.rated[""] for one in judged]
            stop = start + len(frames)
            codes[start:stop] = np.frombuffer(b"".join(one.verdicts for one in rated), np.uint8).reshape(
                len(frames), -1
            )
            margins[start:stop] = [one.margins for one in rated]
            faults |= {start + i: tuple(frame.faults) for i, frame in enumerate(frames) if frame.faults}
            broken |= {start + i: f.settings.broken for i, f in enumerate(frames) if f.settings.broken}
        self.faults, self.broken = faults, broken
        columns = np.ascontiguousarray(codes.T)
        self.verdicts: Mapping[str, NDArray[np.str_]] = {
            name: _NAMES[column] for name, column in zip(self.rules, columns)
        }
        self.margins: Mapping[str, Floats] = dict(zip(self.rules, np.ascontiguousarray(margins.T)))
        decisive = [not rule.advisory for rule in evaluator.rules]
        safe: NDArray[np.bool_] = np.full(self.size, any(decisive))
        safe &= np.isin(codes[:, decisive], list(SAFE_CODES)).all(axis=1)
        safe[list(faults.keys() | broken.keys())] = False
        self.safe = safe

    def __len__(self) -> int:
        return self.size

    def __repr__(self) -> str:
        return f"<Batch: {self.size} cases, {int(self.safe.sum())} safe, {len(self.rules)} rules>"

    def samples(self, rule: str) -> Floats:
        """(size, samples): the margins of a rule, in SI, at every sample of the timeline that it is for all of, or along.

        NaN where undefined, inf where nothing is demanded: where its `where` or `whenever` does not hold. Of a rule for pairs of samples,
        the margin stands at the first of them. Raises E401 for an unknown rule, E406 for one that is not about every sample, or is about other cycles.
        """
        from trackmarshal.backends.samples import Sampled, samples

        info = self._rule(rule)
        try:
            Sampled(info)
        except ValueError as error:
            raise TrackmarshalError(
                "E406", str(error),
                help="there are margins by sample of rules `along` a timeline, and `for all` of its samples, that speak of no other cycle",
            ) from None  # fmt: skip
        rows: list[Floats] = []
        for _, frames in self._frames():
            with self._evaluator.alone:
                rows += samples(self._evaluator.program, info, frames)
        return np.array(rows)

    def case(self, index: int, series: bool = False) -> CaseResult:
        """One case with what decided each rule, and where; raises IndexError."""
        number = range(self.size)[index]
        (frame,) = self._arrays.frames(number, number + 1)
        (judged,) = self._evaluator.judge_all([frame])
        return self._evaluator.result(frame, judged.rated[""], series)

    def _rule(self, name: str) -> RuleInfo:
        for rule in self._evaluator.rules:
            if rule.name == name:
                return rule
        help_ = close_matches(str(name), self.rules) or ", ".join(self.rules)
        raise TrackmarshalError("E401", f"the batch has no rule `{name!s:.40}`", help=help_)

    def _frames(self) -> Iterator[tuple[int, list[Frame]]]:
        for start in range(0, self.size, self._chunk):
            yield start, self._arrays.frames(start, start + self._chunk)
