"""Cases at the door: everything that breaks the input contract is named, and nothing of it can come out as safe."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterable
from typing import Any
from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trackmarshal.runtime.case import MOST_FAULTS, Case, CaseReader
from trackmarshal.runtime.cases import CasesReader

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.codes import CODES
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


@pytest.fixture(params=[CaseReader, CasesReader])
def reader(spec: Spec, request: pytest.FixtureRequest) -> CaseReader | CasesReader:
    made: CaseReader | CasesReader = request.param(spec, READS)
    return made


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


def faults(case: Case) -> list[tuple[str, str, int | None]]:
    return [(f.code, f.signal + (f".{f.field}" if f.field else ""), f.index) for f in case.faults]


def test_a_good_case_has_no_fault_and_is_in_si(reader: CaseReader | CasesReader) -> None:
    case = reader.read(GOOD)
    assert case.faults == []
    assert case.unusable == set()
    assert case.columns["plan"]["v"] == (10.0, 20.0, 30.0)
    assert case.columns["plan"]["slip"] == (0.01, 0.02, 0.03)
    assert case.columns["plan"]["ready"] == (True, False, True)
    assert case.scalars["ego"] == {"x": 1.5, "heading": 90 * math.pi / 180, "age": 0.02, "on": True}
    assert case.columns["objects"] == {"x": (1.0, 3.0), "v": (2.0, 4.0), "age": (0.5, 0.0)}
    assert case.names["objects"] == ["a", "1"]
    assert case.counts == {"plan": 3, "trace": 1, "objects": 2}
    assert list(case.lines["track", "left"]) == [(0.0, 1.0), (9.0, 1.0)]
    assert case.closed == {"track": False}
    assert case.scalars["flag"] == {"": False}


def test_arrays_are_read_like_lists(reader: CaseReader | CasesReader) -> None:
    arrays = copy.deepcopy(GOOD)
    arrays["signals"]["plan"] = {name: np.array(column) for name, column in GOOD["signals"]["plan"].items()}
    arrays["signals"]["track"]["left"] = np.array(GOOD["signals"]["track"]["left"])
    assert reader.read(arrays).columns["plan"] == reader.read(GOOD).columns["plan"]
    assert reader.read(arrays).lines["track", "left"] == reader.read(GOOD).lines["track", "left"]


def test_whole_numbers_are_read_like_others(reader: CaseReader | CasesReader) -> None:
    whole = changed("plan", "v", to=[36, 72, 108])
    whole["signals"]["ego"] |= {"heading": 90, "age": 20}
    assert repr(reader.read(whole)) == repr(reader.read(GOOD))


def test_a_good_case_takes_the_short_way(spec: Spec) -> None:
    reader = CasesReader(spec, READS)
    with mock.patch.object(CaseReader, "read", side_effect=AssertionError):
        assert len(reader.read_all([GOOD, changed("plan", "grip"), changed("ego", "age")])) == 3


def test_defaults_stand_in_for_what_is_left_out(reader: CaseReader | CasesReader) -> None:
    assert list(reader.read(changed("plan", "grip")).columns["plan"]["grip"]) == [1.0, 1.0, 1.0]
    assert list(reader.read(changed("plan", "slip")).columns["plan"]["slip"]) == [0.05] * 3
    assert reader.read(changed("ego", "age")).scalars["ego"]["age"] == 0.1
    assert reader.read(changed("plan", "grip")).faults == []


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
        (changed("plan", to={}), [("D211", "plan", None), ("D211", "plan.v", None), ("D211", "plan.ready", None)]),
        (changed("ego", "x"), [("D211", "ego.x", None), ("D215", "ego.x", None)]),
        (changed("ego", "on"), [("D211", "ego.on", None), ("D215", "ego.on", None)]),
        (changed("objects", 1, "v"), [("D211", "objects.v", 1), ("D215", "objects.v", 1)]),
        (changed("track", "left"), [("D211", "track.left", None)]),
        # columns that do not fit
        (changed("plan", "v", to=[1, 2]), [("D212", "plan", None)]),
        (changed("plan", "ready", to=[True] * 4), [("D212", "plan", None)]),
        (changed("plan", "t", to=[0, 1, 2, 3]), [("D212", "plan", None)]),  # read by nobody, and still a contradiction
        (changed("trace", "x", to=[]), [("D212", "trace", None), ("D213", "trace", None)]),
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
        (changed("plan", to={n: c[:1] for n, c in GOOD["signals"]["plan"].items() if n != "ready"}), [("D213", "plan", None), ("D211", "plan.ready", None)]),
        (changed("objects", 1, "id", to="a"), [("D218", "objects.id", 1)]),
        (changed("objects", 0, "id", to="1"), [("D218", "objects.id", 1)]),  # the other one is called by its index
        # lines
        (changed("track", "left", to=[]), [("D217", "track.left", None)]),
        (changed("border", to=[[0, 0]]), [("D217", "border", None)]),
        (changed("border", to=[[0, 0], [NAN, 0]]), [("D215", "border", 1)]),
        (changed("track", "right", 0, to=[INF, 0]), [("D215", "track.right", 0)]),
    ],
)  # fmt: skip
def test_breaches_of_the_contract(
    reader: CaseReader | CasesReader, case: dict[str, Any], expected: list[Any]
) -> None:
    assert faults(reader.read(case)) == expected
    assert all(code in CODES for code, _, _ in expected)


def test_what_is_missing_blocks_the_rules_that_read_it(reader: CaseReader | CasesReader) -> None:
    assert reader.read(changed("plan", "v")).blocks({("plan", "v")})
    assert not reader.read(changed("plan", "v")).blocks({("plan", "grip"), ("ego", "x")})
    for case in (changed("plan"), changed("plan", "t", to=[0, 0, 1]), changed("plan", "v", to=[1, 2])):
        assert reader.read(case).blocks({("plan", "grip")})
        assert not reader.read(case).blocks({("ego", "x"), ("objects", "x")})
    assert not reader.read(changed("plan", "v", 1, to=NAN)).blocks({("plan", "v")})  # the comparison decides


def test_a_value_that_is_missing_is_nan_inside(reader: CaseReader | CasesReader) -> None:
    case = reader.read(changed("plan", "v", 1, to="inf"))
    assert math.isnan(case.columns["plan"]["v"][1])
    assert reader.read(changed("plan", "ready", 0, to=None)).columns["plan"]["ready"][0] is None


def test_only_what_the_rules_read_has_to_be_there(spec: Spec) -> None:
    reader = CaseReader(spec, {("ego", "x")})
    assert reader.read({"signals": {"ego": {"x": 1}}}).faults == []
    assert reader.read({"signals": {"ego": {"x": 1, "heading": "ignored"}, "plan": 3}}).faults == []


@pytest.mark.parametrize(
    ("case", "code", "said"),
    [
        ([], "D201", "the case"),
        ("x", "D201", "a string"),
        (None, "D201", "null"),
        ({"signals": []}, "D202", "`signals` is an object, not a list"),
        ({"signals": None}, "D202", "`signals` is an object, not null"),
        (changed("plan", to=[1]), "D202", "signal `plan` is an object, not a list"),
        (changed("plan", "v", to=3), "D202", "plan.v is a list, not a number"),
        (changed("plan", "t", to="abc"), "D202", "plan.t is a list, not a string"),
        (changed("plan", "v", 1, to="fast"), "D202", "plan.v[1] is a number or null, not a string"),
        (changed("plan", "v", 1, to=True), "D202", "plan.v[1] is a number or null, not a Boolean"),
        (changed("plan", "v", 1, to=[1]), "D202", "plan.v[1] is a number or null, not a list"),
        (changed("plan", "ready", 1, to=1), "D202", "plan.ready[1] is true, false or null, not a number"),
        (changed("ego", to=3), "D202", "signal `ego` is an object, not a number"),
        (changed("ego", "x", to={}), "D202", "ego.x is a number or null, not an object"),
        (changed("objects", to={}), "D202", "signal `objects` is a list, not an object"),
        (changed("objects", 0, to=3), "D202", "objects[0] is an object, not a number"),
        (changed("objects", 0, "x", to="1"), "D202", "objects.x[0] is a number or null, not a string"),
        (changed("objects", 0, "id", to=[1]), "D202", "objects[0].id is a string or a number, not a list"),
        (changed("track", to=[]), "D202", "signal `track` is an object, not a list"),
        (changed("track", "closed", to=1), "D202", "track.closed is true or false, not a number"),
        (changed("track", "left", to="abc"), "D202", "track.left is a list, not a string"),
        (changed("track", "left", 1, to=[1]), "D202", "track.left[1] has 1 entry, not 2"),
        (changed("track", "left", 1, to=[1, 2, 3]), "D202", "track.left[1] has 3 entries, not 2"),
        (changed("border", 0, 1, to="x"), "D202", "border[0] is a number or null, not a string"),
        (changed("flag", to=1), "D202", "event `flag` is true, false or null, not a number"),
        # names that are almost right, and would leave a default or the spec's own value standing
        ({**GOOD, "parms": {"mass": 1000}}, "D203", "`parms`"),
        ({**GOOD, "tabels": {}}, "D203", "`tabels`"),
        (changed("plan", to={**changed("plan", "grip")["signals"]["plan"], "gripp": [0, 0, 0]}), "D203", "`gripp`"),
        (changed("ego", to={"x": 1, "heading": 0, "on": True, "agee": 400}), "D203", "`agee`"),
        (changed("objects", 1, to={"x": 1, "v": 0, "ages": 4}), "D203", "`ages`"),
        # overrides
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
        ({**GOOD, "tables": {"ax": [[0, 1]]}}, "D203", "no table `ax`"),
        ({**GOOD, "tables": {"ax_max": []}}, "D204", "no rows"),
        ({**GOOD, "tables": {"ax_max": [[0, 1], [0, 2]]}}, "D204", "do not ascend"),
        ({**GOOD, "tables": {"ax_max": [[0, None]]}}, "D204", "not finite"),
        ({**GOOD, "tables": {"ax_max": [[0]]}}, "D202", "has 1 entry"),
        ({**GOOD, "places": {"pits": []}}, "D203", "no place `pits`"),
        ({**GOOD, "places": {"pit": [[0, 0], [1, 1], [0, 0]]}}, "D204", "too few"),
        ({**GOOD, "places": {"start": [[0, 0], [NAN, 1]]}}, "D204", "not finite"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused(
    reader: CaseReader | CasesReader, case: object, code: str, said: str
) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        reader.read(case)
    assert caught.value.code == code
    assert said in caught.value.message
    assert caught.value.help
    assert code in CODES


def test_overrides_are_in_the_declared_units(reader: CaseReader | CasesReader) -> None:
    case = reader.read({
        **GOOD, "params": {"v_max": 36, "door.mass": 1000}, "tables": {"ax_max": [[0, 1], [36, 2]]},
        "places": {"pit": [[0, 0], [1, 0], [1, 1]]},
    })  # fmt: skip
    assert case.params == {"door.v_max": 10.0, "door.mass": 1000.0}
    assert case.tables == {"door.ax_max": ((0.0, 10.0), (1.0, 2.0))}
    assert case.places == {"door.pit": ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))}
    assert reader.read({**GOOD, "params": None, "tables": None, "places": None}).params == {}


def test_keys_of_the_users_own_are_left_alone(reader: CaseReader | CasesReader) -> None:
    case = {**GOOD, "expect": {"safe": True}, "note": "mine"}
    case["signals"] = {
        **GOOD["signals"],
        "weather": "fine",
        "plan": {**GOOD["signals"]["plan"], "gear": [1, 2]},
    }
    assert reader.read(case).faults == []


def test_a_flood_of_faults_is_summed_up(reader: CaseReader | CasesReader) -> None:
    columns = {"t": list(range(1000)), "v": [NAN] * 1000, "ready": [None] * 1000}
    case = reader.read(changed("plan", to=columns))
    assert len(case.faults) <= MOST_FAULTS
    assert faults(case)[:3] == [("D215", "plan.v", i) for i in range(3)]
    assert [str(f) for f in case.faults if f.index is None] == [
        "D215 plan.v: and 997 more",
        "D215 plan.ready: and 997 more",
    ]


def test_equal_lines_are_the_same_object(reader: CaseReader | CasesReader) -> None:
    first, second = reader.read(copy.deepcopy(GOOD)), reader.read(copy.deepcopy(GOOD))
    assert first.lines["track", "left"] is second.lines["track", "left"]
    other = reader.read(changed("track", "left", 0, to=[0, 2]))
    assert list(other.lines["track", "left"]) == [(0.0, 2.0), (9.0, 1.0)]


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
    reader = CaseReader(spec, READS)
    try:
        case = reader.read(changed(*path, to=value))
    except TrackmarshalError as error:
        assert error.code in CODES
        return
    for signal, columns in case.columns.items():
        for name, column in columns.items():
            assert len(column) == case.counts[signal]
            for index, number in enumerate(column):
                if number is None or (isinstance(number, float) and not math.isfinite(number)):
                    assert case.faults, (signal, name, index)
                    assert number is None or math.isnan(number)


def outcome(read: Callable[[], list[Case]]) -> str:
    """What comes of reading: everything in the cases to the bit and type, or the error."""
    try:
        return repr(read())
    except TrackmarshalError as error:
        return f"{error.code} {error}"


#: What is often right, or right somewhere else, so that flaws meet cases without any.
likely = st.sampled_from([0.0, -0.0, 1, 1.5, -20.0, 60.0, 1e308, NAN, INF, True, None, "nan", "a", [], [0.0, 0.1, 0.2], [1.0, NAN, 2.0],
                          [1e308] * 3, (0.0, 0.1, 0.2), [True, False, None], [[0.0, 1.0], [2.0, 3.0]], {}, {"x": 1.0}, np.array([0.0, 0.1, 0.2]),
                          np.array([[0.0, 0.1, 0.2]]), np.array([1, 2, 3]), np.array(1.0), np.array([]), np.array([0.0, 0.1, 0.2], dtype=object)])  # fmt: skip
edits = st.lists(
    st.tuples(st.sampled_from([p for p in sorted(places(GOOD["signals"]), key=str) if len(p) > 1]), likely),
    max_size=2,
)


@settings(max_examples=400, deadline=None)
@given(
    st.lists(edits, min_size=1, max_size=4),
    st.sampled_from([{}, {"params": {"mass": 1000}}, {"params": {"mass": 1}}, {"note": 1}, {"parms": {}}]),
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
    together, alone = CasesReader(spec, READS), CaseReader(spec, READS)
    assert outcome(lambda: together.read_all(raws)) == outcome(lambda: [alone.read(raw) for raw in raws])


def test_what_is_left_out_of_a_set_or_a_state(spec: Spec) -> None:
    together, alone = CasesReader(spec, READS), CaseReader(spec, READS)
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


@pytest.mark.parametrize("array", [np.array(1.0), np.array([]), np.zeros((3, 1)), np.array([None, 0.1, 0.2])])
@pytest.mark.parametrize("name", ["t", "v", "ready"])
def test_arrays_that_are_no_columns(spec: Spec, name: str, array: Any) -> None:
    together, alone = CasesReader(spec, READS), CaseReader(spec, READS)
    raw = copy.deepcopy(GOOD)
    raw["signals"]["plan"][name] = array
    assert outcome(lambda: [together.read(raw)]) == outcome(lambda: [alone.read(raw)])
