"""What decided is not kept by generated code: numpy's program looks for it, rules over the run excepted."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, cached_property, partial

from trackmarshal.backends.c.rules import remembers
from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.backends.results import rule_result
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.verdict import VERDICTS, About, RuleResult


class Explaining:
    """Results of rules whose verdicts and margins are known."""

    def __init__(self, spec: Spec, rules: Sequence[RuleInfo]) -> None:
        self._spec, self._rules = spec, rules
        self._over = [remembers(rule) for rule in rules]

    @cached_property
    def _plain(self) -> NumpyProgram:
        return NumpyProgram(self._spec, [rule for rule, over in zip(self._rules, self._over) if not over])

    def of(self, frame: Frame, codes: bytes, margins: Sequence[float]) -> Callable[[int, bool], RuleResult]:
        """Whole results of one frame by the numbers of rules: what numpy finds there is looked for once for all of them."""
        values = cache(lambda: CaseView(self._plain.run([frame]), 0))
        return partial(self._result, frame, values, codes, margins)

    def _result(
        self, frame: Frame, values: Callable[[], CaseView], codes: bytes, margins: Sequence[float], number: int,
        series: bool = False,
    ) -> RuleResult:  # fmt: skip
        rule, said = self._rules[number], (VERDICTS[codes[number]], float(margins[number]))
        if not self._over[number]:
            return rule_result(rule, frame, values(), said, series)
        blocked = frame.unusable(rule.reads)
        reason = "nothing in its range" if said[0] == "inactive" else "" if blocked is None else str(blocked)
        unit = rule.unit if rule.unit != "mixed" else "1"
        return RuleResult(rule.name, *said, unit, None, reason, None, "", (About(frame.number, *said, True),))
