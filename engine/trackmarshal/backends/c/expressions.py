"""Nodes of the IR to C statements: each node once, in the outermost block in which all its variables are bound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import assert_never

from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import comment, literal
from trackmarshal.backends.c.slots import mark
from trackmarshal.backends.c.statements import Block
from trackmarshal.backends.c.sweeps import along_timeline
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import COMPARISONS, ConnectiveOp, Extreme, FunctionName, Measure
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.source import Span


@dataclass(frozen=True)
class Value:
    """The C names of a formula's value; of one known for sure, worst and best are the same names."""

    worst_sat: str
    worst_margin: str
    best_sat: str
    best_margin: str

    @property
    def sides(self) -> tuple[tuple[str, str], tuple[str, str]]:
        return (self.worst_sat, self.worst_margin), (self.best_sat, self.best_margin)


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


def margin(measure: Measure, a: str, b: str) -> str:
    """C of a comparison's margin."""
    match measure:
        case Measure.ROOM:
            return f"{b} - {a}"
        case Measure.NEARNESS:
            return f"-fabs({a} - {b})"
        case Measure.DISTANCE:
            return f"fabs({a} - {b})"
        case _:
            assert_never(measure)


def extreme(kind: Extreme) -> tuple[str, str]:
    """The C operator that joins whether formulas hold, and the function that joins their margins."""
    match kind:
        case Extreme.LEAST:
            return "&&", "tm_least"
        case Extreme.GREATEST:
            return "||", "tm_greatest"
        case _:
            assert_never(kind)


def neutral(kind: Extreme) -> tuple[str, str]:
    """C of whether nothing holds, and of its margin."""
    holds, least = kind.neutral
    return ("true" if holds else "false"), ("TM_INF" if least > 0.0 else "-TM_INF")


class Writer:
    """Writes one function of one rule. `known`: everything is taken for known, and whatever is not is remarked in `suspect`.

    The other kind of function carries a worst and a best case through every formula (strong Kleene logic).
    """

    def __init__(self, plan: Layout, rule: RuleInfo, known: bool) -> None:
        self.plan = plan
        self.rule = rule
        self.known = known
        self.root = Block("")
        self._count = 0
        self._notes: dict[tuple[str, int], str] = {}
        self._free: dict[ir.IR, frozenset[ir.Axis]] = {}
        self._span: Span | None = rule.span
        #: How many series of the context the function needs, once it is written.
        self.series = 0
        #: Geometric predicates of which only margins below this one matter.
        self.bounds: dict[ir.IR, str] = {}
        #: Those of which all along a timeline are computed ahead of the loop: where, and C of the columns and their length.
        self.timelines: dict[ir.IR, tuple[Block, str]] = {}
        #: libm functions that the function calls, and operations counted once for every statement.
        self.libm: set[str] = set()

    # Bookkeeping ------------------------------------------------------------------------------------------------

    def fresh(self) -> int:
        self._count += 1
        return self._count

    def refuse(self, node: ir.IR, why: str) -> TrackmarshalError:
        span = getattr(node, "span", None) or self.rule.span
        return TrackmarshalError(
            "E470", f"rule `{self.rule.name}`: {why}", file=span.file.path, line=span.line,
            help="choose rules with --rule, or another backend",
        )  # fmt: skip

    def note(self) -> str:
        span = self._span or self.rule.span
        known = self._notes.get((self.rule.name, id(span)))
        if known is None:
            wanted = " ".join(name for name, _ in self.rule.satisfies)
            known = comment(f"{self.rule.name}{' ' + wanted if wanted else ''} {span.file.path}:{span.line}")
            self._notes[self.rule.name, id(span)] = known
        return known

    def add(self, block: Block, text: str, target: str | None = None) -> None:
        block.add(text, target, self.note())

    def free(self, node: ir.Num | ir.Formula) -> frozenset[ir.Axis]:
        """The axes whose variables a node depends on."""
        found = self._free.get(node)
        if found is None:
            found = self._free[node] = self._free_of(node)
        return found

    def _free_of(self, node: ir.Num | ir.Formula) -> frozenset[ir.Axis]:
        match node:
            case ir.Column():
                return frozenset([node.axis])
            case ir.Flag():
                return frozenset() if node.axis is None else frozenset([node.axis])
            case ir.Quantify():
                inner = self.free(node.body) | (frozenset() if node.guard is None else self.free(node.guard))
                return inner - {node.axis}
            case ir.First():
                return self.free(node.operand) - {node.axis}
            case ir.Temporal() | ir.Shift():
                return self.free(node.operand) | {node.axis}
            case ir.Until():
                return self.free(node.left) | self.free(node.right) | {node.axis}
            case _:  # nodes that bind no axis
                result: frozenset[ir.Axis] = frozenset()
                for child in ir.operands(node):
                    result |= self.free(child)
                return result

    def home(self, axes: frozenset[ir.Axis], block: Block) -> Block:
        """The outermost block, seen from one inside, in which these axes' variables have their present values."""
        for candidate in block.chain():
            if candidate.parent is None or any(axis in candidate.binds for axis in axes):
                return candidate
        raise AssertionError("blocks end at the root")

    def index(self, axis: ir.Axis, block: Block) -> str:
        for candidate in block.chain():
            if axis in candidate.binds:
                return candidate.binds[axis]
        raise AssertionError(f"no variable of axis {axis.signal} in scope")

    def count(self, axis: ir.Axis) -> str:
        """C of how many values an axis has."""
        total = f"in->{self.plan.input(axis.signal).c_name}.count"
        return total if axis.width == 1 else f"tm_windows({total}, {axis.width}u)"

    # Numbers ----------------------------------------------------------------------------------------------------

    def number(self, node: ir.Num, block: Block) -> str:
        """The C name of a number's value; its statement is written where it belongs."""
        home = self.home(self.free(node), block)
        known = home.known.get(node)
        if known is None:
            text = self._number(node, home)
            if isinstance(node, ir.Const):
                known = text
            else:
                known = f"n{self.fresh()}"
                self.add(home, f"const double {known} = {text};", known)
            home.known[node] = known
        assert isinstance(known, str)
        return known

    def _number(self, node: ir.Num, at: Block) -> str:
        match node:
            case ir.Const():
                return literal(node.value)
            case ir.Param():
                return f"c->params.{self.plan.params[node.name]}"
            case ir.Column():
                return self._column(node, at)
            case ir.Sample():
                place = self.plan.input(node.signal).c_name
                column = self.plan.field_name(node.signal, node.field)
                if node.index not in (0, -1):
                    raise self.refuse(
                        node,
                        f"sample {node.index} of `{node.signal}`; the C generator knows the first and the last",
                    )
                at_index = "0" if node.index == 0 else f"in->{place}.count - 1u"
                return f"in->{place}.{column}[{at_index}]"
            case ir.Scalar():
                return f"in->{self.plan.input(node.signal).c_name}.{self.plan.field_name(node.signal, node.field)}"
            case ir.Arith():
                left, right = self.number(node.left, at), self.number(node.right, at)
                return f"{left} {node.op} {right}"
            case ir.Neg():
                return f"-{self.number(node.operand, at)}"
            case ir.Func():
                args = ", ".join([self.number(arg, at) for arg in node.args])
                function, libm = called(node.name)
                self.libm |= libm
                return f"{function}({args})"
            case ir.Choose():
                condition = self.formula(node.condition, at)
                then, otherwise = self.number(node.then, at), self.number(node.otherwise, at)
                if self.known:
                    return f"{condition.worst_sat} ? {then} : {otherwise}"
                return f"{condition.worst_sat} ? {then} : ({condition.best_sat} ? TM_NAN : {otherwise})"
            case ir.Lookup():
                return (
                    f"tm_lookup(&c->tables.{self.plan.tables[node.table]}, {self.number(node.argument, at)})"
                )
            case ir.Station():
                return f"{self._projected(node, at)}.station"
            case ir.Offset():
                return f"{self._projected(node, at)}.offset"
            case ir.Direction():
                return f"{self._projected(node, at)}.direction"
            case ir.Distance():
                return f"{self._on_line('distance', node.line)}, {self.number(node.x, at)}, {self.number(node.y, at)})"
            case ir.StationGap():
                return f"{self._on_line('gap', node.line)}, {self.number(node.start, at)}, {self.number(node.end, at)})"
            case _:
                assert_never(node)

    def _column(self, node: ir.Column | ir.Flag, at: Block) -> str:
        assert node.axis is not None
        index = self.index(node.axis, at)
        signal, name = (node.axis.signal, node.field)
        place = f"in->{self.plan.input(signal).c_name}.{self.plan.field_name(signal, name or '')}"
        if node.offset > 0:
            return f"{place}[{index} + {node.offset}u]"
        if node.offset < 0:
            return f"{place}[tm_before({index}, {-node.offset}u)]"
        return f"{place}[{index}]"

    def _on_line(self, what: str, line: ir.Line) -> str:
        """The call of a function of a line, up to its last arguments."""
        if line.kind == "path":
            signal = f"in->{self.plan.input(line.name).c_name}"
            x, y = (self.plan.field_name(line.name, name) for name in ("x", "y"))
            return f"tm_path_{what}({signal}.{x}, {signal}.{y}, {signal}.count"
        return f"tm_line_{what}(c, &c->shapes.{self.plan.shape(line).c_name}"

    def _projected(self, node: ir.Projected, at: Block) -> str:
        """The name of a point's projection, made once: its station, offset and direction are three nodes."""
        x, y = self.number(node.x, at), self.number(node.y, at)
        key = ("projection", node.line, x, y)
        known = at.known.get(key)
        if known is None:
            known = at.known[key] = f"r{self.fresh()}"
            call = f"{self._on_line('project', node.line)}, {x}, {y})"
            self.add(at, f"const tm_projection {known} = {call};", f"{known}")
        return f"{known}"

    # Formulas ---------------------------------------------------------------------------------------------------

    def formula(self, node: ir.Formula, block: Block) -> Value:
        """The C names of a formula's value; its statements are written where they belong."""
        home = self.home(self.free(node), block)
        known = home.known.get(node)
        if known is None:
            before, self._span = self._span, getattr(node, "span", None) or self._span
            known = home.known[node] = self._formula(node, home)
            self._span = before
        assert isinstance(known, Value)
        return known

    def _formula(self, node: ir.Formula, at: Block) -> Value:
        match node:
            case ir.Truth():
                pair = ("true", "TM_INF") if node.value else ("false", "(-TM_INF)")
                return Value(*pair, *pair)
            case ir.Flag():
                return self._flag(node, at)
            case ir.Compare():
                return self._compare(node, at)
            case ir.SweptInside() | ir.SweptClear() | ir.InArea():
                return self._geometry(node, at)
            case ir.Not():
                inner = self.formula(node.operand, at)
                return self.negated(inner, at)
            case ir.Connective():
                return self.connect(node.op, self.formula(node.left, at), self.formula(node.right, at), at)
            case ir.Quantify():
                return self.quantify([node], at)[0]
            case ir.Guarded():
                return self._guarded(node, at)
            case ir.Temporal() | ir.Until() | ir.Shift():
                from trackmarshal.backends.c.timelines import series

                slots = series(self, node, at)
                return self._read(slots, self.index(node.axis, at), at)
            case ir.First():
                first = at.open("")
                first.binds[node.axis] = "0u"
                return self._carried(self.formula(node.operand, first), at, first)
            case ir.OverRun() | ir.Counted():
                raise self.refuse(node, "generated C does not remember yet")
            case _:
                assert_never(node)

    def value(
        self, at: Block, worst_sat: str, worst_margin: str, best_sat: str = "", best_margin: str = ""
    ) -> Value:
        """Declare a value's names with these expressions; the best case only where there is a difference."""
        k = self.fresh()
        if self.known:
            self.add(at, f"const bool s{k} = {worst_sat};", f"s{k}")
            self.add(at, f"const double m{k} = {worst_margin};", f"m{k}")
            return Value(f"s{k}", f"m{k}", f"s{k}", f"m{k}")
        for name, kind, text in (
            ("ws", "bool", worst_sat),
            ("wm", "double", worst_margin),
            ("bs", "bool", best_sat),
            ("bm", "double", best_margin),
        ):
            assert text, "a value with two sides"
            self.add(at, f"const {kind} {name}{k} = {text};", f"{name}{k}")
        return Value(f"ws{k}", f"wm{k}", f"bs{k}", f"bm{k}")

    def _flag(self, node: ir.Flag, at: Block) -> Value:
        if node.axis is not None:
            text = self._column(node, at)
        else:
            source = self.plan.input(node.signal)
            text = (
                f"in->{source.c_name}"
                if source.kind == "event"
                else f"in->{source.c_name}.{self.plan.field_name(node.signal, node.field or '')}"
            )
            if (
                self.plan.spec.signals.get(node.signal) is not None
                and self.plan.spec.signals[node.signal].sequence
            ):
                text += "[0]" if node.offset == 0 else f"[in->{source.c_name}.count - 1u]"
        k = self.fresh()
        self.add(at, f"const tm_flag g{k} = {text};", f"g{k}")
        if self.known:
            self.add(at, f"suspect |= tm_missing(g{k});")
            return self.value(at, f"g{k} == TM_TRUE", f"(g{k} == TM_TRUE) ? TM_INF : -TM_INF")
        return self.value(
            at, f"g{k} == TM_TRUE", f"(g{k} == TM_TRUE) ? TM_INF : -TM_INF",
            f"g{k} != TM_FALSE", f"(g{k} != TM_FALSE) ? TM_INF : -TM_INF",
        )  # fmt: skip

    def _compare(self, node: ir.Compare, at: Block) -> Value:
        op, left, right = node.written  # the C reads as the rule does
        a, b = self.number(left, at), self.number(right, at)
        sides = (b, a) if node.turned else (a, b)
        apart, sat = margin(COMPARISONS[node.op].measure, *sides), f"{a} {op} {b}"
        if self.known:
            value = self.value(at, sat, apart)
            self.add(at, f"suspect |= tm_wild({value.worst_margin});")
            return value
        k = self.fresh()
        self.add(at, f"const bool k{k} = tm_finite({a}) && tm_finite({b});", f"k{k}")
        self.add(at, f"const double d{k} = {apart};", f"d{k}")
        return self.value(
            at, f"k{k} && ({sat})", f"k{k} ? d{k} : -TM_INF", f"!k{k} || ({sat})", f"k{k} ? d{k} : TM_INF"
        )

    def _geometry(self, node: ir.Geometry, at: Block) -> Value:
        args = ", ".join([self.number(arg, at) for arg in ir.operands(node) if isinstance(arg, ir.Num)])
        whole = at
        match node:
            case ir.SweptClear():
                self.libm |= {"sin", "cos", "sqrt"}
                bound = self.bounds.get(node, "TM_INF")
                text = f"tm_curved_clear({args}, {bound})" if node.bend else f"tm_swept_clear({args})"
            case ir.SweptInside():
                bound = self.bounds.get(node, "TM_INF")
                called = "tm_curved_inside" if node.bend else "tm_swept_inside"
                text = f"{called}({self._area(node.area)}, {args}, {bound})"
                if node in self.timelines:
                    whole, columns = self.timelines[node]
                    size = f"{self.number(node.length, whole)}, {self.number(node.width, whole)}"
                    text = f"tm_timeline_inside({self._area(node.area)}, {columns}, {size})"
            case ir.InArea():
                text = f"tm_in_area({self._area(node.area)}, {args})"
            case _:
                assert_never(node)
        k = self.fresh()
        self.add(whole, f"const double d{k} = {text};", f"d{k}")
        if self.known:
            self.add(whole, f"suspect |= tm_wild(d{k});")
            return self.value(at, f"d{k} >= 0.0", f"d{k}")
        self.add(at, f"const bool k{k} = d{k} == d{k};", f"k{k}")
        return self.value(
            at,
            f"k{k} && (d{k} >= 0.0)",
            f"k{k} ? d{k} : -TM_INF",
            f"!k{k} || (d{k} >= 0.0)",
            f"k{k} ? d{k} : TM_INF",
        )

    def _area(self, area: ir.Area) -> str:
        return f"c, &c->shapes.{self.plan.shape(area).c_name}"

    def negated(self, inner: Value, at: Block) -> Value:
        return self.value(
            at, f"!{inner.best_sat}", f"-{inner.best_margin}", f"!{inner.worst_sat}", f"-{inner.worst_margin}"
        )

    def connect(self, op: ConnectiveOp, a: Value, b: Value, at: Block) -> Value:
        match op:
            case "and":
                return self._extreme(Extreme.LEAST, a, b, at)
            case "or":
                return self._extreme(Extreme.GREATEST, a, b, at)
            case "xor":
                return self._differ(a, b, at)
            case "iff":
                return self.negated(self._differ(a, b, at), at)
            case _:
                assert_never(op)

    def _extreme(self, kind: Extreme, a: Value, b: Value, at: Block) -> Value:
        sign, pick = extreme(kind)
        texts = []
        for (x_sat, x_margin), (y_sat, y_margin) in zip(a.sides, b.sides):
            texts += [f"{x_sat} {sign} {y_sat}", f"{pick}({x_margin}, {y_margin})"]
        return self.value(at, *texts)

    def _differ(self, a: Value, b: Value, at: Block) -> Value:
        surely = f"({a.worst_sat} && !{b.best_sat}) || ({b.worst_sat} && !{a.best_sat})"
        surely_not = f"({a.worst_sat} && {b.worst_sat}) || !({a.best_sat} || {b.best_sat})"
        apart = f"tm_greatest(tm_greatest(0.0, tm_apart({a.worst_margin}, {b.best_margin})), tm_apart({b.worst_margin}, {a.best_margin}))"
        at_most = f"tm_greatest(tm_apart({a.best_margin}, {b.worst_margin}), tm_apart({b.best_margin}, {a.worst_margin}))"
        return self.value(at, surely, apart, f"!({surely_not})", at_most)

    def _guarded(self, node: ir.Guarded, at: Block) -> Value:
        guard, body = self.formula(node.guard, at), self.formula(node.body, at)
        return self.value(
            at, f"!{guard.best_sat} || {body.worst_sat}", f"{guard.best_sat} ? {body.worst_margin} : TM_INF",
            f"!{guard.worst_sat} || {body.best_sat}", f"{guard.worst_sat} ? {body.best_margin} : TM_INF",
        )  # fmt: skip

    def quantify(
        self, nodes: list[ir.Quantify], at: Block, owners: Sequence[RuleInfo] | None = None
    ) -> list[Value]:
        """Quantifiers over one axis, in one loop; of several rules, where `owners` says whose each is."""
        axis = nodes[0].axis
        numbers = [self.fresh() for _ in nodes]
        names = (("s", "m"),) if self.known else (("ws", "wm"), ("bs", "bm"))
        for node, k in zip(nodes, numbers):
            holds, least = neutral(node.extreme)
            for s, m in names:
                self.add(at, f"bool {s}{k} = {holds};", f"{s}{k}")
                self.add(at, f"double {m}{k} = {least};", f"{m}{k}")
        i, total = f"i{self.fresh()}", f"t{self.fresh()}"
        self.add(at, f"const size_t {total} = {self.count(axis)};", total)
        loop = at.open(f"for (size_t {i} = 0u; {i} < {total}; ++{i})")
        loop.binds[axis] = i
        for place, (node, k) in enumerate(zip(nodes, numbers)):
            if owners is not None:
                self.rule, self._span = owners[place], owners[place].span
            guard = None if node.guard is None else self.formula(node.guard, loop)
            every = node.extreme is Extreme.LEAST
            if (
                self.known
                and every
                and isinstance(node.body, ir.Geometry)
                and axis in self.free(node.body)  # else it is computed ahead of the loop, once
                and self._once(node.body)
            ):
                # The least margin is asked for: one that is greater than the least so far need not be exact.
                self.bounds[node.body] = f"m{k}"
                sized = node.body if isinstance(node.body, ir.SweptInside) else None
                free = frozenset() if sized is None else self.free(sized.length) | self.free(sized.width)
                fields = along_timeline(node.body, axis, free)
                if guard is None and fields:
                    start = f"in->{self.plan.input(axis.signal).c_name}"
                    columns = [f"{start}.{self.plan.field_name(axis.signal, name)}" for name in fields]
                    if len(columns) == 3:
                        columns.append("NULL")  # straight
                    self.timelines[node.body] = at, f"{', '.join(columns)}, {total}"
            body = self.formula(node.body, loop)
            sign, pick = extreme(node.extreme)
            for side, (s, m) in enumerate(names):
                condition = ""
                if guard is not None:
                    # In the worst case all that may be in range counts against a `for all`: its guard's best side.
                    condition = guard.sides[1 - side if every else side][0]
                body_sat, body_margin = body.sides[side]
                new_sat, new_margin = f"{s}{k} {sign} {body_sat}", f"{pick}({m}{k}, {body_margin})"
                if condition:
                    new_sat, new_margin = (
                        f"{condition} ? ({new_sat}) : {s}{k}",
                        f"{condition} ? {new_margin} : {m}{k}",
                    )
                self.add(loop, f"{s}{k} = {new_sat};", f"{s}{k}")
                self.add(loop, f"{m}{k} = {new_margin};", f"{m}{k}")
        at.close(loop)
        result = []
        for k in numbers:
            (ws, wm), (bs, bm) = names[0], names[-1]
            result.append(Value(f"{ws}{k}", f"{wm}{k}", f"{bs}{k}", f"{bm}{k}"))
        return result

    def _once(self, formula: ir.Formula) -> bool:
        """Whether a formula stands in the rule only once."""
        places = [root for root in (self.rule.formula, self.rule.active) if root is not None]
        parents = {
            node
            for root in places
            for node in ir.below(root)
            if any(child is formula for child in node.children())
        }
        return len(parents) == 1

    def _carried(self, inner: Value, at: Block, block: Block) -> Value:
        """Carry a value out of an inner block into names of the outer one, declared before it."""
        k = self.fresh()
        names = [("s", "m")] if self.known else [("ws", "wm"), ("bs", "bm")]
        for s, m in names:
            self.add(at, f"bool {s}{k} = false;", f"{s}{k}")
            self.add(at, f"double {m}{k} = 0.0;", f"{m}{k}")
        at.close(block)
        for side, (s, m) in enumerate(names):
            self.add(block, f"{s}{k} = {inner.sides[side][0]};", f"{s}{k}")
            self.add(block, f"{m}{k} = {inner.sides[side][1]};", f"{m}{k}")
        (ws, wm), (bs, bm) = names[0], names[-1]
        return Value(f"{ws}{k}", f"{wm}{k}", f"{bs}{k}", f"{bm}{k}")

    def _read(self, slots: tuple[int, ...], index: str, at: Block) -> Value:
        """The value at one sample of a series kept in the context."""
        texts = []
        for slot in slots:
            texts += [f"c->series[{mark(slot)}].sat[{index}]", f"c->series[{mark(slot)}].margin[{index}]"]
        return self.value(at, *texts)
