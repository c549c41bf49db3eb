"""Properties of geometry on generated corridors: narrow, bulging, with walls and posts, near and far, for poses of all kinds."""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from trackmarshal.backends.reference import geometry as reference
from trackmarshal.backends.reference.geometry import corridor, region
from trackmarshal.points import Segment, distance, segment
from trackmarshal.runtime import geometry as fast

Point = tuple[float, float]
Pose = tuple[float, float, float]

#: Of corridors on which the least of all ways is looked for.
EXAMPLES = int(os.environ.get("TRACKMARSHAL_EXAMPLES", "16"))
unhurried = settings(deadline=None)

small = st.floats(-1.0, 1.0)
headings = st.floats(-7.0, 7.0)
sizes = st.tuples(st.floats(0.2, 12.0), st.floats(0.2, 4.0))


@st.composite
def corridors(draw: st.DrawFn) -> tuple[list[Point], list[Point]]:
    """Borders along a winding way; some of their points are pushed across, as bulges, walls or spikes."""
    count = draw(st.integers(3, 14))
    bends = draw(st.lists(small, min_size=count, max_size=count))
    steps = draw(st.lists(st.floats(0.3, 20.0), min_size=count, max_size=count))
    half = draw(st.floats(1.0, 8.0))
    x = y = heading = 0.0
    borders: tuple[list[Point], list[Point]] = ([], [])
    for bend, step in zip(bends, steps):
        for side, border in ((1.0, borders[0]), (-1.0, borders[1])):
            push = draw(st.sampled_from([0.0, 0.0, 0.0, 0.0, 0.5, 0.9, -0.4])) * half
            reach = side * (half - push)
            border.append((x - reach * math.sin(heading), y + reach * math.cos(heading)))
        heading += 0.5 * bend
        x, y = x + step * math.cos(heading), y + step * math.sin(heading)
    return borders


@st.composite
def moves(draw: st.DrawFn, borders: tuple[list[Point], list[Point]]) -> tuple[Pose, Pose]:
    """Two poses: about the middle of the way mostly, anywhere sometimes; the second near the first mostly."""
    k = draw(st.integers(0, len(borders[0]) - 1))
    (lx, ly), (rx, ry) = borders[0][k], borders[1][k]
    across = draw(st.floats(-0.5, 1.5))
    x, y = lx + across * (rx - lx) + 3.0 * draw(small), ly + across * (ry - ly) + 3.0 * draw(small)
    heading = draw(headings)
    if draw(st.booleans()):
        heading = math.atan2(ry - ly, rx - lx) + math.pi / 2 + 0.2 * draw(small)
    length, turn = (
        draw(st.sampled_from([0.0, 0.5, 2.5, 2.5, 30.0])),
        draw(st.sampled_from([0.0, 0.1, 0.1, 2.0])) * draw(small),
    )
    way = heading + draw(st.sampled_from([0.0, 0.05, 1.0])) * draw(small)
    return (x, y, heading), (x + length * math.cos(way), y + length * math.sin(way), heading + turn)


def margins(
    borders: tuple[list[Point], list[Point]], move: tuple[Pose, Pose], body: tuple[float, float]
) -> tuple[float, float]:
    expected = reference.hull_inside_margin(*borders, False, *move, *body)
    found = float(fast.Corridor(*borders).margin_inside(*move[0], *move[1], *body)[0])
    return expected, found


@unhurried
@given(st.data(), corridors(), sizes)
def test_fast_is_the_reference(
    data: st.DataObject, borders: tuple[list[Point], list[Point]], body: tuple[float, float]
) -> None:
    corridor = fast.Corridor(*borders)
    assert corridor.fault == reference.corridor_fault(*borders, False)
    expected, found = margins(borders, data.draw(moves(borders)), body)
    assert math.isnan(found) == math.isnan(expected) == (corridor.fault is not None)
    if not math.isnan(found):
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)
        assert (found >= 0.0) == (expected >= 0.0) or max(abs(found), abs(expected)) < 1e-12


whole = st.integers(-6, 6).map(float)


@unhurried
@given(
    st.lists(st.tuples(whole, whole), min_size=3, max_size=9),
    st.tuples(whole, whole),
    st.tuples(whole, whole),
    st.sampled_from([0.0, math.pi / 2, math.atan2(3.0, 4.0), math.pi / 4]),
    st.tuples(st.sampled_from([1.0, 2.0, 4.0]), st.sampled_from([0.5, 1.0, 2.0])),
)
def test_fast_is_the_reference_where_everything_touches(
    ring: list[Point], start: Point, end: Point, heading: float, body: tuple[float, float]
) -> None:
    zone = fast.Polygon(ring)
    assert zone.fault == reference.zone_fault(ring)
    expected = reference.hull_margin_in(reference.region_of(ring), (*start, heading), (*end, heading), *body)
    found = float(zone.margin_inside(*start, heading, *end, heading, *body)[0])
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9, nan_ok=True)
    if heading == 0.0:  # then all coordinates are exact, and so is the verdict
        assert (found >= 0.0) == (expected >= 0.0)
    point = reference.in_zone_margin(*start, ring)
    assert np.array_equal(zone.signed_distance(*start), [point], equal_nan=True)


@unhurried
@given(st.data(), corridors(), sizes)
def test_many_at_once_are_each_by_itself(
    data: st.DataObject, borders: tuple[list[Point], list[Point]], body: tuple[float, float]
) -> None:
    several = data.draw(st.lists(moves(borders), min_size=1, max_size=6))
    corridor = fast.Corridor(*borders)
    rows = [(*start, *end) for start, end in several]
    broken = data.draw(st.sampled_from([math.nan, math.inf, -math.inf, 1e300]))
    rows.insert(len(rows) // 2, (*rows[0][:3], *rows[0][3:5], broken))
    together = corridor.margin_inside(*np.array(rows).T, *body)
    alone = np.concatenate([corridor.margin_inside(*row, *body) for row in rows])
    assert np.array_equal(together, alone, equal_nan=True)
    assert math.isnan(together[len(several) // 2])


@st.composite
def trajectories(draw: st.DrawFn, borders: tuple[list[Point], list[Point]], count: int) -> list[Pose]:
    """So many poses, each near the one before; now and then somewhere else at once, or nowhere."""
    poses: list[Pose] = []
    while len(poses) < count:
        start, end = draw(moves(borders))
        if not poses or draw(st.integers(0, 9)) == 0:
            poses.append(start)
            continue
        if draw(st.integers(0, 19)) == 0:
            poses.append(draw(st.sampled_from([(math.nan, 0.0, 0.0), (0.0, 1e300, 0.0), (2e5, -3e6, 1.0)])))
            continue
        poses.append(tuple(p + b - a for p, a, b in zip(poses[-1], start, end)))  # type: ignore[arg-type]
    return poses


@pytest.mark.parametrize("curved", [False, True])
@settings(deadline=None, max_examples=EXAMPLES)
@given(data=st.data(), borders=corridors(), body=sizes, trips=st.integers(1, 4), count=st.integers(1, 12))
def test_the_least_of_each_trajectory_is_exact(
    curved: bool,
    data: st.DataObject,
    borders: tuple[list[Point], list[Point]],
    body: tuple[Any, ...],
    trips: int,
    count: int,
) -> None:
    corridor = fast.Corridor(*borders)
    poses = np.array([data.draw(trajectories(borders, count)) for _ in range(trips)])
    before = np.concatenate([poses[:, :1], poses[:, :-1]], axis=1)
    if data.draw(st.integers(0, 4)) == 0:  # hulls that do not begin where the ones before end
        before = before[:, ::-1]
    lengths = np.array([data.draw(st.integers(0, count)) for _ in range(trips)])
    counted = np.arange(count) < lengths[:, None]
    columns = [*before.reshape(-1, 3).T, *poses.reshape(-1, 3).T]
    if curved:  # bends that reach far beyond the hulls of some trajectories, and not of others
        bends = st.lists(
            st.sampled_from([0.0, 0.01, -0.05, 0.1]), min_size=2 * trips * count, max_size=2 * trips * count
        )
        body = (*body, *np.array(data.draw(bends)).reshape(2, -1))
    truth = corridor.margin_inside(*columns, *body).reshape(trips, count)
    found, exact = corridor.least_inside((*columns, *body), count, counted.ravel())
    found, exact = found.reshape(trips, count), exact.reshape(trips, count)
    assert np.array_equal(found[exact], truth[exact], equal_nan=True)
    assert exact[counted & np.isnan(truth)].all()
    for row in range(trips):
        own = truth[row, : lengths[row]]
        least = np.fmin.reduce(own, initial=np.inf)
        assert np.fmin.reduce(found[row, : lengths[row]], initial=np.inf) == least
        assert (found[row, : lengths[row]][~exact[row, : lengths[row]]] > least).all()


def fine(y: float) -> list[Point]:
    """A straight border of short segments."""
    return [(0.1 * k, y) for k in range(-200, 401)]


@pytest.mark.parametrize("bend", [(0.1, 0.1), (0.1, -0.1)])  # in one piece; in several
def test_the_least_may_be_that_of_a_way_whose_hull_is_farther_away(bend: tuple[float, float]) -> None:
    """A way's curvature takes room: the straight hull's distance is no bound of it. The last way bends, 0.3 m farther off."""
    corridor = fast.Corridor(fine(7.0), fine(-7.0))
    x, y, turned = np.array([0.0, 10.0, 20.0, 30.0]), np.array([3.3, 3.3, 3.0, 3.0]), np.zeros(3)
    way = (x[:-1], y[:-1], turned, x[1:], y[1:], turned)
    first, last = (np.array([0.0, 0.0, kappa]) for kappa in bend)
    body = (4.7, 2.8, first, last)
    truth = corridor.margin_inside(*way, *body)
    assert truth[2] < truth[:2].min() - 0.1 < corridor.margin_inside(*way, *body[:2])[2]
    found, exact = corridor.least_inside((*way, *body), 3, np.ones(3, dtype=np.bool_))
    assert exact[2]
    assert found.min() == truth[2]


@unhurried
@given(st.data(), corridors(), st.tuples(st.floats(0.2, 2.0), st.floats(0.2, 1.0)))
def test_inside_means_that_every_corner_and_every_pose_between_is(
    data: st.DataObject, borders: tuple[list[Point], list[Point]], body: tuple[float, float]
) -> None:
    start, end = data.draw(moves(borders))
    if data.draw(st.booleans()):
        end = (*end[:2], start[2])
    margin = margins(borders, (start, end), body)[1]
    if not margin >= 0.0:
        return
    ring = [*borders[0], *borders[1][::-1]]
    for pose in (start, end):
        for corner in reference.footprint(pose, *body):
            assert reference.in_zone_margin(*corner, ring) >= margin - 1e-9
    t = data.draw(st.floats(0.0, 1.0))
    if start[2] == end[2]:  # without turning, what is swept is what the footprints in between cover
        between = (start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1]), start[2])
        assert margins(borders, (between, between), body)[1] >= margin - 1e-9


@unhurried
@given(st.data(), corridors(), sizes, st.floats(1.0, 2.0), st.floats(1.0, 2.0))
def test_a_larger_vehicle_has_no_larger_margin(
    data: st.DataObject,
    borders: tuple[list[Point], list[Point]],
    body: tuple[float, float],
    longer: float,
    wider: float,
) -> None:
    move = data.draw(moves(borders))
    margin = margins(borders, move, body)[1]
    larger = margins(borders, move, (body[0] * longer, body[1] * wider))[1]
    assume(not math.isnan(margin))
    if margin >= 0.0:
        assert larger <= margin + 1e-9
    else:
        assert larger < 1e-9


@unhurried
@given(st.data(), corridors(), sizes, headings, st.tuples(small, small))
def test_rigid_motions_change_nothing(
    data: st.DataObject,
    borders: tuple[list[Point], list[Point]],
    body: tuple[float, float],
    turn: float,
    shift: Point,
) -> None:
    move = data.draw(moves(borders))
    cos, sin = math.cos(turn), math.sin(turn)

    def moved(x: float, y: float) -> Point:
        return cos * x - sin * y + 1000.0 * shift[0], sin * x + cos * y + 1000.0 * shift[1]

    left, right = ([moved(*point) for point in border] for border in borders)
    poses = tuple((*moved(x, y), heading + turn) for x, y, heading in move)
    corridor, elsewhere = fast.Corridor(*borders), fast.Corridor(left, right)
    assume(corridor.fault is None and elsewhere.fault is None)
    margin = float(corridor.margin_inside(*move[0], *move[1], *body)[0])
    other = float(elsewhere.margin_inside(*poses[0], *poses[1], *body)[0])
    if min(abs(margin), abs(other)) > 1e-6:
        assert other == pytest.approx(margin, rel=1e-6, abs=1e-6)


@unhurried
@given(st.data(), corridors(), sizes)
def test_both_directions_are_the_same_sweep(
    data: st.DataObject, borders: tuple[list[Point], list[Point]], body: tuple[float, float]
) -> None:
    start, end = data.draw(moves(borders))
    there, back = margins(borders, (start, end), body)[1], margins(borders, (end, start), body)[1]
    assert back == pytest.approx(there, rel=1e-9, abs=1e-9, nan_ok=True)


poses = st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0), headings)


@unhurried
@given(poses, poses, sizes, poses, sizes)
def test_clearance(
    start: Pose, end: Pose, body: tuple[float, float], box: Pose, size: tuple[float, float]
) -> None:
    expected = reference.clear_margin(start, end, *body, box, *size)
    found = float(fast.boxes_clear(*start, *end, *body, *box, *size))
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)
    back = float(fast.sweeps_clear(*box, *box, *size, *start, *end, *body))
    assert back == pytest.approx(found, rel=1e-9, abs=1e-9)
    for pose in (start, end):  # what is swept holds both footprints
        assert found <= float(fast.boxes_clear(*pose, *pose, *body, *box, *size)) + 1e-9


lines = st.lists(st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)), min_size=2, max_size=20)


@unhurried
@given(lines, st.booleans(), st.tuples(st.floats(-80.0, 80.0), st.floats(-80.0, 80.0)))
def test_curvilinear_coordinates(line: list[Point], closed: bool, point: Point) -> None:
    made = fast.Polyline(line, closed)
    assert made.fault == reference.line_fault(line, closed)
    expected = reference.project(*point, line, closed)
    found = tuple(float(part[0]) for part in made.project(*point))
    assert np.array_equal(found, expected, equal_nan=True)
    assume(made.fault is None)
    assert float(made.distance(*point)[0]) == reference.distance_to_line(*point, line, closed)
    if closed:
        assert 0.0 <= found[0] < made.length
        assert abs(float(made.gap(found[0], found[0] + 0.3 * made.length)[0]) - 0.3 * made.length) < 1e-6


def all_of(
    stretches: list[region.Seen], body: region.Body, known: float, largest: float
) -> list[tuple[float, Segment]]:
    return [(0.0, segment(a, b, body.first[:2])) for _, part in stretches for a, b in part]


def gap_to_all(
    body: region.Body,
    hull: list[Segment],
    border: list[tuple[float, Segment]],
    known: float,
) -> float:
    corners, segments = body.corners, [s for _, s in border]
    from_corners = [distance(*corner, s) for corner in corners for s in segments]
    from_border = [distance(s.ax, s.ay, edge) for s in segments for edge in hull]
    return min(from_corners + from_border)


@unhurried
@given(
    st.data(),
    corridors(),
    sizes,
    st.integers(1, 5),
    st.sampled_from([0.0, 0.0, 1e3, 4e6, 9e8]),
    st.sampled_from([1.0, 1.0, 1e-3, 50.0]),
)
def test_what_the_reference_leaves_out_of_a_border_changes_no_bit(
    data: st.DataObject,
    borders: tuple[list[Point], list[Point]],
    body: tuple[float, float],
    stretch: int,
    away: float,
    scale: float,
) -> None:
    left, right = (tuple((scale * x + away, scale * y - away) for x, y in border) for border in borders)
    (x0, y0, h0), (x1, y1, h1) = data.draw(moves(borders))
    poses = (scale * x0 + away, scale * y0 - away, h0), (scale * x1 + away, scale * y1 - away, h1)
    made = corridor.corridor_region(left, right, False)
    assume(not isinstance(made, str))
    assert isinstance(made, region.Region)
    for kind in (region.Region, region.Outside):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(region, "STRETCH", stretch)
            found = region.hull_margin(kind(made.border, made.groups), *poses, *body)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(region, "near", all_of)
            patch.setattr(region, "gap", gap_to_all)
            assert (
                found.hex()
                == region.hull_margin(
                    made if kind is region.Region else kind(made.border, made.groups), *poses, *body
                ).hex()
            )
