"""A constraint about a parameter that has an error of its own: what is wrong with the parameter is said, and nothing breaks over it."""

from __future__ import annotations

import pytest

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
