"""Rules, and assumptions with a monitor, clause by clause."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, TypeAlias

from trackmarshal.ir.nodes import JudgedAt
from trackmarshal.ir.operators import Quantifier
from trackmarshal.source import Span
from trackmarshal.typed.base import Typed
from trackmarshal.typed.formulas import Formula
from trackmarshal.typed.numbers import Number
from trackmarshal.typed.things import Range

if TYPE_CHECKING:
    from trackmarshal.typed import Value


class Along(Typed):
    """`along plan as p at last`: the rule's timeline, its variable, and the sample at which it is judged; said: it is written."""

    range: Range
    place: JudgedAt
    said: bool
    span: Span


class Whenever(Typed):
    """`whenever blue_flag`: only where this holds, the rule applies."""

    condition: Formula
    span: Span


class Deadline(Typed):
    """`within 5 s`: the demand is met at some time from a cycle of the `whenever` until then, in s."""

    limit: Number
    seconds: float
    span: Span


class ForEach(Typed):
    """`for all o in objects where c`, `exists ...`: all clauses below are about its variables; `by`: of all, only the one of which this is least."""

    quantifier: Quantifier
    range: Range
    where: Formula | None
    by: Number | None
    span: Span


class Except(Typed):
    """`except o behind ego "why"`: elements that the quantifier `of` leaves out."""

    of: ForEach
    condition: Formula
    reason: str
    span: Span


class Let(Typed):
    """`let needed = ...`."""

    name: str
    value: Value
    span: Span


class Require(Typed):
    """`require FORMULA`; `monitor FORMULA` in an assumption."""

    keyword: Literal["require", "monitor"]
    condition: Formula
    span: Span


#: What a rule's formula is made of; its other clauses say where it comes from.
Clause: TypeAlias = Along | Whenever | Deadline | ForEach | Except | Let | Require


class Rule(Typed):
    """A rule or an assumption: the clauses that its meaning is made of, in the order written."""

    name: str
    title: str
    clauses: tuple[Clause, ...]
    span: Span

    @property
    def condition(self) -> Formula:
        """What it requires."""
        return next(clause.condition for clause in self.clauses if isinstance(clause, Require))
