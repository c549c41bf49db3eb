"""Cases at the door: everything that breaks the input contract is named, and nothing of it can come out as safe."""

from __future__ import annotations

import copy
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.length import amount
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.codes import CODES
from trackmarshal.runtime.door.cases import CasesReader
from trackmarshal.runtime.frame import Frame
from trackmarshal.semantics.compile import compile_paths

SPEC = """
module door
signal plan : trajectory {
  t: s increasing, v: km/h in [-10, 300], grip: 1 in [0, 1.5] default 1, slip: % default 5, ready: bool
}
signal trace : series { t: s increasing, x: m }
signal ego : state { x: m, heading: deg in [-180, 180], age: ms in [0, 500] default 100 ms, on: bool }
signal objects : set of object { x: m, v: m/s in [-50, 50], age: s default 0 s }
signal track : corridor { left: polyline, right: polyline }
signal border : polyline
event flag
param mass : kg = 1160 kg in [900, 1400]
param v_max : km/h = 100 km/h in [0, 200]
table ax_max(v: km/h) -> m/s^2 = linear clamp | 0 km/h: 6 m/s^2 | 100 km/h: 3 m/s^2 |
zone pit = polygon (0 m, 0 m) (9 m, 0 m) (9 m, 9 m)
line start = (0 m, 0 m) (0 m, 9 m)
"""
#: Every field of every signal, as rules would read them.
READS = {
    ("plan", ""), ("plan", "v"), ("plan", "grip"), ("plan", "slip"), ("plan", "ready"), ("trace", ""), ("trace", "x"),
    ("ego", "x"), ("ego", "heading"), ("ego", "age"), ("ego", "on"), ("objects", ""), ("objects", "x"), ("objects", "v"),
    ("objects", "age"), ("track", "left"), ("track", "right"), ("border", ""), ("flag", ""),
}  # fmt: skip
GOOD: dict[str, Any] = {
    "id": 1,
    "signals": {
        "plan": {"t": [0.0, 0.1, 0.2], "v": [36.0, 72.0, 108.0], "grip": [1.0, 0.9, 0.8], "slip": [1.0, 2.0, 3.0], "ready": [True, False, True]},
        "trace": {"t": [0.0], "x": [1.0]},
        "ego": {"x": 1.5, "heading": 90.0, "age": 20.0, "on": True},
        "objects": [{"id": "a", "x": 1.0, "v": 2.0, "age": 0.5}, {"x": 3.0, "v": 4.0}],
        "track": {"left": [[0, 1], [9, 1]], "right": [[0, -1], [9, -1]], "closed": False},
        "border": [[0, 0], [1, 1]],
        "flag": False,
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def spec(tmp_path_factory: pytest.TempPathFactory) -> Spec:
    path = tmp_path_factory.mktemp("door") / "door.spec"
    path.write_text(SPEC)
    compiled = compile_paths([path])
    compiled.raise_errors()
    return compiled.spec


@pytest.fixture
def reader(spec: Spec) -> CasesReader:
    return CasesReader(spec, READS)


def changed(*path: str | int, to: Any = "nothing") -> dict[str, Any]:
    """The good case with one value replaced, or left out."""
    case = copy.deepcopy(GOOD)
    place = case["signals"]
    for step in path[:-1]:
        place = place[step]
    if to == "nothing":
        del place[path[-1]]
    else:
        place[path[-1]] = to
    return case


def shown(case: Frame) -> str:
    """Everything in a case, to the bit and type, in words."""
    columns = {
        signal: {name: [repr(value) for value in found.listed(name)] for name in found.names.rows}
        | {"": found.ids}
        for signal, found in case.columns.items()
    }
    lines = {place: line.tuples for place, line in case.lines.items()}
    settings = (case.settings.params, case.settings.tables, case.settings.places, case.settings.broken)
    return repr((case.id, columns, lines, case.closed, case.events, settings, list(map(str, case.faults))))


def faults(case: Frame) -> list[tuple[str, str, int | None]]:
    return [(f.code, f.signal + (f".{f.field}" if f.field else ""), f.index) for f in case.faults]


def test_a_good_case_has_no_fault_and_is_in_si(reader: CasesReader) -> None:
    case = reader.read(GOOD)
    assert case.faults == []
    plan = case.columns["plan"]
    assert plan.listed("v") == [10.0, 20.0, 30.0]
    assert plan.listed("slip") == [0.01, 0.02, 0.03]
    assert plan.listed("ready") == [True, False, True]
    assert [case.value("ego", name) for name in ("x", "heading", "age")] == [1.5, 90 * math.pi / 180, 0.02]
    assert case.flag("ego", "on") is True
    assert [case.columns["objects"].listed(name) for name in ("x", "v", "age")] == [
        [1.0, 3.0],
        [2.0, 4.0],
        [0.5, 0.0],
    ]
    assert case.columns["objects"].ids == ("a", "1")
    assert [case.count(name) for name in ("plan", "trace", "objects")] == [3, 1, 2]
    assert case.line("track", "left").tuples == ((0.0, 1.0), (9.0, 1.0))
    assert case.closed == {"track": False}
    assert case.flag("flag", "") is False


def test_arrays_are_read_like_lists(reader: CasesReader) -> None:
    arrays = copy.deepcopy(GOOD)
    arrays["signals"]["plan"] = {name: np.array(column) for name, column in GOOD["signals"]["plan"].items()}
    arrays["signals"]["track"]["left"] = np.array(GOOD["signals"]["track"]["left"])
    assert shown(reader.read(arrays)) == shown(reader.read(GOOD))


def test_whole_numbers_are_read_like_others(reader: CasesReader) -> None:
    whole = changed("plan", "v", to=[36, 72, 108])
    whole["signals"]["ego"] |= {"heading": 90, "age": 20}
    assert shown(reader.read(whole)) == shown(reader.read(GOOD))


def test_sets_are_columns_or_records(reader: CasesReader) -> None:
    columns = {"id": ["a", "1"], "x": [1.0, 3.0], "v": [2.0, 4.0], "age": [0.5, 0.0]}
    assert shown(reader.read(changed("objects", to=columns))) == shown(reader.read(GOOD))
    counted = {"x": [1.0, 3.0], "v": [2.0, 4.0]}
    bare = [{"x": 1.0, "v": 2.0}, {"x": 3.0, "v": 4.0}]
    assert shown(reader.read(changed("objects", to=counted))) == shown(
        reader.read(changed("objects", to=bare))
    )
    assert reader.read(changed("objects", to=[])).count("objects") == 0


def test_defaults_stand_in_for_what_is_left_out(reader: CasesReader) -> None:
    assert reader.read(changed("plan", "grip")).columns["plan"].listed("grip") == [1.0, 1.0, 1.0]
    assert reader.read(changed("plan", "slip")).columns["plan"].listed("slip") == [0.05] * 3
    assert reader.read(changed("ego", "age")).value("ego", "age") == 0.1
    assert reader.read(changed("plan", "grip")).faults == []


def test_a_default_is_the_declared_one_to_the_bit(tmp_path: Path) -> None:
    """Also where records leave it out of which others have it: it does not go to the unit and back."""
    text = "signal seen : set of object { v: km/h in [-INF, DEFAULT km/h] default DEFAULT km/h, x: m }"
    for default in (0.1, 0.7, 13.3, 17.41, 29.99, 111.11, 233.3):
        path = tmp_path / "default.spec"
        path.write_text("module default\n" + text.replace("DEFAULT", str(default)).replace("-INF", "-300"))
        reader = CasesReader(compile_paths([path]).spec, {("seen", "v"), ("seen", "x")})
        case = reader.read({"signals": {"seen": [{"x": 1.0}, {"x": 2.0, "v": 0.0}, {"x": 3.0}]}})
        assert case.columns["seen"].listed("v") == [default * 1000 / 3600, 0.0, default * 1000 / 3600]
        assert case.faults == []


NAN, INF = math.nan, math.inf


@pytest.mark.parametrize(
    ("case", "expected"),
    [
        # what is missing
        *[(changed(name), [("D211", name, None)]) for name in GOOD["signals"]],
        *[(changed(name, to=None), [("D211", name, None)]) for name in GOOD["signals"]],
        (changed("plan", "v"), [("D211", "plan.v", None)]),
        (changed("plan", "v", to=None), [("D211", "plan.v", None)]),
        (changed("plan", "grip", to=None), [("D211", "plan.grip", None)]),  # a null is not the wish for a default
        (changed("plan", to={}), [("D211", "plan.v", None), ("D211", "plan.ready", None), ("D213", "plan", None)]),
        (changed("ego", "x"), [("D211", "ego.x", None)]),
        (changed("ego", "on"), [("D211", "ego.on", None)]),
        (changed("ego", "on", to=None), [("D215", "ego.on", None)]),
        (changed("objects", 1, "v"), [("D211", "objects.v", 1)]),
        (changed("track", "left"), [("D211", "track.left", None)]),
        # columns that do not fit
        (changed("plan", "v", to=[1, 2]), [("D212", "plan.v", 2)]),
        (changed("plan", "ready", to=[True] * 4), [("D212", "plan.ready", 3)]),
        (changed("plan", "t", to=[0, 1, 2, 3]), [("D212", "plan.t", 3)]),  # read by nobody, and still a contradiction
        (changed("trace", "x", to=[]), [("D212", "trace.x", 0), ("D213", "trace", None)]),
        (changed("trace", to={"t": [], "x": []}), [("D213", "trace", None)]),
        (changed("plan", to={n: c[:1] for n, c in GOOD["signals"]["plan"].items()}), [("D213", "plan", None)]),
        (changed("plan", to={n: [] for n in GOOD["signals"]["plan"]}), [("D213", "plan", None)]),
        # the order of time
        (changed("plan", "t", to=[0, 0.1, 0.1]), [("D214", "plan.t", 2)]),
        (changed("plan", "t", to=[0, -1, 5]), [("D214", "plan.t", 1)]),
        (changed("plan", "t", to=[0, NAN, 5]), [("D215", "plan.t", 1), ("D214", "plan.t", 1)]),
        (changed("plan", "t", to=[None, 1, 5]), [("D215", "plan.t", 0), ("D214", "plan.t", 1)]),
        (changed("plan", "t", to=None), [("D211", "plan.t", None)]),
        # values
        (changed("plan", "v", 1, to=NAN), [("D215", "plan.v", 1)]),
        (changed("plan", "v", 1, to=None), [("D215", "plan.v", 1)]),
        (changed("plan", "v", 1, to="-inf"), [("D215", "plan.v", 1)]),
        (changed("plan", "v", 2, to=INF), [("D215", "plan.v", 2)]),
        (changed("plan", "v", 2, to=10**400), [("D215", "plan.v", 2)]),
        (changed("plan", "ready", 0, to=None), [("D215", "plan.ready", 0)]),
        (changed("plan", "v", 2, to=301), [("D216", "plan.v", 2)]),
        (changed("ego", "heading", to=-181), [("D216", "ego.heading", None)]),
        (changed("ego", "age", to=501), [("D216", "ego.age", None)]),
        (changed("objects", 0, "v", to=51), [("D216", "objects.v", 0)]),
        (changed("plan", "t", to=[0.0, 0.2, 0.1]), [("D214", "plan.t", 2)]),
        (changed("plan", "t", to=[0.0, 0.1, 0.1]), [("D214", "plan.t", 2)]),
        (changed("plan", to={n: c[:1] for n, c in GOOD["signals"]["plan"].items() if n != "ready"}), [("D211", "plan.ready", None), ("D213", "plan", None)]),
        (changed("objects", 1, "id", to="a"), [("D218", "objects.id", 1)]),
        (changed("objects", 0, "id", to="1"), [("D218", "objects.id", 1)]),  # the other one is called by its index
        # lines
        (changed("track", "left", to=[]), [("D217", "track.left", None)]),
        (changed("border", to=[[0, 0]]), [("D217", "border", None)]),
        (changed("border", to=[[0, 0], [NAN, 0]]), [("D215", "border", 1)]),
        (changed("track", "right", 0, to=[INF, 0]), [("D215", "track.right", 0)]),
    ],
)  # fmt: skip
def test_breaches_of_the_contract(reader: CasesReader, case: dict[str, Any], expected: list[Any]) -> None:
    assert faults(reader.read(case)) == expected
    assert all(code in CODES for code, _, _ in expected)


def test_what_is_missing_blocks_the_rules_that_read_it(reader: CasesReader) -> None:
    assert reader.read(changed("plan", "v")).unusable({("plan", "v")})
    assert not reader.read(changed("plan", "v")).unusable({("plan", "grip"), ("ego", "x")})
    for case in (changed("plan"), changed("plan", "t", to=[0, 0, 1]), changed("plan", "v", to=[1, 2])):
        assert reader.read(case).unusable({("plan", "grip")})
        assert not reader.read(case).unusable({("ego", "x"), ("objects", "x")})
    assert not reader.read(changed("plan", "v", 1, to=NAN)).unusable(
        {("plan", "v")}
    )  # the comparison decides


def test_a_value_that_is_missing_is_nan_inside(reader: CasesReader) -> None:
    assert math.isnan(reader.read(changed("plan", "v", 1, to=None)).columns["plan"].listed("v")[1])
    assert reader.read(changed("plan", "v", 1, to="inf")).columns["plan"].listed("v")[1] == INF
    assert reader.read(changed("plan", "ready", 0, to=None)).columns["plan"].listed("ready")[0] is None


def test_only_what_the_rules_read_has_to_be_there(spec: Spec) -> None:
    reader = CasesReader(spec, {("ego", "x")})
    assert reader.read({"signals": {"ego": {"x": 1}}}).faults == []
    assert reader.read({"signals": {"ego": {"x": 1, "heading": "ignored"}, "plan": 3}}).faults == []


@pytest.mark.parametrize(
    ("case", "code", "said"),
    [
        ([], "D201", "the case"),
        ("x", "D201", "a text"),
        (None, "D201", "null"),
        ({"signals": []}, "D202", "`signals` is an object, not a list"),
        ({"signals": None}, "D202", "`signals` is an object, not null"),
        (changed("plan", to=[1]), "D202", "plan: a list has no fields"),
        (changed("plan", "v", to=3), "D202", "plan.v: a number is no column"),
        (changed("trace", "t", to="abc"), "D202", "trace.t: a text is no column"),
        (changed("plan", "v", 1, to="fast"), "D202", "plan.v[1]: a text is no number"),
        (changed("plan", "v", 1, to=True), "D202", "plan.v[1]: a Boolean is no number"),
        (changed("plan", "v", 1, to=[1]), "D202", "plan.v[1]: a list is no number"),
        (changed("plan", "ready", 1, to=1), "D202", "plan.ready[1]: a number is neither true nor false"),
        (changed("ego", to=3), "D202", "ego: a number has no fields"),
        (changed("ego", "x", to={}), "D202", "ego.x: an object is no number"),
        (changed("objects", to="ab"), "D202", "objects: a text has no fields"),
        (changed("objects", 0, to=3), "D202", "objects[0]: a number has no fields"),
        (changed("objects", 0, "x", to="1"), "D202", "objects.x[0]: a text is no number"),
        (changed("objects", 0, "id", to=[1]), "D202", "objects.id[0]: a list is neither a text nor a number"),
        (changed("objects", 0, "id", to=2**63), "D202", "objects.id[0]: a number of more than 64 bits is no id"),
        (changed("objects", 0, "id", to=-(2**63) - 1), "D202", "of more than 64 bits is no id"),
        (changed("objects", 0, "id", to=math.nan), "D202", "objects.id[0]: a number that is not finite is no id"),
        (changed("objects", 0, "id", to=math.inf), "D202", "objects.id[0]: a number that is not finite is no id"),
        (changed("track", to=[]), "D202", "track: a list has no fields"),
        (changed("track", "closed", to=1), "D202", "track.closed: neither true nor false"),
        (changed("track", "left", to="abc"), "D202", "track.left: not a list of points"),
        (changed("track", "left", 1, to=[1]), "D202", "track.left[1]: not a point [x, y]"),
        (changed("track", "left", 1, to=[1, 2, 3]), "D202", "track.left[1]: not a point [x, y]"),
        (changed("border", 0, 1, to="x"), "D202", "border[0]: not a number"),
        (changed("flag", to=1), "D202", "flag: a number is neither true nor false"),
        # names that are almost right, and would leave a default or the spec's own value standing
        ({**GOOD, "parms": {"mass": 1000}}, "D203", "`parms`"),
        ({**GOOD, "PARAMS": {"mass": 1000}}, "D203", "`PARAMS`"),
        ({**GOOD, "tabels": {}}, "D203", "`tabels`"),
        ({**GOOD, "zzz": 1}, "D203", "`zzz`"),
        ({**GOOD, "note": "mine"}, "D203", "`note`"),
        ({**GOOD, "expect": {"safe": True}}, "D203", "`expect`"),
        ({"id": 1, "data": GOOD["signals"]}, "D203", "`data`"),
        (changed("zzz", to=1), "D203", "signals: nothing declares `zzz`"),
        (changed("plna", to=GOOD["signals"]["plan"]), "D203", "signals: nothing declares `plna`"),
        (changed("plan", to={**changed("plan", "grip")["signals"]["plan"], "gripp": [0, 0, 0]}), "D203", "plan: nothing declares `gripp`"),
        (changed("plan", "gear", to=[1, 2]), "D203", "plan: nothing declares `gear`"),
        (changed("plan", "id", to=[1, 2, 3]), "D203", "plan: nothing declares `id`"),
        (changed("ego", to={"x": 1, "heading": 0, "on": True, "Age": 400}), "D203", "ego: nothing declares `Age`"),
        (changed("ego", 7, to=1), "D203", "ego: a field is called by a text"),
        (changed("objects", 1, to={"x": 1, "v": 0, "ages": 4}), "D203", "objects: nothing declares `ages`"),
        (changed("objects", to={"x": [], "v": [], "ages": []}), "D203", "objects: nothing declares `ages`"),
        (changed("track", "middle", to=[]), "D203", "track: nothing declares `middle`"),
        # overrides
        ({**GOOD, "params": {"MASS": 1000}}, "D203", "no parameter `MASS`"),
        ({**GOOD, "params": {"mas": 1000}}, "D203", "no parameter `mas`"),
        ({**GOOD, "params": [1]}, "D202", "`params` is an object"),
        ({**GOOD, "params": []}, "D202", "`params` is an object"),
        ({**GOOD, "tables": False}, "D202", "`tables` is an object"),
        ({**GOOD, "places": ""}, "D202", "`places` is an object"),
        ({**GOOD, "params": {"mass": "1"}}, "D202", "params.mass is a number"),
        ({**GOOD, "params": {"mass": None}}, "D204", "`mass` is not finite"),
        ({**GOOD, "params": {"mass": NAN}}, "D204", "`mass` is not finite"),
        ({**GOOD, "params": {"mass": 1e400}}, "D204", "`mass` is not finite"),
        ({**GOOD, "params": {"mass": 1401}}, "D204", "`mass` = 1401.0 kg is outside its range"),
        ({**GOOD, "params": {"v_max": -1}}, "D204", "outside"),
        ({**GOOD, "params": {"mass": 1000, "door.mass": 1300}}, "D204", "`door.mass` is given twice"),
        ({**GOOD, "tables": {"ax": [[0, 1]]}}, "D203", "no table `ax`"),
        ({**GOOD, "tables": {"door.ax_max": [[0, 1]], "ax_max": [[0, 9]]}}, "D204", "`door.ax_max` is given twice"),
        ({**GOOD, "tables": {"ax_max": []}}, "D204", "no rows"),
        ({**GOOD, "tables": {"ax_max": [[0, 1], [0, 2]]}}, "D204", "do not ascend"),
        ({**GOOD, "tables": {"ax_max": [[0, None]]}}, "D204", "not finite"),
        ({**GOOD, "tables": {"ax_max": [[0]]}}, "D202", "has 1 entry"),
        ({**GOOD, "places": {"pits": []}}, "D203", "no place `pits`"),
        ({**GOOD, "places": {"pit": [[0, 0], [1, 1], [0, 0]]}}, "D204", "too few"),
        ({**GOOD, "places": {"start": [[0, 0], [NAN, 1]]}}, "D204", "not finite"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused(reader: CasesReader, case: object, code: str, said: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        reader.read(case)
    assert caught.value.code == code
    assert said in caught.value.message
    assert caught.value.help
    assert code in CODES


def test_overrides_are_in_the_declared_units(reader: CasesReader) -> None:
    case = reader.read({
        **GOOD, "params": {"v_max": 36, "door.mass": 1000}, "tables": {"ax_max": [[0, 1], [36, 2]]},
        "places": {"pit": [[0, 0], [1, 0], [1, 1]]},
    })  # fmt: skip
    assert case.settings.params == {"door.v_max": 10.0, "door.mass": 1000.0}
    assert case.settings.tables == {"door.ax_max": ((0.0, 10.0), (1.0, 2.0))}
    assert case.settings.places == {"door.pit": ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))}
    assert reader.read({**GOOD, "params": None, "tables": None, "places": {}}).settings.params == {}


ROWS = [[0, 1], [36, 2]]


@pytest.mark.parametrize(
    "rows",
    [
        tuple(map(tuple, ROWS)), np.array(ROWS), np.array(ROWS, dtype=">f4"), np.array(ROWS, dtype=object), [np.array(row) for row in ROWS],
        np.array([[0, 9, 1], [36, 9, 2]])[:, ::2], [[np.float32(0), np.int8(1)], [np.array(36), np.float64(2)]],
    ],
    ids=["tuples", "whole numbers", "short and the other way round", "objects", "rows", "strided", "scalars"],
)  # fmt: skip
def test_rows_are_of_what_numbers_may_be(reader: CasesReader, rows: Any) -> None:
    for name, into, wanted in (
        ("tables", "ax_max", ((0.0, 10.0), (1.0, 2.0))), ("places", "pit", ((0.0, 1.0), (36.0, 2.0), (1.0, 0.0)))
    ):  # fmt: skip
        given = rows if name == "tables" else [*rows, [1, 0]]
        settings = reader.read({**GOOD, name: {into: given}}).settings
        assert (settings.tables or settings.places) == {f"door.{into}": wanted}


@pytest.mark.parametrize(
    "rows", [np.array(ROWS, dtype=complex), [[0, "1"]], np.array(["ab", "cd"]), np.array(7.0), "rows", {0: 1, 36: 2}, {"a": [0, 1]}.values()]
)  # fmt: skip
def test_and_of_nothing_else(reader: CasesReader, rows: Any) -> None:
    for name, into in (("tables", "ax_max"), ("places", "pit")):
        with pytest.raises(TrackmarshalError) as caught:
            reader.read({**GOOD, name: {into: rows}})
        assert caught.value.code == "D202"


@pytest.mark.parametrize(
    ("case", "meant"),
    [
        ({**GOOD, "PARAMS": {}}, "params"), ({**GOOD, "Signals": {}}, "signals"), (changed("ego", "Age", to=1), "age"),
        (changed("ego", "AGE", to=1), "age"), (changed("objects", 0, "V", to=1), "v"), (changed("objects", 1, "Age", to=1), "age"),
        (changed("plan", "gripp", to=[]), "grip"), (changed("Plan", to={}), "plan"), (changed("track", "Left", to=[]), "left"),
    ],
)  # fmt: skip
def test_what_is_misspelt_is_suggested(reader: CasesReader, case: dict[str, Any], meant: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        reader.read(case)
    assert caught.value.help is not None
    assert f"`{meant}`" in caught.value.help


def test_what_the_spec_declares_and_no_rule_reads_is_fine(spec: Spec) -> None:
    """Whatever it is; and so is what other modules of a project declare, which are asked only then."""
    asked = []

    def declared() -> frozenset[str]:
        asked.append(1)
        return frozenset({"weather"})

    reader = CasesReader(spec, {("plan", "v")}, declared)
    case = changed("ego", to=7)
    case["signals"]["plan"]["grip"] = "?"
    assert reader.read(case).faults == []
    assert asked == []
    case["signals"]["weather"] = "fine"
    assert reader.read(case).faults == []
    assert asked == [1]
    with pytest.raises(TrackmarshalError) as caught:
        reader.read(changed("wether", to=1))
    assert caught.value.code == "D203"


def test_a_flood_of_faults_is_summed_up(reader: CasesReader) -> None:
    """One fault for every kind in every field, with the first index."""
    columns = {"t": list(range(1000)), "v": [0.0, *[NAN] * 499, *[1e9] * 500], "ready": [True, *[None] * 999]}
    case = reader.read(changed("plan", to=columns))
    assert list(map(str, case.faults)) == [
        "D215 plan.v[1]: the value is missing or no number, and 498 more",
        "D216 plan.v[500]: 1000000000.0 km/h is outside [-10, 300], and 499 more",
        "D215 plan.ready[1]: the value is missing, and 998 more",
    ]
    for lacking in ({"id": "a", "x": 1.0}, {"x": 2.0}):
        assert faults(reader.read(changed("objects", to=[lacking, {"x": 3.0}, {"x": 3.0, "v": 1.0}]))) == [
            ("D211", "objects.v", 0)
        ]


def test_a_flood_of_unknown_names_takes_no_time_and_is_summed_up(spec: Spec) -> None:
    from trackmarshal.runtime.door.reading import SignalsReader

    reader = CasesReader(spec, READS)
    signals = {**GOOD["signals"], "objects": [{"x": 1.0, "v": 1.0, "agee": 1.0, "b": 1.0}] * 500}
    signals["ego"] = {**GOOD["signals"]["ego"], **{f"field{i}": 1 for i in range(100_000)}}
    frame = Frame()
    found: list[Any] = []
    start = time.process_time()
    SignalsReader(reader.contract).read(signals, frame, found)
    assert time.process_time() - start < 2.0  # of a hundred thousand suggestions it would be a minute
    own = [str(fault) for fault in found if fault.signal == "objects"]
    assert len(own) == 2
    assert own[0].startswith(
        "D220 objects.agee[0]: nothing declares `agee`, and 499 more; did you mean `age`"
    )
    own = [str(fault) for fault in found if fault.signal == "ego"]
    assert len(own) == 100_000
    assert own[-1] == "D220 ego.field99999: nothing declares `field99999`"


def test_faults_come_in_the_same_order_in_every_process(spec: Spec) -> None:
    """Sets of names have an order of their own in each: a record that runs again would say something else."""
    program = """
import sys
from pathlib import Path
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.runtime.door.cases import CasesReader
from trackmarshal.runtime.door.reading import SignalsReader
from trackmarshal.runtime.frame import Frame
compiled = compile_paths([Path(sys.argv[1])])
reader = SignalsReader(CasesReader(compiled.spec, [("plan", "x"), ("seen", "x"), ("track", "left")]).contract)
found = []
columns = {"t": [0, 1], "x": [1, 2], "a": [1], "b": [1, 2, 3], "c": [1], "zz": 1, "yy": 1, "xx": 1}
seen = [{"x": 1.0, "p": 1, "q": 1, "r": 1}, {"a": 1, "b": 1}]
reader.read({"plan": columns, "seen": seen, "track": {"left": [], "l": 1, "m": 1, "n": 1}}, Frame(), found)
print([str(fault) for fault in found])
reader.refuse_unknown(dict.fromkeys("one two three four five six".split()), found, frozenset({"seen"}))
print([str(fault) for fault in found])
"""
    text = (
        "module order\nsignal plan : trajectory { t: s increasing, x: m, a: m, b: m, c: m }\n"
        "signal seen : set of object { x: m, a: m, b: m }\nsignal track : corridor { left: polyline, right: polyline }\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "order.spec"
        path.write_text(text)
        said = {
            subprocess.run(
                [sys.executable, "-c", program, str(path)], check=True, capture_output=True, text=True,
                env={**os.environ, "PYTHONHASHSEED": str(seed)},
            ).stdout
            for seed in range(3)
        }  # fmt: skip
    assert len(said) == 1


def test_equal_lines_are_the_same_object(reader: CasesReader) -> None:
    first, second = reader.read(copy.deepcopy(GOOD)), reader.read(copy.deepcopy(GOOD))
    assert first.line("track", "left") is second.line("track", "left")
    other = reader.read(changed("track", "left", 0, to=[0, 2]))
    assert other.line("track", "left").tuples == ((0.0, 2.0), (9.0, 1.0))


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterable[tuple[Any, ...]]:
    """The path of everything in plain data."""
    if path:
        yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from places(inner, (*path, key))


plain = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@given(st.sampled_from(sorted(places(GOOD["signals"]), key=str)), plain)
def test_whatever_stands_anywhere_is_read_or_refused(spec: Spec, path: tuple[Any, ...], value: Any) -> None:
    reader = CasesReader(spec, READS)
    try:
        case = reader.read(changed(*path, to=value))
    except TrackmarshalError as error:
        assert error.code in CODES
        return
    for signal, columns in case.columns.items():
        for name in columns.names.rows:
            column = columns.listed(name)
            assert len(column) == case.count(signal)
            for index, number in enumerate(column):
                if number is None or not math.isfinite(number):
                    assert any(f.signal == signal for f in case.faults), (signal, name, index)


def outcome(read: Callable[[], list[Frame]]) -> list[str]:
    """What comes of reading: everything in the cases to the bit and type, or the error."""
    try:
        return list(map(shown, read()))
    except TrackmarshalError as error:
        return [f"{error.code} {error}"]


#: What is often right, or right somewhere else, so that flaws meet cases without any.
likely = st.sampled_from([0.0, -0.0, 1, 1.5, -20.0, 60.0, 1e308, NAN, INF, True, None, "nan", "a", [], [0.0, 0.1, 0.2], [1.0, NAN, 2.0],
                          [1e308] * 3, (0.0, 0.1, 0.2), [True, False, None], [[0.0, 1.0], [2.0, 3.0]], {}, {"x": 1.0}, np.array([0.0, 0.1, 0.2]),
                          np.array([[0.0, 0.1, 0.2]]), np.array([1, 2, 3]), np.array(1.0), np.array([]), np.array([0.0, 0.1, 0.2], dtype=object)])  # fmt: skip
edits = st.lists(
    st.tuples(st.sampled_from([p for p in sorted(places(GOOD["signals"]), key=str) if len(p) > 1]), likely),
    max_size=2,
)


@settings(max_examples=amount(20, 400), deadline=None)
@given(
    st.lists(edits, min_size=1, max_size=4),
    st.sampled_from(
        [{}, {"params": {"mass": 1000}}, {"params": {"mass": 1}}, {"note": 1}, {"parms": {}}, {"params": []}]
    ),
)
def test_many_cases_are_read_as_each_by_itself(
    spec: Spec, changes: list[list[tuple[tuple[Any, ...], Any]]], extra: dict[str, Any]
) -> None:
    raws = []
    for edit in changes:
        raw = {**copy.deepcopy(GOOD), **extra}
        for path, value in edit:
            target: Any = raw["signals"]
            try:
                for step in path[:-1]:
                    target = target[step]
                target[path[-1]] = value
            except (TypeError, KeyError, IndexError, ValueError, OverflowError):
                pass
        raws.append(raw)
    together, alone = CasesReader(spec, READS), CasesReader(spec, READS)
    assert outcome(lambda: together.read_all(raws)) == outcome(lambda: [alone.read(raw) for raw in raws])


def test_what_is_left_out_of_a_set_or_a_state(spec: Spec) -> None:
    together, alone = CasesReader(spec, READS), CasesReader(spec, READS)
    for path in places(GOOD["signals"]):
        raw = copy.deepcopy(GOOD)
        target: Any = raw["signals"]
        for step in path[:-1]:
            target = target[step]
        del target[path[-1]]
        for misspelt in ({}, {"gripp": [1.0], "agee": 2.0, "ages": 1.0}):
            if isinstance(target, dict):
                target |= misspelt
            assert outcome(lambda: together.read_all([GOOD, raw])) == outcome(  # noqa: B023 - called here
                lambda: [alone.read(GOOD), alone.read(raw)]  # noqa: B023
            )


@pytest.mark.parametrize(
    "array", [np.array(1.0), np.array([]), np.zeros((3, 1)), np.array([None, 0.1, 0.2]), np.array(None), np.zeros((0, 2))]
)  # fmt: skip
@pytest.mark.parametrize("name", ["t", "v", "ready"])
def test_arrays_that_are_no_columns(spec: Spec, name: str, array: Any) -> None:
    raw = copy.deepcopy(GOOD)
    raw["signals"]["plan"][name] = array
    found = outcome(lambda: [CasesReader(spec, READS).read(raw)])
    assert found != outcome(lambda: [CasesReader(spec, READS).read(GOOD)])
    assert "D2" in found[0]


def test_an_order_by_default_stands_still(tmp_path: Path) -> None:
    """Whether a rule reads the times or not: they are said to be all the same."""
    path = tmp_path / "order.spec"
    path.write_text("module order\nsignal plan : trajectory { t: s increasing default 0 s, x: m }\n")
    for reads in ({("plan", "x"), ("plan", "t")}, {("plan", "x")}):
        reader = CasesReader(compile_paths([path]).spec, reads)
        assert faults(reader.read({"signals": {"plan": {"x": [1.0, 2.0]}}})) == [("D214", "plan.t", 1)]
        both = [{"signals": {"plan": {"x": [1.0, 2.0]}}}] * 2
        assert [faults(case) for case in reader.read_all(both)] == [[("D214", "plan.t", 1)]] * 2
        assert reader.read({"signals": {"plan": {"x": [1.0, 2.0], "t": [0.0, 1.0]}}}).faults == []
