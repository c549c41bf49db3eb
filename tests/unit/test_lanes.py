"""Maps of lanelets: what is refused, and stations, offsets, headings, distances and occupancy that are known by hand."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.shared import REPOSITORY
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, load
from trackmarshal.lanes import Lanelet, Network, Vehicle, cycle
from trackmarshal.lanes.box import touches
from trackmarshal.lanes.curve import Curve
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests

SPECS = REPOSITORY / "specs" / "interstate"


def strip(
    number: int, low: float, high: float, start: float = 0.0, end: float = 200.0, **more: Any
) -> Lanelet:
    """A straight lanelet along x, its right bound at y = low."""
    return Lanelet(number, [(start, high), (end, high)], [(start, low), (end, low)], **more)


CAR = Vehicle(1, 50.0, 5.25, 0.0, 20.0, 0.0, 5.0, 2.0)


def refused(*lanelets: Lanelet) -> TrackmarshalError:
    with pytest.raises(TrackmarshalError) as caught:
        Network(lanelets, "east.xml")
    assert caught.value.file == "east.xml"
    assert caught.value.help
    return caught.value


@pytest.mark.parametrize(
    ("lanelet", "said"),
    [
        (Lanelet(1, [(0, 1)], [(0, 0)]), "the left bound has 1 points"),
        (Lanelet(1, [(0, 1), (9, 1)], [(0, 0), (5, 0), (9, 0)]), "2 points on the left, 3 on the right"),
        (Lanelet(1, [(0, 1), (9, math.nan)], [(0, 0), (9, 0)]), "point 1 of the left bound is not finite"),
        (Lanelet(1, [(0, 1), "no"], [(0, 0), (9, 0)]), "the left bound is no list of points"),  # type: ignore[list-item]
        (Lanelet(1, [("0", "1"), ("9", "1")], [(0, 0), (9, 0)]), "the left bound is no list of points: not a number"),  # type: ignore[list-item]
        (Lanelet(1, [(0, True), (9, True)], [(0, 0), (9, 0)]), "the left bound is no list of points: not a number"),
        (Lanelet(1, np.array([(0, 5.3e6), (9, 5.3e6)], np.float32), [(0, 0), (9, 0)]), "float32 has no two numbers nearer than 0.5 m"),  # type: ignore[arg-type]
        (Lanelet(1, np.ma.masked_array([(0, 1), (9, 1)], [(False, False), (False, True)]), [(0, 0), (9, 0)]), "point 1 of the left bound is not finite"),  # type: ignore[arg-type]
        (Lanelet(1, [(0, 1), (9, -1)], [(0, 0), (9, 0)]), "the bounds cross"),
        (Lanelet(1, [(9, 1), (0, 1)], [(0, 0), (9, 0)]), "the bounds lead opposite ways"),
        (Lanelet(1, [(0, 0), (9, 0)], [(0, 1), (9, 1)]), "the left bound is not on the left"),
        (Lanelet(1, [(0, 0), (9, 0)], [(0, 0), (9, 0)]), "the left bound is not on the left"),
        (Lanelet(1, [(0, 1), (0, 1), (9, 1)], [(0, 0), (0, 0), (9, 0)]), "two pairs of points with one middle"),
        (strip(1, 0, 1, limit=math.inf), "a limit of inf"),
        (strip(1, 0, 1, limit=0.0), "a limit of 0.0"),
        (strip(-1, 0, 1), "no number of a lanelet"),
        (strip(True, 0, 1), "no number of a lanelet"),
    ],
)  # fmt: skip
def test_a_lanelet_that_is_none(lanelet: Lanelet, said: str) -> None:
    error = refused(lanelet)
    assert error.code == "D185"
    assert said in error.message


@pytest.mark.parametrize(
    ("lanelets", "said"),
    [
        ([], "there is no lanelet"),
        ([strip(1, 0, 1), strip(1, 1, 2)], "lanelet 1 stands twice"),
        ([strip(1, 0, 1, beside_left=2)], "lanelet 1 has 2 on its left, which the map does not have"),
        ([strip(1, 0, 1, beside_left=2), strip(2, 1, 2)], "which 2 does not say of 1"),
        ([strip(1, 0, 1, beside_left=2), strip(2, 1, 2, beside_left=1)], "which 2 does not say of 1"),
        ([strip(1, 0, 1, beside_left=2), strip(2, 1, 2, beside_right=1, along_right=False)], "which 2 does not say of 1"),
        ([strip(1, 0, 1, successors=(3,))], "leads to 3, which the map does not have"),
        ([strip(1, 0, 1, successors=(2,)), strip(2, 0, 1, 201.0, 300.0)], "begins 1 m from where it ends"),
    ],
)  # fmt: skip
def test_lanelets_that_do_not_fit(lanelets: list[Lanelet], said: str) -> None:
    error = refused(*lanelets)
    assert error.code == "D186"
    assert said in error.message


def test_a_circle_has_no_beginning() -> None:
    def part(number: int, begin: float, onwards: int) -> Lanelet:
        turns = np.linspace(begin, begin + math.pi, 20)
        inner, outer = ([(r * math.cos(u), r * math.sin(u)) for u in turns] for r in (50.0, 54.0))
        return Lanelet(number, inner, outer, (onwards,))

    assert (
        refused(part(1, 0.0, 2), part(2, math.pi, 1)).message == "lanelet 1 is in a circle, or led to by one"
    )
    feeder = Lanelet(3, [(50, -30), (50, 0)], [(54, -30), (54, 0)], (1,))
    assert "in a circle" in refused(feeder, part(1, 0.0, 2), part(2, math.pi, 1)).message


def test_opposite_neighbours_name_each_other_on_their_left() -> None:
    there = strip(1, 0, 3, beside_left=2, along_left=False)
    back = Lanelet(2, [(200, 3), (0, 3)], [(200, 6), (0, 6)], beside_left=1, along_left=False)
    assert Network([there, back]).roads == {1: 1, 2: 1}


def test_lanes_are_ways_through_the_map() -> None:
    fork = [
        strip(1, 0, 3, 0, 50, successors=(2, 3)), strip(2, 0, 3, 50, 90), strip(4, 5, 8),
        Lanelet(3, [(50, 3), (90, -7)], [(50, 0), (90, -10)]),
    ]  # fmt: skip
    assert [lane.lanelets for lane in Network(fork).lanes] == [(1, 2), (1, 3), (4,)]


def test_before_lanes_part_a_vehicle_is_in_both() -> None:
    """As docs/interstate.md warns of; where the exit begins beside the lane, it is in one."""
    other = Vehicle(1, 20.0, 1.5, 0.0, 20.0, 0.0, 5.0, 2.0)
    exit_ = Lanelet(3, [(50, 3), (90, -7)], [(50, 0), (90, -10)])
    for successors, lanes in (((2, 3), 2), ((2,), 1)):
        road = Network(
            [strip(1, 0, 3, 0, 50, successors=successors), strip(2, 0, 3, 50, 90), exit_], "with an exit"
        )
        assert len(cycle(road, 0.0, 1, [other])["signals"]["occupied"]) == lanes


def test_too_many_ways() -> None:
    """Ten forks in a row that join again are 1,024 lanes."""
    parts = []
    for k in range(11):
        onwards = (2 * k + 2, 2 * k + 3) if k < 10 else ()
        parts += [strip(2 * k + side, 0, 3, 10.0 * k, 10.0 * k + 10, successors=onwards) for side in (0, 1)]
    assert "more than 1000 lanes" in refused(*parts).message


def test_places_beside_a_straight_line_and_beyond_its_ends() -> None:
    line = Curve(np.array([[0.0, 0.0], [10.0, 0.0], [30.0, 0.0]]))
    s, d, heading = line.places(np.array([[12.0, 2.0], [-3.0, -1.0], [35.0, 0.5]]))
    assert s.tolist() == [12.0, -3.0, 35.0]
    assert d.tolist() == [2.0, -1.0, 0.5]
    assert heading.tolist() == [0.0, 0.0, 0.0]


def test_a_single_piece_goes_on_at_both_ends() -> None:
    s, d, _ = Curve(np.array([[0.0, 0.0], [0.0, 10.0]])).places(np.array([[-1.0, -5.0], [2.0, 15.0]]))
    assert s.tolist() == [-5.0, 15.0]
    assert d.tolist() == [1.0, -2.0]


def test_places_beside_an_arc_are_those_of_the_circle() -> None:
    """Radius 900 m around the origin, counter-clockwise through the heading of 180 degrees: a chord of 5 m is off by 3.5 mm."""
    radius, turn = 900.0, np.linspace(0.3, 2.0, 307)
    curve = Curve(radius * np.stack([np.cos(turn), np.sin(turn)], axis=1))
    at = np.linspace(0.4, 1.9, 400)
    for offset in (-3.0, 0.0, 3.0):
        s, d, heading = curve.places((radius - offset) * np.stack([np.cos(at), np.sin(at)], axis=1))
        assert np.abs(s - radius * (at - 0.3)).max() < 0.02
        assert np.abs(d - offset).max() < 0.004
        wrong = np.remainder(heading - (at + math.pi / 2) + math.pi, 2 * math.pi) - math.pi
        assert np.abs(wrong).max() < 1e-4  # nowhere turned round, where the direction passes 180 degrees


@pytest.mark.parametrize(
    ("centre", "heading", "touched"),
    [
        ((5, 1), 0.0, True),  # inside, far from all edges
        ((5, 11), 0.0, True),  # an edge through it
        ((5, 12), 0.0, True),  # a side on an edge
        ((5, 12.001), 0.0, False),
        ((12.5, 5), 0.0, True),
        ((12.501, 5), 0.0, False),
        ((11, 11), math.pi / 4, True),  # a box that reaches past a corner
        ((12, 12), math.pi / 4, False),  # only the boxes around both overlap
        ((30, 5), 0.0, False),  # in the notch of the outline
    ],
)  # fmt: skip
def test_what_a_box_touches(centre: tuple[float, float], heading: float, touched: bool) -> None:
    """A U of 10 m by 10 m blocks, open to the right of x = 10 above y = 0: not convex."""
    outline = np.array(
        [(0, 10), (10, 10), (10, 0), (40, 0), (40, 10), (50, 10), (50, -10), (0, -10)], dtype=float
    )
    if centre[0] == 30:
        assert touches(np.array([30.0, -1.0]), 0.0, np.array([5.0, 4.0]), outline)
    assert touches(np.array(centre, dtype=float), heading, np.array([5.0, 4.0]), outline) is touched


def test_a_box_that_holds_the_whole_outline() -> None:
    small = np.array([(0.0, 0.0), (0.1, 0.0), (0.1, 0.1)])
    assert touches(np.array([0.0, 0.0]), 0.3, np.array([5.0, 4.0]), small)


def signals(*vehicles: Vehicle, lanelets: list[Lanelet] | None = None, **more: Any) -> dict[str, Any]:
    found: dict[str, Any] = cycle(Network(lanelets or ROAD_OF_TWO), 0.0, 1, vehicles, **more)["signals"]
    return found


ROAD_OF_TWO = [
    strip(7, 3.5, 7.0, beside_right=8, main=True, limit=30.0), strip(8, 0.0, 3.5, beside_left=7, beside_right=9, main=True),
    strip(9, -3.0, 0.0, beside_left=8, ramp=True),
]  # fmt: skip


def test_a_cycle_by_hand() -> None:
    """Lanes along x: 0 is lanelet 7, 1 is 8, 2 is 9. The ego in the left one; another one over the line below it."""
    other = Vehicle(2, 80.0, 3.0, 0.0, 10.0, -1.0, 5.0, 2.0, truck=True)
    found = signals(CAR, other)
    assert found["ego_vehicle"] == {"number": 1}
    assert [(o["number"], o["v"], o["a"], o["truck"]) for o in found["vehicles"]] == [
        (1, 20.0, 0.0, False),
        (2, 10.0, -1.0, True),
    ]
    assert found["own"] == [
        {"vehicle": 1, "lane": 0, "front": 52.5, "rear": 47.5, "left": 1.0, "right": -1.0, "offset": 0.0, "heading": 0.0},
        {"vehicle": 2, "lane": 1, "front": 82.5, "rear": 77.5, "left": 2.25, "right": 0.25, "offset": 1.25, "heading": 0.0},
    ]  # fmt: skip
    seen = {(o["vehicle"], o["lane"]): o["offset"] for o in found["places"]}
    assert seen == {(1, 0): 0.0, (1, 1): 3.5, (1, 2): 6.75, (2, 0): -2.25, (2, 1): 1.25, (2, 2): 4.5}
    assert [(o["vehicle"], o["lane"], o["to_left"], o["to_right"]) for o in found["occupied"]] == [
        (1, 0, 0.75, 0.75), (2, 0, 3.0, 0.5), (2, 1, 0.5, 2.0),
    ]  # fmt: skip
    assert [(o["vehicle"], o["lanelet"]) for o in found["touched"]] == [(1, 7), (2, 7), (2, 8)]
    assert [(o["number"], o["road"], o["left"], o["right"], o["width"], o["limited"], o["limit"]) for o in found["lanelets"]] == [
        (7, 7, -1, 8, 3.5, True, 30.0), (8, 7, 7, 9, 3.5, False, 0.0), (9, 7, 8, -1, 3.0, False, 0.0),
    ]  # fmt: skip


def test_own_lane_as_told() -> None:
    other = Vehicle(2, 80.0, 3.0, 0.0, 10.0, -1.0, 5.0, 2.0)
    assert [o["lane"] for o in signals(CAR, other, own={2: 0})["own"]] == [0, 0]


def test_across_a_lane() -> None:
    """Turned by a quarter: 5 m wide and 2 m long, as the lane sees it."""
    (own,) = signals(replace(CAR, heading=math.pi / 2))["own"]
    assert own["front"] - own["rear"] == pytest.approx(2.0)
    assert own["left"] - own["right"] == pytest.approx(5.0)
    assert own["heading"] == pytest.approx(math.pi / 2)


@pytest.mark.parametrize(
    ("vehicles", "said"),
    [
        ([replace(CAR, number=2)], "the ego, 1, is none of the vehicles"),
        ([CAR, CAR], "vehicle 1 stands twice"),
        ([replace(CAR, number=-1)], "no number of a vehicle"),
        ([replace(CAR, v=math.nan)], "vehicle 1 has a v of nan"),
        ([replace(CAR, width=0.0)], "vehicle 1 has a width of 0.0"),
        ([CAR, replace(CAR, number=2, y=30.0)], "vehicle 2 touches no lanelet"),
        (
            [CAR, replace(CAR, number=2, y=np.float32(5.3e6))],  # type: ignore[arg-type]
            "vehicle 2: float32 has no two numbers nearer than 0.5 m",
        ),
    ],
)
def test_vehicles_that_are_refused(vehicles: list[Vehicle], said: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        cycle(Network(ROAD_OF_TWO, "east.xml"), 0.0, 1, vehicles)
    assert (caught.value.code, caught.value.file) == ("D187", "east.xml")
    assert said in caught.value.message


def test_own_lane_that_the_map_does_not_have() -> None:
    with pytest.raises(TrackmarshalError, match="in lane 3"):
        signals(CAR, own={1: 3})


# Rules over runs: what inline tests, of one cycle, cannot show ------------------------------------------------------


def verdicts(
    rule: str, cycles: list[list[Vehicle]], lanelets: list[Lanelet], backend: str, step: float = 1.0
) -> str:
    """By cycle, what was decided in the end: one letter each."""
    network, evaluator = Network(lanelets), Evaluator(load(SPECS), [rule], backend=backend)
    run, found = evaluator.over_run(), [""] * len(cycles)
    for k, vehicles in enumerate(cycles):
        result = run.step(evaluator.read({"id": k, **cycle(network, k * step, 1, vehicles)})).rules[rule]
        for about in result.about:
            found[about.cycle] = about.verdict  # type: ignore[call-overload]
        if not result.about:
            found[k] = result.verdict
    for about in run.end().get(rule, ()):
        found[about.cycle] = about.verdict  # type: ignore[call-overload]
    return "".join(verdict[0] for verdict in found)


BACKENDS = ("reference", "numpy")


@pytest.mark.parametrize("backend", [*BACKENDS, "c"])
def test_a_cut_in_is_excused_for_three_seconds(backend: str) -> None:
    """It comes over the line in the cycle of 2 s, heading right into the ego's lane, and is in it from 3 s on, too near all the time."""
    ego = Vehicle(1, 20.0, 1.75, 0.0, 20.0, 0.0, 5.0, 2.0)
    way = [5.25, 5.25, 3.5, 1.75, 1.75, 1.75, 1.75]
    turns = [0.0, 0.0, -0.05, 0.0, 0.0, 0.0, 0.0]
    cycles = [[ego, Vehicle(2, 28.0, y, turn, 20.0, 0.0, 5.0, 2.0)] for y, turn in zip(way, turns)]
    assert verdicts("R_G1", cycles, ROAD_OF_TWO, backend) == "iiiiiiv"
    apart = [[ego, replace(other, heading=0.05 if other.heading else 0.0)] for _, other in cycles]
    assert verdicts("R_G1", apart, ROAD_OF_TWO, backend) == "iivvvvv"


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_change_to_the_right_beside_one_that_enters(backend: str) -> None:
    """The other one leaves the ramp in the cycle of 4 s; the ego is over the line to the right lane from `change` on."""

    def cycles(change: int, enters: int = 4) -> list[list[Vehicle]]:
        return [
            [
                Vehicle(1, 20.0, 5.25 if k < change else 1.75, 0.0, 20.0, 0.0, 5.0, 2.0),
                Vehicle(2, 60.0, -1.5 if k < enters else 0.5, 0.0, 15.0, 0.0, 5.0, 1.8),
            ]
            for k in range(9)
        ]

    assert verdicts("R_I5", cycles(3), ROAD_OF_TWO, backend) == "vvvssssss"
    assert verdicts("R_I5", cycles(99), ROAD_OF_TWO, backend) == "sssssssss"
    # From the cycle in which it is decided that it enters within five seconds.
    assert verdicts("R_I5", cycles(3, enters=7), ROAD_OF_TWO, backend) == "ssvssssss"
    assert verdicts("R_I5", cycles(3, enters=99), ROAD_OF_TWO, backend) == "sssssssss"


def test_the_page_about_it_says_what_comes_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (REPOSITORY / "docs" / "interstate.md").read_text("utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (said,) = re.findall(r"```text\n(.*?)```", page, re.DOTALL)
    (tmp_path / "specs").symlink_to(REPOSITORY / "specs")
    monkeypatch.chdir(tmp_path)
    exec(compile(program, "docs/interstate.md", "exec"), {})
    assert capsys.readouterr().out == said


def test_the_inline_tests_of_the_rulebook() -> None:
    compiled = compile_paths([SPECS], REPOSITORY)
    tests, _ = prepare(compiled)
    outcomes = list(run_tests(compiled.spec, tests))
    assert len(outcomes) >= 45
    assert [(o.test.title, o.message) for o in outcomes if o.outcome != "passed"] == []


def test_importing_costs_nothing() -> None:
    program = "import sys, trackmarshal.lanes.codes; print('numpy' in sys.modules); from trackmarshal.lanes import cycle; print(callable(cycle))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "False\nTrue\n"


def test_both_bounds_of_a_successor_begin_where_the_lanelet_ends() -> None:
    ahead = Lanelet(2, [(100.0, 2.0), (200.0, 2.0)], [(100.0, -3.0), (200.0, -3.0)])
    behind = Lanelet(1, [(0.0, 2.0), (100.0, 2.0)], [(0.0, -2.0), (100.0, -2.0)], successors=(2,))
    assert "begins 1 m from where it ends" in refused(behind, ahead).message


def test_bounds_lead_the_same_way_as_a_whole() -> None:
    """Of each pair of pieces, neither leads against the other; the left bound goes up by 10 m, the right one down by 5 m."""
    bent = Lanelet(1, [(0.0, 0.0), (1.0, 0.0), (1.0, 10.0)], [(0.0, -2.0), (0.0, -7.0), (5.0, -7.0)])
    assert "the bounds lead opposite ways" in refused(bent).message


def test_a_size_that_a_short_float_has_rounded_is_none() -> None:
    road = Network([Lanelet(1, [(0.0, 9.0), (100.0, 9.0)], [(0.0, 0.0), (100.0, 0.0)])])
    long = replace(CAR, length=np.float16(40.0))  # type: ignore[arg-type]
    with pytest.raises(TrackmarshalError, match="vehicle 1: ") as caught:
        cycle(road, 0.0, 1, [long])
    assert caught.value.code == "D187"


def test_nobody_is_its_own_neighbour_or_one_on_both_sides() -> None:
    """Each names the other, and so both were taken."""
    own = Lanelet(1, [(0.0, 2.0), (9.0, 2.0)], [(0.0, -2.0), (9.0, -2.0)])
    other = Lanelet(2, [(0.0, 6.0), (9.0, 6.0)], [(0.0, 2.0), (9.0, 2.0)], beside_left=1, beside_right=1)
    assert "has itself on its left" in refused(replace(own, beside_left=1, along_left=False)).message
    assert "has 2 on both sides" in refused(replace(own, beside_left=2, beside_right=2), other).message
