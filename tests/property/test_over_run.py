"""Rules over the run: the engine that keeps every cycle and the one whose memory does not grow say the same of every cycle."""

from __future__ import annotations

import math
import os
from functools import lru_cache
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.length import amount
from support.run_formulas import SIGNALS, formulas, runs
from trackmarshal.evaluation import Evaluator, loads

Said = list[Any]
#: TRACKMARSHAL_EXAMPLES=60 is the share of acceptance.
EXAMPLES = int(os.environ.get("TRACKMARSHAL_EXAMPLES", "7"))


#: The spec of a text, one for all that are held against each other.
loaded = lru_cache(8)(loads)


def said(text: str, backend: str, cycles: list[dict[str, Any] | None]) -> Said:
    """Everything that a rule says in every cycle, and after the last one."""
    evaluator = Evaluator(loaded(text), backend=backend)
    run, found = evaluator.over_run(), list[Any]()
    for cycle in cycles:
        if cycle is None:
            run.missed()
            continue
        result = run.step(evaluator.read(cycle)).rules["f"]
        found.append((result.verdict, exact(result.margin), [_about(one) for one in result.about]))
    found.append({name: [_about(one) for one in each] for name, each in run.end().items()})
    return found


def _about(one: Any) -> Any:
    return one.cycle, one.verdict, exact(one.margin), one.final


def exact(margin: float) -> str:
    return "nan" if math.isnan(margin) else float(margin).hex()


def rule(clauses: str) -> str:
    return f'{SIGNALS}rule f "x"\n  {clauses}\n'


@given(formulas(), runs())
@settings(max_examples=3 * EXAMPLES, deadline=None)
def test_both_engines_say_the_same(formula: str, cycles: list[dict[str, Any] | None]) -> None:
    text = rule(f"require {formula}")
    assert said(text, "reference", cycles) == said(text, "numpy", cycles)


@given(
    formulas(depth=2),
    formulas(True, depth=1),
    formulas(True, depth=2),
    formulas(True, depth=1),
    st.booleans(),
    runs(),
)
@settings(max_examples=2 * EXAMPLES, deadline=None)
def test_and_with_all_clauses(
    whenever: str, guard: str, body: str, but: str, within: bool, cycles: list[dict[str, Any] | None]
) -> None:
    deadline = "within 0.3 s\n  " if within else ""
    text = rule(
        f'whenever {whenever}\n  {deadline}for all o in objects where {guard}\n  except {but} "why"\n  require {body}'
    )
    assert said(text, "reference", cycles) == said(text, "numpy", cycles)


@given(formulas(ahead=False), runs())
@settings(max_examples=amount(10, 50), deadline=None)
def test_what_looks_back_is_decided_at_once(formula: str, cycles: list[dict[str, Any] | None]) -> None:
    for one in said(rule(f"require {formula}"), "numpy", cycles)[:-1]:
        verdict, margin, about = one
        assert verdict != "open"
        assert [each[1:] for each in about] in ([], [(verdict, margin, True)])


@given(
    st.lists(
        st.tuples(st.booleans(), st.booleans(), st.sampled_from([0.1, 0.2, 0.4])), min_size=1, max_size=30
    ),
    st.sampled_from(["reference", "numpy"]),
    st.integers(0, 12),
)
@settings(max_examples=amount(25, 150), deadline=None)
def test_counts_are_those_of_a_loop(
    cycles: list[tuple[bool, bool, float]], backend: str, tenths: int
) -> None:
    """Where everything is known: how often a flag was seen in all, in the last seconds, and since another one."""
    spec = loads(
        "module m\nevent seen\nevent anew\n"
        'rule ever "" require count(seen) <= 5\n'
        f'rule last "" require count(seen, last: {tenths / 10!r} s) <= 5\n'
        'rule fresh "" require count(seen, reset: anew) <= 5\n'
    )
    evaluator = Evaluator(spec, backend=backend)
    run, stamps, found, fresh = evaluator.over_run(), list[int](), list[bool](), 0
    tick = 0
    for number, (seen, anew, step) in enumerate(cycles):
        tick += round(step * 10)
        stamps.append(tick)
        found.append(seen)
        fresh = int(seen) + (0 if anew else fresh)
        rules = run.step(
            evaluator.read({"id": number, "t": tick / 10, "signals": {"seen": seen, "anew": anew}})
        ).rules
        recent = sum(one for one, at in zip(found, stamps) if tick - at <= tenths)
        counts = {"ever": sum(found), "last": recent, "fresh": fresh}
        assert {name: rules[name].margin for name in counts} == {
            name: 5.0 - count for name, count in counts.items()
        }
        assert {name: rules[name].verdict for name in counts} == {
            name: "satisfied" if count <= 5 else "violated" for name, count in counts.items()
        }


@given(
    st.lists(st.sampled_from([True, False, None]), min_size=1, max_size=12),
    st.sampled_from(["reference", "numpy"]),
)
@settings(max_examples=amount(13, 80), deadline=None)
def test_counts_with_gaps_are_those_of_every_way_to_fill_them(
    cycles: list[bool | None], backend: str
) -> None:
    """A verdict is that of all runs that a gap may stand for, where they agree, and else undefined."""
    text = 'module m\nevent seen\nrule f "" require count(seen, last: 0.4 s) <= 2\n'
    evaluator = Evaluator(loads(text), backend=backend)
    run = evaluator.over_run()
    known = False
    for number, seen in enumerate(cycles):
        if seen is None:
            run.missed()
            continue
        result = run.step(evaluator.read({"id": number, "t": number / 10, "signals": {"seen": seen}})).rules[
            "f"
        ]
        seen_at = [i for i, one in enumerate(cycles[: number + 1]) if one is not None]
        sure = sum(cycles[i] is True for i in seen_at if i >= number - 4)
        # A gap that reaches into the window counts as a whole; before the first cycle, nothing was.
        missed = sum(end - begin - 1 for begin, end in pairwise(seen_at) if end > number - 4)
        possible = sure + missed
        wanted = "satisfied" if possible <= 2 else "violated" if sure > 2 else "undefined"
        assert result.verdict == wanted, (number, cycles)
        known = True
    assert known or all(one is None for one in cycles)


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
def test_what_may_turn_out_not_to_apply_is_open(backend: str) -> None:
    """A rule that holds counts as one that was asked for only once it is known that it is: else a run in which it never applied is evidence for it."""
    evaluator = Evaluator(loads(rule("whenever weak next flag\n  require ego.v >= 0 m/s")), backend=backend)
    run, heard = evaluator.over_run(), []
    for cycle, flag in enumerate((True, False, True)):
        signals = {"ego": {"v": 5.0, "w": 0.0}, "objects": [], "flag": flag}
        result = run.step(evaluator.read({"t": 0.1 * cycle, "id": cycle, "signals": signals})).rules["f"]
        heard.append((result.verdict, [(one.cycle, one.verdict, one.final) for one in result.about]))
    assert heard == [
        ("open", [(0, "open", False)]),
        ("open", [(1, "open", False), (0, "inactive", True)]),
        ("open", [(2, "open", False), (1, "satisfied", True)]),
    ]
