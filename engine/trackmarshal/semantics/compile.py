"""Modules to a Spec: every declaration checked, every rule lowered, every error found."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable
from pathlib import Path

from trackmarshal.diagnostics.base import Diagnostic, Diagnostics
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import (
    ConstraintInfo,
    FieldType,
    ParamInfo,
    PlaceInfo,
    RuleInfo,
    SignalType,
    Spec,
    TableInfo,
)
from trackmarshal.node import Node
from trackmarshal.semantics import calls
from trackmarshal.semantics.constants import constant_value
from trackmarshal.semantics.errors import BadValue, Duplicate, SignalConflict, WrongDimension
from trackmarshal.semantics.expressions import Context, Expressions
from trackmarshal.semantics.modules import Library
from trackmarshal.semantics.rulebooks import check_rulebook, check_state, check_test_target
from trackmarshal.semantics.rules import RuleBuilder, describe
from trackmarshal.semantics.scope import KINDS, Scope
from trackmarshal.semantics.values import Poison
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import NUMBER, Dimension, name, parse_unit, show, to_si


class Compiled(Node):
    """The outcome: a Spec of all that has a meaning, the modules it came from, and everything that was found."""

    spec: Spec
    library: Library
    #: The names of the modules that were asked for, and all in dependency order.
    asked: tuple[str, ...]
    order: tuple[str, ...]
    scopes: dict[str, Scope]
    expressions: Expressions
    found: tuple[Diagnostic, ...]
    failures: tuple[TrackmarshalError, ...]

    @property
    def errors(self) -> list[Diagnostic]:
        return [d for d in self.found if d.level == "error"]

    def raise_errors(self) -> None:
        """Raise what is wrong, if anything is."""
        if self.failures:
            raise self.failures[0]
        if self.errors:
            raise Diagnostics(self.errors)

    def tests(self) -> list[ast.Test]:
        """The inline tests of all modules."""
        return [i for n in self.order for i in self.library.modules[n].tree.items if isinstance(i, ast.Test)]


def compile_paths(paths: Iterable[Path], shown_from: Path | None = None) -> Compiled:
    """Load and compile files and folders with all that they use; never raises for what is wrong with them."""
    library = Library(shown_from)
    asked = library.load(paths)
    return _Compiler(library, asked).run()


class _Compiler:
    def __init__(self, library: Library, asked: tuple[str, ...]) -> None:
        self.library = library
        self.asked = asked
        self.order = library.order(asked)
        self.found: list[Diagnostic] = list(library.found)
        self.signals: dict[str, SignalType] = {}
        self.events: dict[str, Span] = {}
        self.params: dict[str, ParamInfo] = {}
        self.tables: dict[str, TableInfo] = {}
        self.places: dict[str, PlaceInfo] = {}
        self.constraints: list[ConstraintInfo] = []
        self.x = Expressions(ir.Interner(), self.signals, self.found)
        self.scopes = self.x.scopes

    def run(self) -> Compiled:
        for module in self.order:
            self._scope(module)
        for step in (self._signals, self._params, self._tables, self._places, self._definitions, self._constraints):
            for module in self.order:
                step(module)
        rules = self._rules()
        names = {rule.name for rule in rules} | {i.__dict__["name"] for i in self._items(ast.Rule, ast.Assume)}
        rulebooks = tuple(check_rulebook(rulebook, names, self.found) for rulebook in self._items(ast.Rulebook))
        for state in self._items(ast.State):
            check_state(state, self.found)
        for test in self._items(ast.Test):
            check_test_target(test, names, self.found)
        digest = hashlib.sha256("".join(r.fingerprint for r in rules).encode())
        for info in [*self.params.values(), *self.tables.values(), *self.places.values()]:
            digest.update(repr(info).encode())
        spec = Spec(
            self.signals, self.events, self.params, self.tables, self.places, tuple(self.constraints), tuple(rules), rulebooks,
            digest.hexdigest(),
        )
        found = tuple(sorted(dict.fromkeys(self.found), key=lambda d: (d.span.file.path, d.span.start, d.code)))
        return Compiled(spec, self.library, self.asked, self.order, self.scopes, self.x, found, tuple(self.library.failures))

    def _items(self, *kinds: type[ast.Item]) -> list[ast.Item]:  # type: ignore[explicit-any, unused-ignore]
        return [i for module in self.order for i in self.library.modules[module].tree.items if isinstance(i, kinds)]

    def _scope(self, module: str) -> None:
        scope = self.scopes[module] = Scope(module, self.found)
        loaded = self.library.modules[module]
        for item in loaded.tree.items:
            if type(item) in KINDS:
                scope.declare(item.__dict__["name"], item)
        for use in loaded.uses:
            if use.name in self.scopes and use.name != module:
                scope.use(self.scopes[use.name])

    def _context(self, module: str) -> Context:
        return Context(self.scopes[module], {}, 0, None, None, ())

    def _try(self, step: Callable[[], None]) -> None:
        try:
            step()
        except Poison:
            pass

    def _own(self, module: str, kind: type[ast.Item]) -> list[ast.Item]:
        return [symbol.item for symbol in self.scopes[module].own.values() if isinstance(symbol.item, kind)]

    # Declarations ---------------------------------------------------------------------------------------------

    def _signals(self, module: str) -> None:
        for item in self._own(module, ast.Event):
            assert isinstance(item, ast.Event)
            self.events[item.name] = item.span
        for item in self._own(module, ast.Signal):
            assert isinstance(item, ast.Signal)
            known = self.signals.get(item.name)
            fields = []
            seen: dict[str, Span] = {}
            for field in item.fields_:
                if field.name in seen:
                    self.found.append(Duplicate(field.span, seen[field.name], "field", field.name))
                    continue
                seen[field.name] = field.span
                self._try(lambda field=field: fields.append(self._field(field, module)))  # type: ignore[misc]
            if item.kind == "corridor" and not fields:
                fields = [FieldType(side, "polyline", "m", False, None, None, None, item.span) for side in ("left", "right")]
            signal = SignalType(item.name, item.kind, item.many, tuple(fields), item.span)
            if known is not None and known != signal:
                self.found.append(SignalConflict(item.span, known.span, item.name))
            else:
                self.signals[item.name] = known or signal
        for item in self._own(module, ast.Event):
            assert isinstance(item, ast.Event)
            if item.name in self.signals:
                self.found.append(SignalConflict(item.span, self.signals[item.name].span, item.name))

    def _field(self, field: ast.Field, module: str) -> FieldType:
        if field.type in ("polyline", "bool"):
            if field.range or field.default or field.increasing:
                self.x.fail(BadValue(field.span, f"a {field.type} has no range, order or default"))
            return FieldType(field.name, field.type, "1", False, None, None, None, field.span)
        unit, dimension = field.type, parse_unit(field.type)[2]
        lower, upper = self._range(field.range, unit, dimension, module)
        default = None if field.default is None else self._finite(field.default, unit, dimension, module)
        if default is not None and not _inside(default, lower, upper):
            self.x.fail(BadValue(field.span, f"the default of `{field.name}` is outside its range"))
        return FieldType(field.name, "number", unit, field.increasing, lower, upper, default, field.span)

    def _range(self, limits: ast.Range | None, unit: str, dimension: Dimension, module: str) -> tuple[float | None, float | None]:
        """A range in SI; bounds without a unit are in the declared one."""
        if limits is None:
            return None, None
        lower = self._literal(limits.lower, unit, dimension, module)
        upper = self._literal(limits.upper, unit, dimension, module)
        if not lower <= upper:
            self.x.fail(BadValue(limits.span, "a range runs from low to high", None, "swap the bounds"))
        return lower, upper

    def _finite(self, expr: ast.Expr, unit: str, dimension: Dimension, module: str) -> float:
        """A literal in SI that is not infinite: ranges have open ends, values don't."""
        value = self._literal(expr, unit, dimension, module)
        if not math.isfinite(value):
            self.x.fail(BadValue(expr.__dict__["span"], "this value is not finite"))
        return value

    def _literal(self, expr: ast.Expr, unit: str, dimension: Dimension, module: str) -> float:
        """A literal bound in SI: bare numbers are in `unit`, others must have its dimension."""
        if isinstance(expr, ast.Unary):
            return -self._literal(expr.operand, unit, dimension, module)
        if isinstance(expr, ast.Name):
            return math.inf
        if not isinstance(expr, ast.Number):
            raise AssertionError(f"a bound is a literal, not {type(expr).__name__}")
        if expr.unit:
            own = parse_unit(expr.unit)[2]
            if own != dimension:
                self.x.fail(WrongDimension(expr.span, None, "this value", f"{name(dimension)} [{show(dimension)}]", name(own)))
            return to_si(float(expr.text), expr.unit)
        return to_si(float(expr.text), unit)

    def _params(self, module: str) -> None:
        items = [i for i in self._own(module, ast.Param) if isinstance(i, ast.Param)]
        for item in items:
            self._try(lambda item=item: self._param(item, module))  # type: ignore[misc]

    def _param(self, item: ast.Param, module: str) -> None:
        dimension = parse_unit(item.unit)[2]
        self.x.params[f"{module}.{item.name}"] = dimension
        value = self.x.number(item.value, self._context(module))
        if value.dimension != dimension:
            hint = f"write `{value.span.text} {item.unit}`" if value.dimension == NUMBER and isinstance(item.value, ast.Number) else ""
            what = f"parameter `{item.name}`"
            wanted = f"{name(dimension)} [{item.unit}]"
            self.x.fail(WrongDimension(value.span, item.span, what, wanted, f"{value.spoken} [{show(value.dimension)}]", hint))
        number = self._constant(value.node, value.span)
        lower, upper = self._range(item.range, item.unit, dimension, module)
        if not _inside(number, lower, upper):
            assert item.range is not None
            self.x.fail(BadValue(value.span, f"the value of `{item.name}` is outside its range", item.range.span))
        qualified = f"{module}.{item.name}"
        self.params[qualified] = ParamInfo(qualified, number, item.unit, lower, upper, item.source, item.span)

    def _constant(self, node: ir.Num, span: Span) -> float:
        """The value of a number made of literals and parameters declared before."""
        value = constant_value(node, lambda name: self.params[name].value if name in self.params else None)
        if value is None:
            self.x.fail(BadValue(span, "this is not constant", None, "use literals and parameters that are declared before"))
        if not math.isfinite(value):
            self.x.fail(BadValue(span, "this value is not finite"))
        return value

    def _tables(self, module: str) -> None:
        for item in self._own(module, ast.Table):
            assert isinstance(item, ast.Table)
            self._try(lambda item=item: self._table(item, module))  # type: ignore[misc]

    def _table(self, item: ast.Table, module: str) -> None:
        argument, result = parse_unit(item.unit)[2], parse_unit(item.result)[2]
        rows = [(self._finite(a, item.unit, argument, module), self._finite(b, item.result, result, module)) for a, b in item.rows]
        for (before, _), (after, _), row in zip(rows, rows[1:], item.rows[1:]):
            if not before < after:
                self.x.fail(BadValue(row[0].__dict__["span"], "the knots of a table ascend", None, "sort the rows; each knot stands once"))
        qualified = f"{module}.{item.name}"
        self.tables[qualified] = TableInfo(
            qualified, tuple(r[0] for r in rows), tuple(r[1] for r in rows), (item.unit, item.result), item.span
        )
        self.x.tables[qualified] = (argument, result)

    def _places(self, module: str) -> None:
        for item in self._own(module, ast.Place):
            assert isinstance(item, ast.Place)
            self._try(lambda item=item: self._place(item, module))  # type: ignore[misc]

    def _place(self, item: ast.Place, module: str) -> None:
        length = parse_unit("m")[2]
        points = tuple((self._finite(x, "m", length, module), self._finite(y, "m", length, module)) for x, y in item.points)
        least = 3 if item.kind == "zone" else 2
        if len(set(points)) < least:
            self.x.fail(BadValue(item.span, f"a {item.kind} has at least {least} different points"))
        qualified = f"{module}.{item.name}"
        self.places[qualified] = PlaceInfo(qualified, item.kind, points, item.span)

    def _definitions(self, module: str) -> None:
        for symbol in self.scopes[module].own.values():
            item = symbol.item
            if isinstance(item, ast.Define):
                # A definition may use the rule's timeline: check it with one at hand.
                timeline = self.x.make(ir.Axis, "", "samples", 1, 0)
                ctx = self._context(module).bind({}, 1, timeline)
                self._try(lambda s=symbol, i=item, c=ctx: calls.check_definition(self.x, s, i, c))  # type: ignore[misc]

    def _constraints(self, module: str) -> None:
        for item in self.library.modules[module].tree.items:
            if isinstance(item, ast.Constrain):
                self._try(lambda item=item: self._constraint(item, module))  # type: ignore[misc]

    def _constraint(self, item: ast.Constrain, module: str) -> None:
        formula = self.x.formula(item.condition, self._context(module)).node
        self.constraints.append(ConstraintInfo(formula, item.because, item.span))

    def _rules(self) -> list[RuleInfo]:
        rules: list[RuleInfo] = []
        first: dict[str, ast.Item] = {}
        assumptions = {item.__dict__["name"] for item in self._items(ast.Assume)}
        for module in self.order:
            for item in self.library.modules[module].tree.items:
                if not isinstance(item, (ast.Rule, ast.Assume)):
                    continue
                if item.name in first:
                    kind = "rule" if isinstance(item, ast.Rule) else "assumption"
                    self.found.append(Duplicate(_head(item.span), _head(first[item.name].__dict__["span"]), kind, item.name))
                    continue
                first[item.name] = item
                rule = RuleBuilder(self.x, self._context(module)).build(item, assumptions)
                if rule is not None:
                    rules.append(rule)
        return rules


def _inside(value: float, lower: float | None, upper: float | None) -> bool:
    return (lower is None or value >= lower) and (upper is None or value <= upper) and not math.isnan(value)


def _head(span: Span) -> Span:
    stop = span.file.text.find("\n", span.start)
    return Span(span.file, span.start, min(span.end, stop if stop >= 0 else span.end))


__all__ = ["Compiled", "compile_paths", "describe"]
