"""Nodes of the IR to C: each in place where it is read once, else under a name, in the outermost scope in which all its variables are bound."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import assert_never

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.layout import Layout, roots
from trackmarshal.backends.c.names import RESERVED, comment, identifier, literal
from trackmarshal.backends.c.sweeps import along_timeline
from trackmarshal.backends.c.usage import Same, Usage, Value
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.margins import deciding
from trackmarshal.ir.operators import (
    COMPARISONS,
    ComparisonOp,
    ConnectiveOp,
    Extreme,
    FoldOp,
    FunctionName,
    Measure,
)
from trackmarshal.ir.spec import Called, RuleInfo
from trackmarshal.ir.tables import LINEAR_CLAMP
from trackmarshal.source import Span

#: What is longer than this is named for readers, though it is read once; a side of a comparison, than that.
_LONG = 150
_LONG_SIDE = 40
_ZERO = c.Literal("0u")
#: Numbers of what is swept straight: two poses, length and width. Curvatures come after them.
_STRAIGHT = 8
#: What a number of many is called while it is worked out.
_FOLDED: dict[FoldOp, str] = {"sum": "total", "least": "least", "greatest": "greatest", "nearest": "nearest"}


def called(name: FunctionName) -> tuple[str, frozenset[str]]:
    """The C function of a function of numbers, and which functions of libm that is, or calls."""
    match name:
        case "abs":
            return "fabs", frozenset()
        case "sign":
            return "tm_sign", frozenset()
        case "min":
            return "tm_min", frozenset()
        case "max":
            return "tm_max", frozenset()
        case "hypot":
            return "tm_hypot", frozenset(["sqrt"])
        case "pow":
            return "tm_pow", frozenset(["pow"])
        case "round":
            return "rint", frozenset(["rint"])
        case "sqrt" | "floor" | "ceil" | "exp" | "log" | "tanh":
            return name, frozenset([name])
        case "sin" | "cos" | "tan" | "asin" | "acos" | "atan2":
            return name, frozenset([name])
        case _:
            assert_never(name)


def compared(op: ComparisonOp, turned: bool) -> str:
    """The C function of a comparison as it is written; `turned`: the other way round."""
    match op:
        case "<":
            return "greater" if turned else "less"
        case "<=":
            return "at_least" if turned else "at_most"
        case "==":
            return "equal"
        case "!=":
            return "unequal"
        case "is":
            return "is"
        case _:
            assert_never(op)


class Writer:
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
        self._takes_several = several
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
        for name in (name for rule in rules for name in rule.names):
            if isinstance(name.node, Value):
                called.setdefault(same.of(name.node), name)
        self.usage = Usage(plan.facts, roots, called)
        #: Formulas whose margin is read.
        self.margins = deciding(self.formulas)
        self._binders = {
            node.axis: (node.name,) for root in roots for node in (root,) if isinstance(node, ir.At)
        }
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

    # Bookkeeping ------------------------------------------------------------------------------------------------

    def refuse(self, node: ir.IR, why: str) -> TrackmarshalError:
        span = getattr(node, "span", None) or self.rule.span
        return TrackmarshalError(
            "E470", f"rule `{self.rule.name}`: {why}", file=span.file.path, line=span.line,
            help="choose rules with --rule, or another backend",
        )  # fmt: skip

    def place(self) -> str:
        """Where the spec says what is being written; nothing for the rule's own first line."""
        span = self._span
        if span is None or span is self.rule.span:
            return ""
        here = span.file is self.rule.span.file and not self.grouped
        return f"line {span.line}" if here else comment(f"{span.file.path}:{span.line}")

    def add(self, scope: c.Scope, statement: c.Statement) -> None:
        scope.add(statement, self.place())

    def home(self, axes: frozenset[ir.Axis], scope: c.Scope) -> c.Scope:
        """The outermost scope, seen from one inside, in which these axes' variables have their present values."""
        for candidate in scope.chain():
            if candidate.parent is None or any(axis in candidate.binds for axis in axes):
                return candidate
        raise AssertionError("scopes end at the root")

    def _home(self, node: Value, scope: c.Scope) -> c.Scope:
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
            windows = at.take("windows")
            self.add(at, c.Declare("size_t", windows, count))
            count = c.Name(windows)
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

    # Numbers ----------------------------------------------------------------------------------------------------

    def number(
        self, node: ir.Num, scope: c.Scope, role: str = "", most: int = _LONG, times: int = 1
    ) -> c.Expr:
        """C of a number that is read in a scope, as often as `times`. `role`: what it is there, for its name if it needs one."""
        home = self._home(node, scope)
        known = home.known.get(node)
        if known is not None:
            return known
        made = self._number(node, home)
        if isinstance(node, ir.Const):
            self._length[made] = len(literal(node.value))
        elif self._apart(node, made, home is not scope, most, times):
            made = self.declare(home, "double", made, *self._called(node, made, role, home))
        home.known[node] = made
        return made

    def _apart(self, node: Value, made: c.Expr, elsewhere: bool, most: int, times: int = 1) -> bool:
        """Whether a value gets a name of its own."""
        if isinstance(made, c.Name | c.Literal):
            return False
        if elsewhere or isinstance(node, ir.Param) or self.usage.readers.get(node, 2) > times:
            return True
        return node in self.usage.own or self.length(made) > most

    def declare(self, scope: c.Scope, kind: str, value: c.Expr, *wanted: str) -> c.Expr:
        """A constant with the first of the wanted names that is free."""
        name = scope.take(*wanted)
        self.add(scope, c.Declare(kind, name, value))
        return c.Name(name)

    def _called(self, node: Value, made: c.Expr, role: str, home: c.Scope) -> tuple[str, ...]:
        """What a value may be called: as in the spec, after what it is made of, or after what it is for."""
        spoken = self.usage.names.get(node)
        if spoken is not None:
            plain = identifier(spoken)
            whose = f"{plain}_{self._whose(node, home)}"
            return (whose,) if node in self.usage.ambiguous else (plain, whose)
        own = self._own_name(node, made, home)
        if own:
            return own
        return (
            (f"{self.plan.rule_names[self.rule.name]}_{role}" if self.grouped else role,)
            if role
            else ("value",)
        )

    def _own_name(self, node: Value, made: c.Expr, home: c.Scope) -> tuple[str, ...]:
        match node:
            case ir.Param():
                return identifier(node.name.rpartition(".")[2]), self.plan.params[node.name]
            case ir.Column() | ir.Flag() if node.axis is not None:
                return (self._of_axis(node.axis, node.field or "", node.offset, home),)
            case ir.Scalar():
                return (identifier(f"{node.signal}_{node.field}"),)
            case ir.Flag():
                return (identifier(f"{node.signal}_{node.field}" if node.field else node.signal),)
            case ir.Sample():
                return (identifier(f"{node.signal}_{'first' if node.index == 0 else 'last'}_{node.field}"),)
            case ir.Station() | ir.Offset() | ir.Direction() | ir.Distance():
                return (identifier(f"{node.spoken}_{self._whose(node, home)}"),)
            case ir.Arith() if node.op == "*" and node.left is node.right:
                named = self.usage.names.get(node.left)
                own = (named,) if named else self._own_name(node.left, made, home)
                return (identifier(f"{own[0]}_squared"),) if own else ()
            case ir.Arith() if isinstance(made, c.Binary):
                return _of_arithmetic(made)
            case ir.Neg() if isinstance(made, c.Unary):
                return (f"minus_{made.operand.name}",) if isinstance(made.operand, c.Name) else ()
            case ir.Func() if isinstance(made, c.Call) and len(node.args) == 1:
                of = made.arguments[0]
                return (f"{node.name}_{of.name}",) if isinstance(of, c.Name) else ()
            case _:
                return ()

    def _of_axis(self, axis: ir.Axis, field: str, offset: int, home: c.Scope) -> str:
        names = self.names_of(axis, home)
        if offset < 0:
            return identifier(f"{names[0]}_{field}_before")
        who = names[offset] if offset < len(names) else f"{names[0]}{offset}"
        return identifier(f"{who}_{field}")

    def names_of(self, axis: ir.Axis, scope: c.Scope) -> tuple[str, ...]:
        """What the spec calls the variables of an axis."""
        for candidate in scope.chain():
            if axis in candidate.binders:
                return candidate.binders[axis]
        return self._binders.get(axis, (axis.signal,))

    def _whose(self, node: Value, home: c.Scope) -> str:
        """The variables that a value is about, or the signals; for names that would be alike."""
        axes = sorted(self.facts.free(node), key=lambda axis: axis.level)
        if axes:
            return "_".join(identifier(self.names_of(axis, home)[0]) for axis in axes)
        read: dict[str, None] = {}
        for each in ir.below(node):
            if isinstance(each, ir.Scalar | ir.Sample | ir.Flag):
                read.setdefault(identifier(each.signal))
        return "_".join(read) or "it"

    def _number(self, node: ir.Num, at: c.Scope) -> c.Expr:
        match node:
            case ir.Const():
                return c.Literal(literal(node.value))
            case ir.Param():
                return c.Member(
                    c.Member(self.name("context"), "params", True), self.plan.params[node.name], False
                )
            case ir.Column():
                return self.column(node, at)
            case ir.Sample():
                if node.index not in (0, -1):
                    raise self.refuse(
                        node,
                        f"sample {node.index} of `{node.signal}`; the C generator knows the first and the last",
                    )
                at_index = _ZERO if node.index == 0 else self._last(node.signal)
                return c.Element(self.field(node.signal, node.field), at_index)
            case ir.Scalar():
                return self.field(node.signal, node.field)
            case ir.Arith() if (
                node.op == "*" and node.left is node.right and self.usage.readers.get(node.left) == 2
            ):
                return self.call("tm_square", self.number(node.left, at, times=2))
            case ir.Arith():
                return c.Binary(node.op, self.number(node.left, at), self.number(node.right, at))
            case ir.Neg():
                return c.Unary("-", self.number(node.operand, at))
            case ir.Func():
                function, _ = called(node.name)
                return c.Call(function, tuple([self.number(arg, at) for arg in node.args]))
            case ir.Choose():
                condition = self.formula(node.condition, at, "condition")
                return self.over(
                    "select", condition, self.number(node.then, at), self.number(node.otherwise, at)
                )
            case ir.Lookup():
                tables = c.Member(self.name("context"), "tables", True)
                table = c.Address(c.Member(tables, self.plan.tables[node.table], False))
                way = self.plan.spec.tables[node.table].way
                if way == LINEAR_CLAMP:
                    return self.call("tm_lookup", table, self.number(node.argument, at))
                steps, clamped = (c.Name("true" if each else "false") for each in way[:2])
                length, argument = c.Literal(literal(way.length)), self.number(node.argument, at)
                return self.call("tm_read_table", table, steps, clamped, length, argument)
            case ir.GridLookup():
                grid = c.Address(c.Name(f"tm_grid_{self.plan.grids[node.table]}_whole"))
                return self.call(
                    "tm_read_grid", grid, self.number(node.first, at), self.number(node.second, at)
                )
            case ir.Station() | ir.Offset() | ir.Direction():
                return c.Member(self._projected(node, at), node.spoken, False)
            case ir.Distance():
                return self._on_line("distance", node.line, self.number(node.x, at), self.number(node.y, at))
            case ir.StationGap():
                return self._on_line("gap", node.line, self.number(node.start, at), self.number(node.end, at))
            case ir.OnLane():
                return self._on_lane(node, at)
            case ir.StretchRoom():
                parts = (self.number(part, at) for part in (node.station, node.start, node.end))
                return self._on_line("stretch_room", node.line, *parts)
            case ir.Kept():
                function = f"tm_{self.plan.memory(node.machine).c_name}_kept"
                place = 1 + node.machine.names.index(node.name) if node.name else 0
                states = c.Address(self.states(node.machine, at))
                return self.call(function, self.name("context"), states, c.Literal(f"{place}u"))
            case ir.Ordinal():
                return self.call("tm_ordinal", self.index(node.axis, at))
            case ir.Fold():
                return self._fold(node, at)
            case _:
                assert_never(node)

    def _fold(self, node: ir.Fold, at: c.Scope) -> c.Expr:
        """One number of many, in a loop of its own."""
        name = at.take(_FOLDED[node.op], f"{_FOLDED[node.op]}_{identifier(node.names[0])}")
        self.add(at, c.Declare("tm_fold", name, self.call("tm_fold_none"), False))
        fold = c.Name(name)
        loop = self.loop(node.axis, at, node.names)
        here: c.Expr = c.Literal("1.0")
        if node.guard is not None:
            guard = self.formula(node.guard, loop, "guard")
            here = self.over("select", guard, c.Literal("1.0"), c.Literal("0.0"))
        given = [c.Address(fold), here, self.number(node.body, loop, _FOLDED[node.op])]
        if node.op == "nearest":
            given.append(self.index(node.axis, loop))
        self.add(loop, c.Evaluate(self.call(f"tm_fold_{node.op}", *given)))
        at.close(loop)
        match node.op:
            case "sum":
                return c.Member(fold, "value", False)
            case "least" | "greatest":
                otherwise = c.Name("TM_NAN") if node.otherwise is None else self.number(node.otherwise, at)
                return c.Conditional(c.Member(fold, "some", False), c.Member(fold, "value", False), otherwise)
            case "nearest":
                return c.Member(fold, "place", False)
            case _:
                assert_never(node.op)

    def _last(self, signal: str) -> c.Expr:
        """The index of a timeline's last sample."""
        return c.Binary("-", c.Member(self.input(signal), "count", False), c.Literal("1u"))

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

    def _on_line(self, what: str, line: ir.Line, *arguments: c.Expr) -> c.Expr:
        """A call of a function of a line."""
        if line.kind == "path":
            x, y = (self.field(line.name, name) for name in ("x", "y"))
            return self.call(
                f"tm_path_{what}", x, y, c.Member(self.input(line.name), "count", False), *arguments
            )
        return self.call(f"tm_line_{what}", *self.shape(line), *arguments)

    def shape(self, item: ir.Line | ir.Area) -> tuple[c.Expr, c.Expr]:
        """The context, and the place of a line or region in it."""
        shapes = c.Member(self.name("context"), "shapes", True)
        return c.Name("context"), c.Address(c.Member(shapes, self.plan.shape(item).c_name, False))

    def _on_lane(self, node: ir.OnLane, at: c.Scope) -> c.Expr:
        """What is asked of a lane by its number; of one that is not there, nothing is known."""
        shapes = c.Member(self.name("context"), "shapes", True)
        every = c.Member(shapes, self.plan.shape(node).c_name, False)
        count = c.Member(self.input(node.signal), "count", False)
        lane = self.call("tm_lane_at", every, count, self.number(node.lane, at))
        given = [self.number(each, at) for each in node.ends]
        match node.what:
            case "inside" | "meets":
                way = "curved" if len(given) > _STRAIGHT else "swept"
                bound = [c.Name("TM_INF")] if node.what == "inside" else []
                return self.call(f"tm_{way}_{node.what}", self.name("context"), lane, *given, *bound)
            case "station" | "offset" | "direction":
                call = self.call("tm_line_project", self.name("context"), lane, *given)
                key = ("lane", self.plan.shape(node), node.lane, *node.ends)
                return c.Member(self._projection(key, call, node, at), node.what, False)
            case "distance" | "gap":
                return self.call(f"tm_line_{node.what}", self.name("context"), lane, *given)
            case "room":
                return self.call("tm_line_stretch_room", self.name("context"), lane, *given)
            case _:
                assert_never(node.what)

    def _projected(self, node: ir.Projected, at: c.Scope) -> c.Expr:
        """The name of a point's projection, made once: its station, offset and direction are three nodes."""
        x, y = self.number(node.x, at), self.number(node.y, at)
        key = ("projection", node.line, node.x, node.y)
        return self._projection(key, self._on_line("project", node.line, x, y), node, at)

    def _projection(self, key: tuple[object, ...], call: c.Expr, node: ir.Num, at: c.Scope) -> c.Expr:
        home = self.home(self.facts.free(node), at)
        for scope in at.chain():  # as far out as that, what is known is about the same point
            if key in scope.known:
                return scope.known[key]
            if scope is home:
                break
        known = self.declare(at, "tm_projection", call, identifier(f"projection_{self._whose(node, at)}"))
        at.known[key] = known
        return known

    # Formulas ---------------------------------------------------------------------------------------------------

    def formula(self, node: ir.Formula, scope: c.Scope, role: str = "holds", named: bool = False) -> c.Expr:
        """C of a formula that is read in a scope. named: it gets a name, as it is read twice."""
        home = self._home(node, scope)
        known = home.known.get(node)
        if known is not None:
            return known
        before, self._span = self._span, getattr(node, "span", None) or self._span
        made = self._formula(node, home)
        if not isinstance(node, ir.Truth) and self._apart(node, made, named or home is not scope, _LONG):
            made = self.declare(home, self.type, made, *self._called(node, made, role, home))
        home.known[node] = made
        self._span = before
        return made

    def _formula(self, node: ir.Formula, at: c.Scope) -> c.Expr:
        match node:
            case ir.Truth():
                return self.over("true" if node.value else "false")
            case ir.Flag():
                return self.over("flagged", self._flag(node, at))
            case ir.Compare():
                _, one, other = node.written
                left = self.number(one, at, "left", _LONG_SIDE)
                right = self.number(other, at, "right", _LONG_SIDE)
                return self.over(compared(node.op, node.turned), left, right)
            case ir.SweptInside() | ir.SweptClear() | ir.InArea():
                return self.over("apart_by", self._geometry(node, at))
            case ir.Scaled():
                return self.over("scaled", self.formula(node.operand, at), c.Literal(literal(node.scale)))
            case ir.Not():
                return self.over("not", self.formula(node.operand, at))
            case ir.Connective():
                return self._connect(node.op, self.formula(node.left, at), self.formula(node.right, at))
            case ir.Quantify():
                return self.quantify([node], at)[0]
            case ir.Guarded():
                return self.over(
                    "whenever", self.formula(node.guard, at, "guard"), self.formula(node.body, at)
                )
            case ir.Temporal() | ir.Until() | ir.Shift():
                return self.timed(node, at)
            case ir.Tallied():
                return self._tallied(node, at)
            case ir.OverRun():
                return self.call(f"tm_{self.plan.memory(node).c_name}_now", *self._recalled(node, at))
            case ir.Counted():
                tally = self.call(f"tm_{self.plan.memory(node).c_name}_now", *self._recalled(node, at))
                return self.call(
                    f"tm_count_{compared(node.op, node.turned)}", tally, self.number(node.limit, at, "limit")
                )
            case ir.InState():
                states = c.Address(self.states(node.machine, at))
                state = c.Literal(f"{node.machine.states.index(node.state)}u")
                return self.call(f"tm_{self.plan.memory(node.machine).c_name}_is", states, state)
            case ir.At():
                first = at.open(None)
                first.binds[node.axis] = self._judged(node)
                first.binders[node.axis] = (node.name,)
                made = self.formula(node.operand, first)
                at.close(first)
                return made
            case _:
                assert_never(node)

    def _judged(self, node: ir.At) -> c.Expr:
        """The place of the sample at which a rule is judged."""
        match node.place:
            case "first":
                return _ZERO
            case "last":
                return self._last(node.axis.signal)
            case "now":
                return c.Member(self.input(node.axis.signal), "now", False)
            case _:
                assert_never(node.place)

    def timed(self, node: ir.Timed, at: c.Scope) -> c.Expr:
        """The value of a temporal operator at the present sample."""
        from trackmarshal.backends.c.timelines import series

        return self.over("kept", *series(self, node, at), self.index(node.axis, at))

    def _tallied(self, node: ir.Tallied, at: c.Scope) -> c.Expr:
        """A count of the samples up to the present one, compared."""
        from trackmarshal.backends.c.timelines import series

        count = self.over("tallied_at", *series(self, node, at), self.index(node.axis, at))
        compare = compared(node.op, node.turned)
        limit = self.number(node.limit, at, "limit")
        return self.call(f"tm_{compare}" if self.known else f"tm_count_{compare}", count, limit)

    def place_of(self, axes: tuple[ir.Axis, ...], scope: c.Scope, places: str = "place") -> list[c.Expr]:
        """The place in memories of an element of a set, or of a pair, in the present cycle (`place`) or from now on (`next`); of the run, none."""
        if not axes:
            return []
        run = c.Member(self.name("context"), "run", True)
        place: c.Expr = c.Member(c.Member(run, self.plan.places_of(axes), False), places, False)
        for axis in axes:
            place = c.Element(place, self.index(axis, scope))
        return [place]

    def states(self, machine: ir.Machine, scope: c.Scope) -> c.Expr:
        """The name of the states that a machine may be in after the present cycle, with what it keeps in each."""
        axis = machine.axis
        home = self.home(frozenset() if axis is None else frozenset([axis]), scope)
        known = home.known.get(machine)
        if known is None:
            cell = self.plan.memory(machine)
            places = self.place_of(cell.axes, home)
            guards = [self.formula(guard, home, "guard") for guard in machine.guards]
            numbers = [self.noted(number, home) for number in machine.numbers]
            made = self.call(f"tm_{cell.c_name}_now", self.name("context"), *places, *guards, *numbers)
            known = home.known[machine] = self.declare(
                home, f"tm_{cell.c_name}_states", made, identifier(machine.name)
            )
        return known

    def noted(self, node: ir.Num, scope: c.Scope) -> c.Expr:
        """A number that a machine may take note of."""
        return self.number(node, scope, "noted")

    def _recalled(self, node: ir.OverRun | ir.Counted, at: c.Scope) -> list[c.Expr]:
        """The arguments of a recollection: the context, whose memory it is, and the operands in the present cycle."""
        places = self.place_of(self.plan.memory(node).axes, at)
        return [self.name("context"), *places, *(self.formula(each, at) for each in node.operands)]

    def _flag(self, node: ir.Flag, at: c.Scope) -> c.Expr:
        if node.axis is not None:
            return self.column(node, at)
        source = self.plan.input(node.signal)
        if source.kind == "event":
            return self.input(node.signal)
        field = self.field(node.signal, node.field or "")
        if source.kind != "columns":
            return field
        return c.Element(field, _ZERO if node.offset == 0 else self._last(node.signal))

    def _connect(self, op: ConnectiveOp, left: c.Expr, right: c.Expr) -> c.Expr:
        match op:
            case "and" | "or" | "xor":
                return self.over(op, left, right)
            case "iff":
                return self.over("not", self.over("xor", left, right))
            case _:
                assert_never(op)

    def _geometry(self, node: ir.Geometry, at: c.Scope) -> c.Expr:
        """The signed distance of a geometric predicate."""
        given = [self.number(each, at) for each in self.facts.operands(node) if isinstance(each, ir.Num)]
        bound = self.bounds.get(node, c.Name("TM_INF"))
        match node:
            case ir.SweptClear():
                return (
                    self.call("tm_curved_clear", *given, bound)
                    if node.bend
                    else self.call("tm_swept_clear", *given)
                )
            case ir.SweptInside():
                function = "tm_curved_inside" if node.bend else "tm_swept_inside"
                return self.call(function, *self.shape(node.area), *given, bound)
            case ir.InArea():
                alone = self.known and node not in self.margins
                return self.call("tm_in_area_sign" if alone else "tm_in_area", *self.shape(node.area), *given)
            case _:
                assert_never(node)

    # Quantifiers ------------------------------------------------------------------------------------------------

    def quantify(
        self,
        nodes: Sequence[ir.Quantify],
        at: c.Scope,
        owners: Sequence[RuleInfo] = (),
        names: Sequence[str] = (),
    ) -> list[c.Expr]:
        """Quantifiers over one axis, in one loop; of several rules, where `owners` says whose each is. `names`: of their values."""
        found: dict[ir.Quantify, c.Expr] = {}
        for node in nodes:
            count = self._counted(node)
            if count is not None:
                found[node] = self.over("told", count)
        looping: list[tuple[int, ir.Quantify]] = []
        several = self._several([node for node in nodes if node not in found])
        for place, node in enumerate(nodes):
            if node in found:
                continue
            looping.append((place, node))
            if owners:
                self.of(owners[place])
            every = node.extreme is Extreme.LEAST
            wanted = names[place] if names else "all" if every else "some"
            name = at.take(wanted, f"{wanted}_{identifier(node.names[0])}")
            if node in several:
                empty = self.over("several_true" if every else "several_false", self.count(node.axis))
                self.add(at, c.Declare("tm_several", name, empty, False))
            else:
                self.add(at, c.Declare(self.type, name, self.over("true" if every else "false"), False))
            found[node] = c.Name(name)
        sweeps = self._sweeps(looping[0][1], at) if len(looping) == 1 else None
        alike = [(place, node) for place, node in looping if sweeps is not None or self._alike(node)]
        self._passes([each for each in looping if each[1] in several], at, found, owners)
        differing = [each for each in looping if each not in alike and each[1] not in several]
        for once, some in ((False, differing), (True, alike)):
            if some:
                axis, spoken = nodes[0].axis, some[0][1].names
                scope = self._if_any(axis, at) if once else self.loop(axis, at, spoken)
                for together in self._together(some):
                    if owners:
                        self.of(owners[together[0][0]])
                    inner = self._where([node for _, node in together], scope)
                    self._nested(together, inner, owners)
                    for place, node in together:
                        if owners:
                            self.of(owners[place])
                        self._one_more(node, found[node], inner, sweeps)
                    while inner is not scope:
                        assert inner.parent is not None
                        inner.parent.close(inner)
                        inner = inner.parent
                at.close(scope)
        return [found[node] for node in nodes]

    def _several(self, nodes: Sequence[ir.Quantify]) -> frozenset[ir.Quantify]:
        """Those quantifiers that are worked out for several samples at once. What asks something of the same samples stays together."""
        if not self._takes_several:
            return frozenset()
        simple = [node for node in nodes if _simple(self.plan, node)]
        apart = {node.guard for node in nodes if node.guard is not None and node not in simple}
        return frozenset(node for node in simple if node.guard not in apart)

    def _asks_range(self, node: ir.Quantify) -> bool:
        """Whether a quantifier asks no more than whether there is anything in range."""
        return node.extreme is Extreme.GREATEST and node not in self.margins and _is_true(node.body)

    def _passes(
        self,
        some: Sequence[tuple[int, ir.Quantify]],
        at: c.Scope,
        found: dict[ir.Quantify, c.Expr],
        owners: Sequence[RuleInfo],
    ) -> None:
        """Quantifiers that are worked out for several samples at once, in one loop."""
        if not some:
            return
        loop, inner, n = self._loop_of_several(some[0][1].axis, at, some[0][1].names)
        added = list[c.Statement]()
        for place, node in some:
            if owners:
                self.of(owners[place])
            kind = "for_all" if node.extreme is Extreme.LEAST else "exists"
            given = [c.Address(found[node]), n]
            where = ""
            if node.guard is not None:
                given.append(self.formula(node.guard, inner, "guard"))
                where = "" if self._asks_range(node) else "_where"
            if node.guard is None or where:
                given.append(self.formula(node.body, inner))
            self.add(inner, c.Evaluate(self.over(f"put{where}", *given)))
            added.append(c.Evaluate(self.over(f"{kind}_put{where}", c.Address(found[node]))))
            told = "all_put" if node.extreme is Extreme.LEAST else "some_put"
            found[node] = self.over(told, c.Address(found[node]))
        loop.close(inner)
        for each in added:
            loop.add(each)
        at.close(loop)

    def _loop_of_several(
        self, axis: ir.Axis, at: c.Scope, names: tuple[str, ...]
    ) -> tuple[c.Scope, c.Scope, c.Expr]:
        """A scope for each pass over several values of an axis, in it one that goes through them, and the place among them."""
        count = self.declare(at, "size_t", self.count(axis), "windows" if axis.width > 1 else "count")
        number, first, place = c.Name("pass"), c.Name("first"), c.Name("n")
        passes, several = self.over("passes", count), c.Name("TM_SEVERAL")

        def outer(body: tuple[c.Statement, ...]) -> c.Statement:
            begin = c.Declare("size_t", first.name, self.over("pass_first", number, count))
            step = c.Unary("++", number)
            return c.For(number.name, c.Binary("<", number, passes), step, (begin, *body), axis.signal)

        def head(body: tuple[c.Statement, ...]) -> c.Statement:
            own = c.Declare("size_t", index, c.Binary("+", first, place))
            return c.For(place.name, c.Binary("<", place, several), c.Unary("++", place), (own, *body))

        loop = at.open(outer)
        number, first = c.Name(loop.take("pass")), c.Name(loop.take("first"))
        inner = loop.open(head)
        place, index = c.Name(inner.take("n")), inner.take(identifier(names[0]))
        inner.binds[axis] = c.Name(index)
        inner.binders[axis] = names
        return loop, inner, place

    def _together(self, some: Sequence[tuple[int, ir.Quantify]]) -> list[list[tuple[int, ir.Quantify]]]:
        """Quantifiers in their order, those that ask something of the same elements beside the first of them."""
        asking: dict[ir.Formula | None, list[tuple[int, ir.Quantify]]] = {}
        for each in some:
            asking.setdefault(each[1].guard, []).append(each)
        return list(asking.values())

    def _nested(
        self, together: Sequence[tuple[int, ir.Quantify]], inner: c.Scope, owners: Sequence[RuleInfo]
    ) -> None:
        """Quantifiers right within some, over one axis, in one loop: whether a rule holds, and whether it applies."""
        bodies = [(place, node.body) for place, node in together if isinstance(node.body, ir.Quantify)]
        for axis in dict.fromkeys(body.axis for _, body in bodies):
            same = [(place, body) for place, body in bodies if body.axis is axis]
            if len(same) > 1 and all(self._home(body, inner) is inner for _, body in same):
                made = [body for _, body in same]
                whose = [owners[place] for place, _ in same] if owners else ()
                inner.known.update(zip(made, self.quantify(made, inner, whose)))

    def _where(self, nodes: Sequence[ir.Quantify], scope: c.Scope) -> c.Scope:
        """The scope for what some quantifiers ask of elements in range: an `if` of its own where anything is computed that nobody else reads,
        and one before each part of the guard that takes long, for what stands before it."""
        guard, bodies = nodes[0].guard, [node.body for node in nodes]
        if guard is None:
            return scope
        inner, parts = scope, _conjuncts(guard)
        for place in range(1, len(parts)):
            own = self.usage.only_in([*(part for _, part in parts[place:]), *bodies])
            if any(node in own and _takes_long(node) for node in ir.below(parts[place][1])) and not any(
                isinstance(node, _EVERY_CYCLE) for node in own
            ):
                inner = self._if_may(parts[place - 1][0], inner, own | {whole for whole, _ in parts[place:]})
        own = self.usage.only_in(bodies)
        if any(isinstance(node, _EVERY_CYCLE) for node in own) or not any(
            isinstance(node, _WORTH) for node in own
        ):
            return inner
        return self._if_may(guard, inner, own)

    def _if_may(self, guard: ir.Formula, scope: c.Scope, own: frozenset[Value]) -> c.Scope:
        """A scope for what is computed only where a formula may hold."""
        condition = self.over("may_hold", self.formula(guard, scope, "guard", named=True))
        inner = scope.open(lambda body: c.If(condition, body))
        inner.own = own
        return inner

    def _alike(self, node: ir.Quantify) -> bool:
        """Whether a quantifier says the same of all that it goes through."""
        return node.axis not in self.facts.free(node.body) and (
            node.guard is None or node.axis not in self.facts.free(node.guard)
        )

    def _one_more(
        self, node: ir.Quantify, accumulated: c.Expr, scope: c.Scope, sweeps: c.Expr | None
    ) -> None:
        """What one sample or element adds to a quantifier's value."""
        every = node.extreme is Extreme.LEAST
        guard: c.Expr | None = None if node.guard is None else self.formula(node.guard, scope, "guard")
        body: c.Expr
        if sweeps is not None:
            body = self.over("apart_by", sweeps)
        elif guard is not None and self._asks_range(node):
            body, guard = guard, None  # there is one in range
        else:
            least = (
                self.known
                and every
                and isinstance(node.body, ir.Geometry)
                and node.axis in self.facts.free(node.body)
            )
            if least and self.usage.readers[node.body] == 1:
                # The least margin is asked for: one that is greater than the least so far need not be exact.
                self.bounds[node.body] = c.Member(accumulated, "margin", False)
            body = self.formula(node.body, scope)
        function = "for_all" if every else "exists"
        if guard is None:
            self.add(scope, c.Evaluate(self.over(function, c.Address(accumulated), body)))
        else:
            self.add(scope, c.Evaluate(self.over(f"{function}_where", c.Address(accumulated), guard, body)))

    def of(self, rule: RuleInfo) -> None:
        """Go on with another rule."""
        self.rule, self._span = rule, rule.span

    def _counted(self, node: ir.Formula) -> c.Expr | None:
        """Whether there is anything, where no more than that is asked."""
        if (
            not isinstance(node, ir.Quantify)
            or node.guard is not None
            or node.extreme is not Extreme.GREATEST
        ):
            return None
        some = c.Binary(">", self.count(node.axis), _ZERO)
        if _is_true(node.body):
            return some
        inner = self._counted(node.body)
        return None if inner is None else c.Binary("&&", some, inner)

    def _if_any(self, axis: ir.Axis, at: c.Scope) -> c.Scope:
        """A scope for what is the same for all of an axis."""
        condition = c.Binary(">", self.count(axis), _ZERO)
        return at.open(lambda body: c.If(condition, body))

    def _sweeps(self, node: ir.Quantify, at: c.Scope) -> c.Expr | None:
        """The least margin of sweeps all along a timeline, in one call; None for anything else."""
        body = node.body
        if (
            not self.known
            or node.guard is not None
            or node.extreme is not Extreme.LEAST
            or not isinstance(body, ir.SweptInside)
        ):
            return None
        free = self.facts.free(body.length) | self.facts.free(body.width)
        fields = along_timeline(body, node.axis, free)
        if not fields or self.usage.readers[body] != 1:
            return None
        columns = [self.field(node.axis.signal, name) for name in fields]
        if len(columns) == 3:
            columns.append(c.Name("NULL"))  # straight
        size = [self.number(each, at) for each in (body.length, body.width)]
        return self.call("tm_timeline_inside", *self.shape(body.area), *columns, self.count(node.axis), *size)


def takes_several(plan: Layout, rules: Sequence[RuleInfo]) -> bool:
    """Whether rules have anything that may be worked out for several samples at once."""
    return any(
        isinstance(node, ir.Quantify) and _simple(plan, node)
        for rule in rules
        for root in roots(rule)
        for node in ir.below(root)
    )


def _simple(plan: Layout, node: ir.Quantify) -> bool:
    """Whether a quantifier over a timeline is of simple arithmetic, and of nothing that is called, or entered only sometimes: it is worked
    out for several samples as it is for one."""
    axis = node.axis
    if axis.kind != "samples" or axis.signal in plan.courses:
        return False
    if node.guard is not None and _is_true(node.body):
        asked = [node.guard] if node.extreme is Extreme.GREATEST else []
    else:
        asked = [node.body] if node.guard is None else [node.guard, node.body]
    differs = any(axis in plan.facts.free(each) for each in asked)
    if not (told_by_margin(asked[-1]) and _always_finite(asked[-1])):
        return False
    return differs and all(_straight(plan, each) for each in asked)


def _all_of(value: Value, parts: Callable[[Value], Iterable[Value] | None]) -> bool:
    """Whether all of a value is as wanted: `parts` gives what else is asked of a node, None where it is not as wanted. What stands in it
    several times is asked once."""
    asked, waiting = set[Value](), [value]
    while waiting:
        node = waiting.pop()
        if node not in asked:
            asked.add(node)
            more = parts(node)
            if more is None:
                return False
            waiting += more
    return True


def _straight(plan: Layout, value: Value) -> bool:
    """Whether all of a value that differs from sample to sample is arithmetic in a line."""

    def parts(node: Value) -> Iterable[Value] | None:
        match node:
            case _ if not plan.facts.free(node):
                return () if isinstance(node, ir.Num) else None
            case ir.Column():
                return () if node.offset >= 0 else None
            case ir.Func() if node.name not in _IN_LINE:
                return None
            case ir.Arith() | ir.Neg() | ir.Func() | ir.Choose() | ir.Compare() | ir.Connective() | ir.Not():
                return plan.facts.operands(node)
            case _:
                return None

    return _all_of(value, parts)


def _always_finite(formula: ir.Formula) -> bool:
    """Whether the margin of what is simple is finite where all is known: with several samples at once, an infinite one is not known."""

    def parts(node: Value) -> Iterable[Value] | None:
        if isinstance(node, ir.Connective):
            return node.left, node.right
        same = isinstance(node, ir.Compare) and COMPARISONS[node.op].measure is Measure.SAMENESS
        return None if same else ()

    return _all_of(formula, parts)


def told_by_margin(formula: ir.Formula) -> bool:
    """Whether a formula of which all is known holds exactly where its margin is not negative."""

    def parts(node: Value) -> Iterable[Value] | None:
        match node:
            case ir.Compare():
                return () if COMPARISONS[node.op].holds_at_zero else None
            case ir.Truth() | ir.Flag() | ir.SweptInside() | ir.SweptClear() | ir.InArea():
                return ()
            case ir.Connective() if node.op in ("and", "or"):
                return node.left, node.right
            case ir.Quantify() | ir.Guarded():
                return (node.body,)
            case _:
                return None  # of a margin that is divided by a scale, nothing may be left

    return _all_of(formula, parts)


def _conjuncts(formula: ir.Formula) -> list[tuple[ir.Formula, ir.Formula]]:
    """What has to hold, part by part, each after the formula that says it and all that stands before it."""
    if isinstance(formula, ir.Connective) and formula.op == "and":
        return [*_conjuncts(formula.left), (formula, formula.right)]
    return [(formula, formula)]


def _takes_long(node: ir.IR) -> bool:
    return isinstance(node, _LONG_WAY) or (isinstance(node, ir.Func) and bool(called(node.name)[1]))


def _is_true(formula: ir.Formula) -> bool:
    return isinstance(formula, ir.Truth) and formula.value


def _of_arithmetic(made: c.Binary) -> tuple[str, ...]:
    """What simple arithmetic on something with a name is called."""
    match made.left, made.op, made.right:
        case c.Name(), "/", c.Literal() if made.right.text == "2.0":
            return (f"half_{made.left.name}",)
        case c.Literal(), "*", c.Name() if made.left.text == "2.0":
            return (f"twice_{made.right.name}",)
        case _:
            return ()


#: What takes so long that it is asked first whether it is needed; of functions, those of libm.
_LONG_WAY = (
    ir.Lookup,
    ir.GridLookup,
    ir.Along,
    ir.OnLane,
    ir.Fold,
    ir.Quantify,
    ir.SweptInside,
    ir.SweptClear,
    ir.InArea,
)
#: What is not computed where it is not needed.
_WORTH = (ir.Arith, ir.Func, *_LONG_WAY)
#: Functions that take their arguments as they come, without a branch or a call.
_IN_LINE: frozenset[FunctionName] = frozenset(["abs", "sqrt", "hypot", "floor", "min", "max"])
#: What is computed whether it is needed or not: series of a timeline, and what goes with memories of the run.
_EVERY_CYCLE = (ir.Temporal, ir.Until, ir.Shift, ir.Tallied, ir.At, ir.OverRun, ir.Counted, ir.InState, ir.Kept)  # fmt: skip
#: Names that locals do not have: parameters of functions, and what C and its headers know.
_TAKEN = RESERVED | {"context", "in", "out", "monitor", "known"}
