"""Numbers of the typed tree as expressions of sympy, and the values of one of them at which a difference is zero."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING, Any, Literal, assert_never

from trackmarshal import typed
from trackmarshal.ir.spec import Spec
from trackmarshal.ir.tables import read
from trackmarshal.reading.formulas import Formulas
from trackmarshal.reading.layout import Layout
from trackmarshal.typed import whole_exponent

if TYPE_CHECKING:
    from sympy import Expr, Symbol

#: The most magnitudes of the number in one difference, and the highest degree that is solved.
_MAGNITUDES, _DEGREE = 3, 2


#: What is not solved here.
Reason = Literal[
    "exponent", "choice", "line", "many", "machine", "sample", "record", "grid", "inner table", "table", "degree", "magnitudes", "roots", "inner root",
    "polynomial", "beside", "nothing given", "function", "lines", "samples", "times", "quantified", "absent", "comparison", "equality", "unproved",
]  # fmt: skip


class Unsolvable(Exception):
    """Something that is not solved here."""

    def __init__(self, reason: Reason) -> None:
        super().__init__(reason)
        self.reason: Reason = reason


@dataclass(frozen=True)
class Place:
    """Where the value of a symbol is in a case: a field of the record that a name stands for, or a parameter (no record)."""

    record: str
    signal: str
    offset: int
    name: str
    sample: bool = False


@dataclass
class Quantities:
    """The numbers of one rule as symbols: how each is shown, and where its value is.

    derived: what does not depend on the number that is solved for and has a name, a definition or a table's value, is a symbol, too: of what it is
    worked out, and how, in the order in which it can be.
    """

    writing: Formulas
    spec: Spec
    target: Place
    symbols: dict[Place, Symbol] = field(default_factory=dict)
    shown: dict[Symbol, Layout] = field(default_factory=dict)
    derived: dict[Symbol, tuple[Expr, Callable[[float], float]]] = field(default_factory=dict)
    inside: int = 0
    _named: dict[Layout, Symbol] = field(default_factory=dict)
    #: What was worked out of what has a name in the rule, by its place in memory: in a chain of lets that use the one before twice, once for each.
    bound: dict[tuple[int, int], Expr] = field(default_factory=dict)

    def depends(self, made: Expr) -> bool:
        """Whether an expression is one of the number that is solved for."""
        return self.target in self.symbols and bool(made.has(self.symbols[self.target]))

    def named(self, shown: Layout, made: Expr, work_out: Callable[[float], float] = float) -> Symbol:
        """A symbol for what has a name; one name is one thing in all clauses of a rule."""
        import sympy

        known = self._named.get(shown)
        if known is None:
            known = self._named[shown] = sympy.Symbol(f"d{len(self._named)}", real=True)
            self.shown[known] = shown
            self.derived[known] = made, work_out
        return known

    def symbol(self, place: Place, layout: Callable[[], Layout], positive: bool = False) -> Symbol:
        """One symbol for one place."""
        import sympy

        known = self.symbols.get(place)
        if known is None:
            known = sympy.Symbol(
                f"q{len(self.symbols)}", real=True, **({"positive": True} if positive else {})
            )
            self.symbols[place] = known
            self.shown[known] = layout()
        return known


def expression(node: typed.Number, known: Quantities) -> Expr:
    """A number as an expression; raises Unsolvable for what is no formula of fields and parameters alone."""
    import sympy

    match node:
        case typed.Literally():
            return sympy.nsimplify(sympy.Float(node.value, 17), rational=True)
        case typed.Pi():
            return sympy.pi
        case typed.Parameter():
            lower = known.spec.params[node.symbol.qualified].lower
            place = Place("", "", 0, node.symbol.qualified)
            return known.symbol(place, lambda: known.writing.number(node), lower is not None and lower > 0.0)
        case typed.Field():
            return known.symbol(_place(node), lambda: known.writing.number(node))
        case typed.Negative():
            return -expression(node.operand, known)
        case typed.Arithmetic():
            left, right = expression(node.left, known), expression(node.right, known)
            match node.op:
                case "+":
                    return left + right
                case "-":
                    return left - right
                case "*":
                    return left * right
                case "/":
                    return left / right
                case _:
                    assert_never(node.op)
        case typed.Power():
            whole = whole_exponent(node.exponent)
            if whole is None:
                raise Unsolvable("exponent")
            return expression(node.base, known) ** whole
        case typed.Function():
            return _function(node, [expression(one, known) for one in node.arguments])
        case typed.CalledNumber():
            return _called(node, node.body, known)
        case typed.NamedNumber():
            if node.value is None:
                raise Unsolvable("nothing given")
            key = id(node.value), known.inside
            if key not in known.bound:
                with known.writing.given():
                    known.bound[key] = expression(node.value, known)
            return known.bound[key]
        case typed.Choice() | typed.NumberCase():
            raise Unsolvable("choice")
        case typed.TableValue():
            return _table(node, known)
        case typed.OnLine() | typed.StationGap():
            raise Unsolvable("line")
        case typed.Folded():
            raise Unsolvable("many")
        case typed.Kept():
            raise Unsolvable("machine")
        case _:
            assert_never(node)


def _place(node: typed.Field) -> Place:
    """Where a field is in a case; those of the first or the last sample may be those of another one, too."""
    made = place(node)
    if made.sample:
        raise Unsolvable("sample")
    return made


def place(node: typed.Field) -> Place:
    """Of which record a field is; records by the names of definitions are those that were given. Raises Unsolvable where nothing is."""
    record = node.record
    while isinstance(record, typed.NamedRecord):
        if record.value is None:
            raise Unsolvable("nothing given")
        record = record.value
    match record:
        case typed.State():
            return Place(record.signal.name, record.signal.name, 0, node.name)
        case typed.Variable():
            return Place(record.name, record.signal.name, record.offset, node.name)
        case typed.Sample():
            which = "first" if record.index == 0 else "last"
            return Place(
                f"{record.signal.name}.{which}", record.signal.name, record.index, node.name, sample=True
            )
        case typed.ParameterRecord():
            raise Unsolvable("record")
        case _:
            assert_never(record)


def _called(node: typed.CalledNumber, body: typed.Number, known: Quantities) -> Expr:
    """A definition: by its name, where what it comes to does not depend on the number and is more than a name."""
    known.inside += 1  # there, names are those of the definition, and nothing can be called by them outside
    with known.writing.entered():
        made = expression(body, known)
    known.inside -= 1
    if known.depends(made) or made.is_Atom or known.inside:
        return made
    return known.named(known.writing.number(node), made)


def _table(node: typed.TableValue, known: Quantities) -> Expr:
    if len(node.arguments) != 1:
        raise Unsolvable("grid")
    at = expression(node.arguments[0], known)
    if known.inside:
        raise Unsolvable("inner table")
    if known.depends(at):
        raise Unsolvable("table")
    info = known.spec.tables[node.symbol.qualified]
    return known.named(known.writing.number(node), at, lambda x: read(info.knots, info.values, info.way, x))


def _function(node: typed.Function, given: list[Expr]) -> Expr:
    import sympy

    match node.name:
        case "abs":
            return sympy.Abs(given[0])
        case "sqrt":
            return sympy.sqrt(given[0])
        case "hypot":
            return sympy.sqrt(given[0] ** 2 + given[1] ** 2)
        case "min":
            return sympy.Min(*given)
        case "max":
            return sympy.Max(*given)
        case "sign" | "floor" | "exp" | "log" | "sin" | "cos" | "tan" | "asin" | "acos" | "atan2" | "tanh":
            return getattr(sympy, node.name)(*given)
        case "ceil" | "round" | "pow":
            raise Unsolvable("function")
        case _:
            assert_never(node.name)


def zeros(difference: Expr, x: Symbol) -> list[Expr]:
    """The values of a symbol at which a difference may be zero: all there are, and perhaps others, which are seen where numbers are put in.

    Raises Unsolvable where they are roots of a polynomial of a higher degree than the second, of x or of its square.
    """
    import sympy

    found: list[Expr] = []
    for plain in _without_magnitudes(difference, x):
        polynomial = _polynomial(plain, x)
        powers = [power for (power,) in polynomial.monoms()]
        if powers in ([2, 0], [4, 0]):  # the one root that both signs have
            first, *_, last = polynomial.all_coeffs()
            root = sympy.factor_terms(sympy.cancel(-last / first)) ** sympy.Rational(1, powers[0])
            found += [root, -root]
            continue
        even = all(power % 2 == 0 for power in powers)
        y = sympy.Dummy("y", real=True)
        if even:
            polynomial = sympy.Poly(polynomial.as_expr().subs(x**4, y**2).subs(x**2, y), y)
            if polynomial.has(x):
                raise Unsolvable("degree")
        squares = _roots(polynomial)
        for square in squares:
            root = sympy.simplify(sympy.sqrt(square) if even else square)
            found += [root, -root] if even else [root]
    return list(dict.fromkeys(found))


def _without_magnitudes(difference: Expr, x: Symbol) -> Iterator[Expr]:
    """The difference for each sign of what it takes the magnitude of."""
    import sympy

    inside = [one for one in difference.atoms(sympy.Abs) if one.has(x)]
    if len(inside) > _MAGNITUDES:
        raise Unsolvable("magnitudes")
    for signs in product((1, -1), repeat=len(inside)):
        yield difference.subs({one: sign * one.args[0] for one, sign in zip(inside, signs)})


def _polynomial(difference: Expr, x: Symbol) -> Any:
    """A polynomial in x that is zero wherever the difference is: a root of x alone on one side, both sides squared."""
    import sympy

    roots = [one for one in difference.atoms(sympy.Pow) if one.has(x) and not one.exp.is_integer]
    if len(roots) > 1 or any(one.exp != sympy.Rational(1, 2) for one in roots):
        raise Unsolvable("roots")
    if roots:
        r = sympy.Dummy("r", nonnegative=True)
        linear = sympy.expand(difference.subs(roots[0], r))
        factor, rest = linear.coeff(r, 1), linear.coeff(r, 0)
        if sympy.expand(linear - factor * r - rest) != 0:
            raise Unsolvable("inner root")
        difference = factor**2 * roots[0].base - rest**2
    numerator, _ = sympy.fraction(sympy.together(difference))
    if not numerator.is_polynomial(x):
        raise Unsolvable("polynomial")
    made = sympy.Poly(numerator, x)
    if made.degree() < 1:
        raise Unsolvable("beside")
    return made


def _roots(polynomial: Any) -> list[Expr]:
    import sympy

    if polynomial.degree() > _DEGREE:
        raise Unsolvable("degree")
    if polynomial.degree() == 1:
        a, b = polynomial.all_coeffs()
        return [-b / a]
    a, b, c = polynomial.all_coeffs()
    root = sympy.sqrt(sympy.factor(b**2 - 4 * a * c))
    return [(-b + root) / (2 * a), (-b - root) / (2 * a)]
