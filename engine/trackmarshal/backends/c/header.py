"""The header: capacities, inputs with their units, context, results."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence

from trackmarshal.backends.c import places, setters
from trackmarshal.backends.c.capacities import CAPACITIES, capacities, stated
from trackmarshal.backends.c.courses import counts_samples, longest
from trackmarshal.backends.c.functions.online import CAPACITY, Monitor
from trackmarshal.backends.c.functions.rules import RuleCode, constant
from trackmarshal.backends.c.functions.types import CASES
from trackmarshal.backends.c.layout import Input, Layout
from trackmarshal.backends.c.names import comment
from trackmarshal.backends.c.over_run.writing import types as remembered
from trackmarshal.backends.c.rendering import render
from trackmarshal.backends.c.supervised import interface
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.ir.spec import FieldType, ParamInfo
from trackmarshal.units import parse_unit, show


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
        "along": along(plan), "capacities": [(macro, stated(macro, plan), CAPACITIES[macro][1]) for macro in capacities(plan, supervised)],
        "inputs": list(plan.inputs.values()), "comment": comment, "declaration": _declaration, "unit": unit,
        "geometry": places.has_geometry(plan), "firsts": begins, "end": end, "params": _params(plan),
        "members": _members(plan, series, supervised), "rules": [(constant(code.c_name), _about(code)) for code in codes],
        "places": list(setters.prototypes(plan, supervised is not None)), "cases": CASES, "online": CAPACITY,
        "named": plan.named, "remembered": remembered(plan, supervised is not None),
        "rulebooks": rulebooks, "counted": counts_samples(plan.nodes),
    }  # fmt: skip
    if supervised is not None:
        context |= interface.said(plan)
    return render("program/header.h.j2", context)


def numbered(text: str, source: str, name: str) -> str:
    """A header with its program's number (TM_PROGRAM): another one for all that is compiled otherwise."""
    number = hashlib.sha256(compiled(text + source, name).encode()).hexdigest()[:8]
    return text.replace("#define TM_PROGRAM 0x0ul\n", f"#define TM_PROGRAM 0x{number}ul\n")


def compiled(text: str, name: str) -> str:
    """What of a text is compiled, whatever the files are called, and wherever the spec, and in it each constraint, stands."""
    own = rf'/\*.*?\*/|"{re.escape(name)}\.h"|\bTM_{re.escape(name.upper())}_H\b|(?<=which = )"(?:[^"\\]|\\.)*:\d+:\d+"'
    return re.sub(own, "", text, flags=re.DOTALL)


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
