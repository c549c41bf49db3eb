"""The operators of the core: one table, which semantics, every evaluator and the search for witnesses go by. What is written in
other words (`typed.base`) is rewritten to these by `lowering`.

What an operator is called is a `Literal`: a `match` over it ends in `assert_never`, so that mypy names the evaluator
that forgets one. What the evaluators would otherwise each know of it by name stands in its entry.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Literal, NamedTuple, TypeVar

ArithmeticOp = Literal["+", "-", "*", "/"]
ComparisonOp = Literal["<", "<=", "==", "!=", "is"]
ConnectiveOp = Literal["and", "or", "iff", "xor"]
Quantifier = Literal["for all", "exists"]
TemporalOp = Literal["always", "eventually", "historically", "once"]
UntilOp = Literal["until", "since"]
FoldOp = Literal["sum", "least", "greatest", "nearest"]
RunOp = Literal["always", "eventually", "historically", "once", "until", "since", "next", "previous"]
FunctionName = Literal[
    "abs", "sign", "sqrt", "hypot", "floor", "ceil", "round", "min", "max", "pow", "exp", "log",
    "sin", "cos", "tan", "asin", "acos", "atan2", "tanh",
]  # fmt: skip


class Measure(Enum):
    """The margin of a comparison of `left` and `right`: how far inside it is."""

    ROOM = "right - left"
    NEARNESS = "-|left - right|"
    DISTANCE = "|left - right|"
    SAMENESS = "infinite where left is right, and minus infinite elsewhere"


class Comparison(NamedTuple):
    """A comparison's margin, and whether it holds where that is 0."""

    measure: Measure
    holds_at_zero: bool


class Extreme(Enum):
    """What many values become: all of them hold and the least margin counts, or one of them does and the greatest counts."""

    LEAST = "least"
    GREATEST = "greatest"

    @property
    def neutral(self) -> tuple[bool, float]:
        """Whether nothing holds, and its margin: what changes nothing when it is added."""
        return (True, float("inf")) if self is Extreme.LEAST else (False, float("-inf"))

    @property
    def decisive(self) -> str:
        """The verdict that one of many gives all of them."""
        return "violated" if self is Extreme.LEAST else "satisfied"


class Window(NamedTuple):
    """A temporal operator over a window: into the past or the future, and what the samples become."""

    past: bool
    extreme: Extreme


class Dimensions(Enum):
    """What dimensions a function takes, and what it gives."""

    KEPT = "all arguments of one, which the value has"
    ROOT = "any; the value's is its square root"
    DROPPED = "all arguments of one; the value is a plain number"
    PLAIN = "plain numbers alone"


class Function(NamedTuple):
    """A function of numbers.

    `more`: more arguments than `arity` are taken pair by pair, from the left. `libm`: the C library computes it, and others
    than the platform's may give a neighbouring double; the others are exact, or defined step by step, and alike everywhere.
    """

    arity: int
    dimensions: Dimensions
    libm: bool = False
    more: bool = False


#: Comparisons of two numbers; `is` those of the places of members, which are as far apart as true and false are.
COMPARISONS: dict[ComparisonOp, Comparison] = {
    "<": Comparison(Measure.ROOM, False), "<=": Comparison(Measure.ROOM, True),
    "==": Comparison(Measure.NEARNESS, True), "!=": Comparison(Measure.DISTANCE, False),
    "is": Comparison(Measure.SAMENESS, True),
}  # fmt: skip
#: Arithmetic; dimensions are added for `*`, subtracted for `/`, equal for the other two.
ARITHMETIC: tuple[ArithmeticOp, ...] = ("+", "-", "*", "/")
#: Connectives of two formulas.
CONNECTIVES: tuple[ConnectiveOp, ...] = ("and", "or", "iff", "xor")
#: Quantifiers, by what the elements become.
QUANTIFIERS: dict[Quantifier, Extreme] = {"for all": Extreme.LEAST, "exists": Extreme.GREATEST}
#: Temporal operators over one formula.
TEMPORAL: dict[TemporalOp, Window] = {
    "always": Window(False, Extreme.LEAST), "eventually": Window(False, Extreme.GREATEST),
    "historically": Window(True, Extreme.LEAST), "once": Window(True, Extreme.GREATEST),
}  # fmt: skip
#: Temporal operators over two formulas, by whether they look into the past.
UNTIL: dict[UntilOp, bool] = {"until": False, "since": True}
#: Operators over the run, by whether they look into the past.
OVER_RUN: dict[RunOp, bool] = {
    "always": False, "eventually": False, "until": False, "next": False,
    "historically": True, "once": True, "since": True, "previous": True,
}  # fmt: skip

_PLAIN, _KEPT = Dimensions.PLAIN, Dimensions.KEPT
#: Functions of numbers.
FUNCTIONS: dict[FunctionName, Function] = {
    "abs": Function(1, _KEPT), "sign": Function(1, Dimensions.DROPPED), "sqrt": Function(1, Dimensions.ROOT),
    "hypot": Function(2, _KEPT), "min": Function(2, _KEPT, more=True), "max": Function(2, _KEPT, more=True),
    "floor": Function(1, _PLAIN), "ceil": Function(1, _PLAIN), "round": Function(1, _PLAIN),
    "pow": Function(2, _PLAIN, libm=True), "exp": Function(1, _PLAIN, libm=True), "log": Function(1, _PLAIN, libm=True),
    "sin": Function(1, _PLAIN, libm=True), "cos": Function(1, _PLAIN, libm=True), "tan": Function(1, _PLAIN, libm=True),
    "asin": Function(1, _PLAIN, libm=True), "acos": Function(1, _PLAIN, libm=True), "tanh": Function(1, _PLAIN, libm=True),
    "atan2": Function(2, Dimensions.DROPPED, libm=True),
}  # fmt: skip

Op = TypeVar("Op", bound=str)


def known(op: str, table: Mapping[Op, object] | tuple[Op, ...]) -> Op:
    """An operator of a table, by what a spec calls it; raises AssertionError for one that is not in it."""
    for name in table:
        if name == op:
            return name
    raise AssertionError(f"unknown operator {op}")
