"""Numbers of the numpy evaluator against the scalar arithmetic of the language, bit for bit, in every corner."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from property.strategies.specs import repeatable
from support.agreement import INEXACT
from trackmarshal.backends.numpy import logic, steps
from trackmarshal.backends.numpy.curves import Curve, Curves
from trackmarshal.ir import arithmetic
from trackmarshal.ir.operators import FUNCTIONS, ArithmeticOp, ComparisonOp, FunctionName
from trackmarshal.ir.tables import LINEAR_CLAMP, read

CORNERS = (
    0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 3.0, 2.5, -7.25, 1e-308, 5e-324, -5e-324, 1e308, -1e308, 709.9, -745.2, 1e-9,
    math.pi, math.inf, -math.inf, math.nan,
)  # fmt: skip
#: How many doubles numpy may be away from libm in one call.
NEIGHBOURS = 2
EXACT = sorted(FUNCTIONS.keys() - INEXACT)


def bits(value: float) -> bytes:
    """A float to be compared with its sign of zero; all NaNs are one."""
    return struct.pack("<d", math.nan if math.isnan(value) else value)


def columns(count: int) -> list[np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """All combinations of corners, a column for each argument."""
    return [np.array(column) for column in zip(*product(CORNERS, repeat=count))]


@pytest.mark.parametrize("op", ["+", "-", "*", "/"])
def test_operators(op: ArithmeticOp) -> None:
    left, right = columns(2)
    with np.errstate(all="ignore"):
        found = eval(f"left {op} right")
    for a, b, value in zip(left.tolist(), right.tolist(), found.tolist(), strict=True):
        assert bits(value) == bits(arithmetic.arith(op, a, b)), (a, op, b)


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_functions(name: FunctionName) -> None:
    """In arrays and alone; those of libm may be neighbours, but never where a value is special."""
    args = columns(FUNCTIONS[name].arity)
    with np.errstate(all="ignore"):
        found = steps.CALLS[name](*args)
        alone = [steps.CALLS[name](*map(np.float64, row)) for row in zip(*args)]
    for row, value, single in zip(zip(*(arg.tolist() for arg in args)), found.tolist(), alone, strict=True):
        wanted = arithmetic.apply(name, row)
        for one in (value, float(single)):
            if name in EXACT or not math.isfinite(wanted) or wanted == 0.0:
                assert bits(one) == bits(wanted), (name, row)
            else:
                assert abs(one - wanted) <= NEIGHBOURS * math.ulp(wanted), (name, row)


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_nan_in_nan_out(name: FunctionName) -> None:
    for at, other in product(range(FUNCTIONS[name].arity), (0.0, 1.0, -1.0, math.inf)):
        args = [np.array([other])] * FUNCTIONS[name].arity
        args[at] = np.array([math.nan])
        with np.errstate(all="ignore"):
            assert np.isnan(steps.CALLS[name](*args)).all(), (name, at, other)


@pytest.mark.parametrize("op", sorted(steps.MEASURED))
def test_comparisons(op: ComparisonOp) -> None:
    left, right = columns(2)
    measure, says = steps.MEASURED[op]
    with np.errstate(all="ignore"):
        margin = eval(
            measure.format(x="left", y="right"),
            {"where": np.where, "inf": math.inf},
            {"left": left, "right": right},
        )
        sat = logic.Side(margin, says).sat
    for a, b, holding, value in zip(
        left.tolist(), right.tolist(), sat.tolist(), margin.tolist(), strict=True
    ):
        if math.isfinite(a) and math.isfinite(b):
            assert holding is arithmetic.compare(op, a, b), (a, op, b)
            assert bits(value) == bits(arithmetic.margin(op, a, b)), (a, op, b)


coordinates = st.floats(-1e3, 1e3) | st.sampled_from((0.0, -0.0, 1e300, -1e300, 5e-324))
rows = st.lists(
    st.tuples(coordinates, coordinates), min_size=1, max_size=6, unique_by=lambda row: row[0]
).map(sorted)


def interpolated(table: Sequence[tuple[float, float]], xs: Sequence[float]) -> list[bytes]:
    knots, values = [k for k, _ in table], [v for _, v in table]
    return [bits(read(knots, values, LINEAR_CLAMP, x)) for x in xs]


@repeatable
@given(rows, st.lists(st.floats() | st.sampled_from(CORNERS), min_size=1, max_size=8))
def test_tables(table: list[tuple[float, float]], xs: list[float]) -> None:
    """At, between and beyond knots, of tables with a single row too; in arrays and alone."""
    xs = [*xs, *(knot for knot, _ in table), *((a + b) / 2 for (a, _), (b, _) in pairwise(table))]
    curve = Curve([k for k, _ in table], [v for _, v in table])
    with np.errstate(all="ignore"):
        found = curve(np.array(xs))
        alone = [float(curve(np.float64(x))) for x in xs]
    wanted = interpolated(table, xs)
    assert [bits(value) for value in found.tolist()] == wanted
    assert [bits(value) for value in alone] == wanted


@repeatable
@given(st.lists(rows, min_size=2, max_size=4), st.lists(coordinates, min_size=1, max_size=4))
def test_tables_that_differ_by_case(tables: list[list[tuple[float, float]]], xs: list[float]) -> None:
    curves = Curves([Curve([k for k, _ in table], [v for _, v in table]) for table in tables], 2)
    with np.errstate(all="ignore"):
        found = curves(np.array([xs]))
    assert found.shape == (len(tables), len(xs))
    assert [[bits(v) for v in row] for row in found.tolist()] == [interpolated(table, xs) for table in tables]
