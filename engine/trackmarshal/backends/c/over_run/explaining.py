"""What decided is not kept by generated code: numpy's program looks for it, rules over the run excepted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property, partial
from types import MappingProxyType

from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.backends.over_run.lives import Without, no_place
from trackmarshal.backends.results import rule_result
from trackmarshal.ir.margins import undecided
from trackmarshal.ir.spec import RuleInfo, Spec, remembers
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

    def of(
        self, frame: Frame, codes: bytes, margins: Sequence[float], about: Mapping[int, tuple[About, ...]] = MappingProxyType({}),
        without: Without = MappingProxyType({}),
    ) -> Callable[[int, bool], RuleResult]:  # fmt: skip
        """Whole results of one frame by the numbers of rules: what numpy finds there is looked for once for all of them.

        about: what rules that look ahead say of which cycles, by their numbers; without: the elements that found no place.
        """
        values = cache(lambda: CaseView(self._plain.run([frame]), 0))
        return partial(self._result, frame, values, codes, margins, about, without)

    def _result(
        self, frame: Frame, values: Callable[[], CaseView], codes: bytes, margins: Sequence[float],
        about: Mapping[int, tuple[About, ...]], without: Without, number: int, series: bool = False,
    ) -> RuleResult:  # fmt: skip
        rule, said = self._rules[number], (VERDICTS[codes[number]], float(margins[number]))
        if not self._over[number]:
            return rule_result(rule, frame, values(), said, series)
        blocked = frame.unusable(rule.reads)
        reason = "nothing in its range" if said[0] == "inactive" else "" if blocked is None else str(blocked)
        if said[0] == "undefined" and blocked is None:
            reason = no_place(rule, without)
        own = about.get(number) if blocked is None else None
        told = own or (About(frame.number, *said, said[0] != "open"),)
        if rule.course is not None:  # it is about this cycle alone
            told = ()
        return RuleResult(rule.name, *said, undecided(rule.unit), None, reason, None, "", told, rule.advisory)
