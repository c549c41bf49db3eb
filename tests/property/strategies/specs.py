"""Generated specs with inputs as hypothesis strategies: the generator of `support.generated`, with decisions that shrink."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st

from support.generated import Laws, Subject, laws, subject

T = TypeVar("T")

#: The same examples in every run, and no wall time in a verdict: a loaded machine is slow, not wrong.
repeatable = settings(
    derandomize=True,
    deadline=None,
    database=None,
    phases=(Phase.explicit, Phase.generate, Phase.shrink),
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


class DrawnChoices:
    """Decisions drawn by hypothesis."""

    def __init__(self, draw: Callable[..., Any]) -> None:
        self._draw = draw

    def pick(self, options: Sequence[T]) -> T:
        return options[self.integer(0, len(options) - 1)]

    def integer(self, low: int, high: int) -> int:
        return low if low == high else self._draw(st.integers(low, high))

    def real(self, low: float, high: float) -> float:
        drawn: float = self._draw(st.floats(low, high))
        return drawn

    def chance(self, percent: int) -> bool:
        return percent > 0 and self._draw(st.integers(0, 99)) >= 100 - percent


@st.composite
def subjects(draw: st.DrawFn, geometry: bool = False, inexact: str = "no") -> Subject:
    """A spec with one rule, and up to three cases for it."""
    return subject(DrawnChoices(draw), rules=1, depth=3, cases=3, inexact=inexact, geometry=geometry)


@st.composite
def equivalents(draw: st.DrawFn) -> Laws:
    """A spec whose rules come in pairs that say the same thing, and cases for it."""
    return laws(DrawnChoices(draw), depth=2, cases=3)
