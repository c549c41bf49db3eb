"""The inputs of a demand as its author thinks of them: fields, and whatever is measured and has a name, such as `gap_lon(o)`.

A coordinate says nothing by itself, and a line cannot be put on an axis. So what is read off a line or a place, or made of more than three
inputs, is one input by the name that it has: that of a `let`, or of the definition in which it is written. A `let` of such an input is one itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, assert_never

from trackmarshal import typed
from trackmarshal.ir import nodes as ir
from trackmarshal.lowering.expressions import Lowering
from trackmarshal.reading.formulas import Formulas
from trackmarshal.reading.terminal import text
from trackmarshal.units import Dimension, show

#: Why a demand has no drawing.
Reason = Literal[
    "geometry", "truth", "member", "many", "memory", "timeline", "decision", "none", "unmonitored"
]
#: Of how many inputs a named number is at most that are shown in its place.
_FEW = 3
#: The fields of a place.
_COORDINATES = ("x", "y")


class Undrawable(Exception):
    """A demand of which no drawing would say anything."""

    def __init__(self, reason: Reason) -> None:
        super().__init__(reason)
        self.reason: Reason = reason


class Quantity:
    """One input of a demand: its core, what it is called, and by which names it can be asked for. field: the signal and the field that it is, if any."""

    def __init__(self, node: ir.Num, label: str, names: tuple[str, ...], dimension: Dimension, field: tuple[str, str] = ("", "")) -> None:  # fmt: skip
        self.node, self.label, self.names, self.dimension, self.field = node, label, names, dimension, field

    @property
    def unit(self) -> str:
        """In SI."""
        return show(self.dimension)


class _Raw(Exception):
    """A number that cannot be an input by itself, and why; `depth` is that of the text in which it stands: 0 in the rule, 1 in a definition called there."""

    def __init__(self, depth: int, reason: Reason = "geometry") -> None:
        super().__init__(depth)
        self.depth, self.reason = depth, reason


def quantities(rule: typed.Rule, lowering: Lowering) -> list[Quantity]:
    """The inputs of what a rule requires, in the order in which they are written. Raises Undrawable.

    lowering: one that has made the core of the rule's clauses.
    """
    if any(isinstance(clause, typed.Deadline) for clause in rule.clauses):
        raise Undrawable("memory")
    found = _Opening(lowering)
    for number in _compared(rule.condition):
        found.open(number)
    if not found.made:
        raise Undrawable("none")
    return list(found.made.values())


def _compared(node: typed.Formula) -> Iterator[typed.Number]:
    """The numbers that a formula compares. Raises Undrawable for whatever else it asks."""
    match node:
        case typed.Comparison():
            yield from (node.left, node.right)
        case typed.Chained():
            yield from node.operands
        case typed.Within():
            yield from (node.value, node.lower, node.upper)
        case typed.Connective():
            yield from _compared(node.left)
            yield from _compared(node.right)
        case typed.Not():
            yield from _compared(node.operand)
        case typed.CalledFormula():
            yield from _compared(node.body)
        case typed.NamedFormula():
            yield from _compared(node.value)
        case typed.Boolean():
            return
        case typed.Event() | typed.BooleanField():
            raise Undrawable("truth")
        case typed.InZone() | typed.InStretch() | typed.Inside() | typed.Meets() | typed.ClearOf():
            raise Undrawable("geometry")
        case typed.IsMember() | typed.FormulaCase():
            raise Undrawable("member")
        case typed.InState():
            raise Undrawable("memory")
        case typed.Quantified():
            raise Undrawable("many")
        case typed.Temporal() | typed.Until() | typed.Step() | typed.Edge():
            raise Undrawable("memory" if isinstance(node.axis, typed.TheRun) else "timeline")
        case typed.CountComparison():
            raise Undrawable("memory" if isinstance(node.count.axis, typed.TheRun) else "timeline")
        case _:
            assert_never(node)


class _Opening:
    """Opens numbers down to their inputs, and takes what cannot be opened for one, by its name."""

    def __init__(self, lowering: Lowering) -> None:
        self._lowering = lowering
        self._writing = Formulas()
        #: By the core: equal numbers are one input, wherever they stand.
        self.made: dict[ir.Num, Quantity] = {}
        #: Whether whatever has a name may be taken whole, and what is read off a line by itself.
        self._lenient = False
        #: The inputs of what has a name in the rule, by its place in memory: in a chain of lets that use the one before twice, looked for once for each.
        self._bound: dict[tuple[int, int, bool], dict[ir.Num, Quantity]] = {}

    def open(self, number: typed.Number) -> None:
        """Take in the inputs of one side of a comparison."""
        try:
            found = self._inputs(number, 0)
        except _Raw:
            self._lenient = True
            try:
                found = self._inputs(number, 0)
            except _Raw as raw:
                raise Undrawable(raw.reason) from None
            finally:
                self._lenient = False
        self.made |= {node: one for node, one in found.items() if node not in self.made}

    def _inputs(self, node: typed.Number, depth: int) -> dict[ir.Num, Quantity]:
        match node:
            case typed.Literally() | typed.Pi() | typed.Parameter():
                return {}
            case typed.Field():
                return self._field(node, depth)
            case typed.Negative():
                return self._inputs(node.operand, depth)
            case typed.Arithmetic():
                return self._all((node.left, node.right), depth)
            case typed.Power():
                return self._all((node.base, node.exponent), depth)
            case typed.Function():
                return self._all(node.arguments, depth)
            case typed.TableValue():
                return self._all(node.arguments, depth)
            case typed.Choice():
                return self._all((*self._asked(node.condition, depth), node.then, node.otherwise), depth)
            case typed.CalledNumber():
                return self._called(node, depth)
            case typed.NamedNumber():
                if node.value is None:
                    raise _Raw(depth)
                if depth:  # given to a definition: it stands in the text that calls it
                    return self._inputs(node.value, depth - 1)
                key = id(node.value), depth, self._lenient
                if key not in self._bound:
                    self._bound[key] = self._or_whole(node, node.value, (node.name,), depth, depth)
                return self._bound[key]
            case typed.OnLine() | typed.StationGap():
                if self._lenient:
                    return self._whole(node, (), depth)
                raise _Raw(depth)
            case typed.NumberCase():
                raise _Raw(depth, "member")
            case typed.Folded():
                raise _Raw(depth, "many")
            case typed.Kept():
                raise _Raw(depth, "memory")
            case _:
                assert_never(node)

    def _all(self, nodes: tuple[typed.Number, ...], depth: int) -> dict[ir.Num, Quantity]:
        found: dict[ir.Num, Quantity] = {}
        for node in nodes:
            found |= {core: one for core, one in self._inputs(node, depth).items() if core not in found}
        return found

    def _asked(self, condition: typed.Formula, depth: int) -> tuple[typed.Number, ...]:
        """The numbers by which a choice is made."""
        try:
            return tuple(_compared(condition))
        except Undrawable as why:
            raise _Raw(depth, why.reason) from None

    def _field(self, node: typed.Field, depth: int) -> dict[ir.Num, Quantity]:
        record = node.record
        while isinstance(record, typed.NamedRecord) and record.value is not None:
            record = record.value
        if isinstance(record, typed.ParameterRecord):
            return {}
        signal = record.signal
        if signal is None or (node.name in _COORDINATES and set(_COORDINATES) <= set(record.shape)):
            raise _Raw(depth)
        match record:
            case typed.State():
                of = record.signal.name
            case typed.Variable():
                of = record.name
            case typed.Sample():
                of = f"{record.signal.name}.{'first' if record.index == 0 else 'last'}"
            case typed.NamedRecord():
                raise _Raw(depth)
            case _:
                assert_never(record)
        core, label = self._lowering.number(node), f"{of}.{node.name}"
        return {core: Quantity(core, label, (node.name, label), node.dimension, (signal.name, node.name))}

    def _called(self, node: typed.CalledNumber, depth: int) -> dict[ir.Num, Quantity]:
        return self._or_whole(node, node.body, (node.symbol.name,), depth, depth + 1)

    def _or_whole(
        self, node: typed.CalledNumber | typed.NamedNumber, value: typed.Number, names: tuple[str, ...], depth: int, inner: int
    ) -> dict[ir.Num, Quantity]:  # fmt: skip
        """The inputs of something with a name, where they are few; itself where they are many, or what its own text reads is none."""
        try:
            found = self._inputs(value, inner)
        except _Raw as raw:
            if raw.depth < inner and not self._lenient:
                raise
            return self._whole(node, names, depth)
        measured = isinstance(node, typed.NamedNumber) and not all(one.field[0] for one in found.values())
        return self._whole(node, names, depth) if measured or len(found) > _FEW else found

    def _whole(self, node: typed.Number, names: tuple[str, ...], depth: int) -> dict[ir.Num, Quantity]:
        core = self._lowering.number(node)
        self._writing.inside = depth  # in a definition, what was given to it stands for its names
        label = text(self._writing.number(node))
        return {core: Quantity(core, label, (*names, label), node.dimension)}
