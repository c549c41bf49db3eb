"""Tables that are read by steps, that have no value outside, that repeat, and those of two arguments: at each boundary and beside it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from trackmarshal.configuration import configure
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.ir.spec import Spec, TableInfo

HEAD = "module made\n\nsignal ego : state { x: m, y: s }\n\n"
RULE = '\nrule r "r"\n  require   f(ego.x) >= 0 m/s\n'
BACKENDS = ("reference", "numpy", "c")


def spec(table: str, rule: str = RULE) -> Spec:
    return loads(HEAD + table + "\n" + rule)


def value(made: Spec, x: float, y: float = 0.0, backend: str = "reference", **more: Any) -> float:
    case = {"signals": {"ego": {"x": x, "y": y}}, **more}
    result = Evaluator(made, backend=backend).case(case).rules["r"]
    assert (result.verdict == "undefined") == math.isnan(result.margin)
    return result.margin


def below(x: float) -> float:
    return math.nextafter(x, -math.inf)


STEPS = "table f(x: m) -> m/s = step{} | 0 m: 20 m/s | 100 m: 30 m/s | 300 m: 5 m/s |"


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("x", "wanted"),
    [
        (0.0, 20.0), (-0.0, 20.0), (below(100.0), 20.0), (100.0, 30.0), (below(300.0), 30.0), (300.0, 5.0), (1e300, 5.0),
        (below(0.0), math.nan), (-1.0, math.nan), (math.nan, math.nan), (math.inf, math.nan), (-math.inf, math.nan),
    ],
)  # fmt: skip
def test_a_step_is_the_last_knot_at_or_below(x: float, wanted: float, backend: str) -> None:
    assert value(spec(STEPS.format("")), x, backend=backend) == pytest.approx(wanted, abs=0.0, nan_ok=True)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_clamped_step_has_its_first_value_below(backend: str) -> None:
    assert value(spec(STEPS.format(" clamp")), -1.0, backend=backend) == 20.0
    assert math.isnan(value(spec(STEPS.format(" clamp")), math.nan, backend=backend))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("x", "wanted"), [(below(1.0), math.nan), (1.0, 10.0), (2.0, 20.0), (3.0, 30.0), (math.nextafter(3.0, 4.0), math.nan)]
)  # fmt: skip
def test_linear_without_clamp_has_no_value_outside(x: float, wanted: float, backend: str) -> None:
    made = spec("table f(x: m) -> m/s = linear | 1 m: 10 m/s | 3 m: 30 m/s |")
    assert value(made, x, backend=backend) == pytest.approx(wanted, abs=0.0, nan_ok=True)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("x", "wanted"),
    [
        (100.0, 20.0), (99.0, 30.0), (0.0, 30.0), (4000.0, 30.0), (4999.0, 30.0), (5000.0, 30.0), (5100.0, 20.0), (5099.0, 30.0),
        (-1.0, 30.0), (-4900.0, 20.0), (-4901.0, 30.0), (-5e-324, 30.0), (1e15 + 200.0, 20.0), (math.inf, math.nan),
    ],
)  # fmt: skip
def test_steps_that_repeat(x: float, wanted: float, backend: str) -> None:
    made = spec("table f(x: m) -> m/s = step wrap 5 km | 100 m: 20 m/s | 4000 m: 30 m/s |")
    assert value(made, x, backend=backend) == pytest.approx(wanted, abs=0.0, nan_ok=True)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("x", "wanted"), [(1.0, 10.0), (3.0, 20.0), (5.0, 30.0), (7.0, 20.0), (8.0, 15.0), (0.0, 15.0), (-1.0, 20.0), (9.0, 10.0)]
)  # fmt: skip
def test_linear_that_repeats_joins_its_ends(x: float, wanted: float, backend: str) -> None:
    made = spec("table f(x: m) -> m/s = linear wrap 8 m | 1 m: 10 m/s | 5 m: 30 m/s |")
    assert value(made, x, backend=backend) == wanted


def test_one_knot_that_repeats_is_a_constant() -> None:
    for way in ("linear", "step"):
        made = spec(f"table f(x: m) -> m/s = {way} wrap 8 m | 1 m: 10 m/s |")
        assert {value(made, x) for x in (-9.0, 0.0, 1.0, 7.0)} == {10.0}


GRID = """table g(x: m, y: s) -> m/s = {}
  | y: 0 s, 1 s, 3 s
  | 0 m: 0 m/s, 10 m/s, 30 m/s
  | 10 m: 100 m/s, 110 m/s, 130 m/s |"""
BOTH = '\nrule r "r"\n  require   g(ego.x, ego.y) >= 0 m/s\n'


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("ways", "x", "y", "wanted"),
    [
        ("linear clamp", 5.0, 2.0, 70.0), ("linear clamp", -1.0, 9.0, 30.0), ("linear clamp", 10.0, 1.0, 110.0),
        ("linear clamp", 5.0, math.nan, math.nan), ("linear clamp", math.nan, 1.0, math.nan),
        ("linear", 10.0, 3.0, 130.0), ("linear", 10.0, 3.5, math.nan), ("linear", -0.5, 1.0, math.nan),
        ("step", 9.0, 2.0, 10.0), ("step", 12.0, 5.0, 130.0), ("step", 9.0, -0.5, math.nan),
        ("linear clamp, step", 5.0, 2.0, 60.0), ("step clamp, linear clamp", 5.0, 2.0, 20.0),
        ("step wrap 20 m, linear clamp", 25.0, 0.5, 5.0), ("step wrap 20 m, linear clamp", -1.0, 0.5, 105.0),
    ],
)  # fmt: skip
def test_two_arguments(ways: str, x: float, y: float, wanted: float, backend: str) -> None:
    made = spec(GRID.format(ways), BOTH)
    assert value(made, x, y, backend) == pytest.approx(wanted, abs=0.0, nan_ok=True)


def test_cases_override_steps_within_their_period() -> None:
    made = spec("table f(x: m) -> m/s = step wrap 5 km | 100 m: 20 m/s |")
    for backend in BACKENDS:
        assert value(made, 50.0, backend=backend, tables={"f": [[0, 3], [60, 4]]}) == 3.0
        for knot in (-1, 5000):
            with pytest.raises(TrackmarshalError) as refused:
                value(made, 50.0, backend=backend, tables={"f": [[knot, 3]]})
            assert refused.value.code == "D204"


def test_data_does_not_replace_a_table_of_two_arguments() -> None:
    made = spec(GRID.format("linear clamp"), BOTH)
    with pytest.raises(TrackmarshalError) as refused:
        value(made, 5.0, 2.0, tables={"g": [[0, 3]]})
    assert refused.value.code == "D240"


def test_a_configuration_replaces_rows_columns_and_periods() -> None:
    made = spec(GRID.format("step wrap 20 m, linear clamp"), BOTH)
    new = "module other\ntable g(x: m, y: s) -> m/s = step wrap 30 m, linear clamp | y: 0 s | 25 m: 7 m/s | 29 m: 9 m/s |\n"
    changed = configure(made, loads(new))
    assert changed.fingerprint != made.fingerprint
    for backend in BACKENDS:
        assert value(changed, 28.0, 5.0, backend) == 7.0


@pytest.mark.parametrize(
    "new",
    [
        "table g(x: m, y: s) -> m/s = step clamp, linear clamp | y: 0 s | 25 m: 7 m/s |",
        "table g(x: m, y: s) -> m/s = step wrap 20 m, step clamp | y: 0 s | 15 m: 7 m/s |",
        "table g(x: m, y: m) -> m/s = step wrap 20 m, linear clamp | y: 0 m | 15 m: 7 m/s |",
        "table g(x: m) -> m/s = step wrap 20 m | 15 m: 7 m/s |",
    ],
)
def test_a_configuration_does_not_change_how_a_table_is_read(new: str) -> None:
    made = spec(GRID.format("step wrap 20 m, linear clamp"), BOTH)
    with pytest.raises(TrackmarshalError) as refused:
        configure(made, loads(f"module other\n{new}\n"))
    assert refused.value.code == "E402"


def test_how_a_table_is_read_is_part_of_the_fingerprint(tmp_path: Path) -> None:
    ways = (
        "linear",
        "linear clamp",
        "step",
        "step clamp",
        "step wrap 400 m",
        "step wrap 500 m",
        "linear wrap 500 m",
    )
    made = {spec(f"table f(x: m) -> m/s = {way} | 0 m: 20 m/s | 100 m: 30 m/s |").fingerprint for way in ways}
    assert len(made) == len(ways)


def test_linear_clamp_is_described_as_ever() -> None:
    """What is kept of runs rests on fingerprints, and these on descriptions."""
    (table,) = spec("table f(x: m) -> m/s = linear clamp | 0 m: 20 m/s |").tables.values()
    assert repr(table) == "TableInfo(name='made.f', knots=(0.0,), values=(20.0,), units=('m', 'm/s'))"
    assert isinstance(table, TableInfo)
