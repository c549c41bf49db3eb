"""Generated C geometry against the reference, bit for bit: borders and lines of all kinds, poses around them."""

from __future__ import annotations

import cmath
import math
import random
import struct
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from support.agreement import outcomes
from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.program import CProgram
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, load, loads

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

TEXT = """module geo

signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m }
signal ego : state { x: m, y: m, heading: rad }
signal objects : set of object { x: m, y: m, heading: rad, length: m, width: m }
signal track : corridor { left: polyline, right: polyline }
signal way : polyline

param length : m = 4.7 m in [-10, 1e9]
param width  : m = 2.8 m in [-10, 1e9]
zone z = polygon (0 m, 0 m) (10 m, 0 m) (10 m, 10 m) (5 m, 4 m) (0 m, 10 m)
line l = (0 m, -6 m) (0 m, 6 m) (3 m, 8 m)

"""
RULES = {
    "inside": "for all p in plan|swept_footprint(p, length, width) inside track",
    "inside_one": "exists p in plan|swept_footprint(p, length, width) inside track",
    "inside_zone": "exists p in plan|swept_footprint(p, length, width) inside z",
    "hull_inside": "for all p in plan|swept_hull(p, length, width) inside track",
    "hull_inside_one": "exists p in plan|swept_hull(p, length, width) inside track",
    "hull_inside_zone": "exists p in plan|swept_hull(p, length, width) inside z",
    "point_in_zone": "for all p in plan|p in zone z",
    "clear": "for all o in objects|for all p in plan: (swept_footprint(p, length, width) clear_of footprint(o))",
    "hull_clear": "for all o in objects|for all p in plan: (swept_hull(p, length, width) clear_of footprint(o))",
    "stations": "for all p in plan|station(p, track) <= 100 m",
    "offsets": "for all p in plan|offset(p, track) <= 1 m",
    "directions": "for all p in plan|direction(p, track) <= 1",
    "gaps": "for all p in plan|station_gap(track, station(ego, track), station(p, track)) <= 1 m",
    "stretches": "for all p in plan|p in stretch(track, station(ego, track), ego.x) or ego.y in stretch(plan, p.x, 2 * p.x)",
    "distances": "for all p in plan|distance_to(p, track) <= 1 m",
    "paths": "for all o in objects|station(o, plan) + 1000 * offset(o, plan) <= distance_to(o, plan)",
    "path_directions": "for all o in objects|direction(o, plan) <= 1",
    "path_distances": "for all o in objects|distance_to(o, plan) <= 3 m",
    "ways": "for all p in plan|offset(p, way) + station(p, way) <= distance_to(p, way)",
    "places": "for all p in plan|offset(p, l) + station(p, l) <= distance_to(p, l)",
    "borders": "for all p in plan|distance_to(p, track.left) <= distance_to(p, track.right)",
}
Points = list[list[float]]


@cache
def evaluator(folder: Path) -> tuple[Evaluator, CProgram]:
    path = folder / "geo.spec"
    rules = [
        f'rule {n} "made up"\n  {t.partition("|")[0]}\n  require {t.partition("|")[2]}\n'
        for n, t in RULES.items()
    ]
    path.write_text(TEXT + "\n".join(rules), encoding="utf-8")
    spec = load(path)
    made = Evaluator(spec, None, "reference")
    return made, CProgram(spec, made.rules)


def borders(r: random.Random) -> tuple[Points, Points, bool]:
    """Two borders: an open road or a ring; sometimes on whole numbers, torn, crossing, repeated, reversed or broken."""
    k, closed, w = r.randint(3, 40), r.random() < 0.5, r.choice([2, 3, 5, 8])
    grid = (lambda v: float(round(v))) if r.random() < 0.3 else (lambda v: v)
    other = k if r.random() < 0.6 else r.randint(3, 40)

    def ring(radius: float, count: int) -> Points:
        angles = [2 * math.pi * i / count for i in range(count)]
        return [
            [grid(radius * (1 + 0.15 * math.cos(3 * t)) * f(t)) for f in (math.cos, math.sin)] for t in angles
        ]

    def road(offset: float, count: int) -> Points:
        return [
            [grid(60 * i / count - 10), grid(offset + 4 * math.sin(4 * i / count))] for i in range(count + 1)
        ]

    if closed:
        radius = r.uniform(15, 40)
        left, right = ring(radius + w, k), ring(max(radius - w, 3), other)
        if r.random() < 0.2:
            left.reverse()
        if r.random() < 0.5:
            left, right = right, left
        if r.random() < 0.3:
            left.append(left[0])
    else:
        left, right = road(w, k), road(-w, other)
        if r.random() < 0.1:
            right[0] = list(left[0])
        if r.random() < 0.1:
            right[-1] = list(left[-1])
    for points in (left, right):
        kind, i = r.random(), r.randrange(len(points))
        if kind < 0.1:
            points[i] = [points[i][0] + r.uniform(-4, 4), points[i][1] + r.uniform(-4, 4)]
        elif kind < 0.13:
            points.insert(i, list(r.choice(points)))
        elif kind < 0.15:
            points[i] = [math.nan, points[i][1]]
        elif kind < 0.2:
            points.insert(i, [points[i][0] + 1e-10, points[i][1]])
    return left, right, closed


def eight(r: random.Random) -> tuple[Points, Points, bool]:
    """The borders of a figure of eight, in pairs; sometimes swapped, reversed, with repeated or shared points, or torn."""
    k, w = r.randint(12, 40), r.choice([1.0, 2.0, 4.0])
    a, b = r.uniform(20, 40), r.uniform(12, 25)
    left, right = [], []
    for i in range(k):
        t = 2 * math.pi * (i + r.choice([0.0, 0.3])) / k
        x, y, dx, dy = a * math.sin(t), b * math.sin(2 * t), a * math.cos(t), 2 * b * math.cos(2 * t)
        reach = w / math.hypot(dx, dy)
        left.append([x - dy * reach, y + dx * reach])
        right.append([x + dy * reach, y - dx * reach])
    if r.random() < 0.3:
        left, right = right, left
    if r.random() < 0.3:
        left, right = left[::-1], right[::-1]
    i = r.randrange(k)
    kind = r.random()
    if kind < 0.1:
        left[i] = [left[i][0] + r.uniform(-3, 3), left[i][1] + r.uniform(-3, 3)]
    elif kind < 0.2:
        left.append(list(left[0]))
        right.append(list(right[0]))
    elif kind < 0.3:
        left.insert(i, list(left[i]))
        right.insert(i, [(right[i][j] + right[i - 1][j]) / 2 for j in (0, 1)])
    elif kind < 0.35:
        left[i] = [right[i][0] + 1e-10, right[i][1]]
    return left, right, True


def bend(
    r: random.Random, x: float, y: float, h: float, count: int
) -> tuple[list[Any], list[float], list[float], list[float]]:
    """Samples of an arc, forwards or backwards; sometimes with headings or curvatures that are a little off."""
    kappa, step = (
        r.choice([0.0, 1e-9, 0.01, -0.06, 0.09, r.uniform(-0.4, 0.4)]),
        r.choice([0.05, 1.0, 2.5, 5.0]),
    )
    back, noise = r.choice([0.0, 0.0, math.pi]), r.choice([0.0, 0.0, 0.01, 0.3])
    columns: tuple[list[Any], list[float], list[float], list[float]] = ([], [], [], [])
    for _ in range(count):
        values = (x, y, h + back + noise * r.uniform(-1, 1), kappa * (1 + noise * r.uniform(-1, 1)))
        for column, value in zip(columns, values):
            column.append(value)
        turned = h + kappa * step
        chord = step if kappa == 0.0 else 2 * math.sin(kappa * step / 2) / kappa
        x, y, h = x + chord * math.cos((h + turned) / 2), y + chord * math.sin((h + turned) / 2), turned
    return columns


def case(r: random.Random, left: Points, right: Points, closed: bool) -> dict[str, Any]:
    count, i = r.randint(2, 5), r.randrange(min(len(left), len(right)))
    cx, cy = (left[i][0] + right[i][0]) / 2, (left[i][1] + right[i][1]) / 2
    if r.random() < 0.2 or math.isnan(cx):
        cx, cy = r.uniform(0, 10), r.uniform(0, 10)
    h = r.choice([0.0, math.pi / 2, r.uniform(-4, 4)])
    steps = [(r.choice([0, 1, 2.5]), r.choice([0, 0, 0.3 * r.random()])) for _ in range(count)]
    x: list[Any] = [cx + j * math.cos(h) * step for j, (step, _) in enumerate(steps)]
    y = [cy + j * math.sin(h) * step for j, (step, _) in enumerate(steps)]
    heading = [h + turn for _, turn in steps]
    kappa = [r.choice([0.0, 0.0, 0.02, -0.1, 3.0]) for _ in range(count)]
    if r.random() < 0.5:
        x, y, heading, kappa = bend(r, cx, cy, h, count)
    if r.random() < 0.05:
        kappa[r.randrange(count)] = r.choice([math.nan, 1e9, 1e10, math.inf])
    if r.random() < 0.3:
        x, y = [float(round(v)) for v in x], [float(round(v)) for v in y]
    if r.random() < 0.05:
        x[r.randrange(count)] = r.choice([None, 1e10, 1e9, -1e308])
    if r.random() < 0.05:
        heading[r.randrange(count)] = r.choice([1e9, 1e5])
    objects = [
        {"x": cx + r.uniform(-6, 6), "y": cy + r.uniform(-6, 6), "heading": r.choice([0.0, h, r.uniform(-4, 4)]),
         "length": r.choice([4.0, 0.2, 1e-7, 5 * r.random()]), "width": r.choice([2.0, 0.2])}
        for _ in range(r.randint(0, 2))
    ]  # fmt: skip
    signals = {
        "plan": {"t": [0.1 * j for j in range(count)], "x": x, "y": y, "heading": heading, "kappa": kappa}, "ego": {"x": cx, "y": cy, "heading": h},
        "objects": objects, "track": {"left": left, "right": right, "closed": closed}, "way": r.choice([left, right, [[0, 0], [1, 1], [1, 1], [0, 5]]]),
    }  # fmt: skip
    data: dict[str, Any] = {"signals": signals}
    if r.random() < 0.5:
        data["params"] = {
            "length": r.choice([4.0, 1.0, 0.1, 1e-6, 1e-7, 0.0, 8.0]),
            "width": r.choice([2.0, 1.0, 0.1, 1e-6]),
        }
    if r.random() < 0.1:
        data["places"] = {"z": [[0, 0], [8, 0], [8, 8]], "l": [[0, 0], [5, 5]]}
    return data


def bits(x: float) -> bytes:
    return b"nan" if math.isnan(x) else struct.pack("<d", x)


def compare(seed: int, folder: Path, seen: Counter[str]) -> list[str]:
    reference, program = evaluator(folder)
    r = random.Random(seed)
    given = eight(r) if seed % 4 == 3 else borders(r)
    found = []
    for _ in range(6):
        read = reference.read(case(r, *given))
        expected = next(iter(reference.evaluate([read])))
        try:
            (run,) = outcomes(program, [read])
        except TrackmarshalError as error:
            if error.code != "E473":
                raise
            seen["refused"] += 1
            continue
        for rule in reference.rules:
            verdict, margin = run[rule.name]
            seen[verdict] += 1
            wanted = expected.rules[rule.name]
            if verdict != wanted.verdict or bits(margin) != bits(wanted.margin):
                found.append(
                    f"seed {seed} {rule.name}: {verdict} {margin!r} | {wanted.verdict} {wanted.margin!r}"
                )
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("geo")


def test_some_tracks(folder: Path) -> None:
    seen: Counter[str] = Counter()
    found = [text for seed in range(amount(10, 40)) for text in compare(seed, folder, seen)]
    assert not found
    assert min(seen[verdict] for verdict in ("satisfied", "violated", "undefined")) >= 50
    assert seen["refused"] < 40


@pytest.mark.acceptance
def test_many_tracks(folder: Path) -> None:
    seen: Counter[str] = Counter()
    found = [text for seed in range(1000, 2500) for text in compare(seed, folder, seen)]
    assert not found


@pytest.mark.parametrize("quarters", range(4))
def test_borders_that_touch_at_the_edge_of_all_that_there_is(quarters: int) -> None:
    """A vertex of one on the middle of the other, straight along an axis, as no random track has it: no program has a corridor of them."""
    spec = loads(
        "module m\nsignal ego : state { x: m, y: m, heading: rad }\nsignal track : corridor { left: polyline, right: polyline }\n"
        'rule f "x"\n  require footprint(ego, 1 m, 1 m) inside track\n'
    )

    def turned(*points: tuple[float, float]) -> Points:
        turn = 1j**quarters
        return [[(complex(*point) * turn).real, (complex(*point) * turn).imag] for point in points]

    programs = [Evaluator(spec, None, backend) for backend in ("reference", "numpy", "c")]
    ((x, y),) = turned((5.0, 0.0))
    for left, right, verdict in (
        (turned((0, 6), (100, 6)), turned((0, -6), (50, -6), (100, -6)), "satisfied"),
        (turned((0, 6), (100, 6)), turned((0, -6), (50, 6), (100, -6)), "undefined"),
        (turned((0, 6), (50, -6), (100, 6)), turned((0, -6), (100, -6)), "undefined"),
    ):
        for one, other in ((left, right), (right[::-1], left[::-1])):
            given = {"ego": {"x": x, "y": y, "heading": 0.0}, "track": {"left": one, "right": other}}
            said = [program.case({"signals": given}).rules["f"].verdict for program in programs]
            assert said == [verdict] * 3


@pytest.mark.parametrize("first", [0.0, 500.0])
def test_of_one_body_inside_nothing_follows_for_the_next_one(first: float) -> None:
    """Sweeps that follow each other share a pose, so that the second one begins inside where the first one ended there; other bodies share none."""
    spec = loads(
        "module m\nsignal objects : set of object { x: m, y: m, heading: rad }\nsignal track : corridor { left: polyline, right: polyline }\n"
        'rule f "x"\n  for all o in objects\n  require footprint(o, 4 m, 2 m) inside track\n'
    )
    objects = [{"x": 50.0, "y": y, "heading": 0.0} for y in (first, 500.0 - first)]
    track = {"left": [[0, 10], [100, 10]], "right": [[0, -10], [100, -10]]}
    for backend in ("reference", "numpy", "c"):
        found = Evaluator(spec, None, backend).case({"signals": {"objects": objects, "track": track}})
        # The far corners are at 501 m, the border at 10 m.
        assert (found.rules["f"].verdict, found.rules["f"].margin) == ("violated", -491.0)


@pytest.mark.parametrize("turn", [0.0, math.pi / 2, math.pi, 2.0])
def test_a_tooth_of_the_border_through_a_body_is_as_deep_in_it_as_its_middle(turn: float) -> None:
    """No corner of the body is outside, and no vertex of the border is in the body."""
    spec = loads(
        "module m\nsignal ego : state { x: m, y: m, heading: rad }\nsignal track : corridor { left: polyline, right: polyline }\n"
        'rule f "x"\n  require footprint(ego, 4 m, 2 m) inside track\n'
    )

    def turned(*points: complex) -> Points:
        at = [point * complex(math.cos(turn), math.sin(turn)) for point in points]
        return [[point.real, point.imag] for point in at]

    track = {
        "left": turned(-50 + 10j, -0.1 + 10j, -5j, 0.1 + 10j, 50 + 10j),
        "right": turned(-50 - 10j, 50 - 10j),
    }
    for backend in ("reference", "numpy", "c"):
        for heading in (turn, turn + math.pi):
            signals = {"ego": {"x": 0.0, "y": 0.0, "heading": heading}, "track": track}
            found = Evaluator(spec, None, backend).case({"signals": signals}).rules["f"]
            assert found.verdict == "violated"
            assert found.margin == pytest.approx(-1.0)


def test_a_long_body_that_is_turned_far_beside_one_that_is_turned_the_other_way() -> None:
    """The mean turn of both poses is small, and of one of them a cosine that is good near 0 is off by 4e-4. A notch of the border lies a little farther
    away than another one, along the hull of both."""
    spec = loads(
        "module m\n"
        "signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad }\n"
        "signal track : corridor { left: polyline, right: polyline }\n"
        'rule inside "on the track"\n  for all p in plan\n  require swept_hull(p, 20 m, 0.5 m) inside track\n'
    )
    along, headings = cmath.rect(1.0, 0.7), [-0.149, 0.79, -0.298, 0.0, 0.0, 0.0]
    across = 1j * along

    def reach(turn: float) -> float:
        """How far a body reaches towards the notch."""
        corners = (cmath.rect(1.0, turn) * complex(x, y) for x in (-10.0, 10.0) for y in (-0.25, 0.25))
        return min((corner / across).real for corner in corners)

    last = 16.0 * along + across * (reach(0.79) - reach(-0.298) + 1.4e-3)
    places = [across * (reach(0.79) - reach(-0.149) + 6.0), 0j, last, last, last, last]
    near = cmath.rect(1.0, 0.79) * complex(-10.0, -0.25)
    tail = places[0] + cmath.rect(1.0, -0.149) * complex(-10.0, 0.25) + complex(-0.05, 0.015)
    evaluators = [Evaluator(spec, None, backend) for backend in ("numpy", "c")]

    def margins(gap: float, first: float, second: float) -> list[float]:
        left = [-40 + 18j, tail, -18 + 40j, 60 + 40j]
        right = [-40 - 80j, *(near + along * at - across * gap for at in (first, second)), 60 - 30j]
        columns = {"x": [at.real for at in places], "y": [at.imag for at in places], "heading": headings}
        given = {"plan": {"t": [0.1 * i for i in range(6)], **columns}, "track": {
            side: [[at.real, at.imag] for at in line] for side, line in (("left", left), ("right", right))
        }}  # fmt: skip
        found = [one.case({"signals": given}).rules["inside"].margin for one in evaluators]
        assert all(margin is not None for margin in found)
        return [margin for margin in found if margin is not None]

    alone = margins(6.0, 2.0, 4.0)[0]
    for k in (-5, -4, -3):
        by_numpy, in_c = margins(alone + k * 1e-4, 1.2, 2.4)
        assert 0.04 < by_numpy < 0.06
        assert in_c == pytest.approx(by_numpy, abs=1e-9), k
