"""What fingerprints are made of: rules that ask for different things are described differently, node by node and field by field."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import pytest

from support.supervised import shipped
from trackmarshal.evaluation import loads
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.description import describe

#: What says the same, however it is said: how a limit is shown, and on which side of a comparison it is written.
SILENT = {("Compare", "shown"), ("Compare", "turned")}

SIGNALS = """module m
signal ego : state { v: m/s }
signal plan : trajectory { t: s increasing, s: m, x: m, y: m, heading: rad, kappa: 1/m, v: m/s, a: m/s^2 }
"""
OPERATORS = ("<=", ">=", "<", ">")
#: Demands of which no two ask for the same.
COUNTS = [
    *(f"count(ego.v > 5 m/s, last: 1 s) {op} 2" for op in OPERATORS),
    *(f"count(rising(ego.v > 5 m/s), last: 1 s) {op} 2" for op in OPERATORS),
    "count(ego.v > 5 m/s, last: 2 s) <= 2",
    "count(ego.v > 5 m/s) <= 2",
    "count(ego.v > 5 m/s) >= 2",
    "count(ego.v > 5 m/s, reset: rising(ego.v > 7 m/s)) <= 2",
    "count(ego.v > 5 m/s, reset: rising(ego.v > 7 m/s)) >= 2",
]


def described(demand: str, where: str = "") -> str:
    (rule,) = loads(f'{SIGNALS}rule r "r"\n  {where}\n  require {demand}\n').rules
    assert rule.formula is not None
    return describe(rule.formula)


@pytest.mark.parametrize("where", ["", "along plan as p"])
def test_no_two_counts_are_described_alike(where: str) -> None:
    said = [
        (demand, described(demand.replace("ego.v", "p.v") if where else demand, where)) for demand in COUNTS
    ]
    alike = [(a, b) for (a, one), (b, other) in combinations(said, 2) if one == other]
    assert not alike


def other(value: Any) -> Any:
    match value:
        case bool():
            return not value
        case "<" | "<=":
            return "<=" if value == "<" else "<"  # of a comparison, which has no others
        case str():
            return f"{value}x"
        case int() | float():
            return value + 1
        case None:
            return 7
        case tuple():
            return (*value, *value[:1]) or ("x",)
        case _:
            return None


def test_every_field_of_every_node_is_told() -> None:
    nodes: dict[type, Any] = {}
    for rule in shipped().rules:
        if rule.formula is not None:
            nodes |= {type(node): node for node in ir.below(rule.formula)}
    assert len(nodes) > 20
    silent = set()
    for kind, node in nodes.items():
        for name in node.compared:
            new = other(getattr(node, name))
            if new is None:
                continue  # a node below, which is told of itself
            changed: Any = object.__new__(kind)
            changed.__dict__.update({**node.__dict__, name: new})
            if describe(changed) == describe(node):
                silent.add((kind.__name__, name))
    assert silent <= SILENT
