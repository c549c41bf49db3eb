"""The typed tree to layouts: terms in the order written, with the parentheses that the order of operations takes, and no others.

Definitions are called by their names, or written out (`expand`): then what is given to them stands in their place, and a variable that
they bind gets a prime where another one has its name.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import assert_never

from trackmarshal import typed
from trackmarshal.errors import TrackmarshalError
from trackmarshal.reading import layout as at
from trackmarshal.reading.layout import Layout, listed
from trackmarshal.reading.names import Kind, layout
from trackmarshal.reading.things import Things
from trackmarshal.syntax import ast

#: How tightly pieces hold together: what is looser than its place asks for stands in parentheses.
OPEN, IMPLIED, EITHER, BOTH, DENIED, COMPARED, SUM, PRODUCT, SIGNED, RAISED, WHOLE = range(11)
_COMPARING: dict[typed.Comparing, str] = {"<": "<", "<=": "≤", ">": ">", ">=": "≥", "==": "=", "!=": "≠"}
_JOINING: dict[typed.Joining, tuple[str, int]] = {
    "and": ("∧", BOTH), "or": ("∨", EITHER), "implies": ("⇒", IMPLIED), "iff": ("⇔", IMPLIED), "xor": ("⊕", IMPLIED),
}  # fmt: skip
#: The most nodes that a formula is written out to.
MOST = 20_000

CODES = {
    "E490": (
        "a formula too long to be written out",
        "With its definitions in their places, the rule has more than 20,000 parts: definitions that call each other twice grow without end. "
        "Without --expand, they are called by their names and listed below.",
    ),
}


class Formulas(Things):
    """Writes the numbers and formulas of one rule; expand: definitions are written out."""

    def __init__(self, expand: bool = False) -> None:
        super().__init__(expand)
        self._parts = 0

    # What holds how tightly ----------------------------------------------------------------------------------

    def number(self, node: typed.Number, least: int = OPEN) -> Layout:
        """A number; `least`: in parentheses, where it holds together less than this."""
        made, level = self._number(node)
        return made if level >= least else at.Fence("(", made)

    def formula(self, node: typed.Formula, least: int = OPEN) -> Layout:
        """A formula, likewise."""
        made, level = self._formula(node)
        return made if level >= least else at.Fence("(", made)

    def _number(self, node: typed.Number) -> tuple[Layout, int]:
        self._count(node)
        match node:
            case typed.Literally():
                # The square of 2 m is no 2 m².
                return at.Digits(node.text, node.unit), RAISED if node.unit else WHOLE
            case typed.Pi():
                return at.Name("π"), WHOLE
            case typed.Parameter():
                return self._parameter(node), WHOLE
            case typed.Field():
                return self.field(node.record, node.name), WHOLE
            case typed.Negative():
                return at.Prefix(at.Sign("−"), self.number(node.operand, RAISED)), SIGNED
            case typed.Arithmetic():
                return self._arithmetic(node)
            case typed.Power():
                return at.Power(self.number(node.base, WHOLE), self.number(node.exponent)), RAISED
            case typed.Function():
                return self._function(node)
            case typed.Choice():
                return self._choice(node), OPEN
            case typed.NumberCase():
                branches = [(one.members, one.rest, self.number(one.value)) for one in node.branches]
                return self._case(node.subject, branches), OPEN
            case typed.TableValue():
                head = self.named("table", node.symbol)
                return at.Call(head, tuple(self.number(one) for one in node.arguments)), WHOLE
            case typed.OnLine():
                point = self.record(node.point)
                return at.Call(at.Word(node.function), (point, self.line(node.line))), WHOLE
            case typed.StationGap():
                ends = self.number(node.start), self.number(node.end)
                return at.Call(at.Word("station_gap"), (self.line(node.line), *ends)), WHOLE
            case typed.Folded():
                return self._folded(node)
            case typed.Kept():
                asked = self.machine(node.machine)
                if not node.name:
                    return at.Call(at.Word("time_in"), (asked,)), WHOLE
                return at.Index(layout(node.name), asked), WHOLE
            case typed.CalledNumber():
                if self.expand:
                    with self.entered():
                        return self._number(node.body)
                return self._called(node, "function")
            case typed.NamedNumber():
                if not self.inside or node.value is None:
                    return self.local(node.name), WHOLE
                with self.left():
                    return self._number(node.value)
            case _:
                assert_never(node)

    def _formula(self, node: typed.Formula) -> tuple[Layout, int]:
        self._count(node)
        match node:
            case typed.Boolean():
                return at.Word("true" if node.value else "false"), WHOLE
            case typed.Event():
                return self.named("event", node.symbol), WHOLE
            case typed.BooleanField():
                return self.field(node.record, node.name), WHOLE
            case typed.Comparison():
                return self._compared((node.left, node.right), (node.op,))
            case typed.Chained():
                return self._compared(node.operands, node.ops)
            case typed.Within():
                ends = at.Row((self.number(node.lower), at.Sign(","), self.number(node.upper)))
                return self._chain(self.number(node.value, SUM), "∈", at.Fence("[", ends))
            case typed.InZone():
                zone = at.Row((at.Word("zone "), self.named("place", node.zone.symbol)))
                return self._chain(self.record(node.point), "∈", zone)
            case typed.InStretch():
                return self._chain(self._place(node.place), "∈", self._stretch(node))
            case typed.Inside():
                return self._chain(self.region(node.region), "⊆", self.area(node.area))
            case typed.Meets():
                return self._chain(self.region(node.region), at.Word("meets"), self.area(node.area))
            case typed.ClearOf():
                return self._chain(self.region(node.region), at.Word("clear of"), self.region(node.other))
            case typed.IsMember():
                return self._chain(self.member(node.left), "=", self.member(node.right))
            case typed.InState():
                state = self.names.of("state", node.state, node.state)
                return self._chain(self.machine(node.machine), "=", state)
            case typed.FormulaCase():
                branches = [(one.members, one.rest, self.formula(one.value)) for one in node.branches]
                return self._case(node.subject, branches), OPEN
            case typed.Not():
                return at.Prefix(at.Sign("¬"), self._operand(node.operand)), DENIED
            case typed.Connective():
                return self._connective(node)
            case typed.Quantified():
                return self._quantified(node), OPEN
            case typed.Temporal():
                return at.Prefix(self._timed(node.op, node.window), self._operand(node.operand)), DENIED
            case typed.Until():
                left, right = self._operand(node.left), self._operand(node.right)
                return at.Chain(left, (at.Joined(self._timed(node.op, node.window), right),), True), IMPLIED
            case typed.Step():
                word = at.Word(f"weak {node.op}" if node.weak else node.op)
                return at.Prefix(word, self._operand(node.operand)), DENIED
            case typed.Edge():
                return at.Call(at.Word(node.op), (self.formula(node.operand),)), WHOLE
            case typed.CountComparison():
                return self._count_compared(node)
            case typed.CalledFormula():
                if self.expand:
                    with self.entered():
                        return self._formula(node.body)
                return self._called(node, "predicate")
            case typed.NamedFormula():
                if not self.inside or node.value is None:
                    return self.local(node.name), WHOLE
                with self.left():
                    return self._formula(node.value)
            case _:
                assert_never(node)

    def _operand(self, node: typed.Formula) -> Layout:
        """What stands after a sign alone: comparisons too are in parentheses, as not everybody knows which one comes first."""
        made, level = self._formula(node)
        return at.Fence("(", made) if level < DENIED or level == COMPARED else made

    def _count(self, node: typed.Typed) -> None:
        self._parts += 1
        if self._parts > MOST:
            span = node.__dict__["span"]
            raise TrackmarshalError(
                "E490", f"with its definitions in their places, the formula has more than {MOST} parts",
                file=str(span.file.path), line=span.line, help="leave out --expand: definitions are then called by their names",
            )  # fmt: skip

    # Numbers ------------------------------------------------------------------------------------------------

    def _arithmetic(self, node: typed.Arithmetic) -> tuple[Layout, int]:
        match node.op:
            case "+" | "-":
                right = self._right(node.right, PRODUCT)
                return _continued(
                    self.number(node.left, SUM), "+" if node.op == "+" else "−", right, ("+", "−")
                ), SUM
            case "*":
                right = self._right(node.right, RAISED)
                return _continued(self.number(node.left, PRODUCT), "·", right, ("·",)), PRODUCT
            case "/":
                return at.Fraction(self.number(node.left), self.number(node.right)), RAISED
            case _:
                assert_never(node.op)

    def _right(self, node: typed.Number, least: int) -> Layout:
        """What follows a sign: one with a minus of its own stands in parentheses."""
        made = self.number(node, least)
        first = made.first if isinstance(made, at.Chain) else made
        return at.Fence("(", made) if isinstance(first, at.Prefix) else made

    def _function(self, node: typed.Function) -> tuple[Layout, int]:
        arguments = tuple(self.number(one) for one in node.arguments)
        match node.name:
            case "abs":
                return at.Fence("|", arguments[0]), WHOLE
            case "floor":
                return at.Fence("⌊", arguments[0]), WHOLE
            case "ceil":
                return at.Fence("⌈", arguments[0]), WHOLE
            case "sqrt":
                return at.Root(arguments[0]), WHOLE
            case (
                "sign" | "hypot" | "round" | "min" | "max" | "pow" | "exp" | "log" | "sin" | "cos" | "tan" | "asin" | "acos"
                | "atan2" | "tanh"
            ):  # fmt: skip
                return at.Call(at.Word(node.name), arguments), WHOLE
            case _:
                assert_never(node.name)

    def _choice(self, node: typed.Choice) -> Layout:
        """`if .. else if ..`: one row each."""
        branches = [at.Branch(self.number(node.then), self.formula(node.condition))]
        other = node.otherwise
        while isinstance(other, typed.Choice):
            self._count(other)
            branches.append(at.Branch(self.number(other.then), self.formula(other.condition)))
            other = other.otherwise
        return at.Branches((*branches, at.Branch(self.number(other), None)))

    def _case(
        self, subject: typed.AnyMember, branches: Sequence[tuple[tuple[str, ...], bool, Layout]]
    ) -> Layout:
        """A row for each branch; the one for all the others says which these are."""
        asked = self.member(subject)
        rows = []
        for members, _, value in branches:
            named = [self.names.of("member", one, one) for one in members]
            if len(named) == 1:
                condition: Layout = at.Chain(asked, (at.Joined(at.Sign("="), named[0]),))
            else:
                among = at.Fence("{", listed(named))
                condition = at.Chain(asked, (at.Joined(at.Sign("∈"), among),))
            rows.append(at.Branch(value, condition))
        return at.Branches(tuple(rows))

    def _folded(self, node: typed.Folded) -> tuple[Layout, int]:
        with self.binding(node.range):
            below = self._ranged(node.range, node.where)
            body = None if node.body is None else self.number(node.body, PRODUCT)
        head: at.Sign | at.Word = (
            at.Sign("∑") if node.op == "sum" else at.Word("#" if node.op == "count" else node.op)
        )
        fold = at.Fold(head, below, body)
        if node.otherwise is None:
            return fold, SUM if body is not None else WHOLE
        found = at.Branch(fold, at.Word("there is any"))
        return at.Branches((found, at.Branch(self.number(node.otherwise), None))), OPEN

    # Formulas -----------------------------------------------------------------------------------------------

    def _compared(
        self, operands: Sequence[typed.Number], ops: Sequence[typed.Comparing]
    ) -> tuple[Layout, int]:
        first, *others = [self.number(one, SUM) for one in operands]
        rest = tuple(at.Joined(at.Sign(_COMPARING[op]), other) for op, other in zip(ops, others))
        return at.Chain(first, rest), COMPARED

    def _chain(self, left: Layout, sign: str | at.Word, right: Layout) -> tuple[Layout, int]:
        shown = at.Sign(sign) if isinstance(sign, str) else sign
        return at.Chain(left, (at.Joined(shown, right),)), COMPARED

    def _connective(self, node: typed.Connective) -> tuple[Layout, int]:
        sign, level = _JOINING[node.op]
        if level == IMPLIED:
            left, right = self.formula(node.left, IMPLIED + 1), self.formula(node.right, IMPLIED + 1)
            return at.Chain(left, (at.Joined(at.Sign(sign), right),), True), level
        right = self.formula(node.right, level + 1)
        return _continued(self.formula(node.left, level), sign, right, (sign,), True), level

    def _ranged(self, range_: typed.Range, where: typed.Formula | None) -> Layout:
        ranged = self.ranged(range_)
        if where is None:
            return ranged
        return at.Row((ranged, at.Sign(":"), self.formula(where, IMPLIED)))

    def ranged(self, range_: typed.Range) -> Layout:
        """`p ∈ plan`, `consecutive p, q ∈ plan`."""
        names = listed([at.Name(self.variable(range_, offset)) for offset in range(len(range_.names))])
        first: Layout = at.Row((at.Word("consecutive "), names)) if len(range_.names) > 1 else names
        return at.Chain(first, (at.Joined(at.Sign("∈"), self.signal(range_.domain)),))

    def quantifier(self, quantifier: str, range_: typed.Range, by: typed.Number | None) -> Layout:
        """`∀ p ∈ plan`, `∃ nearest o ∈ objects by d`."""
        sign, ranged = at.Sign("∀" if quantifier == "for all" else "∃"), self.ranged(range_)
        if by is None:
            return at.Row((sign, ranged))
        return at.Row((sign, at.Word("nearest "), ranged, at.Word(" by "), self.number(by, SUM)))

    def _quantified(self, node: typed.Quantified) -> Layout:
        with self.binding(node.range):
            head = self.quantifier(node.quantifier, node.range, node.by)
            where = None if node.where is None else self.formula(node.where, IMPLIED)
            return at.Binder(head, where, self.formula(node.body))

    def window(self, window: typed.Window) -> Layout:
        """`[0 s, 0.5 s]`."""
        return at.Fence("[", at.Row((self.number(window.lower), at.Sign(","), self.number(window.upper))))

    def _timed(self, op: str, window: typed.Window | None) -> at.Word | at.Index:
        return at.Word(op) if window is None else at.Index(at.Word(op), self.window(window))

    def _count_compared(self, node: typed.CountComparison) -> tuple[Layout, int]:
        count = node.count
        arguments: list[Layout] = [self.formula(count.counted)]
        if count.window is not None:
            arguments.append(at.Row((at.Word("last: "), self.number(count.window.upper))))
        if count.reset is not None:
            arguments.append(at.Row((at.Word("reset: "), self.formula(count.reset))))
        counted, limit = at.Call(at.Word("count"), tuple(arguments)), self.number(node.limit, SUM)
        left, right = (limit, counted) if node.turned else (counted, limit)
        return at.Chain(left, (at.Joined(at.Sign(_COMPARING[node.op]), right),)), COMPARED

    # Calls --------------------------------------------------------------------------------------------------

    def _parameter(self, node: typed.Parameter) -> Layout:
        if node.record is not None:
            return self._setting(node.record, node.symbol)
        return self.named("parameter", node.symbol)

    def _setting(self, record: typed.Record, symbol: typed.Symbol) -> Layout:
        """A field of a record of parameters: by the record's name, or by the one that it is given to."""
        name = symbol.qualified.rpartition(".")[2]
        if not isinstance(record, typed.NamedRecord):
            assert isinstance(symbol.item, ast.ParamRecord)
            return self.names.of("parameter", symbol.qualified, f"{symbol.item.name}.{name}")
        if not self.inside or record.value is None:
            return self.field(record, name)
        with self.left():
            return self._setting(record.value, symbol)

    def _called(self, node: typed.CalledNumber | typed.CalledFormula, kind: Kind) -> tuple[Layout, int]:
        head = self.named(kind, node.symbol)
        if node.infix:
            left, right = [self.value(one) for one in node.arguments]
            name = head if isinstance(head, at.Name) else at.Name(node.symbol.name)
            return at.Chain(left, (at.Joined(at.Word(name.text), right),)), COMPARED
        item = node.symbol.item
        assert isinstance(item, ast.Define)
        if not item.parameters:
            return head, WHOLE
        return at.Call(head, tuple(map(self.value, node.arguments))), WHOLE

    def value(self, node: typed.Value) -> Layout:
        """Anything that is given to a definition."""
        match node:
            case typed.NumberNode():
                return self.number(node)
            case typed.FormulaNode():
                return self.formula(node)
            case typed.Count():
                raise AssertionError("a count is compared, and given to nothing")
            case typed.SignalNode():
                return self.signal(node)
            case typed.RecordNode():
                return self.record(node)
            case typed.MemberNode():
                return self.member(node)
            case typed.LineNode():
                return self.line(node)
            case typed.AreaNode():
                return self.area(node)
            case typed.RegionNode():
                return self.region(node)
            case _:
                assert_never(node)

    def _place(self, node: typed.Record | typed.Number) -> Layout:
        return self.record(node) if isinstance(node, typed.RecordNode) else self.number(node, SUM)

    def _stretch(self, node: typed.InStretch) -> Layout:
        if node.symbol is not None and not self.expand:
            return at.Row((at.Word("stretch "), self.named("place", node.symbol)))
        return self.ends(node)

    def ends(self, node: typed.InStretch) -> Layout:
        """`stretch(track, 4900 m, 120 m)`, also of one that goes by a name."""
        ends = self.number(node.start), self.number(node.end)
        return at.Call(at.Word("stretch"), (self.line(node.line), *ends))


def _continued(left: Layout, sign: str, right: Layout, signs: Sequence[str], logic: bool = False) -> at.Chain:
    """A chain with one more term: what is read from the left is one chain."""
    joined = at.Joined(at.Sign(sign), right)
    if isinstance(left, at.Chain) and all(
        isinstance(one.sign, at.Sign) and one.sign.text in signs for one in left.rest
    ):
        return at.Chain(left.first, (*left.rest, joined), logic)
    return at.Chain(left, (joined,), logic)
