"""A constraint about a parameter that has an error of its own: what is wrong with the parameter is said, and nothing breaks over it."""

from __future__ import annotations

import pytest

from trackmarshal.cli.check import unconstrained
from trackmarshal.evaluation import broken_constraints
from trackmarshal.semantics.compile import compile_text

SPEC = """module m
param least : m/s^2 = 1 m/s^2
param b_max : m/s^2 = {}
constrain least <= b_max because "what is least is not most"
constrain least >= 2 m/s^2 because "it is too little"
"""


@pytest.mark.parametrize("wrong", ["6 kg", "6 m/s^2 in [12, 1]"])
def test_a_constraint_that_names_what_has_an_error(wrong: str) -> None:
    made = compile_text(SPEC.format(wrong))
    assert made.errors
    (broken,) = broken_constraints(made.spec)  # the other one is about what is there
    assert "least >= 2 m/s^2" in broken


def of_a_table(rows: str) -> list[str]:
    made = compile_text(f"""module m
table g(x: m, y: m) -> m = linear | y: 0 m, 1 m | {rows} |
constrain g(0.5 m, 0.5 m) > 3 m
""")
    return [f"{one.code} {one.message}" for one in (*made.errors, *unconstrained(made))]


def test_a_constraint_that_asks_a_table_of_two_arguments() -> None:
    wrong = of_a_table("0 m: 1 m, 2 s | 1 m: 1 m, 2 m")
    assert len(wrong) == 1
    assert wrong[0].startswith("E302")
    assert of_a_table("0 m: 1 m, 2 m | 1 m: 1 m, 2 m") == [
        "E307 this constraint does not hold: a table breaks it"
    ]


def test_a_constraint_of_numbers_alone() -> None:
    made = compile_text('module m\nconstrain 1/0 > 3 because "it is a mistake"\n')
    (broken,) = unconstrained(made)
    assert broken.message == "this constraint does not hold: its own numbers break it"
