"""Members of enumerations: three evaluators and two doors say the same of them, and nothing that is no member is ever safe."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from support import typed
from support.agreement import differences, read, results
from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime.contract import Condition
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of
from trackmarshal.supervision import supervisor

BACKENDS = [
    "reference", "numpy", pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
]  # fmt: skip
FLAGS = ("green", "yellow", "blue", "red")
TEXT = """
module enums
enum flag "shown to the car" { green, yellow, blue, red }
enum kind { car, truck }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, lane: flag default green, lit: bool default false }
signal trace : series { t: s increasing, shown: flag }
signal ego : state { x: m, y: m, heading: rad }
signal race : state { flag: flag, before: flag default red, wet: bool default true, v: m/s }
signal objects : set of object { x: m, class: kind default car, seen: flag, braking: bool default false }

predicate slow(limit: m/s) = race.v <= limit

rule is_yellow "" require race.flag is yellow
rule not_red "" require not race.flag is red
rule same "" require race.flag is race.before
rule either "" require race.flag is blue or slow(10 m/s)
rule iff_wet "" require race.flag is green iff race.wet
rule xor_wet "" require (race.flag is green) xor race.wet
rule limit "" require race.v <= case race.flag { green: 80 m/s, yellow, blue: 40 m/s, red: 0 m/s }
rule formulas "" require case race.flag { green, blue: race.v <= 50 m/s, yellow: slow(5 m/s), else: not race.wet }
rule nested ""
  require case race.flag { green: case race.before { red: race.wet, else: false }, else: race.before is red }
rule several ""
  for all o in objects where o.class is truck
  except o.braking "it brakes"
  require o.seen is race.flag
rule some "" exists o in objects where not o.seen is green require o.x <= 10 m
rule counted "" require count(o in objects where o.class is car) <= 1
rule summed "" require sum(case o.class { car: 1, truck: 2.5 } for o in objects) <= 4
rule closest ""
  for nearest o in objects by o.x where o.class is car
  let shown = o.seen
  require shown is race.flag or shown is green
rule samples "" for all p in plan require p.lane is green or p.lit
rule ends "" require plan.first.lane is plan.last.lane
rule pairs "" for all consecutive p, q in plan require p.lane is q.lane or q.v <= 3 m/s
rule along_plan "" along plan as p require always (p.lane is yellow implies eventually[0 s, 0.2 s] p.v <= 2 m/s)
rule until_red "" along trace as s require (not s.shown is red) until s.shown is blue
rule rises "" along trace as s require always (rising(s.shown is yellow) implies next (s.shown is yellow))
rule chosen "" whenever race.flag is yellow require race.v <= if race.before is red then 1 m/s else 9 m/s
"""
#: What is no member, or nothing: by name, by place.
WRONG: tuple[Any, ...] = ("yelow", "Green", "", 1.5, -1, 4, 99, math.nan, math.inf, -0.5, 1e300, None)


def column(dice: random.Random, members: tuple[str, ...], count: int, dirt: float) -> Any:
    """Names, places, or both, in each of the ways in which a column is given."""
    places = [dice.randrange(len(members)) for _ in range(count)]
    names: list[Any] = [members[place] for place in places]
    if dice.random() < dirt:
        if count:
            names[dice.randrange(count)] = dice.choice(WRONG)
        return names
    ways: list[Callable[[], Any]] = [
        lambda: names,
        lambda: tuple(names),
        lambda: [dice.choice(pair) for pair in zip(names, places)],
        lambda: [float(place) for place in places],
        lambda: np.array(places, dtype=np.uint8),
        lambda: np.array(places, dtype=np.float64),
        lambda: np.array(names, dtype=f"U{max(map(len, members))}"),
        lambda: np.array(names, dtype=object),
    ]
    return dice.choice(ways)()


def case(number: int, dice: random.Random, dirt: float) -> dict[str, Any]:
    """A case; `dirt`: the share of columns in which something is no member."""

    def one(members: tuple[str, ...]) -> Any:
        return dice.choice(WRONG) if dice.random() < dirt else dice.choice((members, range(len(members))))[dice.randrange(len(members))]  # fmt: skip

    n, m, k = dice.randint(2, 5), dice.randint(1, 5), dice.randint(0, 4)
    plan = {
        "t": [0.1 * i for i in range(n)],
        **{f: [1.0 * i for i in range(n)] for f in ("x", "y", "heading")},
    }
    plan["v"] = [float(dice.randint(0, 5)) for _ in range(n)]
    if dice.random() < 0.8:
        plan["lane"] = column(dice, FLAGS, n, dirt)
    if dice.random() < 0.5:
        plan["lit"] = [dice.random() < 0.5 for _ in range(n)]
    race = {"flag": one(FLAGS), "v": float(dice.choice((0, 1, 5, 9, 10, 40, 50, 80, 81)))}
    if dice.random() < 0.6:
        race["before"] = one(FLAGS)
    if dice.random() < 0.6:
        race["wet"] = dice.random() < 0.5
    objects: list[dict[str, Any]] = []
    for _ in range(k):
        each = {"x": float(dice.randint(0, 20)), "seen": one(FLAGS)}
        if dice.random() < 0.7:
            each["class"] = one(("car", "truck"))
        if dice.random() < 0.5:
            each["braking"] = dice.random() < 0.5
        objects.append(each)
    columns = {
        "x": [float(i) for i in range(k)],
        "seen": column(dice, FLAGS, k, dirt),
        "class": column(dice, ("car", "truck"), k, dirt),
    }
    signals = {
        "plan": plan, "race": race, "ego": {"x": 0.0, "y": 0.0, "heading": 0.0},
        "trace": {"t": [0.1 * i for i in range(m)], "shown": column(dice, FLAGS, m, dirt)},
        "objects": objects if dice.random() < 0.6 else columns,
    }  # fmt: skip
    return {"id": number, "signals": signals}


CASES = amount(100, 400)


@pytest.mark.parametrize("dirt", [0.0, 0.15])
def test_all_evaluators_say_the_same(dirt: float) -> None:
    spec, dice = loads(TEXT), random.Random(int(dirt * 100))
    frames = read(spec, [case(number, dice, dirt) for number in range(CASES)])
    assert len(frames) == CASES
    reference = results(spec, frames, "reference")
    for backend in ("numpy", *(["c"] if compiler() else [])):
        found = [
            text
            for one, other in zip(reference, results(spec, frames, backend), strict=True)
            for text in differences(one, other)
        ]
        assert found == []
    broken = [frame for frame in frames if frame.faults]
    assert (len(broken) > CASES / 4) == (dirt > 0.0)
    assert not any(result.safe for frame, result in zip(frames, reference) if frame.faults)
    verdicts = {(name, rule.verdict) for result in reference for name, rule in result.rules.items()}
    assert {name for name, verdict in verdicts if verdict == "satisfied"} == {
        rule.name for rule in spec.rules
    }
    assert {name for name, verdict in verdicts if verdict == "violated"} == {rule.name for rule in spec.rules}
    margins = {
        rule.margin
        for result in reference
        for name, rule in result.rules.items()
        if name in ("is_yellow", "same")
    }
    assert {margin for margin in margins if not math.isnan(margin)} == {math.inf, -math.inf}


def oracle(race: dict[str, Any]) -> dict[str, tuple[str, float]]:
    """What some rules come to, written by hand."""
    flag, v, wet = race["flag"], race["v"], race.get("wet", True)
    before = race.get("before", "red")
    limits = {"green": 80.0, "yellow": 40.0, "blue": 40.0, "red": 0.0}
    parts = {
        "green": 50.0 - v,
        "blue": 50.0 - v,
        "yellow": 5.0 - v,
        "red": math.inf if not wet else -math.inf,
    }
    found = {"is_yellow": math.inf if flag == "yellow" else -math.inf, "same": math.inf if flag == before else -math.inf,
             "limit": limits[flag] - v, "formulas": parts[flag]}  # fmt: skip
    return {name: ("satisfied" if margin >= 0.0 else "violated", margin) for name, margin in found.items()}


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_rules_come_to_is_what_they_say(backend: str) -> None:
    spec, dice = loads(TEXT), random.Random(3)
    races = []
    for _ in range(100):
        race = {"flag": dice.choice(FLAGS), "v": float(dice.choice((0, 5, 40, 50, 80, 81)))}
        race |= {} if dice.random() < 0.5 else {"before": dice.choice(FLAGS), "wet": dice.random() < 0.5}
        races.append(race)
    evaluator = Evaluator(spec, ["is_yellow", "same", "limit", "formulas"], backend)
    for race, result in zip(
        races, evaluator.evaluate(evaluator.read_all([{"signals": {"race": race}} for race in races]))
    ):
        assert {name: (rule.verdict, rule.margin) for name, rule in result.rules.items()} == oracle(race)


@pytest.mark.parametrize("backend", BACKENDS)
def test_nothing_is_known_of_what_is_missing(backend: str) -> None:
    evaluator = Evaluator(loads(TEXT), ["is_yellow", "not_red", "limit", "either"], backend)
    for missing in (None, math.nan, "nan"):
        race = {"flag": missing, "v": 20.0}
        (result,) = evaluator.evaluate([evaluator.read({"signals": {"race": race}})])
        assert {rule.verdict for rule in result.rules.values()} == {"undefined"}
        assert not result.safe
    (result,) = evaluator.evaluate([evaluator.read({"signals": {"race": {"flag": None, "v": 5.0}}})])
    assert result.rules["either"].verdict == "satisfied"  # whatever the flag is
    assert not result.safe


def test_a_name_that_is_none_is_told_with_the_members() -> None:
    evaluator = Evaluator(loads(TEXT), ["is_yellow", "some"])
    frame = evaluator.read(
        {
            "signals": {
                "race": {"flag": "yelow", "v": 0},
                "objects": [{"x": 0, "seen": "red"}, {"x": 0, "seen": "RED"}],
            }
        }
    )
    said = sorted(str(fault) for fault in frame.faults)
    assert said[0].startswith(
        "D237 objects.seen[1]: `RED` is none of green, yellow, blue, red; did you mean `red`?"
    )
    assert said[1] == "D237 race.flag: `yelow` is none of green, yellow, blue, red; did you mean `yellow`?"
    frame = evaluator.read({"signals": {"race": {"flag": 1.5, "v": 0}, "objects": []}})
    assert [str(fault) for fault in frame.faults] == [
        "D237 race.flag: 1.5 is no place of a member, which are 0 to 3: green, yellow, blue, red"
    ]


@pytest.mark.parametrize("backend", BACKENDS)
def test_arrays_of_many_cases(backend: str) -> None:
    """Names and places say the same, for each case and for all of them."""
    evaluator = Evaluator(loads(TEXT), ["is_yellow", "samples", "several"], backend)
    dice = random.Random(5)
    size, n = 40, 3
    flags = [dice.choice(FLAGS) for _ in range(size)]
    lanes = [[dice.choice(FLAGS) for _ in range(n)] for _ in range(size)]
    v, t = np.zeros(size), np.tile(np.arange(n) * 0.1, (size, 1))
    objects = {"x": np.zeros((size, 2)), "seen": np.array(["green", "red"]), "class": np.array([1.0, 1.0])}

    def verdicts(flag: Any, lane: Any) -> list[Any]:
        batch = evaluator.batch(
            {"race": {"flag": flag, "v": v}, "plan": {"t": t, "lane": lane}, "objects": objects}
        )
        return [
            (list(batch.verdicts[name]), list(batch.margins[name]))
            for name in ("is_yellow", "samples", "several")
        ]

    places = {name: place for place, name in enumerate(FLAGS)}
    by_place = verdicts(
        np.array([places[f] for f in flags]), np.array([[float(places[f]) for f in lane] for lane in lanes])
    )
    assert verdicts(np.array(flags), np.array(lanes)) == by_place
    single = [
        next(iter(evaluator.evaluate([evaluator.read({"signals": {
            "race": {"flag": f, "v": 0.0}, "plan": {"t": [0.0, 0.1, 0.2], "lane": lane},
            "objects": {"x": [0.0, 0.0], "seen": ["green", "red"], "class": ["truck", "truck"]},
        }})])))
        for f, lane in zip(flags, lanes)
    ]  # fmt: skip
    assert [by_place[0][1][i] == one.rules["is_yellow"].margin for i, one in enumerate(single)] == [
        True
    ] * size
    assert [by_place[1][1][i] == one.rules["samples"].margin for i, one in enumerate(single)] == [True] * size


# The doors of cycles --------------------------------------------------------------------------------------------

ONLINE = """
module online
enum flag { green, yellow, blue, red }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, lane: flag default green }
signal ego : state { x: m, y: m, heading: rad }
signal race : state { flag: flag default blue, wet: bool default false }
signal objects : set of object { x: m, seen: flag }

rule no_red "" require not race.flag is red and not race.wet
rule lanes "" for all p in plan require not p.lane is red
rule seen "" for all o in objects require not o.seen is race.flag or race.flag is green
"""


class Run:
    def __init__(self, backend: str) -> None:
        self.now = -1
        self.supervisor = supervisor(
            loads(ONLINE), backend=backend, limits=typed.LIMITS, clock=lambda: float(self.now)
        )

    def step(self, change: Callable[[Cycle], Cycle] = lambda given: given) -> Decision:
        self.now += 1
        plan = {
            "t": np.array([0.0, 1.0, 2.0]), "x": np.zeros(3), "y": np.zeros(3), "heading": np.zeros(3), "v": np.zeros(3),
            "lane": np.array([0.0, 1.0, 2.0]),
        }  # fmt: skip
        signals = {
            "ego": {"x": 0.0, "y": 0.0, "heading": 0.0}, "race": {"flag": "green", "wet": False},
            "objects": {"x": np.zeros(2), "seen": np.array([0, 3])},
        }  # fmt: skip
        return self.supervisor.step(change(Cycle(self.now, float(self.now), plan, dict(plan), signals)))


def with_signal(name: str, **fields: Any) -> Callable[[Cycle], Cycle]:
    def changed(given: Cycle) -> Cycle:
        left = {k: v for k, v in {**given.signals[name], **fields}.items() if v is not ...}
        return replace(given, signals={**given.signals, name: left})

    return changed


def lane(values: Any) -> Callable[[Cycle], Cycle]:
    return lambda given: replace(given, driving={**given.driving, "lane": values})


NUMBERS = np.array
GOOD: list[Callable[[Cycle], Cycle]] = [
    with_signal("race", flag=0), with_signal("race", flag=np.array("yellow")), with_signal("race", flag=np.str_("yellow")),
    with_signal("race", flag=1.0, wet=...), with_signal("race", flag=..., wet=...),
    with_signal("objects", seen=["green", "yellow"]), with_signal("objects", seen=NUMBERS(["green", "blue"])),
    lane(["green", 1, 2.0]), lane(NUMBERS([0, 1, 2], dtype=np.int8)), lane(NUMBERS(["blue"] * 3)),
]  # fmt: skip
BAD: list[tuple[Callable[[Cycle], Cycle], tuple[str, str, str, int | None]]] = [
    (with_signal("race", flag="yelow"), ("no_member", "race", "flag", None)),
    (with_signal("race", flag=1.5), ("no_member", "race", "flag", None)),
    (with_signal("race", flag=-1), ("no_member", "race", "flag", None)),
    (with_signal("race", flag=99), ("no_member", "race", "flag", None)),
    (with_signal("race", flag=4), ("no_member", "race", "flag", None)),
    (with_signal("race", flag=2.0**60), ("no_member", "race", "flag", None)),
    (with_signal("race", flag=math.nextafter(1.0, 2.0)), ("no_member", "race", "flag", None)),
    (with_signal("race", flag=math.nan), ("not_finite", "race", "flag", None)),
    (with_signal("race", flag=math.inf), ("not_finite", "race", "flag", None)),
    (with_signal("race", flag=True), ("wrong_type", "race", "flag", None)),
    (with_signal("race", flag=["green"]), ("wrong_type", "race", "flag", None)),
    (with_signal("race", wet="no"), ("wrong_type", "race", "wet", None)),
    (with_signal("objects", seen=["green", "Blue"]), ("no_member", "objects", "seen", 1)),
    (with_signal("objects", seen=NUMBERS([0.0, 0.25])), ("no_member", "objects", "seen", 1)),
    (with_signal("objects", seen=NUMBERS([0.0, math.nan])), ("not_finite", "objects", "seen", 1)),
    (with_signal("objects", seen=["green", b"red"]), ("wrong_type", "objects", "seen", 1)),
    (lane(NUMBERS([0.0, 4.0, 0.0])), ("no_member", "driving", "lane", 1)),
    (lane(NUMBERS(["green", "red", "rad"])), ("no_member", "driving", "lane", 2)),
    (lane([0.0, 0.0]), ("wrong_length", "driving", "lane", 2)),
]  # fmt: skip


@pytest.mark.parametrize("backend", BACKENDS)
def test_doors_of_cycles(backend: str) -> None:
    run = Run(backend)
    assert run.step().safe
    for change in GOOD:
        decision = run.step(change)
        assert decision.safe, decision.reasons
    for change, expected in BAD:
        decision = run.step(change)
        assert not decision.safe
        found = [(name_of(f), f.signal, f.field, f.index) for f in decision.faults]
        assert found == [expected], decision.reasons
        assert run.step().safe
    decision = run.step(with_signal("race", flag="red"))
    assert not decision.safe
    assert not decision.faults


def test_what_is_whole_is_so_to_numbers_and_arrays() -> None:
    """The condition that Python's door evaluates, of single numbers and of columns, is that of C's `floor`."""
    numbers = [
        0.0,
        -0.0,
        1.0,
        3.0,
        4.0,
        0.5,
        1.5,
        2.5,
        -1.0,
        -0.5,
        1e300,
        math.inf,
        -math.inf,
        math.nan,
        math.nextafter(3.0, 4.0),
        5e-324,
    ]
    whole = Condition("(x >= 0) & (x <= last) & (floor(x) == x)").function("x", "last")
    told = [bool(whole(x, 3.0)) for x in numbers]
    assert told == [x in (0.0, 1.0, 2.0, 3.0) for x in numbers]
    assert whole(np.array(numbers), 3.0).tolist() == told
    assert [bool(whole(np.float64(x), 3.0)) for x in numbers] == told
