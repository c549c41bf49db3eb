"""Between which samples of a trajectory a time lies, whatever numbers they are made of: the layer that executes never raises."""

from __future__ import annotations

import math
import shutil
import struct
from dataclasses import asdict
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from support.process_tape import compiled, played
from trackmarshal.backends.c.process.emit import Emitted
from trackmarshal.backends.c.source import generate
from trackmarshal.evaluation import loads
from trackmarshal.process.executing import DECIDED, DRIVE, Executing, Setpoint
from trackmarshal.process.messages import Layout
from trackmarshal.runtime.cycle import Limits


class Said:
    """A message's columns."""

    def __init__(self, **columns: list[float]) -> None:
        self._columns = columns

    def column(self, group: str, name: str) -> list[float]:
        return self._columns[name]

    def due(self, group: str) -> list[float]:
        return self._columns["due"]


def sampled(now: float, due: list[float], x: list[float], heading: list[float]) -> Setpoint:
    layout: Any = SimpleNamespace(silence=1.0, plan=("x", "heading"), plan_members=frozenset())
    said: Any = Said(due=due, x=x, heading=heading)
    return Executing(layout)._sampled(said, "driving", now, DRIVE, DECIDED, 0)


#: A car's clock after eleven days, and a step that it cannot tell from none.
STAMP, NONE = 1e6, 1e-11


@pytest.mark.parametrize(
    ("now", "times", "expected"),
    [
        (STAMP - 0.01, [0.0, NONE, 1.0], 0.0),  # before the first sample, of which two are due at once
        (STAMP, [0.0, NONE, 1.0], 0.0),
        (STAMP + 1.0, [0.0, 1.0, 1.0 + NONE], 1.0),  # at the end, likewise
        (STAMP + 0.5, [0.0, 1.0, 1.0 + NONE], 0.5),
    ],
)
def test_two_samples_that_are_due_at_once(now: float, times: list[float], expected: float) -> None:
    due = [STAMP + t for t in times]
    assert len(set(due)) == 2
    found = sampled(now, due, times, [0.0, 0.0, 0.0])
    assert found.sample is not None
    assert found.sample["x"] == pytest.approx(expected, abs=1e-9)


def test_headings_that_cannot_be_subtracted() -> None:
    found = sampled(0.5, [0.0, 1.0], [0.0, 1.0], [1.7e308, -1.7e308])
    assert found.sample is not None
    assert (found.sample["x"], math.isnan(found.sample["heading"])) == (0.5, True)


@pytest.mark.parametrize(
    ("before", "after"), [(3.1, -3.1), (-3.1, 3.1), (3.1, 2.0 * math.pi - 3.1 + 4.0 * math.pi)]
)
def test_headings_go_the_shorter_way_round(before: float, after: float) -> None:
    """Halfway between two on both sides of pi, a car points there, and not the other way."""
    found = sampled(0.5, [0.0, 1.0], [0.0, 1.0], [before, after])
    assert found.sample is not None
    assert math.cos(found.sample["heading"]) == pytest.approx(-1.0)


#: A plan with a member, what a drone is about, and with columns that are called as what messages have of their own.
LANDS = """
module lands
enum intent { climb, hover, land }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, intent: intent, due: s, count: 1 }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
rule fast for all p in plan require p.v <= 60 m/s
"""
#: When its samples are due, and what it is about in each: no climbing on the way from `land` to `hover`.
DUE, INTENTS = (0.0, 1.0, 2.0, 3.0), (0.0, 2.0, 1.0, 2.0)
#: At a time: what it is about, and where it is.
ABOUT = {-0.5: (0.0, 0.0), 0.0: (0.0, 0.0), 0.5: (0.0, 5.0), 1.0: (2.0, 10.0), 1.5: (2.0, 15.0), 1.999: (2.0, 19.99), 2.0: (1.0, 20.0), 2.9: (1.0, 29.0), 3.0: (2.0, 30.0)}  # fmt: skip


def as_double(bits: str) -> float:
    (value,) = struct.unpack("<d", struct.pack("<Q", int(bits, 16)))
    return float(value)


def decision(layout: Layout) -> bytes:
    """To drive these samples, and to fall back to the same."""
    kind = layout.kinds["decision"]
    message = bytearray(kind.length)
    said = {"about_session": 1, "about_sequence": 1, "simulated": 1, "safe": 1, "driven": 1, "stored": 1, "serial": 1, "stored_session": 1}  # fmt: skip
    for name, value in said.items():
        if name in kind.entries:
            kind.put(message, name, value)
    kind.put(message, "now", -1.0)
    kind.put(message, "valid_until", 10.0)
    for group in ("driving", "fallback"):
        kind.put(message, f"{group}/count", len(DUE))
        kind.put(message, f"{group}/due", list(DUE))
        kind.put(message, f"{group}.x", [10.0 * t for t in DUE])
        kind.put(message, f"{group}.intent", list(INTENTS))
        kind.put(message, f"{group}.due", [5.0] * len(DUE))
        kind.put(message, f"{group}.count", [7.0] * len(DUE))
    layout.seal(message, kind, 1, 1, -1.0)
    return bytes(message)


def described() -> Layout:
    spec = loads(LANDS)
    return Layout(Emitted(generate(spec, spec.rules, doored=True), asdict(Limits())).description)


def test_no_member_is_between_two() -> None:
    layout = described()
    executing = Executing(layout, silence=100.0, simulated=True)
    assert executing.hear(decision(layout)) == "none"
    for now, (intent, x) in ABOUT.items():
        found = executing.at(now).sample
        assert found is not None
        assert found["intent"] == intent
        assert found["x"] == pytest.approx(x)
        assert (found["due"], found["count"]) == (5.0, 7.0)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_no_member_is_between_two_in_c(tmp_path: Path) -> None:
    layout = described()
    lines = played(compiled(tmp_path, ["-O0"], False, loads(LANDS)), [decision(layout), *ABOUT])
    assert lines[0].split()[3] == "none", lines
    for line, (intent, x) in zip(lines[1:-1], ABOUT.values(), strict=True):
        sample = dict(zip(layout.plan, map(as_double, line.split()[6:]), strict=True))
        assert sample["intent"] == intent, line
        assert sample["x"] == pytest.approx(x), line
        assert (sample["due"], sample["count"]) == (5.0, 7.0), line
