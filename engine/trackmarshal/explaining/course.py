"""A cycle with the course that a rule lives along, made anew of all cycles before it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from trackmarshal.backends.over_run.history import Past
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.course import Courses

if TYPE_CHECKING:
    from trackmarshal.backends.reference.evaluator import Reference


def along_course(rule: RuleInfo, cycles: Sequence[Past]) -> Reference:
    """The values of the last cycle. Raises AssertionError where cycles are not kept whole."""
    from trackmarshal.backends.reference.evaluator import Reference

    courses = Courses([rule])
    state = courses.start()
    for past in cycles[:-1]:
        state = courses.missed(state, past.missed)
        assert past.now is not None, "cycles are kept whole where they are explained"
        state = courses.commit(state, past.now.frame)
    last = cycles[-1]
    assert last.now is not None
    state = courses.missed(state, last.missed)
    return Reference(last.now.values.spec, courses.joined(state, last.now.frame))
