"""Results in brief say what whole ones do: verdicts, margins, what is against a case and whether it is safe; whoever asks them for more is refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.agreement import compiled, same
from support.length import amount
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Rated
from trackmarshal.runtime.verdict import Briefly, CaseResult, RuleResult

SPEC = """
module brief
signal plan : trajectory { t: s increasing, x: m, v: m/s }
signal ego : state { v: m/s }
signal objects : set of object { x: m, w: m }
rule slow "decides"
  for all p in plan
  require p.v <= 10 m/s
rule apart "only where there is anything"
  for all o in objects
  require o.x > 5 m
rule hint "warns"
  severity advisory
  require ego.v <= 8 m/s
rule mixed "of two dimensions"
  require ego.v <= 9 m/s and (exists o in objects: o.x <= 1 m)
"""
AHEAD = """
rule soon "is open until it is known"
  whenever ego.v >= 5 m/s
  require eventually[0 s, 1 s] (ego.v <= 3 m/s)
"""
#: Verdicts in the order of their codes, written out: as records and generated C have them.
CODES = ("satisfied", "violated", "undefined", "inactive", "open")
ALONE, OVER_RUN = compiled(SPEC), compiled(SPEC + AHEAD)
EVALUATOR = Evaluator(ALONE, None, "reference")
NAMES = ["slow", "apart", "hint", "mixed"]
NEVER_DECIDE = frozenset((2,))

_NUMBER = st.one_of(
    st.floats(-20.0, 20.0), st.sampled_from((math.nan, math.inf, -math.inf, 0.0, -0.0, 5.0, 8.0, 9.0, 10.0))
)


def explained(codes: Sequence[int], asked: list[int]) -> Any:
    def explain(number: int, series: bool = False) -> RuleResult:
        asked.append(number)
        return RuleResult(
            NAMES[number], CODES[codes[number]], math.nan, "m", reason="looked for", advisory=number in NEVER_DECIDE
        )  # fmt: skip

    return explain


@given(st.lists(st.tuples(st.integers(0, 4), _NUMBER), min_size=4, max_size=4))
@settings(max_examples=amount(50, 300), deadline=None)
def test_whatever_a_program_says(said: list[tuple[int, float]]) -> None:
    codes, margins, asked = [code for code, _ in said], [margin for _, margin in said], list[int]()
    rated = Rated(bytes(codes), margins, explained(codes, asked), NEVER_DECIDE)
    result = EVALUATOR.result(Frame(), rated, brief=True)
    against = [k for k in range(4) if CODES[codes[k]] in ("violated", "undefined")]
    assert asked == against
    assert list(result.rules) == NAMES
    assert len(result.rules) == 4
    for k, name in enumerate(NAMES):
        one = result.rules[name]
        assert (one.rule, one.verdict, one.advisory) == (name, CODES[codes[k]], k == 2)
        assert one.fired == (k in against) == (one.reason == "looked for")
        assert k in against or same(one.margin, margins[k])
        for brief in (result.said(name), CaseResult(result.id, dict(result.rules)).said(name)):
            assert (brief.verdict, brief.fired) == (CODES[codes[k]], k in against)
            assert same(brief.margin, one.margin)
    assert [one.rule for one in result.against] == [NAMES[k] for k in against]
    assert result.safe == (not [k for k in against if k != 2])
    plain = CaseResult(result.id, dict(result.rules), result.faults)
    assert [one.rule for one in plain.against] == [NAMES[k] for k in against]
    assert plain.safe == result.safe
    assert asked == against, "nobody was asked again"


def frames(evaluator: Evaluator, cases: Sequence[dict[str, Any]]) -> list[Frame]:
    read = evaluator.read_all(cases)
    for number, frame in enumerate(read):
        frame.t, frame.number = 0.1 * number, number
    return read


def case(speeds: Sequence[float], ego: float, objects: Sequence[float]) -> dict[str, Any]:
    plan = {"t": [0.1 * k for k in range(len(speeds))], "x": [float(k) for k in range(len(speeds))]}
    return {
        "signals": {
            "plan": {**plan, "v": list(speeds)},
            "ego": {"v": ego},
            "objects": [{"x": x, "w": 1.0} for x in objects],
        }
    }


@pytest.mark.parametrize("backend", ["reference", "numpy"])
@given(
    st.lists(
        st.builds(case, st.lists(_NUMBER, min_size=1, max_size=3), _NUMBER, st.lists(_NUMBER, max_size=2)),
        min_size=1,
        max_size=4,
    )
)
@settings(max_examples=40, deadline=None)
def test_of_cases(backend: str, cases: list[dict[str, Any]]) -> None:
    """NaN is in the inputs, and what depends on it is unsafe in brief as it is at length."""
    for spec in (ALONE, OVER_RUN):
        evaluator = Evaluator(spec, None, backend)
        memory = evaluator.program.start()
        for raw, frame in zip(cases, frames(evaluator, cases), strict=True):
            judged = evaluator.program.judge(memory, frame)
            memory = evaluator.program.commit(memory, frame, None)
            brief, whole = (evaluator.result(frame, judged.rated[""], brief=each) for each in (True, False))
            assert list(brief.rules) == list(whole.rules)
            for name, one in whole.rules.items():
                assert brief.rules[name].verdict == one.verdict
                assert same(brief.rules[name].margin, one.margin)
                assert brief.rules[name].advisory == one.advisory
                assert not one.fired or brief.rules[name] == one or math.isnan(one.margin)
            assert (
                brief.safe
                == whole.safe
                == (not any(r.unsafe for r in whole.rules.values()) and not whole.faults)
            )
            if any(map(math.isnan, (*raw["signals"]["plan"]["v"], raw["signals"]["ego"]["v"]))):
                assert not brief.safe


@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_what_is_open_is_so_in_brief(backend: str) -> None:
    evaluator = Evaluator(OVER_RUN, None, backend)
    (frame,) = frames(evaluator, [case([1.0], 6.0, [])])
    result = evaluator.result(
        frame, evaluator.program.judge(evaluator.program.start(), frame).rated[""], brief=True
    )
    assert result.rules["soon"].verdict == "open"
    assert result.rules["apart"].verdict == "inactive"


def test_what_is_not_there_is_not_made_up() -> None:
    result = EVALUATOR.result(Frame(), Rated(bytes(4), [1.0] * 4, explained([0] * 4, [])), brief=True)
    with pytest.raises(KeyError):
        result.rules["slower"]
    assert "slower" not in result.rules
    assert result.rules == {name: RuleResult(name, "satisfied", 1.0, unit, advisory=name == "hint") for name, unit in zip(NAMES, ("m/s", "m", "m/s", "1"))}  # fmt: skip


@pytest.mark.parametrize(("codes", "margins"), [(3, 4), (4, 3), (5, 4), (0, 0)])
def test_rules_without_a_verdict_are_no_safe_ones(codes: int, margins: int) -> None:
    rated = Rated(bytes(codes), [1.0] * margins, explained([0] * 5, []))
    with pytest.raises(ValueError, match="of 4 rules"):
        EVALUATOR.result(Frame(), rated, brief=True)
    with pytest.raises(ValueError, match="of 0 rules"):
        Briefly({}, b"\0", [1.0], {})
