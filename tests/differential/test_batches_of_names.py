"""Names of members in arrays of many cases: what is wrong with one case is said of that one, in the words that it gets by itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trackmarshal as tm
from trackmarshal.backends.c.build import compiler

C = pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
SPEC = tm.loads("""
module lights
enum light { green, red }
signal ego : state { seen: light, v: m/s }
signal plan : trajectory { t: s increasing, shown: light }
signal objects : set of object { of: light }

rule single "of a record"
  require ego.seen is red and ego.v <= 3 m/s

rule sampled "of a timeline"
  for all p in plan
  require p.shown is red

rule every "of a set"
  for all o in objects
  require o.of is red
""")
NAMES = st.sampled_from(["red", "green", "gren", "", "rot"])
CASE = st.tuples(NAMES, st.tuples(NAMES, NAMES), st.tuples(NAMES, NAMES, NAMES))


@pytest.mark.parametrize("backend", ["reference", "numpy", C])
@settings(deadline=None)
@given(cases=st.lists(CASE, min_size=1, max_size=5))
def test_a_batch_says_what_each_case_says(backend: str, cases: list[tuple[Any, ...]]) -> None:
    evaluator = tm.Evaluator(SPEC, None, backend)
    seen, shown, of = ([case[place] for case in cases] for place in range(3))
    batch = evaluator.batch(
        {"ego": {"seen": np.array(seen), "v": np.ones(len(cases))}, "plan": {"t": np.arange(2.0), "shown": np.array(shown)}, "objects": {"of": np.array(of, dtype=object)}}
    )  # fmt: skip
    for number, (name, along, each) in enumerate(cases):
        alone = evaluator.case(
            {"signals": {"ego": {"seen": name, "v": 1.0}, "plan": {"t": [0.0, 1.0], "shown": list(along)}, "objects": {"of": list(each)}}}
        )  # fmt: skip
        assert bool(batch.safe[number]) == alone.safe
        assert [str(fault) for fault in batch.faults.get(number, ())] == [
            str(fault) for fault in alone.faults
        ]
        for rule, result in alone.rules.items():
            assert str(batch.verdicts[rule][number]) == result.verdict, (rule, number)


@pytest.mark.parametrize("backend", ["reference", "numpy", C])
def test_a_rule_that_is_named_twice_is_judged_once(backend: str) -> None:
    evaluator = tm.Evaluator(SPEC, ["every", "single", "every"], backend)
    assert [rule.name for rule in evaluator.rules] == ["every", "single"]
    assert evaluator.case(
        {"signals": {"ego": {"seen": "red", "v": 1.0}, "objects": [], "plan": {"t": [0.0], "shown": ["red"]}}}
    ).safe


def test_a_text_is_no_list_of_rules() -> None:
    with pytest.raises(tm.TrackmarshalError, match=r"`every` is one text"):
        tm.Evaluator(SPEC, "every")
