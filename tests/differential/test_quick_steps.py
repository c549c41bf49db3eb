"""Steps that one call of C takes, and the same steps by way of Python: the same decisions, records and states, whatever comes."""

from __future__ import annotations

import copy
import gc
import math
import random
import re
import sys
import weakref
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.cycles import PERIOD, cycle, mutate
from support.length import shared_out
from support.pairs import agree, bits
from support.supervised import Clock, shipped
from trackmarshal.backends.c import calling
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.calling import objects, quick
from trackmarshal.backends.c.calling.objects import OtherObjectsError
from trackmarshal.backends.c.calling.quick import Quick, Slowly
from trackmarshal.backends.c.supervised.binding import HEAD, SAID
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.door.lines import line
from trackmarshal.supervision import supervisor

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

TRACK = {
    side: line([[float(x), y] for x in range(-50, 2000, 10)]) for side, y in (("left", 6.0), ("right", -6.0))
}


class Stop:
    """A reading of the clock that is no number, and stops whoever asks for it."""

    def __float__(self) -> float:
        raise KeyboardInterrupt


class Counted:
    """A Supervisor of which it is known how many steps one call took."""

    def __init__(self, record: Path | None = None, **given: Any) -> None:
        self.clock = Clock()
        made = supervisor(shipped(), backend="c", clock=self.clock, record=record, snapshots=0, **given)
        assert isinstance(made, CSupervisor)
        self.made, self.at_length, self.steps = made, 0, 0
        own = made._at_length

        def counted(given: Any) -> Decision:
            self.at_length += 1
            return own(given)

        made._at_length = counted  # type: ignore[method-assign, assignment]

    def step(self, given: Any, *ticks: Any) -> Decision:
        self.clock.ticks = list(ticks)
        self.clock.now = given.t if isinstance(given, Cycle) and type(given.t) is float else self.clock.now
        self.steps += 1
        return self.made.step(given)

    @property
    def quick(self) -> int:
        return self.steps - self.at_length


def slowly(record: Path | None = None, **given: Any) -> Counted:
    made = Counted(record, **given)
    made.made._quick = Slowly()
    made.made.recorder = made.made.recorder
    return made


def framed(number: int, objects: int = 2, **given: Any) -> Cycle:
    """A cycle whose borders nobody can change."""
    made = cycle(number, objects, **given)
    return replace(made, signals={**made.signals, "track": TRACK})


def same(mine: Decision, other: Decision) -> None:
    agree(mine, other)
    if mine.judged is not None and other.judged is not None:
        assert mine.judged.rated.verdicts == other.judged.rated.verdicts  # type: ignore[attr-defined]
        assert mine.judged.rated.margins == other.judged.rated.margins  # type: ignore[attr-defined]
    assert mine.feedback == other.feedback
    assert type(mine) is type(other) is Decision


def test_steps_that_are_safe_take_one_call() -> None:
    one, other = Counted(), slowly()
    decisions = [(one.step(framed(number)), other.step(framed(number))) for number in range(20)]
    for mine, its in decisions:  # also when later steps have been taken
        same(mine, its)
        assert mine.safe
        assert mine.driven is not None
        assert np.array_equal(mine.driven.matrix, its.driven.matrix)  # type: ignore[union-attr]
        assert copy.deepcopy(mine) is mine
        assert copy.deepcopy(mine.driven).due == its.driven.due  # type: ignore[union-attr]
    assert (one.quick, other.quick) == (17, 0)  # three to see that they are alike


@pytest.mark.parametrize("seed", shared_out(range(4), 2))
def test_whatever_comes(seed: int, tmp_path: Path) -> None:
    rng = random.Random(seed)
    one, other = Counted(tmp_path / "one.arrows"), slowly(tmp_path / "other.arrows")
    number = 0
    for _ in range(150):
        number += 1
        given: Any = framed(number, 1 + (rng.random() < 0.1))
        kind = rng.random()
        late = rng.choice(
            [
                [],
                [],
                [],
                [given.t, given.t + 1.0],
                [math.nan],
                [given.t, math.inf],
                [ValueError()],
                [given.t, ValueError()],
                ["x"],
            ]
        )
        if kind < 0.1:
            plain = cycle(number)
            given = mutate(rng, plain)[0]
            if type(given.signals) is dict and given.signals.get("track") is plain.signals["track"]:
                given = replace(given, signals={**given.signals, "track": TRACK})
        elif kind < 0.15:
            given = rng.choice(
                [
                    None,
                    7,
                    "cycle",
                    replace(given, number=2**70),
                    replace(given, t=7),
                    replace(given, number=True),
                ]
            )
        elif kind < 0.25:
            driving = {**given.driving, "v": given.driving["v"] * rng.choice([1.0, 1.0 + 1e-12, 8.0])}
            given = replace(given, driving=driving)
        elif kind < 0.3:
            track = rng.choice(
                [{**TRACK, "closed": True}, {**TRACK}, {"left": TRACK["left"]}, cycle(0).signals["track"]]
            )
            given = replace(given, signals={**given.signals, "track": track})
        elif kind < 0.33:
            number += rng.randrange(3)
        ticks = late if rng.random() < 0.1 else []
        same(one.step(given, *ticks), other.step(given, *ticks))
        assert one.made.stepper.save() == other.made.stepper.save()  # type: ignore[attr-defined]
        assert one.made._quick.steps == other.made._quick.steps
        assert bits(one.made._quick.last) == bits(other.made._quick.last)
    for made in (one, other):
        made.made.close()
        assert made.made.record_error == ""
    assert (tmp_path / "one.arrows").read_bytes() == (tmp_path / "other.arrows").read_bytes()
    assert one.made._quick.recorded


def test_an_error_of_the_clock_that_is_no_exception_goes_on() -> None:
    steps = []
    for made in (Counted(), slowly()):
        for number in range(5):
            made.step(framed(number))
        for before in ([], [0.5]):  # at the arrival, and when the rules are done
            with pytest.raises(KeyboardInterrupt):
                made.step(framed(5), *before, Stop())
            assert made.made._quick.left() == (None, None, None, None)
        assert [made.step(framed(number)).safe for number in (6, 7, 8)] == [True] * 3
        steps.append(made.made._quick.steps)
    assert steps[0] == steps[1] == 9


def test_goes_on_from_what_was_saved() -> None:
    one, other = Counted(), Counted()
    for number in range(6):
        one.step(framed(number))
    other.made.restore(one.made.save())
    assert other.made._quick.steps == 6
    for number in range(6, 10):
        same(one.step(framed(number)), other.step(framed(number)))
    for number in range(10, 13):
        other.step(framed(number))
    other.made.restore(one.made.save())  # one that has cycles like those before forgets that it has
    for number in range(10, 15):
        same(one.step(framed(number)), other.step(framed(number)))


def test_what_is_read_may_change_meanwhile() -> None:
    """A key that is asked whether it is a field has the same Supervisor decide another cycle, and takes the cycle's attributes away."""

    class Hostile:
        def __hash__(self) -> int:
            return hash("v")

        def __eq__(self, _: object) -> bool:
            if armed:
                armed.clear()
                object.__setattr__(given, "signals", None)
                object.__setattr__(given, "driving", None)
                object.__setattr__(given, "number", None)
                nested.append(made.made.step(None))
                nested.append(made.made.step(framed(6)))
            return False

    made, nested, armed = Counted(), list[Decision](), list[bool]()
    for number in range(5):
        made.step(framed(number))
    held: dict[Any, Any] = {Hostile(): 1.0}
    given = framed(5)
    held.update(given.driving)
    given = replace(given, driving=held)
    armed.append(True)
    decision = made.step(given)
    assert not decision.safe
    assert len(nested) == 2
    assert made.step(framed(7)).t == 7 * PERIOD


def test_objects_are_let_go() -> None:
    made = Counted()
    for number in range(4):
        made.step(framed(number))
    given = framed(4)
    held: list[Any] = [
        given,
        *given.driving.values(),
        given.driving,
        given.signals,
        given.signals["objects"],
        given.t,
        TRACK,
    ]
    held += [made.made._explaining, made.made._quick._armed, Decision]  # type: ignore[attr-defined]
    before = [sys.getrefcount(one) for one in held]
    for number in range(4, 60):
        decision = made.step(replace(given, number=number, t=number * PERIOD + 0.0), number * PERIOD)
        assert decision.number == number
        del decision
    assert made.quick == 57
    made.made._quick.stored = None
    assert [sys.getrefcount(one) for one in held] == before


def test_a_supervisor_is_let_go() -> None:
    made = Counted()
    for number in range(4):
        decision = made.step(framed(number))
    gone = weakref.ref(made.made.stepper)
    del made
    gc.collect()
    assert gone() is None
    assert decision.driven is not None
    assert decision.driven.due[0] == 3 * PERIOD
    assert decision.judged is not None
    assert decision.judged.rated["driving"].explain(0, False).verdict


@pytest.mark.parametrize("why", ["slots", "tuples", "numpy"])
def test_objects_that_look_otherwise_are_for_python(why: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def other(*_: Any) -> Any:
        raise OtherObjectsError

    if why == "numpy":
        monkeypatch.setattr("trackmarshal.backends.c.gather.as_known", lambda: False)
    else:
        monkeypatch.setattr(quick, "places" if why == "slots" else "place_of_items", other)
    one = Counted()
    monkeypatch.undo()
    other_one = Counted()
    assert type(one.made._quick) is Slowly
    assert type(other_one.made._quick) is Quick
    for number in range(6):
        same(one.step(framed(number)), other_one.step(framed(number)))
    assert (one.quick, other_one.quick) == (0, 3)


@pytest.mark.parametrize(
    ("file", "struct", "fields"),
    [
        ("quick.c", "said_words", [name for name, _ in SAID]),
        ("call.c", "head", [name for name, _ in HEAD]),
        ("quick.c", "quick", [name.rstrip("_") for name, *_ in quick._Quick._fields_]),
        ("quick.c", "stretch", [name for name, *_ in quick._Stretch._fields_]),
        ("call.h", "calling", [name for name, *_ in calling._Calling._fields_]),
    ],
)
def test_structs_are_those_of_python(file: str, struct: str, fields: list[str]) -> None:
    text = Path(calling.__file__).with_name(file).read_text(encoding="utf-8")
    body = text[: text.index(f"}} {struct};")].rpartition("typedef struct {")[2]
    names = [re.search(r"(\w+)\)?(\(.*\))?;", part) for part in body.splitlines() if ";" in part]
    assert [found.group(1) for found in names if found] == fields


def test_decisions_have_the_fields_that_c_fills() -> None:
    text = Path(calling.__file__).with_name("quick.c").read_text(encoding="utf-8")
    assert f"enum {{ FIELDS = {len(Decision._fields)} }};" in text


def test_objects_are_looked_at() -> None:
    assert objects.as_known()
    assert objects.places(Cycle, "t", "number") != objects.places(Cycle, "number", "t")
    with pytest.raises(AttributeError):
        objects.places(Cycle, "nothing")
