"""Cycles whose parts are replaced by arbitrary objects: every backend says the same, none raises, and none is safe with a breach in it.

What is a breach, `support.plain_contract` decides, which has none of the door's code; and where it finds none, no door may find one.
"""

from __future__ import annotations

import math
import os
import random
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from support import typed
from support.length import shared_out
from support.plain_contract import Plain
from trackmarshal.backends.c.build import compiler
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of
from trackmarshal.supervision import supervisor

pytestmark = pytest.mark.verifies("S-1-B-1")

#: Cycles that `make test` hands in; `make acceptance` sets more, of which so many are enough here.
CYCLES = min(int(os.environ.get("TRACKMARSHAL_FUZZ_CYCLES", "500")), 100_000)
#: The reference sees the first of them.
REFERENCE = max(1000, CYCLES // 20)
LIMITS = replace(typed.LIMITS, clock_tolerance=0.5)


class Raising:
    """Fails at whatever it is asked."""

    def __getattr__(self, name: str) -> Any:
        raise ZeroDivisionError(name)

    __len__ = __iter__ = __getitem__ = __bool__ = __float__ = __index__ = __eq__ = __repr__ = __array__ = (  # type: ignore[assignment]
        lambda *_: 1 // 0
    )

    def __hash__(self) -> int:
        return 7


class RaisingList(list[Any]):
    def __len__(self) -> int:
        raise ZeroDivisionError

    __iter__ = __getitem__ = __eq__ = __bool__ = __len__  # type: ignore[assignment]
    __hash__ = None


class RaisingDict(dict[Any, Any]):
    def __getitem__(self, key: Any) -> Any:
        raise ZeroDivisionError

    __iter__ = keys = get = items = __len__ = __contains__ = __getitem__  # type: ignore[assignment]


class Claims:
    """Says that it is of a class of which it is not."""

    def __init__(self, kind: type) -> None:
        self._kind = kind

    @property  # type: ignore[misc]
    def __class__(self) -> Any:
        return self._kind

    def __len__(self) -> int:
        return 2

    def __iter__(self) -> Any:
        return iter((1.0, 2.0))


class Everything:
    """Is equal to everything."""

    def __eq__(self, other: object) -> bool:
        return True

    def __hash__(self) -> int:
        return hash("v")


def endless() -> Any:
    made: list[Any] = []
    made.append(made)
    return made


#: Beyond the table.
ODD: tuple[Callable[[random.Random], Any], ...] = (
    lambda _: Raising(), lambda _: RaisingList([1.0, 2.0, 3.0]), lambda _: RaisingDict({"x": 1.0}), lambda _: endless(),
    lambda rng: Claims(rng.choice((list, dict, float, int, str, np.ndarray, bool))), lambda _: Everything(), lambda _: {Everything(): 1.0},
    lambda rng: {rng.choice((1, None, (1,), 1.0, "v", b"v", "zz")): 1.0}, lambda rng: [rng.choice((1.0, None, "a", True, [1.0]))] * rng.randrange(5),
    lambda rng: rng.choice((0.0, -0.0, 1.0, -1.0, 1e-9, 1e308, -1e308, 180.5, 150.5, 1e-3)), lambda rng: rng.choice((0, 1, -1, 2**53 + 1, 2**63, -(2**63), 2**70)),
    lambda rng: rng.choice(("", "a", "nan", "1.0", "x" * 1000, "\ud800")), lambda rng: rng.choice((True, False, np.True_)),
    lambda rng: np.array([[1.0, 2.0]] * rng.randrange(4)), lambda rng: np.array(rng.choice((1.0, 1, True, "a", None))),
    lambda rng: np.zeros(rng.randrange(10)), lambda rng: [0.0] * 100, lambda rng: np.arange(3.0)[::-1], lambda rng: np.zeros((0, 2)),
    lambda rng: np.array([math.nan, 1.0, math.inf]), lambda rng: [[1.0, 2.0], [3.0]], lambda rng: [], lambda rng: {}, lambda rng: (),
    lambda rng: np.ma.masked_all(3), lambda rng: np.ma.array([1.0, 2.0, 3.0], mask=False), lambda rng: [np.ma.masked, 1.0, 2.0],  # type: ignore[no-untyped-call]
    lambda rng: (1.0, 2.0), lambda rng: [(1, 2), np.array([3, 4])], lambda rng: np.array([[1, 2], [3, 4]], dtype=object),
    lambda rng: [np.float32(1.5), np.int8(2), 3], lambda rng: np.array([True, True, False]), lambda rng: [True, np.False_, np.array(True)],
    lambda rng: [{"x": 1.0, "w": 2.0, "seen": True}] * rng.randrange(6), lambda rng: {"x": [1.0], "w": [2], "seen": (True,)},
)  # fmt: skip
NUMBERS = (
    0.0, -0.0, 0.005, 0.02, -0.3, 1.0, 2.5, 7.0, -9.0, 50.0, 100.5, 149.0, 150.0, 151.0, 179.0, 180.0, 181.0, 500.0, 501.0, 6.283185307179586,
    math.nan, math.inf, -math.inf, 1e-9, 1e300, 10**400, None, 3, True,
)  # fmt: skip
KINDS = [example for examples in typed.EXAMPLES.values() for example in examples]


def holders(given: Cycle) -> list[tuple[Any, Any]]:
    """Every dict and list in a cycle, with a key or index of it."""
    found: list[tuple[Any, Any]] = []
    waiting: list[Any] = [given.driving, given.emergency, given.signals]
    while waiting:
        held = waiting.pop()
        keys = list(held) if isinstance(held, dict) else range(len(held))
        for key in keys:
            found.append((held, key))
            if type(held[key]) in (dict, list) and held[key] is not held:
                waiting.append(held[key])
    return found


def stretch(given: Any, count: int) -> None:
    """So many entries in all columns, or records, that go on as they were."""
    columns = given.values() if type(given) is dict else [given]
    for column in columns:
        if type(column) is list and len(column) > 1:
            while len(column) < count:
                last, before = column[-1], column[-2]
                column.append(last + (last - before) if type(last) is type(before) is float else last)
            del column[count:]


def spoilt(rng: random.Random, given: Cycle, variant: str) -> Any:
    """The cycle with some of its parts replaced, left out, or others added."""
    if rng.random() < (0.3 if variant == "lists" else 0.1):
        given = typed.records(given)
    for _ in range(rng.choice((0, 1, 1, 1, 1, 2, 3))):
        act = rng.random()
        if act < 0.55:
            place = rng.choice(typed.places(variant))
            suited = [example for example in KINDS if place.holds in example.holds] if act < 0.4 else KINDS
            try:
                if typed.based(given, place) is not given:
                    continue
                given = typed.replaced(given, place, rng.choice(suited).of(given, place))
            except (
                Exception
            ):  # the place went with what was replaced before, or its content does not suit the example
                continue
        elif act < 0.67:
            held, key = rng.choice(
                [one for one in holders(given) if type(one[0][one[1]]) is float] or holders(given)
            )
            held[key] = rng.choice(NUMBERS)
        elif act < 0.77:
            held, key = rng.choice(holders(given))
            held[key] = rng.choice(ODD)(rng)
        elif act < 0.83:
            held, key = rng.choice(holders(given))
            del held[key]
        elif act < 0.89:
            held, key = rng.choice(holders(given))
            if isinstance(held, dict):
                held[rng.choice(("zz", "X", 7, "age", "id", "grip", "closed"))] = rng.choice(
                    (held[key], *(odd(rng) for odd in ODD[:2]))
                )
            else:
                held.append(held[key])
        elif act < 0.94:
            stretch(
                rng.choice((given.driving, given.emergency, given.signals.get("objects"))),
                rng.choice((0, 1, 1, 2, 4, 5, 9)),
            )
        elif act < 0.99:
            given = replace(
                given,
                **{rng.choice(("number", "t", "driving", "emergency", "signals")): rng.choice(ODD)(rng)},
            )
        else:
            return rng.choice(ODD)(rng)
        if not all(type(part) is dict for part in (given.driving, given.emergency, given.signals)):
            break
    return given


def said(decision: Decision) -> tuple[Any, ...]:
    """Everything of a decision that cannot depend on who makes it."""
    driven = decision.driven
    return (
        decision.state, decision.safe, decision.lost, decision.number, repr(decision.t), decision.more,
        [(name_of(f), f.signal, f.field, f.index, f.message) for f in decision.faults],
        [(v.rule, v.candidate, v.verdict) for v in decision.violations],
        None if driven is None else (driven.candidate, driven.number, driven.matrix.tobytes()),
    )  # fmt: skip


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("variant", shared_out(typed.VARIANTS, 2))
def test_arbitrary_objects_in_cycles(variant: str) -> None:
    now = 0.0
    backends = ["numpy", "reference", *(["c"] if compiler() is not None else [])]
    made = {
        name: supervisor(typed.spec(variant), backend=name, limits=LIMITS, clock=lambda: now)
        for name in backends
    }
    rng = random.Random(20261122)
    plain = Plain(flags=variant == "lists", ahead=LIMITS.clock_tolerance)
    seen: Counter[str] = Counter()
    for run in range(CYCLES):
        now = float(run)
        following = 0 if plain.number is None or plain.number > 2**60 else plain.number + 1
        with warnings.catch_warnings(action="ignore"):
            given = typed.cycle(following, now, variant)
            given = spoilt(rng, typed.complete(given) if rng.random() < 0.5 else given, variant)
            if variant == "arrays" and isinstance(given, Cycle) and rng.random() < 0.9:
                given = typed.arrayed(given)
        decisions = {}
        for name, one in made.items():
            if name != "reference" or run < REFERENCE:
                decisions[name] = one.step(given)
        decision = decisions["numpy"]
        expected = said(decision)
        for name, other in decisions.items():
            assert said(other) == expected, (run, name, shown(given))
        kept = plain.kept(given, now)
        assert kept == (not decision.faults), (run, decision.reasons, shown(given))
        assert kept or not decision.safe
        assert decision.safe == (kept and not decision.violations)
        assert not any(name_of(f) in ("internal", "incomplete", "judge_failed") for f in decision.faults), (
            decision.reasons
        )
        seen["kept" if kept else "broken"] += 1
        seen["safe" if decision.safe else "unsafe"] += 1
        seen.update({name_of(fault) for fault in decision.faults})
    assert all(one.record_error == "" for one in made.values())
    assert seen["kept"] > CYCLES / 5, seen
    assert seen["broken"] > CYCLES / 5, seen
    assert seen["safe"] > CYCLES / 10, seen
    for name in (
        "wrong_type", "missing", "wrong_length", "too_short", "not_increasing", "not_finite", "out_of_range", "bad_border", "over_capacity",
        "unknown", "starts_elsewhere", "not_at_rest", "duplicate", "out_of_order",
    ):  # fmt: skip
        assert seen[name], (name, seen)


def shown(given: Any) -> str:
    try:
        return repr(given)[:1500]
    except Exception:
        return f"a {type(given).__name__} that has no words"
