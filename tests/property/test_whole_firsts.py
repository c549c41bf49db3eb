"""Where a window decides: found in one look along a piece, and as the definition of each operator says it, cycle by cycle."""

from __future__ import annotations

import math
from typing import Any
from unittest import mock

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from property.test_over_run import EXAMPLES
from property.test_whole_run import CUTS, same
from support.length import at_length
from trackmarshal.backends.numpy.whole import spans
from trackmarshal.backends.numpy.whole.elements import edge_of, elements
from trackmarshal.backends.numpy.whole.firsts import NEVER, STAYS, Firsts
from trackmarshal.backends.numpy.whole.outcomes import OTHER, together, worst
from trackmarshal.backends.over_run.outcome import RANK
from trackmarshal.runtime.verdict import VERDICTS

#: Surely, not, perhaps.
TRUTH = {True: (True, True), False: (False, False), None: (False, True)}
#: One cycle: how long after the one before, how many are missing between, and what two formulas are.
_CYCLE = st.tuples(st.integers(1, 4), st.sampled_from([0, 0, 0, 1]), st.sampled_from([True, False, None]), st.sampled_from([True, False, None]))  # fmt: skip


@given(st.lists(_CYCLE, min_size=1, max_size=14), st.integers(0, 5), st.integers(0, 8))
@settings(max_examples=20 * EXAMPLES, deadline=None)
def test_as_defined(cycles: list[Any], lower: int, length: int) -> None:
    stamps = np.cumsum([10 * cycle[0] for cycle in cycles]).astype(np.int64)
    own = elements(stamps, np.array([cycle[1] for cycle in cycles]), None)
    windows = own.ahead(10 * lower, 10 * (lower + length))
    places = range(len(own)) if own.cycles is None else own.cycles.tolist()
    held, goal = ({at: cycle[i] for at, cycle in zip(places, cycles)} for i in (2, 3))
    number = {at: place for place, at in enumerate(places)}
    sides = [
        tuple(np.array([TRUTH[of.get(at)][best] for at in range(len(own))]) for best in (0, 1))
        for of in (held, goal)
    ]
    inside = [list(range(windows.start[at], windows.stop[at])) if windows.stop[at] else [] for at in places]

    found = Firsts(windows, own)
    first, nowhere = found.decided(*sides[0])
    assert first.tolist() == [
        min((number[j] for j in window if held.get(j) is True), default=NEVER) for window in inside
    ]
    assert nowhere.tolist() == [all(held.get(j) is False for j in window) for window in inside]
    # What is known of each cycle is asked for once.
    surely = sides[0][0]
    assert [each.tolist() for each in found.decided(surely, surely)] == [
        first.tolist(),
        [all(held.get(j) is not True for j in window) for window in inside],
    ]
    true, false = found.until((sides[0][0], sides[0][1]), (sides[1][0], sides[1][1]))
    for at, window, is_true, is_false in zip(places, inside, true.tolist(), false.tolist()):
        reached = [
            j for j in window if goal.get(j) is True and all(held.get(i) is True for i in range(at, j))
        ]
        assert is_true == min((number[j] for j in reached), default=NEVER)
        broken = next((j for j in range(at, len(own)) if held.get(j, None) is False), None)
        end = windows.stop[at] if window else max(at, _end(windows, at))
        may = [j for j in window if goal.get(j) is not False and (broken is None or j <= broken)]
        if may:
            assert is_false == NEVER
        elif broken is not None and broken < end:
            assert is_false == number[broken]
        else:
            assert is_false == STAYS


#: How often something holds, and how likely it stays as it was.
_OFTEN = st.tuples(st.sampled_from([0.0, 0.05, 0.5, 0.9, 0.98, 1.0]), st.sampled_from([0.0, 0.0, 0.97]))


@given(st.integers(0, 2**32 - 1), st.integers(1, 150), _OFTEN, _OFTEN, st.integers(0, 5), st.integers(0, 40), st.booleans())  # fmt: skip
@settings(max_examples=10 * EXAMPLES, deadline=None)
def test_however_often_something_holds(
    seed: int, n: int, held: tuple[float, float], goal: tuple[float, float], lower: int, length: int, even: bool
) -> None:  # fmt: skip
    """Without gaps, of which nothing is undefined: where an operator is decided before its window is closed."""
    random = np.random.default_rng(seed)
    stamps = np.cumsum(np.full(n, 10) if even else random.integers(1, 21, n))
    p, q = _often(random, n, *held), _often(random, n, *goal)
    windows = (own := elements(stamps, np.zeros(n, np.intp), None)).ahead(10 * lower, 10 * (lower + length))
    reached, inside = Firsts(windows, own).found(q)
    first, holds = Firsts(windows, own).settles(p, q)
    for at in range(n):
        window = [j for j in range(at, n) if 10 * lower <= stamps[j] - stamps[at] <= 10 * (lower + length)]
        begin = next((j for j in range(at, n) if stamps[j] - stamps[at] >= 10 * lower), n)
        assert reached[at] == next((j for j in range(begin, n) if q[j]), NEVER)
        assert inside[at] == any(q[j] for j in window)
        fails = next((j for j in range(at, n) if not p[j]), NEVER)
        assert first[at] == min(reached[at], fails)
        assert holds[at] == any(q[j] and all(p[at:j]) for j in window)


def _often(random: np.random.Generator, n: int, share: float, stays: float) -> Any:
    found, new = random.random(n) < share, random.random(n) >= stays
    new[0] = True
    return found[np.maximum.accumulate(np.where(new, np.arange(n), 0))]


@given(st.lists(st.integers(1, 60), min_size=1, max_size=40), st.sampled_from(["even", "late", "any"]), st.integers(0, 400), st.sampled_from(["left", "right"]), st.integers(1, 40))  # fmt: skip
@settings(max_examples=20 * EXAMPLES, deadline=None)
def test_edges_are_counted(steps: list[int], kind: str, reach: int, side: Any, asked: int) -> None:
    """Stamps that come evenly, a little late, or anyhow: how many lie before what each reaches."""
    late = {"even": 0, "late": 5, "any": 1000}[kind]
    keys = np.cumsum([20 + step % (late + 1) if kind == "any" else 20 for step in steps]).astype(np.int64)
    keys += np.array([step % (late + 1) if kind == "late" else 0 for step in steps])
    found = edge_of(keys, keys[:asked] + reach, side)
    listed = keys.tolist()
    wanted = [
        sum(key < one + reach or (side == "right" and key == one + reach) for key in listed)
        for one in listed[:asked]
    ]
    got = [min(k + found, len(keys)) for k in range(len(wanted))] if isinstance(found, int) else found.tolist()  # fmt: skip
    assert got == wanted


@given(st.lists(_CYCLE, min_size=1, max_size=14), st.integers(0, 5), st.integers(0, 8), st.integers(1, 28))
@settings(max_examples=10 * EXAMPLES, deadline=None)
def test_windows_back_from_the_last_elements(cycles: list[Any], lower: int, length: int, asked: int) -> None:
    stamps = np.cumsum([10 * cycle[0] for cycle in cycles]).astype(np.int64)
    own = elements(stamps, np.array([cycle[1] for cycle in cycles]), None)
    asked = min(asked, len(own))
    every, few = (own.back(10 * lower, 10 * (lower + length), count) for count in (len(own), asked))
    assert few.start.tolist() == every.start.tolist()[-asked:]
    assert few.stop.tolist() == every.stop.tolist()[-asked:]
    assert few.longest == (few.stop - few.start).max()


def _end(windows: Any, at: int) -> int:
    """The end of an empty window: what has to hold has to hold until there."""
    return min(at + windows.end, windows.n) if isinstance(windows.end, int) else int(windows.end[at])


#: A place, a verdict, and a margin.
_SAID = st.tuples(st.integers(0, 3), st.sampled_from(RANK), st.floats(-9, 9).map(lambda x: x + 0.0))


@given(st.lists(_SAID, max_size=40), st.lists(_SAID, min_size=4, max_size=4), st.booleans())
@settings(max_examples=20 * EXAMPLES, deadline=None)
def test_the_worst_of_what_is_said(said: list[Any], own: list[Any], in_order: bool) -> None:
    def margin(verdict: str, size: float) -> float:
        return {"undefined": math.nan, "open": math.nan, "inactive": math.inf}.get(verdict, size)

    said = sorted(said, key=lambda one: one[0]) if in_order else said
    wanted = []
    for place in range(4):
        each = [(one[1], margin(*one[1:])) for one in (own[place], *(one for one in said if one[0] == place))]
        bad = min((name for name, _ in each), key=RANK.index)
        wanted.append((bad, repr(min(size for name, size in each if name == bad))))
    codes, margins = worst(
        (_codes(own), np.array([margin(*one[1:]) for one in own])),
        np.array([one[0] for one in said], dtype=np.intp),
        _codes(said),
        np.array([margin(*one[1:]) for one in said]),
    )
    assert [(VERDICTS[code], repr(size)) for code, size in zip(codes, margins.tolist())] == wanted


#: Margins as comparisons have them: none of what holds is below zero, none of what does not above it.
_SIGNED = {"violated": [-math.inf, -2.0, -1.0, 0.0], "satisfied": [0.0, 1.0, 2.0, math.inf]}
_ANY = [-math.inf, -1.0, 0.0, 1.0, math.inf]


@given(
    st.data(),
    st.lists(st.sampled_from(["open", "undefined", ""]), min_size=1, max_size=5),
    st.booleans(),
    st.booleans(),
)
@settings(max_examples=20 * EXAMPLES, deadline=None)
def test_the_worst_of_what_is_said_of_oneself_and_of_others(
    data: st.DataObject, waits: list[str], plain: bool, agree: bool
) -> None:
    """Each cycle that does not wait says something of itself, after all that is said of earlier ones; one that waits is open, or undefined for good."""
    known = ["violated", "satisfied"] if plain else [name for name in RANK if name != "open"]

    def one(place: int) -> tuple[int, str, float]:
        verdict = data.draw(st.sampled_from(known))
        drawn = data.draw(st.sampled_from(_SIGNED.get(verdict, _ANY) if agree else _ANY))
        return place, verdict, {"undefined": math.nan, "inactive": math.inf}.get(verdict, drawn)

    others = data.draw(st.lists(st.integers(0, len(waits) - 1), max_size=8))
    said = [one(place) for place in others]
    said += [one(place) for place, waiting in enumerate(waits) if not waiting]
    wanted = []
    for place, waiting in enumerate(waits):
        each = [(name, margin) for at, name, margin in said if at == place]
        each += [(waiting, math.nan)] if waiting else []
        bad = min((name for name, _ in each), key=RANK.index)
        wanted.append((bad, repr(min(margin for name, margin in each if name == bad))))
    own = np.array([VERDICTS.index(one) if one else OTHER for one in waits], dtype=np.uint8)
    codes, margins = together(
        own, np.array([at for at, _, _ in said], dtype=np.intp), _codes(said), np.array([margin for _, _, margin in said])
    )  # fmt: skip
    assert [(VERDICTS[code], repr(margin)) for code, margin in zip(codes, margins.tolist())] == wanted


def _codes(said: list[Any]) -> Any:
    return np.array([VERDICTS.index(one[1]) for one in said], dtype=np.uint8)


@pytest.mark.parametrize("cuts", [[], [1] * 40, [7, 16]])
@pytest.mark.parametrize(
    "formula",
    [
        "ego.w > -1 m/s until[0.2 s, 0.5 s] ego.v > 1 m/s",
        "ego.w > -2 m/s until[0.3 s, 0.6 s] ego.v > -1 m/s",
        "not (ego.w > -1 m/s until[0 s, 0.4 s] ego.v > 1 m/s)",
        "ego.v / ego.w < 4 until[0.1 s, 0.3 s] ego.v > 1 m/s",
        "ego.w > -1 m/s until[0 s, 0.3 s] ego.v / ego.w > 4",
        "(always[0 s, 0.2 s] ego.v / ego.w < 9) or (eventually[0.1 s, 0.7 s] ego.v > 1 m/s)",
        "(eventually[0 s, 0.1 s] ego.v / ego.w > 9) and (always[0.1 s, 0.7 s] ego.v > -2 m/s)",
        "(always[0.2 s, 0.4 s] ego.v > -1 m/s) xor (eventually[0 s, 0.3 s] ego.w > 1 m/s)",
        "whenever eventually[0 s, 0 s] ego.v > 0 m/s then next ego.w > 0 m/s",
    ],
)
def test_numbers_that_are_all_different(formula: str, cuts: list[int]) -> None:
    """Of each window another cycle decides, by its own margin; where `ego.w` is 0, nothing is known."""
    numbers = np.random.default_rng(7).normal(size=(40, 2)).round(3)
    numbers[::6, 1] = 0.0
    cycles: list[dict[str, Any] | None] = [
        {"id": i, "t": i / 10, "signals": {"ego": {"v": v, "w": w, "on": True}}}
        for i, (v, w) in enumerate(numbers.tolist())
    ]
    cycles[13] = cycles[29] = None
    whenever, _, demand = formula.rpartition(" then ")
    same(f'{_MODULE}rule f "" {whenever} require {demand}\n', cycles, cuts)


def test_an_operator_that_another_one_decides_earlier() -> None:
    """What `or` is known by one side before the other has said its last word."""
    for formula in (
        "(always[0 s, 1 s] ego.v > 0 m/s) and (always[0 s, 0.3 s] ego.w > 0 m/s)",
        "(eventually[0 s, 1 s] ego.v > 0 m/s) or (eventually[0.2 s, 0.3 s] ego.w > 0 m/s)",
        "(eventually[0 s, 1 s] ego.v > 3 m/s) iff (always[0.1 s, 0.5 s] ego.w > 0 m/s)",
    ):
        rows = [(2.0, 1.0), (1.0, 2.0), (0.5, -1.0), (-1.0, -2.0), (-3.0, 1.0), (5.0, 0.5), (0.25, 3.0)] * 3
        cycles: list[dict[str, Any] | None] = [
            {"id": i, "t": i / 10, "signals": {"ego": {"v": v, "w": w, "on": True}}}
            for i, (v, w) in enumerate(rows)
        ]
        same(f'{_MODULE}rule f "" require {formula}\n', cycles, [4, 5])


@pytest.mark.parametrize("cuts", [[], [1] * 30, [7, 16]])
@pytest.mark.parametrize("op", ["xor", at_length("iff")])
@pytest.mark.parametrize("of", ["{} until[0 s, 0.3 s] ego.v > 1 m/s", "{} until[0.1 s, 0.3 s] ego.v > 1 m/s", "ego.w > -1 m/s until[0 s, 0.4 s] {}", "always[0 s, 0.3 s] {}", "eventually[0.1 s, 0.3 s] {}"])  # fmt: skip
@pytest.mark.parametrize("missing", [(), (9, 20)])
def test_margins_that_do_not_say_whether_it_holds(
    of: str, op: str, missing: tuple[int, ...], cuts: list[int]
) -> None:
    """What `xor` denies has a margin above zero, and what `iff` allows one below."""
    numbers = np.random.default_rng(3).normal(size=(30, 2)).round(2)
    cycles: list[dict[str, Any] | None] = [
        None if i in missing else {"id": i, "t": i / 10, "signals": {"ego": {"v": v, "w": w, "on": True}}}
        for i, (v, w) in enumerate(numbers.tolist())
    ]
    same(f'{_MODULE}rule f "" require {of.format(f"(ego.v > 0 m/s {op} ego.w > 0 m/s)")}\n', cycles, cuts)


_EXACT = st.sampled_from([0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 5e-324, -5e-324, 1e300, -1e300])
_OPERANDS = st.sampled_from(["ego.v > 0 m/s", "ego.v >= 0 m/s", "ego.w < 1 m/s", "not (ego.w > ego.v)", "ego.on", "(ego.v > 0 m/s xor ego.w > 0 m/s)", "(ego.v > 0 m/s or ego.w == 1 m/s)"])  # fmt: skip
_STEPS = st.sampled_from([1, 1, 1, 2, 4])


@given(
    st.sampled_from(["always{1} {0}", "eventually{1} {0}", "({0}) until{1} ({2})"]), _OPERANDS, _OPERANDS, st.tuples(st.integers(0, 6), st.integers(0, 40)),
    st.lists(st.tuples(_EXACT, _EXACT, st.booleans(), _STEPS), min_size=1, max_size=24), st.booleans(), CUTS,
    st.sampled_from([0, 16, 1000]),
)  # fmt: skip
@example(
    "always{1} {0}",
    "ego.v >= 0 m/s",
    "ego.v > 0 m/s",
    (2, 5),
    [(0.0, 0.0, False, 1)] * 4 + [(0.0, 0.0, False, 4)],
    False,
    [],
    0,
)
@settings(max_examples=6 * EXAMPLES, deadline=None)
def test_an_operator_that_is_the_whole_rule(
    of: str, p: str, q: str, bounds: tuple[int, int], rows: list[Any], even: bool, cuts: list[int], few: int
) -> None:
    """All cycles are there, and nothing is undefined: zeros with a sign, huge and tiny margins, windows of one cycle and longer than the run."""
    t, cycles = 0, list[Any]()
    for i, (v, w, on, step) in enumerate(rows):
        t += 1 if even else step
        cycles.append({"id": i, "t": t / 10, "signals": {"ego": {"v": v, "w": w, "on": on}}})
    window = f"[{bounds[0] / 10!r} s, {sum(bounds) / 10!r} s]"
    with mock.patch.object(spans, "FEW", few):  # looked through one by one, or in a table
        same(f'{_MODULE}rule f "" require {of.format(p, window, q)}\n', cycles, cuts)


_MODULE = "module m\nsignal ego : state { v: m/s, w: m/s, on: bool }\n"
