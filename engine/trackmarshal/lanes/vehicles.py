"""Vehicles on a map, as the cycles that the rulebook `interstate` takes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.errors import TrackmarshalError
from trackmarshal.lanes import box
from trackmarshal.lanes.curve import distances
from trackmarshal.lanes.lanelet import MOST, Lanelet
from trackmarshal.lanes.network import Lane, Network
from trackmarshal.runtime.door import values

Array = NDArray[np.float64]
Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Vehicle:
    """A vehicle in a cycle: the centre of its box in m, heading in rad, speed along it in m/s (negative when it reverses), acceleration in m/s^2."""

    number: int
    x: float
    y: float
    heading: float
    v: float
    a: float
    length: float
    width: float
    truck: bool = False


@dataclass(frozen=True, slots=True)
class _Seen:
    """Where all vehicles are in one lane: (n,) each."""

    station: Array
    offset: Array
    heading: Array
    ahead: Array
    beside: Array

    def row(self, k: int, number: int, lane: Lane) -> Row:
        s, d, ahead, beside = (float(x[k]) for x in (self.station, self.offset, self.ahead, self.beside))
        return {
            "vehicle": number, "lane": lane.number, "front": s + ahead, "rear": s - ahead, "left": d + beside, "right": d - beside, "offset": d,
            "heading": float(self.heading[k]),
        }  # fmt: skip


def cycle(
    network: Network, t: float, ego: int, vehicles: Sequence[Vehicle], own: Mapping[int, int] | None = None
) -> Row:
    """A cycle at t (s) for `Evaluator.read`, of all vehicles that are there at t, the ego (by its number) among them.

    A vehicle is looked at in the lane of those that it occupies the middle of which is nearest to its centre, of equal ones the first; own, by the number
    of a vehicle, says otherwise. Raises TrackmarshalError D187.
    """
    _check(network, ego, vehicles, own or {})
    centre = np.array([(v.x, v.y) for v in vehicles], dtype=np.float64)
    heading = np.array([v.heading for v in vehicles], dtype=np.float64)
    size = np.array([(v.length, v.width) for v in vehicles], dtype=np.float64)
    corners = box.corners(centre, heading, size)
    touched = [_touched(network, k, corners, centre, heading, size) for k in range(len(vehicles))]
    seen = [_seen(lane, centre, heading, size) for lane in network.lanes]
    rows: dict[str, list[Row]] = {"vehicles": [], "own": [], "places": [], "occupied": [], "touched": []}
    for k, vehicle in enumerate(vehicles):
        number = vehicle.number
        if not touched[k]:
            raise _off(network, number)
        lanes = [lane for lane in network.lanes if not touched[k].isdisjoint(lane.lanelets)]
        nearest = min(lanes, key=lambda lane: (abs(float(seen[lane.number].offset[k])), lane.number))
        chosen = network.lanes[(own or {}).get(number, nearest.number)]
        rows["vehicles"].append(
            {"id": str(number), "number": number, "v": vehicle.v, "a": vehicle.a, "truck": vehicle.truck}
        )
        rows["own"].append(seen[chosen.number].row(k, number, chosen))
        rows["places"] += [seen[lane.number].row(k, number, lane) for lane in network.lanes]
        rows["occupied"] += [
            {
                "vehicle": number, "lane": lane.number, "heading": float(seen[lane.number].heading[k]),
                "to_left": float(distances(corners[k], lane.left).min()), "to_right": float(distances(corners[k], lane.right).min()),
            }
            for lane in lanes
        ]  # fmt: skip
        rows["touched"] += [{"vehicle": number, "lanelet": one} for one in sorted(touched[k])]
    at = next(centre[k] for k, vehicle in enumerate(vehicles) if vehicle.number == ego)
    roads = {network.roads[one] for each in touched for one in each}
    lanelets = [
        _lanelet(network, one, at)
        for number, one in sorted(network.lanelets.items())
        if network.roads[number] in roads
    ]
    return {"t": t, "signals": {"ego_vehicle": {"number": ego}, **rows, "lanelets": lanelets}}


def _seen(lane: Lane, centre: Array, heading: Array, size: Array) -> _Seen:
    station, offset, direction = lane.middle.places(centre)
    turned = np.remainder(heading - direction + math.pi, 2 * math.pi) - math.pi
    cos, sin = np.abs(np.cos(turned)), np.abs(np.sin(turned))
    length, width = size.T / 2
    return _Seen(station, offset, turned, length * cos + width * sin, width * cos + length * sin)


def _touched(
    network: Network, k: int, corners: Array, centre: Array, heading: Array, size: Array
) -> set[int]:
    """The lanelets that a box touches."""
    low, high = corners[k].min(axis=0), corners[k].max(axis=0)
    return {
        number
        for number, outline in network.outlines.items()
        if bool((outline.min(axis=0) <= high).all() and (outline.max(axis=0) >= low).all())
        and box.touches(centre[k], float(heading[k]), size[k], outline)
    }


def _lanelet(network: Network, lanelet: Lanelet, at: Array) -> Row:
    left, right, limit = lanelet.beside_left, lanelet.beside_right, lanelet.limit
    return {
        "number": lanelet.number, "road": network.roads[lanelet.number], "left": -1 if left is None else left, "right": -1 if right is None else right,
        "left_along": lanelet.along_left, "right_along": lanelet.along_right, "main": lanelet.main, "ramp": lanelet.ramp, "shoulder": lanelet.shoulder,
        "limited": limit is not None, "limit": 0.0 if limit is None else limit, "width": network.width(lanelet.number, at),
    }  # fmt: skip


def _check(network: Network, ego: int, vehicles: Sequence[Vehicle], own: Mapping[int, int]) -> None:
    where, known = network.where or None, set[int]()
    for vehicle in vehicles:
        number = vehicle.number
        if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < MOST:
            raise TrackmarshalError(
                "D187",
                f"`{number!s:.40}` is no number of a vehicle",
                file=where,
                help="numbers are whole, from 0 on",
            )
        if number in known:
            raise TrackmarshalError(
                "D187", f"vehicle {number} stands twice", file=where, help="a number is that of one vehicle"
            )
        known.add(number)
        for name in ("x", "y", "heading", "v", "a", "length", "width"):
            value = getattr(vehicle, name)
            if not math.isfinite(value) or (name in ("length", "width") and value <= 0.0):
                raise TrackmarshalError(
                    "D187", f"vehicle {number} has a {name} of {value}", file=where, help="pose, speed and acceleration are finite, sizes greater than zero"
                )  # fmt: skip
        if lost := values.rounded([vehicle.x, vehicle.y, vehicle.length, vehicle.width]):
            raise TrackmarshalError(
                "D187", f"vehicle {number}: {lost}", file=where, help="give its numbers as float64"
            )
    if ego not in known:
        raise TrackmarshalError(
            "D187",
            f"the ego, {ego}, is none of the vehicles",
            file=where,
            help="it is one of those that are handed in",
        )
    for number, lane in own.items():
        if not 0 <= lane < len(network.lanes):
            raise TrackmarshalError(
                "D187",
                f"vehicle {number} is to be looked at in lane {lane}",
                file=where,
                help=f"the map has {len(network.lanes)} lanes, from 0 on",
            )


def _off(network: Network, number: int) -> TrackmarshalError:
    return TrackmarshalError(
        "D187", f"vehicle {number} touches no lanelet", file=network.where or None, help="leave out who is off the map, and stop judging when the ego is"
    )  # fmt: skip
