"""What compiles and is hardly meant: warnings, each of which a rule may allow with a reason.

An angle is a plain number, and stays one: that something is an angle is known from declared units alone, and for these warnings alone.
"""

from __future__ import annotations

import re
from typing import assert_never

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import SignalType
from trackmarshal.semantics import errors
from trackmarshal.semantics.errors import BareAngle, ExactlyEqual, WrongDimension
from trackmarshal.semantics.values import NumberValue
from trackmarshal.source import Span
from trackmarshal.units import NUMBER, show

#: What stands in parentheses on the left and on the right of a minus.
_LEFT, _RIGHT = re.compile(r"^if\b"), re.compile(r"\s[+−-]\s|^if\b")
#: Units of an angle.
ANGLES = ("rad", "deg")
#: What gives an angle, what gives a whole number, and what gives what it takes.
_GIVE_ANGLES = {"atan2", "atan", "asin", "acos"}
_GIVE_WHOLE = {"floor", "ceil", "round", "sign"}
_GIVE_ON = {"abs", "min", "max"}


def warnings() -> set[str]:
    """The codes of all warnings."""
    kinds = (
        kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, Diagnostic)
    )
    return {kind.code for kind in kinds if kind.level == "warning"}


class Advice:
    """Looks at numbers that are put together; `units` are the declared ones of parameters and of the results of tables."""

    def __init__(self, signals: dict[str, SignalType]) -> None:
        self._signals = signals
        self.units: dict[str, str] = {}
        #: What was found of numbers, which formulas share: written out, they can be far more than they are.
        self._angles: dict[ir.Num, bool] = {}
        self._measured: dict[ir.Num, bool] = {}

    def compared(self, op: str, left: NumberValue, right: NumberValue, span: Span) -> ExactlyEqual | None:
        """What is to be said of a comparison of two numbers of one dimension."""
        if op not in ("==", "!=") or not (self.measured(left.node) or self.measured(right.node)):
            return None
        a, b, within = _text(left), _text(right), "<=" if op == "==" else ">"
        whole = isinstance(right.node, ir.Const) and right.node.value == 0.0
        difference = a if whole else f"{_operand(a, _LEFT)} - {_operand(b, _RIGHT)}"
        unit = "" if left.dimension == NUMBER else f" {show(left.dimension)}"
        return ExactlyEqual(span, op, f"abs({difference}) {within} ...{unit}")

    def joined(self, left: NumberValue, right: NumberValue) -> BareAngle | None:
        """What is to be said of two numbers that are compared, added or chosen between."""
        for number, other in ((left, right), (right, left)):
            if left.dimension == NUMBER and self._bare(number) and self.angle(other.node):
                return self.bare(number, other.span)
        return None

    def in_unit(
        self, value: NumberValue, unit: str, what: str, declared: Span | None
    ) -> BareAngle | WrongDimension | None:
        """What is to be said of a plain number where one in a unit is declared.

        A literal without a unit is refused where it is one in % or deg, a hundredth of what it looks like; 1 and rad are the same number.
        """
        if value.bare and unit not in ("1", "rad") and value.dimension == NUMBER:
            wanted, hint = f"a number in {unit}", f"write the unit: `{_text(value)} {unit}`"
            return WrongDimension(value.span, declared, what, wanted, "a bare number", hint)
        return self.bare(value, declared) if unit in ANGLES and self._bare(value) else None

    def bare(self, value: NumberValue, other: Span | None) -> BareAngle:
        text = _text(value)
        hint = (
            f"write `{text} deg` or `{text} rad`"
            if value.bare and text[-1:].isdigit()
            else "give it the unit rad or deg where it is declared"
        )
        return BareAngle(value.span, other, hint)

    def _bare(self, value: NumberValue) -> bool:
        """Whether nothing says what a number counts: a literal without a unit, or a parameter whose unit is 1."""
        node = value.node.operand if isinstance(value.node, ir.Neg) else value.node
        return value.bare or (isinstance(node, ir.Param) and self.units.get(node.name) == "1")

    def angle(self, node: ir.Num) -> bool:
        """Whether a plain number is an angle by the units that were declared."""
        if node not in self._angles:
            self._angles[node] = self._is_angle(node)
        return self._angles[node]

    def measured(self, node: ir.Num) -> bool:
        """Whether a number comes from measurements: from fields with a unit, or by arithmetic that leaves whole numbers."""
        if node not in self._measured:
            self._measured[node] = self._is_measured(node)
        return self._measured[node]

    def _is_angle(self, node: ir.Num) -> bool:
        match node:
            case ir.Column():
                return self._unit(node.axis.signal, node.field) in ANGLES
            case ir.Sample() | ir.Scalar():
                return self._unit(node.signal, node.field) in ANGLES
            case ir.Param():
                return self.units.get(node.name) in ANGLES
            case ir.Lookup():
                return self.units.get(node.table) in ANGLES
            case ir.Neg():
                return self.angle(node.operand)
            case ir.Choose():
                return self.angle(node.then) or self.angle(node.otherwise)
            case ir.Func():
                return node.name in _GIVE_ANGLES or (
                    node.name in _GIVE_ON and any(map(self.angle, node.args))
                )
            case ir.Arith():
                left, right = self.angle(node.left), self.angle(node.right)
                return (
                    left or right
                    if node.op in "+-"
                    else left != right
                    if node.op == "*"
                    else left and not right
                )
            case ir.Direction():
                return True
            case ir.Station() | ir.Offset() | ir.Distance() | ir.StationGap() | ir.Const():
                return False
            case _:
                assert_never(node)

    def _is_measured(self, node: ir.Num) -> bool:
        match node:
            case ir.Column():
                return self._unit(node.axis.signal, node.field) != "1"
            case ir.Sample() | ir.Scalar():
                return self._unit(node.signal, node.field) != "1"
            case ir.Const() | ir.Param():
                return False
            case ir.Neg():
                return self.measured(node.operand)
            case ir.Choose():
                return self.measured(node.then) or self.measured(node.otherwise)
            case ir.Func():
                if node.name in _GIVE_WHOLE:
                    return False
                return any(map(self.measured if node.name in _GIVE_ON else _reads, node.args))
            case ir.Arith():
                of = _reads if node.op == "/" else self.measured
                return of(node.left) or of(node.right)
            case ir.Lookup():
                return _reads(node.argument)
            case ir.Station() | ir.Offset() | ir.Direction() | ir.Distance() | ir.StationGap():
                return True
            case _:
                assert_never(node)

    def _unit(self, signal: str, field: str) -> str:
        kind = self._signals[signal].field(field)
        assert kind is not None
        return kind.unit


def _text(value: NumberValue) -> str:
    """What the author wrote, on one line."""
    return " ".join(value.span.text.split())


def _operand(text: str, loose: re.Pattern[str]) -> str:
    return f"({text})" if loose.search(text) else text


def _reads(node: ir.Num) -> bool:
    """Whether a number depends on an input."""
    return any(isinstance(part, (ir.Column, ir.Sample, ir.Scalar, ir.Along)) for part in ir.below(node))
