"""Units: the closed list, exact conversions, dimensions and how messages show them."""

from __future__ import annotations

import math
import re
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackmarshal.units import (
    ACCELERATION,
    FORCE,
    LENGTH,
    MASS,
    NUMBER,
    SPEED,
    TIME,
    UNIT_PATTERN,
    UNITS,
    Dimension,
    about,
    from_si,
    in_full,
    moment,
    name,
    over,
    parse_shown,
    parse_unit,
    power,
    quantity,
    show,
    times,
    to_si,
)  # fmt: skip

#: The exact factors to SI, written independently of the table under test.
EXACT = {
    "m": Fraction(1), "km": Fraction(1000), "cm": Fraction(1, 100), "mm": Fraction(1, 1000),
    "s": Fraction(1), "ms": Fraction(1, 1000), "us": Fraction(1, 1_000_000), "min": Fraction(60), "h": Fraction(3600),
    "kg": Fraction(1), "t": Fraction(1000), "N": Fraction(1), "kN": Fraction(1000), "J": Fraction(1),
    "W": Fraction(1), "kW": Fraction(1000), "Hz": Fraction(1), "rad": Fraction(1), "%": Fraction(1, 100),
    "deg": Fraction(math.pi) / 180,
}  # fmt: skip

finite = st.floats(min_value=-1e200, max_value=1e200, allow_nan=False)
exponents = st.integers(-3, 3)
dimensions = st.tuples(exponents, exponents, exponents).map(lambda t: tuple(Fraction(e) for e in t))
fractional = st.tuples(*[st.fractions(min_value=-3, max_value=3, max_denominator=4)] * 3)


def unit_texts() -> st.SearchStrategy[str]:
    names = st.sampled_from(sorted(UNITS))
    part = st.builds(
        lambda unit, e: unit + ("" if e == 1 else f"^{e}"), names, st.sampled_from([1, 2, 3, -1, -2])
    )
    return st.lists(part, min_size=1, max_size=3).flatmap(
        lambda parts: st.lists(st.sampled_from("/*"), min_size=len(parts) - 1, max_size=len(parts) - 1).map(
            lambda signs: "".join(p + s for p, s in zip(parts, [*signs, ""]))
        )
    )


def exact(text: str) -> Fraction:
    """The factor of a unit as an exact rational, read in the plainest way."""
    value, sign = Fraction(1), 1
    for part in re.findall(r"[*/]|[^*/]+", text):
        if part in "*/":
            sign = 1 if part == "*" else -1
        elif part != "1":
            unit, _, exponent = part.partition("^")
            value *= EXACT[unit] ** (sign * int(exponent or 1))
    return value


def test_the_list_is_the_one_that_the_tests_know() -> None:
    assert set(UNITS) == set(EXACT)


@pytest.mark.parametrize(
    ("text", "dimension"),
    [
        ("1", NUMBER), ("m", LENGTH), ("m/s", SPEED), ("km/h", SPEED), ("m/s^2", ACCELERATION), ("m/s²", ACCELERATION),
        ("m/s/s", ACCELERATION), ("kg*m/s^2", FORCE), ("kg·m/s²", FORCE), ("N", FORCE), ("1/m", over(NUMBER, LENGTH)),
        ("m^-1", over(NUMBER, LENGTH)), ("1/s", over(NUMBER, TIME)), ("Hz", over(NUMBER, TIME)), ("rad", NUMBER),
        ("deg/s", over(NUMBER, TIME)), ("%", NUMBER), ("J", times(FORCE, LENGTH)), ("W", times(FORCE, SPEED)),
        ("m³", power(LENGTH, Fraction(3))), ("kg/m", over(MASS, LENGTH)), ("m^0", NUMBER),
    ],
)  # fmt: skip
def test_dimensions(text: str, dimension: Dimension) -> None:
    assert parse_unit(text)[2] == dimension


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("", ""), ("mph", "mph"), ("M", "M"), ("m/", ""), ("/s", ""), ("m//s", ""), ("m s", "m s"), ("m/sec", "sec"),
        ("km h", "km h"), ("²", ""), ("µs", "µs"),
    ],
)  # fmt: skip
def test_what_is_no_unit_is_refused(text: str, part: str) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(part)}$"):
        parse_unit(text)


def test_exponents_are_bounded() -> None:
    assert re.fullmatch(UNIT_PATTERN, "m^99")
    assert not re.fullmatch(UNIT_PATTERN, "m^100")


@pytest.mark.parametrize(
    ("number", "unit", "si"),
    [
        (60.0, "km/h", 60.0 * 1000.0 / 3600.0), (80.0, "km/h", 200.0 / 9.0), (100.0, "ms", 0.1), (1.0, "%", 0.01),
        (3.0, "cm", 0.03), (0.3, "mm", 0.0003), (180.0, "deg", math.pi), (7.0, "1/mm", 7000.0), (36.0, "m/min", 0.6),
        (1.0, "kN", 1000.0), (2.0, "t", 2000.0), (5.0, "us", 5e-6),
    ],
)  # fmt: skip
def test_conversions_that_people_know_are_exact(number: float, unit: str, si: float) -> None:
    assert to_si(number, unit) == si


@given(finite, unit_texts().filter(lambda text: "deg" not in text))
def test_a_conversion_is_off_by_two_roundings_at_most(number: float, unit: str) -> None:
    """Factors of the list are exact in binary or divide exactly, so only the product and the quotient round."""
    converted, true = to_si(number, unit), Fraction(number) * exact(unit)
    if math.isfinite(converted) and abs(true) > Fraction(1, 10**290):
        assert abs(Fraction(converted) - true) <= abs(true) * Fraction(3, 2**53)


@given(st.integers(-(10**6), 10**6), unit_texts().filter(lambda text: "deg" not in text))
def test_there_and_back(number: int, unit: str) -> None:
    assert from_si(to_si(float(number), unit), unit) == pytest.approx(float(number), rel=1e-15)


@given(dimensions, dimensions)
def test_dimensions_are_a_group(a: Dimension, b: Dimension) -> None:
    assert over(times(a, b), b) == a
    assert times(a, b) == times(b, a)
    assert power(power(a, Fraction(2)), Fraction(1, 2)) == a


@given(st.one_of(dimensions, fractional))
def test_what_is_shown_can_be_read(dimension: Dimension) -> None:
    assert parse_shown(show(dimension)) == dimension


@given(dimensions)
def test_what_is_shown_of_whole_exponents_is_a_unit(dimension: Dimension) -> None:
    assert parse_unit(show(dimension))[2] == dimension


@pytest.mark.parametrize(
    ("dimension", "shown", "spoken"),
    [
        (NUMBER, "1", "a plain number"), (SPEED, "m/s", "a speed"), (ACCELERATION, "m/s^2", "an acceleration"),
        (FORCE, "N", "a force"), (over(NUMBER, LENGTH), "1/m", "a curvature"),
        (times(MASS, LENGTH), "kg*m", "kg*m"), (power(LENGTH, Fraction(1, 2)), "m^(1/2)", "m^(1/2)"),
        (over(LENGTH, power(TIME, Fraction(3))), "m/s^3", "m/s^3"),
    ],
)  # fmt: skip
def test_how_messages_call_them(dimension: Dimension, shown: str, spoken: str) -> None:
    assert show(dimension) == shown
    assert name(dimension) == spoken
    assert quantity(dimension) == (
        spoken if dimension == NUMBER or spoken == shown else f"{spoken} [{shown}]"
    )


def test_what_is_not_shown_is_refused() -> None:
    with pytest.raises(ValueError, match="furlong"):
        parse_shown("furlong/s")


@pytest.mark.parametrize(
    ("number", "unit", "text"),
    [
        (to_si(130.0, "km/h"), "km/h", "130 km/h"), (36.0, "m/s", "36 m/s"), (1.1, "1", "1.1"), (100.00000000000001, "m", "100.00000000000001 m"),
        (1234567.0, "1", "1234567.0"), (math.inf, "m", "inf m"), (math.nan, "1", "nan"), (-0.5, "1/m", "-0.5 1/m"),
    ],
)  # fmt: skip
def test_numbers_that_differ_are_written_differently(number: float, unit: str, text: str) -> None:
    assert in_full(number, unit) == text


@pytest.mark.parametrize(
    ("full", "said"),
    [
        ("1.325178389398573", "≈ 1.32518"), ("16.666666666666668 m/s", "≈ 16.6667 m/s"), ("60 km/h", "60 km/h"), ("1.32518", "1.32518"),
        ("-0.3333333333333333 1/m", "≈ -0.333333 1/m"), ("1234567.0", "1234567.0"), ("nan", "nan"), ("inf m", "inf m"), ("-inf", "-inf"),
        ("9.80665 m/s^2", "9.80665 m/s^2"),
    ],
)  # fmt: skip
def test_sentences_have_six_digits(full: str, said: str) -> None:
    assert about(full) == said


@pytest.mark.parametrize(
    ("t", "said"),
    [
        (0.0, "0"), (2.6, "2.6"), (3 * 0.1, "0.3"), (86399.9, "86399.9"), (172800.05, "172800.05"), (1790000005.0999999, "1790000005.1"),
        (1790000005.1234567, "1790000005.123"), (-5e8 + 0.1, "-499999999.9"), (1e300, "1e+300"), (math.nan, "nan"),
    ],
)  # fmt: skip
def test_stamps_of_a_clock_that_counts_from_far_away_are_told_apart(t: float, said: str) -> None:
    assert moment(t) == said


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_what_is_left_out_of_a_number_is_little_and_said(value: float) -> None:
    said = about(in_full(value, "m"))
    number = float(said.removeprefix("≈ ").removesuffix(" m"))
    assert said.endswith(" m")
    assert (number == value) != said.startswith("≈ ")
    assert math.isclose(number, value, rel_tol=5.1e-6)
