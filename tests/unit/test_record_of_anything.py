"""A record keeps what the door takes, of whatever types it is made: the run again decides the same. What cannot be written counts as missing."""

from __future__ import annotations

import enum
from collections import OrderedDict, UserDict, namedtuple
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from trackmarshal.runtime.record.reading import read
from trackmarshal.supervision import box_of, rerun

#: Units, Booleans and enumerations: none of it is kept as columns.
TEXT = """
module anything
enum flag { green, yellow }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, ready: bool }
signal ego : state { x: m, y: m, heading: rad, v: m/s, flag: flag, limit: km/h }
signal objects : set of object { v: m/s }
signal track : corridor { left: polyline, right: polyline }

rule speed "Speed"
  for all p in plan
  require p.v <= ego.limit and p.ready

rule others "Nobody is fast"
  for all o in objects
  require o.v <= 10 m/s

rule green "By green alone"
  require ego.flag is green

rule off "Off the border"
  require distance_to(ego, track.left) >= 0.5 m
"""


class Flag(enum.IntEnum):
    green = 0


class Real(float):
    pass


class Many(list[Any]):
    pass


class Own(tm.Cycle):
    pass


Point = namedtuple("Point", "x y")
EGO = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 1.0, "flag": "green", "limit": 90.0}
TRACK = {"left": [[0.0, 3.0], [9.0, 3.0]], "right": [[0.0, -3.0], [9.0, -3.0]]}


def plan(**others: Any) -> dict[str, Any]:
    return {
        "t": [0.0, 1.0], "x": [0.0, 1.0], "y": [0.0, 0.0], "heading": [0.0, 0.0], "v": [1.0, 0.0], "ready": [True, True], **others,
    }  # fmt: skip


def cycle(number: int, driving: Any = None, kind: Any = tm.Cycle, **signals: Any) -> tm.Cycle:
    given = {"ego": EGO, "objects": [], "track": TRACK, **signals}
    made: tm.Cycle = kind(number, 0.1 * number, driving or plan(), plan(), given)
    return made


TAKEN: list[dict[str, Any]] = [
    {"driving": OrderedDict(plan())},
    {"driving": UserDict(plan())},
    {"ego": MappingProxyType(EGO)},
    {"ego": {**EGO, "limit": Real(90.0)}},
    {"ego": {**EGO, "flag": Flag.green}},
    {"ego": {**EGO, "limit": np.longdouble(90.0)}},
    {"driving": plan(v=Many([1.0, 0.0]))},
    {"driving": plan(v=np.ma.array([1.0, 0.0]))},
    {"driving": plan(v=np.array([1.0, 0.0], dtype=object))},
    {"driving": plan(ready=np.ma.array([True, True]))},
    {"track": {**TRACK, "left": [Point(0.0, 3.0), Point(9.0, 3.0)]}},
    {"objects": [OrderedDict(v=2.0)]},
    {"kind": Own},
]
REFUSED: list[dict[str, Any]] = [
    {"driving": plan(v=np.ma.array([1.0, 0.0], mask=[False, True]))},
    {"driving": plan(ready=np.ma.array([True, True], mask=[False, True]))},
    {"objects": {"id": np.ma.array([1]), "v": [1.0]}},
    {"ego": {**EGO, "limit": np.timedelta64(3, "s")}},
    {"ego": {**EGO, "limit": np.datetime64("2026-01-01")}},
    {"ego": {**EGO, "x": np.float32(5e6)}},  # where no two of them are nearer than 0.5 m
    {"track": {**TRACK, "left": [[np.float16(0.0), 3.0], [np.float16(9000.0), 3.0]]}},
]


def recorded(path: Path, cycles: list[tm.Cycle]) -> tuple[list[Any], Any]:
    spec, now = tm.loads(TEXT), [0.0]
    held = {"budget": 1e9}
    supervisor = tm.supervisor(spec, clock=lambda: now[0], limits=held, record=path)
    decisions = []
    for one in cycles:
        now[0] = one.t
        decisions.append(supervisor.step(one))
    supervisor.close()
    return decisions, supervisor


def test_a_run_of_all_that_the_door_takes_again(tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    decisions, supervisor = recorded(path, [cycle(i, **one) for i, one in enumerate(TAKEN)])
    assert [decision.reasons for decision in decisions if not decision.safe] == []
    assert supervisor.record_error == ""
    run = read(path.read_bytes(), "run")
    again = list(rerun(run, box_of(run, tm.loads(TEXT))))
    assert len(again) == len(TAKEN)
    assert [differences for _, differences in again if differences] == []


@pytest.mark.parametrize("number", range(len(REFUSED)))
def test_what_the_door_refuses_is_refused_again(number: int, tmp_path: Path) -> None:
    path = tmp_path / "run.arrows"
    decisions, supervisor = recorded(path, [cycle(0), cycle(1, **REFUSED[number]), cycle(2)])
    assert [decision.safe for decision in decisions] == [True, False, True]
    assert supervisor.record_error == ""
    run = read(path.read_bytes(), "run")
    assert run.missed == 0
    again = list(rerun(run, box_of(run, tm.loads(TEXT))))
    assert [decision.safe for decision, _ in again] == [True, False, True]
    assert [differences for _, differences in again if differences] == []  # for the same reason


def test_a_cycle_that_cannot_be_written_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever it is that fails, and not the disk alone."""
    from trackmarshal.runtime.record import raw, writing

    path, plain = tmp_path / "run.arrows", raw.plain

    def failing(value: Any, depth: int = 0) -> Any:
        if getattr(value, "number", None) == 1:
            raise TypeError("no word for it")
        return plain(value, depth)

    monkeypatch.setattr(writing, "plain", failing)
    decisions, supervisor = recorded(path, [cycle(0), cycle(1), cycle(2)])
    assert all(decision.safe for decision in decisions)
    assert supervisor.record_error != ""
    run = read(path.read_bytes(), "run")
    assert (len(run.cycles), run.missed) == (2, 1)
