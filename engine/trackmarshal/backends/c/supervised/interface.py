"""The header of a Supervisor in C: a cycle as it comes, limits, configuration, the context's memory, and the decision."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import comment
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.runtime.cycle import CAPACITIES, LIMITS_MODULE, Limits
from trackmarshal.runtime.decision import MOST_REASONS
from trackmarshal.runtime.faults import FAULTS
from trackmarshal.runtime.machine import STATES

#: Limits that are numbers; capacities are macros in C.
LIMITS: dict[str, float] = {
    field.name: getattr(Limits(), field.name) for field in fields(Limits) if field.name not in CAPACITIES
}
_MEANING = {
    "shortest_gap": "s, stamps that are nearer to each other are one",
    "longest_gap": "s, the longest time from one stamp to the next",
    "oldest": "s, the oldest stamp at arrival",
    "clock_tolerance": "s, how far a stamp may lie ahead of the clock",
    "budget": "s, the longest time from the arrival of a cycle to its verdict",
    "start_distance": "m, how far apart the candidates may start",
    "start_turn": "rad, the same of their headings",
    "start_speed": "m/s, the same of their speeds",
    "rest_speed": "m/s, the most speed at the end of an emergency trajectory",
    "apart": "m, how far along the stored trajectory's path the car may be from where it is due",
    "beside": "m, how far beside that path",
    "turned": "rad, how far it may be turned against it",
    "overspeed": "m/s, how much faster than it is there, or how fast the other way",
    "blind": "s, how long no pose may confirm it",
}


def declared(plan: Layout) -> dict[str, str]:
    """Limits that parameters of the program declare, with the parameters' names."""
    return {limit: name for limit in LIMITS if (name := f"{LIMITS_MODULE}.{limit}") in plan.params}


def in_force(plan: Layout, params: Mapping[str, float], limits: Mapping[str, float]) -> dict[str, float]:
    """What the program's parameters are with these, in its order: those that declare a limit are the limit, where it is finite."""
    held = {name: limits[limit] for limit, name in declared(plan).items() if limits[limit] < math.inf}
    return {name: held.get(name, params.get(name, plan.spec.params[name].value)) for name in plan.params}


#: Names of faults by their number in C.
FAULT_NAMES = ("none", *FAULTS)
#: The member of what is stored that says when each sample is due.
DUE = "due"


def said(plan: Layout) -> dict[str, Any]:
    """What the header's templates ask about a Supervisor."""
    tables = []
    for name, c_name in plan.tables.items():
        units = " over ".join(comment(unit) for unit in reversed(plan.spec.tables[name].units))
        tables.append((c_name, f"{units}; {comment(name)} {comment(str(plan.spec.tables[name].span))}"))
    return {
        "faults": FAULTS, "limits": LIMITS, "meaning": _MEANING, "states": STATES, "tables": tables, "due": DUE, "marks": MARKS,
        "most_reasons": MOST_REASONS,
    }  # fmt: skip


#: Parts of a step, each of which leaves the step's serial when it ran to its end.
MARKS = ("door", "judge", "rating", "watchdog", "sound", "store", "machine")


#: Members of the context that a step leaves to the next. What is configured is none of them, nor what is made of borders.
LASTING = (
    "serial", "marks", "reading", "stamp", "number", "stamped", "numbered", "state", "stored",
)  # fmt: skip


def members(plan: Layout, given: Supervised) -> list[str]:
    """Members of the context."""
    found = [
        "  uint64_t made; /* TM_MADE once tm_init ran to its end */",
        "  uint64_t configured; /* TM_MADE while what was configured last is valid */",
        "  uint64_t serial; /* counts steps */",
        "  tm_marks marks;",
        "  tm_limits limits;",
        "  double reading; /* s, the clock's last */",
        "  double stamp; /* s, the last in order */",
        "  int64_t number; /* the last that came with a stamp in order */",
        "  bool stamped; /* there is such a stamp */",
        "  bool numbered; /* there is such a number */",
        "  tm_state state;",
        "  tm_stored stored;",
    ]
    if plan.remembers:
        found.append(
            "  double from_now[TM_MAX_SAMPLES]; /* s, the times of a stored trajectory that is driven, from a stamp on */"
        )
    if given.borders:
        found.append("  struct {")
        for signal in given.borders:
            own = given.signals[signal.name]
            found.append("    struct {")
            found += [f"      tm_passed {given.lines[signal.name, field.name]};" for field in signal.lines]
            found.append("      bool closed;")
            found.append("      bool set; /* made of what passed last */")
            found.append(f"    }} {own};")
        found.append("  } lines;")
    if given.lanes:
        found.append("  struct {")
        found += [
            f"    tm_passed_lane {given.signals[signal.name]}[TM_MAX_ELEMENTS];" for signal in given.lanes
        ]
        found.append("  } lanes;")
    return found
