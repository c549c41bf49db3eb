"""Capacities: how much of what a program holds, by the macro that says so."""

from __future__ import annotations

from collections.abc import Mapping

from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Limits

#: Capacities: macro -> (default, what it bounds). A spec may declare others: see `default`.
CAPACITIES = {
    "TM_MAX_SAMPLES": (128, "samples of a timeline"),
    "TM_MAX_ELEMENTS": (32, "elements of a set"),
    "TM_LIMIT_ELEMENTS": (32, "elements of a set that declares no capacity: the limit `elements`"),
    "TM_MAX_BORDER": (2048, "points of a border, or of a line that is a signal"),
    "TM_MAX_PLACE": (64, "points of a zone or line of the spec"),
    "TM_MAX_KNOTS": (64, "rows of a table"),
    "TM_MAX_RATE": (
        50,
        "cycles in a second that windows over the run have room for; of more, what rules remember is not known",
    ),
}
#: Capacities that are limits of a Supervisor, by their names there.
_LIMITS = {
    "TM_MAX_SAMPLES": "samples", "TM_LIMIT_ELEMENTS": "elements", "TM_MAX_BORDER": "border", "TM_MAX_RATE": "rate",
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
        if supervised is not None and supervised.limited:
            found.append("TM_LIMIT_ELEMENTS")
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


def stated(macro: str, plan: Layout) -> int:
    """A capacity as the header has it: the default one, or as much as the spec's own tables and places need."""
    value = default(macro, plan.spec)
    if macro == "TM_MAX_KNOTS":
        return max(value, *(len(plan.spec.tables[table].knots) for table in plan.tables))
    if macro == "TM_MAX_PLACE":
        return max(value, *(len(place.points) for place in plan.spec.places.values()))
    return value


def of_limits(spec: Spec, limits: Mapping[str, float], knots: int = 0) -> dict[str, int]:
    """Those of limits, and as many points of places and rows of tables as the spec has; knots: rows of other tables."""
    return {
        "TM_MAX_SAMPLES": int(limits["samples"]),
        "TM_MAX_ELEMENTS": elements(spec, int(limits["elements"])),
        "TM_LIMIT_ELEMENTS": int(limits["elements"]),
        "TM_MAX_BORDER": int(limits["border"]),
        "TM_MAX_RATE": int(limits["rate"]),
        "TM_MAX_PLACE": max(CAPACITIES["TM_MAX_PLACE"][0], *(len(p.points) for p in spec.places.values()), 0),
        "TM_MAX_KNOTS": max(
            CAPACITIES["TM_MAX_KNOTS"][0], *(len(t.knots) for t in spec.tables.values()), knots
        ),
    }
