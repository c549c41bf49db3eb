"""Elements that are absent for a while and keep their history, in generated C: what the other evaluators say, to the last bit."""

from __future__ import annotations

import json
import random
import subprocess
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from differential.test_c_over_run import _SETTINGS, OTHERS, one_memory, said
from property.test_forgetting import KEPT, LASTING, rule
from support import run_pairs
from support.length import amount, shared_out
from support.run_formulas import formulas, runs
from support.start import STRICT
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.source import generate
from trackmarshal.evaluation import Evaluator, loads

#: Runs of one program.
RUNS = amount(5, 20)

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")
#: What looks ahead ends with an absence, whatever is remembered.
AHEAD = (
    "always[0 s, 0.4 s] o.v > 0 m/s", "next o.v > 0 m/s", "once[0 s, 0.5 s] o.v > 1 m/s implies eventually[0.1 s, 0.6 s] flag",
    "(m(o) is q) until[0 s, 0.5 s] o.v <= ego.v",
)  # fmt: skip


@given(
    LASTING,
    st.lists(formulas(True, ahead=False), min_size=8, max_size=8),
    st.lists(runs(), min_size=min(RUNS, 12), max_size=min(RUNS, 12)),
)
@_SETTINGS
def test_all_three_agree(lasting: str, drawn: list[str], several: list[list[dict[str, Any] | None]]) -> None:
    bodies = [*drawn, *AHEAD, KEPT, "not (m(o) is r)", f"(m(o) is q) iff once[0 s, 0.3 s] ({KEPT})"]
    text = rule(lasting, "require flag") + "".join(
        f'rule f{n} "x" for all o in objects require {one}\nrule g{n} "x" require exists o in objects: ({one})\n'
        for n, one in enumerate(bodies)
    )
    spec = loads(text)
    evaluators = {name: Evaluator(spec, backend=name) for name in (*OTHERS, "c")}
    for cycles in several:
        found = said(evaluators, cycles)
        assert found["c"] == found["reference"] == found["numpy"], text


@given(
    run_pairs.LASTING,
    run_pairs.LASTING,
    st.sampled_from([run_pairs.SETS, run_pairs.SETS[::-1], ("objects", "objects")]),
    st.lists(run_pairs.paired(False), min_size=8, max_size=8),
    st.lists(run_pairs.runs(), min_size=RUNS, max_size=RUNS),
)
@_SETTINGS
def test_pairs_of_elements(
    first: str,
    second: str,
    sets: tuple[str, str],
    drawn: list[str],
    several: list[list[dict[str, Any] | None]],
) -> None:
    """Pairs of which one element may be absent, or both, or none."""
    text = run_pairs.signals(first, second) + run_pairs.rules(drawn, sets)
    evaluators = {name: Evaluator(loads(text), backend=name) for name in (*OTHERS, "c")}
    for cycles in several:
        found = said(evaluators, cycles)
        assert found["c"] == found["reference"] == found["numpy"], text


#: Elements and pairs that may be absent, of sets that have room for fewer than there are.
SCARCE = """module m
signal cars : set of object { v: m/s } capacity 3 forget 0.3 s
signal people : set of object { v: m/s } capacity 2 forget 0.5 s
rule a "" for all c in cars require once[0 s, 0 s] c.v > 1 m/s
rule b "" for all c in cars for all p in people require once[0 s, 2 s] c.v > p.v + 1 m/s
rule c "" for all c in cars for all d in cars require not rising(c.v > d.v)
rule d "" for all c in cars for all p in people require count(c.v > p.v, last: 2 s) <= 4
rule e "" for all c in cars require count(c.v > 0 m/s, last: 1 s) <= 4
rule f "" for all c in cars require historically[0.1 s, 0.2 s] c.v > -1 m/s
"""


def test_absences_that_end_at_the_last_moment_or_behind_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stamps are tenths of a second, as the times of absences are; each run begins in what the one before leaves in memory."""
    one_memory(monkeypatch)
    spec = loads(SCARCE)
    evaluators = {name: Evaluator(spec, backend=name) for name in ("numpy", "c")}
    for seed in (9, 31, 9):  # of sixty ones, those of which each mistake that could be planted changes one
        dice, t, cycles = random.Random(seed), 0.0, list[dict[str, Any] | None]()
        there: dict[str, set[str]] = {"cars": set(), "people": set()}
        for number in range(60):
            t = round(t + dice.choice([0.1, 0.1, 0.1, 0.1, 0.2, 0.3, 0.6]), 9)
            signals = dict[str, Any]()
            for name, names, most in (("cars", "abcd", 3), ("people", "abc", 2)):
                there[name] ^= {one for one in names if dice.random() < 0.3}
                ids = [one for one in names if one in there[name]]
                dice.shuffle(ids)
                ids = ids[:most]
                signals[name] = {"id": ids, "v": [dice.choice([-1.0, 0.0, 0.5, 2.0]) for _ in ids]}
            cycles.append(None if dice.random() < 0.05 else {"id": number, "t": t, "signals": signals})
        found = said(evaluators, cycles)
        assert found["c"] == found["numpy"]


#: Of pairs of cars, of cars and people, who may be absent too, and of cars and lights, which may not.
PAIRS = """module m
event flag
signal cars : set of object { v: m/s } capacity 4 forget 0.3 s
signal people : set of object { v: m/s } capacity 3 forget 0.6 s
signal lights : set of object { v: m/s }
rule a "" for all c in cars for all d in cars require once[0 s, 1 s] c.v > d.v + 1 m/s
rule b "" for all c in cars for all p in people require historically[0.2 s, 2 s] c.v > p.v - 3 m/s
rule c "" for all l in lights for all c in cars require c.v > -1.9 m/s since[0.1 s, 1 s] c.v > l.v
rule d "" for all p in people for all c in cars require count(c.v > p.v, last: 0.8 s) <= 3
rule e "" for all c in cars for all l in lights require count(c.v > l.v, reset: l.v > 1.8 m/s) <= 5
rule f "" for all c in cars for all d in cars where d.v > 0 m/s require not rising(c.v > d.v)
rule g "" for all p in people for all l in lights require p.v > -1.8 m/s since p.v > l.v
rule h "" for all l in lights for all o in lights require once (l.v > o.v)
state m : { p, q } for each c in cars starts p
  becomes q when c.v > 1.5 m/s
    remember took = c.v
  becomes p when c.v < -1.5 m/s
rule i "" for all c in cars for all d in cars require once[0 s, 0.4 s] (m(c) is p and m(d) is q or m(c).took > d.v + 2 m/s)
"""


def scarce(dice: random.Random, many: int) -> list[dict[str, Any] | None]:
    """Cycles of three sets whose elements come and go, of some more than there are places for."""
    t, cycles = 0.0, list[dict[str, Any] | None]()
    sets = {"cars": ("abcdef", 4), "people": ("abcd", 3), "lights": ("abc", 3)}
    away: dict[tuple[str, str], float] = {}
    for number in range(many):
        t = round(t + dice.choice([0.01, 0.05, 0.05, 0.1, 0.1, 0.4]), 9)
        signals: dict[str, Any] = {"flag": dice.random() < 0.3}
        for name, (names, most) in sets.items():
            for one in names:
                if (name, one) not in away and dice.random() < 0.12:
                    away[name, one] = t + dice.choice([0.05, 0.2, 0.5, 1.5])
                elif away.get((name, one), t) < t:
                    del away[name, one]
            there = [one for one in names if (name, one) not in away]
            dice.shuffle(there)
            signals[name] = {"id": there[:most], "v": [dice.uniform(-2, 2) for _ in there[:most]]}
        cycles.append(None if dice.random() < 0.04 else {"id": number, "t": t, "signals": signals})
    return cycles


@pytest.mark.acceptance  # short ones every day
def test_long_runs_of_pairs_saved_in_between() -> None:
    """Pairs come apart and meet again, with some that find no place; saved and restored, C goes on as if it had not stopped."""
    spec, dice = loads(PAIRS), random.Random(5)
    cycles = scarce(dice, amount(120, 2000))
    evaluators = {name: Evaluator(spec, backend=name) for name in ("numpy", "c")}
    found = said(evaluators, cycles)
    assert found["c"] == found["numpy"]
    for name in "abcdefghi":
        assert len({each[name][0] for each in found["c"][:-1]}) >= 3, name
    run, every = evaluators["c"].over_run(), list[Any]()
    for cycle in cycles:
        if dice.random() < 0.1:
            run = evaluators["c"].over_run(json.loads(json.dumps(run.save())))
        if cycle is None:
            run.missed()
        else:
            rules = run.step(evaluators["c"].read(cycle)).rules
            every.append({name: one.verdict for name, one in rules.items()})
    assert every == [{name: one[0] for name, one in each.items()} for each in found["c"][:-1]]


@pytest.mark.acceptance  # short ones every day
def test_long_runs_in_which_places_are_scarce() -> None:
    """Runs of many cycles, saved and restored in between: elements come and go, more than there are places for."""
    spec = loads(
        "module m\nevent flag\nsignal objects : set of object { v: m/s } capacity 4 forget 0.3 s\n"
        'rule a "" for all o in objects require once[0 s, 1 s] o.v > 1 m/s\n'
        'rule b "" for all o in objects require historically[0.2 s, 2 s] o.v > -1.9 m/s\n'
        'rule c "" for all o in objects require o.v > -1.5 m/s since[0.1 s, 1 s] o.v > 1.5 m/s\n'
        'rule d "" for all o in objects require count(o.v > 1 m/s, last: 0.8 s) <= 3\n'
        'rule e "" for all o in objects require count(o.v > 0 m/s, reset: o.v > 1.8 m/s) <= 5\n'
        'rule f "" for all o in objects require not rising(o.v > 1 m/s)\n'
        'rule g "" for all o in objects require o.v > -1.8 m/s since o.v > 1 m/s\n'
        'rule h "" for all o in objects require always[0 s, 0.3 s] o.v > -1.9 m/s\n'
        'rule i "" whenever exists o in objects: once[0 s, 0.5 s] o.v > 1.9 m/s within 0.4 s require flag\n'
        "state m : { p, q } for each o in objects starts p\n"
        "  becomes q when o.v > 1.5 m/s\n    remember took = o.v\n  becomes p when o.v < -1.5 m/s\n"
        'rule j "" for all o in objects require m(o) is p or m(o).took > 1.6 m/s or time_in(m(o)) < 0.5 s\n'
    )
    dice = random.Random(11)
    t, there, cycles = 0.0, list("abcdef"), list[dict[str, Any] | None]()
    away: dict[str, float] = {}
    for number in range(amount(150, 3000)):
        t = round(t + dice.choice([0.01, 0.05, 0.05, 0.1, 0.1, 0.4]), 9)
        for name in there:
            if name not in away and dice.random() < 0.15:
                away[name] = t + dice.choice([0.05, 0.2, 0.5, 1.5])
            elif away.get(name, t) < t:
                del away[name]
        present = [name for name in there if name not in away]
        dice.shuffle(present)
        objects = {"id": present[:4], "v": [dice.uniform(-2, 2) for _ in present[:4]]}
        signals = {"objects": objects, "flag": dice.random() < 0.3}
        cycles.append(None if dice.random() < 0.04 else {"id": number, "t": t, "signals": signals})
    evaluators = {name: Evaluator(spec, backend=name) for name in ("numpy", "c")}
    found = said(evaluators, cycles)
    assert found["c"] == found["numpy"]
    for name in "abcdefghij":
        assert len({each[name][0] for each in found["c"][:-1]}) >= 3, name
    for backend, evaluator in evaluators.items():
        run, every = evaluator.over_run(), list[Any]()
        for cycle in cycles:
            if dice.random() < 0.1:
                run = evaluator.over_run(json.loads(json.dumps(run.save())))
            if cycle is None:
                run.missed()
            else:
                every.append(
                    {name: one.verdict for name, one in run.step(evaluator.read(cycle)).rules.items()}
                )
        assert every == [{name: one[0] for name, one in each.items()} for each in found[backend][:-1]]


@pytest.mark.parametrize(
    ("body", "doored"),
    shared_out(
        [
            (AHEAD[0], False), (AHEAD[0], True), ("once[0.1 s, 0.5 s] o.v > 0 m/s", True), ("once[0.1 s, 0.5 s] o.v > 0 m/s", False),
            ("previous o.v > 0 m/s", False), ("previous o.v > 0 m/s", True), (KEPT, True), (KEPT, False),
        ], 4,
    ),
)  # fmt: skip
def test_each_by_itself_compiles_without_a_warning(body: str, doored: bool, tmp_path: Path) -> None:
    text = rule(" capacity 3 forget 0.7 s\n", f"for all o in objects require {body}")
    if doored:
        plan = "signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }\n"
        text = text.replace(
            "signal ego : state { ", f"{plan}signal ego : state {{ x: m, y: m, heading: rad, "
        )
    spec = loads(text)
    made = generate(spec, spec.rules, "made", doored=doored)
    (tmp_path / "made.h").write_text(made.header, encoding="utf-8")
    (tmp_path / "made.c").write_text(made.source, encoding="utf-8")
    found = compiler()
    assert found is not None
    command = [*found, *STRICT, "-c", "made.c", "-o", "made.o"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
