"""Numbers and formulas: each in place where it is read once, else under a name, in the outermost scope in which all its variables are bound."""

from __future__ import annotations

from typing import assert_never

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.facts import Value
from trackmarshal.backends.c.functions import geometry
from trackmarshal.backends.c.functions.naming import wanted
from trackmarshal.backends.c.functions.operators import called, compared
from trackmarshal.backends.c.functions.quantifiers import quantify
from trackmarshal.backends.c.functions.timelines import series
from trackmarshal.backends.c.functions.writer import LONG, ZERO, Writer
from trackmarshal.backends.c.names import identifier, literal
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import ConnectiveOp, FoldOp
from trackmarshal.ir.tables import LINEAR_CLAMP

#: A side of a comparison that is longer than this is named for readers.
_LONG_SIDE = 40
#: What a number of many is called while it is worked out.
_FOLDED: dict[FoldOp, str] = {"sum": "total", "least": "least", "greatest": "greatest", "nearest": "nearest"}


class Expressions(Writer):
    """Writes what a function is made of, node by node."""

    def number(
        self, node: ir.Num, scope: c.Scope, role: str = "", most: int = LONG, times: int = 1
    ) -> c.Expr:
        home = self.home_of(node, scope)
        known = home.known.get(node)
        if known is not None:
            return known
        made = self._number(node, home)
        if isinstance(node, ir.Const):
            self._length[made] = len(literal(node.value))
        elif self._apart(node, made, home is not scope, most, times):
            made = self.declare(home, "double", made, *wanted(self, node, made, role, home))
        home.known[node] = made
        return made

    def _apart(self, node: Value, made: c.Expr, elsewhere: bool, most: int, times: int = 1) -> bool:
        """Whether a value gets a name of its own."""
        if isinstance(made, c.Name | c.Literal):
            return False
        if elsewhere or isinstance(node, ir.Param) or self.usage.readers.get(node, 2) > times:
            return True
        return node in self.usage.own or self.length(made) > most

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
                at_index = ZERO if node.index == 0 else self._last(node.signal)
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
                return c.Member(geometry.projected(self, node, at), node.spoken, False)
            case ir.Distance():
                return geometry.on_line(
                    self, "distance", node.line, self.number(node.x, at), self.number(node.y, at)
                )
            case ir.StationGap():
                return geometry.on_line(
                    self, "gap", node.line, self.number(node.start, at), self.number(node.end, at)
                )
            case ir.OnLane():
                return geometry.on_lane(self, node, at)
            case ir.StretchRoom():
                parts = (self.number(part, at) for part in (node.station, node.start, node.end))
                return geometry.on_line(self, "stretch_room", node.line, *parts)
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

    def formula(self, node: ir.Formula, scope: c.Scope, role: str = "holds", named: bool = False) -> c.Expr:
        home = self.home_of(node, scope)
        known = home.known.get(node)
        if known is not None:
            return known
        before, self._span = self._span, getattr(node, "span", None) or self._span
        made = self._formula(node, home)
        if not isinstance(node, ir.Truth) and self._apart(node, made, named or home is not scope, LONG):
            made = self.declare(home, self.type, made, *wanted(self, node, made, role, home))
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
                return self.over("apart_by", geometry.distance(self, node, at))
            case ir.Scaled():
                return self.over("scaled", self.formula(node.operand, at), c.Literal(literal(node.scale)))
            case ir.Not():
                return self.over("not", self.formula(node.operand, at))
            case ir.Connective():
                return self._connect(node.op, self.formula(node.left, at), self.formula(node.right, at))
            case ir.Quantify():
                return quantify(self, [node], at)[0]
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
                return ZERO
            case "last":
                return self._last(node.axis.signal)
            case "now":
                return c.Member(self.input(node.axis.signal), "now", False)
            case _:
                assert_never(node.place)

    def timed(self, node: ir.Timed, at: c.Scope) -> c.Expr:
        """The value of a temporal operator at the present sample."""
        return self.over("kept", *series(self, node, at), self.index(node.axis, at))

    def _tallied(self, node: ir.Tallied, at: c.Scope) -> c.Expr:
        """A count of the samples up to the present one, compared."""
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
        return c.Element(field, ZERO if node.offset == 0 else self._last(node.signal))

    def _connect(self, op: ConnectiveOp, left: c.Expr, right: c.Expr) -> c.Expr:
        match op:
            case "and" | "or" | "xor":
                return self.over(op, left, right)
            case "iff":
                return self.over("not", self.over("xor", left, right))
            case _:
                assert_never(op)
