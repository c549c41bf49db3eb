"""Rows that differ from an earlier one in numbers alone are written as if there had been none."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.cycles import PERIOD, cycle
from support.length import at_length
from support.supervised import ROOT, Clock, made, shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.evaluation import load
from trackmarshal.runtime.door.lines import line
from trackmarshal.runtime.record import Record, stencil
from trackmarshal.runtime.record.reading import Run, read
from trackmarshal.runtime.record.stencil import letters
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.supervision import supervisor


def given(number: int) -> Any:
    """Cycles of which many in a row, but not all, have as much in them and are called alike; some are refused."""
    whole = cycle(number, 1 + number // 20 % 2, 1, v=20.0 + number % 5 * 0.01)
    signals = {
        **whole.signals,
        "track": {**SIDES[number // 30 % 2], "closed": number // 8 % 6 == 5},
    }
    if number // 9 % 3 == 1:
        signals["objects"] = {
            **signals["objects"],
            "id": [f"ä{number // 8}{name}" for name in signals["objects"]["id"]],
        }
    planned = {name: column[: 30 - number // 25 % 2] for name, column in whole.driving.items()}
    driving = {**planned, "a": planned["a"] - (30.0 if number % 23 in (18, 19) else 0.0)}
    return replace(
        whole, driving=driving, signals=signals, t=math.nan if number % 31 in (28, 29) else whole.t
    )


SIDES = [
    {side: line(points + shift) for side, points in cycle(0).signals["track"].items()} for shift in (0.0, 0.5)
]


def run(path: Path, backend: str) -> Run:
    driven: Supervisor | CSupervisor
    if backend == "oracle":  # all is well
        driven, oracle, clock = made()
        driven.recorder = Record(path, driven.door.contract, driven.limits, oracle.identity)
    else:
        clock = Clock()
        driven = supervisor(shipped(), backend=backend, clock=clock, record=path)
    for number in range(120):
        clock.now = number * PERIOD
        driven.step(None if number % 37 == 30 else given(number))
        assert driven.record_error == ""
    driven.close()
    return read(path.read_bytes(), "x")


@pytest.mark.parametrize("backend", ["c", at_length("numpy"), "oracle"])
def test_a_row_like_another_is_the_row_written_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, backend: str
) -> None:
    if backend == "c" and compiler() is None:
        pytest.skip("no C compiler")
    filled, count = stencil._Stencil.filled, [0]

    def counted(*args: Any) -> Any:
        count[0] += 1
        return filled(*args)

    with monkeypatch.context() as patch:
        patch.setattr(stencil._Stencil, "filled", counted)
        found = run(tmp_path / "like.arrows", backend)
    monkeypatch.setattr(stencil.Stencils, "row", lambda *given: given[-1]())
    run(tmp_path / "whole.arrows", backend)
    assert 40 <= count[0] <= 80, count
    assert (tmp_path / "like.arrows").read_bytes() == (tmp_path / "whole.arrows").read_bytes()
    assert {one.value("state") for one in found.cycles} >= {"drive", "previous_emergency"}
    for number, one in enumerate(found.cycles):
        wanted: Any = given(number)
        if one.cycle is None or not math.isfinite(wanted.t):
            continue
        assert one.cycle.signals["objects"]["id"] == wanted.signals["objects"]["id"]
        for name, column in wanted.driving.items():
            assert np.array_equal(one.cycle.driving[name], column), (number, name)
        for signal in ("objects", "obstacles"):
            for name in ("x", "y"):
                assert np.array_equal(one.cycle.signals[signal][name], wanted.signals[signal][name])
        assert one.cycle.signals["ego"]["v"] == wanted.signals["ego"]["v"]
        left = one.cycle.signals["track"]["left"]  # a line where the cycle was refused
        assert np.array_equal(getattr(left, "points", left), wanted.signals["track"]["left"].points)


def test_events_are_those_of_the_cycle(tmp_path: Path) -> None:
    rule = 'module wet\n\nevent wet "the road is wet"\n\nrule damp "it is wet or not"\n  require wet or not wet\n'
    (tmp_path / "wet.spec").write_text(rule, encoding="utf-8")
    clock, path = Clock(), tmp_path / "run.arrows"
    spec = load([ROOT / "specs" / "supervisor", tmp_path / "wet.spec"])
    driven = supervisor(spec, clock=clock, record=path)
    wet = [number // 4 % 2 == 1 for number in range(24)]
    for number, one in enumerate(wet):
        clock.now = number * PERIOD
        whole = cycle(number)
        assert driven.step(replace(whole, signals={**whole.signals, "wet": one})).safe
    driven.close()
    assert [one.cycle.signals["wet"] for one in read(path.read_bytes(), "x").cycles] == wet


def test_what_is_no_verdict_has_no_letter() -> None:
    assert letters(bytes(range(5))) == "svuio"
    with pytest.raises(ValueError, match="0xff"):
        letters(b"\x00\x05")


def test_a_row_that_was_broken_off_is_cut_off_before_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where it was no error of the disk that broke it off."""
    path = tmp_path / "run.arrows"
    supervisor, oracle, clock = made()
    supervisor.recorder = Record(path, supervisor.door.contract, supervisor.limits, oracle.identity)
    write = os.write

    def half(file: int, data: Any) -> int:
        write(file, bytes(data)[: len(data) // 2])
        raise KeyboardInterrupt

    for number in range(8):
        clock.now = number * PERIOD
        with monkeypatch.context() as patch:
            if number == 5:
                patch.setattr(os, "write", half)
                with pytest.raises(KeyboardInterrupt):
                    supervisor.step(cycle(number))
                continue
            supervisor.step(cycle(number))
    supervisor.close()
    found = read(path.read_bytes(), "x")
    assert (found.ended, found.rest, found.missed, found.damage) == (True, 0, 1, "")
    assert [one.cycle.number for one in found.cycles] == [0, 1, 2, 3, 4, 6, 7]
