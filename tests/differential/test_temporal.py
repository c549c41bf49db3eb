"""Both evaluators' temporal operators against formulas that independent tools evaluated."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from support.shared import oracle
from trackmarshal.backends.numpy import temporal
from trackmarshal.backends.reference import temporal as reference

#: operator of the oracle -> (kernel, past)
WINDOWED = {
    "always": ("always", False),
    "eventually": ("eventually", False),
    "until": ("until", False),
    "historically": ("always", True),
    "once": ("eventually", True),
    "since": ("since", True),
}
#: operator of the oracle -> (step, weak)
SHIFTS = {"next": (1, True), "s_next": (1, False), "prev": (-1, True), "s_prev": (-1, False)}
EDGES = ("rise", "fall")
COMPARISONS: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    "<": (np.less, lambda left, right: right - left),
    "<=": (np.less_equal, lambda left, right: right - left),
    ">": (np.greater, lambda left, right: left - right),
    ">=": (np.greater_equal, lambda left, right: left - right),
    "==": (np.equal, lambda left, right: -np.abs(left - right)),
    "!=": (np.not_equal, lambda left, right: np.abs(left - right)),
}
ARITHMETIC = {"+": np.add, "-": np.subtract, "*": np.multiply, "abs": np.abs}


class Walker:
    """Evaluates a formula tree: temporal operators with the evaluator under test, all others with numpy."""

    def __init__(self, evaluator: Any, trace: dict[str, list[float]]) -> None:
        self.evaluator = evaluator
        self.trace = {name: np.array(column) for name, column in trace.items()}
        self.n = len(next(iter(trace.values())))

    def kernel(self, name: str, *operands: Any, window: Any = None) -> Any:
        """One temporal operator; the reference is handed lists."""
        t = np.arange(self.n, dtype=np.float64)
        if self.evaluator is reference:
            operands = tuple(x.tolist() if isinstance(x, np.ndarray) else x for x in operands)
        if window is not None:
            times = t.tolist() if self.evaluator is reference else t
            operands = (*operands, self.evaluator.windows(times, *window))
        sat, margin = getattr(self.evaluator, name)(*operands)
        return np.array(sat, dtype=np.bool_), np.array(margin, dtype=np.float64)

    def number(self, node: Any) -> Any:
        """A term's samples."""
        if node["op"] == "var":
            return self.trace[node["name"]]
        if node["op"] == "const":
            return np.full(self.n, float(node["value"]))
        return ARITHMETIC[node["op"]](*map(self.number, node["args"]))

    def value(self, node: Any) -> Any:
        """A formula's (sat, margin)."""
        op = node["op"]
        if op in COMPARISONS:
            left, right = map(self.number, node["args"])
            holds, margin = COMPARISONS[op]
            return holds(left, right), margin(left, right)
        operands = [self.value(argument) for argument in node["args"]]
        flat = [array for operand in operands for array in operand]
        if op in WINDOWED:
            kernel, past = WINDOWED[op]
            lower, upper = node["interval"] or (None, None)
            return self.kernel(kernel, *flat, window=(lower, upper, past))
        if op in SHIFTS:
            return self.kernel("shift", *flat, *SHIFTS[op])
        if op in EDGES:
            denied = self.connective("not", *flat)
            before, now = (denied, flat) if op == "rise" else (flat, denied)
            return self.connective("and", *self.kernel("shift", *before, -1, True), *now)
        return self.connective(op, *flat)

    def connective(self, op: str, *flat: Any) -> Any:
        """not, and, or, implies, iff, xor."""
        if op == "not":
            return ~flat[0], -flat[1]
        left_sat, left, right_sat, right = flat
        if op == "and":
            return left_sat & right_sat, np.minimum(left, right)
        if op == "or":
            return left_sat | right_sat, np.maximum(left, right)
        if op == "implies":
            return ~left_sat | right_sat, np.maximum(-left, right)
        with np.errstate(invalid="ignore"):
            apart = np.where(left == right, 0.0, np.abs(left - right))
        if op == "iff":
            return left_sat == right_sat, -apart
        if op == "xor":
            return left_sat != right_sat, apart
        raise AssertionError(f"the oracle has an operator this test does not know: {op}")


def entries(file: str) -> list[Any]:
    """An oracle's entries; none, and so a skipped test, where it is not ours and the shared folder is absent."""
    try:
        loaded = oracle(file)["entries"]
    except pytest.skip.Exception as skipped:
        return [pytest.param(None, marks=pytest.mark.skip(reason=str(skipped)))]
    return [pytest.param(entry, id=entry["id"]) for entry in loaded]


def operators(node: Any) -> set[str]:
    """All operators in a formula."""
    return {node["op"]}.union(*map(operators, node.get("args", ())))


@pytest.mark.parametrize("evaluator", [reference, temporal], ids=["reference", "numpy"])
@pytest.mark.parametrize("entry", entries("stl_dev.json"))
def test_robustness_of_every_sample(entry: Any, evaluator: Any) -> None:
    sat, margin = Walker(evaluator, entry["trace"]).value(entry["formula"])
    expected = [float(value) for value in entry["robustness"]]
    assert not any(map(math.isnan, expected))
    assert margin.tolist() == expected
    if not operators(entry["formula"]) & {"iff", "xor"}:  # whose margins do not tell true from false
        assert sat[margin > 0].all()
        assert not sat[margin < 0].any()


@pytest.mark.parametrize("evaluator", [reference, temporal], ids=["reference", "numpy"])
@pytest.mark.parametrize("entry", entries("mltl_r2u2_vectors.json"))
def test_verdicts_of_bounded_formulas(entry: Any, evaluator: Any) -> None:
    sat, _ = Walker(evaluator, entry["trace"]).value(entry["formula"])
    assert entry["verdicts"]
    assert sat.tolist()[: len(entry["verdicts"])] == entry["verdicts"]
