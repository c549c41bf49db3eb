"""What a rule requires of one thing that it is about, as a demand on a few numbers: on any values of these, an evaluator says whether it is met."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.backends.numpy.sharing import representatives
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.interning import Interner
from trackmarshal.ir.margins import SCALED
from trackmarshal.ir.reads import reads
from trackmarshal.ir.spec import RuleInfo, Spec, remembers
from trackmarshal.lowering.expressions import Lowering
from trackmarshal.lowering.rules import clauses
from trackmarshal.reading.drawing.quantities import Quantity, Undrawable, quantities
from trackmarshal.runtime.frame import NO_SETTINGS, Columns, Frame, Names, Settings
from trackmarshal.units import parse_unit

N = TypeVar("N", bound=ir.IR)
Floats = NDArray[np.float64]
Codes = NDArray[np.uint8]
#: What a demand comes to.
HOLDS, BROKEN, UNKNOWN = 0, 1, 2
#: The set whose elements have the inputs as fields; no signal of a spec has a space in its name.
_DRAWN = "the drawn"


class Demand:
    """A rule's `require`, by itself. Raises Undrawable.

    levels: the clauses that it stands under, outermost first. body: its core, on what cases say. quantities: its inputs, of which `judge` is given
    values. params: parameters, by qualified names, that are inputs too; KeyError for one that the rule does not read.
    """

    def __init__(self, rule: RuleInfo, spec: Spec, params: Sequence[str] = ()) -> None:
        if rule.typed is None or rule.formula is None:
            raise Undrawable("unmonitored")
        if remembers(rule) or rule.course is not None:
            raise Undrawable("memory")
        self.rule, self.spec, self.added = rule, spec, tuple(params)
        self.lowering = Lowering(Interner(), dict(spec.scales) if rule.unit == SCALED else None)
        self.levels, self.body = clauses(rule.typed, self.lowering)
        found: list[Quantity] = quantities(rule.typed, self.lowering)
        found += [self._param(name) for name in params]
        # A number is another node wherever a condition stands in it, as messages about that have another place.
        nodes = ir.ordered([*(one.node for one in found), self.body])
        alike = representatives(nodes)
        inputs = {alike[one.node]: one for one in reversed(found)}
        self.quantities = [one for one in found if inputs[alike[one.node]] is one]
        self._fields = tuple(f"q{number}" for number in range(len(self.quantities)))
        axis = self.lowering.make(ir.Axis, _DRAWN, "elements", 1, 0, 0, None)
        given = {
            inputs[alike[one.node]]: self.lowering.make(ir.Column, axis, field)
            for one, field in zip(self.quantities, self._fields)
        }
        self._alone: ir.Formula = replaced(
            self.body, {node: given[inputs[alike[node]]] for node in nodes if alike[node] in inputs}
        )
        left = {signal for signal, _ in reads(self._alone)} - {_DRAWN}
        if left:
            raise AssertionError(
                f"what `{rule.name}` requires reads more than its inputs: {', '.join(sorted(left))}"
            )
        self._numpy = NumpyProgram(spec, [], [self._alone])

    @property
    def params(self) -> list[str]:
        """The parameters that it reads, by qualified names, in order of these."""
        return sorted({node.name for node in ir.below(self.body) if isinstance(node, ir.Param)})

    def exact(self, axes: Sequence[int]) -> bool:
        """Whether it asks for one of these inputs to be the same as something, which is so, or not so, on a line that no cell is as thin as."""
        drawn = {self._fields[number] for number in axes}
        same = (node for node in ir.below(self._alone) if isinstance(node, ir.Compare) and node.op in ("==", "!="))  # fmt: skip
        return any(isinstance(part, ir.Column) and part.field in drawn for node in same for part in ir.below(node))  # fmt: skip

    def _param(self, name: str) -> Quantity:
        info = self.spec.params[name]
        if name not in self.params:
            raise KeyError(name)
        core = self.lowering.make(ir.Param, name)
        return Quantity(core, info.short, (info.short, name), parse_unit(info.unit)[2], ("", name))

    def judge(self, values: Sequence[Floats], settings: Settings = NO_SETTINGS) -> tuple[Codes, Floats]:
        """What it comes to at n values of each input, in SI: (n,) codes, and (n,) margins in SI, NaN where unknown.

        settings: parameters and tables in place of the spec's.
        """
        size = len(values[0])
        if not size:
            return np.zeros(0, dtype=np.uint8), np.zeros(0)
        side = self._numpy.run([self._frame(values, settings)]).of(self._alone)
        return outcome(*(np.broadcast_to(np.ravel(one), size) for one in _sides(side)))

    def reference(self, values: Sequence[float], settings: Settings = NO_SETTINGS) -> int:
        """What the reference evaluator says at one value of each input."""
        frame = self._frame([np.array([value]) for value in values], settings)
        verdict = Reference(self.spec, frame).truth(self._alone, {0: 0}).verdict
        return {"satisfied": HOLDS, "violated": BROKEN, "undefined": UNKNOWN}[verdict]

    def _frame(self, values: Sequence[Floats], settings: Settings) -> Frame:
        columns = Columns(Names(self._fields), np.array(values, dtype=np.float64))
        return Frame(settings=settings, columns={_DRAWN: columns})


def _sides(value: Any) -> tuple[Any, Any, Any, Any]:
    return value.worst.sat, value.worst.margin, value.best.sat, value.best.margin


def outcome(worst_sat: Any, worst: Any, best_sat: Any, best: Any) -> tuple[Codes, Floats]:
    """Codes and margins of a formula's two sides, which are arrays of one shape."""
    codes = np.where(worst_sat, HOLDS, np.where(best_sat, UNKNOWN, BROKEN)).astype(np.uint8)
    return codes, np.where(worst_sat, worst, np.where(best_sat, np.nan, best)) + 0.0


def replaced(root: N, by: Mapping[ir.IR, ir.IR]) -> N:
    """A formula with other nodes in place of some; what is shared stays shared."""
    done: dict[ir.IR, ir.IR] = dict(by)

    def part(value: object) -> object:
        if isinstance(value, ir.IR):
            return made(value)
        return tuple([part(one) for one in value]) if type(value) is tuple else value

    def made(node: ir.IR) -> ir.IR:
        found = done.get(node)
        if found is None:
            parts = {name: part(node.__dict__[name]) for name in node.fields}
            same = all(
                parts[name] is node.__dict__[name] or parts[name] == node.__dict__[name] for name in parts
            )
            found = done[node] = node if same else type(node)(**parts)
        return found

    return made(root)  # type: ignore[return-value]
