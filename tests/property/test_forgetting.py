"""Elements that are absent for a while and keep their history: all engines, and what is saved of them, say the same of every cycle."""

from __future__ import annotations

import re
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from property.test_over_run import said
from property.test_saved_memory import told
from property.test_whole_run import CUTS, same
from support import run_pairs
from support.length import amount
from support.run_formulas import SIGNALS, formulas, runs
from support.run_pairs import paired
from trackmarshal.backends.over_run.history import History, Past
from trackmarshal.backends.over_run.keeping import past
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.explaining.trail import Trail

Cycles = list[dict[str, Any] | None]
LASTING = st.builds(
    lambda capacity, tenths: f" capacity {capacity} forget {tenths / 10!r} s\n",
    st.integers(1, 4),
    st.integers(0, 12),
)
MACHINE = """state m : { p, q, r } for each o in objects starts p
  becomes q from p when o.v > 0 m/s
    remember took = ego.v
  becomes r when o.seen is yellow and ego.on
  becomes p from q, r when once[0 s, 0.3 s] flag
"""
KEPT = "m(o) is q and time_in(m(o)) >= 0.2 s or m(o).took > 0 m/s"


def rule(lasting: str, clauses: str) -> str:
    signals, found = re.subn(r"(signal objects[^\n]*)\n", rf"\g<1>{lasting}", SIGNALS)
    assert found == 1
    return f'{signals}{MACHINE}rule f "x"\n  {clauses}\n'


def bodies() -> st.SearchStrategy[str]:
    """Formulas about an element, and the machine that it has."""
    back = formulas(True, ahead=False, depth=2)
    return st.one_of(
        back, formulas(True, depth=2), back.map(lambda p: f"({KEPT}) iff {p}"), st.just("not (m(o) is r)")
    )


def compiled(text: str) -> None:
    """What looks back at what looks ahead is refused of elements that may be absent."""
    try:
        loads(text)
    except Diagnostics as found:
        assert {one.code for one in found.items} == {"E223"}
        assume(False)


@given(LASTING, formulas(ahead=False), runs())
@settings(max_examples=amount(10, 900), deadline=None)
def test_both_engines_say_the_same(lasting: str, formula: str, cycles: Cycles) -> None:
    text = rule(lasting, f"require {formula}")
    assert said(text, "reference", cycles) == said(text, "numpy", cycles)


@given(LASTING, st.sampled_from(["for all", "exists"]), bodies(), bodies(), runs())
@settings(max_examples=amount(20, 1500), deadline=None)
def test_of_elements_too(lasting: str, quantifier: str, guard: str, body: str, cycles: Cycles) -> None:
    text = rule(lasting, f"{quantifier} o in objects where {guard}\n  require {body}")
    compiled(text)
    assert said(text, "reference", cycles) == said(text, "numpy", cycles)


@given(LASTING, bodies(), runs(), st.sets(st.integers(0, 14), min_size=1))
@settings(max_examples=amount(10, 900), deadline=None)
def test_a_run_goes_on_as_if_it_had_not_stopped(
    lasting: str, body: str, cycles: Cycles, restarts: set[int]
) -> None:
    text = rule(lasting, f"for all o in objects require {body}")
    compiled(text)
    assert told(text, cycles, restarts) == told(text, cycles, set())


@given(LASTING, bodies(), runs(), CUTS)
@settings(max_examples=amount(8, 400), deadline=None)
def test_many_cycles_at_once_say_the_same(lasting: str, body: str, cycles: Cycles, cuts: list[int]) -> None:
    text = rule(lasting, f"for all o in objects require {body}")
    compiled(text)
    same(text, cycles, cuts)


@given(
    st.lists(st.tuples(st.sampled_from([None, False, True]), st.sampled_from([1, 2, 3])), max_size=12),
    st.integers(0, 6),
    st.integers(0, 8),
    st.sampled_from(["reference", "numpy", "c"]),
)
@settings(max_examples=amount(10, 600), deadline=None)
def test_an_absence_is_any_way_to_fill_it(
    drawn: list[tuple[bool | None, int]], forget: int, back: int, backend: str
) -> None:
    """Of one element: what holds whatever its flag was in the cycles in which it was not there. None: it is not there."""
    spec = loads(
        f"module m\nsignal objects : set of object {{ v: bool }} capacity 1 forget {forget / 10!r} s\n"
        f'rule f "" for all o in objects require once[0 s, {back / 10!r} s] o.v\n'
        f'rule g "" for all o in objects require historically[0 s, {back / 10!r} s] o.v\n'
        'rule h "" for all o in objects require previous o.v\n'
    )
    evaluator = Evaluator(spec, backend=backend)
    run = evaluator.over_run()
    life: list[tuple[int, bool | None]] = []
    t = last = 0
    for number, (flag, step) in enumerate(drawn):
        t += step
        there = [] if flag is None else [{"id": "a", "v": flag}]
        rules = run.step(evaluator.read({"id": number, "t": t / 10, "signals": {"objects": there}})).rules
        if flag is None:
            assert {rules[name].verdict for name in "fgh"} == {"inactive"}
            life.append((t, None))
            continue
        if life and life[-1][1] is None and t - last > forget:
            life = []
        while life and life[0][1] is None:
            life.pop(0)
        life.append((t, flag))
        last = t
        recent = [one for at, one in life if t - at <= back] + [
            # Somewhere in an absence that the window overlaps, whether or not a cycle of it lies inside.
            None
            for (begin, one), (end, other) in absences(life)
            if end > t - back
        ]
        once = True if True in recent else None if None in recent else False
        always = False if False in recent else None if None in recent else True
        before = life[-2][1] if len(life) > 1 else False
        words = {True: "satisfied", False: "violated", None: "undefined"}
        assert [rules[name].verdict for name in "fgh"] == [words[once], words[always], words[before]]


def absences(
    life: list[tuple[int, bool | None]],
) -> list[tuple[tuple[int, bool | None], tuple[int, bool | None]]]:
    """The cycles before and after each absence."""
    seen = [place for place, (_, flag) in enumerate(life) if flag is not None]
    return [(life[a], life[b]) for a, b in zip(seen, seen[1:]) if b > a + 1]


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
def test_one_that_finds_no_place_makes_its_rules_undefined(backend: str) -> None:
    spec = loads(
        "module m\nsignal objects : set of object { v: bool } capacity 2 forget 1 s\n"
        'rule f "" for all o in objects require once[0 s, 9 s] o.v\n'
    )
    evaluator = Evaluator(spec, backend=backend)
    run = evaluator.over_run()

    def step(t: float, **there: bool) -> str:
        objects = [{"id": name, "v": v} for name, v in there.items()]
        return run.step(evaluator.read({"id": t, "t": t, "signals": {"objects": objects}})).rules["f"].verdict

    assert step(0.0, a=True, b=True) == "satisfied"
    assert step(0.5, c=True) == "undefined"  # a and b may still come back
    assert step(1.0, c=True) == "satisfied"  # not any more: the place of one is free
    assert step(1.1, c=False, d=False) == "undefined"  # d may be one that found no place before
    assert step(1.6, c=False, d=True) == "satisfied"
    assert step(1.7, c=False, d=True, a=True) == "undefined"  # more than the capacity: a fault


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
def test_who_finds_no_place_is_named(backend: str) -> None:
    spec = loads(
        "module m\nsignal objects : set of object { v: bool } capacity 2 forget 1 s\n"
        'rule f "" for all o in objects require count(o.v) <= 1\n'
    )
    evaluator = Evaluator(spec, backend=backend)
    run = evaluator.over_run()
    for t, there, reason in (
        (0.0, "ab", ""),
        (0.5, "bcd", "3 elements, room for 2"),
        (0.6, "cd", "no place for `c`, `d` among the 2 elements of `objects` that are remembered"),
    ):
        objects = [{"id": name, "v": False} for name in there]
        result = run.step(evaluator.read({"id": t, "t": t, "signals": {"objects": objects}})).rules["f"]
        assert reason in result.reason
        assert (result.verdict == "undefined") == bool(reason)


@pytest.mark.parametrize("beside", ["", "for all o in objects require once o.v"])
@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
def test_nobody_is_named_of_whom_a_rule_remembers_nothing(backend: str, beside: str) -> None:
    """It reads them, and is undefined by a gap: that somebody has no place is not why, whether another rule remembers them or not."""
    spec = loads(
        "module m\nevent on\nsignal objects : set of object { v: bool } capacity 1 forget 1 s\n"
        'rule f "" require exists o in objects where o.v: historically on\n'
        + (f'rule g "" {beside}\n' if beside else "")
    )
    evaluator = Evaluator(spec, backend=backend)
    run = evaluator.over_run()
    for t, name in ((0.0, "a"), (0.1, ""), (0.2, "b")):
        if not name:
            run.missed()
            continue
        signals = {"on": True, "objects": [{"id": name, "v": True}]}
        rules = run.step(evaluator.read({"id": t, "t": t, "signals": signals})).rules
    assert (rules["f"].verdict, rules["f"].reason) == ("undefined", "")
    assert not beside or rules["g"].reason.startswith("no place for `b` ")


@given(LASTING, formulas(True, ahead=False, depth=2), runs())
@settings(max_examples=amount(8, 400), deadline=None)
def test_what_decided_is_found(lasting: str, body: str, cycles: Cycles) -> None:
    evaluator = Evaluator(loads(rule(lasting, f"for all o in objects require {body}")))
    kept: list[Past] = []
    capacity = evaluator.spec.signals["objects"].capacity
    assert capacity is not None
    for cycle in cycles:
        if cycle is None or len(cycle["signals"]["objects"]["id"]) > capacity:
            continue
        kept.append(past(evaluator.spec, evaluator.read(cycle), 0))
        formula = evaluator.rules[0].formula
        assert formula is not None
        trail = Trail(History(kept))
        found = trail.find(formula, len(kept) - 1, {})
        assert found is not None or trail.said or "o." not in body or not cycle["signals"]["objects"]["id"]


def test_who_finds_no_place_is_told() -> None:
    evaluator = Evaluator(
        loads(
            "module m\nsignal objects : set of object { v: bool } capacity 1 forget 1 s\n"
            'rule f "" for all o in objects require once[0 s, 2 s] o.v\n'
        )
    )
    kept = [
        past(evaluator.spec, evaluator.read({"t": t, "signals": {"objects": [{"id": name, "v": False}]}}), 0)
        for t, name in ((0.0, "a"), (0.5, "b"))
    ]
    formula = evaluator.rules[0].formula
    assert formula is not None
    trail = Trail(History(kept))
    assert trail.find(formula, 1, {}) is None
    assert trail.said[-1] == "nothing is remembered of objects b: `capacity 1` leaves no place for it"


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
def test_lanes_have_a_capacity_too(backend: str) -> None:
    spec = loads(
        "module m\nsignal ego : state { x: m, y: m, heading: rad, length: m, width: m }\n"
        "signal lanes : set of lane { left: polyline, right: polyline } capacity 1\n"
        'rule f "" for all l in lanes require footprint(ego) meets l\n'
    )
    lane = {"left": [[0, 4], [50, 4]], "right": [[0, 0], [50, 0]]}
    ego = {"x": 20, "y": 2, "heading": 0, "length": 4, "width": 2}
    evaluator = Evaluator(spec, backend=backend)
    found = [
        evaluator.case({"signals": {"ego": ego, "lanes": [lane] * many}}).rules["f"] for many in (1, 2, 3, 1)
    ]
    assert [one.verdict for one in found] == ["satisfied", "undefined", "undefined", "satisfied"]
    assert "3 elements, room for 1: declare the signal with `capacity 3`" in found[2].reason


@given(
    run_pairs.LASTING,
    run_pairs.LASTING,
    st.sampled_from([run_pairs.SETS, run_pairs.SETS[::-1], ("objects", "objects")]),
    paired(False),
    paired(False),
    run_pairs.runs(),
)
@settings(max_examples=amount(14, 900), deadline=None)
def test_pairs_of_elements(
    first: str, second: str, sets: tuple[str, str], guard: str, body: str, cycles: Cycles
) -> None:
    """A pair lasts as long as both of its elements do, each as its set has it."""
    text = run_pairs.signals(first, second) + (
        f'rule f "x"\n  for all o in {sets[0]}\n  for all b in {sets[1]} where {guard}\n  require {body}\n'
    )
    assert said(text, "reference", cycles) == said(text, "numpy", cycles)


@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_one_whose_set_forgets_it_at_once_makes_a_new_pair(backend: str) -> None:
    spec = loads(
        "module m\nsignal cars : set of object { v: bool } capacity 2 forget 1 s\nsignal lights : set of object { v: bool }\n"
        'rule f "" for all c in cars for all l in lights require once (c.v and l.v)\n'
    )
    evaluator = Evaluator(spec, backend=backend)
    run = evaluator.over_run()

    def step(t: float, cars: dict[str, bool], lights: dict[str, bool]) -> str:
        signals = {
            name: [{"id": one, "v": v} for one, v in there.items()]
            for name, there in (("cars", cars), ("lights", lights))
        }
        return run.step(evaluator.read({"id": t, "t": t, "signals": signals})).rules["f"].verdict

    assert step(0.0, {"a": True}, {"x": True}) == "satisfied"
    assert step(0.1, {"a": False}, {"x": False}) == "satisfied"
    assert step(0.2, {}, {"x": False}) == "inactive"
    assert step(0.3, {"a": False}, {"x": False}) == "satisfied"  # the car is known again
    assert step(0.4, {"a": False}, {}) == "inactive"
    assert step(0.5, {"a": False}, {"x": False}) == "violated"  # the light is another one
