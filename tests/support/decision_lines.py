"""A decision of the Supervisor in Python in the words in which the emitted example prints its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from trackmarshal.backends.c.cycles import integer, label, word
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.machine import DRIVE

LETTERS = "svuio"


def decision_lines(decision: Decision) -> Iterator[str]:
    """The lines of one step; docs/generated-c.md describes them."""
    driven, stored = decision.driven, decision.fallback
    what = "nothing" if driven is None else "driving" if decision.state == DRIVE else "stored"
    words = ["decision", decision.state, "safe" if decision.safe else "unsafe", what]
    first = 0
    if driven is not None:
        first = driven.first(decision.now)
        words += [integer(driven.number), _word(driven.t), integer(first)]
    yield " ".join(words)
    yield _line("clock", (decision.now, decision.finished, decision.valid_until))
    if stored is not None:
        yield f"stored {integer(stored.number)} {_word(stored.t)}"
    if driven is not None:
        names = driven.columns.names
        flags = [integer(int(driven.columns.column(name)[first])) for name in names.flags]
        yield " ".join([_line("sample", driven.matrix[:, first].tolist()), *flags])
    if decision.judged is not None:
        for name in (DRIVING, EMERGENCY):
            rated = decision.judged.rated[name]
            letters = "".join(LETTERS[code] for code in rated.verdicts)
            yield _line(f"{name} {letters}", [float(margin) for margin in rated.margins])
    for fault in decision.faults:
        index = [] if fault.index is None else [integer(fault.index)]
        yield " ".join(["fault", name_of(fault), label(fault.signal), label(fault.field), *index])
    for violation in decision.violations:
        said = f"rule {violation.candidate} {label(violation.rule)} {violation.verdict}"
        yield _line(said, [violation.margin])
    if decision.lost:
        yield f"lost {decision.lost}"
    if decision.more:
        yield "more"


def _line(begin: str, numbers: Sequence[float]) -> str:
    return " ".join([begin, *map(_word, numbers)])


def _word(x: float) -> str:
    return word(math.nan if math.isnan(x) else x)
