"""Lanes at the door of a Supervisor in generated C: its decisions, faults and margins are those of the one in Python, whatever comes."""

from __future__ import annotations

import ctypes
import random
import subprocess
import threading
from collections import Counter
from dataclasses import asdict, replace
from functools import cache
from itertools import repeat
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from support.decision_lines import decision_lines
from support.emitted import emit
from support.length import amount, at_length
from support.pairs import Pair
from support.sanitized import FLAGS as SANITIZED
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.source import Source, generate
from trackmarshal.backends.c.step import Stepper
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.process.serving import build
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.faults import name_of
from unit.test_c_integrity import names, switched

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

TEXT = """module made.lanes
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal others : set of object { x: m }
signal lanes : set of lane { left: polyline, right: polyline, limit: km/h in [0, 300] default 180 km/h }
rule limits "x"
  for all l in lanes where footprint(ego, 4 m, 2 m) meets l
  require ego.v <= l.limit
rule kept "x"
  for all p in plan
  require exists l in lanes: (swept_footprint(p, 4 m, 2 m) inside l or swept_footprint(p, 4 m, 2 m) meets l)
rule beside "x"
  for nearest l in lanes by distance_to(ego, l)
  require abs(offset(ego, l)) <= 3 m and distance_to(ego, l.left) + distance_to(ego, l.right) <= 6 m
rule was "x"
  for all l in lanes where footprint(ego, 4 m, 2 m) meets l
  require once[0 s, 0.3 s] (footprint(ego, 4 m, 2 m) inside l)
"""
STRICT = ["-std=c99", "-O0", "-ffp-contract=off", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror"]
LIMITS = Limits(elements=4, border=6, budget=1e9)


@cache
def evaluator(more: str = "") -> Evaluator:
    """more: what is declared of the set of lanes besides."""
    return Evaluator(loads(TEXT.replace("default 180 km/h }", f"default 180 km/h }} {more}")))


def road(rng: random.Random, y: float, count: int) -> dict[str, Any]:
    across = [rng.choice([0.0, 0.0, rng.uniform(-1, 1)]) for _ in range(count)]
    x = [-10.0 + 60.0 * k / (count - 1) for k in range(count)]
    left, right = ([[a, y + w + b] for a, b in zip(x, across)] for w in (2.0, -2.0))
    return {"left": left, "right": right, "limit": rng.choice([50.0, 90.0])}


def lanes(rng: random.Random, kept: list[dict[str, Any]]) -> Any:
    """Some roads, most often those of the cycle before, with something wrong now and then."""
    if not kept or rng.random() < 0.3:
        kept[:] = [road(rng, 4.0 * k, rng.randint(2, 5)) for k in range(rng.randint(0, 4))]
    made = [dict(each, id=f"lane{k}") for k, each in enumerate(kept)]
    if rng.random() < 0.3:
        rng.shuffle(made)
    for _ in range(rng.choice([0, 0, 1, 2])):
        if not made:
            break
        one = rng.choice(made)
        match rng.randrange(9):
            case 0:
                one["left"] = list(one["left"])[::-1]
            case 1:
                one["right"] = road(rng, 0.0, 7)["right"]  # one more than there is room for
            case 2:
                one["left"] = one["left"][:1]
            case 3:
                one["left"] = [[float("nan"), 1.0], *one["left"]]
            case 4:
                one["right"] = None
            case 5:
                one["limit"] = rng.choice([None, 400.0, float("inf")])
            case 6:
                one["left"] = "no line"
            case 7:
                made += [dict(road(rng, 50.0, 2), id=f"more{k}") for k in range(5)]
            case _:
                one["id"] = "lane0"
    return rng.choice([made] * 30 + [None, 7, []])


def candidate(rng: random.Random, stops: bool) -> dict[str, Any]:
    y = rng.choice([0.0, 2.0, 5.0])
    return {
        "t": [0.0, 1.0, 2.0], "x": [0.0, 9.0, 18.0], "y": [y, y, y + rng.choice([0.0, 0.7])], "heading": [0.0, 0.0, 0.1],
        "kappa": [0.0, rng.choice([0.0, 0.02]), 0.0], "v": [10.0, 9.0, 0.0 if stops else 8.0],
    }  # fmt: skip


@pytest.mark.parametrize("seed", amount(range(1), range(40)))
@pytest.mark.parametrize("more", [at_length(""), "capacity 3 forget 0.3 s"])
def test_whatever_comes(more: str, seed: int) -> None:
    rng, pair, seen = random.Random(seed), Pair(evaluator(more), limits=LIMITS), Counter[str]()
    kept: list[dict[str, Any]] = []
    for number in range(60):
        ego = {"x": 0.0, "y": rng.choice([0.0, 0.5, 3.0]), "heading": 0.0, "v": 10.0}
        driving, now = candidate(rng, False), 0.1 * number
        emergency = {**candidate(rng, True), "y": driving["y"]}
        given = Cycle(number, now, driving, emergency, {"ego": ego, "lanes": lanes(rng, kept)})
        decision = pair.step(given, now, now)
        seen.update({name_of(fault) for fault in decision.faults} or {"none"})
        seen[f"safe {decision.safe}"] += 1
    assert seen["none"] > 5
    assert seen["bad_border"] + seen["over_capacity"] > 3


def test_all_that_can_be_wrong_came() -> None:
    """The faults of the runs above, by their names."""
    seen: set[str] = set()
    for seed in range(12):
        rng, kept = random.Random(seed), list[dict[str, Any]]()
        box: Any = tm.supervisor(evaluator().spec, backend="c", limits=LIMITS, clock=lambda: 0.0)
        for _ in range(40):
            given = lanes(rng, kept)
            ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0}
            plan = candidate(rng, True)
            seen |= {
                name_of(f) for f in box.step(Cycle(0, 0.0, plan, plan, {"ego": ego, "lanes": given})).faults
            }
    assert {"bad_border", "over_capacity", "missing", "out_of_range", "wrong_type", "duplicate"} <= seen


def test_one_without_a_point_is_told_of_beside_one_that_is_missing() -> None:
    """C took both for missing, of which whoever read them has told."""
    good = [[-9.0, 2.5], [60.0, 2.5]]
    given = [
        {"left": left, "right": good, "limit": 90.0, "id": name} for name, left in (("a", []), ("b", None))
    ]
    plan, ego = candidate(random.Random(0), True), {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0}
    pair = Pair(evaluator(), limits=LIMITS)
    decision = pair.step(Cycle(0, 0.0, plan, plan, {"ego": ego, "lanes": given}), 0.0, 0.0)
    told = [(name_of(fault), fault.field, fault.index) for fault in decision.faults]
    assert told == [("missing", "left", 1), ("bad_border", "", 0)]


def test_of_columns_that_differ_in_length_the_shortest_counts() -> None:
    """C looked at as many lanes as the set has, and Python at all borders that came."""
    good, crossing = [[-9.0, 2.5], [60.0, 2.5]], [[-9.0, -2.5], [60.0, 3.5]]
    given = {
        "left": [good, crossing],
        "right": [[[-9.0, -2.5], [60.0, -2.5]], good],
        "limit": [90.0],
        "id": ["a", "b"],
    }
    plan, ego = candidate(random.Random(0), True), {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0}
    decision = Pair(evaluator(), limits=LIMITS).step(
        Cycle(0, 0.0, plan, plan, {"ego": ego, "lanes": given}), 0.0, 0.0
    )
    assert {name_of(fault) for fault in decision.faults} == {"wrong_length"}


def test_a_program_whose_rules_ask_for_no_place(tmp_path: Path) -> None:
    """The door looks at the borders of lanes all the same: what it prepares them in was not declared."""
    text = TEXT[: TEXT.index("rule limits")]
    spec = loads(text + 'rule slow "x"\n  for all l in lanes\n  require ego.v <= l.limit\n')
    crossing, rng = [[-9.0, -2.5], [60.0, 3.5]], random.Random(0)
    good = {**road(rng, 0.0, 2), "limit": 90.0, "id": "a"}
    plan, ego = candidate(rng, True), {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0}
    pair = Pair(Evaluator(spec), limits=LIMITS)
    for number, left in enumerate((good["left"], crossing)):
        given = Cycle(number, 0.1 * number, plan, plan, {"ego": ego, "lanes": [{**good, "left": left}]})
        decision = pair.step(given, 0.1 * number, 0.1 * number)
        assert [name_of(fault) for fault in decision.faults] == ["bad_border"] * number
    made = generate(spec, list(spec.rules), doored=True)
    (tmp_path / "supervisor.h").write_text(made.header)
    (tmp_path / "supervisor.c").write_text(made.source)
    subprocess.run(["cc", *STRICT, "-fsyntax-only", "supervisor.c"], cwd=tmp_path, check=True)


def test_two_in_two_threads_have_lanes_of_their_own() -> None:
    """Python is let go on while a step is taken: where both kept the borders of their lanes at one place, each was judged in those of the other."""
    text = TEXT[: TEXT.index("rule limits")]
    spec = loads(text + 'rule kept "x"\n  require exists l in lanes: (footprint(ego, 4 m, 2 m) inside l)\n')
    x = [-10.0 + 0.1 * k for k in range(600)]

    def around(y: float) -> dict[str, Any]:
        return {name: tm.line([[a, y + side] for a in x]) for name, side in (("left", 2.0), ("right", -2.0))}

    # Of the lanes of the first one, the last has the car in it; of the second one, none. All of them are new in every cycle.
    sets = [
        [[around(10.0 * k) | {"id": str(k), "limit": 50.0} for k in (1, 2, 3, 4, 5, last)] for _ in range(2)]
        for last in (0, 6)
    ]
    limits = Limits(elements=8, border=600, budget=1e9, oldest=1e9)
    now = [0.0, 0.0]
    clocks = (lambda: now[0]), (lambda: now[1])
    boxes = [tm.supervisor(spec, backend="c", limits=limits, clock=clock) for clock in clocks]
    plan = candidate(random.Random(0), True)
    safe: list[list[bool]] = [[], []]
    together = threading.Barrier(2)

    def drive(which: int) -> None:
        for number in range(30):
            now[which] = 0.1 * number
            ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0}
            given = Cycle(number, now[which], plan, plan, {"ego": ego, "lanes": sets[which][number % 2]})
            together.wait(30)
            safe[which].append(boxes[which].step(given).safe)

    threads = [threading.Thread(target=drive, args=(which,)) for which in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert safe == [[True] * 30, [False] * 30]


@pytest.mark.acceptance
def test_emitted(tmp_path: Path) -> None:
    """The Supervisor in C that is emitted, sanitized and without a warning, decides of a record what Python decided."""
    (tmp_path / "m.spec").write_text(TEXT.replace("module made.lanes", "module m"), encoding="utf-8")
    now, expected, rng, kept = 0.0, list[str](), random.Random(2), list[dict[str, Any]]()
    recorded: Any = tm.supervisor(
        tm.load([tmp_path / "m.spec"]),
        backend="numpy",
        limits=LIMITS,
        clock=lambda: now,
        record=tmp_path / "run.arrows",
    )
    for number in range(80):
        now = 0.1 * number
        ego = {"x": 0.0, "y": rng.choice([0.0, 0.5]), "heading": 0.0, "v": 10.0}
        driving = candidate(rng, False)
        emergency = {**candidate(rng, True), "y": driving["y"]}
        given = Cycle(number, now, driving, emergency, {"ego": ego, "lanes": lanes(rng, kept)})
        expected += decision_lines(recorded.step(given))
    recorded.close()
    made = emit(
        tmp_path / "out", recordings=[tmp_path / "run.arrows"], spec=tmp_path / "m.spec", root=tmp_path
    )
    sizes = ["-DTM_MAX_ELEMENTS=4u", "-DTM_MAX_BORDER=6u"]
    command = [
        "cc",
        *STRICT,
        *SANITIZED,
        *sizes,
        "supervisor.c",
        "main.c",
        "cycles.c",
        "-o",
        "example",
        "-lm",
    ]
    subprocess.run(command, cwd=made, check=True)
    ran = subprocess.run([made / "example", made / "run.cycles"], capture_output=True, text=True, check=True)
    decisions, wanted = (
        [line.split()[:4] for line in text if line.startswith("decision ")]
        for text in (ran.stdout.splitlines(), expected)
    )
    assert decisions == wanted
    assert {words[2] for words in wanted} == {"safe", "unsafe"}
    assert len({words[3] for words in wanted}) == 3


def test_a_process_takes_none() -> None:
    with pytest.raises(TrackmarshalError, match="no place for the lanes") as caught:
        build(evaluator().spec, evaluator().rules, LIMITS)
    assert caught.value.code == "E476"


@cache
def emptied() -> tuple[Source, tuple[str, ...]]:
    """The program, with functions that do nothing while `tmg_emptied` has their number; and what they are called."""
    source = generate(evaluator().spec, evaluator().rules, doored=True)
    found = tuple(name for name, _ in names(source.source))
    return replace(source, source=switched(source.source)), found


@pytest.mark.parametrize(
    "name", ["tm_lanes_lanes", "tm_set_lanes", "tm_make_corridor", "tm_make_line", "tm_make_centre"]
)
@pytest.mark.parametrize("answer", [0, 1])
def test_a_part_that_does_not_run(name: str, answer: int) -> None:
    """Nothing is safe in which lanes were not looked at, or not prepared."""
    source, known = emptied()
    good = [
        {"left": [[-9.0, 2.5], [60.0, 2.5]], "right": [[-9.0, -2.5], [60.0, -2.5]], "limit": 90.0, "id": "a"}
    ]
    crossing = [{**good[0], "left": [[-9.0, 2.5], [60.0, -3.0]]}]
    slow = [{**good[0], "limit": 18.0}]
    limits = replace(LIMITS, oldest=1e9)
    found, readings = [], repeat(0.5)
    for number in (-1, known.index(name)):
        stepper = Stepper(source, asdict(limits), readings.__next__)
        safe = list[bool]()
        box = CSupervisor(
            evaluator().spec,
            evaluator().rules,
            LIMITS,
            readings.__next__,
            stepping=lambda _, made=stepper: made,  # type: ignore[misc]
        )
        ctypes.c_int.in_dll(stepper._dll, "tmg_answer").value = answer
        ctypes.c_int.in_dll(stepper._dll, "tmg_emptied").value = number
        for k, given in enumerate((good, crossing, good, slow, good)):
            plan = {
                "t": [0.0, 1.0], "x": [0.0, 9.0], "y": [0.0] * 2, "heading": [0.0] * 2, "kappa": [0.0] * 2, "v": [10.0, 0.0],
            }  # fmt: skip
            ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0}
            safe.append(box.step(Cycle(k, 0.1 * k, plan, plan, {"ego": ego, "lanes": given})).safe)
        ctypes.c_int.in_dll(stepper._dll, "tmg_emptied").value = -1
        found.append(safe)
    assert found[0] == [True, False, True, False, True]
    assert found[1] == [False] * 5
