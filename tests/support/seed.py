"""The paper's worked cases (seed_dev.json) as data for `eval`, in the conventions of its head."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

#: Oracle check -> shipped rule, for the kind `trajectory`.
TRAJECTORY_RULES = {
    "friction": "friction",
    "turn_radius": "turn_radius",
    "ax_max": "drive_acceleration",
    "ax_min": "braking_limit",
    "v_max": "speed_limit",
    "v_min": "no_reversing",
    "localisation": "pose_match",
    "localisation_polyline": "pose_on_path",
}
#: Column of the oracle -> column of the signal `plan`.
_COLUMNS = {"x": "x", "y": "y", "psi": "heading", "kappa": "kappa", "v": "v", "ax": "a"}
_LIMITS = {"m": "mass", "r_min": "R_min", "brake_max": "b_max", "v_max": "v_max", "d_loc": "d_loc"}

#: Both vehicles of the longitudinal cases; only the gap between them matters.
LENGTH, WIDTH = 4.7, 2.8
#: A straight track along +x, long enough for every gap.
STRAIGHT = {"left": [[-100.0, 10.0], [2000.0, 10.0]], "right": [[-100.0, -10.0], [2000.0, -10.0]]}


def trajectory(case: Mapping[str, Any]) -> dict[str, Any]:
    """A trajectory, the car's position and its limits. No drag, no allowance, g as the oracle's head says."""
    given, limits = case["inputs"], case["inputs"]["limits"]
    params = {name: limits[key] for key, name in _LIMITS.items()}
    columns = {name: given["trajectory"][key] for key, name in _COLUMNS.items()}
    mu, grip = friction(limits["mu"], len(columns["x"]))
    return {
        "id": case["id"],
        "params": {**params, "mu": mu, "g": 9.81, "drag": 0.0, "drive_factor": 1.0},
        "tables": {"ax_max": limits["ax_max_table"]},
        "signals": {
            "plan": {**columns, "grip": grip},
            "ego": {"x": given["ego"][0], "y": given["ego"][1]},
        },
    }


def friction(mu: float | Sequence[float], count: int) -> tuple[float, list[float]]:
    """A reference friction, and each sample's share of it. The reference is a power of two, so products are exact."""
    values = [mu] * count if isinstance(mu, float) else list(mu)
    assert len(values) == count
    reference = 2.0 ** math.ceil(math.log2(max(values)))
    return reference, [value / reference for value in values]


def following(case: Mapping[str, Any]) -> dict[str, Any]:
    """Two cars one behind the other on a straight, `d` apart from bumper to bumper."""
    given = case["inputs"]
    return {
        "id": case["id"],
        "params": {
            "response": given["rho"],
            "a_response": given["a_r_acc"],
            "b_rear": given["a_r_br"],
            "b_front": given["a_f_br"],
            "speed_cap": 1000.0,
            "least_gap": 0.0,
            "length": LENGTH,
            "width": WIDTH,
        },
        "signals": {
            "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": given["v_r"]},
            "objects": [body(given["d"] + LENGTH, 0.0, 0.0, given["v_f"])],
            "track": STRAIGHT,
        },
    }


def rectangles(case: Mapping[str, Any]) -> dict[str, Any]:
    """Two rectangles at rest."""
    given = case["inputs"]
    length, width = given["ego_size"]
    return {
        "id": case["id"],
        "params": {"length": length, "width": width},
        "signals": {
            "ego": _pose(given["ego"]),
            "objects": [{**_pose(given["obstacle"]), **_size(given["obstacle_size"])}],
        },
    }


def corridor(case: Mapping[str, Any]) -> dict[str, Any]:
    """A car at rest on a track: the ring is one border and the other one backwards."""
    given = case["inputs"]
    ring, (length, width) = given["ring"], given["size"]
    half = len(ring) // 2
    assert len(ring) == 2 * half
    x, y, heading = given["pose"]
    return {
        "id": case["id"],
        "params": {"length": length, "width": width},
        "signals": {
            "plan": {"x": [x, x], "y": [y, y], "heading": [heading, heading]},
            "track": {"left": ring[:half], "right": ring[half:][::-1]},
        },
    }


def body(x: float, y: float, heading: float, v: float) -> dict[str, float]:
    """Another car of the same size."""
    return {"x": x, "y": y, "heading": heading, "v": v, "length": LENGTH, "width": WIDTH}


def _pose(values: Sequence[float]) -> dict[str, float]:
    x, y, heading = values
    return {"x": x, "y": y, "heading": heading}


def _size(values: Sequence[float]) -> dict[str, float]:
    length, width = values
    return {"length": length, "width": width}
