"""A function while it is written: its scopes and names, and what it reads."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.facts import Same, Value
from trackmarshal.backends.c.functions.slots import assign
from trackmarshal.backends.c.functions.usage import Usage
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import RESERVED, identifier, where
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.margins import deciding
from trackmarshal.ir.spec import Called, RuleInfo
from trackmarshal.source import Span

ZERO = c.Literal("0u")
#: What is longer than this is named for readers, though it is read once.
LONG = 150
#: Names that locals do not have: parameters of functions, and what C and its headers know.
_TAKEN = RESERVED | {"context", "in", "out", "monitor", "known"}


class Writer(ABC):
    """Writes one function. `known`: everything is taken for known, and whatever is not makes a formula's value unknown.

    The other kind of function carries a worst and a best case through every formula (strong Kleene logic). A number is C of type
    double; a formula is a `tm_truth` or, of the other kind, a `tm_cases`.
    """

    def __init__(
        self,
        plan: Layout,
        rules: Sequence[RuleInfo],
        known: bool,
        formulas: Sequence[ir.Formula],
        guards: Sequence[ir.Formula] = (),
        several: bool = False,
    ) -> None:
        """several: quantifiers of simple arithmetic are worked out for several samples at once."""
        self.plan = plan
        self.several = several
        self.rule = rules[0]
        self.known = known
        self.grouped = len(rules) > 1
        self.root = c.Scope()
        self.root.names |= _TAKEN
        self.facts = plan.facts
        same = Same(plan.facts)
        #: What is written: formulas with their margins, and others of which it is asked whether they hold.
        self.formulas = [same.formula(each) for each in formulas]
        self.guards = [same.formula(each) for each in guards]
        roots = [*self.formulas, *self.guards]
        called: dict[ir.IR, Called] = {}
        for rule in rules:
            for name in rule.names:
                if isinstance(name.node, Value):
                    called.setdefault(same.of(name.node), name)
        self.usage = Usage(plan.facts, roots, called)
        #: Formulas whose margin is read.
        self.margins = deciding(self.formulas)
        self._binders = {root.axis: (root.name,) for root in roots if isinstance(root, ir.At)}
        self._span: Span | None = self.rule.span
        self._length: dict[c.Expr, int] = {}
        #: How many series of the context the function needs, before they share places.
        self.slots = 0
        self.series: dict[tuple[c.Scope, ir.Timed | ir.Tallied], list[c.Expr]] = {}
        #: The series with the times of each timeline, in whole nanoseconds.
        self.times: dict[str, c.Expr] = {}
        #: Geometric predicates of which only margins below this one matter.
        self.bounds: dict[ir.IR, c.Expr] = {}
        #: Parameters of the function that it reads.
        self.reads: set[str] = set()
        self._columns: dict[tuple[str, str], c.Expr] = {}

    @abstractmethod
    def number(
        self, node: ir.Num, scope: c.Scope, role: str = "", most: int = LONG, times: int = 1
    ) -> c.Expr:
        """C of a number that is read in a scope, as often as `times`. `role`: what it is there, for its name if it needs one; it gets one if it
        is longer than `most`."""

    @abstractmethod
    def formula(self, node: ir.Formula, scope: c.Scope, role: str = "holds", named: bool = False) -> c.Expr:
        """C of a formula that is read in a scope. named: it gets a name, as it is read twice."""

    def refuse(self, node: ir.IR, why: str) -> TrackmarshalError:
        span = getattr(node, "span", None) or self.rule.span
        return TrackmarshalError(
            "E470", f"rule `{self.rule.name}`: {why}", file=span.file.path, line=span.line,
            help="choose rules with --rule, or another backend",
        )  # fmt: skip

    def of(self, rule: RuleInfo | None) -> None:
        """Go on with another rule, if there are several."""
        if rule is not None:
            self.rule, self._span = rule, rule.span

    def place(self) -> str:
        """Where the spec says what is being written; nothing for the rule's own first line."""
        span = self._span
        if span is None or span is self.rule.span:
            return ""
        here = span.file is self.rule.span.file and not self.grouped
        return f"line {span.line}" if here else where(span)

    def add(self, scope: c.Scope, statement: c.Statement) -> None:
        scope.add(statement, self.place())

    def home(self, axes: frozenset[ir.Axis], scope: c.Scope) -> c.Scope:
        """The outermost scope, seen from one inside, in which these axes' variables have their present values."""
        for candidate in scope.chain():
            if candidate.parent is None or any(axis in candidate.binds for axis in axes):
                return candidate
        raise AssertionError("scopes end at the root")

    def home_of(self, node: Value, scope: c.Scope) -> c.Scope:
        """Where a node is computed that is read in a scope: where its variables have their values, yet no sooner than it is known to be needed."""
        home = self.home(self.facts.free(node), scope)
        needed = home
        for candidate in scope.chain():
            if candidate is home:
                break
            if candidate.binds:
                needed = home  # not again and again
            elif needed is home and node in candidate.own:
                needed = candidate
        return needed

    def index(self, axis: ir.Axis, scope: c.Scope) -> c.Expr:
        for candidate in scope.chain():
            if axis in candidate.binds:
                return candidate.binds[axis]
        raise AssertionError(f"no variable of axis {axis.signal} in scope")

    def name(self, name: str) -> c.Expr:
        """A parameter of the function."""
        self.reads.add(name)
        return c.Name(name)

    def call(self, function: str, *arguments: c.Expr) -> c.Expr:
        return c.Call(function, arguments)

    def over(self, function: str, *arguments: c.Expr) -> c.Expr:
        """A function of formulas, of the kind that is written."""
        return c.Call(f"tm_{function}" if self.known else f"tm_{function}_any", arguments)

    @property
    def type(self) -> str:
        """The C type of a formula."""
        return "tm_truth" if self.known else "tm_cases"

    def input(self, signal: str) -> c.Expr:
        course = self.plan.courses.get(signal)
        if course is not None:
            courses = c.Member(self.name("context"), "course", True)
            return c.Member(courses, course.c_name, False)
        return c.Member(self.name("in"), self.plan.input(signal).c_name, True)

    def count(self, axis: ir.Axis) -> c.Expr:
        """C of how many values an axis has."""
        total = c.Member(self.input(axis.signal), "count", False)
        return total if axis.width == 1 else self.call("tm_windows", total, c.Literal(f"{axis.width}u"))

    def loop(self, axis: ir.Axis, at: c.Scope, names: tuple[str, ...]) -> c.Scope:
        """A scope that goes through all of an axis."""
        count = self.count(axis)
        if axis.width != 1:
            count = self.declare(at, "size_t", count, "windows")
        index = identifier(names[0])

        def head(body: tuple[c.Statement, ...]) -> c.Statement:
            return c.For(
                index, c.Binary("<", c.Name(index), count), c.Unary("++", c.Name(index)), body, axis.signal
            )

        loop = at.open(head)
        index = loop.take(index)
        loop.binds[axis] = c.Name(index)
        loop.binders[axis] = names
        return loop

    def length(self, expr: c.Expr) -> int:
        """About how many characters an expression has."""
        known = self._length.get(expr)
        if known is None:
            own = 3
            if isinstance(expr, c.Name | c.Member):
                own = len(expr.name)
            elif isinstance(expr, c.Call):
                own = len(expr.function)
            known = self._length[expr] = own + sum([self.length(each) for each in c.operands(expr)])
        return known

    def declare(self, scope: c.Scope, kind: str, value: c.Expr, *wanted: str) -> c.Expr:
        """A constant with the first of the wanted names that is free."""
        name = scope.take(*wanted)
        self.add(scope, c.Declare(kind, name, value))
        return c.Name(name)

    def names_of(self, axis: ir.Axis, scope: c.Scope) -> tuple[str, ...]:
        """What the spec calls the variables of an axis."""
        for candidate in scope.chain():
            if axis in candidate.binders:
                return candidate.binders[axis]
        return self._binders.get(axis, (axis.signal,))

    def field(self, signal: str, name: str) -> c.Expr:
        """A field of a record, or a column."""
        known = self._columns.get((signal, name))
        if known is None:
            known = c.Member(self.input(signal), self.plan.field_name(signal, name), False)
            self._columns[signal, name] = known
        return known

    def column(self, node: ir.Column | ir.Flag, at: c.Scope) -> c.Expr:
        """C of a field of the variable of an axis."""
        assert node.axis is not None
        index = self.index(node.axis, at)
        if node.offset > 0:
            index = c.Binary("+", index, c.Literal(f"{node.offset}u"))
        if node.offset < 0:
            index = self.call("tm_before", index, c.Literal(f"{-node.offset}u"))
        return c.Element(self.field(node.axis.signal, node.field or ""), index)

    def finished(
        self, parameters: tuple[str, ...] = ("context", "in")
    ) -> tuple[tuple[c.Statement, ...], int]:
        """The function's body with all that it needs around what was written, and how many series it has."""
        body = self.root.statements([""])
        series = 0
        if self.slots:
            body, series = assign(body)
            if self.known:
                *before, last = body
                unknown = c.If(c.Unary("!", c.Name("known")), (c.Return(c.Literal("false")),))
                body = (c.Declare("bool", "known", c.Literal("true"), False), *before, unknown, last)
        read = set(_names(body))
        unused = [c.Evaluate(c.Name(name), True) for name in parameters if name not in read]
        return (*unused, *body), series


def _names(body: Iterable[c.Statement]) -> Iterator[str]:
    """The names that statements, and those within, read."""
    for item in body:
        for expr in c.expressions(item):
            yield from (each.name for each in c.within(expr) if isinstance(each, c.Name))
        if isinstance(item, c.For | c.If):
            yield from _names(item.body)
