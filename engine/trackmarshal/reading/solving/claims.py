"""Up to which value of a number a rule holds: what algebra proposes is claimed where the reference says so on 1,000 inputs."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable, Iterator, Sequence
from itertools import permutations
from math import isfinite
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, assert_never

from trackmarshal import typed
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.reading import layout as at
from trackmarshal.reading.formulas import Formulas
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.solving.algebra import Place, Quantities, Unsolvable, expression, zeros
from trackmarshal.reading.solving.inputs import Inputs
from trackmarshal.reading.solving.printing import printed
from trackmarshal.testing.si import spec_in_si

if TYPE_CHECKING:
    from sympy import Expr

#: On how many inputs a claim is held against the reference, and on how many it is chosen.
CHECKED, PILOT = 1000, 60
#: How many inputs are tried for one that a claim is about; and how far beside a boundary, relative to it, a number is put.
_TRIED, _BESIDE = 12, 1e-6

Side = Literal["up to", "from", "between", "magnitude"]


class Claim(NamedTuple):
    """A rule holds up to a value of a number, from it on, or between two.

    conditions: what must not be negative for that, which is that the rule holds where the number is 0. zero: parameters that are taken for 0.
    strict: of each bound, whether the rule does not hold on it, as a demand with `<` does not.
    """

    side: Side
    bounds: tuple[Expr, ...]
    conditions: tuple[Expr, ...]
    zero: tuple[Place, ...]
    strict: tuple[bool, ...]


class Solver:
    """Claims on one number of one rule. Raises Unsolvable for a rule that is no demand on numbers of the input alone."""

    def __init__(self, rule: RuleInfo, spec: Spec, target: Place) -> None:
        assert rule.typed is not None
        self.target = target
        self.quantities = Quantities(Formulas(), spec, target)
        self._spec = spec_in_si(spec)
        self._inputs = Inputs(rule, self._spec)
        demands = list(_demands(rule.typed, self.quantities))
        self._differences = [right - left for left, right, _ in demands]
        self._strict = [strict for *_, strict in demands]
        if target not in self.quantities.symbols:
            raise Unsolvable("absent")
        self.symbol = self.quantities.symbols[target]
        if not all(one.has(self.symbol) for one in self._differences):
            raise Unsolvable("beside")
        self._derived = [
            _compiled(made, self.quantities, number, then)
            for number, (made, then) in enumerate(self.quantities.derived.values())
        ]
        self._evaluator = Evaluator(self._spec, [rule.name], "reference")
        self._name = rule.name

    def claims(self) -> Iterator[Claim]:
        """With all parameters, and where one that may be 0 is."""
        whole = self._claim(())
        if whole is not None:
            yield whole
        for place in self.quantities.symbols:
            if place.record or place == self.target or self._spec.params[place.name].lower != 0.0:
                continue
            simple = self._claim((place,))
            trivial = simple is None or not any(bound.free_symbols for bound in simple.bounds)
            if (
                simple is not None
                and not trivial
                and (whole is None or _length(simple) * 2 <= _length(whole))
            ):
                yield simple

    def printed(self, claim: Claim) -> Iterator[Layout]:
        """What has to be so, and where that is claimed."""
        x = self.quantities.shown[self.symbol]
        bounds = [printed(one, self.quantities.shown) for one in claim.bounds]
        most = ["<" if strict else "≤" for strict in claim.strict]
        match claim.side:
            case "up to":
                yield _chain(x, (most[0], bounds[0]))
            case "from":
                yield _chain(x, (">" if claim.strict[0] else "≥", bounds[0]))
            case "between":
                yield _chain(bounds[0], (most[0], x), (most[1], bounds[1]))
            case "magnitude":
                yield _chain(at.Fence("|", x), (most[1], bounds[1]))
            case _:
                assert_never(claim.side)
        where = at.Word("where ")
        for condition in claim.conditions:
            more, less = _sides(condition)
            yield at.Row(
                (
                    where,
                    _chain(printed(more, self.quantities.shown), ("≥", printed(less, self.quantities.shown))),
                )
            )
        for place in claim.zero:
            yield at.Row(
                (where, _chain(self.quantities.shown[self.quantities.symbols[place]], ("=", at.Digits("0"))))
            )

    def _claim(self, zero: tuple[Place, ...]) -> Claim | None:
        """One that holds on every input that it is about, or None."""
        import sympy

        without = {self.quantities.symbols[place]: 0 for place in zero}
        differences = [one.subs(without) for one in self._differences]
        found = [zeros(one, self.symbol) for one in differences]
        roots = [root for some in found for root in some]
        # Where a number is a zero of a strict demand, that one does not hold, whatever else has its zero there.
        strict = {
            root for some, is_strict in zip(found, self._strict, strict=True) if is_strict for root in some
        }
        at_zero = [sympy.simplify(one.subs(self.symbol, 0)) for one in differences]
        made = [_compiled(one, self.quantities) for one in (*roots, *at_zero)]
        choose = random.Random(f"{self._name} {self.target} {zero}")
        pilot = [self._pilot(made, len(roots), zero, choose) for _ in range(PILOT * 3)]
        for conditions in ((), tuple(range(len(roots), len(made)))):
            best: tuple[int, Claim, Holding] | None = None
            for side, numbers in _patterns(roots):
                holds = _holding(side, numbers, conditions)
                about = [one for one in pilot if holds(one[0], 0.0) is not None]
                told = [(holds(values, x), said) for values, tried in about for x, said in tried]
                right = all(wanted is said for wanted, said in told) and {said for _, said in told} == {
                    True,
                    False,
                }
                if right and len(about) >= PILOT // 4 and (best is None or len(about) > best[0]):
                    stated = tuple(one for one in at_zero if conditions and not one.is_nonnegative)
                    bounds = tuple(roots[k] for k in numbers)
                    claim = Claim(side, bounds, stated, zero, tuple(one in strict for one in bounds))
                    best = len(about), claim, holds
            if best is not None and self._checked(made, len(roots), best[2], zero, choose):
                return best[1]
        return None

    def _pilot(
        self, made: Sequence[_Root], count: int, zero: tuple[Place, ...], choose: random.Random
    ) -> tuple[list[float | None], list[tuple[float, bool]]]:
        """The roots on one input, and what the reference says beside each of them and elsewhere."""
        case, roots = self._input(made, zero, choose)
        low, high = self._inputs.bounds(self.target)
        xs = [choose.uniform(low, high) for _ in range(2)]
        xs += [
            x for root in roots[:count] if root is not None for x in (root - _far(root), root + _far(root))
        ]
        told = [(x, self._says(case, x)) for x in xs if low <= x <= high]
        return roots, [(x, said) for x, said in told if said is not None]

    def _checked(
        self,
        made: Sequence[_Root],
        count: int,
        holds: Holding,
        zero: tuple[Place, ...],
        choose: random.Random,
    ) -> bool:
        """Whether the reference says the same on as many inputs as a claim takes: beside a boundary, and anywhere."""
        low, high = self._inputs.bounds(self.target)
        found = 0
        for _ in range(CHECKED * _TRIED):
            case, roots = self._input(made, zero, choose)
            known = [root for root in roots[:count] if root is not None]
            root = choose.choice(known) if known else 0.0
            x = choose.choice((root - _far(root), root + _far(root), choose.uniform(low, high)))
            wanted = holds(roots, x)
            if wanted is None or not low <= x <= high:
                continue
            said = self._says(case, x)
            if said is None:
                continue
            if said is not wanted:
                return False
            found += 1
            if found == CHECKED:
                return True
        return False

    def _input(
        self, made: Sequence[_Root], zero: tuple[Place, ...], choose: random.Random
    ) -> tuple[dict[str, Any], list[float | None]]:
        case = self._inputs.made(choose)
        for place in zero:
            self._inputs.put(case, place, 0.0)
        values = [self._inputs.value(case, place) for place in self.quantities.symbols]
        for work_out in self._derived:
            found = work_out(values)
            values.append(float("nan") if found is None else found)
        return case, [root(values) for root in made]

    def _says(self, case: dict[str, Any], x: float) -> bool | None:
        """Whether the rule holds; None where it says nothing."""
        tried = copy.deepcopy(case)
        self._inputs.put(tried, self.target, x)
        verdict = self._evaluator.case(tried).rules[self._name].verdict
        return {"satisfied": True, "violated": False}.get(verdict)


_Root = Callable[[Sequence[float]], "float | None"]
#: Whether a rule holds, given the values of all roots and conditions, and of the number.
Holding = Callable[["Sequence[float | None]", float], "bool | None"]


#: What has to be at most what, or less than it (True).
_Demand = tuple["Expr", "Expr", bool]


def _demands(rule: typed.Rule, known: Quantities) -> Iterator[_Demand]:
    """All of it for every variable of the rule."""
    for clause in rule.clauses:
        if isinstance(clause, typed.Along | typed.Deadline) or (
            isinstance(clause, typed.ForEach) and (clause.quantifier == "exists" or clause.by is not None)
        ):
            raise Unsolvable("quantified")
    yield from _parts(rule.condition, known)


def _parts(node: typed.Formula, known: Quantities) -> Iterator[_Demand]:
    match node:
        case typed.Comparison():
            yield _ordered(node.op, expression(node.left, known), expression(node.right, known))
        case typed.Chained():
            numbers = [expression(one, known) for one in node.operands]
            for op, left, right in zip(node.ops, numbers, numbers[1:]):
                yield _ordered(op, left, right)
        case typed.Within():
            value = expression(node.value, known)
            yield expression(node.lower, known), value, False
            yield value, expression(node.upper, known), False
        case typed.Connective() if node.op == "and":
            yield from _parts(node.left, known)
            yield from _parts(node.right, known)
        case typed.CalledFormula():
            with known.writing.entered():
                yield from _parts(node.body, known)
        case typed.NamedFormula():
            with known.writing.given():
                yield from _parts(node.value, known)
        case _:
            raise Unsolvable("comparison")


def _ordered(op: typed.Comparing, left: Expr, right: Expr) -> _Demand:
    match op:
        case "<" | "<=":
            return left, right, op == "<"
        case ">" | ">=":
            return right, left, op == ">"
        case "==" | "!=":
            raise Unsolvable("equality")
        case _:
            assert_never(op)


def _compiled(
    root: Expr, known: Quantities, derived: int | None = None, then: Callable[[float], float] = float
) -> _Root:
    """An expression as a function of the numbers of all symbols, the derived ones last (those before one: `derived`); None where it is no real number."""
    import sympy

    function = sympy.lambdify([*known.symbols.values(), *list(known.derived)[:derived]], root, modules="math")

    def value(numbers: Sequence[float]) -> float | None:
        try:
            found = function(*numbers)
        except (ValueError, ZeroDivisionError, OverflowError):
            return None
        return then(float(found)) if not isinstance(found, complex) and isfinite(found) else None

    return value


def _patterns(roots: Sequence[Expr]) -> Iterator[tuple[Side, tuple[int, ...]]]:
    for k in range(len(roots)):
        yield "up to", (k,)
        yield "from", (k,)
    for i, j in permutations(range(len(roots)), 2):
        yield ("magnitude" if roots[i] == -roots[j] else "between"), (i, j)


def _holding(side: Side, numbers: tuple[int, ...], conditions: tuple[int, ...]) -> Holding:
    """Whether a rule holds at x by a pattern; None where the pattern says nothing."""

    def holds(roots: Sequence[float | None], x: float) -> bool | None:
        chosen, given = [roots[k] for k in numbers], [roots[k] for k in conditions]
        if any(one is None or one < 0.0 for one in given) or any(one is None for one in chosen):
            return None
        first = chosen[0]
        assert first is not None
        if side == "up to":
            return x <= first
        if side == "from":
            return x >= first
        last = chosen[1]
        assert last is not None
        return first <= x <= last if first <= last else None

    return holds


def _far(root: float) -> float:
    return _BESIDE * max(abs(root), 1e-3)


def _length(claim: Claim) -> int:
    return int(sum(bound.count_ops() for bound in claim.bounds))


def _chain(first: Layout, *rest: tuple[str, Layout]) -> Layout:
    return at.Chain(first, tuple(at.Joined(at.Sign(sign), operand) for sign, operand in rest))


def _sides(condition: Expr) -> tuple[Expr, Expr]:
    """What is not negative as two sides, of which the first is not less: without factors that are positive, and without a minus."""
    import sympy

    factors = sympy.Mul.make_args(sympy.factor_terms(condition))
    rest = sympy.Mul(*[one for one in factors if not one.is_positive])
    terms = sympy.Add.make_args(rest)
    less = [-one for one in terms if one.could_extract_minus_sign()]
    return sympy.Add(*[one for one in terms if not one.could_extract_minus_sign()]), sympy.Add(*less)
