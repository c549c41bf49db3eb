"""A cycle is undefined for good where nothing that can come makes its rule hold, and open where something does: all continuations are tried."""

from __future__ import annotations

import random
from itertools import product
from typing import Any

import pytest

from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads

pytestmark = pytest.mark.verifies("S-1-B-1")
HEAD = """module m
signal ego : state { v0: m, w0: m, v1: m, w1: m, v2: m, w2: m }
rule f "x"
  require """
#: What each of three formulas is, each of numbers of its own, and so whatever the others are: true, false, undefined.
SAID: dict[str, tuple[float, float]] = {"true": (2.0, 1.0), "false": (0.0, 1.0), "undefined": (1.0, 0.0)}


def formula(dice: random.Random) -> str:
    """Each of the three once, below connectives, operators that look ahead no further than two cycles, and connectives again."""
    leaves = [f"ego.v{number} / ego.w{number} > 1" for number in range(3)]
    dice.shuffle(leaves)

    def joined(one: str, other: str) -> str:
        return f"({one} {dice.choice(['and', 'or', 'implies', 'iff', 'xor'])} {other})"

    def negated(text: str) -> str:
        return f"(not ({text}))" if dice.random() < 0.3 else text

    def ahead(*parts: str) -> str:
        window = dice.choice(["[0 s, 0.2 s]", "[0 s, 0.1 s]", "[0.1 s, 0.2 s]", "[0 s, 0 s]"])
        if len(parts) == 2:
            return f"({parts[0]} until{window} ({parts[1]}))"
        word = dice.choice([f"always{window}", f"eventually{window}", "next", "weak next"])
        return f"({word} ({parts[0]}))"

    one, other, third = map(negated, leaves)
    match dice.randrange(5):
        case 0:
            made = joined(ahead(one), joined(other, third))
        case 1:
            made = joined(ahead(joined(one, other)), third)
        case 2:
            made = joined(ahead(one, other), third)
        case 3:
            made = joined(ahead(one), ahead(other, third))
        case _:
            made = ahead(one, joined(other, third))
    return negated(made)


def cycle(number: int, said: tuple[str, ...]) -> dict[str, Any]:
    fields = {}
    for place, name in enumerate(said):
        fields[f"v{place}"], fields[f"w{place}"] = SAID[name]
    return {"id": number, "t": number / 10, "signals": {"ego": fields}}


def verdicts(evaluator: Evaluator, cycles: list[dict[str, Any]]) -> tuple[str, str]:
    """What the rule says of the first cycle in that one, and in the end."""
    run, said = evaluator.over_run(), list[str]()
    for one in cycles:
        said += [each.verdict for each in run.step(evaluator.read(one)).rules["f"].about if each.cycle == 0]
    said += [each.verdict for each in run.end().get("f", ()) if each.cycle == 0]
    return said[0], said[-1]


C = pytest.param(
    "c", marks=[pytest.mark.acceptance, pytest.mark.skipif(compiler() is None, reason="no C compiler")]
)


@pytest.mark.parametrize("backend", ["numpy", "reference", C])
def test_undefined_for_good_or_open(backend: str) -> None:
    seen = dict.fromkeys(("undefined", "open"), 0)
    for seed in range(amount(8, 300 if backend != "c" else 60)):
        dice = random.Random(seed)
        evaluator = Evaluator(loads(HEAD + formula(dice) + "\n"), None, backend)
        now = cycle(0, tuple(dice.choice([*SAID, "undefined"]) for _ in range(3)))
        ways = list(product(product(["true", "false"], repeat=3), repeat=2))
        dice.shuffle(ways)
        ends = set[str]()
        for way in ways:
            first, last = verdicts(evaluator, [now, *(cycle(1 + k, one) for k, one in enumerate(way))])
            ends.add(last)
            if first == "open" and "satisfied" in ends:
                break
        if first in seen:
            seen[first] += 1
            assert ("satisfied" in ends) == (first == "open"), (seed, first, ends)
    assert all(seen.values()), seen
