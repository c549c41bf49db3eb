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


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_undefined_for_good_or_open_in_one_program() -> None:
    """The same of generated C, of many rules at once: one is compiled for all."""
    count = amount(12, 48)
    rules = "".join(f'rule f{seed} "x"\n  require {formula(random.Random(seed))}\n' for seed in range(count))
    evaluator = Evaluator(loads(HEAD.partition("rule")[0] + rules), None, "c")
    ways = list(product(product(["true", "false"], repeat=3), repeat=2))
    come = {
        (k, one): evaluator.read(cycle(k, one))
        for k in (1, 2)
        for one in product(["true", "false"], repeat=3)
    }
    seen = dict.fromkeys(("undefined", "open"), 0)
    dice = random.Random(3)
    for _ in range(3):
        now = evaluator.read(cycle(0, tuple(dice.choice([*SAID, "undefined"]) for _ in range(3))))
        first, ends = dict[str, str](), dict[str, set[str]]()
        for way in ways:
            run, last = evaluator.over_run(), dict[str, str]()
            read = [now, *(come[1 + k, one] for k, one in enumerate(way))]
            told = [{name: one.about for name, one in run.step(one).rules.items()} for one in read]
            for said in (*told, run.end()):
                last |= {name: one.verdict for name, about in said.items() for one in about if one.cycle == 0}
                first = first or dict(last)
            for name, verdict in last.items():
                ends.setdefault(name, set()).add(verdict)
        assert first.keys() == ends.keys() == {rule.name for rule in evaluator.rules}
        for name, verdict in first.items():
            assert "open" not in ends[name]
            if verdict in seen:
                seen[verdict] += 1
                assert ("satisfied" in ends[name]) == (verdict == "open"), (name, verdict, ends[name])
    assert min(seen.values()) >= 3, seen


@pytest.mark.parametrize(
    "backend",
    [
        "numpy",
        "reference",
        pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
    ],
)
def test_until_is_open_while_its_first_formula_holds(backend: str) -> None:
    """What is not known leaves it to the other one, which `p until q` holds where p holds now and q in the next cycle."""
    one, p, q = (f"ego.v{number} / ego.w{number} > 1" for number in range(3))
    evaluator = Evaluator(loads(f"{HEAD}{one} or ({p} until[0 s, 0.1 s] {q})\n"), None, backend)
    for held, expected in (("true", "open"), ("false", "undefined")):
        (said,) = (
            evaluator.over_run().step(evaluator.read(cycle(0, ("undefined", held, "false")))).rules["f"].about
        )
        assert said.verdict == expected
