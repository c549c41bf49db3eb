"""What compiles and is hardly meant: warnings, each of which a rule may allow with a reason.

Angles and percentages are plain numbers, and stay such: that something is one is known from declared units alone, and for these warnings alone.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator
from functools import partial
from typing import TypeAlias, TypeGuard, assert_never

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.semantics import errors
from trackmarshal.semantics.errors import (
    BareAngle,
    BarePercentage,
    EndsEarly,
    ExactlyEqual,
    GoesOn,
    JoinsConditions,
    LapsOver,
    MetByOthers,
    NoShare,
    SameEverywhere,
    TurnsOver,
    WrongDimension,
)
from trackmarshal.semantics.values import on_open_line
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.notation import ASKED
from trackmarshal.units import NUMBER, in_full, show

#: What stands in parentheses on the left and on the right of a minus.
_LEFT, _RIGHT = re.compile(r"^if\b"), re.compile(r"\s[+−-]\s|^if\b")
#: Units of an angle, and of a percentage.
ANGLES = ("rad", "deg")
PERCENT = ("%",)
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


def ends_early(expr: ast.Binary) -> EndsEarly | None:
    """What is to be said of a connective whose left side ends with a quantifier, or with `always`, that may have been meant to go on.

    Of a quantifier before `and` and `or` it makes no difference, or next to none, how far it goes, and the formatter shows where it ends.
    """
    last: ast.Expr | None = expr.left
    while last is not None and not ast.is_parenthesised(last):
        below = _ending(last)
        word = last.quantifier if isinstance(last, ast.Quantified) else "always" if _always(last) else ""
        if word and word != "always" and expr.op not in ASKED:
            return None
        if word and below is not None and not ast.is_parenthesised(below):
            return EndsEarly(last.__dict__["span"], word, expr.op)
        last = below
    return None


def changes(axis: typed.TimeAxis, formula: typed.Formula) -> bool:
    """Whether a formula without temporal operators may be another one at another sample of a timeline, or in another cycle."""
    parts = list(typed.below(formula))
    if any(isinstance(part, _OVER_TIME) for part in parts):
        return False
    if isinstance(axis, typed.Range):
        return any(_is_sample(part, axis) for part in parts)
    return not isinstance(formula, typed.Boolean)


def joins_conditions(expr: ast.Binary) -> JoinsConditions | None:
    """What is to be said of `a implies b and c implies d`, which reads as two consequences, and demands nothing of `b`."""
    left, right = expr.left, expr.right
    if _leads_on(right):
        middle, op = right.left, right.op
    elif _leads_on(left):
        while _leads_on(left.right):
            left = left.right
        middle, op = left.right, left.op
    else:
        return None
    if isinstance(middle, ast.Binary) and middle.op in ("and", "or") and not ast.is_parenthesised(middle):
        return JoinsConditions(middle.__dict__["span"], middle.op, op)
    return None


#: What comes of one for which, or of a cycle in which, the left side of an `implies` does not hold.
_MET = {
    "exists": "one for which that does not hold is enough", "where": "all for which that does not hold are in the range",
    "whenever": "the rule applies wherever that does not hold", "except": "all for which that does not hold are left out",
    "once": "a time at which that did not hold is enough", "eventually": "a time at which that does not hold is enough",
    "within": "a cycle in which that does not hold meets the demand", "until": "a time at which that does not hold ends the wait",
    "since": "a time at which that did not hold is enough", "count": "all in which that does not hold count",
    "reset": "the count starts anew wherever that does not hold",
}  # fmt: skip


def met_by_others(
    word: str, condition: ast.Expr | None, sought: Collection[str] | None = None
) -> MetByOthers | None:
    """What is to be said of an `implies` of which one that meets it is looked for, or those that do are picked.

    sought: the names of those that are looked for; where its left side is about none of them, no other one meets it.
    """
    if word not in _MET or not isinstance(condition, ast.Binary) or condition.op != "implies":
        return None
    if sought is not None and ast.names_in(condition.left).isdisjoint(sought):
        return None
    return MetByOthers(condition.__dict__["span"], word, _MET[word])


#: What ranges over a timeline.
_OVER_TIME = (typed.Temporal, typed.Until, typed.Step, typed.Edge, typed.CountComparison)


def same_everywhere(
    word: str, axis: typed.TimeAxis, *operands: typed.Formula | None
) -> SameEverywhere | None:
    """What is to be said of a temporal operator along a timeline that is about something else, such as an event: that is of the cycle, and does not change."""
    if not isinstance(axis, typed.Range) or not axis.signal.name:  # the run, or a definition by itself
        return None
    for operand in operands:
        if operand is None or isinstance(operand, typed.Boolean):
            continue
        parts = typed.below(operand)
        if not any(_is_sample(part, axis) or isinstance(part, _OVER_TIME) for part in parts):
            return SameEverywhere(operand.span, word, axis.signal.name)
    return None


def _is_sample(part: typed.Typed, axis: typed.Range) -> bool:
    return isinstance(part, typed.Variable) and part.range is axis


def _leads_on(expr: ast.Expr) -> TypeGuard[ast.Binary]:
    return isinstance(expr, ast.Binary) and expr.op in ASKED and not ast.is_parenthesised(expr)


def goes_on(expr: ast.Temporal) -> GoesOn | None:
    """What is to be said of `previous (a) - b <= c`, which reads as the `a` of before beside the `b` of now, and is neither.

    Where nothing else comes from the input, both come to the same.
    """
    whole = expr.operand
    if ast.is_parenthesised(whole):
        return None
    first = whole
    while not ast.is_parenthesised(first):
        if isinstance(first, ast.Binary) and first.op not in typed.CONNECTIVES:
            first = first.left
        elif isinstance(first, ast.Chained):
            first = first.operands[0]
        else:
            return None
    read, inside = (sum(isinstance(node, ast.Attribute) for node in part.walk()) for part in (whole, first))
    return GoesOn(whole.__dict__["span"], expr.op, first.__dict__["span"].text) if read > inside else None


def _always(expr: ast.Expr) -> bool:
    return isinstance(expr, ast.Temporal) and expr.op == "always"


def _ending(expr: ast.Expr) -> ast.Expr | None:
    """What a formula ends with, where that is a formula that may go on."""
    match expr:
        case ast.Binary() | ast.Until():
            return expr.right
        case ast.Unary() | ast.Temporal():
            return expr.operand
        case ast.Quantified():
            return expr.body
        case _:
            return None


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
        a, b, within = _text(left), _text(right), "<=" if op == "==" else ">"
        whole = typed.literal(right) == 0.0
        difference = a if whole else f"{_operand(a, _LEFT)} - {_operand(b, _RIGHT)}"
        unit = "" if left.dimension == NUMBER else f" {show(left.dimension)}"
        return ExactlyEqual(span, op, f"abs({difference}) {within} ...{unit}")

    def turns_over(self, left: typed.Number, right: typed.Number, span: Span) -> TurnsOver | None:
        """What is to be said of a comparison of two headings, or of how far they are apart, where nothing takes whole turns out of it."""
        one, other = _but_for_constants(left, _turns), _but_for_constants(right, _turns)
        if one is not None and other is not None and (_leads(one) or _leads(other)):
            return TurnsOver(span, _text(one), _text(other), "179 deg and -179 deg are no 358 deg apart")
        apart = next((found for number in (left, right) if (found := _apart(number)) is not None), None)
        return None if apart is None else TurnsOver(apart.span, _text(apart.left), _text(apart.right))

    def laps_over(self, left: typed.Number, right: typed.Number, span: Span) -> LapsOver | None:
        """The same of stations of a line that may be closed, one beside another: a station and a constant are a place."""
        one, other = _but_for_constants(left, _stands), _but_for_constants(right, _stands)
        if one is not None and other is not None:
            return LapsOver(span, _text(other), _text(one))
        found = (_apart(number, _both_stand) for number in (left, right))
        apart = next((each for each in found if each is not None), None)
        return None if apart is None else LapsOver(apart.span, _text(apart.right), _text(apart.left))

    def between(self, op: str, left: typed.Number, right: typed.Number, span: Span) -> TurnsOver | None:
        """What is to be said of arithmetic that takes a heading between two others from their numbers."""
        if left.dimension != NUMBER or right.dimension != NUMBER:  # mostly
            return None
        one, other = _behind(left), _behind(right)
        ends: _Ends | None = None
        if op == "+":
            ends = _shares(one, other) or _on_the_way(one, other) or _on_the_way(other, one)
        elif op in ("*", "/"):
            ends = _summed(one, other) or (_summed(other, one) if op == "*" else None)
        elif op != "-":
            raise AssertionError(f"unknown operator {op}")
        return None if ends is None else TurnsOver(span, _text(ends[0]), _text(ends[1]), _THROUGH)

    def joined(
        self, left: typed.Number, right: typed.Number
    ) -> Iterator[BareAngle | BarePercentage | NoShare]:
        """What is to be said of two numbers that are compared, added or chosen between."""
        if left.dimension != NUMBER:
            return
        for whole, other in ((left, right), (right, left)):
            number = _behind(other)
            if isinstance(number, typed.Folded) and number.body is None and self.declared_in(PERCENT, whole):
                hint = f"say of how many: `{_text(whole)} * count(...)`"
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
        hint = f"write it in deg; the angle of a slope is `atan2({_text(share)}, 1)`"
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
            wanted, hint = f"a number in {unit}", f"write the unit: `{_text(numbers[0])} {unit}`"
            share = typed.literal(numbers[0])
            if unit in PERCENT and share is not None and abs(share) <= 1.0:
                hint += f", or `{in_full(share, unit)}` where it is a share of a whole"
            return WrongDimension(numbers[0].span, declared, what, wanted, "a bare number", hint)
        return (
            self.bare(numbers[0], declared) if unit in ANGLES and all(map(self._uncounted, numbers)) else None
        )

    def bare(self, value: typed.Number, other: Span | None) -> BareAngle:
        text = _text(value)
        hint = (
            f"write `{text} deg` or `{text} rad`"
            if self.is_bare(value) and text[-1:].isdigit()
            else "give it the unit rad or deg where it is declared"
        )
        return BareAngle(value.span, other, hint)

    def _uncounted(self, value: typed.Number) -> bool:
        """Whether nothing says what a number counts: a literal without a unit, or a parameter or a table whose unit is 1."""
        number = _behind(value)
        if isinstance(number, typed.Negative):
            number = _behind(number.operand)
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
                return gives or (node.name in _GIVE_ON and any(map(of, node.arguments)))
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
                return any(map(self.measured if node.name in _GIVE_ON else _reads, node.arguments))
            case typed.Arithmetic():
                of = _reads if node.op == "/" else self.measured
                return of(node.left) or of(node.right)
            case typed.Power():
                whole = typed.whole_exponent(node.exponent)
                if whole is not None and whole > 0:
                    return self.measured(node.base)
                return _reads(node.base) or _reads(node.exponent)
            case typed.TableValue():
                return any(map(_reads, node.arguments))
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
        return not _reads(node.right) and any(isinstance(part, typed.Pi) for part in typed.below(node.right))
    sides = (_behind(node.left), _behind(node.right))
    return any(
        isinstance(side, typed.Arithmetic) and side.op == "/" and not _reads(side) and _counts_turns(side)
        for side in sides
    )


def _kept(node: typed.Kept) -> Iterator[typed.Keep]:
    """Where a machine takes note of what is read of it; nowhere for how long it is in its state."""
    return (keep for one in node.machine.transitions for keep in one.kept if keep.name == node.name)


def _leads_apart(left: typed.Number, right: typed.Number) -> bool:
    """Whether a difference is one of two headings, or of one and a bearing or a constant."""
    sides = (left, right)
    return any(map(_leads, sides)) and all(_turns(one) or not _reads(one) for one in sides)


def _apart(
    node: typed.Number, of: Callable[[typed.Number, typed.Number], bool] = _leads_apart
) -> typed.Arithmetic | None:
    """The difference of two headings, or of what else is asked for, that a number is made of: its size, its rate, the most or least of several."""
    seen: set[typed.Number] = set()  # written out, they can be far more than they are
    stack = [node]
    while stack:
        part = _behind(stack.pop())
        if part in seen:
            continue
        seen.add(part)
        match part:
            case typed.Arithmetic(op="-"):
                if of(part.left, part.right):
                    return part
            case typed.Arithmetic(op="*"):
                stack += [part.right, part.left]
            case typed.Arithmetic(op="/"):
                stack.append(part.left)
            case typed.Negative():
                stack.append(part.operand)
            case typed.Power():
                stack.append(part.base)
            case typed.Folded(body=body) if body is not None:
                stack.append(body)
            case typed.Choice():
                stack += [part.otherwise, part.then]
            case typed.NumberCase():
                stack += [branch.value for branch in reversed(part.branches)]
            case typed.Function() if part.name in _GIVE_ON or part.name in ("sqrt", "hypot"):
                if not _both_ways(part):
                    stack += reversed(part.arguments)
            case _:  # whatever else is made of it, such as a sine, is another matter
                pass
    return None


def _both_ways(node: typed.Function) -> bool:
    """Whether a number is that of the shorter way round: `min(apart, 360 deg - apart)`, where `apart` is a size."""
    sizes = [
        _text(each)
        for each in node.arguments
        if isinstance(part := _behind(each), typed.Function) and part.name == "abs"
    ]
    return node.name == "min" and any(
        isinstance(part, typed.Arithmetic)
        and part.op == "-"
        and _is_turn(part.left)
        and _text(part.right) in sizes
        for part in map(_behind, node.arguments)
    )


def _is_turn(node: typed.Number) -> bool:
    """Whether a number is a whole turn: `360 deg`, `2 * pi`."""
    node = _behind(node)
    factors = (node.left, node.right) if isinstance(node, typed.Arithmetic) and node.op == "*" else (node,)
    values = [value for each in factors if (value := typed.literal(each)) is not None]
    return len(values) == len(factors) and math.isclose(math.prod(values), math.tau)


def _stands(node: typed.Number) -> bool:
    """Whether a number is a station of a line that may be closed."""
    node = _behind(node)
    return isinstance(node, typed.OnLine) and node.function == "station" and not on_open_line(node.line)


def _both_stand(left: typed.Number, right: typed.Number) -> bool:
    """Whether a difference is one of two stations."""
    return _stands(left) and _stands(right)


#: Two headings.
_Ends: TypeAlias = tuple[typed.Number, typed.Number]
_THROUGH = "of 179 deg and -179 deg, what lies between is taken for 0 deg"


def _shares(one: typed.Number, other: typed.Number) -> _Ends | None:
    """The headings of which two numbers are multiples: `(1 - share) * p.heading + share * q.heading`."""
    factors = [
        next(filter(_leads, (each.left, each.right)), None)
        for each in (one, other)
        if isinstance(each, typed.Arithmetic) and each.op == "*"
    ]
    found = [each for each in factors if each is not None]
    return (found[1], found[0]) if len(found) == 2 else None


def _on_the_way(begin: typed.Number, way: typed.Number) -> _Ends | None:
    """The headings between which one is, that is another one and a multiple of a difference: `p.heading + share * (q.heading - p.heading)`."""
    scaled = isinstance(way, typed.Arithmetic) and way.op in "*/"
    apart = _apart(way) if scaled and _leads(begin) else None
    return None if apart is None else (apart.left, apart.right)


def _summed(total: typed.Number, factor: typed.Number) -> _Ends | None:
    """The headings of which one is the mean: `(p.heading + q.heading) / 2`."""
    if not isinstance(total, typed.Arithmetic) or total.op != "+":
        return None
    both = _leads(total.left) and _leads(total.right)
    return (total.right, total.left) if both and not _reads(factor) else None


def _but_for_constants(node: typed.Number, kind: Callable[[typed.Number], bool]) -> typed.Number | None:
    """The number of a kind, such as a heading, that a number is but for a constant."""
    node = _behind(node)
    while isinstance(node, typed.Arithmetic) and node.op in "+-":
        if not _reads(node.right):
            node = _behind(node.left)
        elif node.op == "+" and not _reads(node.left):
            node = _behind(node.right)
        else:
            return None
    return node if kind(node) else None


def _leads(node: typed.Number) -> bool:
    """Whether a number is where something heads for: a field of that name, or the direction of a line."""
    match _behind(node):
        case typed.Field(name="heading"):
            return True
        case typed.OnLine(function="direction"):
            return True
        case _:
            return False


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
        match meant := _behind(part):
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


def _turns(node: typed.Number) -> bool:
    """Whether a number starts anew after half a turn: where something heads for, or the bearing that `atan2` gives."""
    return _leads(node) or (isinstance(found := _behind(node), typed.Function) and found.name == "atan2")


def _behind(number: typed.Number) -> typed.Number:
    """A number without the names that it goes by."""
    while True:
        if isinstance(number, typed.NamedNumber) and number.value is not None:
            number = number.value
        elif isinstance(number, typed.CalledNumber):
            number = number.body
        else:
            return number


def _text(value: typed.Number) -> str:
    """What the author wrote, on one line."""
    return value.span.in_line


def _operand(text: str, loose: re.Pattern[str]) -> str:
    return f"({text})" if loose.search(text) else text


def _reads(node: typed.Number) -> bool:
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
