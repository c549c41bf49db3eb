"""The program of each evaluator: that of rules without a memory, or that of rules over the run. Each is imported when it is wanted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from trackmarshal.backends.over_run.program import Remembering
from trackmarshal.ir.spec import remembers

if TYPE_CHECKING:
    from trackmarshal.ir.spec import RuleInfo, Spec
    from trackmarshal.runtime.program import Program


def reference(spec: Spec, rules: Sequence[RuleInfo]) -> Program:
    """The literal evaluator."""
    from trackmarshal.backends.reference.evaluator import ReferenceProgram
    from trackmarshal.backends.reference.over_run import KeepingAll

    if not any(map(remembers, rules)):
        return ReferenceProgram(spec, rules)
    return Remembering(spec, rules, ReferenceProgram, KeepingAll)


def numpy(spec: Spec, rules: Sequence[RuleInfo]) -> Program:
    """The vectorised evaluator."""
    from trackmarshal.backends.numpy.program import NumpyProgram
    from trackmarshal.backends.over_run.streaming import Streaming

    if not any(map(remembers, rules)):
        return NumpyProgram(spec, rules)
    return Remembering(spec, rules, NumpyProgram, Streaming)


def generated(spec: Spec, rules: Sequence[RuleInfo]) -> Program:
    """Generated C, compiled; raises TrackmarshalError E470 to E473 where it cannot be had."""
    from trackmarshal.backends.c.over_run.program import CRemembering
    from trackmarshal.backends.c.program import CProgram

    made = (CRemembering if any(map(remembers, rules)) else CProgram)(spec, rules)
    made.library_for()
    return made
