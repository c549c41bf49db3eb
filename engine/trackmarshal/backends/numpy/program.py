"""Rules as a straight-line program over arrays: each shared node is one step, computed once for a whole batch."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from trackmarshal.backends.numpy import logic, places, time
from trackmarshal.backends.numpy.batch import Batch, shifted
from trackmarshal.backends.numpy.logic import Value
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.backends.results import case_result
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.case import Case
from trackmarshal.runtime.verdict import CaseResult

#: A step: what to compute from the batch and the values of earlier steps.
Step = Callable[..., Any]


class Program:
    """The compiled rules; `run` evaluates them on a batch of cases."""

    def __init__(self, spec: Spec, rules: Sequence[RuleInfo]) -> None:
        self.spec = spec
        self.rules = [rule for rule in rules if rule.formula is not None]
        self.slots: dict[ir.IR, int] = {}
        self._steps: list[tuple[Step, tuple[int, ...]]] = []
        self.rank = 1
        for rule in self.rules:
            for root in (rule.formula, rule.active):
                if root is not None:
                    self._emit(root)

    def run(self, cases: Sequence[Case]) -> Run:
        """Evaluate all rules on all cases."""
        batch = Batch(self.spec, cases, self.rank)
        values: list[Any] = []
        # Undefined values are part of the language: divisions by zero and NaN are no cause for warnings.
        with np.errstate(all="ignore"):
            for step, args in self._steps:
                values.append(step(batch, *[values[i] for i in args]))
        return Run(self, batch, values)

    def _emit(self, root: ir.IR) -> int:
        """Steps for a node and all below it, children first; iterative, so depth is no limit."""
        stack: list[tuple[ir.IR, bool]] = [(root, False)]
        while stack:
            node, ready = stack.pop()
            if node in self.slots:
                continue
            if isinstance(node, ir.Axis):
                self.rank = max(self.rank, node.level + 2)
            inputs = _inputs(node)
            if not ready:
                stack.append((node, True))
                stack.extend((child, False) for child in reversed(inputs))
                stack.extend((axis, True) for axis in node.children() if isinstance(axis, ir.Axis))
                continue
            if isinstance(node, ir.Axis):
                continue
            self.slots[node] = len(self._steps)
            self._steps.append((_step(node), tuple(self.slots[child] for child in inputs)))
        return self.slots[root]


class Run:
    """The values of a program for one batch."""

    def __init__(self, program: Program, batch: Batch, values: list[Any]) -> None:
        self.program = program
        self.batch = batch
        self.values = values

    def of(self, node: ir.IR) -> Any:
        """The array, or the Value, of a node."""
        return self.values[self.program.slots[node]]

    def verdicts(self, rule: RuleInfo) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """(cases,) verdict names and (cases,) margins of a rule, without witnesses."""
        size = self.batch.size
        assert rule.formula is not None
        value: Value = self.of(rule.formula)
        worst = np.broadcast_to(np.ravel(value.worst.sat), (size,))
        best = np.broadcast_to(np.ravel(value.best.sat), (size,))
        verdict = np.where(worst, "satisfied", np.where(best, "undefined", "violated"))
        margin = np.where(worst, np.ravel(value.worst.margin), np.where(best, np.nan, np.ravel(value.best.margin)))
        if rule.active is not None:
            idle = ~np.broadcast_to(np.ravel(self.of(rule.active).best.sat), (size,))
            verdict, margin = np.where(idle, "inactive", verdict), np.where(idle, np.inf, margin)
        blocked = np.array([case.blocks(rule.reads) for case in self.batch.cases])
        return np.where(blocked, "undefined", verdict), np.where(blocked, np.nan, margin)

    def results(self, series: bool = False) -> Iterator[CaseResult]:
        """The results of every case, with witnesses."""
        for index, case in enumerate(self.batch.cases):
            yield case_result(self.program.rules, case, CaseView(self, index), series)


def evaluate(spec: Spec, rules: Sequence[RuleInfo], cases: Sequence[Case], series: bool = False) -> Iterator[CaseResult]:
    """Evaluate rules on cases, all at once."""
    return Program(spec, rules).run(cases).results(series)


def _inputs(node: ir.IR) -> list[ir.IR]:
    """The nodes whose values a step takes, in the order of its arguments."""
    return [child for child in node.children() if isinstance(child, (ir.Num, ir.Formula))]


_ARITH: dict[str, Step] = {
    "+": lambda b, x, y: x + y, "-": lambda b, x, y: x - y, "*": lambda b, x, y: x * y, "/": lambda b, x, y: x / y,
}  # fmt: skip
_FUNC: dict[str, Step] = {
    "abs": lambda b, x: np.abs(x), "sqrt": lambda b, x: np.sqrt(x), "sin": lambda b, x: np.sin(x), "cos": lambda b, x: np.cos(x),
    "tan": lambda b, x: np.tan(x), "exp": lambda b, x: np.exp(x), "log": lambda b, x: np.log(x), "floor": lambda b, x: np.floor(x),
    # Adding 0.0 turns -0.0 into 0.0: see `ir.arithmetic`.
    "min": lambda b, x, y: np.minimum(x, y) + 0.0, "max": lambda b, x, y: np.maximum(x, y) + 0.0,
    "atan2": lambda b, x, y: np.arctan2(x, y), "pow": lambda b, x, y: _pow(x, y),
}  # fmt: skip
_COMPARE: dict[str, tuple[Step, Step]] = {
    "<": (np.less, lambda x, y: y - x), "<=": (np.less_equal, lambda x, y: y - x),
    ">": (np.greater, lambda x, y: x - y), ">=": (np.greater_equal, lambda x, y: x - y),
    "==": (np.equal, lambda x, y: -np.abs(x - y)), "!=": (np.not_equal, lambda x, y: np.abs(x - y)),
}  # fmt: skip


def _pow(x: Any, y: Any) -> Any:
    """A power; NaN in, NaN out, where IEEE 754 says that anything to the 0 is 1, and 1 to anything."""
    return np.where(np.isnan(x) | np.isnan(y), np.nan, np.power(x, y))


def _step(node: ir.IR) -> Step:  # noqa: C901 - one case a node
    match node:
        case ir.Const():
            constant = np.float64(node.value)
            return lambda b: constant
        case ir.Param():
            return lambda b: _param(b, node.name)
        case ir.Column():
            return lambda b: b.column(node.axis, node.field, node.offset)
        case ir.Sample():
            return lambda b: b.per_case([case.columns[node.signal][node.field][node.index] for case in b.cases])
        case ir.Scalar():
            return lambda b: b.per_case([case.scalars[node.signal][node.field] for case in b.cases])
        case ir.Arith():
            return _ARITH[node.op]
        case ir.Neg():
            return lambda b, x: -x
        case ir.Func():
            return _FUNC[node.name]
        case ir.Choose():
            return _choose
        case ir.Lookup():
            return lambda b, x: _lookup(b, node.table, x)
        case ir.Along():
            return lambda b, *args: places.along(b, node, args)
        case ir.Truth():
            constant_truth = logic.defined(np.bool_(node.value), np.float64(np.inf if node.value else -np.inf))
            return lambda b: constant_truth
        case ir.Flag():
            return lambda b: _flag(b, node)
        case ir.Compare():
            return _comparison(node.op)
        case ir.Geometry():
            return lambda b, *args: places.predicate(b, node, args)
        case ir.Not():
            return lambda b, x: logic.negate(x)
        case ir.Connective():
            return lambda b, x, y: logic.connect(node.op, x, y)
        case ir.Quantify():
            if node.guard is None:
                return lambda b, body: _quantify(b, node, None, body)
            return lambda b, guard, body: _quantify(b, node, guard, body)
        case ir.Guarded():
            return lambda b, guard, body: _guarded(guard, body)
        case ir.Temporal() | ir.Until() | ir.Shift() | ir.Edge():
            return lambda b, *operands: time.operator(b, node, operands)
        case ir.First():
            return lambda b, body: _first(node.axis, body)
        case _:
            raise AssertionError(f"unknown node {type(node).__name__}")


def _param(batch: Batch, name: str) -> Any:
    value = batch.spec.params[name].value
    if all(name not in case.params for case in batch.cases):
        return np.float64(value)
    return batch.per_case([case.params.get(name, value) for case in batch.cases])


def _choose(batch: Batch, condition: Value, then: Any, otherwise: Any) -> Any:
    chosen = np.where(condition.worst.sat, then, otherwise)
    if condition.best is condition.worst:
        return chosen
    return np.where(condition.best.sat & ~condition.worst.sat, np.nan, chosen)


def _lookup(batch: Batch, name: str, x: Any) -> Any:
    info = batch.spec.tables[name]
    if all(name not in case.tables for case in batch.cases):
        return _interpolate(np.array(info.knots), np.array(info.values), x)
    shared, tables = batch.shared(lambda case: case.tables.get(name))
    if shared and tables[0] is not None:
        return _interpolate(np.array(tables[0][0]), np.array(tables[0][1]), x)
    x = np.asarray(x)
    if x.ndim == 0 or x.shape[0] == 1:
        x = np.broadcast_to(x, (batch.size, *(x.shape[1:] if x.ndim else (1,) * (batch.rank - 1))))
    rows = [table if table is not None else (info.knots, info.values) for table in tables]
    return np.stack([_interpolate(np.array(knots), np.array(values), row) for (knots, values), row in zip(rows, x)])


def _interpolate(knots: Any, values: Any, x: Any) -> Any:
    """Linear between knots, clamped outside, NaN for a non-finite argument; the formula of `ir.arithmetic`."""
    if len(knots) == 1:
        return np.where(np.isfinite(x), values[0], np.nan)
    index = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
    slope = (values[index + 1] - values[index]) / (knots[index + 1] - knots[index])
    result = values[index] + slope * (x - knots[index])
    result = np.where(x <= knots[0], values[0], np.where(x >= knots[-1], values[-1], result))
    return np.where(np.isfinite(x), result, np.nan)


def _comparison(op: str) -> Step:
    holds, measure = _COMPARE[op]

    def step(batch: Batch, x: Any, y: Any) -> Value:
        margin = measure(x, y)
        sat = holds(x, y)
        if np.isfinite(margin).all():
            return logic.defined(sat, margin)
        known = np.isfinite(x) & np.isfinite(y)
        if known.all():
            return logic.defined(sat, margin)
        return logic.partly(sat, margin, known)

    return step


def _flag(batch: Batch, node: ir.Flag) -> Value:
    if node.axis is not None:
        assert node.field is not None
        code = batch.on_axis(shifted(batch.flags(node.signal, node.field), node.offset, batch.count(node.axis)), node.axis)
    else:
        code = batch.per_case([_code(case.scalars[node.signal][node.field or ""]) for case in batch.cases])
    sat = code == 1.0
    margin = np.where(sat, np.inf, -np.inf)
    known = ~np.isnan(code)
    return logic.defined(sat, margin) if known.all() else logic.partly(sat, margin, known)


def _code(value: bool | None) -> float:
    return np.nan if value is None else float(value)


def _quantify(batch: Batch, node: ir.Quantify, guard: Value | None, body: Value) -> Value:
    mask = batch.mask(node.axis)
    if guard is None:
        return logic.reduce(body, node.quantifier, 1 + node.axis.level, mask, mask)
    # See the reference evaluator: what may be in range counts against a `for all` in the worst case.
    in_worst, in_best = guard.best.sat, guard.worst.sat
    if guard.best is guard.worst:
        in_best = in_worst
    if mask is not None:
        one = in_best is in_worst
        in_worst = mask & in_worst
        in_best = in_worst if one else mask & in_best
    if node.quantifier == "exists":
        in_worst, in_best = in_best, in_worst
    if mask is None and in_worst.ndim == 0:
        shape = (1,) * batch.rank
        in_worst, in_best = np.broadcast_to(in_worst, shape), np.broadcast_to(in_best, shape)
    return logic.reduce(body, node.quantifier, 1 + node.axis.level, in_worst, in_best)


def _guarded(guard: Value, body: Value) -> Value:
    worst = logic.Side(body.worst.sat | ~guard.best.sat, np.where(guard.best.sat, body.worst.margin, np.inf))
    if guard.best is guard.worst and body.best is body.worst:
        return Value(worst, worst)
    return Value(worst, logic.Side(body.best.sat | ~guard.worst.sat, np.where(guard.worst.sat, body.best.margin, np.inf)))


def _first(axis: ir.Axis, body: Value) -> Value:
    def take(side: logic.Side) -> logic.Side:
        if side.sat.ndim == 0:
            return side
        index = (slice(None),) * (1 + axis.level) + (slice(0, 1),)
        return logic.Side(side.sat[index], side.margin[index])

    worst = take(body.worst)
    return Value(worst, worst if body.best is body.worst else take(body.best))
