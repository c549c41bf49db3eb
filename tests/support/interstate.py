"""The interstate oracle's scenes as cycles of the rulebook `interstate`, by the oracle's own numbers along lanes."""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Sequence
from functools import cache
from typing import Any

from support.shared import shared
from trackmarshal.lanes import Lanelet, Network, Vehicle, cycle

Scene = dict[str, Any]
Cycle = dict[str, Any]
RULES = ("R_G1", "R_G2", "R_G3", "R_G4", "R_I1", "R_I2", "R_I3", "R_I4", "R_I5")


@cache
def scenes() -> list[Scene]:
    """All scenes; the test is skipped, saying so, where the file is absent."""
    content = json.loads(gzip.decompress(shared("oracles", "interstate_dev.json.gz").read_bytes()))
    found: list[Scene] = content["scenarios"]
    return found


def unrolled(runs: list[list[Any]]) -> list[Any]:
    """[[count, value], ...], written out."""
    return [value for count, value in runs for _ in range(count)]


def corners(x: float, y: float, heading: float, length: float, width: float) -> list[tuple[float, float]]:
    cos, sin = math.cos(heading), math.sin(heading)
    return [
        (x + along * cos - beside * sin, y + along * sin + beside * cos)
        for along, beside in (
            (length / 2, width / 2),
            (length / 2, -width / 2),
            (-length / 2, -width / 2),
            (-length / 2, width / 2),
        )
    ]


def nearest(point: tuple[float, float], line: Sequence[Sequence[float]]) -> float:
    """How far a point is from a line of points."""
    best = math.inf
    for (x, y), (u, v) in zip(line, line[1:]):
        du, dv = u - x, v - y
        square = du * du + dv * dv
        share = (
            0.0 if square == 0.0 else min(1.0, max(0.0, ((point[0] - x) * du + (point[1] - y) * dv) / square))
        )
        best = min(best, math.hypot(point[0] - x - share * du, point[1] - y - share * dv))
    return best


def crossing_width(lanelet: Scene, point: tuple[float, float]) -> float:
    """How wide a lanelet is beside a point: between its bounds, at the place on its middle that is nearest."""
    best, width = math.inf, 0.0
    rungs = list(zip(lanelet["left"], lanelet["right"]))
    for ((a, b), (c, d)), ((e, f), (g, h)) in zip(rungs, rungs[1:]):
        x, y, u, v = (a + c) / 2, (b + d) / 2, (e + g) / 2, (f + h) / 2
        du, dv = u - x, v - y
        share = ((point[0] - x) * du + (point[1] - y) * dv) / (du * du + dv * dv)
        share = min(1.0, max(0.0, share))
        away = math.hypot(point[0] - x - share * du, point[1] - y - share * dv)
        if away < best:
            best = away
            wide, long = math.hypot(a - c, b - d), math.hypot(e - g, f - h)
            width = wide + share * (long - wide)
    return width


def roads(scene: Scene) -> dict[int, int]:
    """By lanelet, a number that all lanelets beside it share."""
    found: dict[int, int] = {}
    known = {one["id"]: one for one in scene["lanelets"]}
    for start in known:
        waiting = [start]
        while waiting:
            number = waiting.pop()
            if number in found or number not in known:
                continue
            found[number] = start
            waiting += [n for n in (known[number]["adj_left"], known[number]["adj_right"]) if n is not None]
    return found


def state(vehicle: Scene, k: int, lane: int) -> dict[str, float]:
    """Where a vehicle is in a lane, by the stored numbers."""
    along = vehicle["curv"][lane]
    s, d, th = along["s"][k], along["d"][k], along["th"][k]
    length, width = vehicle["length"], vehicle["width"]
    ahead = length / 2 * abs(math.cos(th)) + width / 2 * abs(math.sin(th))
    beside = width / 2 * abs(math.cos(th)) + length / 2 * abs(math.sin(th))
    return {
        "front": s + ahead, "rear": s - ahead, "left": d + beside, "right": d - beside, "offset": d, "heading": th,
    }  # fmt: skip


def cycles(scene: Scene, ego: int, first: int, count: int) -> list[Cycle]:
    """The cycles of one run, from the oracle's own stations, offsets, headings and occupancy."""
    rle = {
        v["id"]: {name: unrolled(v[name]) for name in ("lanelets", "lanes", "ref_lane")}
        for v in scene["vehicles"]
    }
    known, road = {one["id"]: one for one in scene["lanelets"]}, roads(scene)
    bounds = [
        [[p for number in lane["lanelets"] for p in known[number][side]] for side in ("left", "right")]
        for lane in scene["lanes"]
    ]
    found = []
    for step in range(first, first + count):
        there = [(v, step - v["t0"]) for v in scene["vehicles"] if 0 <= step - v["t0"] < len(v["x"])]
        vehicles, own, places, occupied, touched = [], [], [], [], []
        at = next((v["x"][k], v["y"][k]) for v, k in there if v["id"] == ego)
        for v, k in there:
            number, lists = v["id"], rle[v["id"]]
            vehicles.append(
                {
                    "id": number, "number": number, "v": v["v"][k], "a": v["a"][k], "truck": v["type"] == "truck",
                }
            )  # fmt: skip
            own.append({"vehicle": number, "lane": lists["ref_lane"][k], **state(v, k, lists["ref_lane"][k])})
            for lane in range(len(scene["lanes"])):
                places.append({"vehicle": number, "lane": lane, **state(v, k, lane)})
            box = corners(v["x"][k], v["y"][k], v["heading"][k], v["length"], v["width"])
            for lane in lists["lanes"][k]:
                left, right = (min(nearest(c, line) for c in box) for line in bounds[lane])
                occupied.append(
                    {
                        "vehicle": number, "lane": lane, "heading": v["curv"][lane]["th"][k],
                        "to_left": left, "to_right": right,
                    }
                )  # fmt: skip
            touched += [{"vehicle": number, "lanelet": one} for one in lists["lanelets"][k]]
        used = {one["lanelet"] for one in touched}
        lanelets = [
            {
                "number": n, "road": road[n], "left": -1 if one["adj_left"] is None else one["adj_left"],
                "right": -1 if one["adj_right"] is None else one["adj_right"],
                "left_along": bool(one["adj_left_same_dir"]), "right_along": bool(one["adj_right_same_dir"]),
                "main": "mainCarriageWay" in one["types"], "ramp": "accessRamp" in one["types"],
                "shoulder": "shoulder" in one["types"], "limited": one["speed_limit"] is not None,
                "limit": one["speed_limit"] or 0.0, "width": crossing_width(one, at),
            }
            for n, one in known.items() if road[n] in {road[u] for u in used}
        ]  # fmt: skip
        found.append(
            {
                "id": step - first, "t": step * scene["dt"],
                "signals": {
                    "ego_vehicle": {"number": ego}, "vehicles": vehicles, "own": own, "places": places, "occupied": occupied,
                    "touched": touched, "lanelets": lanelets,
                },
            }
        )  # fmt: skip
    return found


def mapped(scene: Scene) -> Network:
    """The scene's map, as ours."""
    return Network(
        [
            Lanelet(
                one["id"], one["left"], one["right"], tuple(one["succ"]), one["adj_left"], one["adj_right"],
                one["adj_left_same_dir"] is not False, one["adj_right_same_dir"] is not False, "mainCarriageWay" in one["types"],
                "accessRamp" in one["types"], "shoulder" in one["types"], one["speed_limit"],
            )
            for one in scene["lanelets"]
        ],
        scene["name"],
    )  # fmt: skip


def measured(scene: Scene, ego: int, first: int, count: int) -> list[Cycle]:
    """The cycles of one run, measured anew on the map: of the oracle, poses, speeds, accelerations, sizes and lanelets alone."""
    network, found = mapped(scene), []
    for step in range(first, first + count):
        there = [
            Vehicle(
                v["id"], v["x"][k], v["y"][k], v["heading"][k], v["v"][k], v["a"][k], v["length"], v["width"], v["type"] == "truck"
            )
            for v in scene["vehicles"]
            if 0 <= (k := step - v["t0"]) < len(v["x"])
        ]  # fmt: skip
        found.append({"id": step - first, **cycle(network, step * scene["dt"], ego, there)})
    return found
