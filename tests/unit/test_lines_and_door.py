"""`tm.line` takes what the door takes, and as it does: it is no way round it. What a mask hides is missing, and texts and times are no numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support import typed
from support.cycles import cycle
from support.supervised import BACKENDS, shipped
from trackmarshal.runtime.faults import name_of


def hidden(points: Any, of: int) -> Any:
    """The border with one of its points behind a mask."""
    mask = np.zeros((len(points), 2), dtype=bool)
    mask[of] = True
    return np.ma.masked_array(np.array(points, dtype=float), mask=mask)


@BACKENDS
@pytest.mark.parametrize(
    "given",
    [
        lambda points: points,
        tm.line,
        lambda points: tm.line(list(points)),
        lambda points: tm.line(tuple(points)),
    ],
    ids=["to the door", "line", "line of a list", "line of a tuple"],
)
def test_a_point_that_a_mask_hides_is_missing(given: Callable[[Any], Any], backend: str) -> None:
    made = cycle(0, objects=0, obstacles=0)
    track = made.signals["track"]
    track["left"] = given(hidden(track["left"], 1))
    decision = tm.supervisor(shipped(), backend=backend, limits={"budget": 60.0}, clock=lambda: 0.0).step(
        made
    )
    assert not decision.safe
    assert {(name_of(fault), fault.signal, fault.field) for fault in decision.faults} == {
        ("not_finite", "track", "left")
    }


@BACKENDS
def test_a_mask_that_hides_nothing_changes_nothing(backend: str) -> None:
    made = cycle(0, objects=0, obstacles=0)
    track = made.signals["track"]
    track["left"] = tm.line(np.ma.masked_array(np.array(track["left"], dtype=float)))
    assert (
        tm.supervisor(shipped(), backend=backend, limits={"budget": 60.0}, clock=lambda: 0.0).step(made).safe
    )


@pytest.mark.parametrize(
    "given",
    [
        [["0", "0"], ["1", "0"]],
        np.array([["0", "0"], ["1", "0"]]),
        np.array([["0", "0"], ["1", "0"]], dtype=object),
        np.array([[0, 0], [1, 0]], dtype="M8[s]"),
        np.array([[0, 0], [1, 0]], dtype="m8[s]"),
        np.array([[1j, 0], [1, 0]]),
        np.array([[True, False], [True, True]]),
    ],
    ids=["list of texts", "texts", "objects", "times", "durations", "complex", "flags"],
)
def test_what_is_no_number_to_the_door_makes_no_line(given: Any) -> None:
    made = cycle(0, objects=0, obstacles=0)
    made.signals["track"]["left"] = given
    decision = tm.supervisor(shipped(), backend="numpy", limits={"budget": 60.0}, clock=lambda: 0.0).step(
        made
    )
    assert [name_of(fault) for fault in decision.faults] == ["wrong_type"]
    with pytest.raises(ValueError, match="a line is a list of points"):
        tm.line(given)


@BACKENDS
@pytest.mark.parametrize("hides", [False, True])
def test_a_flag_that_a_mask_hides_is_missing(hides: bool, backend: str) -> None:
    """True stands below the mask, and is what nobody said: in a candidate, and in a set."""
    for signal in ("driving", "emergency", "objects"):
        given = typed.cycle(0, 0.0)
        held: Any = given.signals["objects"] if signal == "objects" else getattr(given, signal)
        name = "seen" if signal == "objects" else "ready"
        said = np.ones(len(held[name]), dtype=bool)
        held[name] = np.ma.masked_array(said, mask=[hides, *[False] * (len(said) - 1)])
        decision = tm.supervisor(typed.spec(), backend=backend, limits=typed.LIMITS, clock=lambda: 0.0).step(
            typed.complete(given)
        )
        assert decision.safe == (not hides)
        assert [(name_of(one), one.signal, one.field) for one in decision.faults] == (
            [("not_finite", signal, name)] * hides
        )
