"""The fast geometry against the reference, against the oracles and against shapely, on tracks of all kinds.

Both implementations compute distances with the same formulas in the same order, so their results are the same doubles
wherever numpy and libm agree on the sines and cosines of the headings; where they do not, they differ by rounding. Another
exception: corners of the two footprints that lie on one line up to rounding, where the implementations may keep or leave out
a corner of the hull.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from support.bodies import BOTH, Geometry, same_trigonometry
from support.shared import oracle, shared
from support.tracks import Borders, eight, loop, oval, race_line, scenario_borders
from trackmarshal.backends.reference import geometry as reference
from trackmarshal.runtime import geometry as fast

BODY = (4.7, 2.0)
Floats = NDArray[np.float64]

both = pytest.mark.parametrize("geometry", BOTH.values(), ids=BOTH.keys())


def cases(kind: str) -> list[dict[str, Any]]:
    found = [case for case in oracle("seed_dev.json")["cases"] if case["kind"] == kind]
    assert found
    return found


@both
def test_boxes_of_the_oracle(geometry: Geometry) -> None:
    for case in cases("rect_rect"):
        given, expected = case["inputs"], case["expect"]
        ego = tuple(given["ego"])
        margin = geometry.clear(ego, ego, given["ego_size"], tuple(given["obstacle"]), given["obstacle_size"])
        assert (margin < 0.0) == expected["collides"], case["id"]
        if margin < 0.0:
            assert margin == pytest.approx(expected["sat_gap"], rel=1e-9), case["id"]
        else:
            assert margin >= expected["sat_gap"] * (1.0 - 1e-9), case[
                "id"
            ]  # the distance along one axis is no more


@both
def test_corridors_of_the_oracle(geometry: Geometry) -> None:
    for case in cases("corridor"):
        given, expected = case["inputs"], case["expect"]
        left, right, pose = given["ring"][:40], given["ring"][40:][::-1], tuple(given["pose"])
        margin = geometry.inside(left, right, pose, pose, given["size"])
        assert (margin >= 0.0) == expected["inside"], case["id"]
        if expected["inside"]:
            assert margin == pytest.approx(expected["clearance"], rel=1e-9), case["id"]


def around(borders: Borders, count: int, seed: int, scatter: float = 1.5) -> Floats:
    """Pairs of poses on and beside a track, (6, count)."""
    generator = np.random.default_rng(seed)
    left, right = np.array(borders[0]), np.array(borders[1])
    middle = fast.Corridor(left, right).centre.points[:-1]
    ahead = fast.Corridor(left, right).centre.points[1:] - middle
    k = generator.integers(0, len(middle), count)
    heading = np.arctan2(ahead[k, 1], ahead[k, 0])
    width = np.sqrt(((left[0] - right[0]) ** 2).sum())
    start = middle[k] + generator.normal(0.0, 0.25 * width * scatter, (count, 2))
    step = generator.uniform(0.0, 4.0, count)
    end = start + step[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    turned = heading + generator.normal(0.0, 0.3, count)
    return np.stack([*start.T, turned, *end.T, turned + generator.normal(0.0, 0.1, count)])


def same(found: Floats, expected: list[float], poses: Floats) -> None:
    """The same doubles, except where sines and cosines are not."""
    for k, (value, other) in enumerate(zip(found.tolist(), expected)):
        if same_trigonometry(poses[2, k], poses[5, k]):
            assert value == other, poses[:, k]
        assert value == pytest.approx(other, rel=1e-9, abs=1e-12), poses[:, k]


def compare(borders: Borders, closed: bool, poses: Floats) -> Floats:
    left, right = borders
    assert fast.Corridor(left, right, closed).fault is None
    assert reference.corridor_fault(left, right, closed) is None
    found = fast.Corridor(left, right, closed).margin_inside(*poses, *BODY)
    expected = [
        reference.hull_inside_margin(left, right, closed, (a, b, c), (d, e, f), *BODY)
        for a, b, c, d, e, f in poses.T.tolist()
    ]
    same(found, expected, poses)
    return found


@pytest.mark.parametrize("scatter", [0.3, 1.5, 8.0])
@pytest.mark.parametrize(("way", "count", "closed"), [(oval, 90, True), (oval, 90, False), (eight, 80, True)])
def test_on_tracks_of_our_own(way: Any, count: int, closed: bool, scatter: float) -> None:
    (left, right), _ = loop(way, count, 4.0, 6.0)
    borders = (left, right) if closed else (left[:-3], right[:-3])
    inside = compare(borders, closed, around(borders, 150, seed=5, scatter=scatter)) >= 0.0
    assert inside.any()
    assert scatter < 1.0 or not inside.all()


@pytest.mark.parametrize("scatter", [0.5, 4.0])
def test_a_large_batch_is_its_parts(scatter: float) -> None:
    (left, right), _ = loop(oval, 90, 4.0, 6.0)
    poses = around((left, right), 5000, seed=3, scatter=scatter)
    poses[2, 17] = math.nan
    poses[:, 4000] = 1e7
    lengths = np.where(np.arange(5000) % 7 == 0, 0.0, 4.7)
    track = fast.Corridor(left, right, True)
    together = track.margin_inside(*poses, lengths, 2.0)
    parts = [track.margin_inside(*poses[:, k : k + 40], lengths[k : k + 40], 2.0) for k in range(0, 5000, 40)]
    assert np.array_equal(together, np.concatenate(parts), equal_nan=True)
    assert np.isnan(together[lengths == 0.0]).all()
    boxes = poses[[1, 0, 2]] * 0.9
    together = fast.boxes_clear(*poses, 4.7, 2.0, *boxes, 3.0, 1.0)
    parts = [
        fast.boxes_clear(*poses[:, k : k + 40], 4.7, 2.0, *boxes[:, k : k + 40], 3.0, 1.0)
        for k in range(0, 5000, 40)
    ]
    assert np.array_equal(together, np.concatenate(parts), equal_nan=True)


def test_on_jagged_borders() -> None:
    generator = np.random.default_rng(11)
    for used in range(12):
        x = np.cumsum(generator.uniform(0.05, 4.0, 40))
        left = list(zip(x.tolist(), generator.uniform(2.0, 6.0, 40).tolist()))
        right = list(zip(x.tolist(), generator.uniform(-6.0, -2.0, 40).tolist()))
        poses = around((left, right), 60, seed=used, scatter=0.6)
        compare((left, right), False, poses)


@pytest.mark.parametrize("name", ["modena_T1_valid", "modena_T1_infeasible", "modena_T1_cutin_collision"])
def test_on_the_tracks_of_the_recordings(name: str) -> None:
    borders = scenario_borders(shared("data", "scenarios", f"{name}.saa"))
    compare(borders, False, around(borders, 60, seed=2))


@pytest.mark.parametrize("name", ["ltpl_berlin", "ltpl_modena"])
def test_race_lines_stay_on_their_tracks(name: str) -> None:
    (left, right), line = race_line(shared("data", "tracks", f"{name}.csv"))
    track = fast.Corridor(left, right, closed=True)
    assert track.fault is None
    poses = np.concatenate([np.array(line).T, np.roll(line, -1, axis=0).T])
    assert track.margin_inside(*poses, 4.7, 2.0).min() >= 0.0
    assert track.margin_inside(*poses, 4.7, 6.0).min() < 0.0
    some = np.random.default_rng(1).integers(0, len(line), 6)
    expected = [
        reference.hull_inside_margin(left, right, True, line[k], line[(k + 1) % len(line)], *BODY)
        for k in some
    ]
    same(track.margin_inside(*poses[:, some], *BODY), expected, poses[:, some])


def test_an_independent_geometry_agrees() -> None:
    borders, _ = loop(oval, 150, 4.0, 6.0)
    ring = [*borders[0][:-5], *borders[1][:-5][::-1]]
    region = shapely.Polygon(ring)
    poses = around(borders, 400, seed=8)
    margins = fast.Polygon(ring).margin_inside(*poses, *BODY)
    for (a, b, c, d, e, f), margin in zip(poses.T.tolist(), margins.tolist()):
        corners = reference.footprint((a, b, c), *BODY) + reference.footprint((d, e, f), *BODY)
        hull = shapely.convex_hull(shapely.MultiPoint(corners))
        assert region.covers(hull) == (margin >= 0.0)
        if margin >= 0.0:
            assert margin == pytest.approx(region.exterior.distance(hull), rel=1e-9, abs=1e-9)


def test_an_independent_geometry_agrees_on_clearance() -> None:
    generator = np.random.default_rng(4)
    poses, boxes = generator.uniform(-4.0, 4.0, (6, 400)), generator.uniform(-8.0, 8.0, (3, 400))
    margins = fast.boxes_clear(*poses, *BODY, *boxes, 3.0, 1.5)
    for (a, b, c, d, e, f), box, margin in zip(poses.T.tolist(), boxes.T.tolist(), margins.tolist()):
        corners = reference.footprint((a, b, c), *BODY) + reference.footprint((d, e, f), *BODY)
        hull = shapely.convex_hull(shapely.MultiPoint(corners))
        other = shapely.Polygon(reference.footprint(tuple(box), 3.0, 1.5))
        assert hull.intersects(other) == (margin <= 0.0)
        assert max(0.0, margin) == pytest.approx(hull.distance(other), abs=1e-9)


def test_boxes_and_sweeps() -> None:
    generator = np.random.default_rng(6)
    poses, boxes = generator.uniform(-6.0, 6.0, (6, 500)), generator.uniform(-9.0, 9.0, (6, 500))
    found = fast.boxes_clear(*poses, *BODY, *boxes[:3], 3.0, 1.5)
    swept = fast.sweeps_clear(*(*poses, *BODY, *boxes, 3.0, 1.5))
    for k, (a, b, c, d, e, f) in enumerate(poses.T.tolist()):
        box, there = tuple(boxes[:3, k].tolist()), tuple(boxes[3:, k].tolist())
        expected = reference.clear_margin((a, b, c), (d, e, f), *BODY, box, 3.0, 1.5)
        assert found[k] == pytest.approx(expected, rel=1e-12)
        if same_trigonometry(c, f, box[2]):
            assert found[k] == expected
        expected = reference.swept_clearance((a, b, c), (d, e, f), *BODY, box, there, 3.0, 1.5)
        assert swept[k] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("closed", [False, True])
def test_curvilinear_coordinates(closed: bool) -> None:
    (left, right), poses = loop(oval, 120, 4.0, 6.0)
    generator = np.random.default_rng(9)
    x, y = generator.uniform(-170.0, 170.0, (2, 500))
    line = [(px, py) for px, py, _ in poses]
    made = fast.Polyline(line, closed)
    expected = [reference.project(px, py, line, closed) for px, py in zip(x.tolist(), y.tolist())]
    assert np.array_equal(np.stack(made.project(x, y), axis=1), np.array(expected))
    distances = [reference.distance_to_line(px, py, line, closed) for px, py in zip(x.tolist(), y.tolist())]
    assert made.distance(x, y).tolist() == distances
    start, end = generator.uniform(-2000.0, 2000.0, (2, 300))
    gaps = [reference.station_gap(line, s, t, closed) for s, t in zip(start.tolist(), end.tolist())]
    assert made.gap(start, end).tolist() == gaps
    assert math.isclose(
        made.length, sum(math.dist(a, b) for a, b in zip(line, line[1:] + line[: int(closed)]))
    )
    few = [(px, py) for k, (px, py) in enumerate(right) if k % 3]
    centre = fast.Corridor(left, few, closed).centre.points
    assert centre.tolist() == [list(p) for p in reference.centre_line(left, few, closed)]


def test_points_in_zones() -> None:
    (left, _), _ = loop(oval, 80, 4.0, 6.0)
    generator = np.random.default_rng(10)
    x, y = generator.uniform(-170.0, 170.0, (2, 600))
    expected = [reference.in_zone_margin(px, py, left) for px, py in zip(x.tolist(), y.tolist())]
    assert fast.Polygon(left).signed_distance(x, y).tolist() == expected


def test_what_is_off_the_border_by_rounding_is_on_the_same_side() -> None:
    """Within rounding of a vertex, and of a side 1e8 m from the origin, where doubles are 1.5e-8 m apart."""
    zone = [(1e-7, -1.4), (1e-16, 0.0), (-2.0, -2.8), (-4.0, 1.4), (0.0, 8.4), (4.0, 8.4)]
    assert fast.Polygon(zone).signed_distance(0.0, 0.0).tolist() == [reference.in_zone_margin(0.0, 0.0, zone)]
    slot = [(20.0, 30.0), (-20.0, 30.0), (-20.0, -2.349), (3.0, -2.348998), (3.0, -2.35), (-20.0, -2.35), (-20.0, -30.0), (20.0, -30.0)]  # fmt: skip
    far = [(x + 1e8, y - 1e8) for x, y in slot]
    first, second = (1e8, -1e8, 0.5 * math.pi), (1e8, -1e8, 0.5 * math.pi + 0.1)
    expected = reference.hull_margin_in(reference.region_of(far), first, second, 4.7, 1.0)
    assert expected < 0.0
    assert fast.Polygon(far).margin_inside(*first, *second, 4.7, 1.0).tolist() == [expected]


def test_a_case_by_itself_has_the_margin_of_its_batch() -> None:
    """Straight on, where which corners lie on one line is a matter of rounding: numpy fuses products of complex numbers where it can, and margins
    in a batch had other last bits than those of one case, which are worked out in plain numbers."""
    generator = np.random.default_rng(1)
    heading, step = generator.uniform(-4.0, 4.0, 600), generator.choice([0.5, 1.0, 2.5, 5.0], 600)
    x, y = generator.uniform(-3.0, 3.0, 600), generator.uniform(-1.0, 1.0, 600)
    poses = np.stack([x, y, heading, x + step * np.cos(heading), y + step * np.sin(heading), heading])
    left, right = [(-40.0, 12.3), (0.0, 8.0), (40.0, 11.7)], [(-40.0, -12.1), (0.0, -7.5), (40.0, -12.9)]
    track = fast.Corridor(left, right)
    together = track.margin_inside(*poses, 4.7, 2.8)
    one = np.ones(1, dtype=bool)
    alone = [track.nearest_inside([*poses[:, k : k + 1], 4.7, 2.8], 1, one) for k in range(600)]
    found = [(float(margin[0]), float(other)) for margin, other in zip(alone, together) if margin is not None]
    assert len(found) > 200
    assert all(margin == other for margin, other in found)


@pytest.mark.parametrize("out", [1.0, -1.0], ids=["outwards", "inwards"])
@pytest.mark.parametrize("width", [1e-6, 1e-7, 2e-8, 1e-12])
def test_beside_a_spike(width: float, out: float) -> None:
    """Beside the tip, both of a spike's sides are equally near up to rounding, and their normals add up to nothing: what lay wholly outside, 3 m from
    the region, was inside it."""
    generator = np.random.default_rng(5)
    for turned in generator.uniform(-math.pi, math.pi, 12):
        turn = complex(math.cos(turned), math.sin(turned))
        tip = -out * 5.0
        corners = [-5j, 50 - 5j, 50 + 5j, 5j, 0.5j * width, complex(tip), -0.5j * width]
        zone = [((z * turn).real, (z * turn).imag) for z in corners]
        made = fast.Polygon(zone)
        assert made.fault is None
        beside = (tip + np.array([0.0, 0.0, 1e-8, -1e-8]) + 1j * np.array([3.0, -3.0, 2.0, -2.0])) * turn
        x, y = np.ascontiguousarray(beside.real), np.ascontiguousarray(beside.imag)
        expected = [reference.in_zone_margin(px, py, zone) for px, py in zip(x.tolist(), y.tolist())]
        assert made.signed_distance(x, y).tolist() == expected
        heading = turned + np.array([0.0, 0.5, 0.5 * math.pi, 0.0])
        poses = np.stack([x, y, heading, x, y, heading])
        inside = [
            reference.hull_margin_in(reference.region_of(zone), pose, pose, 2.0, 1.0)
            for pose in zip(x.tolist(), y.tolist(), heading.tolist())
        ]
        assert [margin >= 0.0 for margin in expected] == [out < 0.0] * 4
        assert [margin >= 0.0 for margin in inside] == [out < 0.0] * 4
        for found in (
            made.margin_inside(*poses, 2.0, 1.0),
            made.least_inside([*poses, 2.0, 1.0], 1, np.ones(4, dtype=bool))[0],
        ):
            same(found, inside, poses)
        looked = made.nearest_inside([*poses[:, :1], 2.0, 1.0], 1, np.ones(1, dtype=bool))
        assert (looked is not None) == (out < 0.0)
