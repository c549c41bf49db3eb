"""The rules of `rulebooks.racing` in made-up duels, of which a plain simulation of two cars knows who moved where and who passed whom."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from support.length import at_length, shared_out
from support.shared import REPOSITORY
from trackmarshal.evaluation import Evaluator, load

STEP = 0.1
RULES = ["one_move", "no_overtaking_under_yellow", "gives_back", "leaves_room"]
#: Where something is along a road and beside its middle, over time.
Way = Callable[[float], tuple[float, float]]


class Road:
    """Straights and bends to the left by turns, from station 0 at the origin on: of each straight its length, and the radius of the quarter circle behind it."""

    def __init__(self, pieces: Sequence[tuple[float, float]], width: float = 14.0) -> None:
        self.width, self._pieces = width, list[tuple[float, float, float, float, float, float]]()
        s = x = y = h = 0.0
        for straight, radius in pieces:
            for length, kappa in ((straight, 0.0), (radius * math.pi / 2, 1 / radius)):
                self._pieces.append((s, length, x, y, h, kappa))
                x, y, h = self._on(x, y, h, kappa, length)
                s += length
        self.length = s

    @staticmethod
    def _on(x: float, y: float, h: float, kappa: float, way: float) -> tuple[float, float, float]:
        if not kappa:
            return x + way * math.cos(h), y + way * math.sin(h), h
        g = h + kappa * way
        return x + (math.sin(g) - math.sin(h)) / kappa, y + (math.cos(h) - math.cos(g)) / kappa, g

    def at(self, s: float, d: float) -> tuple[float, float, float]:
        """x, y and the direction of the road, d to the left of its middle; before its beginning and beyond its end it goes straight on."""
        begin, _, x, y, h, kappa = next(
            (one for one in reversed(self._pieces) if one[0] <= s), self._pieces[0]
        )
        x, y, h = self._on(x, y, h, kappa, s - begin)
        return x - d * math.sin(h), y + d * math.cos(h), h

    @property
    def borders(self) -> dict[str, Any]:
        places = [-150.0 + 5.0 * i for i in range(int((self.length + 350.0) / 5.0))]
        left, right = ([list(self.at(s, side * self.width / 2)[:2]) for s in places] for side in (1, -1))
        return {"left": left, "right": right}

    def drives(self, way: Way, t: float) -> dict[str, float]:
        """Position, heading and speed of what goes its way."""
        (x0, y0, _), (x, y, _), (x1, y1, _) = (self.at(*way(u)) for u in (t - 1e-3, t, t + 1e-3))
        return {
            "x": x,
            "y": y,
            "heading": math.atan2(y1 - y0, x1 - x0),
            "v": math.hypot(x1 - x0, y1 - y0) / 2e-3,
        }


@cache
def evaluator(specs: Path = REPOSITORY / "specs", backend: str = "numpy") -> Evaluator:
    return Evaluator(load([specs / "rulebooks" / "racing.spec"]), RULES, backend)


def said(
    road: Road,
    ego: Way,
    other: Way,
    until: float,
    yellow: bool = False,
    lost: Sequence[int] = (),
    unseen: Sequence[int] = (),
    by: Evaluator | None = None,
) -> list[dict[str, str] | None]:
    """What the rules say in every cycle; None: it was lost, or the other car was not seen in it. The plan is what the car does, and lies about its curvature."""
    one, borders = by or evaluator(), road.borders
    run, found = one.over_run(), list[dict[str, str] | None]()
    for k in range(round(until / STEP)):
        if k in lost:
            run.missed()
            found.append(None)
            continue
        t = k * STEP
        ahead = [road.drives(ego, t + 0.25 * i) for i in range(11)]
        plan = {name: [one[name] for one in ahead] for name in ("x", "y", "heading", "v")}
        plan |= {
            "t": [0.25 * i for i in range(11)],
            "s": [0.25 * i * ahead[0]["v"] for i in range(11)],
            "a": [0.0] * 11,
        }
        plan |= {"kappa": [0.05 * (-1.0) ** i for i in range(11)], "grip": [1.0] * 11}
        there = (
            []
            if k in unseen
            else [{"id": "o", **road.drives(other, t), "length": 4.7, "width": 2.0, "age": 0.0}]
        )
        signals = {
            "ego": {**ahead[0], "age": 0.0}, "objects": there, "track": borders, "plan": plan,
            "yellow_sectors": [{"id": "0", "from": 0.0, "to": road.length + 150.0}] if yellow else [],
        }  # fmt: skip
        rules = run.step(one.read({"t": round(t, 3), "signals": signals})).rules
        found.append(None if k in unseen else {name: rules[name].verdict for name in RULES})
    return found


def smooth(share: float) -> float:
    """From 0 to 1, without a jump of the speed."""
    s = min(1.0, max(0.0, share))
    return (1 - math.cos(math.pi * s)) / 2


STRAIGHT = Road([(3000.0, 50.0)])


def weaving(v: float, far: float, half: float, swings: int) -> Way:
    """From 1 s on, `far` to the left and back again, `half` seconds each."""

    def way(t: float) -> tuple[float, float]:
        done = min(max(0.0, (t - 1.0) / half), swings)
        whole = min(int(done), swings - 1)
        share = smooth(done - whole)
        return 50.0 + v * t, far * (share if whole % 2 == 0 else 1 - share)

    return way


def behind(way: Way, gap: float, gains: float = 0.1) -> Way:
    """A car on the middle of the road that comes nearer."""
    return lambda t: (way(t)[0] - gap + gains * t, 0.0)


@pytest.mark.parametrize("v", [at_length(10.0), 30.0, at_length(80.0)])
@pytest.mark.parametrize(
    ("far", "half"), shared_out([(1.5, 0.9), (1.5, 2.0), (1.5, 8.0), (-3.0, 1.5), (6.0, 10.0)], 3)
)
def test_who_weaves_on_a_straight_is_found_in_the_second_swing(v: float, far: float, half: float) -> None:
    ego = weaving(v, far, half, 2)
    verdicts = [row["one_move"] for row in said(STRAIGHT, ego, behind(ego, 20.0), 1.5 + 2 * half) if row]
    first = verdicts.index("violated") * STEP
    assert 1.0 + half < first <= 1.0 + 2 * half + STEP
    assert set(verdicts[: round(first / STEP)]) == {"satisfied"}


@pytest.mark.parametrize(("far", "half"), [(1.5, 0.9), (-3.0, 1.5), (6.0, 10.0)])
def test_one_move_is_allowed(far: float, half: float) -> None:
    ego = weaving(30.0, far, half, 1)
    rows = said(STRAIGHT, ego, behind(ego, 20.0), 3.0 + half)
    assert {row["one_move"] for row in rows if row} == {"satisfied"}


CIRCUIT = Road([(300.0, 30.0), (150.0, 60.0), (250.0, 30.0)])
#: Where its corners begin and end.
CORNERS = [(begin, begin + length) for begin, length, *_, kappa in CIRCUIT._pieces if kappa]


def race_line(s: float) -> float:
    """From the outside of each corner to its inside and out again; between two of them, the car stays outside."""
    return -4.0 + 8.0 * max(
        smooth((s - a + 40) / ((b - a) / 2 + 40)) * smooth((b + 40 - s) / ((b - a) / 2 + 40))
        for a, b in CORNERS
    )


@pytest.mark.acceptance  # a straight one every day
def test_a_race_line_through_corners_is_no_change_of_line() -> None:
    def ego(t: float) -> tuple[float, float]:
        return 18.0 * t, race_line(18.0 * t)

    def other(t: float) -> tuple[float, float]:
        return 18.02 * t - 15.0, race_line(18.02 * t - 15.0)

    verdicts = [row["one_move"] for row in said(CIRCUIT, ego, other, CIRCUIT.length / 18.0) if row]
    assert verdicts.count("satisfied") > 0.9 * len(verdicts)
    assert {*verdicts} == {"satisfied", "inactive"}


@pytest.mark.parametrize(("back", "found"), [(40.0, False), (150.0, True)])
def test_back_to_the_race_line_is_for_the_approach(back: float, found: bool) -> None:
    """One move to the inside on the straight of 300 m, and back from so far before the corner on."""

    def ego(t: float) -> tuple[float, float]:
        s = 10.0 + 30.0 * t
        return s, -4.0 + 6.0 * smooth((s - 60.0) / 60.0) * (1 - smooth((s - 300.0 + back) / 40.0))

    verdicts = [row["one_move"] for row in said(CIRCUIT, ego, behind(ego, 20.0), 9.5) if row]
    assert ("violated" in verdicts) is found
    assert {*verdicts} <= {"satisfied", "violated"}


def passing(t: float) -> tuple[float, float]:
    """Past the other one at 2 s, and on."""
    return 50.0 + 25.0 * t, -2.0


def passed(t: float) -> tuple[float, float]:
    return 60.0 + 20.0 * t, 2.0


def follows(t: float) -> tuple[float, float]:
    """40 m behind all along."""
    return 10.0 + 25.0 * t, 2.0


@pytest.mark.parametrize("lost", [at_length([]), at_length([30]), at_length([19, 20, 21]), [5, 20, 35, 60]])
def test_lost_cycles_change_no_place(lost: list[int]) -> None:
    """Who is behind all along stays so, and whoever was passed, in a lost cycle too, is to be given the place back 5 s later."""
    rows = said(STRAIGHT, passing, follows, 9.0, yellow=True, lost=lost)
    assert {row["gives_back"] for row in rows if row} == {"inactive"}
    rows = said(STRAIGHT, passing, passed, 9.0, yellow=True, lost=lost)
    for k, row in enumerate(rows):
        t = k * STEP
        if row is not None and not 1.9 < t < 2.5 and not 6.9 < t < 7.5:
            assert row["gives_back"] == ("inactive" if t < 2 else "satisfied" if t < 7 else "violated"), t


def test_after_a_long_gap_nobody_knows() -> None:
    rows = said(STRAIGHT, passing, passed, 6.0, yellow=True, lost=range(10, 40))
    assert {row["gives_back"] for row in rows[40:] if row} == {"undefined"}


@pytest.fixture(scope="session")
def forgetting(tmp_path_factory: pytest.TempPathFactory) -> Evaluator:
    """The same rules where perception may lose cars for a second."""
    specs = tmp_path_factory.mktemp("racing") / "specs"
    shutil.copytree(REPOSITORY / "specs", specs, ignore=shutil.ignore_patterns("scenarios"))
    path = specs / "supervisor" / "interface.spec"
    text = path.read_text("utf-8")
    if "forget" not in text:
        head, mark, tail = text.partition("signal objects")
        declared, end, rest = tail.partition("}")
        path.write_text(f"{head}{mark}{declared}{end} capacity 32 forget 1 s{rest}", "utf-8")
    return evaluator(specs)


@pytest.mark.parametrize("unseen", [at_length([20]), [18, 19, 20, 21, 22], at_length([5, 20, 40, 41])])
def test_who_is_not_seen_for_a_moment_is_who_it_was(unseen: list[int], forgetting: Evaluator) -> None:
    rows = said(STRAIGHT, passing, passed, 9.0, yellow=True, unseen=unseen, by=forgetting)
    for k, row in enumerate(rows):
        t = k * STEP
        if row is not None and not 1.9 < t < 2.5 and not 6.9 < t < 7.5:
            assert row["gives_back"] == ("inactive" if t < 2 else "satisfied" if t < 7 else "violated"), t
    ego = weaving(30.0, 3.0, 2.0, 2)
    rows = said(STRAIGHT, ego, behind(ego, 20.0), 6.0, unseen=unseen, by=forgetting)
    assert {row["one_move"] for row in rows[:35] if row} == {"satisfied"}
    assert {row["one_move"] for row in rows[45:] if row} == {"violated"}


def test_a_car_that_is_squeezed_is_squeezed_after_it_was_not_seen(forgetting: Evaluator) -> None:
    """Alongside on the way into a corner, and then pushed to the edge."""

    def ego(t: float) -> tuple[float, float]:
        return 250.0 + 15.0 * t, 3.5 * smooth((t - 1.5) / 1.0)

    def other(t: float) -> tuple[float, float]:
        return 250.0 + 15.0 * t, 5.0

    rows = said(CIRCUIT, ego, other, 3.0, unseen=[12, 13], by=forgetting)
    assert "violated" in [row["leaves_room"] for row in rows[14:] if row]
