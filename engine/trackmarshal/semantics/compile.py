"""Modules to a Spec: every declaration checked, every rule typed and lowered, every error found."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable
from contextlib import suppress
from functools import cached_property, partial
from pathlib import Path
from typing import NoReturn, TypeGuard, TypeVar

from trackmarshal import outlines, typed
from trackmarshal.diagnostics.base import Diagnostic, Diagnostics, close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import (
    UNKNOWN,
    ConstraintInfo,
    FieldType,
    ParamInfo,
    PlaceInfo,
    RuleInfo,
    SignalType,
    Spec,
    TableInfo,
    track_of,
)
from trackmarshal.lowering.expressions import Lowering
from trackmarshal.node import Node
from trackmarshal.semantics.advice.bounds import Bounds
from trackmarshal.semantics.again import Before
from trackmarshal.semantics.causes import told_once
from trackmarshal.semantics.constants import constant_value, literal, settled
from trackmarshal.semantics.declarations.courses import check_course
from trackmarshal.semantics.declarations.enums import check_enum, declared
from trackmarshal.semantics.declarations.lifetimes import lifetimes
from trackmarshal.semantics.declarations.records import check_field, record_params
from trackmarshal.semantics.declarations.rulebooks import Rulebooks, check_signal, check_test_target
from trackmarshal.semantics.declarations.shapes import check_shape, own_fields
from trackmarshal.semantics.declarations.states import check_state
from trackmarshal.semantics.declarations.tables import table_info
from trackmarshal.semantics.elsewhere import Elsewhere
from trackmarshal.semantics.errors.declarations import (
    BackwardStretch,
    BadPlace,
    ScaleConflict,
    SignalConflict,
)
from trackmarshal.semantics.errors.expressions import BadValue, WrongDimension, WrongKind
from trackmarshal.semantics.errors.names import Duplicate
from trackmarshal.semantics.expressions.calls import built_in_names
from trackmarshal.semantics.expressions.checking import Context, Expressions, any_timeline
from trackmarshal.semantics.expressions.definitions import check_definition
from trackmarshal.semantics.expressions.dimensions import unit_hint as wanted_unit
from trackmarshal.semantics.expressions.members import unknown
from trackmarshal.semantics.expressions.places import ends
from trackmarshal.semantics.expressions.quantifiers import check_used
from trackmarshal.semantics.expressions.values import Poison, on_open_line
from trackmarshal.semantics.modules import Library
from trackmarshal.semantics.rules import RuleBuilder
from trackmarshal.semantics.scope import KINDS, Scope, spoken
from trackmarshal.semantics.warnings.vacuity import NeverAsked
from trackmarshal.source import NOWHERE, Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.build import is_unit
from trackmarshal.syntax.errors import UnknownUnit
from trackmarshal.syntax.foreign_units import unit_hint
from trackmarshal.typed import Symbol
from trackmarshal.units import NUMBER, Dimension, digits, in_full, name, parse_unit, quantity, show

T = TypeVar("T", bound=ast.Item)


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
    #: What made the numbers of its rules.
    interner: ir.Interner

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


def compile_paths(
    paths: Iterable[Path], shown_from: Path | None = None, before: Compiled | None = None
) -> Compiled:
    """Load and compile files and folders with all that they use; never raises for what is wrong with them.

    before: what was compiled with some of the same modules; their rules are taken from there where all that they rest on is the same.
    """
    library = Library(shown_from)
    asked = library.load(paths)
    return _Compiler(library, asked, before).run()


def compile_text(text: str, shown_from: Path | None = None, folder: Path | None = None) -> Compiled:
    """The same for a text in memory, which uses modules as a file of the folder (default: the current one) would."""
    library = Library(shown_from)
    asked = library.load_text(text, folder)
    return _Compiler(library, asked).run()


class _Compiler:
    def __init__(self, library: Library, asked: tuple[str, ...], before: Compiled | None = None) -> None:
        self._compiled_before = before
        self.library = library
        self.asked = asked
        self.order = library.order(asked)
        self.found: list[Diagnostic] = list(library.found)
        self.signals: dict[str, SignalType] = {}
        self.events: dict[str, Span] = {}
        self.params: dict[str, ParamInfo] = {}
        self.tables: dict[str, TableInfo] = {}
        #: The parameters of records, by the identity of their declaration.
        self.record_params: dict[int, list[ast.Param]] = {}
        #: By SI unit the scale of margins, and where it is declared first.
        self.scaled: dict[str, tuple[float, ast.Scale]] = {}
        self.places: dict[str, PlaceInfo] = {}
        self.constraints: list[ConstraintInfo] = []
        # Rules that are taken from there share their numbers with those that are made here.
        self.interner = ir.Interner() if before is None else before.interner
        self.x = Expressions(self.signals, self.found)
        self.x.bounds = Bounds(self.signals, self.params, self.tables)
        self.scopes = self.x.scopes
        self.elsewhere = Elsewhere(library)

    def run(self) -> Compiled:
        for module in self.order:
            self._scope(module)
        for module in self.order:  # in a circle of modules, one uses a module that comes later
            self._uses(module)
            self.scopes[module].check_own()
        for step in (
            self._enums,
            self._fields_of_shapes,
            self._shapes,
            self._signals,
            self._courses,
            self._params,
            self._scales,
            self._tables,
            self._places,
            self._stretches,
            self._states,
            self._definitions,
            self._constraints,
        ):
            for module in self.order:
                step(module)
        rules = self._rules()
        broken = {name for scope in self.scopes.values() for name in scope.own_broken}
        names = {i.__dict__["name"] for i in self._items(ast.Rule, ast.Assume)} | broken
        silent = {rule.name for rule in rules if rule.formula is None}
        books = Rulebooks(self.scopes, names, silent, self.found)
        rulebooks = tuple(
            books.check(item, module) for module in self.order for item in self._own(module, ast.Rulebook)
        )
        for test in self._items(ast.Test):
            check_test_target(test, names, self.found)
        self._unasked()
        digest = hashlib.sha256("".join(r.fingerprint for r in rules).encode())
        for info in [*self.params.values(), *self.tables.values(), *self.places.values()]:
            digest.update(repr(info).encode())
        scales = tuple(sorted(self.x.scales.items()))
        if scales:  # of a spec without one, what is kept of runs rests on
            digest.update(repr(scales).encode())
        spec = Spec(
            self.signals,
            self.events,
            self.params,
            self.tables,
            self.places,
            tuple(self.constraints),
            tuple(rules),
            rulebooks,
            digest.hexdigest(),
            scales,
            tuple(self.x.courses.values()),
        )
        found = tuple(told_once(self.found))
        return Compiled(
            spec,
            self.library,
            self.asked,
            self.order,
            self.scopes,
            self.x,
            found,
            tuple(self.library.failures),
            self.interner,
        )

    @cached_property
    def _before(self) -> Before:
        """What is known of these modules already; asked for once everything is declared that rules may read."""
        wrong = self.found or self.library.failures
        return Before(
            None if wrong else self._compiled_before, self.library, self.order, self.signals, self.events, self.x.courses, self.x.scales
        )  # fmt: skip

    def _items(self, *kinds: type[ast.Item]) -> list[ast.Item]:  # type: ignore[explicit-any, unused-ignore]
        return [
            i
            for module in self.order
            for i in self.library.modules[module].tree.items
            if isinstance(i, kinds)
        ]

    def _scope(self, module: str) -> None:
        scope = self.scopes[module] = Scope(module, self.found, self.elsewhere.modules)
        loaded = self.library.modules[module]
        for item in loaded.tree.items:
            if type(item) in KINDS:
                scope.declare(item.__dict__["name"], item)
            if isinstance(item, (ast.Define, ast.Table)) and item.name in built_in_names():
                self.found.append(Duplicate(item.span.head, NOWHERE, "function", item.name))
        scope.own_broken = loaded.broken
        scope.broken = set(loaded.broken)
        scope.incomplete = not loaded.complete

    def _uses(self, module: str) -> None:
        for use in self.library.modules[module].uses:
            if use.name in self.scopes and use.name != module:
                self.scopes[module].use(self.scopes[use.name])
            elif use.name != module:
                self.scopes[module].incomplete = True

    def _context(self, module: str) -> Context:
        return Context(self.scopes[module], {}, 0, typed.THE_RUN, None, ())

    def _own(self, module: str, kind: type[T]) -> list[T]:
        """A module's declarations of a kind; those that were declared twice too, for the errors in them."""
        return [item for item in self.library.modules[module].tree.items if isinstance(item, kind)]

    # Declarations ---------------------------------------------------------------------------------------------

    def _signals(self, module: str) -> None:
        for event in self._own(module, ast.Event):
            self.events[event.name] = event.span
        for item in self._own(module, ast.Signal):
            known = self.signals.get(item.name)
            fields: list[FieldType] = []
            seen: dict[str, Span] = {}
            check_signal(item, self.found)
            for field in item.fields_:
                if field.name in seen:
                    self.found.append(Duplicate(field.span, seen[field.name], "field", field.name))
                    continue
                seen[field.name] = field.span
                fields.append(self._field(field, module))
            if item.kind == "corridor" and not fields:
                fields = [
                    FieldType(side, "polyline", "m", False, None, None, None, item.span)
                    for side in ("left", "right")
                ]
            capacity, forget = lifetimes(
                item,
                lambda expr, unit: self._finite(expr, unit, parse_unit(unit)[2], module),
                self.found,
            )
            signal = SignalType(item.name, item.kind, item.many, tuple(fields), item.span, capacity, forget)
            if known is None:
                self.signals[item.name] = signal
            elif known != signal and self.scopes[module].own[item.name].item is item:
                self.found.append(SignalConflict(item.span.head, known.span.head, item.name))
        for flag, span in self.events.items():
            same = self.signals.get(flag)
            if same is not None and same.span.file is not span.file:
                self.found.append(SignalConflict(span.head, same.span.head, flag))

    def _enums(self, module: str) -> None:
        for item in self._own(module, ast.Enum):
            check_enum(item, self.found)

    def _fields_of_shapes(self, module: str) -> None:
        for item in self._own(module, ast.Shape):
            fields = own_fields(
                self.x, item, f"{module}.{item.name}", lambda field: self._field(field, module)
            )
            if fields is not None:
                self.x.own_fields.setdefault(f"{module}.{item.name}", fields)

    def _shapes(self, module: str) -> None:
        for item in self._own(module, ast.Shape):
            symbol = Symbol(item, module, f"{module}.{item.name}")
            self.x.attempt(partial(check_shape, self.x, item, symbol), item.span.head)

    def _field(self, field: ast.Field, module: str) -> FieldType:
        """The contract of a field; where a part of it has an error, the field is there all the same."""
        if field.type == "polyline":
            if field.range or field.default or field.increasing:
                self.found.append(BadValue(field.span, "a polyline has no range, order or default"))
            return FieldType(field.name, field.type, "1", False, None, None, None, field.span)
        if field.type == "bool":
            if field.range or field.increasing:
                self.found.append(BadValue(field.span, "a bool has no range or order"))
            truth = self._truth_of(field)
            return FieldType(field.name, field.type, "1", False, None, None, truth, field.span)
        if not is_unit(field.type):
            return self._member_of(field, module)
        unit, dimension = field.type, parse_unit(field.type)[2]
        lower, upper, default = None, None, None
        with suppress(Poison):
            lower, upper = self._range(field.range, unit, dimension, module)
        if field.default is not None:
            with suppress(Poison):
                if isinstance(field.default, ast.Boolean) or _is_word(field.default):
                    at = field.default.__dict__["span"]
                    self.x.fail(BadValue(at, f"the default of `{field.name}` is a number in {unit}"))
                default = self._finite(field.default, unit, dimension, module)
                if not _inside(default, lower, upper):
                    at, limits = field.default.__dict__["span"], field.range.span if field.range else None
                    problem = f"the default of `{field.name}`, {in_full(default, unit)}, is {_outside(lower, upper, unit)}"
                    self.found.append(BadValue(at, problem, limits))
        return FieldType(field.name, "number", unit, field.increasing, lower, upper, default, field.span)

    def _truth_of(self, field: ast.Field) -> float | None:
        """The default of a Boolean."""
        if field.default is None or isinstance(field.default, ast.Boolean):
            return None if field.default is None else float(field.default.value)
        at = field.default.__dict__["span"]
        self.found.append(BadValue(at, f"the default of `{field.name}` is true or false"))
        return None

    def _member_of(self, field: ast.Field, module: str) -> FieldType:
        """A field that is a member of an enumeration, by the place of the member."""
        at, scope = field.span.word(field.type), self.scopes[module]
        symbol = scope.find(field.type)
        known = scope.look_up(field.type, at, "enumeration", set()) if scope.knows(field.type) else None
        if symbol is None or not isinstance(symbol.item, ast.Enum):
            if isinstance(known, Diagnostic):
                self.found.append(known)
            elif symbol is not None:
                self.found.append(
                    WrongKind(at, "a unit or an enumeration", f"the {spoken(symbol.item)} `{field.type}`")
                )
            elif field.type not in scope.broken and not scope.incomplete:
                self.found.append(
                    UnknownUnit(at, "unit or enumeration", field.type, self._type_hint(field.type, scope))
                )
            return FieldType(field.name, UNKNOWN, "1", False, None, None, None, field.span)
        made = declared(symbol.item, symbol.module)
        if field.range or field.increasing:
            self.found.append(BadValue(field.span, "a member of an enumeration has no range or order"))
        default = None
        if _is_word(field.default) and field.default.name in made.members:
            default = float(made.members.index(field.default.name))
        elif _is_word(field.default):
            self.found.append(unknown(made, field.default.name, field.default.span))
        elif field.default is not None:
            problem = f"the default of `{field.name}` is a member of `{field.type}`"
            hint = f"its members are {', '.join(made.members)}"
            self.found.append(BadValue(field.default.__dict__["span"], problem, None, hint))
        return FieldType(field.name, "number", "1", False, None, None, default, field.span, made)

    def _type_hint(self, name: str, scope: Scope) -> str:
        """What may have been meant by the type of a field: an enumeration, or a unit."""
        known = [
            n for n in scope.names() if (s := scope.find(n)) is not None and isinstance(s.item, ast.Enum)
        ]
        return close_matches(name, known) or unit_hint(name, name, "polyline, bool, or the name of an `enum`")

    def _range(
        self, limits: ast.Range | None, unit: str, dimension: Dimension, module: str
    ) -> tuple[float | None, float | None]:
        """A range in SI; bounds without a unit are in the declared one."""
        if limits is None:
            return None, None
        lower, upper = self.x.all(
            lambda: self._literal(limits.lower, unit, dimension, module),
            lambda: self._literal(limits.upper, unit, dimension, module),
        )
        if not lower <= upper:
            problem = (
                f"a range runs from low to high, not from {in_full(lower, unit)} to {in_full(upper, unit)}"
            )
            self.x.fail(BadValue(limits.span, problem, None, "swap the bounds"))
        return lower, upper

    def _finite(self, expr: ast.Expr, unit: str, dimension: Dimension, module: str) -> float:
        """A literal in SI that is not infinite: ranges have open ends, values don't."""
        value = self._literal(expr, unit, dimension, module)
        if not math.isfinite(value):
            self.x.fail(
                BadValue(
                    expr.__dict__["span"],
                    f"this value is {in_full(value, '1')}, which is not finite",
                    None,
                    "only ranges may be open: `in [0, inf]`",
                )
            )
        return value

    def _literal(self, expr: ast.Expr, unit: str, dimension: Dimension, module: str) -> float:
        """A literal bound in SI: bare numbers are in `unit`, others must have its dimension."""
        if isinstance(expr, ast.Unary):
            return -self._literal(expr.operand, unit, dimension, module)
        if isinstance(expr, ast.Name):
            return math.inf
        if not isinstance(expr, ast.Number):
            raise AssertionError(f"a bound is a literal, not {type(expr).__name__}")
        own = parse_unit(expr.unit)[2] if expr.unit else dimension
        if own != dimension:
            hint = f"write it in {unit}" + (", or leave the unit out" if unit != "1" else "")
            self.x.fail(
                WrongDimension(expr.span, None, "this value", quantity(dimension), quantity(own), hint)
            )
        value, problem = literal(expr.text, expr.unit or unit)
        if problem:
            self.x.fail(BadValue(expr.span, problem, None, "is an exponent or a unit wrong?"))
        return value

    def _courses(self, module: str) -> None:
        for item in self._own(module, ast.Course):
            own = self.scopes[module].own[item.name].item is item
            self.x.attempt(
                lambda item=item, own=own: check_course(item, self.x, self._context(module), own),  # type: ignore[misc]
                item.span.head,
            )

    def _params(self, module: str) -> None:
        for record in self._own(module, ast.ParamRecord):
            self.x.attempt(lambda record=record: self._record(record, module), record.span.head)  # type: ignore[misc]
        for item in self._own(module, ast.Param):
            check_field(self.x, item, self.scopes[module])
        items = [
            param
            for item in self.library.modules[module].tree.items
            for param in (
                [item]
                if isinstance(item, ast.Param)
                else self.record_params.get(id(item), [])
                if isinstance(item, ast.ParamRecord)
                else []
            )
        ]
        for item in items:
            self.x.params.setdefault(f"{module}.{item.name}", parse_unit(item.unit)[2])
            self.x.advice.units.setdefault(f"{module}.{item.name}", item.unit)
        for item in items:
            self.x.attempt(lambda item=item: self._param(item, module), item.span.head)  # type: ignore[misc]

    def _record(self, item: ast.ParamRecord, module: str) -> None:
        """The parameters that a record is made of; they are looked at with all others, in the order of their declarations."""
        qualified = f"{module}.{item.name}"
        shape, params = record_params(self.x, item, self.scopes[module])
        self.record_params[id(item)] = params
        self.x.records.setdefault(qualified, shape)

    def _param(self, item: ast.Param, module: str) -> None:
        dimension = parse_unit(item.unit)[2]
        number, (lower, upper) = self.x.all(
            lambda: self._param_value(item, dimension, module),
            lambda: self._range(item.range, item.unit, dimension, module),
        )
        if not _inside(number, lower, upper):
            assert item.range is not None
            at, unit = item.value.__dict__["span"], item.unit
            problem = (
                f"the value of `{item.name}`, {in_full(number, unit)}, is {_outside(lower, upper, unit)}"
            )
            self.x.fail(BadValue(at, problem, item.range.span))
        qualified = f"{module}.{item.name}"
        self.params.setdefault(
            qualified,
            ParamInfo(
                qualified,
                number,
                item.unit,
                lower,
                upper,
                item.source,
                item.span,
                item.name.partition(".")[0] if "." in item.name else "",
            ),
        )

    def _param_value(self, item: ast.Param, dimension: Dimension, module: str) -> float:
        value = self.x.number(item.value, self._context(module))
        if value.dimension != dimension:
            hint = wanted_unit(value, dimension, item.unit)
            if value.dimension == NUMBER and isinstance(item.value, ast.Number) and not item.value.unit:
                hint = f"write the unit: `{item.value.text} {item.unit}`"
            what = f"parameter `{item.name}`"
            wanted = f"{name(dimension)} [{item.unit}]" if dimension != NUMBER else name(dimension)
            declared = item.span.word(item.unit)
            self.x.fail(WrongDimension(value.span, declared, what, wanted, quantity(value.dimension), hint))
        what = f"parameter `{item.name}`"
        self.x.advise(self.x.advice.in_unit(value, item.unit, what, item.span.word(item.unit)))
        return self._constant(Lowering(self.interner).number(value), value.span, module)

    def _constant(self, node: ir.Num, span: Span, module: str) -> float:
        """The value of a number made of literals and parameters declared before."""
        for part in ir.below(node):
            if isinstance(part, ir.Param) and part.name not in self.params:
                self._without_value(part.name, span, module)
        value = constant_value(node, lambda name: self.params[name].value)
        if value is None:
            self.x.fail(
                BadValue(
                    span, "this is not constant", None, "use literals and parameters that are declared before"
                )
            )
        if not math.isfinite(value):
            self.x.fail(
                BadValue(
                    span,
                    f"this value is {in_full(value, '1')}, which is not finite",
                    None,
                    "its arithmetic divides by zero or overflows",
                )
            )
        return value

    def _without_value(self, qualified: str, span: Span, module: str) -> NoReturn:
        """Fail for a parameter that has no value yet; where its own error was reported, silently."""
        own = self.scopes[module].own.items()
        symbol, short = next(
            ((known, name) for name, known in own if f"{qualified}.".startswith(f"{module}.{name}.")),
            (None, ""),
        )
        if symbol is not None:
            declared: Span = symbol.item.__dict__["span"]
            if declared.start < span.start < declared.end:
                self.x.fail(
                    BadValue(
                        span.word(short), f"the value of `{short}` needs itself", None, "write its value"
                    )
                )
            if declared.start > span.start:
                hint, about = "move its declaration up", "it is declared here"
                self.x.fail(
                    BadValue(
                        span.word(short), f"`{short}` is declared further down", declared.head, hint, about
                    )
                )
        raise Poison

    def _scales(self, module: str) -> None:
        for item in self._own(module, ast.Scale):
            self.x.attempt(lambda item=item: self._scale(item, module), item.span.head)  # type: ignore[misc]

    def _scale(self, item: ast.Scale, module: str) -> None:
        dimension = parse_unit(item.unit)[2]
        value, unit = self._finite(item.value, item.unit, dimension, module), show(dimension)
        if not value > 0.0:
            at, problem = item.value.__dict__["span"], f"a scale is above 0, not {in_full(value, item.unit)}"
            self.x.fail(BadValue(at, problem, None, "write the margin that counts as 1"))
        first = self.scaled.setdefault(unit, (value, item))
        if first[0] != value:
            self.x.fail(ScaleConflict(item.span, first[1].span, name(dimension)))
        self.x.scales[unit] = value

    def _tables(self, module: str) -> None:
        for item in self._own(module, ast.Table):
            self.x.attempt(lambda item=item: self._table(item, module), item.span.head)  # type: ignore[misc]

    def _table(self, item: ast.Table, module: str) -> None:
        qualified = f"{module}.{item.name}"
        info = table_info(self.x, item, qualified, partial(self._finite_in, module))
        self.x.advice.units.setdefault(qualified, item.result)
        self.tables.setdefault(qualified, info)

    def _finite_in(self, module: str, expr: ast.Expr, unit: str, dimension: Dimension) -> float:
        return self._finite(expr, unit, dimension, module)

    def _places(self, module: str) -> None:
        for item in self._own(module, ast.Place):
            self.x.attempt(lambda item=item: self._place(item, module), item.span.head)  # type: ignore[misc]

    def _place(self, item: ast.Place, module: str) -> None:
        length = parse_unit("m")[2]
        numbers = self.x.all(
            *(lambda n=n: self._finite(n, "m", length, module) for point in item.points for n in point)
        )
        points = tuple(zip(numbers[::2], numbers[1::2]))
        least = 3 if item.kind == "zone" else 2
        if len(set(points)) < least:
            problem = f"a {item.kind} has at least {least} different points, not {len(set(points))}"
            self.x.fail(BadValue(item.span.head, problem))
        wrong = outlines.problem(item.kind, points)
        if wrong is not None:
            other = None if wrong.other is None else _point(item, wrong.other)
            text = f"the {item.kind} `{item.name}` {wrong.text}"
            self.x.fail(BadPlace(_point(item, wrong.at), other, text, wrong.hint))
        qualified = f"{module}.{item.name}"
        self.places.setdefault(
            qualified, PlaceInfo(qualified, item.kind, points, item.span, track_of(module))
        )

    def _stretches(self, module: str) -> None:
        for item in self._own(module, ast.Stretch):
            if not self.x.attempt(lambda item=item: self._stretch(item, module), item.span.head):  # type: ignore[misc]
                self.x.failed.add(f"{module}.{item.name}")

    def _stretch(self, item: ast.Stretch, module: str) -> None:
        line, *numbers = ends(item, self.x, self._context(module))
        start, end = self.x.all(
            *(lambda n=n: self._constant(Lowering(self.interner).number(n), n.span, module) for n in numbers)
        )
        if on_open_line(line) and end < start:
            self.x.fail(BackwardStretch(numbers[1].span, line.span, in_full(start, "m"), in_full(end, "m")))

    def _definitions(self, module: str) -> None:
        if module in self._before.modules:
            return
        # A definition may use the rule's timeline: check it with one at hand.
        ctx = self._context(module).bind({}, 1, any_timeline(NOWHERE))
        for item in self._own(module, ast.Define):
            start = len(self.found)
            seen: dict[str, Span] = {}
            for parameter in item.parameters:
                if parameter.name in seen:
                    self.found.append(
                        Duplicate(parameter.span, seen[parameter.name], "parameter", parameter.name)
                    )
                seen.setdefault(parameter.name, parameter.span)
                self.scopes[module].check_bound(parameter.name, parameter.span, "parameter")
            symbol = Symbol(item, module, f"{module}.{item.name}")
            check, before = partial(check_definition, self.x, symbol, item, ctx), len(self.found)
            if not self.x.attempt(check, item.span.head):
                self.x.failed.add(symbol.qualified)
            # Where a rule uses it, they are found again, and the rule may allow them.
            self.found[before:] = [d for d in self.found[before:] if not d.code.startswith("W")]
            if not any(found.level == "error" for found in self.found[start:]):
                for parameter in item.parameters:
                    check_used(self.x, (parameter.name,), (item.body,), parameter.span)

    def _states(self, module: str) -> None:
        for item in self._own(module, ast.State):
            self.x.expansions = 0
            check_state(item, Symbol(item, module, f"{module}.{item.name}"), self.x, self._context(module))

    def _unasked(self) -> None:
        """Warn of states that nothing depends on; where something is wrong, what it would ask for is not known."""
        if any(found.level == "error" for found in self.found) or self.library.failures:
            return
        for module in self.asked:
            for item in self._own(module, ast.State):
                if f"{module}.{item.name}" not in self.x.asked:
                    element = f"({item.binder})" if item.binder else ""
                    self.found.append(NeverAsked(item.span.head, item.name, element))

    def _constraints(self, module: str) -> None:
        for item in self.library.modules[module].tree.items:
            if isinstance(item, ast.Constrain):
                self.x.attempt(lambda item=item: self._constraint(item, module), item.span.head)  # type: ignore[misc]

    def _constraint(self, item: ast.Constrain, module: str) -> None:
        condition = self.x.formula(item.condition, self._context(module))
        formula = Lowering(self.interner).formula(condition)
        if not settled(formula):
            at = item.condition.__dict__["span"]
            hint = "what the input must fulfil is an `assume` with a `monitor`, or a `rule`"
            self.x.fail(
                BadValue(at, "a constraint is about parameters and tables, not about inputs", None, hint)
            )
        self.constraints.append(ConstraintInfo(formula, item.because, item.span))

    def _rules(self) -> list[RuleInfo]:
        rules: list[RuleInfo] = []
        first: dict[str, ast.Item] = {}
        broken = {name for scope in self.scopes.values() for name in scope.own_broken}
        assumptions = {item.__dict__["name"] for item in self._items(ast.Assume)} | broken
        for module in self.order:
            for item in self.library.modules[module].tree.items:
                if not isinstance(item, (ast.Rule, ast.Assume)):
                    continue
                if item.name in first:
                    kind = "rule" if isinstance(item, ast.Rule) else "assumption"
                    self.found.append(
                        Duplicate(item.span.head, first[item.name].__dict__["span"].head, kind, item.name)
                    )
                rule = self._before.rule(module, item.name, assumptions)
                if rule is None:
                    rule = RuleBuilder(self.x, self._context(module), self.interner).build(item, assumptions)
                if rule is not None and item.name not in first:
                    rules.append(rule)
                first.setdefault(item.name, item)
        return rules


def _is_word(expr: ast.Expr | None) -> TypeGuard[ast.Name]:
    """Whether a default is a word, and not the name of a number."""
    return isinstance(expr, ast.Name) and expr.name != "inf"


def _point(item: ast.Place, index: int) -> Span:
    """Where a point of a zone or a line stands."""
    x, y = (expr.__dict__["span"] for expr in item.points[index])
    return Span(x.file, x.start, y.end)


def _outside(lower: float | None, upper: float | None, unit: str) -> str:
    """What is said of a value that is outside a range in SI."""
    low = digits(-math.inf if lower is None else lower, unit)
    high = digits(math.inf if upper is None else upper, unit)
    return f"outside its range [{low}, {high}]" + ("" if unit == "1" else f" {unit}")


def _inside(value: float, lower: float | None, upper: float | None) -> bool:
    return (lower is None or value >= lower) and (upper is None or value <= upper) and not math.isnan(value)


__all__ = ["Compiled", "compile_paths", "compile_text"]
