"""A list of elements that are alike is read at once, to the same columns and faults as by a closer look."""

from __future__ import annotations

from random import Random
from typing import Any

from trackmarshal.evaluation import loads
from trackmarshal.runtime.contract import of_cases
from trackmarshal.runtime.door.columns import ColumnsReader
from trackmarshal.runtime.faults import Fault

SPEC = """module t
signal objects : set of object { x: m, y: m, v: m/s }
rule near "Near"
  for all o in objects
  require abs(o.x) + abs(o.y) <= 100 m and o.v <= 10 m/s
"""
NAMES = ("x", "y", "v")


def readers() -> tuple[ColumnsReader, ColumnsReader]:
    """One that reads at once where it can, and one that always looks closely."""
    spec = loads(SPEC)
    (signal,) = of_cases(spec, [("objects", name) for name in NAMES]).signals
    both = ColumnsReader(signal), ColumnsReader(signal)
    assert both[0].plain
    both[1].plain = False
    return both


def some(random: Random) -> Any:
    """Elements, most of them as they should be."""
    names = [name for name in NAMES if random.random() > 0.03]
    names += ["id"] * (random.random() < 0.7) + ["odd"] * (random.random() < 0.03)

    def value(name: str, place: int) -> Any:
        if name == "id":
            return f"o{place}" if random.random() > 0.1 else random.choice(["a", "", 1, None])
        odd = [1, "x", None, True, [1.0]]
        return random.choice([1.0, -0.0, float("nan")]) if random.random() > 0.02 else random.choice(odd)

    given: list[Any] = [
        {name: value(name, place) for name in names} for place in range(random.choice([0, 1, 2, 3]))
    ]
    if given and random.random() < 0.1:
        given[-1] = random.choice([None, [], {}, dict(reversed(given[-1].items()))])
    return given


def test_what_is_read_at_once_is_what_a_closer_look_reads() -> None:
    quick, close = readers()
    random, at_once = Random(7), 0
    for _ in range(600):
        given = some(random)
        faults: tuple[list[Fault], list[Fault]] = [], []
        found, expected = quick.read(given, faults[0]), close.read(given, faults[1])
        assert list(map(str, faults[0])) == list(map(str, faults[1]))
        assert found.values.tobytes() == expected.values.tobytes(), given
        assert (found.ids, found.count, found.absent) == (expected.ids, expected.count, expected.absent), (
            given
        )
        try:
            at_once += quick._elements(given) is not None
        except Exception:  # then it is looked at closely
            continue
    assert at_once > 300
