"""Tables of every way and shape: three evaluators to the bit, and a reading by search from the definition."""

from __future__ import annotations

import math
import struct
from fractions import Fraction

from hypothesis import given, settings
from hypothesis import strategies as st

from property.strategies.specs import repeatable
from support.agreement import said_of
from support.length import amount
from trackmarshal.evaluation import Evaluator, loads

WAYS = ("linear", "linear clamp", "step", "step clamp", "linear wrap 64 m", "step wrap 64 m")
numbers = st.sampled_from([-5, -1, 0, 1, 2, 7, 63]) | st.integers(-40, 100).map(lambda n: n / 4)
knots = st.lists(st.integers(0, 63), min_size=1, max_size=5, unique=True).map(sorted)
places = numbers | st.sampled_from([64.0, 128.0, -64.0, 1e9, math.inf, -math.inf, math.nan])


def literal(value: float) -> str:
    return f"{value!r}"


@st.composite
def tables(draw: st.DrawFn) -> tuple[list[str], list[int], list[int], list[list[float]]]:
    rows, columns = draw(knots), draw(knots)
    cells = [[float(draw(numbers)) for _ in columns] for _ in rows]
    return [draw(st.sampled_from(WAYS)) for _ in "xy"], rows, columns, cells


def weights(way: str, at: list[int], x: float) -> dict[int, Fraction] | None:
    """How much each knot counts, in exact arithmetic; None where there is no value."""
    if not math.isfinite(x):
        return None
    exact = Fraction(x)
    known = [(Fraction(knot), index) for index, knot in enumerate(at)]
    if "wrap" in way:
        exact -= 64 * (exact // 64)
        known = [(knot + 64 * turn, index) for turn in (-1, 0, 1) for knot, index in known]
    lower = [each for each in known if each[0] <= exact]
    upper = [each for each in known if each[0] >= exact]
    if "clamp" in way:
        lower, upper = lower or known[:1], upper or known[-1:]
    if not lower or (not upper and "linear" in way):
        return None
    (low, first) = lower[-1]
    if "step" in way or low >= exact or upper[0][0] <= exact:
        return {first if "step" in way or low >= exact else upper[0][1]: Fraction(1)}
    (high, second) = upper[0]
    share = (exact - low) / (high - low)
    if first == second:
        return {first: Fraction(1)}
    return {first: 1 - share, second: share}


@settings(repeatable, max_examples=amount(8, 16))
@given(tables(), st.lists(st.tuples(places, places), min_size=1, max_size=12))
def test_evaluators_agree_and_read_what_is_defined(
    made: tuple[list[str], list[int], list[int], list[list[float]]], points: list[tuple[float, float]]
) -> None:
    (down, across), rows, columns, cells = made
    points = [*points, *((float(row), float(column)) for row in rows for column in columns)]
    lines = [f"  | {row} m: {', '.join(map(literal, line))}" for row, line in zip(rows, cells)]
    text = f"""module made
signal ego : state {{ x: m, y: m }}
table g(x: m, y: m) -> 1 = {down}, {across}
  | y: {", ".join(f"{column} m" for column in columns)}
{chr(10).join(lines)} |
table f(x: m) -> 1 = {down} {" ".join(f"| {row} m: {literal(line[0])}" for row, line in zip(rows, cells))} |
rule one "one"
  require f(ego.x) >= 0
rule two "two"
  require g(ego.x, ego.y) >= 0
"""
    spec = loads(text)
    cases = [{"signals": {"ego": {"x": x, "y": y}}} for x, y in points]
    evaluators = {backend: Evaluator(spec, backend=backend) for backend in ("reference", "numpy", "c")}
    found = {
        backend: [
            {
                name: (verdict, struct.pack("<d", margin))
                for name, (verdict, margin) in said_of(one, case).items()
            }
            for case in cases
        ]
        for backend, one in evaluators.items()
    }
    assert found["reference"] == found["numpy"] == found["c"]
    for (x, y), said in zip(points, found["reference"]):
        one, two = weights(down, rows, x), weights(across, columns, y)
        wanted = None if one is None else sum(share * Fraction(cells[row][0]) for row, share in one.items())
        close(said["one"], wanted)
        both = one is not None and two is not None
        wanted = (
            sum(a * b * Fraction(cells[i][j]) for i, a in one.items() for j, b in two.items())
            if one is not None and two is not None
            else None
        )
        assert both == (wanted is not None)
        close(said["two"], wanted)


def close(said: tuple[str, bytes], wanted: Fraction | int | None) -> None:
    (margin,) = struct.unpack("<d", said[1])
    if wanted is None:
        assert said[0] == "undefined"
        assert math.isnan(margin)
    else:
        assert abs(Fraction(margin) - wanted) <= Fraction(1, 10**9)
