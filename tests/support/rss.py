"""Distances of a reference RSS library (rss_dev.json) as data for `eval`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from support.seed import LENGTH, STRAIGHT, WIDTH, body

#: Kind of the oracle -> shipped rule.
RULES = {
    "longitudinal_same_direction": "safe_gap",
    "longitudinal_opposite_direction": "safe_gap_oncoming",
    "lateral": "safe_side",
}
#: Speed along the track while two cars drive side by side; any will do.
ALONGSIDE = 20.0


def data(case: Mapping[str, Any]) -> dict[str, Any]:
    """Two cars on a straight, as far apart as the case says, bumper to bumper or flank to flank."""
    place = {
        "longitudinal_same_direction": _following,
        "longitudinal_opposite_direction": _oncoming,
        "lateral": _alongside,
    }[case["kind"]]
    params, ego, other = place(case["inputs"])
    return {
        "id": case["id"],
        "params": {**params, "length": LENGTH, "width": WIDTH},
        "signals": {"ego": ego, "objects": [other], "track": STRAIGHT},
    }


Placed = tuple[dict[str, float], dict[str, float], dict[str, float]]


def _following(given: Mapping[str, float]) -> Placed:
    params = {
        "response": given["rho_rear"],
        "a_response": given["a_accel_max_rear"],
        "b_rear": given["b_min_rear"],
        "b_front": given["b_max_front"],
        "speed_cap": given["v_max_accel_rear"],
        "least_gap": given["min_safety_distance_rear"],
    }
    return params, _ego(0.0, given["v_rear"]), body(given["distance"] + LENGTH, 0.0, 0.0, given["v_front"])


def _oncoming(given: Mapping[str, float]) -> Placed:
    params = {
        "response": given["rho_correct"],
        "a_response": given["a_accel_max_correct"],
        "b_rear": given["b_min_correct"],
        "speed_cap": given["v_max_accel_correct"],
        "response_other": given["rho_other"],
        "a_other": given["a_accel_max_other"],
        "b_other": given["b_min_other"],
        "cap_other": given["v_max_accel_other"],
        "least_gap": max(given["min_safety_distance_correct"], given["min_safety_distance_other"]),
    }
    other = body(given["distance"] + LENGTH, 0.0, math.pi, given["v_other"])
    return params, _ego(0.0, given["v_correct"]), other


def _alongside(given: Mapping[str, float]) -> Placed:
    """The ego is the left one. Lateral speeds are positive to the right, here as headings to the right."""
    params = {
        "response": given["rho_left"],
        "a_lateral": given["a_accel_max_left"],
        "b_lateral": given["b_min_left"],
        "fluctuation": given["mu_left"],
        "response_other": given["rho_right"],
        "a_lateral_other": given["a_accel_max_right"],
        "b_lateral_other": given["b_min_right"],
        "fluctuation_other": given["mu_right"],
    }
    left, right = (-math.atan2(given[key], ALONGSIDE) for key in ("v_left", "v_right"))
    apart = given["distance"] + half_width(left) + half_width(right)
    other = body(0.0, -apart, right, math.hypot(given["v_right"], ALONGSIDE))
    return params, _ego(left, math.hypot(given["v_left"], ALONGSIDE)), other


def half_width(heading: float) -> float:
    """Half of what a car at an angle to the track takes up across it."""
    return (LENGTH * abs(math.sin(heading)) + WIDTH * abs(math.cos(heading))) / 2.0


def _ego(heading: float, v: float) -> dict[str, float]:
    return {"x": 0.0, "y": 0.0, "heading": heading, "v": v}
