"""What looks back at what looks ahead: a cycle is kept for as long as a later one asks about it, in each evaluator, and after a restart."""

from __future__ import annotations

import random

import pytest

from support.length import amount, shared_out
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

AHEAD = (
    "(s.x < 0 until[0 s, 3 s] s.z > 0)",
    "(eventually[1 s, 2 s] s.z > 0)",
    "(always[0 s, 2 s] s.x < 1)",
    "(next s.z > 0)",
)
BACK = (
    "previous {}", "once {}", "historically {}", "{} since s.x > 1", "once[0 s, 2 s] {}", "historically[1 s, 2 s] {}",
    "{} since[0 s, 3 s] s.z > 1",
)  # fmt: skip

Said = dict[object, list[tuple[object, str, str]]]


def said(evaluator: Evaluator, rows: list[tuple[float, float, float]], restart: bool) -> Said:
    """By cycle what was said about it for good, and in which cycle."""
    run, found = evaluator.over_run(), Said()
    for k, (t, x, z) in enumerate(rows):
        if restart and k == len(rows) // 2:
            run = evaluator.over_run(list(run.save()))
        read = evaluator.read({"id": k, "t": t, "signals": {"s": {"x": x, "z": z}}})
        for one in run.step(read).rules["f"].about:
            if one.final:
                found.setdefault(one.cycle, []).append((k, one.verdict, one.margin.hex()))
    for one in run.end().get("f", ()):
        if one.final:
            found.setdefault(one.cycle, []).append(("end", one.verdict, one.margin.hex()))
    return found


def formulas() -> list[str]:
    chosen = random.Random(7)
    nested = [outer.format(f"({inner.format(ahead)})") for outer in BACK for inner in BACK for ahead in AHEAD]
    return [back.format(ahead) for back in BACK for ahead in AHEAD] + chosen.sample(
        nested, amount(6, len(nested))
    )


@pytest.mark.parametrize("formula", shared_out(formulas(), 4))
def test_all_say_the_same_of_every_cycle(formula: str) -> None:
    chosen = random.Random(formula)
    text = f'module m\nsignal s : state {{ x: 1, z: 1 }}\nrule f "x"\n  require {formula}\n'
    evaluators = {name: Evaluator(loads(text), backend=name) for name in ("reference", "numpy", "c")}
    for _ in range(amount(2, 3)):
        t, rows = 0.0, []
        for _ in range(14):
            t += chosen.choice((0.5, 1.0, 1.0, 2.0))
            rows.append((t, chosen.uniform(-2, 2), chosen.uniform(-2, 2)))
        found = {name: said(one, rows, False) for name, one in evaluators.items()}
        assert found["numpy"] == found["reference"]
        assert found["c"] == found["reference"]
        assert found["reference"].keys() == set(range(len(rows)))
        for name in ("numpy", "c"):
            assert said(evaluators[name], rows, True) == found["reference"], name


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        ("once[0 s, 9 s] (next o.v > 0)", "++++---"),
        ("once (next o.v > 0)", "++++---"),
        ("((next o.v > -9) since[0 s, 9 s] (next o.v > 0))", "+++----"),
        ("((o.v > -9) since[0 s, 9 s] (next o.v > 0))", "++++---"),
        ("((o.v > -9) since (next o.v > 0))", "++++---"),
        ("count(next o.v > 0, last: 9 s) >= 1", "++++---"),
        ("(previous (weak next o.v > 0))", "-++----"),
        ("(next o.v < 0)", "--+-+++"),
        ("eventually[1 s, 1 s] o.v < 0", "--+-+++"),
    ],
)
def test_who_takes_the_place_of_another_has_nothing_of_its_past(
    backend: str, formula: str, expected: str
) -> None:
    """`b` comes as `a` leaves: what is kept of `b` is kept where that of `a` was. By cycle, whether the formula holds."""
    text = f'module m\nsignal objects : set of object {{ v: 1 }}\nrule f "x"\n  for all o in objects\n  require {formula}\n'
    evaluator = Evaluator(loads(text), backend=backend)
    run, found = evaluator.over_run(), dict[object, str]()
    for k, (name, v) in enumerate([*zip("aaaa", (1, 1, 1, -1)), *zip("bbbb", (-1, -1, -1, -1))]):
        read = evaluator.read({"id": k, "t": k, "signals": {"objects": [{"id": name, "v": v}]}})
        found |= {one.cycle: one.verdict for one in run.step(read).rules["f"].about if one.final}
    said = "".join({"satisfied": "+", "violated": "-"}[found[k]] for k in range(7))
    assert said == expected


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
@pytest.mark.parametrize(
    ("window", "unknown"),
    [("[0 s, 1 s]", {1}), ("[3 s, 4 s]", set()), ("[2 s, 4 s]", {0}), ("[2 s, 2 s]", {0})],
)
def test_a_cycle_that_was_missed_is_in_the_windows_that_hold_more_than_its_neighbours(
    backend: str, window: str, unknown: set[int]
) -> None:
    """It would have come between 1 s and 3 s: not at 1 s, where the first window of all ends, nor at 3 s, where the second one begins."""
    text = f'module m\nsignal s : state {{ x: 1 }}\nrule f "x"\n  require always{window} s.x > 0\n'
    evaluator = Evaluator(loads(text), backend=backend)
    run, found = evaluator.over_run(), dict[object, str]()
    for t in (0, 1, 3, 4, 5, 6, 7, 8):
        if t == 3:
            run.missed()
        about = run.step(evaluator.read({"id": t, "t": t, "signals": {"s": {"x": 1}}})).rules["f"].about
        found |= {one.cycle: one.verdict for one in about if one.final}
    expected = {t: "undefined" if t in unknown else "satisfied" for t in (0, 1, 3, 4)}
    assert {t: found[t] for t in expected} == expected


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
def test_each_cycle_of_a_long_run_has_what_is_said_of_it_and_of_no_other(backend: str) -> None:
    """They are kept in a ring, in which the first comes after the last: what stood there was of another cycle."""
    chosen = random.Random(3)
    held = [chosen.random() < 0.4 for _ in range(40)]
    text = 'module m\nsignal s : state { x: 1 }\nrule f "x"\n  require (next s.x > 0)\n'
    evaluator = Evaluator(loads(text), backend=backend)
    run, found = evaluator.over_run(), dict[object, str]()
    for k, holds in enumerate(held):
        read = evaluator.read({"id": k, "t": k, "signals": {"s": {"x": 1 if holds else -1}}})
        found |= {one.cycle: one.verdict for one in run.step(read).rules["f"].about if one.final}
    assert list(found.values()) == ["satisfied" if holds else "violated" for holds in held[1:]]


Row = tuple[int, str, bool]


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
@pytest.mark.parametrize(
    ("whenever", "required", "first", "second"),
    [
        # That it does not apply is sure, whatever comes of what it would require.
        ("s.z > 0", "eventually[0 s, 2 s] s.x > 0", [(0, "inactive", True)], [(1, "satisfied", False)]),
        # What is required holds; whether it was required is open.
        ("(next s.z > 0)", "s.x < 0", [(0, "open", False)], [(1, "open", False), (0, "satisfied", True)]),
        ("(next s.z < 0)", "s.x < 0", [(0, "open", False)], [(1, "open", False), (0, "inactive", True)]),
        ("(next s.z > 0)", "s.x > 0", [(0, "open", False)], [(1, "open", False), (0, "violated", True)]),
    ],
)
def test_what_is_said_of_a_cycle_in_which_a_rule_may_not_apply(
    backend: str, whenever: str, required: str, first: list[Row], second: list[Row]
) -> None:
    text = f'module m\nsignal s : state {{ x: 1, z: 1 }}\nrule f "x"\n  whenever {whenever}\n  require {required}\n'
    evaluator = Evaluator(loads(text), backend=backend)
    run, found = evaluator.over_run(), list[list[Row]]()
    for t, sign in enumerate((-1, 1)):
        read = evaluator.read({"id": t, "t": t, "signals": {"s": {"x": sign, "z": sign}}})
        about = run.step(read).rules["f"].about
        found.append([(int(str(one.cycle)), one.verdict, one.final) for one in about])
    assert found == [first, second]
