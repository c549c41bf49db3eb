"""How much runs every day, and how much in `make acceptance`."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, TypeVar

import pytest
from _pytest.mark import ParameterSet

T = TypeVar("T")

#: `make acceptance`: everything as it ships, and more of each.
AT_LENGTH = os.environ.get("TRACKMARSHAL_OPTIMIZED") == "1"


def amount(daily: T, full: T) -> T:
    """So many every day, so many at length."""
    return full if AT_LENGTH else daily


def at_length(*items: Any) -> Any:
    """A case of `parametrize` that only `make acceptance` runs."""
    return pytest.param(*items, marks=pytest.mark.acceptance)


def shared_out(cases: Iterable[Any], every: int) -> list[Any]:
    """All cases of `parametrize` for `make acceptance`, one of so many for every day.

    A case of several values is a tuple. Each of them may be a `pytest.param`, whose marks are the case's.
    """
    found = []
    for place, case in enumerate(cases):
        several = isinstance(case, tuple) and not isinstance(case, ParameterSet)
        parts = [
            p if isinstance(p, ParameterSet) else pytest.param(p) for p in (case if several else (case,))
        ]
        marks = [mark for part in parts for mark in part.marks]
        if place % every:
            marks.append(pytest.mark.acceptance)
        found.append(pytest.param(*(value for part in parts for value in part.values), marks=marks))
    return found
