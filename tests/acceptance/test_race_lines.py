"""Friction on two race lines that were planned with 13.50 m/s^2 of grip: enough at 13.51, too little at 13.49."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from support import race_line
from support.command import close, evaluate, number
from support.length import at_length
from support.shared import SUPERVISOR, shared

pytestmark = pytest.mark.verifies("S-1-A-4")

LINES = ("ltpl_berlin.csv", "ltpl_modena.csv")
POINTS = 50
MASS = 1000.0
ENOUGH, TOO_LITTLE = 13.51, 13.49


def case(identity: int, plan: race_line.Columns, grip: float) -> dict[str, Any]:
    """A trajectory on a road with mu * g = grip, exactly; without drag, which eq. (2) does not know."""
    return {
        "id": identity,
        "params": {"mu": 1.0, "g": grip, "mass": MASS, "drag": 0.0},
        "signals": {"plan": plan},
    }


def asked(lap: race_line.Columns) -> list[float]:
    """The combined acceleration that the line asks for at each place, by eq. (2), in m/s^2."""
    return [math.hypot(a, v * v * kappa) for a, v, kappa in zip(lap["a"], lap["v"], lap["kappa"])]


def friction(folder: Path, plans: list[race_line.Columns], grip: float, backend: str) -> list[dict[str, Any]]:
    cases = [case(index, plan, grip) for index, plan in enumerate(plans)]
    return [line["rules"]["friction"] for line in evaluate(folder, SUPERVISOR, cases, ["friction"], backend)]


@pytest.mark.parametrize("backend", [at_length("reference"), "numpy", "c"])
@pytest.mark.parametrize("name", LINES)
def test_trajectories(name: str, backend: str, tmp_path: Path) -> None:
    """Every place in one of the trajectories; the verdict, margin and witness of each."""
    lap = race_line.read(shared("data", "tracks", name))
    needs = asked(lap)
    cuts = list(race_line.cut(lap, POINTS))
    assert {place for places, _ in cuts for place in places} == set(range(len(needs)))
    assert all(len(places) == POINTS for places, _ in cuts)

    plans = [plan for _, plan in cuts]
    assert {found["verdict"] for found in friction(tmp_path, plans, ENOUGH, backend)} == {"satisfied"}

    violated = 0
    for (places, _), found in zip(cuts, friction(tmp_path, plans, TOO_LITTLE, backend), strict=True):
        most = max(places, key=lambda place: needs[place])
        assert found["verdict"] == ("violated" if needs[most] > TOO_LITTLE else "satisfied")
        assert places[found["witness"]["p"]] == most
        assert close(number(found["margin"]), MASS * (TOO_LITTLE - needs[most]))
        violated += found["verdict"] == "violated"
    assert 0 < violated < len(cuts)


@pytest.mark.parametrize("backend", [at_length("reference"), "numpy", "c"])
@pytest.mark.parametrize("line", LINES)
def test_places(line: str, backend: str, tmp_path: Path) -> None:
    """Place by place, each as a trajectory that has only this place: violated exactly where more is asked for."""
    lap = race_line.read(shared("data", "tracks", line))
    count = len(lap["v"])
    plans = [{name: [column[place]] * 2 for name, column in lap.items()} for place in range(count)]
    for grip in (ENOUGH, TOO_LITTLE):
        found = friction(tmp_path, plans, grip, backend)
        assert {result["verdict"] for result in found} <= {"satisfied", "violated"}
        violated = {place for place, result in enumerate(found) if result["verdict"] == "violated"}
        assert violated == {place for place, need in enumerate(asked(lap)) if need > grip}
        assert bool(violated) == (grip == TOO_LITTLE)
        # These are the places where the line asks for all of its 13.50 m/s^2, up to its rounding.
        assert all(abs(asked(lap)[place] - 13.5) < 0.01 for place in violated)
