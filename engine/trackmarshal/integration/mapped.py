"""A planner's cycles, read: which parts stand for what the contract asks for, and the cycles that come of it."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trackmarshal.doubles import double
from trackmarshal.errors import TrackmarshalError
from trackmarshal.integration import records
from trackmarshal.integration.found import Array, Found, look, paths
from trackmarshal.integration.mapping import Column, columns
from trackmarshal.integration.names import likeness
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.trajectories.along import completed

#: A trajectory that ends slower than this, in m/s, may be meant to end at rest.
SLOW = 1.5
#: What is computed where a planner does not send it, and by which helper.
HELPERS = {
    "t": "time_along",
    "s": "arc_length",
    "heading": "direction_along",
    "kappa": "curvature_along",
    "a": "acceleration_along",
}


@dataclass(slots=True)
class Mapped:
    """Paths and columns of a planner's cycles. driving, emergency, ego, objects, left and right are paths; None: there is none."""

    founds: list[Found]
    #: What the contract has: fields by signal. What it does not have is neither asked for nor handed on.
    contract: Mapping[str, frozenset[str]]
    stamp: Column | None = None
    driving: str | None = None
    emergency: str | None = None
    plan: dict[str, Column] = field(default_factory=dict)
    #: Whether its times are on the stamps' clock; the contract's count from the stamp.
    absolute: bool = False
    ego: str | None = None
    ego_fields: dict[str, Column] = field(default_factory=dict)
    objects: str | None = None
    object_fields: dict[str, Column] = field(default_factory=dict)
    #: Where other vehicles would be: a list that was empty in all cycles.
    no_objects: str | None = None
    obstacles: str | None = None
    obstacle_fields: dict[str, Column] = field(default_factory=dict)
    #: Of objects and obstacles, which are mappings by id: the contract's are lists.
    keyed: set[str] = field(default_factory=set)
    left: str | None = None
    right: str | None = None
    #: Where borders come once, before the cycles.
    header: Found = field(default_factory=Found)
    others: list[str] = field(default_factory=list)

    @property
    def computed(self) -> list[str]:
        """Fields of the plan that it does not have and that follow from others."""
        return (
            [name for name in HELPERS if name not in self.plan and name in self.contract["plan"]]
            if {"x", "y", "v"} <= self.plan.keys()
            else []
        )

    def times(self) -> list[float]:
        """Stamps in s; without any, the numbers of the cycles by 0.1 s."""
        if self.stamp is None:
            return [0.1 * number for number in range(len(self.founds))]
        return [self.stamp.convert(one.records[""].get(self.stamp.column, math.nan)) for one in self.founds]

    def timeline(self, place: int, path: str | None) -> dict[str, Array] | None:
        """A trajectory of one cycle in the contract's terms; None where it is not there or cannot be completed."""
        raw = None if path is None else self.founds[place].timelines.get(path)
        if raw is None or any(column.column not in raw for column in self.plan.values()):
            return None
        made = {name: column.convert(raw[column.column]) for name, column in self.plan.items()}
        if self.absolute and "t" in made:
            made["t"] = made["t"] - self.times()[place]
        if not {"x", "y", "v"} <= made.keys():
            return self._declared(made)
        try:
            full = completed({name: list(map(float, values)) for name, values in made.items()})
        except TrackmarshalError:  # it stands, and nobody says where it points
            return self._declared(made)
        return self._declared({name: np.array(values) for name, values in full.items()})

    def _declared(self, columns: dict[str, Array]) -> dict[str, Array]:
        return {name: values for name, values in columns.items() if name in self.contract["plan"]}

    def border(self, place: int, path: str | None) -> Array | None:
        if path is None:
            return None
        return self.founds[place].lines.get(path, self.header.lines.get(path))

    @staticmethod
    def elements(found: Found, path: str | None, fields: dict[str, Column]) -> list[dict[str, Any]]:
        return [_element(item, fields) for item in found.sets.get(path, ())] if path is not None else []

    def cycle(self, place: int, t: float) -> Cycle:
        """One cycle as the Supervisor takes it; what is not there is None or left out."""
        found = self.founds[place]
        signals: dict[str, Any] = {}
        if "obstacles" in self.contract:
            signals["obstacles"] = self.elements(found, self.obstacles, self.obstacle_fields)
        record = found.records.get(self.ego) if self.ego is not None else None
        if record is not None:
            signals["ego"] = {
                n: value if isinstance(value := record.get(c.column, math.nan), str) else c.convert(value)
                for n, c in self.ego_fields.items()
            }
        if self.objects is not None or self.no_objects is not None:
            signals["objects"] = self.elements(found, self.objects, self.object_fields)
        left, right = self.border(place, self.left), self.border(place, self.right)
        if left is not None and right is not None:
            signals["track"] = {"left": left, "right": right}
        return Cycle(
            place, t, self.timeline(place, self.driving), self.timeline(place, self.emergency), signals
        )


def _element(item: Mapping[str, Any], fields: dict[str, Column]) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for name, column in fields.items():
        value = item.get(column.column)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        made[name] = column.convert(double(value)) if number and name != "id" else value  # type: ignore[arg-type]
    return made


def read(
    cycles: Sequence[Mapping[str, Any]], contract: Mapping[str, frozenset[str]], header: Mapping[str, Any] | None = None,
    driving: str | None = None, emergency: str | None = None,
) -> Mapped:  # fmt: skip
    """Look for everything that the contract has, which is fields by signal. driving, emergency: paths, where a person says them. Raises D196 where there is no trajectory."""
    made = Mapped([look(cycle) for cycle in cycles], contract, header=look(header or {}))
    there = [path for path, _ in paths(made.founds, "timelines")]
    for given in (driving, emergency):
        if given is not None and given not in there:
            raise TrackmarshalError(
                "D196", f"no cycle has a trajectory `{given}`", help=f"there are {', '.join(there) or 'none'}"
            )
    main = driving or (there[0] if there else None)
    if main is None:
        raise TrackmarshalError(
            "D196",
            "no cycle has a trajectory",
            help="one is three or more equally long columns of numbers, or a list of records or rows",
        )
    made.stamp = records.stamp(made.founds)
    # Trajectories with the columns of the main one are read alike; all of them are evidence.
    names = set(next(one.timelines[main] for one in made.founds if main in one.timelines))
    alike = [p for p in there if any(set(one.timelines.get(p, ())) == names for one in made.founds)]
    pool = [one.timelines[p] for one in made.founds for p in alike if set(one.timelines.get(p, ())) == names]
    made.plan = columns([one for one in pool if len(one[next(iter(names))]) >= 3] or pool)
    _candidates(made, alike, driving, emergency)
    made.absolute = _absolute(made)
    made.others = [p for p in there if p not in (made.driving, made.emergency)]
    _car(made)
    found = records.objects(made.founds, made.times(), made.plan) if "objects" in contract else None
    if found is not None:
        made.objects, fields = found
        made.object_fields = _of(fields, contract["objects"] | {"id"})
    elif "objects" in contract:
        empty = [
            (likeness(path.rpartition(".")[2], "objects"), path) for path, _ in paths(made.founds, "empty")
        ]
        made.no_objects = max((one for one in empty if one[0] >= 0.8), default=(0.0, None))[1]
    standing = records.obstacles(made.founds, made.objects, made.plan)
    if standing is not None and "obstacles" in contract:
        made.obstacles, fields = standing
        made.obstacle_fields = _of(fields, contract["obstacles"] | {"id"})
    there = [path for path in (made.objects, made.obstacles) if path is not None]
    made.keyed = {path for path in there if any(path in one.keyed for one in made.founds)}
    if "track" in contract:
        made.left, made.right = _borders(made)
    return made


def _of(fields: dict[str, Column], declared: Collection[str]) -> dict[str, Column]:
    return {name: column for name, column in fields.items() if name in declared}


def _absolute(made: Mapped) -> bool:
    """Whether times of trajectories go along with the stamps, of which there are two at least."""
    column = made.plan.get("t")
    if made.stamp is None or made.driving is None or column is None:
        return False
    plans = [one.timelines.get(made.driving, {}).get(column.column) for one in made.founds]
    begins = [
        (column.convert(float(p[0])), t) for p, t in zip(plans, made.times()) if p is not None and len(p)
    ]
    first, behind = np.array([b for b, _ in begins]), np.array([t - b for b, t in begins])
    found = np.isfinite(first) & np.isfinite(behind)
    return bool(found.any()) and float(np.ptp(behind[found])) < float(np.ptp(first[found]))


def _candidates(made: Mapped, alike: list[str], driving: str | None, emergency: str | None) -> None:
    """Which trajectory is which: by name, and by ending at rest."""

    def last(path: str) -> str:
        return path.rpartition(".")[2] or path

    def rests(path: str) -> float:
        v = made.plan.get("v")
        ends = [
            one.timelines[path][v.column][-1]
            for one in made.founds
            if v is not None and path in one.timelines and v.column in one.timelines[path]
        ]
        return (
            float(np.mean([abs(v.convert(float(end))) <= SLOW for end in ends]))
            if ends and v is not None
            else 0.0
        )

    if emergency is None:
        ranked = sorted(
            ((likeness(last(p), "emergency") + rests(p), -i, p) for i, p in enumerate(alike) if p != driving),
            reverse=True,
        )
        named = bool(ranked) and likeness(ranked[0][2].rpartition(".")[2], "emergency") >= 0.8
        if ranked and (named or (ranked[0][0] > 0.9 and len(alike) > 1)):
            emergency = ranked[0][2]
    rest = [p for p in alike if p != emergency]
    made.emergency = emergency
    made.driving = driving or max(
        rest, key=lambda p: (likeness(last(p), "driving"), -rest.index(p)), default=None
    )


def _car(made: Mapped) -> None:
    plans = [made.timeline(i, made.driving) for i in range(len(made.founds))]
    begins = [None if p is None or "x" not in p else (float(p["x"][0]), float(p["y"][0])) for p in plans]
    way = np.array([math.nan if p is None or "heading" not in p else p["heading"][0] for p in plans])
    found = records.ego(made.founds, begins, way, made.plan)
    if found is None:
        return
    made.ego, made.ego_fields = found
    if "v" in made.ego_fields:
        column = made.ego_fields["v"]
        said = np.array([one.records.get(made.ego, {}).get(column.column, math.nan) for one in made.founds])
        speeds = np.array([math.nan if p is None or "v" not in p else p["v"][0] for p in plans])
        made.ego_fields["v"] = records.speed_unit(said, speeds, column)


def _borders(made: Mapped) -> tuple[str | None, str | None]:
    """The two lines that are called left and right."""
    there = [*made.header.lines, *(p for p, _ in paths(made.founds, "lines"))]
    sides = []
    for side in ("left", "right"):
        ranked = [(likeness(p.rpartition(".")[2], side), -i, p) for i, p in enumerate(dict.fromkeys(there))]
        ranked = [one for one in ranked if one[0] >= 0.8]
        sides.append(max(ranked)[2] if ranked else None)
    return (sides[0], sides[1]) if sides[0] != sides[1] else (None, None)
