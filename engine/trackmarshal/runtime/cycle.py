"""A cycle as a caller hands it in, and the limits that the Supervisor holds cycles and itself to."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    from trackmarshal.ir.spec import Spec

#: The candidates, in the order in which they are judged.
DRIVING, EMERGENCY = "driving", "emergency"

#: The largest capacity: what numbers of entries are in C.
MOST = 2**31 - 1


@dataclass(frozen=True, slots=True)
class Cycle:
    """One cycle, unchecked: the door takes anything and says what is wrong with it.

    number counts cycles; t is the stamp in s, on the Supervisor's clock. driving, emergency: columns by field of the
    signal `plan`, in the declared units. signals: everything else that rules read, by signal. also: names (`objects`, `ego.kappa`) that
    whoever made the cycle knows of, whether the spec declares them or not; any other name that it does not declare is a fault.
    """

    number: Any
    t: Any
    driving: Any
    emergency: Any
    signals: Any
    also: frozenset[str] = frozenset()


#: The module in which a project declares limits, as parameters.
LIMITS_MODULE = "supervisor.limits"
#: The limits that are capacities, and what a capacity is of.
CAPACITIES = {"samples": "samples", "elements": "elements", "border": "points", "rate": "cycles a second"}

#: Every parameter has the value that its spec declares.
NO_PARAMS: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Limits:
    """Capacities, times in s, distances in m, angles in rad, speeds in m/s. Raises E481 for what cannot be a limit.

    What is left out has the default here; `Limits.of` takes those of a project.
    """

    #: The most samples of a timeline, elements of a set, and points of a border.
    samples: int = 128
    elements: int = 32
    border: int = 2048
    #: Cycles in a second that windows over the run have room for, in generated C; Python makes room as they come.
    rate: int = 50
    #: Shortest (more than this) and longest time from one stamp to the next; oldest stamp at arrival; how far a stamp may
    #: lie ahead of the clock.
    shortest_gap: float = 0.001
    longest_gap: float = 0.15
    oldest: float = 0.1
    clock_tolerance: float = 0.01
    #: Time from the arrival of a cycle to its verdict.
    budget: float = 0.05
    #: How far the first samples of the two candidates may differ.
    start_distance: float = 0.1
    start_turn: float = 0.05
    start_speed: float = 0.5
    #: Speed at the end of an emergency trajectory.
    rest_speed: float = 0.01
    #: Of the car and the stored emergency trajectory: how far along its path the car may be from where it is due, how far beside the
    #: path, how much turned and how much faster than it is there; and how long the car's pose may stay unknown.
    apart: float = 4.0
    beside: float = 1.5
    turned: float = 0.35
    overspeed: float = 5.0
    blind: float = 0.5

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            whole = field.name in CAPACITIES
            kinds, least, most = ((int,), 2, MOST) if whole else ((int, float), 0, math.inf)
            if type(value) in kinds and least <= value <= most and _is_double(value):
                continue
            wanted = (
                f"a whole number (int), from 2 to {MOST}"
                if whole
                else "a number (int or float), at least 0; inf takes the limit away"
            )
            raise TrackmarshalError(
                "E481",
                f"the limit `{field.name}` is {_shown(value)}",
                help=f"it is {wanted}",
            )

    @classmethod
    def of(cls, spec: Spec, **changes: Any) -> Limits:
        """The limits that a spec declares, with some changed; raises E481, and E485 where one that is declared is none.

        They are the parameters of its module `supervisor.limits`, by name.
        """
        declared: dict[str, Any] = {}
        for name, info in spec.params.items():
            module, _, short = name.rpartition(".")
            if module == LIMITS_MODULE:
                problem = _no_limit(short, info.value, info.unit)
                if problem:
                    raise TrackmarshalError(
                        "E485", problem[0], file=info.span.file.path, line=info.span.line, help=problem[1]
                    )
                declared[short] = int(info.value) if short in CAPACITIES else info.value
        for name in changes:
            if name not in UNITS:
                help_ = close_matches(name, UNITS) or f"there are {', '.join(UNITS)}"
                raise TrackmarshalError("E481", f"there is no limit `{name}`", help=help_)
        return cls(**{**declared, **changes})

    @staticmethod
    def given(spec: Spec, params: Mapping[str, float]) -> dict[str, float]:
        """Of parameters by their full names, those that declare limits of a spec, by the names of the limits."""
        named = {f"{LIMITS_MODULE}.{name}": name for name in UNITS}
        return {
            named[name]: int(value) if named[name] in CAPACITIES and value == int(value) else value
            for name, value in params.items()
            if name in named and name in spec.params
        }

    def declared(self, spec: Spec) -> dict[str, float]:
        """Those that a spec declares, by the names of its parameters, as they are here."""
        named = {f"{LIMITS_MODULE}.{name}": float(value) for name, value in asdict(self).items()}
        return {name: value for name, value in named.items() if name in spec.params}

    @classmethod
    def open_loop(cls, spec: Spec | None = None, params: Mapping[str, float] = NO_PARAMS) -> Limits:
        """For recordings of a car that did not follow the decisions: its pace and its pose say nothing about them.

        All others are those that the spec declares, with the values of its parameters where others are in force, so that a replay refuses what is refused in the car; capacities that it does not declare are
        open.
        """
        held = cls() if spec is None else cls.of(spec, **cls.given(spec, params))
        wide = {"samples": 10_000, "elements": 1_000, "border": 1_000_000, "rate": 1_000}
        declared = () if spec is None else [name for name in wide if f"{LIMITS_MODULE}.{name}" in spec.params]
        free: dict[str, Any] = {name: most for name, most in wide.items() if name not in declared}
        for name in ("longest_gap", "oldest", "clock_tolerance", "budget", "apart", "beside", "turned", "overspeed", "blind"):  # fmt: skip
            free[name] = math.inf
        return replace(held, shortest_gap=0.0, **free)


#: Every limit, and the SI unit that it is in.
UNITS = {
    "samples": "1", "elements": "1", "border": "1", "rate": "1", "shortest_gap": "s", "longest_gap": "s", "oldest": "s", "clock_tolerance": "s",
    "budget": "s", "start_distance": "m", "start_turn": "rad", "start_speed": "m/s", "rest_speed": "m/s", "apart": "m", "beside": "m",
    "turned": "rad", "overspeed": "m/s", "blind": "s",
}  # fmt: skip


def _is_double(value: float) -> bool:
    """Whether it is a number that can be added to a time: whole ones of Python have no end."""
    return type(value) is not int or abs(value) <= sys.float_info.max


def _shown(value: Any) -> str:
    return f"{value!r:.40}" if _is_double(value) else "beyond all doubles"


def _no_limit(name: str, value: float, unit: str) -> tuple[str, str] | None:
    """Why a parameter is no limit, and what to do; None where it is one."""
    from trackmarshal.units import parse_unit

    if name not in UNITS:
        help_ = close_matches(name, UNITS) or f"there are {', '.join(UNITS)}"
        return f"`{name}` is no limit of a Supervisor", help_
    if parse_unit(unit)[2] != parse_unit(UNITS[name])[2]:
        return f"the limit `{name}` is in {unit}, not in {UNITS[name]}", f"declare it in {UNITS[name]}"
    if name in CAPACITIES and not (2 <= value <= MOST and value == int(value)):
        return f"the limit `{name}` is {value:g}", f"it is a whole number, from 2 to {MOST}"
    return None
