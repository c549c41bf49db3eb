"""One number in one unit is one double, wherever it stands: in specs, in their tests, and in data."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.length import shared_out
from trackmarshal.evaluation import Evaluator
from trackmarshal.semantics.compile import Compiled, compile_paths
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests
from trackmarshal.testing.si import spec_in_si
from trackmarshal.units import UNITS, from_si, parse_unit, to_si

#: pi to 80 digits.
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")
#: The exact factors of every unit that is not SI, and of what people make of them.
FACTORS = {
    "km": Fraction(1000), "cm": Fraction(1, 100), "mm": Fraction(1, 1000), "ms": Fraction(1, 1000), "us": Fraction(1, 10**6),
    "min": Fraction(60), "h": Fraction(3600), "t": Fraction(1000), "kN": Fraction(1000), "kW": Fraction(1000), "%": Fraction(1, 100),
    "deg": PI / 180, "km/h": Fraction(1000, 3600), "km/h^2": Fraction(1000, 3600**2), "deg/s": PI / 180, "1/mm": Fraction(1000),
    "m/min": Fraction(1, 60), "mm/s^2": Fraction(1, 1000), "kN/cm": Fraction(10**5), "1/km": Fraction(1, 1000),
}  # fmt: skip
#: What people write: all multiples of a half up to 500.
NUMBERS = [k / 2 for k in range(1001)]
TRUE = {unit: [float(Fraction(number) * factor) for number in NUMBERS] for unit, factor in FACTORS.items()}


def made(folder: Path, content: str) -> Compiled:
    path = folder / "made.spec"
    path.write_text(f"module made\n{content}", "utf-8")
    result = compile_paths([path], folder)
    assert result.found == ()
    return result


def listed(numbers: list[float], unit: str = "") -> str:
    return "[" + ", ".join(f"{number!r} {unit}".strip() for number in numbers) + "]"


def test_no_unit_is_forgotten() -> None:
    assert {unit for unit, (factor, _) in UNITS.items() if factor != 1} <= FACTORS.keys()


@pytest.mark.parametrize("unit", FACTORS)
def test_a_conversion_is_rounded_once(unit: str) -> None:
    assert [to_si(number, unit) for number in NUMBERS] == TRUE[unit]
    assert [to_si(-number, unit) for number in NUMBERS] == [-si for si in TRUE[unit]]


@pytest.mark.parametrize("unit", FACTORS)
def test_arrays_are_converted_by_the_same_two_operations(unit: str) -> None:
    up, down, _ = parse_unit(unit)
    odd = [*NUMBERS, *np.random.default_rng(7).uniform(-1e3, 1e3, 1000).tolist()]
    assert (np.array(odd) * up / down).tobytes() == np.array(
        [to_si(number, unit) for number in odd]
    ).tobytes()


@pytest.mark.parametrize("unit", FACTORS)
def test_what_came_from_a_unit_goes_back_to_it(unit: str) -> None:
    odd = [*NUMBERS, *np.random.default_rng(8).uniform(0, 1e3, 1000).tolist()]
    there = [to_si(number, unit) for number in odd]
    assert [to_si(from_si(si, unit), unit) for si in there] == there


@pytest.mark.parametrize("unit", shared_out(FACTORS, 3))
def test_specs_tests_and_data_have_the_same_doubles(unit: str, tmp_path: Path) -> None:
    """Rows of a table, expressions, what a test gives, and data that is read one by one and together."""
    rows = " ".join(f"| {number!r} {unit}: {number!r} {unit}" for number in NUMBERS)
    bare = " ".join(f"| {number!r}: {number!r}" for number in NUMBERS)
    content = f"""table written(x: {unit}) -> {unit} = linear clamp {rows} |
table bare(x: {unit}) -> {unit} = linear clamp {bare} |
table other(x: {unit}) -> {unit} = linear clamp | 0: 0 |
signal log : series {{ t: s increasing, v: {unit} }}
signal things : set of object {{ v: {unit} }}
signal ego : state {{ v: {unit} }}
rule r "r"
  for all p in log
  for all o in things where o.v > 0 {unit}
  require abs(ego.v) + p.v + o.v >= 0 {unit}
test r "all"
  given log = {{ t: {listed(NUMBERS, "s")}, v: {listed(NUMBERS, unit)} }}
  given things = [{", ".join(f"{{ v: {number!r} {unit} }}" for number in NUMBERS)}]
  given ego = {{ v: 130 {unit} }}
  given other = [{", ".join(f"[{number!r} {unit}, {number!r} {unit}]" for number in NUMBERS)}]
  expect satisfied
"""
    compiled = made(tmp_path, content)
    spec = compiled.spec
    for table in ("made.written", "made.bare"):
        assert list(spec.tables[table].knots) == TRUE[unit]
        assert list(spec.tables[table].values) == TRUE[unit]
    (test,), found = prepare(compiled)
    assert found == []
    given = Evaluator(spec_in_si(spec)).read(test.case)
    data: dict[str, Any] = {
        "signals": {
            "log": {"t": NUMBERS, "v": NUMBERS},
            "things": [{"v": v} for v in NUMBERS],
            "ego": {"v": 130.0},
        },
        "tables": {"other": [[number, number] for number in NUMBERS]},
    }
    evaluator = Evaluator(spec)
    for case in (given, evaluator.read(data), *evaluator.read_all([data, data])):
        assert case.columns["log"].listed("v") == TRUE[unit]
        assert case.columns["things"].listed("v") == TRUE[unit]
        assert case.value("ego", "v") == TRUE[unit][260]
        assert list(case.settings.tables["made.other"][0]) == TRUE[unit]
        assert list(case.settings.tables["made.other"][1]) == TRUE[unit]


@pytest.mark.parametrize("unit", FACTORS)
def test_parameters_ranges_and_defaults_have_the_same_doubles(unit: str, tmp_path: Path) -> None:
    some = [*range(0, 1001, 13), 64, 129, 131, 257, 258, 261]
    lines, fields = [], []
    for k in some:
        text = repr(NUMBERS[k])
        lines.append(f"param p{k} : {unit} = {text} {unit} in [{text} {unit}, {text}]")
        fields.append(f"f{k}: {unit} in [{text}, {text} {unit}] default {text} {unit}")
    names = list(dict.fromkeys(fields))
    compiled = made(
        tmp_path,
        "\n".join(dict.fromkeys(lines)) + f"\nsignal ego : state {{ {', '.join(names)} }}\n"
        f"signal things : set of object {{ {', '.join(names)} }}\n"
        + f'rule r "r"\n  allow W306 because "the numbers count, not the demand"\n  for all o in things\n  require {" + ".join(f"ego.f{k} + o.f{k}" for k in some[:8])} >= 0 {unit}\n',
    )
    spec = compiled.spec
    data: dict[str, Any] = {"signals": {"ego": {}, "things": [{}, {}]}}
    evaluator = Evaluator(spec)
    cases = [evaluator.read(data), *evaluator.read_all([data, data])]
    for k in some:
        si = TRUE[unit][k]
        param = spec.params[f"made.p{k}"]
        assert (param.value, param.lower, param.upper) == (si, si, si)
        field = spec.signals["ego"].field(f"f{k}")
        assert field is not None
        assert (field.lower, field.upper, field.default) == (si, si, si)
    for case in cases:
        assert case.faults == []
        for k in some[:8]:
            assert case.value("ego", f"f{k}") == TRUE[unit][k]
            assert case.columns["things"].listed(f"f{k}") == [TRUE[unit][k]] * 2


def test_a_default_in_another_unit_is_the_number_that_it_was_written_as(tmp_path: Path) -> None:
    """No double in km/h gives 6.1 m/s by the conversion of data, which the default does not pass."""
    assert to_si(from_si(6.1, "km/h"), "km/h") != 6.1
    compiled = made(
        tmp_path,
        "signal ego : state { v: km/h default 6.1 m/s }\nsignal cars : set of object { v: km/h default 6.1 m/s }\n"
        'rule r "r"\n  for all o in cars\n  require ego.v <= 6.1 m/s and o.v <= 6.1 m/s\n',
    )
    evaluator = Evaluator(compiled.spec)
    data: dict[str, Any] = {"signals": {"ego": {}, "cars": [{"v": 20.0}, {}]}}
    for case in (evaluator.read(data), *evaluator.read_all([data, data])):
        assert case.value("ego", "v") == 6.1
        assert case.columns["cars"].listed("v") == [to_si(20.0, "km/h"), 6.1]
        assert {type(v) for v in (*case.columns["cars"].listed("v"), case.value("ego", "v"))} == {float}


@pytest.mark.parametrize("speed", [65, 130, 260])
def test_a_test_on_the_limit_is_on_the_limit(speed: int, tmp_path: Path) -> None:
    content = f"""signal ego : state {{ v: km/h }}
signal plan : trajectory {{ t: s increasing, v: km/h }}
param v_max : km/h = {speed} km/h
param v_own : km/h = 1 km/h
rule limit "limit"
  for all p in plan
  require ego.v <= {speed} km/h and ego.v >= {speed} km/h and p.v <= {speed} km/h and p.v >= v_own
test limit "on it"
  given ego = {{ v: {speed} km/h }}
  given plan = constant_speed(v: {speed} km/h)
  given v_own = {speed} km/h
  expect satisfied, margin 0 m/s
test limit "as the parameter says"
  given ego = {{ v: v_max }}
  given plan = constant_speed(v: 1 km/h) with v = v_max
  expect satisfied, margin 0 m/s
"""
    compiled = made(tmp_path, content)
    tests, found = prepare(compiled)
    assert found == []
    assert [(o.outcome, o.message) for o in run_tests(compiled.spec, tests)] == [("passed", "")] * 2
