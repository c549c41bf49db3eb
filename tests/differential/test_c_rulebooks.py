"""Rulebooks in generated C against Python's: the same outcome and the same choice, for rulebooks and results of any shape."""

from __future__ import annotations

import ctypes
import itertools
import math
import random
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from support.agreement import compiled
from support.rulebooks import RULES, Relation
from support.sanitized import FLAGS as SANITIZED
from trackmarshal.backends.c.build import compiler, library
from trackmarshal.backends.c.report import report
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.backends.results import chosen_rules
from trackmarshal.ir.spec import Spec
from trackmarshal.rulebooks.candidates import choose, compare
from trackmarshal.rulebooks.comparing import BETTER, EQUAL, INCOMPARABLE, WORSE
from trackmarshal.rulebooks.order import Order, rulebook
from trackmarshal.runtime.verdict import VERDICTS

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

BOOKS = 60
OUTCOMES = (BETTER, WORSE, EQUAL, INCOMPARABLE)
MARGINS = (0.0, -0.0, -1.0, -1.0, -2.5, 3.0, -5e-324, -1.7e308, math.inf, -math.inf, math.nan)
Result = dict[str, tuple[str, float]]


def relations(r: random.Random) -> list[Relation]:
    level = {rule: r.randint(0, 2) for rule in RULES}
    found = []
    for one, other in itertools.combinations(RULES, 2):
        if r.random() < 0.4:
            upper, lower = sorted((one, other), key=level.__getitem__)
            found.append((upper, r.choice("~&") if level[one] == level[other] else ">", lower))
    return found


@cache
def spec() -> Spec:
    r = random.Random(7)
    text = "module ranked\n\nsignal ego : state { v: m/s }\n\n"
    text += "".join(f'rule {name} "{name}"\n  require ego.v < {i} m/s\n\n' for i, name in enumerate(RULES))
    for number in range(BOOKS):
        chains = [f"{a} {relation} {b}" for a, relation, b in relations(r)]
        text += f"rulebook book{number} {', '.join([*chains, r.choice(RULES)])}\n"
    return compiled(text)


@cache
def source() -> Source:
    return generate(spec(), chosen_rules(spec(), None))


class CResult(ctypes.Structure):
    _fields_ = [("margin", ctypes.c_double), ("verdict", ctypes.c_int)]


Output = CResult * len(RULES)


@cache
def dll() -> ctypes.CDLL:
    return ctypes.CDLL(str(library(source(), {})))


def results(r: random.Random) -> Result:
    few = r.sample(MARGINS, 3)  # so that candidates are often alike
    return {rule: (r.choice(VERDICTS), r.choice(few)) for rule in RULES}


def handed(result: Result) -> ctypes.Array[CResult]:
    return Output(*(CResult(margin, VERDICTS.index(verdict)) for verdict, margin in map(result.get, RULES)))  # type: ignore[misc]


@cache
def books() -> list[Order]:
    return [rulebook(spec(), f"book{number}") for number in range(BOOKS)]


@pytest.mark.parametrize("seed", range(5))
def test_the_outcome_is_the_same(seed: int) -> None:
    r = random.Random(seed)
    seen = set()
    for _ in range(400):
        number = r.randrange(BOOKS)
        one = results(r)
        other = {rule: one[rule] if r.random() < 0.5 else new for rule, new in results(r).items()}
        said = compare(books()[number], one, other).outcome
        found = getattr(dll(), f"tm_compare_book{number}")(
            ctypes.byref(handed(one)), ctypes.byref(handed(other))
        )
        assert OUTCOMES[found] == said, (number, one, other)
        seen.add(said)
    assert seen == set(OUTCOMES)


@pytest.mark.parametrize("seed", range(5))
def test_the_choice_is_the_same(seed: int) -> None:
    r = random.Random(100 + seed)
    sizes = set()
    for _ in range(100):
        number, count = r.randrange(BOOKS), r.randint(1, 7)
        many = [results(r) for _ in range(count)]
        best = (ctypes.c_bool * count)()
        pick = getattr(dll(), f"tm_choose_book{number}")
        pick.restype = ctypes.c_size_t
        chosen = pick((Output * count)(*map(handed, many)), ctypes.c_size_t(count), best)
        said = choose(books()[number], many)
        assert chosen == said.chosen
        assert tuple(place for place in range(count) if best[place]) == said.best
        sizes.add(len(said.best))
    assert {1, 2} <= sizes


def test_of_no_candidate_none_is_chosen() -> None:
    pick = dll().tm_choose_book0
    pick.restype = ctypes.c_size_t
    assert pick(None, ctypes.c_size_t(0), None) == 0


def test_a_verdict_that_is_none_counts_as_undefined() -> None:
    fine: Result = dict.fromkeys(RULES, ("undefined", 0.0))
    odd = handed(fine)
    for result in odd:
        result.verdict = 77
    for number in range(BOOKS):
        found = getattr(dll(), f"tm_compare_book{number}")(ctypes.byref(odd), ctypes.byref(handed(fine)))
        assert OUTCOMES[found] == EQUAL


def test_a_rulebook_of_which_a_rule_is_left_out_is_not_there() -> None:
    some = generate(spec(), chosen_rules(spec(), ["a"]))
    alone = [book for book in books() if set(book.rules) <= {"a"}]
    assert some.header.count("tm_outcome tm_compare_") == len(alone)
    assert source().header.count("tm_outcome tm_compare_") == BOOKS
    assert "`tm_compare_book7`" in report(source())


def test_rulebooks_of_one_name_get_a_number() -> None:
    text = 'module m\n\nevent e\n\nrule a "A"\n  require e\n\nrulebook Same a\nrulebook same a\nrulebook while a\n'
    header = generate(made := compiled(text), chosen_rules(made, None)).header
    for name in ("Same", "same_2", "while_"):
        assert f"tm_compare_{name}(" in header


PROGRAM = """#include "supervisor.h"
#include <stdio.h>

int main(void)
{
  static tm_context context;
  tm_output candidates[2];
  bool best[2];
  const double speed[2] = { 3.5, 0.5 };
  if (tm_init(&context) != TM_OK) { return 1; }
  for (size_t i = 0u; i < 2u; ++i) {
    tm_input in;
    in.ego.v = speed[i];
    if (tm_check(&context, &in, &candidates[i]) != TM_OK) { return 1; }
  }
  const size_t chosen = tm_choose_book0(candidates, 2u, best);
  (void)printf("%d %d %d\\n", (int)chosen, (int)best[0], (int)best[1]);
  return 0;
}
"""


@pytest.mark.parametrize("command", ["gcc", "clang"])
def test_strict_compilers_and_sanitizers_have_nothing_to_say(command: str, tmp_path: Path) -> None:
    if shutil.which(command) is None:
        pytest.skip(f"no {command}")
    for name, text in {
        "supervisor.h": source().header, "supervisor.c": source().source, "main.c": PROGRAM,
    }.items():  # fmt: skip
        (tmp_path / name).write_text(text)
    flags = [
        "-std=c99",
        "-pedantic",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Werror",
        "-ffp-contract=off",
        "-O1",
    ]
    flags += SANITIZED
    built = [command, *flags, "-o", "program", "main.c", "supervisor.c", "-lm"]
    subprocess.run(built, cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=True)
    assert done.stdout == "1 0 1\n"  # the slower one violates the first rule alone
