"""Numbers that hardly fit together: measured ones that are compared to the last bit, and angles, percentages and counts beside others.

Angles and percentages are plain numbers, and stay such: that something is one is known from declared units alone, and for these warnings alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import assert_never

from trackmarshal import typed
from trackmarshal.semantics.errors.expressions import WrongDimension
from trackmarshal.semantics.values import behind
from trackmarshal.semantics.warnings.numbers import BareAngle, BarePercentage, ExactlyEqual, NoShare
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import NUMBER, in_full, show

#: What stands in parentheses on the left and on the right of a minus.
_LEFT, _RIGHT = re.compile(r"^if\b"), re.compile(r"\s[+−-]\s|^if\b")
#: Units of an angle, and of a percentage.
ANGLES = ("rad", "deg")
PERCENT = ("%",)
#: What gives an angle, what gives a whole number, and what gives what it takes.
_GIVE_ANGLES = {"atan2", "atan", "asin", "acos"}
_GIVE_WHOLE = {"floor", "ceil", "round", "sign"}
GIVE_ON = {"abs", "min", "max"}


class Advice:
    """Looks at numbers that are put together; `units` are the declared ones of parameters and of the results of tables."""

    def __init__(self) -> None:
        self.units: dict[str, str] = {}
        #: What was found of numbers, which names share: written out, they can be far more than they are.
        self._declared: dict[tuple[tuple[str, ...], typed.Number], bool] = {}
        self._measured: dict[typed.Number, bool] = {}
        self._bare: dict[typed.Number, bool] = {}

    def compared(self, op: str, left: typed.Number, right: typed.Number, span: Span) -> ExactlyEqual | None:
        """What is to be said of a comparison of two numbers of one dimension."""
        if op not in ("==", "!=") or not (self.measured(left) or self.measured(right)):
            return None
        a, b, within = left.span.in_line, right.span.in_line, "<=" if op == "==" else ">"
        whole = typed.literal(right) == 0.0
        difference = a if whole else f"{_operand(a, _LEFT)} - {_operand(b, _RIGHT)}"
        unit = "" if left.dimension == NUMBER else f" {show(left.dimension)}"
        return ExactlyEqual(span, op, f"abs({difference}) {within} ...{unit}")

    def joined(
        self, left: typed.Number, right: typed.Number
    ) -> Iterator[BareAngle | BarePercentage | NoShare]:
        """What is to be said of two numbers that are compared, added or chosen between."""
        if left.dimension != NUMBER:
            return
        for whole, other in ((left, right), (right, left)):
            number = behind(other)
            if isinstance(number, typed.Folded) and number.body is None and self.declared_in(PERCENT, whole):
                hint = f"say of how many: `{whole.span.in_line} * count(...)`"
                yield NoShare(whole.span, other.span, "a count", hint)
            elif self.declared_in(ANGLES, other) and self._is_share(whole):
                yield self._beside_angle(whole, other.span)
            for number in _chosen_from(whole):
                value = typed.literal(number)
                if self._uncounted(number) and self.declared_in(ANGLES, other):
                    yield self.bare(number, other.span)
                elif (
                    value is not None
                    and abs(value) > 1.0
                    and self.is_bare(number)
                    and self.declared_in(PERCENT, other)
                ):
                    yield _bare_share(number.span, other.span, value)

    def _is_share(self, number: typed.Number) -> bool:
        """Whether a number is a percentage, and not an angle besides, of which it was told where they met."""
        return self.declared_in(PERCENT, number) and not self.declared_in(ANGLES, number)

    def counted(self, limit: typed.Number, count: Span) -> NoShare | None:
        """What is to be said of the limit of a count of cycles or samples."""
        share = self.declared_in(PERCENT, limit)
        return NoShare(limit.span, count, "a count", "write how many, without a unit") if share else None

    def _beside_angle(self, share: typed.Number, other: Span | None) -> NoShare:
        hint = f"write it in deg; the angle of a slope is `atan2({share.span.in_line}, 1)`"
        return NoShare(share.span, other, "an angle", hint)

    def in_unit(
        self, value: typed.Number, unit: str, what: str, declared: Span | None
    ) -> BareAngle | NoShare | WrongDimension | None:
        """What is to be said of a plain number where one in a unit is declared.

        A literal without a unit is refused where it is one in % or deg, a hundredth of what it looks like; 1 and rad are the same number.
        """
        if unit in ANGLES and self._is_share(value):
            return self._beside_angle(value, declared)
        # 0 is the same in every unit; and a limit beside a number of another kind, as in `min(share, 1)`, may well be one of that kind.
        numbers = [number for number in _chosen_from(value) if typed.literal(number) != 0.0]
        if value.dimension != NUMBER or not numbers:
            return None
        if unit not in ("1", "rad") and all(map(self.is_bare, numbers)):
            wanted, hint = f"a number in {unit}", f"write the unit: `{numbers[0].span.in_line} {unit}`"
            share = typed.literal(numbers[0])
            if unit in PERCENT and share is not None and abs(share) <= 1.0:
                hint += f", or `{in_full(share, unit)}` where it is a share of a whole"
            return WrongDimension(numbers[0].span, declared, what, wanted, "a bare number", hint)
        return (
            self.bare(numbers[0], declared) if unit in ANGLES and all(map(self._uncounted, numbers)) else None
        )

    def bare(self, value: typed.Number, other: Span | None) -> BareAngle:
        text = value.span.in_line
        hint = (
            f"write `{text} deg` or `{text} rad`"
            if self.is_bare(value) and text[-1:].isdigit()
            else "give it the unit rad or deg where it is declared"
        )
        return BareAngle(value.span, other, hint)

    def _uncounted(self, value: typed.Number) -> bool:
        """Whether nothing says what a number counts: a literal without a unit, or a parameter or a table whose unit is 1."""
        number = behind(value)
        if isinstance(number, typed.Negative):
            number = behind(number.operand)
        return self.is_bare(value) or (
            isinstance(number, typed.Parameter | typed.TableValue)
            and self.units.get(number.symbol.qualified) == "1"
        )

    def is_bare(self, number: typed.Number) -> bool:
        """Whether a number is a literal other than 0 without a unit, or arithmetic on such literals."""
        if number not in self._bare:
            self._bare[number] = self._is_bare(number)
        return self._bare[number]

    def declared_in(self, units: tuple[str, ...], node: typed.Number) -> bool:
        """Whether a plain number is one in some units, as far as it is declared."""
        if (units, node) not in self._declared:
            self._declared[units, node] = self._is_in(units, node)
        return self._declared[units, node]

    def measured(self, node: typed.Number) -> bool:
        """Whether a number comes from measurements: from fields with a unit, or by arithmetic that leaves whole numbers."""
        if node not in self._measured:
            self._measured[node] = self._is_measured(node)
        return self._measured[node]

    def _is_in(self, units: tuple[str, ...], node: typed.Number) -> bool:
        of, angles = partial(self.declared_in, units), units == ANGLES
        match node:
            case typed.Field():
                return self._unit(node) in units
            case typed.Parameter() | typed.TableValue():
                return self.units.get(node.symbol.qualified) in units
            case typed.Negative():
                return of(node.operand)
            case typed.Choice():
                return of(node.then) or of(node.otherwise)
            case typed.NumberCase():
                return any(of(branch.value) for branch in node.branches)
            case typed.Folded():
                return node.body is not None and of(node.body)
            case typed.Function():
                gives = angles and node.name in _GIVE_ANGLES
                return gives or (node.name in GIVE_ON and any(map(of, node.arguments)))
            case typed.Arithmetic():
                left, right = of(node.left), of(node.right)
                if node.op in "+-":
                    return left or right
                # A multiple of an angle is one; of a percentage, it may well be made what it looks like: `100 * share`.
                if not angles or (left == right if node.op == "*" else right or not left):
                    return False
                return not _counts_turns(node)
            case typed.Power():  # a product: of an odd number of angles
                whole = typed.whole_exponent(node.exponent)
                return angles and whole is not None and whole > 0 and whole % 2 == 1 and of(node.base)
            case typed.OnLine():
                return angles and node.function == "direction"
            case typed.Literally():
                return node.unit in units
            case typed.CalledNumber():
                return _said(_result(node), units, node.body, of)
            case typed.NamedNumber():
                return _said(node.unit, units, node.value, of)
            case typed.Kept():
                return any(of(keep.value) for keep in _kept(node))
            case typed.StationGap() | typed.Pi():
                return False
            case _:
                assert_never(node)

    def _is_measured(self, node: typed.Number) -> bool:
        match node:
            case typed.Field():
                return self._unit(node) != "1"
            case typed.Literally() | typed.Pi() | typed.Parameter():
                return False
            case typed.Negative():
                return self.measured(node.operand)
            case typed.Choice():
                return self.measured(node.then) or self.measured(node.otherwise)
            case typed.NumberCase():
                return any(self.measured(branch.value) for branch in node.branches)
            case typed.Folded():
                return node.body is not None and self.measured(node.body)
            case typed.Function():
                if node.name in _GIVE_WHOLE:
                    return False
                return any(map(self.measured if node.name in GIVE_ON else reads, node.arguments))
            case typed.Arithmetic():
                of = reads if node.op == "/" else self.measured
                return of(node.left) or of(node.right)
            case typed.Power():
                whole = typed.whole_exponent(node.exponent)
                if whole is not None and whole > 0:
                    return self.measured(node.base)
                return reads(node.base) or reads(node.exponent)
            case typed.TableValue():
                return any(map(reads, node.arguments))
            case typed.OnLine() | typed.StationGap() | typed.Kept():
                return True
            case typed.CalledNumber():
                return self.measured(node.body)
            case typed.NamedNumber():
                return node.value is not None and self.measured(node.value)
            case _:
                assert_never(node)

    def _is_bare(self, number: typed.Number) -> bool:
        match number:
            case typed.Literally():
                return not number.unit and number.value != 0.0
            case typed.Arithmetic():
                return self.is_bare(number.left) and self.is_bare(number.right)
            case typed.Negative():
                return typed.literal(number.operand) is not None and self.is_bare(number.operand)
            case typed.NamedNumber():
                return number.value is not None and self.is_bare(number.value)
            case _:  # whatever else it is, says what it counts
                return False

    def _unit(self, field: typed.Field) -> str:
        """The unit in which a field is declared; "1" for that of a parameter that nothing is given for."""
        kind = None if field.record.signal is None else field.record.signal.field(field.name)
        return "1" if kind is None else kind.unit


def _bare_share(number: Span, other: Span, value: float) -> BarePercentage:
    hint = f"write `{in_full(value, '1')} %`"
    if abs(value) <= 2.0:
        hint += f", or `{in_full(value, '%')}` where it is so many times the whole"
    return BarePercentage(number, other, in_full(value, "%"), hint)


def _counts_turns(node: typed.Arithmetic) -> bool:
    """Whether a multiple of an angle is one no more, as it is divided by pi: `angle * 180 / pi`, and `180 / pi * angle`."""
    if node.op == "/":
        return not reads(node.right) and any(isinstance(part, typed.Pi) for part in typed.below(node.right))
    sides = (behind(node.left), behind(node.right))
    return any(
        isinstance(side, typed.Arithmetic) and side.op == "/" and not reads(side) and _counts_turns(side)
        for side in sides
    )


def _kept(node: typed.Kept) -> Iterator[typed.Keep]:
    """Where a machine takes note of what is read of it; nowhere for how long it is in its state."""
    return (keep for one in node.machine.transitions for keep in one.kept if keep.name == node.name)


def _said(
    unit: str, units: tuple[str, ...], value: typed.Number | None, of: Callable[[typed.Number], bool]
) -> bool:
    """Whether a number is in one of some units by what a definition says of it; where it says of no angle and no share, by what it comes to."""
    if unit in (*ANGLES, *PERCENT):
        return unit in units
    return value is not None and of(value)


def _result(call: typed.CalledNumber) -> str:
    """The unit in which a definition declares its value; "" where it declares none."""
    item = call.symbol.item
    return (isinstance(item, ast.Define) and item.result) or ""


def _chosen_from(number: typed.Number) -> list[typed.Number]:
    """The numbers of which one is this one: the branches of a `case` or an `if`, and what `min` and `max` take; else itself."""
    found: list[typed.Number] = []
    seen: set[typed.Number] = set()
    stack = [number]
    while stack:
        part = stack.pop()
        match meant := behind(part):
            case _ if meant in seen:  # written out, they can be far more than they are
                continue
            case typed.Choice():
                stack += [meant.otherwise, meant.then]
            case typed.NumberCase():
                stack += [branch.value for branch in reversed(meant.branches)]
            case typed.Function() if meant.name in ("min", "max"):
                stack += reversed(meant.arguments)
            case _:
                found.append(part)
        seen.add(meant)
    return found


def _operand(text: str, loose: re.Pattern[str]) -> str:
    return f"({text})" if loose.search(text) else text


def reads(node: typed.Number) -> bool:
    """Whether a number depends on an input."""
    return any(isinstance(part, _READING) for part in typed.below(node))


_READING = (
    typed.Field,
    typed.MemberField,
    typed.OnLine,
    typed.StationGap,
    typed.RegionNode,
    typed.InZone,
    typed.InStretch,
)
