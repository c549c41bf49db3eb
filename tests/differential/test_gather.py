"""A cycle of arrays read by C, by numpy at once, and signal by signal: the same columns to the bit, the same faults."""

from __future__ import annotations

import pickle
import random
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from support.cycles import cycle, mutate
from support.supervised import Clock, shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.gather import Gathered
from trackmarshal.runtime.contract import of_cycles
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.door.at_once import AtOnce
from trackmarshal.runtime.door.lines import line
from trackmarshal.runtime.door.reading import CycleReader
from trackmarshal.runtime.faults import name_of
from trackmarshal.supervision import supervisor

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")


BORDER = np.array([[0.0, 6.0], [500.0, 6.0], [900.0, 6.0]])


class Never(AtOnce):
    """Reads nothing at once."""

    def _read(self, *raws: Any) -> None:
        return None


def readers() -> dict[str, CycleReader]:
    contract = of_cycles(shipped(), [rule for rule in shipped().rules if rule.formula is not None])
    return {
        "C": CycleReader(contract, at_once=lambda readers: Gathered(readers, Limits())),
        "numpy": CycleReader(contract),
        "by signal": CycleReader(contract, at_once=Never),
    }


def seen(reader: CycleReader, given: Cycle) -> tuple[Any, ...]:
    frame, faults = reader.read(given)
    columns = {**frame.candidates, **frame.columns}
    return (
        {
            name: (own.count, own.ids, own.values.tobytes() if not faults else b"")
            for name, own in columns.items()
        },
        sorted((f.code, f.signal, f.field, f.index or 0) for f in faults),
        {place: line.points.tobytes() for place, line in frame.lines.items()},
    )


def in_place(given: Cycle, change: Any) -> Cycle:
    return replace(given, driving={name: change(column) for name, column in given.driving.items()})


#: What an array may be like, and still be one of numbers; or like one of numbers, and be none.
KINDS = {
    "as it is": lambda c: c,
    "every other": lambda c: np.repeat(c, 2)[::2],
    "backwards": lambda c: c[::-1].copy()[::-1],
    "of a table": lambda c: np.column_stack([c, c])[:, 1],
    "read-only": lambda c: np.frombuffer(c.tobytes()),
    "from another process": lambda c: pickle.loads(pickle.dumps(c)),
    "big-endian": lambda c: c.astype(">f8"),
    "float32": lambda c: c.astype(np.float32),
    "whole numbers": lambda c: c.astype(np.int64),
    "masked": lambda c: np.ma.array(c, mask=np.zeros(len(c), dtype=bool)),
    "half masked": lambda c: np.ma.array(c, mask=np.arange(len(c)) % 2 == 0),
    "a list": lambda c: c.tolist(),
    "a column": lambda c: c[:, None],
    "one number": lambda c: c[0],
    "no axis": lambda c: np.array(c[0]),
    "complex": lambda c: c.astype(complex),
    "structured": lambda c: c.view([("x", "f8")]),
    "times": lambda c: c.view("M8[s]"),
    "empty": lambda c: c[:0],
    "too long": lambda c: np.resize(c, 65),
}


@pytest.mark.parametrize("kind", KINDS)
def test_kinds_of_arrays(kind: str) -> None:
    made = readers()
    for _ in range(2):  # the second time, ids are known
        found = {name: seen(reader, in_place(cycle(3), KINDS[kind])) for name, reader in made.items()}
        assert found["C"] == found["numpy"] == found["by signal"]


def test_broken_cycles() -> None:
    made, rng = readers(), random.Random(11)
    for number in range(400):
        given = cycle(number, 1 + rng.randrange(3), 1 + rng.randrange(2))
        if number % 2:
            given = mutate(rng, given)[0]
        found = {name: seen(reader, given) for name, reader in made.items()}
        assert found["C"] == found["numpy"] == found["by signal"], number


def test_defaults_and_unknown_names() -> None:
    made = readers()
    whole = cycle(1)
    grip = {**whole.driving, "grip": np.full(len(whole.driving["t"]), 0.5)}
    ages = {**whole.signals["objects"], "age": np.zeros(2)}
    for given in (
        replace(whole, driving=grip),
        replace(whole, signals={**whole.signals, "objects": ages}),
        replace(whole, signals={**whole.signals, "ego": {**whole.signals["ego"], "Age": 9.0}}),
        replace(whole, driving={**grip, "gripp": grip["grip"]}),
        replace(whole, driving={**whole.driving, "grip": None}),
        replace(whole, signals={**whole.signals, "zzz": 1}),
    ):
        found = {name: seen(reader, given) for name, reader in made.items()}
        assert found["C"] == found["numpy"] == found["by signal"]


def fewer(given: Cycle, ids: list[str]) -> Cycle:
    """With these very ids, and one object less than they are."""
    columns = {name: column[:-1] for name, column in given.signals["objects"].items()}
    return replace(given, signals={**given.signals, "objects": {**columns, "id": ids}})


@pytest.mark.parametrize("objects", [1, 2, 5])
def test_known_ids_of_more_elements_than_there_are(objects: int) -> None:
    ids = cycle(0, objects).signals["objects"]["id"]
    wanted = ("wrong_length", "objects", "id", objects - 1)
    for name, reader in readers().items():
        for number in range(2):
            whole = cycle(number, objects)
            whole.signals["objects"]["id"] = ids
            frame, faults = reader.read(whole)
            assert not faults
            assert (frame.arena is None) == (name == "by signal" or number == 0), name
        faults = reader.read(fewer(cycle(2, objects), ids))[1]
        assert [(name_of(one), one.signal, one.field, one.index) for one in faults] == [wanted], name
    for backend in ("c", "numpy", "reference"):
        clock = Clock()
        made = supervisor(shipped(), backend=backend, clock=clock)
        for number in range(3):
            given = cycle(number, objects)
            given.signals["objects"]["id"] = ids
            clock.now = given.t
            decision = made.step(given if number < 2 else fewer(given, ids))
            assert decision.safe == (number < 2), backend
        faults = list(decision.faults)
        assert [(name_of(one), one.signal, one.field, one.index) for one in faults] == [wanted], backend


def test_borders_are_those_of_the_cycle() -> None:
    """Also after a cycle with the very objects of the one before, which nobody looks at again."""
    made, whole = readers(), cycle(1)
    one, other = (
        {side: line(points + shift) for side, points in (("left", BORDER), ("right", -BORDER))}
        for shift in (0.0, 1.0)
    )
    for track in (
        one,
        one,
        {**one, "closed": True},
        {**one, "closed": True},
        {**one, "left": other["left"]},
        other,
        {"left": one["left"]},
    ):
        given = replace(whole, signals={**whole.signals, "track": track})
        found = {name: (seen(reader, given), reader.read(given)[0].closed) for name, reader in made.items()}
        assert found["C"] == found["numpy"] == found["by signal"]


def test_what_is_looked_up_may_change_meanwhile() -> None:
    """A key that is asked whether it is the last of the fields puts other columns into the dict that it is in, and has another cycle read."""

    class Hostile:
        def __hash__(self) -> int:
            return hash(last)

        def __eq__(self, _: object) -> bool:
            if not armed:  # it is still being put in
                return False
            armed.clear()
            held.clear()
            held.update({name: np.full(len(column), 7.0) for name, column in whole.driving.items()})
            reader.read(cycle(2))
            return False

    reader, whole, held, armed = readers()["C"], cycle(1), dict[Any, Any](), list[bool]()
    first, *_, last = (name for name in reader.candidates[0][1].names.numbers if name in whole.driving)
    reader.read(whole)
    held[Hostile()] = 1.0
    held.update({name: column.copy() for name, column in whole.driving.items()})
    armed.append(True)
    frame, faults = reader.read(replace(whole, driving=held))
    assert not faults
    assert frame.candidates["driving"].column(first).tolist() == whole.driving[first].tolist()
    assert set(frame.candidates["driving"].column(last).tolist()) == {7.0}


def test_arrays_of_another_process_take_no_closer_look() -> None:
    reader, given = readers()["C"], in_place(cycle(3), KINDS["from another process"])
    reader.read(given)
    assert reader.read(given)[0].arena is not None


def test_objects_are_let_go() -> None:
    reader, given = readers()["C"], cycle(1)
    refused = replace(given, driving={**given.driving, "gripp": given.driving["x"]})
    held = [*given.driving.values(), given.driving, given.signals["objects"], given.signals["objects"]["x"]]
    for _ in range(2):
        reader.read(given)
        reader.read(refused)
    before = [sys.getrefcount(one) for one in held]
    for _ in range(50):
        reader.read(given)
        reader.read(refused)
    assert [sys.getrefcount(one) for one in held] == before


def test_memory_of_one_cycle_is_not_that_of_the_next() -> None:
    reader = readers()["C"]
    first, _ = reader.read(cycle(0))
    before = {name: own.values.copy() for name, own in first.candidates.items()}
    reader.read(cycle(5))
    assert all(np.array_equal(first.candidates[name].values, values) for name, values in before.items())
