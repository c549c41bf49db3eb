"""The header: capacities, inputs with their units, context, results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal.backends.c import interface
from trackmarshal.backends.c.contract import Supervised
from trackmarshal.backends.c.layout import Input, Layout
from trackmarshal.backends.c.names import comment
from trackmarshal.backends.c.online import TYPES, Monitor
from trackmarshal.backends.c.rules import CASES, RuleCode
from trackmarshal.ir.spec import FieldType, Spec
from trackmarshal.runtime.cycle import Limits
from trackmarshal.units import parse_unit, show

#: Capacities: macro -> (default, what it bounds). A spec may declare others: see `default`.
CAPACITIES = {
    "TM_MAX_SAMPLES": (128, "samples of a timeline"),
    "TM_MAX_ELEMENTS": (32, "elements of a set"),
    "TM_MAX_BORDER": (2048, "points of a border, or of a line that is a signal"),
    "TM_MAX_PLACE": (64, "points of a zone or line of the spec"),
    "TM_MAX_KNOTS": (64, "rows of a table"),
}


def header(
    plan: Layout,
    codes: Sequence[RuleCode],
    series: int,
    name: str,
    monitors: Sequence[Monitor],
    supervised: Supervised | None,
) -> str:
    """The text of the header file."""
    return "\n".join(_lines(plan, codes, series, name, monitors, supervised))


#: Capacities that are limits of a Supervisor, by their names there.
_LIMITS = {"TM_MAX_SAMPLES": "samples", "TM_MAX_ELEMENTS": "elements", "TM_MAX_BORDER": "border"}


def default(macro: str, spec: Spec) -> int:
    """A capacity as the spec declares it, or as it is by default."""
    return getattr(Limits.of(spec), _LIMITS[macro]) if macro in _LIMITS else CAPACITIES[macro][0]


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
    return found


def _lines(
    plan: Layout,
    codes: Sequence[RuleCode],
    series: int,
    name: str,
    monitors: Sequence[Monitor],
    supervised: Supervised | None,
) -> Iterator[str]:
    guard = f"TM_{name.upper()}_H"
    yield f"/* Generated from a spec by trackmarshal. Fingerprint {plan.spec.fingerprint[:16]}."
    yield "   All numbers are in SI units; a missing number is NaN. Nothing is allocated, nothing is global: what a check"
    yield "   needs beside its input is in one context. One context serves one thread. */"
    yield f"#ifndef {guard}"
    yield f"#define {guard}"
    yield ""
    yield "#include <stdbool.h>"
    yield "#include <stddef.h>"
    if supervised is not None:
        yield "#include <stdint.h>"
    yield ""
    for macro in capacities(plan, supervised):
        value, what = default(macro, plan.spec), CAPACITIES[macro][1]
        if macro == "TM_MAX_KNOTS":
            value = max(value, *(len(plan.spec.tables[t].knots) for t in plan.tables))
        if macro == "TM_MAX_PLACE":
            value = max(value, *(len(place.points) for place in plan.spec.places.values()))
        yield f"/* Capacity: {what}. */"
        yield f"#ifndef {macro}"
        yield f"#define {macro} {value}u"
        yield "#endif"
        yield ""
    yield from _CONSTANTS
    yield from _inputs(plan)
    if supervised is not None:
        yield from interface.types(plan, supervised)
    yield from _context(plan, series, supervised)
    yield "/* The rules, in the order of their results. */"
    yield "enum {"
    for index, code in enumerate(codes):
        wanted = ", ".join(n for n, _ in code.rule.satisfies) or "no requirement"
        yield f"  TM_RULE_{code.c_name.upper()} = {index}, /* {comment(code.rule.title)}; {comment(wanted)}; {comment(str(code.rule.span))} */"
    yield f"  TM_RULES = {len(codes)}"
    yield "};"
    yield ""
    yield "typedef struct {"
    yield "  tm_result rule[TM_RULES];"
    yield "} tm_output;"
    yield ""
    if supervised is None:
        yield "tm_status tm_init(tm_context *c);"
        yield "tm_status tm_check(tm_context *c, const tm_input *in, tm_output *out);"
    else:
        yield from interface.results(supervised)
        yield from interface.prototypes(plan, supervised)
    if plan.tables and supervised is None:
        yield "bool tm_set_table(tm_table *table, const double *knots, const double *values, size_t count);"
    from trackmarshal.backends.c.places import prototypes

    yield from prototypes(plan, supervised is not None)
    yield ""
    if monitors:
        yield CASES
        yield "/* Rules along a timeline, a sample at a time: start, push, ..., finish. */"
        yield from TYPES
        for monitor in monitors:
            yield monitor.types
            yield monitor.prototypes
            yield ""
    yield "#endif"
    yield ""


_CONSTANTS = [
    "/* A Boolean of an input; any other value counts as missing. */",
    "typedef signed char tm_flag;",
    "#define TM_FALSE ((tm_flag)0)",
    "#define TM_TRUE ((tm_flag)1)",
    "#define TM_MISSING ((tm_flag)-1)",
    "",
    "typedef enum {",
    "  TM_SATISFIED = 0,",
    "  TM_VIOLATED = 1,",
    "  TM_UNDEFINED = 2, /* as unsafe as violated */",
    "  TM_INACTIVE = 3,",
    "  TM_OPEN = 4 /* kept for deadlines in the future */",
    "} tm_verdict;",
    "",
    "typedef enum {",
    "  TM_OK = 0,",
    "  TM_OVER_CAPACITY = 1,",
    "  TM_TOO_SHORT = 2,",
    "  TM_UNUSABLE = 3,",
    "  TM_UNSUPPORTED = 4,",
    "  TM_BAD_LIMIT = 5,",
    "  TM_BAD_PARAM = 6, /* not finite, or outside its range */",
    "  TM_BAD_TABLE = 7, /* no row, too many, not finite, or knots that do not ascend */",
    "  TM_BAD_CONSTRAINT = 8 /* parameters that the spec does not let stand together */",
    "} tm_status;",
    "",
    "/* One rule's verdict, and its margin: positive inside, NaN when undefined. */",
    "typedef struct {",
    "  double margin;",
    "  tm_verdict verdict;",
    "} tm_result;",
    "",
]


def _inputs(plan: Layout) -> Iterator[str]:
    for item in plan.inputs.values():
        if item.kind == "event":
            continue
        assert item.signal is not None
        what = f"{comment(item.name)}: {item.signal.kind}; {comment(str(item.signal.span))}"
        yield f"/* {what} */"
        yield "typedef struct {"
        if item.kind == "columns":
            yield "  size_t count;"
        for info, c_name in item.fields:
            yield f"  {_declaration(item, info, c_name)} /* {unit(info)} */"
        if item.kind != "columns" and not item.fields:
            yield "  tm_flag unused;"
        yield f"}} tm_in_{item.c_name};"
        yield ""
    yield "typedef struct {"
    for item in plan.inputs.values():
        if item.kind == "event":
            yield f"  tm_flag {item.c_name}; /* event {comment(item.name)} */"
        else:
            yield f"  tm_in_{item.c_name} {item.c_name};"
    if not plan.inputs:
        yield "  tm_flag unused;"
    yield "} tm_input;"
    yield ""


def _declaration(item: Input, info: FieldType, c_name: str) -> str:
    kind = "tm_flag" if info.kind == "bool" else "double"
    return f"const {kind} *{c_name};" if item.kind == "columns" else f"{kind} {c_name};"


def unit(info: FieldType) -> str:
    """A field's unit and range, for a comment."""
    if info.kind == "bool":
        return "TM_TRUE, TM_FALSE, TM_MISSING"
    unit = comment(show(parse_unit(info.unit)[2]))
    low = "" if info.lower is None else f", from {info.lower!r}"
    high = "" if info.upper is None else f", to {info.upper!r}"
    return f"{unit}{low}{high}{', increasing' if info.increasing else ''}"


def _context(plan: Layout, series: int, supervised: Supervised | None) -> Iterator[str]:
    if plan.tables:
        yield "/* A table: linear between knots, clamped outside. Filled by tm_set_table. */"
        yield "typedef struct {"
        yield "  size_t count;"
        yield "  size_t last; /* the row below the last argument */"
        yield "  double knot[TM_MAX_KNOTS];"
        yield "  double value[TM_MAX_KNOTS];"
        yield "  double slope[TM_MAX_KNOTS];"
        yield "} tm_table;"
        yield ""
    if series:
        yield "/* A formula at every sample of a timeline. */"
        yield "typedef struct {"
        yield "  double margin[TM_MAX_SAMPLES];"
        yield "  bool sat[TM_MAX_SAMPLES];"
        yield "} tm_series;"
        yield ""
    from trackmarshal.backends.c.places import types

    yield from types(plan)
    if plan.params:
        yield "typedef struct {"
        for name, c_name in plan.params.items():
            info = plan.spec.params[name]
            shown = comment(show(parse_unit(info.unit)[2]))
            low = "" if info.lower is None else f", from {info.lower!r}"
            high = "" if info.upper is None else f", to {info.upper!r}"
            yield f"  double {c_name}; /* {shown}{low}{high}; {comment(name)} {comment(str(info.span))} */"
        yield "} tm_params;"
        yield ""
    if supervised is not None:
        yield from interface.memory(plan, supervised)
    yield "typedef struct {"
    members = [] if supervised is None else interface.members(plan, supervised)
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
            f"  tm_series series[{series}];", "  tm_series goal;", "  tm_series hold;", "  size_t queue[TM_MAX_SAMPLES];",
        ]  # fmt: skip
    from trackmarshal.backends.c.places import members as places

    members += places(plan)
    yield from members or ["  tm_flag unused;"]
    yield "} tm_context;"
    yield ""
