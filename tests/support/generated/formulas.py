"""Numbers of a wanted dimension and formulas, as text, over the names in scope."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from support.generated.choices import Choices
from support.generated.vocabulary import (
    COMMON,
    HUGE,
    LENGTH,
    NUMBER,
    PLAIN,
    SETS,
    SHAPES,
    TIMELINES,
    UNITS,
    DefineInfo,
    Dimension,
    World,
    spelled,
)

#: Functions whose last digit depends on the platform's libm.
INEXACT = ("sin", "cos", "tan", "exp", "log", "pow", "atan2", "asin", "acos", "tanh")
_COMPARISONS = ("<=", "<", ">=", ">", "==", "!=", "≤", "≥", "≠")
_CONNECTIVES = ("and", "or", "implies", "iff", "xor")
_WINDOWED = ("always", "eventually", "historically", "once")
_STEPS = ("next", "previous", "weak next", "weak previous")
#: More axes than this make arrays, and the reference evaluator's loops, long without new combinations.
DEEPEST = 4


@dataclass(frozen=True)
class Scope:
    """The names an expression sees: records with their fields, numbers with their dimensions, formulas."""

    records: tuple[tuple[str, dict[str, Dimension | None]], ...] = ()
    numbers: tuple[tuple[str, Dimension], ...] = ()
    formulas: tuple[str, ...] = ()
    timeline: bool = False
    #: Samples of timelines among the records (they have a predecessor).
    samples: tuple[str, ...] = ()
    #: Lines and corridors that are parameters of a definition.
    lines: tuple[str, ...] = ()
    corridors: tuple[str, ...] = ()
    axes: int = 0

    def bind(self, name: str, fields: dict[str, Dimension | None], sample: bool) -> Scope:
        return replace(
            self,
            records=(*self.records, (name, fields)),
            samples=(*self.samples, name) if sample else self.samples,
        )


class FormulaWriter:
    """Writes expressions; `soft` numbers may use inexact functions, in places where an error stays small.

    inexact: "no" inexact functions at all, "gentle" ones only where errors don't grow, "any" everywhere.
    domains: the signals that inner quantifiers may range over.
    """

    def __init__(self, choices: Choices, world: World, inexact: str = "no") -> None:
        self.choices = choices
        self.world = world
        self.inexact = inexact
        self.domains: tuple[str, ...] = (*TIMELINES, *SETS)
        self._names = 0

    def fresh(self, stem: str) -> str:
        self._names += 1
        return f"{stem}{self._names}"

    # Numbers --------------------------------------------------------------------------------------------------

    def literal(self, dimension: Dimension) -> str:
        """A number of the spec, in any of the dimension's units."""
        huge = self.choices.chance(3)
        value = self.choices.pick(HUGE if huge else PLAIN)
        unit = UNITS[dimension][0] if huge else self.choices.pick(UNITS[dimension])
        text = spelled(abs(value)) + ("" if unit == "1" else f" {unit}")
        negative = value < 0 or (value == 0.0 and str(value) == "-0.0")
        return f"(-{text})" if negative else text

    def number(self, dimension: Dimension, depth: int, scope: Scope, soft: bool = True) -> str:
        """A number of a dimension; `soft`: errors of inexact functions would stay small here."""
        if depth <= 0 or self.choices.chance(25):
            return self._leaf(dimension, scope)
        ways: list[Callable[[], str]] = [
            lambda: self._leaf(dimension, scope),
            lambda: self._joined(self.choices.pick("+-"), dimension, depth, scope, soft),
            lambda: self._product(dimension, depth, scope, soft),
            lambda: self._quotient(dimension, depth, scope, soft),
            lambda: f"(-{self.number(dimension, depth - 1, scope, soft)})",
            lambda: f"abs({self.number(dimension, depth - 1, scope, soft)})",
            lambda: self._extremum(dimension, depth, scope, soft),
            lambda: self._choice(dimension, depth, scope, soft),
            lambda: self._power(dimension, depth, scope, soft),
        ]
        squared = (2 * dimension[0], 2 * dimension[1])
        if squared in UNITS:
            ways.append(
                lambda: (
                    f"{self.choices.pick(('sqrt', '√'))}({self.number(squared, depth - 1, scope, self._any)})"
                )
            )
        if dimension == NUMBER:
            ways.append(lambda: self._stepped(depth, scope))
            if self.inexact == "any" or (self.inexact == "gentle" and soft):
                ways += [lambda: self._inexact(depth, scope)] * 3
        ways += [
            partial(self._lookup, name, depth, scope)
            for name, t in self.world.tables.items()
            if t.result == dimension
        ] * 2
        ways += [
            partial(self._call, n, d, depth, scope) for n, d in self._callable(scope) if d.result == dimension
        ]
        ways += self.on_lines(dimension, depth, scope)
        if scope.axes < DEEPEST and self.domains:
            ways.append(lambda: self._folded(dimension, depth, scope, soft))
            if dimension == NUMBER:
                ways.append(lambda: self._counted(depth, scope))
        return self.choices.pick(ways)()

    def on_lines(self, dimension: Dimension, depth: int, scope: Scope) -> list[Callable[[], str]]:
        """Numbers read off lines; there are none without geometry."""
        return []

    def in_places(self, depth: int, scope: Scope) -> list[Callable[[], str]]:
        """Geometric predicates; there are none without geometry."""
        return []

    @property
    def _any(self) -> bool:
        return self.inexact == "any"

    def _leaf(self, dimension: Dimension, scope: Scope) -> str:
        leaves = [
            f"{name}.{field}"
            for name, fields in scope.records
            for field, d in fields.items()
            if d == dimension
        ]
        leaves += [name for name, d in scope.numbers if d == dimension] * 2
        if not leaves or self.choices.chance(55):
            leaves = [name for name, p in self.world.params.items() if p.dimension == dimension]
            for name, signal in self.world.signals.items():
                stems = (
                    [name]
                    if signal.kind == "state"
                    else [f"{name}.first", f"{name}.last"]
                    if name in TIMELINES
                    else []
                )
                leaves += [
                    f"{stem}.{f}"
                    for stem in stems
                    for f, info in signal.fields.items()
                    if info.dimension == dimension
                ]
            if not leaves or self.choices.chance(50):
                return "pi" if dimension == NUMBER and self.choices.chance(10) else self.literal(dimension)
        return self.choices.pick(leaves)

    def _joined(self, op: str, dimension: Dimension, depth: int, scope: Scope, soft: bool) -> str:
        return f"({self.number(dimension, depth - 1, scope, soft)} {op} {self.number(dimension, depth - 1, scope, soft)})"

    def _product(self, dimension: Dimension, depth: int, scope: Scope, soft: bool) -> str:
        parts = [a for a in UNITS if (dimension[0] - a[0], dimension[1] - a[1]) in UNITS]
        left = self.choices.pick(parts)
        right = (dimension[0] - left[0], dimension[1] - left[1])
        return f"({self.number(left, depth - 1, scope, soft)} {self.choices.pick('*·')} {self.number(right, depth - 1, scope, soft)})"

    def _quotient(self, dimension: Dimension, depth: int, scope: Scope, soft: bool) -> str:
        parts = [b for b in UNITS if (dimension[0] + b[0], dimension[1] + b[1]) in UNITS]
        below = self.choices.pick(parts)
        above = (dimension[0] + below[0], dimension[1] + below[1])
        return f"({self.number(above, depth - 1, scope, soft)} / {self.number(below, depth - 1, scope, self._any)})"

    def _extremum(self, dimension: Dimension, depth: int, scope: Scope, soft: bool) -> str:
        args = [self.number(dimension, depth - 1, scope, soft) for _ in range(self.choices.pick((2, 2, 3)))]
        return f"{self.choices.pick(('min', 'max', 'hypot') if len(args) == 2 else ('min', 'max'))}({', '.join(args)})"

    def _stepped(self, depth: int, scope: Scope) -> str:
        """Functions that jump: an error of their argument does not stay small."""
        name = self.choices.pick(("floor", "ceil", "round", "sign"))
        dimension = self.choices.pick(COMMON) if name == "sign" else NUMBER
        return f"{name}({self.number(dimension, depth - 1, scope, self._any)})"

    def _choice(self, dimension: Dimension, depth: int, scope: Scope, soft: bool) -> str:
        condition = self.formula(depth - 1, scope, soft=self._any)
        return (
            f"(if {condition} then {self.number(dimension, depth - 1, scope, soft)} "
            f"else {self.number(dimension, depth - 1, scope, soft)})"
        )

    def _folded(self, dimension: Dimension, depth: int, scope: Scope, soft: bool) -> str:
        """A sum, or the least or greatest of many."""
        op = self.choices.pick(("sum", "min", "max"))
        bound, inner = self.bound(depth, scope)
        body = self.number(dimension, depth - 1, inner, soft)
        otherwise = "" if op == "sum" else f" else {self.number(dimension, depth - 1, scope, soft)}"
        return f"{op}({body} for {bound}{otherwise})"

    def _counted(self, depth: int, scope: Scope) -> str:
        while True:
            bound, _ = self.bound(depth, scope)
            if not bound.startswith("consecutive"):
                return f"count({bound})"

    def _power(self, dimension: Dimension, depth: int, scope: Scope, soft: bool) -> str:
        exponents = [
            e
            for e in (2, 3, -1, -2, 5)
            if dimension[0] % e == 0
            and dimension[1] % e == 0
            and (dimension[0] // e, dimension[1] // e) in UNITS
        ]
        if not exponents:
            return self._leaf(dimension, scope)
        exponent = self.choices.pick(exponents)
        base = self.number(
            (dimension[0] // exponent, dimension[1] // exponent), depth - 1, scope, soft and exponent > 0
        )
        if exponent in (2, 3) and self.choices.chance(30):
            return f"(({base}){'²' if exponent == 2 else '³'})"
        return f"(({base})^{exponent})"

    def _inexact(self, depth: int, scope: Scope) -> str:
        name = self.choices.pick(INEXACT)
        if name == "atan2":
            dimension = self.choices.pick((NUMBER, LENGTH))
            return f"atan2({self.number(dimension, depth - 1, scope, self._any)}, {self.number(dimension, depth - 1, scope, self._any)})"
        argument = self.number(NUMBER, depth - 1, scope, self._any)
        if name != "pow":
            return f"{name}({argument})"
        if self.choices.chance(40):
            return f"pow({argument}, {self.number(NUMBER, depth - 1, scope, self._any)})"
        return f"(({argument})^{self.choices.pick(('0.5', '(-0.5)', '0', '1.5', '9', f'({self._leaf(NUMBER, scope)})'))})"

    def _lookup(self, name: str, depth: int, scope: Scope) -> str:
        return f"{name}({self.number(self.world.tables[name].argument, depth - 1, scope, self._any)})"

    # Definitions ----------------------------------------------------------------------------------------------

    def _callable(self, scope: Scope) -> list[tuple[str, DefineInfo]]:
        return [
            (name, define) for name, define in self.world.defines.items()
            if (scope.timeline or not define.temporal) and all(isinstance(t, tuple) or self.known(t, scope) for _, t in define.parameters)
        ]  # fmt: skip

    def _records(self, shape: str, scope: Scope) -> list[str]:
        """Records in scope, and of the signals, that have a shape's fields."""
        wanted = SHAPES[shape].items()
        known = list(scope.records)
        for name, signal in self.world.signals.items():
            if signal.kind == "state":
                known.append((name, signal.dimensions()))
            elif name in TIMELINES:
                known += [(f"{name}.first", signal.dimensions()), (f"{name}.last", signal.dimensions())]
        return [name for name, fields in known if all(fields.get(f, "none") == d for f, d in wanted)]

    def known(self, kind: str, scope: Scope) -> list[str]:
        """What may stand for a parameter that is not a number."""
        return self._records(kind, scope)

    def _argument(self, kind: Dimension | str, depth: int, scope: Scope) -> str:
        if isinstance(kind, str):
            return self.choices.pick(self.known(kind, scope))
        return self.number(kind, depth - 1, scope, self._any)

    def _call(self, name: str, define: DefineInfo, depth: int, scope: Scope) -> str:
        args = [self._argument(kind, depth, scope) for _, kind in define.parameters]
        if define.result is None and len(args) == 2 and self.choices.chance(60):
            return f"({args[0]} {name} {args[1]})"
        return f"{name}({', '.join(args)})" if args else name

    # Formulas -------------------------------------------------------------------------------------------------

    def formula(self, depth: int, scope: Scope, soft: bool = True) -> str:
        """A formula."""
        if depth <= 0 or self.choices.chance(15):
            return self._atom(max(depth, 1), scope, soft)
        ways: list[Callable[[], str]] = [
            lambda: self._atom(depth, scope, soft),
            lambda: self._connective(depth, scope, soft),
            lambda: f"({self.choices.pick(('not', '¬'))} {self.formula(depth - 1, scope, soft)})",
        ]
        if scope.axes < DEEPEST and self.domains:
            ways += [lambda: self._quantified(depth, scope, soft)] * 2
        if scope.timeline:
            ways += [lambda: self._temporal(depth, scope, soft)] * 4
        ways += [
            partial(self._call, n, d, depth, scope) for n, d in self._callable(scope) if d.result is None
        ]
        return self.choices.pick(ways)()

    def _atom(self, depth: int, scope: Scope, soft: bool) -> str:
        flags = [
            f"{name}.{field}" for name, fields in scope.records for field, d in fields.items() if d is None
        ]
        flags += [*scope.formulas, *self.world.events]
        flags += [
            f"{n}.{f}"
            for n, s in self.world.signals.items()
            if s.kind == "state"
            for f, i in s.fields.items()
            if i.dimension is None
        ]
        if flags and self.choices.chance(20):
            return self.choices.pick(flags)
        if self.choices.chance(3):
            return self.choices.pick(("true", "false"))
        geometric = self.in_places(depth, scope)
        if geometric and self.choices.chance(30):
            return self.choices.pick(geometric)()
        dimension = self.choices.pick((*COMMON, *COMMON, *UNITS))
        if self.choices.chance(12):
            low, value, high = (self.number(dimension, depth - 1, scope, soft) for _ in range(3))
            return f"({value} {self.choices.pick(('in', '∈'))} [{low}, {high}])"
        left, right = (
            self.number(dimension, depth, scope, soft),
            self.number(dimension, depth - 1, scope, soft),
        )
        return f"({left} {self.choices.pick(_COMPARISONS)} {right})"

    def _connective(self, depth: int, scope: Scope, soft: bool) -> str:
        left, right = self.formula(depth - 1, scope, soft), self.formula(depth - 1, scope, soft)
        return f"({left} {self.choices.pick(_CONNECTIVES)} {right})"

    def _quantified(self, depth: int, scope: Scope, soft: bool) -> str:
        clause, inner = self.binder(depth, scope)
        return f"({clause}: ({self.formula(depth - 1, inner, soft)}))"

    def binder(self, depth: int, scope: Scope) -> tuple[str, Scope]:
        """A quantifier with its variables and, perhaps, a `where`, and the scope below it."""
        if self.choices.chance(15):
            return self._nearest(depth, scope)
        bound, inner = self.bound(depth, scope)
        return f"{self.choices.pick(('for all', 'exists', '∀', '∃'))} {bound}", inner

    def _nearest(self, depth: int, scope: Scope) -> tuple[str, Scope]:
        """A quantifier about the one of which a number is least."""
        domain, name = self.choices.pick(self.domains), self.fresh("q")
        inner = replace(scope, axes=scope.axes + 1)
        inner = inner.bind(name, self.world.signals[domain].dimensions(), domain in TIMELINES)
        text = f"{self.choices.pick(('for', 'exists', '∀', '∃'))} nearest {name} in {domain}"
        text += f" by {self.number(self.choices.pick(COMMON), depth - 1, inner, self._any)}"
        if self.choices.chance(35):
            text += f" where {self.formula(depth - 1, inner, self._any)}"
        return text, inner

    def bound(self, depth: int, scope: Scope) -> tuple[str, Scope]:
        """Variables, what they range over and, perhaps, a `where`, and the scope of what is said of them."""
        domain = self.choices.pick(self.domains)
        fields = self.world.signals[domain].dimensions()
        count = self.choices.integer(2, 4) if domain in TIMELINES and self.choices.chance(35) else 1
        names = [self.fresh("q") for _ in range(count)]
        inner = replace(scope, axes=scope.axes + 1)
        for name in names:
            inner = inner.bind(name, fields, domain in TIMELINES)
        text = "consecutive " if count > 1 else ""
        text += ", ".join(names) + f" {self.choices.pick(('in', '∈'))} {domain}"
        if self.choices.chance(35):
            text += f" where {self.formula(depth - 1, inner, self._any)}"
        return text, inner

    def _temporal(self, depth: int, scope: Scope, soft: bool) -> str:
        kind = self.choices.integer(0, 9)
        operand = self.formula(depth - 1, scope, soft)
        if kind < 4:
            return f"({self.choices.pick(_WINDOWED)}{self.window()} {operand})"
        if kind < 6:
            other = self.formula(depth - 1, scope, soft)
            return f"({operand} {self.choices.pick(('until', 'since'))}{self.window()} {other})"
        if kind < 8:
            return f"({self.choices.pick(_STEPS)} {operand})"
        return f"{self.choices.pick(('rising', 'falling'))}({operand})"

    def window(self) -> str:
        """No window, or bounds in any unit of time, in order."""
        if self.choices.chance(30):
            return ""
        low = self.choices.pick((0.0, 0.1, 0.25, 0.5, 1.0, 3.0))
        high = low + self.choices.pick((0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 50.0))
        texts = [self.choices.pick((f"{spelled(v)} s", f"{spelled(v * 1000)} ms")) for v in (low, high)]
        return f"[{texts[0]}, {texts[1]}]"
