"""The header: capacities, inputs with their units, context, results."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence

from trackmarshal.backends.c import interface, places
from trackmarshal.backends.c.contract import Supervised
from trackmarshal.backends.c.courses import counts_samples, longest
from trackmarshal.backends.c.functions.online import CAPACITY, Monitor
from trackmarshal.backends.c.functions.rules import RuleCode
from trackmarshal.backends.c.functions.types import CASES
from trackmarshal.backends.c.layout import Input, Layout, roots
from trackmarshal.backends.c.names import comment
from trackmarshal.backends.c.over_run.writing import types as remembered
from trackmarshal.backends.c.rendering import render
from trackmarshal.ir.spec import FieldType, ParamInfo, Spec
from trackmarshal.runtime.cycle import Limits
from trackmarshal.units import parse_unit, show

#: Capacities: macro -> (default, what it bounds). A spec may declare others: see `default`.
CAPACITIES = {
    "TM_MAX_SAMPLES": (128, "samples of a timeline"),
    "TM_MAX_ELEMENTS": (32, "elements of a set"),
    "TM_MAX_BORDER": (2048, "points of a border, or of a line that is a signal"),
    "TM_MAX_PLACE": (64, "points of a zone or line of the spec"),
    "TM_MAX_KNOTS": (64, "rows of a table"),
    "TM_MAX_RATE": (
        50,
        "cycles in a second that windows over the run have room for; of more, what rules remember is not known",
    ),
}


def header(
    plan: Layout,
    codes: Sequence[RuleCode],
    series: int,
    name: str,
    monitors: Sequence[Monitor],
    supervised: Supervised | None,
    rulebooks: str = "",
) -> str:
    """The text of the header file."""
    begins, end = places.firsts(plan)
    context = {
        "guard": f"TM_{name.upper()}_H", "plan": plan, "given": supervised, "series": series, "monitors": monitors,
        "along": along(plan), "capacities": [(macro, _capacity(macro, plan), CAPACITIES[macro][1]) for macro in capacities(plan, supervised)],
        "inputs": list(plan.inputs.values()), "comment": comment, "declaration": _declaration, "unit": unit,
        "geometry": places.has_geometry(plan), "firsts": begins, "end": end, "params": _params(plan),
        "members": _members(plan, series, supervised), "rules": [(f"TM_RULE_{code.c_name.upper()}", _about(code)) for code in codes],
        "places": list(places.prototypes(plan, supervised is not None)), "cases": CASES, "online": CAPACITY,
        "named": plan.named, "remembered": remembered(plan, supervised is not None),
        "rulebooks": rulebooks, "counted": counts_samples(root for rule in plan.rules for root in roots(rule)),
    }  # fmt: skip
    if supervised is not None:
        context |= interface.said(plan)
    return render("program/header.h.j2", context)


def numbered(text: str, source: str, name: str) -> str:
    """A header with its program's number (TM_PROGRAM): another one for all that is compiled otherwise, whatever the files are called, and wherever
    the spec stands."""
    own = rf'/\*.*?\*/|"{re.escape(name)}\.h"|\bTM_{re.escape(name.upper())}_H\b'
    number = hashlib.sha256(re.sub(own, "", text + source, flags=re.DOTALL).encode()).hexdigest()[:8]
    return text.replace("#define TM_PROGRAM 0x0ul\n", f"#define TM_PROGRAM 0x{number}ul\n")


#: Capacities that are limits of a Supervisor, by their names there.
_LIMITS = {
    "TM_MAX_SAMPLES": "samples", "TM_MAX_ELEMENTS": "elements", "TM_MAX_BORDER": "border", "TM_MAX_RATE": "rate",
}  # fmt: skip


def default(macro: str, spec: Spec) -> int:
    """A capacity as the spec declares it, or as it is by default."""
    if macro == "TM_MAX_ELEMENTS":
        return elements(spec, Limits.of(spec).elements)
    return getattr(Limits.of(spec), _LIMITS[macro]) if macro in _LIMITS else CAPACITIES[macro][0]


def elements(spec: Spec, limit: int) -> int:
    """The most elements of any set: those that are declared, and the limit of sets that declare none."""
    sets = [signal for signal in spec.signals.values() if signal.many]
    return max((limit if signal.capacity is None else signal.capacity for signal in sets), default=limit)


def capacities(plan: Layout, supervised: Supervised | None = None) -> list[str]:
    """The capacities that a program has."""
    found = []
    inputs = [
        item.signal for item in plan.inputs.values() if item.signal is not None and item.kind == "columns"
    ]
    if any(signal.sequence for signal in inputs):
        found.append("TM_MAX_SAMPLES")
    if any(not signal.sequence for signal in inputs):
        found.append("TM_MAX_ELEMENTS")
    kinds = {shape.kind for shape in plan.shapes.values()}
    if kinds & {"corridor", "centre", "signal"} or (supervised is not None and supervised.borders):
        found.append("TM_MAX_BORDER")
    if kinds & {"zone", "place"}:
        found.append("TM_MAX_PLACE")
    if plan.tables:
        found.append("TM_MAX_KNOTS")
    if plan.future.rules or plan.courses or any(each.kind != "previous" for each in plan.kept.values()):
        found.append("TM_MAX_RATE")
    return found


def _capacity(macro: str, plan: Layout) -> int:
    value = default(macro, plan.spec)
    if macro == "TM_MAX_KNOTS":
        return max(value, *(len(plan.spec.tables[table].knots) for table in plan.tables))
    if macro == "TM_MAX_PLACE":
        return max(value, *(len(place.points) for place in plan.spec.places.values()))
    return value


def _about(code: RuleCode) -> str:
    wanted = ", ".join(name for name, _ in code.rule.satisfies) or "no requirement"
    advisory = "advisory; " if code.rule.advisory else ""
    return f"{advisory}{comment(code.rule.title)}; {comment(wanted)}; {comment(str(code.rule.span))}"


def _params(plan: Layout) -> list[tuple[str, str]]:
    """Parameters by C name, with unit, range and where they are declared."""
    found = []
    for name, c_name in plan.params.items():
        info = plan.spec.params[name]
        found.append((c_name, f"{_ranged(info)}; {comment(name)} {comment(str(info.span))}"))
    return found


def _declaration(item: Input, info: FieldType, c_name: str) -> str:
    kind = "tm_flag" if info.kind == "bool" else "double"
    return f"const {kind} *{c_name};" if item.kind == "columns" else f"{kind} {c_name};"


def unit(info: FieldType) -> str:
    """A field's unit and range, for a comment."""
    if info.kind == "bool":
        return "TM_TRUE, TM_FALSE, TM_MISSING"
    if info.enumeration is not None:
        return comment(", ".join(f"{place} {name}" for place, name in enumerate(info.enumeration.members)))
    return f"{_ranged(info)}{', increasing' if info.increasing else ''}"


def _ranged(info: FieldType | ParamInfo) -> str:
    """A unit and the range of what is in it."""
    low = "" if info.lower is None else f", from {info.lower!r}"
    high = "" if info.upper is None else f", to {info.upper!r}"
    return f"{comment(show(parse_unit(info.unit)[2]))}{low}{high}"


def along(plan: Layout) -> str:
    """C of how many samples a timeline has at most."""
    course = longest(plan.courses.values())
    return "TM_MAX_SAMPLES" if course is None else course.size


#: Of rules alone, as `configured` is of a Supervisor.
TRIED = "  unsigned tried; /* 1u once tm_init found that numbers are computed as they are written: without, tm_check refuses */"


def _members(plan: Layout, series: int, supervised: Supervised | None) -> list[str]:
    """Members of the context."""
    members = [TRIED] if supervised is None else interface.members(plan, supervised)
    if plan.params:
        members.append("  tm_params params;")
    if plan.tables:
        members += [
            "  struct {",
            *(f"    tm_table {c_name};" for c_name in plan.tables.values()),
            "  } tables;",
        ]
    if series:
        members += [
            f"  tm_series series[{series}];", "  tm_series goal;", "  tm_series hold;", f"  size_t queue[{along(plan)}];",
        ]  # fmt: skip
    if plan.courses:
        joined = [f"    tm_course_{course.c_name} {course.c_name};" for course in plan.courses.values()]
        members += ["  struct {", *joined, "  } course; /* of the candidate that is being rated */"]
    if plan.remembers:
        members.append("  tm_run run;")
    return [*members, *places.members(plan)]
