"""Comparing the other way round says the opposite, of whatever verdicts and margins; and `stricter` is what it says."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import trackmarshal as tm
from support.length import amount
from trackmarshal.comparing import EQUAL, MIXED, NOT_COMPARABLE, STRICTER, WEAKER
from trackmarshal.comparing.changes import Column, changed
from trackmarshal.runtime.verdict import UNSAFE, VERDICTS

RULE = tm.loads('module m\nsignal ego : state { v: m/s }\nrule slow "" require ego.v <= 3 m/s').rules[0]
OPPOSITE = {EQUAL: EQUAL, STRICTER: WEAKER, WEAKER: STRICTER, MIXED: MIXED, NOT_COMPARABLE: NOT_COMPARABLE}
#: What a rule can say: a verdict with a margin that goes with it.
SAID = st.sampled_from(["satisfied", "violated", "undefined", "inactive", "open"]).flatmap(
    lambda verdict: st.tuples(
        st.just(verdict),
        {
            "satisfied": st.sampled_from([0.0, 0.5, 1.0, np.inf]), "violated": st.sampled_from([0.0, -0.5, -1.0, -np.inf]),
            "inactive": st.just(np.inf), "undefined": st.just(np.nan), "open": st.just(np.nan),
        }[verdict],
    )
)  # fmt: skip
RUNS = st.lists(st.tuples(SAID, SAID), min_size=1, max_size=4)


def column(cells: list[tuple[tuple[str, float], tuple[str, float]]], turned: bool = False) -> Column:
    """A run of these cycles; both candidates say the same."""
    sides = [[cell[side] for cell in cells] for side in ((1, 0) if turned else (0, 1))]
    codes = [
        np.repeat(np.array([[VERDICTS.index(verdict)] for verdict, _ in side], np.uint8), 2, axis=1)
        for side in sides
    ]
    margins = [np.repeat(np.array([[margin] for _, margin in side]), 2, axis=1) for side in sides]
    return Column(
        "r",
        np.arange(len(cells), dtype=np.float64) * 0.1,
        np.ones((len(cells), 2), np.bool_),
        codes[0],
        codes[1],
        margins[0],
        margins[1],
    )


@given(cells=RUNS)
@settings(max_examples=amount(35, 200), deadline=None)
def test_the_other_way_round_is_the_opposite(
    cells: list[tuple[tuple[str, float], tuple[str, float]]],
) -> None:
    there, back = changed(RULE, RULE, [column(cells)]), changed(RULE, RULE, [column(cells, turned=True)])
    assert back.word == OPPOSITE[there.word]
    assert (back.changed, back.undecided) == (there.changed, there.undecided)
    assert sorted((flip.new, flip.old, flip.spans) for flip in back.flips) == sorted(
        (flip.old, flip.new, flip.spans) for flip in there.flips
    )


@given(cells=RUNS)
@settings(max_examples=amount(35, 200), deadline=None)
def test_the_word_is_what_it_says(cells: list[tuple[tuple[str, float], tuple[str, float]]]) -> None:
    """Cell by cell, in plain Python."""
    word = changed(RULE, RULE, [column(cells)]).word
    decided = [cell for cell in cells if (cell[0][0] == "open") == (cell[1][0] == "open")]
    if word == EQUAL:
        assert all(a[0] == b[0] and (a[1] == b[1] or a[1] != a[1]) for a, b in cells)
    if word in (STRICTER, WEAKER):
        pairs = [(a, b) if word == STRICTER else (b, a) for a, b in decided]
        assert not any(a[0] in UNSAFE and b[0] not in UNSAFE for a, b in pairs)
        assert not any(b[1] > a[1] for a, b in pairs)
        assert any(b[1] < a[1] or (b[0] in UNSAFE and a[0] not in UNSAFE) for a, b in pairs)
    if word == MIXED:
        assert len(decided) > 1
