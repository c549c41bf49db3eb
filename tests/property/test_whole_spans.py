"""Extrema over spans that are asked for, as the definitions say them element by element."""

from __future__ import annotations

from typing import Any
from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from property.test_over_run import EXAMPLES
from trackmarshal.backends.numpy.temporal.carrier import MARGIN, VERDICT, Carrier
from trackmarshal.backends.numpy.whole import spans as module
from trackmarshal.backends.numpy.whole.spans import Levels, Spans

_NUMBERS = st.lists(
    st.tuples(*[st.sampled_from([-np.inf, -2.0, -1.0, 0.0, 0.5, 1.0, np.inf])] * 2), min_size=1, max_size=40
)


@given(_NUMBERS, st.lists(st.lists(st.tuples(st.integers(0, 40), st.integers(0, 40)), max_size=12), min_size=1, max_size=3), st.sampled_from([MARGIN, VERDICT]), st.sampled_from([0, 2, 16, 1000]))  # fmt: skip
@settings(max_examples=10 * EXAMPLES, deadline=None)
def test_as_defined(
    numbers: list[tuple[float, float]], asked: list[list[tuple[int, int]]], carrier: Carrier, few: int
) -> None:
    """Of no element, of one, of all; asked one after the other of one table, or looked through each by itself where they are few."""
    with mock.patch.object(module, "FEW", few):
        _compare(numbers, asked, carrier)


def _compare(
    numbers: list[tuple[float, float]], asked: list[list[tuple[int, int]]], carrier: Carrier
) -> None:
    held, goal = np.array(numbers).T.copy() if carrier is MARGIN else np.array(numbers).T > 0.0
    until, least, most = (
        Spans(held, goal, carrier),
        Spans(held, None, carrier),
        Spans(None, goal, carrier),
    )
    for pairs in asked:
        ends = [sorted(min(end, len(numbers)) for end in pair) for pair in pairs]
        begin, end = (np.array([pair[i] for pair in ends], dtype=np.intp) for i in (0, 1))
        spans = Levels(begin, end, len(numbers))
        every = [range(low, high) for low, high in ends]
        lasting = [min((held[i] for i in own), default=carrier.top) for own in every]
        assert least.all(spans).tolist() == lasting
        assert until.all(spans).tolist() == lasting
        assert most.until(spans).tolist() == [
            max((goal[i] for i in own), default=carrier.bottom) for own in every
        ]
        assert until.until(spans).tolist() == [
            max((min([goal[i], *held[own[0] : i]]) for i in own), default=carrier.bottom) for own in every
        ]


@pytest.mark.parametrize("length", [65_535, 65_536, 70_000])
def test_spans_that_are_long(length: int) -> None:
    values: Any = np.random.default_rng(length).normal(size=70_001)
    begin = np.array([0, 70_001 - length, 5, 70_001])
    end = np.array([length, 70_001, 6, 70_001])
    spans, wanted = Levels(begin, end, len(values)), [values[a:b] for a, b in zip(begin[:3], end[:3])]
    assert Spans(values, None, MARGIN).all(spans).tolist() == [*map(min, wanted), np.inf]
    assert Spans(None, values, MARGIN).until(spans).tolist() == [*map(max, wanted), -np.inf]
