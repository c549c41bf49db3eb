"""Expressions: names resolved, dimensions checked; syntax tree to typed tree. All errors of an expression are found."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any, NoReturn, TypeVar

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir.operators import ARITHMETIC, QUANTIFIERS, TEMPORAL, UNTIL, known
from trackmarshal.ir.spec import UNKNOWN, CourseInfo, Enumeration, SignalType
from trackmarshal.node import Node
from trackmarshal.semantics import calls, courses, enums, states, stretches
from trackmarshal.semantics.advice.bounds import Bounds
from trackmarshal.semantics.advice.formulas import (
    changes,
    ends_early,
    goes_on,
    joins_conditions,
    met_by_others,
    same_everywhere,
)
from trackmarshal.semantics.advice.headings import between, laps_over, turns_over
from trackmarshal.semantics.advice.units import Advice
from trackmarshal.semantics.constants import literal
from trackmarshal.semantics.errors.expressions import (
    BadValue,
    DimensionMismatch,
    TooLarge,
    WrongDimension,
    WrongKind,
)
from trackmarshal.semantics.errors.names import Duplicate, UnknownField, UnknownName, UnknownReference
from trackmarshal.semantics.scope import Scope, spoken
from trackmarshal.semantics.sharing import Shared
from trackmarshal.semantics.values import (
    Broken,
    Local,
    Poison,
    common,
    own_unit,
    product,
    record_behind,
    record_spoken,
    span_of,
    written_unit,
)
from trackmarshal.semantics.values import spoken as value_spoken
from trackmarshal.semantics.warnings.vacuity import UnusedVariable
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.notation import ASKED
from trackmarshal.units import (
    NUMBER,
    TIME,
    Dimension,
    in_full,
    over,
    parse_unit,
    power,
    quantity,
    show,
    times,
)

T = TypeVar("T")


class Context(Node):
    """Where an expression stands: the names it sees, how deep it is nested, what its temporal operators range over."""

    scope: Scope
    local: dict[str, Local]
    level: int
    timeline: typed.TimeAxis
    #: The call in the rule's own file, while a definition is written out.
    site: Span | None
    #: Definitions being written out, outermost first.
    stack: tuple[str, ...]

    def bind(
        self, names: Mapping[str, Local], levels: int = 0, timeline: typed.TimeAxis | None = None
    ) -> Context:
        """This context with more local names, and `levels` more axes in use."""
        return Context(
            self.scope,
            {**self.local, **names},
            self.level + levels,
            timeline or self.timeline,
            self.site,
            self.stack,
        )

    def elsewhere(self, scope: Scope, span: Span) -> Context:
        """Where a declaration stands that is used here, at `span`: it sees the names of its own module."""
        return Context(scope, {}, self.level, self.timeline, self.site or span, self.stack)


def _run(step: Callable[[], Any]) -> Any:
    return step()


def any_timeline(span: Span) -> typed.TimeAxis:
    """A timeline where only the axis is missing: for definitions, which may use that of a rule, and for what follows an error."""
    domain = typed.Signal(SignalType("", "series", False, (), span), span)
    return typed.Range(domain, ("",), 0, span)


class Expressions:
    """Makes typed nodes of expressions; `signals` maps the names of signals to their types, `found` collects diagnostics."""

    def __init__(self, signals: dict[str, SignalType], found: list[Diagnostic]) -> None:
        self.signals = signals
        self.found = found
        self.scopes: dict[str, Scope] = {}
        #: By qualified name the fields of declared shapes: those that they declare themselves, and all.
        self.own_fields: dict[str, dict[str, Dimension | Enumeration | None]] = {}
        self.shapes: dict[str, typed.Shape] = {}
        #: By qualified name the units in which shapes declare their numbers.
        self.units: dict[str, dict[str, str]] = {}
        #: By qualified name the shapes of records of parameters.
        self.records: dict[str, typed.Shape] = {}
        #: SI unit -> the scale of margins in it, where that is declared.
        self.scales: dict[str, float] = {}
        self.params: dict[str, Dimension] = {}
        #: What numbers can come to; the compiler adds what it knows of parameters.
        self.bounds = Bounds(signals, {}, {})
        #: By name.
        self.courses: dict[str, CourseInfo] = {}
        self.advice = Advice()
        self._shapes: dict[str, typed.Shape] = {}
        #: Definitions (qualified names) whose bodies have errors: nothing more is said about their uses.
        self.failed: set[str] = set()
        #: States (qualified names) that something asks for.
        self.asked: set[str] = set()
        #: How many definitions were written out for the declaration at hand.
        self.expansions = 0
        #: How many of them are around the innermost one of the definition that is being written out.
        self.deepest = 0
        self.shared = Shared()

    def attempt(self, step: Callable[[], None], span: Span) -> bool:
        """Check one declaration, or one clause: whether it has a meaning; what keeps it from one was reported."""
        self.expansions = 0
        try:
            step()
        except Poison:
            return False
        except RecursionError:
            self.too_deep(span)
            return False
        return True

    def too_deep(self, span: Span) -> None:
        """Report what exhausted the stack: expressions may be deep, and definitions too, but not both."""
        self.found.append(
            TooLarge(span, "nested too deeply", "let fewer names, of `let` or `define`, build on each other")
        )

    def advise(self, diagnostic: Diagnostic | None) -> None:
        """Report what was found, if anything was; fail where it is an error."""
        if diagnostic is not None and diagnostic.level == "error":
            self.fail(diagnostic)
        if diagnostic is not None:
            self.found.append(diagnostic)

    def fail(self, diagnostic: Diagnostic) -> NoReturn:
        self.found.append(diagnostic)
        raise Poison

    def all(self, *steps: Callable[[], Any]) -> list[Any]:
        """Run all steps, so that the errors of each are reported; then fail if one did."""
        return self.each(_run, steps)

    def each(self, step: Callable[[T], Any], given: Iterable[T]) -> list[Any]:
        """The same of one step for each that is given."""
        values, failed = [], False
        for one in given:
            try:
                values.append(step(one))
            except Poison:
                failed = True
        if failed:
            raise Poison
        return values

    def literal(self, expr: ast.Number) -> tuple[float, Dimension]:
        """What digits with their unit are in SI, and of which dimension."""
        value, problem = literal(expr.text, expr.unit or "1")
        if problem:
            self.fail(BadValue(ast.span_of(expr), problem, None, "is an exponent or a unit wrong?"))
        return value, parse_unit(expr.unit or "1")[2]

    def number(self, expr: ast.Expr, ctx: Context) -> typed.Number:
        return self._numeric(self.value(expr, ctx), expr)

    def _numeric(self, value: typed.Value, expr: ast.Expr) -> typed.Number:
        if isinstance(value, typed.NumberNode):
            return value
        hint = ""
        if isinstance(value, typed.FormulaNode):
            hint = "`if FORMULA then 1 else 0` makes a number of a formula"
        elif isinstance(value, typed.Count):
            hint = "compare it with a number: `count(...) <= 3`"
        elif isinstance(value, typed.MemberNode):
            hint = enums.hint(value)
        self.fail(WrongKind(ast.span_of(expr), "a number", value_spoken(value), hint))

    def formula(self, expr: ast.Expr, ctx: Context) -> typed.Formula:
        value = self.value(expr, ctx)
        if not isinstance(value, typed.FormulaNode):
            hint = "compare it with something" if isinstance(value, (typed.NumberNode, typed.Count)) else ""
            if isinstance(value, typed.MemberNode):
                hint = enums.hint(value)
            if isinstance(value, typed.SignalNode):
                courses.refuse_course(value.signal, ast.span_of(expr), "no formula is made of", self)
            if isinstance(value, typed.SignalNode) and (value.signal.many or value.signal.sequence):
                each = f"o in {ast.span_of(expr).text}"
                hint = (
                    f"ask about what is in it: `exists {each}: (...)`, or how many there are, `count({each})`"
                )
            self.fail(WrongKind(ast.span_of(expr), "a formula", value_spoken(value), hint))
        return value

    def value(self, expr: ast.Expr, ctx: Context) -> typed.Value:
        span = ast.span_of(expr)
        match expr:  # the most frequent ones first
            case ast.Name():
                return self._name(expr, ctx)
            case ast.Attribute():
                return self._attribute(expr, ctx)
            case ast.Binary():
                return self._binary(expr, ctx)
            case ast.Number():
                value, dimension = self.literal(expr)
                return typed.Literally(dimension, own_unit(expr.unit), expr.text, expr.unit, value, span)
            case ast.Boolean():
                return typed.Boolean(expr.value, span)
            case ast.Call() if expr.function == states.TIME_IN:
                return states.time_in(expr, self, ctx)
            case ast.Call():
                return calls.call(self, expr.function, expr.args, expr.names, False, span, ctx)
            case ast.Infix() if expr.predicate == states.IS:
                return enums.asked(expr, self, ctx)
            case ast.Case():
                return enums.case(expr, self, ctx)
            case ast.Infix():
                return calls.call(self, expr.predicate, (expr.left, expr.right), ("", ""), True, span, ctx)
            case ast.Unary():
                if expr.op == "not":
                    return typed.Not(self.formula(expr.operand, ctx), span)
                operand = self.number(expr.operand, ctx)
                return typed.Negative(operand.dimension, operand.written, operand, span)
            case ast.IfElse():
                return self._if_else(expr, ctx)
            case ast.Within():
                return self._within(expr, ctx)
            case ast.Chained():
                return self._chained(expr, ctx)
            case ast.InZone():
                return self._in_zone(expr, ctx)
            case ast.InStretch():
                return stretches.in_stretch(expr, self, ctx)
            case ast.BetweenStations():
                return stretches.between_stations(expr, self, ctx)
            case ast.Temporal():
                return self._temporal(expr, ctx)
            case ast.Until():
                return self._until(expr, ctx)
            case ast.Quantified():
                return self._quantified(expr, ctx)
            case ast.Folded():
                return self._folded(expr, ctx)
            case _:
                raise AssertionError(f"unknown expression {type(expr).__name__}")

    # Names ------------------------------------------------------------------------------------------------

    def _name(self, expr: ast.Name, ctx: Context) -> typed.Value:
        if expr.name in ctx.local:
            value = ctx.local[expr.name]
            if isinstance(value, Broken):
                raise Poison  # the error is where the name was bound
            return value.at(expr.span)  # messages point to the use
        if expr.name == "pi" and ctx.scope.find("pi") is None:
            return typed.Pi(NUMBER, "", expr.span)
        return self._symbol(
            self.look_up(expr.name, expr.span, "name", {*ctx.local, "pi"}, ctx), expr.span, ctx
        )

    def _ended(self, expr: ast.Binary, before: int) -> None:
        """Names that a quantifier on the left of a connective binds are unknown on its right: that it ends there is what is to be said of them."""
        ended = {
            name: node.quantifier
            for node in expr.left.walk()
            if isinstance(node, ast.Quantified)
            for name in node.names
        }
        for at, item in enumerate(self.found[before:], before):
            if (
                isinstance(item, UnknownName)
                and item.name in ended
                and item.span.start >= ast.span_of(expr.right).start
            ):
                quantifier = f"{ended[item.name]} {item.name}"
                hint = f"`{quantifier}` ends before `{expr.op}`: put all that it is about in parentheses, `{quantifier} in ...: (...)`"
                self.found[at] = UnknownName(item.span, item.what, item.name, hint)

    def look_up(self, name: str, span: Span, what: str, extra: set[str], ctx: Context) -> typed.Symbol:
        """A declared name; fails with what is wrong with it."""
        found = ctx.scope.look_up(name, span, what, extra)
        if isinstance(found, typed.Symbol):
            return found
        if isinstance(found, Diagnostic):
            self.fail(found)
        raise Poison  # reported with the declaration

    def _symbol(self, symbol: typed.Symbol, span: Span, ctx: Context) -> typed.Value:
        item = symbol.item
        match item:
            case ast.Signal():
                signal = self.signals[item.name]
                if signal.kind == "state":
                    return typed.State(self._shape(signal), signal, span)
                if signal.kind == "polyline":
                    return typed.SignalLine(signal, span)
                return typed.Signal(signal, span)
            case ast.Course():
                if item.name not in self.courses:
                    raise Poison  # its declaration was reported
                return typed.Signal(self.courses[item.name].signal, span)
            case ast.Event():
                return typed.Event(symbol, span)
            case ast.Param():
                if symbol.qualified not in self.params:
                    raise Poison  # its declaration was reported
                unit = written_unit((item.value,), item.unit)
                return typed.Parameter(self.params[symbol.qualified], unit, symbol, None, span)
            case ast.ParamRecord():
                shape = self.records.get(symbol.qualified)
                if shape is None:
                    raise Poison  # its declaration was reported
                return typed.ParameterRecord(shape, None, symbol, span)
            case ast.Place():
                if item.kind == "zone":
                    return typed.Zone(symbol, span)
                return typed.PlacedLine(symbol, span)
            case ast.Stretch():
                hint = f"ask what lies in it: `p in stretch {item.name}`"
                self.fail(WrongKind(span, "a value", f"the stretch `{item.name}`", hint))
            case ast.Define() if not item.parameters:
                return calls.expand(self, symbol, item, [], False, span, ctx)
            case ast.Define() | ast.Table():
                self.fail(
                    WrongKind(span, "a value", f"the function `{item.name}`", f"call it: `{item.name}(...)`")
                )
            case ast.State():
                hint = f"ask for it: `{item.name} is {item.start.name}`"
                self.fail(WrongKind(span, "a value", f"the state `{item.name}`", hint))
            case ast.Enum():
                hint = f"ask a field of this type for its member: `... is {item.members[0].name}`"
                self.fail(WrongKind(span, "a value", f"the enumeration `{item.name}`", hint))
            case ast.Shape():
                hint = "a parameter of a definition has it: `predicate p(o: " + item.name + ") = ...`"
                self.fail(WrongKind(span, "a value", f"the shape `{item.name}`", hint))
            case ast.Reference() | ast.Rulebook():
                self.fail(WrongKind(span, "a value", f"the name of a {type(item).__name__.lower()}"))
            case _:
                raise AssertionError(f"unknown symbol {type(item).__name__}")

    def shape_of(self, signal: str) -> typed.Shape:
        """What can be read of a record of a signal, by its name."""
        return self._shape(self.signals[signal])

    def _shape(self, signal: SignalType) -> typed.Shape:
        """What can be read of a record of a signal."""
        shape = self._shapes.get(signal.name)
        if shape is None:
            shape = self._shapes[signal.name] = {
                f.name: None if f.kind == "bool" else f.enumeration or parse_unit(f.unit)[2]
                for f in signal.fields_
                if f.kind != "polyline"
            }
        return shape

    def _attribute(self, expr: ast.Attribute, ctx: Context) -> typed.Value:
        if states.names_machine(expr.value, ctx):
            return states.kept(expr, self, ctx)
        value = self.value(expr.value, ctx)
        span = expr.span
        if isinstance(value, typed.RecordNode):
            if expr.name in ("left", "right") and calls.is_lane(value):
                return typed.LaneSide(value, expr.name, span)
            if expr.name not in value.shape:
                known = [*(("left", "right") if calls.is_lane(value) else ()), *value.shape]
                hint = close_matches(expr.name, known)
                if not hint and value.signal is not None and value.signal.field(expr.name) is not None:
                    hint = "the definition asks for a shape without it"
                elif not hint and expr.name == "id":
                    hint = f"an id is no field: {_NUMBERED}"
                elif not hint:
                    hint = "only what a signal's declaration lists can be read"
                self.fail(UnknownField(span, record_spoken(value), expr.name, ", ".join(known), hint))
            dimension = value.shape[expr.name]
            if dimension is None:
                return typed.BooleanField(value, expr.name, span)
            if isinstance(dimension, Enumeration):
                return typed.MemberField(dimension, value, expr.name, span)
            record = record_behind(value)
            if isinstance(record, typed.ParameterRecord):
                return self._parameter(record.symbol, value, expr.name, dimension, span)
            field = None if value.signal is None else value.signal.field(expr.name)
            if field is not None and field.kind == UNKNOWN:
                raise Poison
            return typed.Field(
                dimension, "" if field is None else own_unit(field.unit), value, expr.name, span
            )
        if isinstance(value, typed.SignalNode):
            signal = value.signal
            courses.refuse_course(signal, span, "nothing is read of", self)
            if signal.sequence and expr.name == "first":
                return typed.Sample(self._shape(signal), signal, value, 0, span)
            if signal.sequence and expr.name == "last":
                return typed.Sample(self._shape(signal), signal, value, -1, span)
            field = signal.field(expr.name)
            if field is not None and field.kind == "polyline" and not signal.many:
                return typed.Border(value, expr.name, span)
            fitting = (
                ["first", "last"]
                if signal.sequence
                else [f.name for f in signal.fields_ if f.kind == "polyline"]
            )
            hint, shown = close_matches(expr.name, fitting), ", ".join(fitting)
            if signal.sequence or signal.many:
                parts = f"{'samples' if signal.sequence else 'elements'} with {', '.join(f.name for f in signal.fields_)}"
                shown = f"{shown}, and {parts}" if shown else parts
            if signal.field(expr.name) is not None:
                hint = f"bind a variable first: `for all x in {signal.name}`"
            self.fail(UnknownField(span, value_spoken(value), expr.name, shown or "nothing to read", hint))
        digits = ast.span_of(expr.value).text
        hint = f"a number with a point has digits after it: `{digits}.0`" if digits.isdigit() else ""
        self.fail(WrongKind(ast.span_of(expr.value), "a record", value_spoken(value), hint))

    def _parameter(
        self, record: typed.Symbol, read: typed.Record, name: str, dimension: Dimension, span: Span
    ) -> typed.Parameter:
        """`limits.response`: the parameter that a field of a record of parameters is."""
        assert isinstance(record.item, ast.ParamRecord)
        symbol = typed.Symbol(record.item, record.module, f"{record.qualified}.{name}")
        entry = next((entry for entry in record.item.entries if entry.name == name), None)
        if entry is None or symbol.qualified not in self.params:
            raise Poison  # its declaration was reported
        unit = written_unit((entry.value,), self.advice.units.get(symbol.qualified, "1"))
        return typed.Parameter(dimension, unit, symbol, read, span)

    # Arithmetic and logic -----------------------------------------------------------------------------------

    def _binary(self, expr: ast.Binary, ctx: Context) -> typed.Value:
        op, span = expr.op, expr.span
        if op in typed.CONNECTIVES:
            early = ends_early(expr)
            if op in ASKED:
                self.advise(early)
                self.advise(joins_conditions(expr))
            before = len(self.found)
            try:
                a, b = self.all(lambda: self.formula(expr.left, ctx), lambda: self.formula(expr.right, ctx))
            except Poison:
                self._ended(expr, before)
                raise
            if op not in ASKED and early is not None and changes(ctx.timeline, b):
                self.advise(early)
            return typed.Connective(known(op, typed.CONNECTIVES), a, b, span)
        if op == "^":
            return self._power(expr, ctx)
        if op in typed.COMPARISONS:
            return self._comparison(expr, ctx)
        try:
            left = self.number(expr.left, ctx)
        except Poison:
            self.number(expr.right, ctx)  # whose errors are reported as well
            raise
        right = self.number(expr.right, ctx)
        self.advise(between(op, left, right, span))
        if op in ("*", "/"):
            dimension = (
                times(left.dimension, right.dimension) if op == "*" else over(left.dimension, right.dimension)
            )
            written = product(op, left, right)
            return typed.Arithmetic(dimension, written, known(op, ARITHMETIC), left, right, span)
        self.same("add" if op == "+" else "subtract", left, right)
        written = common(left, right)
        return typed.Arithmetic(left.dimension, written, known(op, ARITHMETIC), left, right, span)

    def _comparison(self, expr: ast.Binary, ctx: Context) -> typed.Formula:
        """Two numbers, or a count and a number that no input changes."""
        op, span = known(expr.op, typed.COMPARISONS), expr.span
        left, right = self._compared(expr, ctx)
        if isinstance(left, typed.Count) and not isinstance(right, typed.Count):
            return typed.CountComparison(op, left, self._limit(right, left.span), False, span)
        if isinstance(right, typed.Count) and not isinstance(left, typed.Count):
            return typed.CountComparison(op, right, self._limit(left, right.span), True, span)
        if isinstance(left, typed.Count) or isinstance(right, typed.Count):
            self.fail(WrongKind(right.span, "a number", value_spoken(right)))
        self._compare(expr.op, left, right, span)
        return typed.Comparison(op, left, right, span)

    def _compared(self, expr: ast.Binary, ctx: Context) -> list[Any]:
        """Both sides: numbers, or counts. Two members, or two formulas, are one mistake."""
        members: list[typed.MemberNode] = []

        def left_side() -> typed.Value:
            value = self.value(expr.left, ctx)
            if isinstance(value, typed.MemberNode) and isinstance(expr.right, ast.Name):
                members.append(value)
                hint = enums.hint(value, expr.right.name, expr.op)
                self.fail(WrongKind(ast.span_of(expr.left), "a number", value_spoken(value), hint))
            return value

        def right_side() -> typed.Value:
            if members:
                raise Poison  # the word is one of its members, or meant to be
            return self.value(expr.right, ctx)

        def number(value: typed.Value, side: ast.Expr) -> typed.Number | typed.Count:
            return value if isinstance(value, typed.Count) else self._numeric(value, side)

        sides: list[typed.Value] = self.all(left_side, right_side)
        left, right = sides
        if isinstance(left, typed.FormulaNode) and isinstance(right, typed.FormulaNode):
            self.fail(WrongKind(ast.span_of(expr.left), "a number", "a formula", _of_formulas(expr)))
        if isinstance(left, typed.RecordNode) and isinstance(right, typed.RecordNode):
            self.fail(
                WrongKind(
                    ast.span_of(expr.left), "a number", value_spoken(left), _of_records(expr, left, right)
                )
            )
        return self.all(lambda: number(left, expr.left), lambda: number(right, expr.right))

    def _limit(self, number: typed.Number, count: Span) -> typed.Number:
        """What a count is compared with: a plain number made of literals and parameters."""
        if number.dimension != NUMBER:
            what = "what a count is compared with"
            hint = "it counts samples or cycles; how long something lasts is asked by `historically[0 s, 3 s] (...)`"
            hint = hint if number.dimension == TIME else ""
            self.fail(
                WrongDimension(number.span, None, what, "a plain number", quantity(number.dimension), hint)
            )
        inputs = (
            typed.Field,
            typed.Folded,
            typed.Choice,
            typed.NumberCase,
            typed.TableValue,
            typed.OnLine,
            typed.StationGap,
            typed.Kept,
        )
        if any(isinstance(node, inputs) for node in typed.below(number)):
            problem = "a count is compared with a number that no input changes"
            self.fail(BadValue(number.span, problem, None, "use literals and parameters"))
        self.advise(self.advice.counted(number, count))
        return number

    def _within(self, expr: ast.Within, ctx: Context) -> typed.Formula:
        lower, value, upper = self.all(
            lambda: self.number(expr.lower, ctx),
            lambda: self.number(expr.value, ctx),
            lambda: self.number(expr.upper, ctx),
        )
        self.all(
            lambda: self._compare("<=", lower, value, expr.span),
            lambda: self._compare("<=", value, upper, expr.span),
        )
        return typed.Within(value, lower, upper, expr.span)

    def _chained(self, expr: ast.Chained, ctx: Context) -> typed.Formula:
        numbers = self.each(lambda operand: self.number(operand, ctx), expr.operands)
        self.all(
            *(
                lambda op=op, left=left, right=right: self._compare(op, left, right, left.span.to(right.span))
                for op, left, right in zip(expr.ops, numbers, numbers[1:])
            )
        )
        ops = tuple([known(op, typed.COMPARISONS) for op in expr.ops])
        return typed.Chained(tuple(numbers), ops, expr.span)

    def _compare(self, op: str, left: typed.Number, right: typed.Number, span: Span) -> None:
        """Check a comparison of two numbers."""
        self.same("compare", left, right)
        self.advise(self.advice.compared(op, left, right, span))
        self.advise(turns_over(left, right, span))
        self.advise(laps_over(left, right, span))

    def same(self, action: str, left: typed.Number, right: typed.Number) -> None:
        """Fail unless two numbers have one dimension."""
        if left.dimension == right.dimension:
            for found in self.advice.joined(left, right):
                self.advise(found)
            return
        sides = (
            ("left side", "right side")
            if action in ("compare", "add", "subtract")
            else ("first one", "second one")
        )
        hint = calls.decimal_comma(left.span, right.span)
        hint = hint or calls.unit_hint(right, left.dimension, left.written)
        hint = hint or calls.unit_hint(left, right.dimension, right.written)
        hint = (
            hint or calls.unit_of_factor(left, right.dimension) or calls.unit_of_factor(right, left.dimension)
        )
        hint = hint or _factor(left.dimension, right.dimension, *sides)
        ours, theirs = quantity(left.dimension), quantity(right.dimension)
        # Where a unit is missing, it is missing there, and no declaration is to blame.
        bare = any(isinstance(side, typed.Literally) and not side.unit for side in (left, right))
        things = () if bare else (_declared(left, ours, theirs), _declared(right, theirs, ours))
        self.fail(
            DimensionMismatch(
                left.span,
                right.span,
                action,
                ours,
                theirs,
                hint,
                (),
                tuple(thing for thing in things if thing),
            )
        )

    def _power(self, expr: ast.Binary, ctx: Context) -> typed.Value:
        base, exponent = self.all(lambda: self.number(expr.left, ctx), lambda: self.number(expr.right, ctx))
        if exponent.dimension != NUMBER:
            self.fail(
                BadValue(exponent.span, f"an exponent is a plain number, not {quantity(exponent.dimension)}")
            )
        constant, whole = typed.literal(exponent), typed.whole_exponent(exponent)
        if whole is not None:
            return typed.Power(power(base.dimension, whole), "", base, exponent, expr.span)
        if base.dimension != NUMBER:
            hint = (
                "use sqrt(...) for a root"
                if constant == 0.5
                else "divide the base by a reference quantity first"
            )
            problem = f"the exponent of {quantity(base.dimension)} must be a literal whole number from 1 to 8, or from -8 to -1"
            if constant is not None:
                problem += f", not {in_full(constant, '1')}"
            self.fail(
                BadValue(exponent.span, problem, base.span, hint, f"this is {quantity(base.dimension)}")
            )
        return typed.Power(NUMBER, "", base, exponent, expr.span)

    def _if_else(self, expr: ast.IfElse, ctx: Context) -> typed.Value:
        condition, then, otherwise = self.all(
            lambda: self.formula(expr.condition, ctx),
            lambda: self.number(expr.then, ctx),
            lambda: self.number(expr.otherwise, ctx),
        )
        self.same("choose between", then, otherwise)
        return typed.Choice(then.dimension, common(then, otherwise), condition, then, otherwise, expr.span)

    def _in_zone(self, expr: ast.InZone, ctx: Context) -> typed.Value:
        at = Span(expr.span.file, ast.span_of(expr.value).end, expr.span.end).word(expr.zone)
        found = self.look_up(expr.zone, at, "zone", set(), ctx)
        if not isinstance(found.item, ast.Place) or found.item.kind != "zone":
            self.fail(WrongKind(at, "a zone", f"the {spoken(found.item)} `{expr.zone}`"))
        point = calls.shaped(self, self.value(expr.value, ctx), "point", ast.span_of(expr.value))
        return typed.InZone(point, typed.Zone(found, at), expr.span)

    # Time and quantifiers -----------------------------------------------------------------------------------

    def _temporal(self, expr: ast.Temporal, ctx: Context) -> typed.Formula:
        self.advise(goes_on(expr))
        self.advise(met_by_others(expr.op, expr.operand))
        (operand,), window = self._over_time((expr.operand,), expr.window, ctx)
        axis = ctx.timeline
        self.advise(same_everywhere(expr.op, axis, operand))
        if expr.op in typed.STEPS:
            return typed.Step(known(expr.op, typed.STEPS), expr.weak, axis, operand, expr.span)
        return typed.Temporal(known(expr.op, TEMPORAL), axis, window, operand, expr.span)

    def _over_time(
        self, operands: tuple[ast.Expr, ...], window: ast.Window | None, ctx: Context
    ) -> tuple[list[typed.Formula], typed.Window | None]:
        """Operands and window of a temporal operator; the errors of all of them are reported."""
        bounds, *formulas = self.all(
            lambda: self._window(window, ctx),
            *(lambda o=operand: self.formula(o, ctx) for operand in operands),
        )
        return formulas, bounds

    def _until(self, expr: ast.Until, ctx: Context) -> typed.Formula:
        self.advise(met_by_others(expr.op, expr.right))
        (left, right), window = self._over_time((expr.left, expr.right), expr.window, ctx)
        self.advise(same_everywhere(expr.op, ctx.timeline, left, right))
        return typed.Until(known(expr.op, UNTIL), ctx.timeline, window, left, right, expr.span)

    def last(self, bound: ast.Expr, ctx: Context) -> typed.Window:
        """The window of a count: so long until now."""
        number, seconds = self.bound(bound, ctx)
        if seconds < 0.0:
            self.fail(
                BadValue(
                    ast.span_of(bound), f"a window starts at zero or later, not at {in_full(seconds, 's')}"
                )
            )
        zero = typed.Literally(TIME, "s", "0", "s", 0.0, ast.span_of(bound))
        return typed.Window(zero, number, (0.0, seconds), ast.span_of(bound))

    def deadline(self, limit: ast.Expr, span: Span, ctx: Context) -> typed.Deadline:
        """How long after a cycle something has to happen: a literal time."""
        number, seconds = self.bound(limit, ctx)
        if seconds < 0.0:
            problem = f"a deadline is not before the cycle that it counts from, at {in_full(seconds, 's')}"
            self.fail(BadValue(ast.span_of(limit), problem))
        return typed.Deadline(number, seconds, span)

    def _window(self, window: ast.Window | None, ctx: Context) -> typed.Window | None:
        if window is None:
            return None
        (lower, low), (upper, high) = self.all(
            lambda: self.bound(window.lower, ctx), lambda: self.bound(window.upper, ctx)
        )
        if low < 0:
            past = "`once`, `historically` and `since` look back"
            hint = f"windows count away from the current sample; {past}"
            problem = f"a window starts at zero or later, not at {in_full(low, 's')}"
            self.fail(BadValue(ast.span_of(window.lower), problem, None, hint))
        if high < low:
            problem = f"a window runs from low to high, not from {in_full(low, 's')} to {in_full(high, 's')}"
            self.fail(BadValue(window.span, problem, None, "swap the bounds"))
        return typed.Window(lower, upper, (low, high), window.span)

    def bound(self, bound: ast.Expr, ctx: Context) -> tuple[typed.Number, float]:
        """A bound of a window: a literal time, and its value in s."""
        value = self.number(bound, ctx)
        if value.dimension != TIME:
            problem = f"the window of a temporal operator is a time, not {quantity(value.dimension)}"
            self.fail(BadValue(value.span, problem, None, calls.unit_hint(value, TIME)))
        seconds = typed.literal(value)
        if seconds is None:
            self.fail(
                BadValue(
                    value.span,
                    "the window of a temporal operator is constant",
                    None,
                    "write a number with a unit of time: how much is remembered is known before the run, and a parameter may be overridden",
                )
            )
        if abs(seconds) > NEVER:
            problem = f"no time is as long as {in_full(seconds, 's')}"
            self.fail(BadValue(value.span, problem, None, "leave the bound out where it is none"))
        return value, seconds

    def axis(
        self, domain: ast.Expr, names: tuple[str, ...], consecutive: bool, span: Span, ctx: Context, clause: bool = False
    ) -> tuple[typed.Range, dict[str, Local]]:  # fmt: skip
        """What a quantifier ranges over, and its variables; clause: that of a rule, where no other one of its depth has its names."""
        value = self.value(domain, ctx)
        if not isinstance(value, typed.SignalNode) or not (value.signal.sequence or value.signal.many):
            self.fail(WrongKind(ast.span_of(domain), "a timeline or a set", value_spoken(value)))
        signal = value.signal
        courses.refuse_course(signal, ast.span_of(domain), "no quantifier ranges over", self)
        if len(names) > 1 and not consecutive:
            hint = "write a quantifier for each"
            if signal.sequence:
                hint = f"write `consecutive {', '.join(names)}`, or a quantifier for each"
            self.fail(
                UnknownReference(span, "several variables range together over consecutive samples only", hint)
            )
        if consecutive and not signal.sequence:
            self.fail(
                UnknownReference(
                    span, f"the elements of `{signal.name}` have no order", "remove `consecutive`"
                )
            )
        if consecutive and len(names) < 2:
            self.fail(
                UnknownReference(
                    span, "`consecutive` binds two or more samples", "add a variable, or remove `consecutive`"
                )
            )
        return self._range(value, names, span, ctx, clause)

    def timeline(
        self, value: typed.WholeSignal, name: str, span: Span, ctx: Context
    ) -> tuple[typed.Range, dict[str, Local]]:
        """The timeline of a rule, and its variable."""
        return self._range(value, (name,), span, ctx, True)

    def _range(
        self, value: typed.WholeSignal, names: tuple[str, ...], span: Span, ctx: Context, clause: bool
    ) -> tuple[typed.Range, dict[str, Local]]:
        signal = value.signal
        range_, shape = typed.Range(value, names, ctx.level, span), self._shape(signal)
        if clause:
            range_ = self.shared.range(range_)
        variables: dict[str, Local] = {}
        for offset, name in enumerate(names):
            if name in variables:
                self.fail(UnknownReference(span, f"`{name}` is bound twice", "give each its own name"))
            self.check_new(name, span, ctx)
            variables[name] = typed.Variable(shape, signal, name, range_, offset, span)
        return range_, variables

    def check_new(self, name: str, span: Span, ctx: Context) -> None:
        """Report a variable that would hide another one: it is not said which of the two is meant."""
        known = ctx.local.get(name)
        if known is not None and not isinstance(known, Broken):
            self.found.append(Duplicate(span.word(name), span_of(known).head, "variable", name))
        else:
            ctx.scope.check_bound(name, span.word(name), "variable")

    def _quantified(self, expr: ast.Quantified, ctx: Context) -> typed.Formula:
        range_, variables = self.range_of(expr, ctx)
        inner = ctx.bind(variables, 1)
        self.check_used(expr.names, (expr.where, expr.by, expr.body), expr.span.head)
        self.advise(met_by_others("where", expr.where))
        if expr.by is None:  # of the nearest there is one
            self.advise(met_by_others(expr.quantifier, expr.body, expr.names))
        by, guard, body = self.all(
            lambda: self.number(expr.by, inner) if expr.by is not None else None,
            lambda: self.formula(expr.where, inner) if expr.where is not None else None,
            lambda: self.formula(expr.body, inner),
        )
        if range_ is None:
            raise Poison
        return typed.Quantified(known(expr.quantifier, QUANTIFIERS), range_, guard, by, body, expr.span)

    def _folded(self, expr: ast.Folded, ctx: Context) -> typed.Number:
        """`sum(E for o in objects where c)`, `count(o in objects where c)`."""
        op = self._folding(expr)
        range_, variables = self.range_of(expr, ctx)
        inner = ctx.bind(variables, 1)
        if expr.body is not None or expr.where is not None:
            self.check_used(expr.names, (expr.where, expr.body), expr.span.head)
        self.advise(met_by_others("where", expr.where))
        guard, body, otherwise = self.all(
            lambda: self.formula(expr.where, inner) if expr.where is not None else None,
            lambda: self.number(expr.body, inner) if expr.body is not None else None,
            lambda: self.number(expr.otherwise, ctx) if expr.otherwise is not None else None,
        )
        if range_ is None:
            raise Poison
        if op in ("min", "max") and otherwise is None and (guard is not None or not _never_empty(range_)):
            hint = (
                f"say what it is then: `{op}(... for {expr.names[0]} in {range_.signal.name} ... else ...)`"
            )
            self.fail(BadValue(expr.span, f"there may be nothing to take the {op} of", None, hint))
        if body is None:
            return typed.Folded(NUMBER, "", op, range_, guard, None, None, expr.span)
        if otherwise is not None:
            self.same("choose between", body, otherwise)
        unit = body.written if otherwise is None else common(body, otherwise)
        return typed.Folded(body.dimension, unit, op, range_, guard, body, otherwise, expr.span)

    def _folding(self, expr: ast.Folded) -> typed.Folding:
        """What becomes one number of many; fails for what has another form."""
        at = expr.span.head.word(expr.function)
        if expr.function not in typed.FOLDINGS:
            asked = {"any": "exists", "some": "exists", "all": "for all", "every": "for all"}.get(
                expr.function
            )
            hint = close_matches(expr.function, typed.FOLDINGS) or f"write {', '.join(typed.FOLDINGS)}"
            hint = f"write `{asked} o in objects: (...)`" if asked else hint
            self.fail(UnknownReference(at, f"`{expr.function}` makes no number of many", hint))
        op = known(expr.function, typed.FOLDINGS)
        if (op == "count") != (expr.body is None):
            hint = f"write `{_FORMS[op]}`"
            self.fail(UnknownReference(at, f"`{op}` is written another way over many", hint))
        if op in ("count", "sum") and expr.otherwise is not None:
            problem = f"the {op} of nothing is 0, so it has no `else`"
            self.fail(UnknownReference(ast.span_of(expr.otherwise), problem, "remove the `else`"))
        return op

    def range_of(
        self, bind: ast.Bind | ast.Quantified | ast.Folded, ctx: Context
    ) -> tuple[typed.Range | None, dict[str, Local]]:
        """The range and the variables of a quantifier; where its range has an error, none and broken variables."""
        try:
            clause = isinstance(bind, ast.Bind)
            return self.axis(bind.domain, bind.names, bind.consecutive, bind.span.head, ctx, clause)
        except Poison:
            return None, dict.fromkeys(bind.names, Broken())

    def check_used(self, names: tuple[str, ...], parts: tuple[Node | None, ...], span: Span) -> None:
        """Warn of a quantifier none of whose variables is mentioned below."""
        if all(ast.names_in(part).isdisjoint(names) for part in parts if part is not None):
            self.found.append(UnusedVariable(span, "`, `".join(names)))


#: No time that anybody means is longer [s]; a thousand times as long, and no evaluator could count in it.
NEVER = 1e15
#: How numbers of many are written.
_FORMS: dict[typed.Folding, str] = {
    "count": "count(o in objects where ...)", "sum": "sum(... for o in objects)",
    "min": "min(... for o in objects else ...)", "max": "max(... for o in objects else ...)",
}  # fmt: skip


def _never_empty(range_: typed.Range) -> bool:
    """Whether there always is something in a range: a trajectory has two samples at least, a series one."""
    signal = range_.signal
    return signal.sequence and len(range_.names) <= (2 if signal.kind == "trajectory" else 1)


def _of_formulas(expr: ast.Binary) -> str:
    """What to write for two formulas between which `==` stands, or another comparison."""
    left, right = (" ".join(ast.span_of(side).text.split()) for side in (expr.left, expr.right))
    if expr.op not in ("==", "!="):
        return "compare numbers, or join formulas with `and`, `or`, `implies`, `iff`, `xor`"
    if isinstance(expr.right, ast.Boolean):
        return f"write `{left}`" if expr.right.value == (expr.op == "==") else f"write `not ({left})`"
    return f"write `({left}) {'iff' if expr.op == '==' else 'xor'} ({right})`"


#: How elements of one set are told apart.
_NUMBERED = "let the data number them, in a field of the unit 1"


def _of_records(expr: ast.Binary, left: typed.Record, right: typed.Record) -> str:
    """What to write for two elements, or an element and a state, between which `!=` stands.

    Not their places: two that are in one place are what rules about two of them look for.
    """
    ours, theirs = (ast.span_of(side).text for side in (expr.left, expr.right))
    if left.signal is not None and left.signal.many and left.signal == right.signal:
        return f"{_NUMBERED}: `{ours}.number {'==' if expr.op == '==' else '<'} {theirs}.number`"
    return "compare a field that tells which it is: declare one, such as `own: bool`"


def _declared(number: typed.Number, own: str, other: str) -> tuple[str, Span, str, str] | None:
    """What a number is where it is declared: a parameter, or a field of a signal."""
    if isinstance(number, typed.Parameter):
        return number.symbol.item.__dict__["name"], number.symbol.item.__dict__["span"], own, other
    if isinstance(number, typed.Field) and number.record.signal is not None:
        field = number.record.signal.field(number.name)
        return (
            None if field is None else (f"{number.record.signal.name}.{number.name}", field.span, own, other)
        )
    return None


def _factor(left: Dimension, right: Dimension, a: str, b: str) -> str:
    """What would make two dimensions one; `a` and `b` are what messages call the two."""
    if power(right, Fraction(2)) == left:
        return f"square the {b}, or take the square root of the {a}"
    if power(left, Fraction(2)) == right:
        return f"square the {a}, or take the square root of the {b}"
    factor = over(right, left)
    unit, inverse = show(factor), show(over(NUMBER, factor))
    if unit.startswith("1/"):
        return f"divide the {a} by a quantity in {inverse}, or multiply the {b} by it"
    return f"multiply the {a} by a quantity in {unit}, or divide the {b} by it"
