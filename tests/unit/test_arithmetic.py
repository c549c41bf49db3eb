"""Scalar arithmetic: IEEE 754 in every corner, comparisons and margins against exact rationals."""

from __future__ import annotations

import math
import struct
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from trackmarshal.ir.arithmetic import apply, arith, compare, margin
from trackmarshal.ir.operators import FUNCTIONS, ArithmeticOp, ComparisonOp, FunctionName
from trackmarshal.ir.tables import LINEAR_CLAMP, read

CORNERS = (
    0.0, -0.0, 1.0, -1.0, 0.5, 3.0, 1e-308, -1e-308, 5e-324, -5e-324, 1e308, -1e308, 1.7976931348623157e308,
    math.inf, -math.inf, math.nan,
)  # fmt: skip
COMPARISONS = ("<", "<=", "==", "!=")
anything = st.floats() | st.sampled_from(CORNERS)
finite = st.floats(allow_nan=False, allow_infinity=False)


def bits(value: float) -> bytes:
    """A float to be compared with its sign of zero; all NaNs are one."""
    return struct.pack("<d", math.nan if math.isnan(value) else value)


def ieee(op: str, a: float, b: float) -> float:
    """The operation as numpy's doubles do it, which is what the processor does."""
    with np.errstate(all="ignore"):
        x, y = np.float64(a), np.float64(b)
        return float({"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}[op](x, y))


@pytest.mark.parametrize("op", ["+", "-", "*", "/"])
def test_every_corner_is_that_of_the_processor(op: ArithmeticOp) -> None:
    for a, b in product(CORNERS, CORNERS):
        assert bits(arith(op, a, b)) == bits(ieee(op, a, b)), (a, op, b)


@given(st.sampled_from("+-*/"), anything, anything)
def test_arithmetic_is_that_of_the_processor(op: ArithmeticOp, a: float, b: float) -> None:
    assert bits(arith(op, a, b)) == bits(ieee(op, a, b))


@given(st.sampled_from("+-*/"), finite, finite)
def test_arithmetic_rounds_the_exact_value_once(op: ArithmeticOp, a: float, b: float) -> None:
    if op == "/" and b == 0.0:
        return
    x, y = Fraction(a), Fraction(b)
    true = x + y if op == "+" else x - y if op == "-" else x * y if op == "*" else x / y
    value = arith(op, a, b)
    if abs(true) < Fraction(2) ** 1024 - Fraction(2) ** 970:
        assert Fraction(value) == Fraction(float(true))
    else:
        assert math.isinf(value) or abs(value) == 1.7976931348623157e308


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_nan_in_nan_out(name: FunctionName) -> None:
    for place in range(FUNCTIONS[name].arity):
        for other in (0.0, 1.0, math.inf):
            args = [other] * FUNCTIONS[name].arity
            args[place] = math.nan
            assert math.isnan(apply(name, args)), args


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_no_corner_raises(name: FunctionName) -> None:
    for args in product(CORNERS, repeat=FUNCTIONS[name].arity):
        assert isinstance(apply(name, args), float)


@pytest.mark.parametrize(
    ("name", "args", "value"),
    [
        ("sqrt", (-1.0,), math.nan), ("sqrt", (-0.0,), -0.0), ("sqrt", (math.inf,), math.inf),
        ("log", (0.0,), -math.inf), ("log", (-0.0,), -math.inf), ("log", (-1.0,), math.nan), ("log", (math.inf,), math.inf),
        ("exp", (1e4,), math.inf), ("exp", (-1e4,), 0.0), ("exp", (-math.inf,), 0.0),
        ("sin", (math.inf,), math.nan), ("cos", (-math.inf,), math.nan), ("tan", (math.inf,), math.nan),
        ("floor", (-0.0,), -0.0), ("floor", (-0.5,), -1.0), ("floor", (math.inf,), math.inf), ("floor", (1e300,), 1e300),
        ("abs", (-0.0,), 0.0), ("abs", (-math.inf,), math.inf),
        ("min", (0.0, -0.0), 0.0), ("min", (-0.0, -0.0), 0.0), ("max", (-0.0, 0.0), 0.0), ("max", (-math.inf, 1.0), 1.0),
        ("atan2", (0.0, -0.0), math.pi), ("atan2", (-0.0, 0.0), -0.0), ("atan2", (math.inf, math.inf), math.pi / 4),
        ("pow", (0.0, -1.0), math.inf), ("pow", (-0.0, -1.0), -math.inf), ("pow", (-0.0, -2.0), math.inf),
        ("pow", (0.0, -0.5), math.inf), ("pow", (-0.0, -0.5), math.inf), ("pow", (0.0, 0.0), 1.0),
        ("pow", (-8.0, 1 / 3), math.nan), ("pow", (-10.0, 309.0), -math.inf), ("pow", (-10.0, 310.0), math.inf),
        ("pow", (10.0, 400.0), math.inf), ("pow", (10.0, -400.0), 0.0), ("pow", (-1.0, math.inf), 1.0),
        ("pow", (2.0, 0.5), math.sqrt(2.0)),
    ],
)  # fmt: skip
def test_functions_have_the_values_of_their_definitions(
    name: FunctionName, args: tuple[float, ...], value: float
) -> None:
    assert bits(apply(name, args)) == bits(value)


@given(finite, finite)
def test_min_and_max_are_one_of_the_two(a: float, b: float) -> None:
    assert apply("min", (a, b)) == min(a, b)
    assert apply("max", (a, b)) == max(a, b)


@given(finite)
def test_the_floor_is_the_whole_number_below(x: float) -> None:
    below = apply("floor", (x,))
    assert below == int(below) <= x
    assert Fraction(x) - Fraction(below) < 1


@given(st.sampled_from(COMPARISONS), finite, finite)
@example("<", 0.0, -0.0)
@example("<=", 0.1 + 0.2, 0.3)
def test_comparisons_are_exact(op: ComparisonOp, a: float, b: float) -> None:
    x, y = Fraction(a), Fraction(b)
    exact = {"<": x < y, "<=": x <= y, "==": x == y, "!=": x != y}[op]
    assert compare(op, a, b) is exact


@given(st.sampled_from(COMPARISONS), finite, finite)
@example("<", 1e308, -1e308)
def test_margins_are_the_distance_rounded_once(op: ComparisonOp, a: float, b: float) -> None:
    x, y = Fraction(a), Fraction(b)
    inside = {"<": y - x, "<=": y - x, "==": -abs(x - y), "!=": abs(x - y)}[op]
    found = margin(op, a, b)
    if abs(inside) < Fraction(2) ** 1024 - Fraction(2) ** 970:
        assert found == float(inside)
    else:
        assert math.isinf(found)
    assert (found > 0) == (inside > 0)  # doubles are dense enough: unequal numbers have an unequal difference
    assert (found < 0) == (inside < 0)


@pytest.mark.parametrize("function", [compare, margin, arith])
def test_an_unknown_operator_raises(function: object) -> None:
    with pytest.raises((AssertionError, KeyError), match="<>"):
        function("<>", 1.0, 2.0)  # type: ignore[operator]
    with pytest.raises(KeyError):
        apply("sinh", (1.0,))  # type: ignore[arg-type]


#: Knots are at least a billionth apart: of knots next to each other the slope is infinite, and the value undefined.
tables = st.lists(
    st.tuples(st.integers(-(10**15), 10**15).map(lambda n: n * 1e-9), st.floats(-1e6, 1e6)),
    min_size=1,
    max_size=6,
    unique_by=lambda row: row[0],
).map(sorted)


@given(tables, st.floats(-2e6, 2e6))
def test_tables_are_linear_between_knots_and_clamped_outside(
    rows: list[tuple[float, float]], x: float
) -> None:
    knots, values = [k for k, _ in rows], [v for _, v in rows]
    found = read(knots, values, LINEAR_CLAMP, x)
    if x <= knots[0]:
        assert found == values[0]
    elif x >= knots[-1]:
        assert found == values[-1]
    else:
        at = max(i for i, knot in enumerate(knots) if knot <= x)
        share = (Fraction(x) - Fraction(knots[at])) / (Fraction(knots[at + 1]) - Fraction(knots[at]))
        true = Fraction(values[at]) + share * (Fraction(values[at + 1]) - Fraction(values[at]))
        size = abs(values[at]) + abs(values[at + 1])
        assert abs(Fraction(found) - true) <= Fraction(size) * Fraction(8, 2**53) + Fraction(1, 10**300)


@given(tables)
def test_tables_go_through_their_knots(rows: list[tuple[float, float]]) -> None:
    for knot, value in rows:
        assert read([k for k, _ in rows], [v for _, v in rows], LINEAR_CLAMP, knot) == value


@pytest.mark.parametrize("x", [math.nan, math.inf, -math.inf])
def test_a_table_has_no_value_for_what_is_not_finite(x: float) -> None:
    assert math.isnan(read([0.0, 1.0], [2.0, 3.0], LINEAR_CLAMP, x))
