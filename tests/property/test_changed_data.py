"""Data that the caller changes between two calls: it is read anew, wherever it stands and whatever holds it."""

from __future__ import annotations

import math
import struct
import tempfile
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from property.strategies.specs import repeatable
from support.agreement import compiled
from support.length import amount
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.door.cases import AT_ONCE
from trackmarshal.runtime.door.lines import KEPT, line
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.lines import Line

SPEC = """
module changed
signal track : corridor { left: polyline, right: polyline }
signal line : polyline
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m default 0 }
zone pit = polygon (0 m, -1 m) (9 m, -1 m) (9 m, 1 m) (0 m, 1 m)
rule on_track "on the track"
  for all p in plan
  require swept_footprint(p, 2 m, 1 m) inside track
rule near "near the line"
  for all p in plan
  require distance_to(p, line) <= 1 m
rule in_pit "in the pit"
  for all p in plan
  require p in zone pit
"""


def array_of_lists(points: list[list[float]]) -> Any:
    held = np.empty(len(points), dtype=object)
    held[:] = points
    return held


def memmap(points: list[list[float]]) -> Any:
    with tempfile.TemporaryFile() as file:
        held = np.memmap(file, dtype=np.float64, mode="w+", shape=(len(points), 2))
        held[:] = points
    return held


#: What holds the points of a line, made from lists of numbers.
HOLDERS: dict[str, Callable[[list[list[float]]], Any]] = {
    "a list of lists": lambda points: points,
    "a list of tuples": lambda points: [tuple(point) for point in points],
    "a tuple of lists": tuple,
    "a tuple of tuples": lambda points: tuple(tuple(point) for point in points),
    "a list of arrays": lambda points: [np.array(point) for point in points],
    "a tuple of arrays": lambda points: tuple(np.array(point) for point in points),
    "an array": np.array,
    "an array of singles": lambda points: np.array(points, dtype=np.float32),
    "an array of objects": lambda points: np.array(points, dtype=object),
    "an array of lists": array_of_lists,
    "a masked array": np.ma.array,
    "a memmap": memmap,
}
BACKENDS = pytest.mark.parametrize("backend", ["reference", "numpy"])
LEFT = ((-9.0, 2.0), (3.0, 2.0), (20.0, 2.0))


@pytest.fixture(scope="module")
def spec() -> Spec:
    return compiled(SPEC)


def points() -> list[list[float]]:
    return [list(point) for point in LEFT]


def case(left: Any, line: Any = None) -> dict[str, Any]:
    """A car on y = 0, the left border on y = 2."""
    plan = {"t": [0.0, 1.0], "x": [1.0, 4.0], "y": [0.0, 0.0], "heading": [0.0, 0.0]}
    track = {"left": left, "right": [[-9, -2], [20, -2]]}
    signals = {"track": track, "plan": plan, "line": [[-9, 0], [20, 0]] if line is None else line}
    return {"signals": signals}


def verdicts(evaluator: Evaluator, raw: Any) -> dict[str, tuple[str, str]] | str:
    """What an evaluator says of every rule of a case, or with which error it refuses the case."""
    try:
        (result,) = evaluator.evaluate([evaluator.read(raw)])
    except TrackmarshalError as error:
        return str(error)
    return {name: (rule.verdict, repr(rule.margin)) for name, rule in result.rules.items()}


def replaced(held: Any, index: int, point: Any) -> None:
    held[index] = point


#: Changes in place, by what is changed: of the line, of one of its points, of what an array looks at.
OF_LINES: dict[str, Callable[[Any], Any]] = {
    "another point": lambda held: replaced(held, 1, [3.0, 0.2]),
    "a point more": lambda held: held.insert(1, [2.0, 0.2]),
    "points less": lambda held: held.clear(),
    "NaN": lambda held: replaced(held, 1, [3.0, math.nan]),
    "text": lambda held: replaced(held, 1, "ab"),
}
OF_POINTS: dict[str, Callable[[Any], Any]] = {
    "another number": lambda held: replaced(held[1], 1, 0.2),
    "NaN": lambda held: replaced(held[1], 1, math.nan),
    "True": lambda held: replaced(held[1], 1, True),
    "a number more": lambda held: held[1].append(0.2),
    "no number": lambda held: held[1].clear(),
}
OF_ARRAYS = {
    "another number": OF_POINTS["another number"],
    "NaN": OF_POINTS["NaN"],
    "all": lambda held: held.fill(1.0),
}
CHANGES = [
    *[("a list of lists", name, change) for name, change in {**OF_LINES, **OF_POINTS}.items()],
    *[("a list of tuples", name, change) for name, change in OF_LINES.items()],
    *[("a tuple of lists", name, change) for name, change in OF_POINTS.items()],
    *[(holder, "another number", OF_POINTS["another number"]) for holder in ("a list of arrays", "a tuple of arrays")],
    *[("an array of lists", name, change) for name, change in OF_POINTS.items()],
    *[(holder, name, change) for holder in ("an array", "an array of singles", "an array of objects", "a masked array", "a memmap") for name, change in OF_ARRAYS.items()],
    ("a masked array", "a point masked", lambda held: replaced(held, 1, np.ma.masked)),
]  # fmt: skip


@BACKENDS
@pytest.mark.parametrize(
    ("holder", "name", "change"), CHANGES, ids=[f"{name} in {holder}" for holder, name, _ in CHANGES]
)
def test_a_border_changed_in_place(
    spec: Spec, backend: str, holder: str, name: str, change: Callable[[Any], Any]
) -> None:
    evaluator = Evaluator(spec, None, backend)
    raw = case(HOLDERS[holder](points()))
    before = verdicts(evaluator, raw)
    assert before == verdicts(evaluator, raw)
    assert isinstance(before, dict)
    assert before["on_track"][0] == "satisfied"
    change(raw["signals"]["track"]["left"])
    after = verdicts(evaluator, raw)
    assert after == verdicts(Evaluator(spec, None, backend), raw), name
    assert isinstance(after, str) or after["on_track"][0] in ("violated", "undefined")


@BACKENDS
def test_a_view_that_cannot_be_written_of_an_array_that_can(spec: Spec, backend: str) -> None:
    evaluator = Evaluator(spec, None, backend)
    base = np.array(points())
    view = base[:]
    view.flags.writeable = False
    assert verdicts(evaluator, case(view))["on_track"][0] == "satisfied"  # type: ignore[index]
    base[1, 1] = 0.2
    assert verdicts(evaluator, case(view))["on_track"][0] == "violated"  # type: ignore[index]


@BACKENDS
@pytest.mark.parametrize(
    ("number", "other"),
    [(1.0, True), (1.0, "1.0"), (np.float64(1.0), struct.pack("d", 1.0)), (np.float64(1.0), np.array([1.0]))],
)
def test_a_value_of_a_wrong_type_that_looks_the_same(
    spec: Spec, backend: str, number: object, other: object
) -> None:
    evaluator = Evaluator(spec, None, backend)
    left: list[Any] = [[number, 2.0], [9.0, 2.0]]
    assert isinstance(verdicts(evaluator, case(left)), dict)
    left[0][0] = other
    assert "D202" in verdicts(evaluator, case(left))


@BACKENDS
@pytest.mark.filterwarnings("ignore:Setting the")
def test_the_same_bytes_in_another_shape_or_type(spec: Spec, backend: str) -> None:
    evaluator = Evaluator(spec, None, backend)
    left = np.array([[1.0, 2.0], [9.0, 2.0], [10.0, 2.0], [20.0, 2.0]])
    before = verdicts(evaluator, case(left))
    left.shape = (2, 4)
    assert "not a list of points" in verdicts(evaluator, case(left))
    left.shape = (4, 2)
    assert verdicts(evaluator, case(left)) == before
    left.dtype = np.dtype(np.int64)  # type: ignore[misc]
    assert verdicts(evaluator, case(left)) == verdicts(Evaluator(spec, None, backend), case(left)) != before


@BACKENDS
def test_the_sign_of_a_zero_is_not_lost(spec: Spec, backend: str) -> None:
    evaluator = Evaluator(spec, None, backend)
    for zero in (0.0, -0.0, 0.0):
        read = evaluator.read(case([[zero, 2.0], [9.0, 2.0]]))
        assert math.copysign(1.0, read.line("track", "left").tuples[0][0]) == math.copysign(1.0, zero)


@BACKENDS
def test_overrides_changed_in_place(spec: Spec, backend: str) -> None:
    evaluator = Evaluator(spec, None, backend)
    pit = points()
    pit[0][1] = pit[2][1] = -2.0
    raw = {**case(points()), "places": {"pit": pit}}
    assert verdicts(evaluator, raw)["in_pit"][0] == "satisfied"  # type: ignore[index]
    pit[1][1] = -1.0
    assert verdicts(evaluator, raw)["in_pit"][0] == "violated"  # type: ignore[index]


@BACKENDS
def test_a_case_cannot_be_changed_where_its_geometry_is_kept(spec: Spec, backend: str) -> None:
    read = Evaluator(spec, None, backend).read({**case(points()), "places": {"pit": points()}})
    assert all(
        type(points) is tuple and set(map(type, points)) == {tuple}
        for points in read.settings.places.values()
    )
    for held in read.lines.values():
        with pytest.raises(ValueError, match="read-only"):
            held.points[0, 0] = 7.0
        with pytest.raises(ValueError, match="WRITEABLE"):
            held.points.flags.writeable = True
        with pytest.raises(AttributeError, match="does not change"):
            held.points = np.zeros((2, 2))
        with pytest.raises(AttributeError, match="does not change"):
            held.number = 7


# What need not be read again -----------------------------------------------------------------------------------------


@BACKENDS
def test_a_line_that_cannot_change_is_taken_as_it_is(spec: Spec, backend: str) -> None:
    left = line(points())
    evaluator = Evaluator(spec, None, backend)
    before = verdicts(evaluator, case(left))
    assert before == verdicts(evaluator, case(points()))
    assert evaluator.read(case(left)).line("track", "left") is left
    assert evaluator.read(case(points())).line("track", "left") is not left
    assert evaluator.read(case(left)).line("track", "left") is left
    assert verdicts(evaluator, case(left)) == before


@BACKENDS
def test_lines_that_were_made_otherwise_are_refused(spec: Spec, backend: str) -> None:
    """Somebody could write to their points, or they are none."""
    loose = np.array(points())
    frozen = np.array(points())
    frozen.flags.writeable = False
    for held in (loose, frozen, points(), np.zeros((2, 3)), None, line(points()).points.astype(np.float32)):
        assert "not a list of points" in verdicts(Evaluator(spec, None, backend), case(Line(held)))  # type: ignore[arg-type]


@BACKENDS
@pytest.mark.filterwarnings("ignore:Setting the")
def test_a_frozen_array_that_is_looked_at_otherwise(spec: Spec, backend: str) -> None:
    """Nobody can write to its memory; what it makes of it changes all the same."""
    evaluator = Evaluator(spec, None, backend)
    left = np.frombuffer(np.array([[1.0, 2.0], [9.0, 2.0], [10.0, 2.0], [20.0, 2.0]]).tobytes()).reshape(4, 2)
    before = verdicts(evaluator, case(left))
    assert verdicts(evaluator, case(left)) == before
    left.shape = (2, 4)
    assert "not a list of points" in verdicts(evaluator, case(left))
    left.shape = (4, 2)
    assert verdicts(evaluator, case(left)) == before
    left.dtype = np.dtype(np.int64)  # type: ignore[assignment, misc]
    assert verdicts(evaluator, case(left)) == verdicts(Evaluator(spec, None, backend), case(left)) != before


@BACKENDS
@pytest.mark.parametrize(
    "before", [points, lambda: line(points()), lambda: np.array(points()), lambda: None, lambda: "ab"]
)
def test_an_empty_border_is_not_the_one_before(spec: Spec, backend: str, before: Callable[[], Any]) -> None:
    empties: tuple[Any, ...] = (
        [],
        (),
        np.zeros((0, 2)),
        np.zeros((0, 2), np.float32),
        line(np.zeros((0, 2))),
    )
    for empty in empties:
        evaluator = Evaluator(spec, None, backend)
        verdicts(evaluator, case(before()))
        for _ in range(2):
            after = verdicts(evaluator, case(empty))
            assert isinstance(after, dict)
            assert after["on_track"][0] == "undefined"
            assert [str(f) for f in evaluator.read(case(empty)).faults] == ["D217 track.left: 0 points"]


def test_only_so_many_lines_are_kept(spec: Spec) -> None:
    reader = Evaluator(spec).reader
    many = [[[-9.0, 2.0 + k], [20.0, 2.0]] for k in range(3 * KEPT)]
    for _ in range(2):
        assert [reader.read(case(left)).line("track", "left").tuples[0][1] for left in many] == [
            2.0 + k for k in range(3 * KEPT)
        ]


@pytest.mark.parametrize("held", [list, tuple, np.array])
def test_a_case_that_was_read_does_not_change_any_more(
    spec: Spec, held: Callable[[list[float]], Any]
) -> None:
    raw = case(points())
    plan = raw["signals"]["plan"]
    raw["signals"]["plan"] = {name: held(column) for name, column in plan.items()}
    read = Evaluator(spec).read(raw)
    before = shown(read)
    for column in raw["signals"]["plan"].values():
        if not isinstance(column, tuple):
            column[1] = 7.0
    raw["signals"]["track"]["left"][1][1] = 0.2
    assert shown(read) == before


# One call, many cases ---------------------------------------------------------------------------------------------


class Lazy(Mapping[str, Any]):
    """A track that fills one list over and over, whenever it is asked."""

    def __init__(self, buffer: list[Any], lines: dict[str, list[list[float]]]) -> None:
        self.buffer, self.lines = buffer, lines

    def __getitem__(self, name: str) -> Any:
        self.buffer[:] = self.lines[name]
        return self.buffer

    def __iter__(self) -> Iterator[str]:
        return iter(self.lines)

    def __len__(self) -> int:
        return len(self.lines)


def test_cases_that_are_read_together_are_as_if_read_alone(spec: Spec) -> None:
    shared: Any = [[-9.0, 0.5], [20.0, 0.5]]
    raw = [case(points()), case(shared), case(np.array(points())), case(shared, line=shared)]
    evaluator = Evaluator(spec)
    together = evaluator.read_all(raw)
    assert [lines(one) for one in together] == [lines(Evaluator(spec).read(one)) for one in raw]
    shared[0][1] = 0.25
    assert [lines(one) for one in evaluator.read_all(raw)] == [
        lines(Evaluator(spec).read(one)) for one in raw
    ]
    many = [case([[-9.0, float(k)], [20.0, 2.0]]) for k in range(2 * AT_ONCE)]
    many[-1] = case([[-9.0, math.nan], [20.0, 2.0]])
    assert [lines(one) for one in evaluator.read_all(many)] == [
        lines(Evaluator(spec).read(one)) for one in many
    ]
    shared[0][1] = 0.125
    assert lines(evaluator.read(raw[1])) == lines(Evaluator(spec).read(raw[1]))


def test_the_first_case_that_cannot_be_read_is_named(spec: Spec) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        Evaluator(spec).read_all([case(points()), case("ab"), 3])
    assert "track.left" in caught.value.message


def test_a_mapping_that_changes_its_data_as_it_is_read(spec: Spec) -> None:
    borders = [{"left": [[0.0, y], [9.0, y]], "right": [[0.0, -y], [9.0, -y]]} for y in (2.0, 3.0, 4.0, 5.0)]
    buffer: list[Any] = [[0.0, 0.0], [9.0, 0.0]]
    raw = [case(buffer) for _ in borders]
    for one, border in zip(raw[1:], borders):
        one["signals"]["track"] = Lazy(buffer, border)
    together = Evaluator(spec).read_all(raw)
    assert [one.line("track", "left").tuples[0][1] for one in together] == [0.0, 2.0, 3.0, 4.0]
    assert [one.line("track", "right").tuples[0][1] for one in together] == [-2.0, -2.0, -3.0, -4.0]


def test_what_only_looks_like_an_array_is_none(spec: Spec) -> None:
    class Live:
        def tolist(self) -> list[list[float]]:
            return points()

    with pytest.raises(TrackmarshalError) as caught:
        Evaluator(spec).read(case(Live()))
    assert caught.value.code == "D202"


def test_cases_that_are_made_in_the_same_list_as_they_are_read(spec: Spec) -> None:
    def made() -> Iterator[dict[str, Any]]:
        left = points()
        for y in (2.0, 3.0, 4.0):
            left[1][1] = y
            yield case(left)

    assert [one.line("track", "left").tuples[1][1] for one in Evaluator(spec).read_all(made())] == [
        2.0,
        3.0,
        4.0,
    ]


# Any change -------------------------------------------------------------------------------------------------------

ODD = (0.0, -0.0, 1.0, 1, True, 2**70, math.nan, math.inf, None, "nan", "1", b"\0\0\0\0\0\0\xf0\x3f", [1.0], (1.0,),
       np.float64(1.0), np.float32(1.0), np.int64(1), np.array(1.0), np.array([1.0]), bytearray(8))  # fmt: skip
odd = st.sampled_from(ODD)
pairs = st.lists(odd, min_size=1, max_size=3)
change = st.one_of(
    st.tuples(st.just("value"), st.integers(0, 2), st.integers(0, 1), odd),
    st.tuples(st.just("point"), st.integers(0, 2), st.sampled_from((list, tuple, np.array)), pairs),
    st.tuples(st.just("more"), st.integers(0, 2), st.just(list), pairs),
    st.tuples(st.just("less"), st.integers(0, 2), st.none(), st.none()),
    st.tuples(st.just("nothing"), st.none(), st.none(), st.none()),
)


def apply(held: Any, kind: str, index: Any, how: Any, what: Any) -> None:
    """One change in place, where what holds the data allows it."""
    try:
        match kind:
            case "value":
                held[index][how] = what
            case "point":
                held[index] = how(what)
            case "more":
                held.insert(index, how(what))
            case "less":
                held.pop(index)
    except (TypeError, ValueError, AttributeError, IndexError, OverflowError):
        pass


def lines(read: Frame) -> tuple[str, list[str]]:
    return repr(sorted((place, line.tuples) for place, line in read.lines.items())), list(
        map(str, read.faults)
    )


def shown(read: Frame) -> str:
    columns = [
        (signal, [(name, found.listed(name)) for name in found.names.rows])
        for signal, found in read.columns.items()
    ]
    return repr((columns, lines(read), read.settings.places))


@settings(repeatable, max_examples=amount(27, 160))
@given(st.sampled_from(list(HOLDERS)), st.lists(change, min_size=1, max_size=6))
def test_whatever_is_changed_is_read_as_by_a_new_evaluator(
    spec: Spec, holder: str, changes: list[tuple[str, Any, Any, Any]]
) -> None:
    left = HOLDERS[holder]([[1.0, 0.0], [0.0, 1.0], [1.0, 2.0]])
    warm = Evaluator(spec)
    for one in [("nothing", None, None, None), *changes]:
        apply(left, *one)
        assert _read(warm, left) == _read(Evaluator(spec), left)


def _read(evaluator: Evaluator, left: Any) -> object:
    try:
        return lines(evaluator.read(case(left)))
    except TrackmarshalError as error:
        return str(error)
