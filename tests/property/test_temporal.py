"""The numpy kernels equal the literal reference, to the bit, on any samples and windows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any
from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trackmarshal.backends.numpy import temporal
from trackmarshal.backends.numpy.temporal import blocks
from trackmarshal.backends.reference import temporal as reference

ROWS = 2
#: The module, of which the package has the function by the same name.
DOUBLING = import_module("trackmarshal.backends.numpy.temporal.until")
#: No wall time in a verdict: a loaded machine is slow, not wrong.
unhurried = settings(deadline=None)
MARGINS = st.one_of(
    st.sampled_from([0.0, -0.0, math.inf, -math.inf, 1.0, -1.0, 5e-324, 1e308]),
    st.integers(-9, 9).map(float),
    st.floats(allow_nan=False),
)


@dataclass(frozen=True)
class Case:
    """A timeline, bounds, and values of p and q on ROWS rows."""

    t: list[float]
    lower: float | None
    upper: float | None
    p: list[tuple[list[bool], list[float]]]
    q: list[tuple[list[bool], list[float]]]
    block: int


@st.composite
def times(draw: st.DrawFn) -> list[float]:
    """Equidistant times (exact and rounded ones), multiples of a quarter, some at one time, or anything that increases."""
    n = draw(st.integers(0, 40))
    kind = draw(st.sampled_from(["product", "sum", "quarters", "coarse", "any"]))
    if kind == "any":
        value = st.floats(-1e6, 1e6)
        return sorted(draw(st.lists(value, min_size=n, max_size=n, unique=True)))
    if kind == "coarse":  # several samples at one time, beside which small bounds are lost
        return [
            1e18 + 100.0 * one for one in sorted(draw(st.lists(st.integers(0, 9), min_size=n, max_size=n)))
        ]
    if kind == "quarters":
        steps = draw(st.lists(st.integers(1, 12), min_size=n, max_size=n))
        return [0.25 * sum(steps[: k + 1]) for k in range(n)]
    start, period = draw(st.sampled_from([0.0, -3.3, 1e5])), draw(st.sampled_from([1.0, 0.1, 0.01, 1 / 3]))
    if kind == "product":
        return [start + k * period for k in range(n)]
    return np.cumsum(np.full(n, period)).tolist()  # type: ignore[no-any-return]


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """Bounds are often differences of times, so that edges fall on samples; or equal, or beyond the trace."""
    t = draw(times())
    span = t[-1] - t[0] if t else 1.0
    sources = [st.just(None), st.just(0.0), st.floats(0.0, 2 * span + 1), st.just(math.inf)]
    if len(t) > 1:
        sample = st.integers(0, len(t) - 1)
        sources.insert(0, st.tuples(sample, sample).map(lambda pair: abs(t[pair[0]] - t[pair[1]])))
    lower, upper = draw(st.one_of(sources)), draw(st.one_of(sources))
    if draw(st.booleans()) and draw(st.booleans()):
        upper = lower
    if lower is not None and upper is not None and lower > upper:
        lower, upper = upper, lower
    values = st.tuples(
        st.lists(st.booleans(), min_size=len(t), max_size=len(t)),
        st.lists(MARGINS, min_size=len(t), max_size=len(t)),
    )
    p, q = ([draw(values) for _ in range(ROWS)] for _ in "pq")
    return Case(t, lower, upper, p, q, draw(st.sampled_from([1, 2, 3, 8, 16384])))


def stacked(bounds: list[tuple[list[bool], list[float]]]) -> tuple[Any, Any]:
    """Rows of values as arrays (ROWS, n)."""
    return (
        np.array([sat for sat, _ in bounds], dtype=np.bool_),
        np.array([margin for _, margin in bounds], dtype=np.float64),
    )


def assert_same(found: tuple[Any, Any], expected: list[tuple[list[bool], list[float]]]) -> None:
    """Equal shapes, types, Booleans, and margins to the bit (0.0 is not -0.0)."""
    sat, margin = found
    want_sat, want = stacked(expected)
    assert sat.dtype == np.bool_
    assert margin.dtype == np.float64
    assert sat.tolist() == want_sat.tolist()
    assert margin.shape == want.shape
    assert margin.tobytes() == want.tobytes(), (margin, want)


@unhurried
@given(cases(), st.booleans())
def test_windows(case: Case, past: bool) -> None:
    w = temporal.windows(np.array(case.t, dtype=np.float64), case.lower, case.upper, past)
    expected = reference.windows(case.t, case.lower, case.upper, past)
    members = [list(range(start, stop)) for start, stop in zip(w.start.tolist(), w.stop.tolist())]
    assert members == [list(window) for window in expected]
    assert w.longest == max(map(len, expected), default=0)
    lead = w.lead()
    before = [list(range(start, stop)) for start, stop in zip(lead.start.tolist(), lead.stop.tolist())]
    edges = w.stop.tolist() if past else w.start.tolist()
    assert before == [list(range(e, k + 1) if past else range(k, e)) for k, e in enumerate(edges)]
    assert lead.longest == max(map(len, before), default=0)


@unhurried
@given(cases(), st.booleans(), st.sampled_from(["always", "eventually"]))
def test_extrema(case: Case, past: bool, operator: str) -> None:
    w = temporal.windows(np.array(case.t, dtype=np.float64), case.lower, case.upper, past)
    spelled_out = reference.windows(case.t, case.lower, case.upper, past)
    with mock.patch.object(blocks, "BLOCK", case.block):
        found = getattr(temporal, operator)(*stacked(case.p), w)
    assert_same(found, [getattr(reference, operator)(*p, spelled_out) for p in case.p])


@unhurried
@given(cases(), st.booleans())
def test_until_and_since(case: Case, past: bool) -> None:
    operator = "since" if past else "until"
    w = temporal.windows(np.array(case.t, dtype=np.float64), case.lower, case.upper, past)
    spelled_out = reference.windows(case.t, case.lower, case.upper, past)
    with mock.patch.object(blocks, "BLOCK", case.block):
        found = getattr(temporal, operator)(*stacked(case.p), *stacked(case.q), w)
    expected = [getattr(reference, operator)(*p, *q, spelled_out) for p, q in zip(case.p, case.q)]
    assert_same(found, expected)


@unhurried
@given(
    st.integers(0, 2**32 - 1), st.sampled_from([-20, -6, 0, 6, 20]), st.booleans(), st.booleans(),
    st.tuples(st.integers(0, 20), st.integers(0, 170)), st.sampled_from([(1, 1), (1, 8), (3, 1), (3, 7), (3, 64)]), st.sampled_from([16, 16384]),
)  # fmt: skip
def test_spans_beyond_which_nothing_says_more(
    seed: int, above: int, past: bool, uneven: bool, window: tuple[int, int], looks: tuple[int, int], block: int
) -> None:  # fmt: skip
    """p that is mostly below q, about as it, or above it: in long windows, where doubling may end early or must not."""
    random, n = np.random.default_rng(seed), 150
    t = np.cumsum(random.integers(1, 4, n).astype(np.float64) if uneven else np.ones(n)) * 0.25
    p, q = (random.integers(-9, 10, n).astype(np.float64) for _ in "pq")
    p += above * random.random()
    for some in (p, q):
        rare = random.random(n) < 0.03
        some[rare] = random.choice([-0.0, 0.0, np.inf, -np.inf, 1e308], np.count_nonzero(rare))
    p_sat, q_sat = random.random(n) < 0.5 + 0.024 * above, random.random(n) < random.random()
    lower, upper = 0.25 * window[0], 0.25 * sum(window)
    w, spelled_out = temporal.windows(t, lower, upper, past), reference.windows(t.tolist(), lower, upper, past)  # fmt: skip
    operator = "since" if past else "until"
    with (
        mock.patch.object(DOUBLING, "LOOK", looks[0]),
        mock.patch.object(DOUBLING, "FEW", looks[1]),
        mock.patch.object(blocks, "BLOCK", block),
    ):
        found = getattr(temporal, operator)(p_sat, p, q_sat, q, w)
    expected = getattr(reference, operator)(*(each.tolist() for each in (p_sat, p, q_sat, q)), spelled_out)
    assert_same((found[0][None], found[1][None]), [expected])


@unhurried
@given(
    st.integers(0, 2**32 - 1), st.booleans(), st.booleans(), st.tuples(st.integers(0, 20), st.integers(0, 170)),
    st.sampled_from([1, 16, 40, 16384]), st.sampled_from([0.0, 0.0, 0.01]),
)  # fmt: skip
def test_what_has_to_hold_does_by_more_than_any_goal(
    seed: int, past: bool, uneven: bool, window: tuple[int, int], block: int, rare: float
) -> None:
    """p that is nowhere below any q, or as much as the greatest, zeros of either sign among them; or is below it in some blocks, or on the way to a window."""
    random, n = np.random.default_rng(seed), 150
    t = np.cumsum(random.integers(1, 4, n).astype(np.float64) if uneven else np.ones(n)) * 0.25
    most = random.choice([0.0, 3.0, 1e300, -1e300, math.inf, -math.inf])
    p = np.where(random.random(n) < 0.5, most, np.maximum(most, random.choice([0.0, 1e301, math.inf], n)))
    q = np.where(random.random(n) < 0.5, most, np.minimum(most, random.choice([-0.0, -2.0, -math.inf], n)))
    for some in (p, q):
        some[(some == 0.0) & (random.random(n) < 0.5)] = -0.0
    p_sat, q_sat = random.random(n) >= rare, random.random(n) < random.random()
    p[random.random(n) < rare] = random.choice([-math.inf, -5.0, 2.0])
    lower, upper = 0.25 * window[0], 0.25 * sum(window)
    w, spelled_out = temporal.windows(t, lower, upper, past), reference.windows(t.tolist(), lower, upper, past)  # fmt: skip
    operator = "since" if past else "until"
    with mock.patch.object(DOUBLING, "FEW", 1), mock.patch.object(blocks, "BLOCK", block):
        found = getattr(temporal, operator)(p_sat, p, q_sat, q, w)
    expected = getattr(reference, operator)(*(each.tolist() for each in (p_sat, p, q_sat, q)), spelled_out)
    assert_same((found[0][None], found[1][None]), [expected])


@unhurried
@given(cases(), st.booleans(), st.integers(0, 39))
def test_windows_of_some(case: Case, past: bool, fewer: int) -> None:
    """Those nearest to where windows look to are said as if all were asked for."""
    w = temporal.windows(np.array(case.t, dtype=np.float64), case.lower, case.upper, past)
    asked = max(w.n - fewer, min(w.n, 1))
    begin, end = (edge if isinstance(edge, int) else edge[:asked] for edge in (w.begin, w.end))
    few = replace(w, begin=begin, end=end, asked=asked)
    operator, both = (temporal.since if past else temporal.until), (*stacked(case.p), *stacked(case.q))
    with mock.patch.object(blocks, "BLOCK", case.block):
        for found, whole in (
            (operator(*both, few), operator(*both, w)),
            (temporal.always(*both[:2], few), temporal.always(*both[:2], w)),
        ):
            for some, every in zip(found, whole):
                own = every[:, w.n - asked :] if past else every[:, :asked]
                assert some.shape == own.shape
                assert some.tobytes() == own.tobytes()


@unhurried
@given(cases(), st.sampled_from([-1, 1]), st.booleans())
def test_shift(case: Case, step: int, weak: bool) -> None:
    found = temporal.shift(*stacked(case.p), step, weak)
    assert_same(found, [reference.shift(*p, step, weak) for p in case.p])


@unhurried
@given(cases(), st.booleans())
def test_until_is_what_it_says(case: Case, past: bool) -> None:
    """The reference against the definition in one expression: slices of p instead of a running minimum."""
    w = reference.windows(case.t, case.lower, case.upper, past)
    (_, p), (_, q) = case.p[0], case.q[0]
    _, margin = (reference.since if past else reference.until)(*case.p[0], *case.q[0], w)
    assert margin == [
        max((min([q[j], *(p[j + 1 : k + 1] if past else p[k:j])]) for j in window), default=-math.inf)
        for k, window in enumerate(w)
    ]


@pytest.mark.parametrize(
    ("period", "jitter"),
    [
        (0.01, 0.0),
        *(
            pytest.param(*other, marks=pytest.mark.acceptance)
            for other in ((1 / 3, 0.3), (1.0, 0.0), (1 / 3, 0.0), (1.0, 0.3), (0.01, 0.3))
        ),
    ],
)
def test_long_timelines_cross_blocks(period: float, jitter: float) -> None:
    rng = np.random.default_rng(5)
    n = 2 * blocks.BLOCK + 777
    t = np.arange(n) * period + period * jitter * rng.random(n)
    margin = rng.integers(-50, 50, n).astype(np.float64)
    other = rng.integers(-50, 50, n).astype(np.float64)
    for lower, upper in ((0.0, 20.0), (3.0, 21.5)):
        for past in (False, True):
            w = temporal.windows(t, lower * period, upper * period, past)
            literal = reference.windows(t.tolist(), lower * period, upper * period, past)
            held = "since" if past else "until"
            p, q = (margin >= 0, margin), (other >= 0, other)
            lists = [x.tolist() for x in (*p, *q)]
            for name, operands, spelled in (("always", p, lists[:2]), (held, (*p, *q), lists)):
                sat, found = getattr(temporal, name)(*operands, w)
                want_sat, want = getattr(reference, name)(*spelled, literal)
                assert sat.tolist() == want_sat
                assert found.tolist() == want
