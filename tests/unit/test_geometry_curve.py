"""What is swept along a curve, against curves walked densely with numpy and shapely, which share nothing with the engine.

A curve is known here by its curvature along the way, integrated in small steps, or by the formulas that docs/geometry.md assumes,
written anew. Each of its footprints has to lie in what the engine takes for swept, and that must not reach far beyond them all.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from support.bodies import same_trigonometry
from support.length import amount
from trackmarshal.backends.reference import geometry as reference
from trackmarshal.backends.reference.geometry.curve import MOST, Curve, curve, placed
from trackmarshal.backends.reference.geometry.footprint import convex_hull, swept_corners
from trackmarshal.cli.main import main
from trackmarshal.runtime import geometry as fast
from trackmarshal.runtime.geometry.curve import Curves

BODY = (4.7, 2.8)
Floats = NDArray[np.float64]
Pose = tuple[float, float, float]
#: What the arithmetic of a test may be wrong by [m].
EXACT = 1e-7


def boxes(poses: Floats, body: tuple[float, float] = BODY) -> Floats:
    """The rectangles of poses, (3, N): as shapely's polygons."""
    x, y, heading = poses
    corners = [(sx * body[0] / 2, sy * body[1] / 2) for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    at = [
        np.stack(
            [x + a * np.cos(heading) - b * np.sin(heading), y + a * np.sin(heading) + b * np.cos(heading)], -1
        )
        for a, b in corners
    ]
    made: Floats = shapely.polygons(np.stack(at, axis=1))
    return made


def walked(
    length: float, kappa: Callable[[Floats], Floats], start: Pose, steps: int = 2000
) -> tuple[Floats, float, float]:
    """Poses along a curve of a length, given its curvature, by Simpson's rule; and the curvature at both ends."""
    s = np.linspace(0.0, length, 2 * steps + 1)
    h = s[1] - s[0]
    k = kappa(s)
    heading = np.zeros(s.size)
    heading[2::2] = np.cumsum((k[:-2:2] + 4.0 * k[1::2] + k[2::2]) * h / 3.0)
    heading[1::2] = heading[:-2:2] + (5.0 * k[:-2:2] + 8.0 * k[1::2] - k[2::2]) * h / 12.0
    heading += start[2]
    x, y = (
        begin + np.concatenate([[0.0], np.cumsum((f[:-2:2] + 4.0 * f[1::2] + f[2::2]) * h / 3.0)])
        for begin, f in ((start[0], np.cos(heading)), (start[1], np.sin(heading)))
    )
    return np.stack([x, y, heading[::2]]), float(k[0]), float(k[-1])


def way(poses: Floats, kappa0: float, kappa1: float, body: tuple[float, float] = BODY) -> Curve:
    """What the engine makes of the ends of a curve."""
    first, last = (tuple(poses[:, k].tolist()) for k in (0, -1))
    return curve(placed(first), placed(last), (kappa0, kappa1), *body)


def covered(made: Curve, body: tuple[float, float] = BODY) -> shapely.Geometry:
    """The area that the engine takes for swept; its round corners a little too small."""
    hulls = []
    for first, second in pairwise(made.poses):
        hull = convex_hull(swept_corners(first, second, *body))
        hulls.append(shapely.Polygon([(x + first.x, y + first.y) for x, y in hull]))
    return shapely.union_all([hull.buffer(made.more, quad_segs=64) for hull in hulls])


def left_out(made: Curve, poses: Floats, body: tuple[float, float] = BODY) -> float:
    """How far footprints reach beyond what the engine takes for swept: none of it may be farther from any hull than `more`."""
    hulls = [
        shapely.Polygon(
            [(x + first.x, y + first.y) for x, y in convex_hull(swept_corners(first, second, *body))]
        )
        for first, second in pairwise(made.poses)
    ]
    # A corner's distance is not enough where a footprint lies between two hulls; each has to be near to one hull as a whole.
    corners = shapely.get_coordinates(boxes(poses, body)).reshape(-1, 5, 2)[:, :4]
    apart = [shapely.distance(hull, shapely.points(corners)).max(axis=1) for hull in hulls]
    return float(np.min(apart, axis=0).max()) - made.more


def beyond(made: Curve, poses: Floats, body: tuple[float, float] = BODY) -> float:
    """How far the area that the engine takes for swept reaches beyond the footprints of a curve, at most."""
    dense = shapely.union_all(boxes(poses, body)[::10])
    outline = shapely.segmentize(covered(made, body).boundary, 0.02)
    return float(shapely.distance(dense, shapely.points(shapely.get_coordinates(outline))).max())


def starts(generator: np.random.Generator) -> Pose:
    x, y, heading = generator.uniform(-200.0, 200.0, 3)
    return float(x), float(y), float(heading / 60.0)


@pytest.mark.parametrize("radius", [11.0, 16.0, -16.0, 30.0, 100.0, 1000.0])
def test_an_arc_is_covered_and_little_else(radius: float) -> None:
    """The bounds that docs/geometry.md states for 2.5 m between samples, down to the tightest turn of the shipped vehicle."""
    poses, kappa0, kappa1 = walked(2.5, lambda s: np.full_like(s, 1.0 / radius), (3.0, -2.0, 0.7))
    made = way(poses, kappa0, kappa1)
    assert left_out(made, poses) <= EXACT
    found = beyond(made, poses)
    assert found <= {16.0: 0.0085, 11.0: 0.0145}.get(abs(radius), 0.0075)  # docs/geometry.md
    if abs(radius) == 16.0:
        hull = Curve((made.poses[0], made.poses[-1]), 0.0)
        assert beyond(hull, poses) > 0.2  # what is mended
        assert left_out(hull, poses) > 0.04  # and the hull was too narrow on the outside


def test_what_is_left_out_is_noticed() -> None:
    poses, kappa0, kappa1 = walked(2.5, lambda s: np.full_like(s, 1.0 / 16.0), (0.0, 0.0, 0.0))
    made = way(poses, kappa0, kappa1)
    assert made.more > 0.0005
    assert left_out(made._replace(more=0.0), poses) > 1e-4


def test_arcs_and_clothoids_of_all_kinds_are_covered() -> None:
    generator = np.random.default_rng(1)
    for _ in range(amount(20, 150)):
        length = float(generator.choice([0.05, 0.5, 2.5, 5.0, 10.0]))
        most = min(0.2, 1.2 / length)
        kappa0, kappa1 = generator.uniform(-most, most, 2) * generator.choice([1.0, 0.1])
        body = (float(generator.uniform(0.5, 12.0)), float(generator.uniform(0.3, 3.0)))
        poses, begin, end = walked(
            length,
            lambda s, a=kappa0, b=kappa1, L=length: a + (b - a) * s / L,  # type: ignore[misc]
            starts(generator),
            400,
        )
        assert left_out(way(poses, begin, end, body), poses, body) <= EXACT, (length, kappa0, kappa1, body)


@pytest.mark.parametrize("other", [-1.2, -1.0, -0.8, 0.5, 0.9])
def test_clothoids_that_wind_to_both_sides_are_covered(other: float) -> None:
    """Where curvatures at both ends cancel out, they do not show by how much the slope of a clothoid grows unevenly."""
    for bent in np.arange(0.1, 1.3, amount(0.3, 0.1)):
        poses, begin, end = walked(
            1.0,
            lambda s, a=bent: a * (1.0 + (other - 1.0) * s),  # type: ignore[misc]
            (3.0, -2.0, 0.7),
            400,
        )
        for body in (BODY, (12.0, 0.3), (0.5, 0.3)):
            assert left_out(way(poses, begin, end, body), poses, body) <= EXACT, (bent, body)


def test_backing_up_along_a_curve() -> None:
    """The heading is against the way; curvature is what the heading turns by per metre of way."""
    poses, kappa0, kappa1 = walked(2.5, lambda s: 0.02 + 0.02 * s, (5.0, 6.0, 1.0))
    poses[2] += math.pi
    made = way(poses, kappa0, kappa1)
    assert left_out(made, poses) <= EXACT
    assert beyond(made, poses) <= 0.012


def family(generator: np.random.Generator, steps: int = 200) -> tuple[Floats, tuple[float, float], float]:
    """A motion of those that docs/geometry.md says are covered, by its definition: slopes along the chord, that of the way and that
    of the heading, whose rates are anything within the bounds and whose means are right; the curvatures at both ends, and the chord's length."""
    t = np.linspace(0.0, 1.0, 2 * steps + 1)
    h = t[1]
    chord = float(generator.choice([0.1, 1.0, 2.5, 6.0]))
    slope0, slope1 = generator.uniform(-0.3, 0.3, 2)
    turn = slope1 - slope0
    lean, off = generator.uniform(-0.3, 0.3), generator.uniform(-0.1, 0.1)
    sway = -3.0 * (slope0 + slope1)

    def within(most: float, moments: int) -> Floats:
        """A function of t, mostly at plus or minus `most`, of which `moments` moments vanish."""
        raw = generator.choice([-1.0, 1.0], 40).repeat(math.ceil(t.size / 40))[: t.size] * 1.0
        weights = np.full(t.size, h)
        weights[[0, -1]] = h / 2
        for _ in range(30):
            for power in range(moments):
                base = t**power - (0.5 if power else 0.0)
                raw = raw - base * ((weights * raw * base).sum() / (weights * base * base).sum())
            raw = np.clip(raw, -1.0, 1.0)
        for power in range(moments):
            base = t**power - (0.5 if power else 0.0)
            raw = raw - base * ((weights * raw * base).sum() / (weights * base * base).sum())
        made: Floats = most * raw / max(1.0, float(np.abs(raw).max()))
        return made

    def summed(rate: Floats) -> Floats:
        made: Floats = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) * h / 2)])
        return made

    heading = slope0 + summed(turn + lean * (1.0 - 2.0 * t) + within(abs(off), 1))
    path = slope0 + summed(turn + sway * (1.0 - 2.0 * t) + within(abs(off) + abs(lean - sway), 2))
    x, y = chord * t, chord * summed(path)
    assert abs(heading[-1] - slope1) < 1e-9
    assert abs(y[-1]) < 1e-3 * chord
    bent = [(turn + off + sign * lean) / chord for sign in (1.0, -1.0)]
    kappas = [b / (1.0 + s * s) ** 1.5 for b, s in zip(bent, (slope0, slope1))]
    y -= y[-1] * t  # what the sums are wrong by
    return np.stack([x, y, np.arctan(heading)]), (kappas[0], kappas[1]), chord


@pytest.mark.acceptance
def test_all_that_is_assumed_is_covered() -> None:
    generator = np.random.default_rng(2)
    tight = 0.0
    for _ in range(100):
        poses, kappas, chord = family(generator)
        made = way(poses, *kappas)
        found = left_out(made, poses)
        assert found <= 1e-5 * chord + EXACT, (kappas, chord)
        tight = max(tight, (found + made.more) / made.more)
    assert tight > 0.3  # motions come near to the bound


def test_the_excess_is_bounded_as_the_docs_say() -> None:
    generator = np.random.default_rng(3)
    for _ in range(30):
        length = float(generator.choice([0.5, 2.5, 5.0]))
        most = min(0.12, 0.8 / length)
        kappa0, kappa1 = generator.uniform(-most, most, 2)
        poses, begin, end = walked(
            length,
            lambda s, a=kappa0, b=kappa1, L=length: a + (b - a) * s / L,  # type: ignore[misc]
            starts(generator),
            400,
        )
        made = way(poses, begin, end)
        pieces = len(made.poses) - 1
        corner = math.hypot(BODY[0], BODY[1]) / 2
        steepest = abs(poses[2, -1] - poses[2, 0]) + 0.5 * length * abs(kappa0 - kappa1)
        limit = corner * 1.3 * steepest / (2 * pieces) + 2 * made.more + 1e-3
        assert beyond(made, poses) <= limit
        if pieces < MOST:
            assert corner * steepest / (2 * pieces) <= 0.007 * 1.3


@pytest.mark.parametrize(
    ("second", "kappas"),
    [
        ((0.0, 0.0, 0.0), (0.3, -0.2)),  # stands
        ((2.5, 0.0, 0.0), (0.0, 0.0)),  # goes straight on
        ((-2.5, 0.0, 0.0), (0.0, 0.0)),  # backs up
    ],
)
def test_nothing_is_added_where_nothing_turns(second: Pose, kappas: tuple[float, float]) -> None:
    made = curve(placed((0.0, 0.0, 0.0)), placed(second), kappas, *BODY)
    assert made.more == 0.0
    assert len(made.poses) == 2


def test_what_fits_nothing_is_covered_wherever_it_passes() -> None:
    """Headings across the way, headings against each other, a turn on the spot: anywhere in the circle around the chord, pointing
    anywhere between both headings."""
    generator = np.random.default_rng(4)
    for _ in range(200):
        chord, turn = generator.choice([0.0, 0.01, 0.3, 2.5]), generator.uniform(-3.1, 3.1)
        heading = generator.choice([generator.uniform(0.8, 2.3), -2.0])
        if abs(math.tan(heading)) <= 1.0 and chord:
            continue
        first, second = (0.0, 0.0, float(heading)), (float(chord), 0.0, float(heading + turn))
        made = curve(placed(first), placed(second), (0.0, 0.0), *BODY)
        assert len(made.poses) == 2
        angle, out = generator.uniform(-math.pi, math.pi, 300), np.sqrt(generator.uniform(0.0, 1.0, 300))
        x = chord / 2 * (1.0 + out * np.cos(angle))
        y = chord / 2 * out * np.sin(angle)
        poses = np.stack([x, y, heading + turn * generator.uniform(0.0, 1.0, 300)])
        assert left_out(made, poses) <= EXACT, (first, second)


def test_a_curvature_that_does_not_fit_makes_it_wider() -> None:
    poses, kappa0, kappa1 = walked(2.5, lambda s: np.full_like(s, 0.05), (0.0, 0.0, 0.0))
    right, wrong = way(poses, kappa0, kappa1), way(poses, 0.0, 0.0)
    assert wrong.more > right.more + 0.15
    for heading in (0.05, -0.2):  # nor do headings that lie beside the way
        moved = poses.copy()
        moved[2] += heading
        assert way(moved, kappa0, kappa1).more > right.more


TRACK = ([(-20.0, 4.0), (40.0, 6.0)], [(-20.0, -4.0), (12.0, -3.0), (40.0, -5.0)])
STANDS = (6.0, 3.5, 0.4)


def some(count: int) -> tuple[Floats, Floats]:
    """Poses and curvatures of all kinds: that fit, that nearly fit, that do not, that stand, that back up."""
    generator = np.random.default_rng(5)
    poses, bends = np.empty((6, count)), np.empty((2, count))
    for k in range(count):
        length, kappa = generator.choice([0.0, 1e-7, 0.3, 2.5, 8.0]), generator.uniform(-0.1, 0.1)
        start = (
            float(generator.uniform(-5.0, 15.0)),
            float(generator.uniform(-3.0, 3.0)),
            float(generator.normal(0.0, 0.3)),
        )
        made, *ends = walked(float(length), lambda s, a=kappa: np.full_like(s, a), start, 20)  # type: ignore[misc]
        noise = generator.choice([0.0, 0.0, 0.01, 0.5, 2.0])
        poses[:, k] = [*made[:, 0], *made[:, -1]]
        poses[[2, 5], k] += noise * generator.normal(size=2) + generator.choice([0.0, 0.0, math.pi])
        bends[:, k] = np.array(ends) + 0.1 * noise * generator.normal(size=2)
    return poses, bends


@pytest.mark.acceptance
def test_numpy_takes_the_same_steps() -> None:
    poses, bends = some(1500)
    made = Curves(poses, bends, *BODY)
    left, right = TRACK
    margins = fast.Corridor(left, right).margin_inside(*poses, *BODY, *bends)
    clear = fast.boxes_clear(*poses, *BODY, *STANDS, 3.0, 1.0, *bends)
    kinds = set()
    for k, (a, b, c, d, e, f) in enumerate(poses.T.tolist()):
        bend = bends[:, k].tolist()
        one = curve(placed((a, b, c)), placed((d, e, f)), bend, *BODY)
        assert made.count[k] == len(one.poses) - 1
        kinds.add(int(made.count[k]))
        inside = reference.hull_inside_margin(left, right, False, (a, b, c), (d, e, f), *BODY, bend)
        apart = reference.clear_margin((a, b, c), (d, e, f), *BODY, STANDS, 3.0, 1.0, bend)
        assert margins[k] == pytest.approx(inside, rel=1e-9, abs=1e-9)
        assert clear[k] == pytest.approx(apart, rel=1e-9, abs=1e-9)
        if same_trigonometry(c, f):
            assert made.more[k] == one.more
        straight = reference.hull_inside_margin(left, right, False, (a, b, c), (d, e, f), *BODY)
        if straight > 0.5:
            assert inside >= straight - made.reach[k] - EXACT
            if made.count[k] == 1:  # it is the straight hull, so no more than this is to be taken off
                assert inside == pytest.approx(straight - made.reach[k], abs=EXACT)
        assert inside <= max(straight, 0.0) + made.short[k] + EXACT
    assert kinds == set(range(1, MOST + 1))
    assert (margins > 0.0).any()
    assert (margins < 0.0).any()


@pytest.mark.parametrize("angle", [0.1, 0.2, 0.4])
def test_in_a_bend_less_is_swept_than_the_straight_hull(angle: float) -> None:
    """A post that all but touches the inner side of the hull is farther from the way, by no more than `short` says."""
    radius = 11.0
    x, y = radius * math.sin(angle / 2), -radius * math.cos(angle / 2)
    poses = np.array([[-x], [y], [-angle / 2], [x], [y], [angle / 2]])
    bends = np.full((2, 1), 1.0 / radius)
    top = y + BODY[1] / 2 * math.cos(angle / 2) + BODY[0] / 2 * math.sin(angle / 2)
    track = (
        [(-30.0, 5.0), (-0.1, 5.0), (0.0, top + 0.01), (0.1, 5.0), (30.0, 5.0)],
        [(-30.0, -30.0), (30.0, -30.0)],
    )
    straight = fast.Corridor(*track).margin_inside(*poses, *BODY)[0]
    along = fast.Corridor(*track).margin_inside(*poses, *BODY, *bends)[0]
    assert straight == pytest.approx(0.01, abs=1e-3)
    short = Curves(poses, bends, *BODY).short[0]
    assert 0.6 * short < along - straight <= short


def test_what_is_no_number_is_undefined() -> None:
    pose = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    for bend in ((math.nan, 0.0), (0.0, math.inf), (2e9, 0.0)):
        assert math.isnan(reference.hull_inside_margin(*TRACK, False, pose[:3], pose[3:], *BODY, bend))
        assert math.isnan(fast.Corridor(*TRACK).margin_inside(*pose, *BODY, *bend)[0])
        assert math.isnan(reference.clear_margin(pose[:3], pose[3:], *BODY, STANDS, 1.0, 1.0, bend))
        assert math.isnan(fast.boxes_clear(*pose, *BODY, *STANDS, 1.0, 1.0, *bend))


SPOKEN = """module spoken
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m }
signal track : corridor { left: polyline, right: polyline }
rule curve "along the curve"
  for all p in plan
  require swept_footprint(p, 4.7 m, 2.8 m) inside track
rule straight "straight"
  for all p in plan
  require swept_hull(p, 4.7 m, 2.8 m) inside track
"""


def test_explain_says_which_way_is_taken(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    poses, *_ = walked(2.5, lambda s: np.full_like(s, 1.0 / 16.0), (0.0, 0.0, 0.0), 10)
    columns = {name: row[[0, -1]].tolist() for name, row in zip(("x", "y", "heading"), poses)}
    columns |= {"t": [0.0, 1.0], "kappa": [1 / 16, 1 / 16], "s": [0.0, 2.5], "v": [2.5, 2.5], "a": [0.0, 0.0]}
    head = {
        "format": "trackmarshal-recording", "version": 1, "name": "bend",
        "track": {"left": [[-20, 9], [40, 9]], "right": [[-20, -9], [40, -9]]},
    }  # fmt: skip
    cycle = {
        "t": 0.0, "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 2.5}, "objects": [],
        "candidates": {"driving": columns, "emergency": columns},
    }  # fmt: skip
    recording, spec = tmp_path / "bend.tmrec.jsonl", tmp_path / "spoken.spec"
    recording.write_text(f"{json.dumps(head)}\n{json.dumps(cycle)}\n", encoding="utf-8")
    spec.write_text(SPOKEN, encoding="utf-8")
    said = {}
    for rule in ("curve", "straight"):
        given = ["--spec", str(spec), "--rule", rule, "--at", "0", "--candidate", "driving"]
        assert main(["explain", str(recording), *given]) == 0
        said[rule] = capsys.readouterr().out
    assert "swept_footprint(p, 4.7 m, 2.8 m) inside track" in said["curve"]
    assert re.search(r"swept = along a curve, in 31 pieces, and 0\.0015\d* m around them\n", said["curve"])
    assert "swept = the straight hull of two footprints\n" in said["straight"]
