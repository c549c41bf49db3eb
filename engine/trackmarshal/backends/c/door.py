"""The input contract of a program: what a cycle has to be before its rules count, in C (S-2-C)."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.backends.c.layout import Input, Layout
from trackmarshal.backends.c.names import comment, literal
from trackmarshal.backends.c.places import _bordered, _setters, sources
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.contract import EGO, IS_EMERGENCY, PLAN
from trackmarshal.runtime.cycle import Limits

#: Names of faults (`runtime.faults`) in the order of their numbers in C.
FAULTS = (
    "none", "repeated", "out_of_order", "skipped", "late", "stale", "early", "wrong_type", "missing", "wrong_length", "too_short",
    "not_increasing", "not_finite", "out_of_range", "bad_border", "over_capacity", "starts_elsewhere", "not_at_rest", "bad_clock",
)  # fmt: skip
_DEFAULTS = Limits()
#: Limits of the door: name, default, what it is.
LIMITS: tuple[tuple[str, float, str], ...] = tuple(
    (name, getattr(_DEFAULTS, name), what)
    for name, what in (
        ("shortest_gap", "s, stamps that are nearer to each other are one"),
        ("longest_gap", "s, the longest time from one stamp to the next"),
        ("oldest", "s, the oldest stamp at arrival"),
        ("clock_tolerance", "s, how far a stamp may lie ahead of the clock"),
        ("start_distance", "m, how far apart the candidates may start"),
        ("start_turn", "rad"),
        ("start_speed", "m/s"),
        ("rest_speed", "m/s, the speed at the end of an emergency trajectory"),
    )
)


def has_door(spec: Spec) -> bool:
    """Whether a spec has what the door is for: two candidates of a trajectory `plan`, and the state `ego`."""
    plan, ego = spec.signals.get(PLAN), spec.signals.get(EGO)
    if plan is None or ego is None or plan.kind != "trajectory" or plan.many or ego.kind != "state":
        return False
    needed = {"t", "x", "y", "heading", "v"}
    return needed <= {f.name for f in plan.fields_ if f.kind == "number"}


def types(plan: Layout) -> Iterator[str]:
    """Types of the header; those that the context needs."""
    yield "/* What breaks the input contract. */"
    yield "typedef enum {"
    for number, name in enumerate(FAULTS):
        yield f"  TM_FAULT_{name.upper()} = {number}{',' if number + 1 < len(FAULTS) else ''}"
    yield "} tm_fault_name;"
    yield ""
    yield "#define TM_NOWHERE ((size_t)-1)"
    yield ""
    yield "/* One breach: the signal (for a candidate `driving` or `emergency`), its field, the sample or element, or TM_NOWHERE. */"
    yield "typedef struct {\n  tm_fault_name name;\n  const char *signal;\n  const char *field;\n  size_t index;\n} tm_fault;"
    yield ""
    yield "/* A cycle: its number, one more than in the cycle before; when its data was taken; when it arrived; s on one clock. */"
    yield "typedef struct {\n  int64_t number;\n  double t;\n  double now;\n} tm_stamp;"
    yield ""
    yield "typedef struct {"
    for name, default, what in LIMITS:
        yield f"  double {name}; /* {what}; {default!r} */"
    yield "} tm_limits;"
    yield ""
    yield "/* What the door remembers. A check counts only for the cycle that was admitted last. */"
    yield "typedef struct {"
    yield "  tm_limits limits;\n  double t;\n  int64_t number;\n  bool begun;\n  bool admitted;"
    for name in sources(plan):
        yield f"  bool {_setters(plan)[name].removeprefix('tm_set_')}; /* its lines were admitted */"
    yield "} tm_door;"
    yield ""


def prototypes(plan: Layout) -> Iterator[str]:
    """Declarations of the header."""
    yield "/* Whether a cycle keeps the input contract: both candidates, and what they have in common, which is taken from `driving`."
    yield "   Where it does not, `fault` says why, and tm_check leaves every rule undefined (TM_REFUSED). */"
    yield "bool tm_admit(tm_context *c, const tm_stamp *stamp, const tm_input *driving, const tm_input *emergency, tm_fault *fault);"
    yield "/* All rules on both candidates of the admitted cycle; rules that read nothing of a candidate are computed once. */"
    yield "tm_status tm_check_both(tm_context *c, const tm_input *driving, const tm_input *emergency, tm_output *out_driving,"
    yield "                        tm_output *out_emergency);"
    for name, signature in _line_signatures(plan):
        yield f"/* Whether the lines of `{comment(name)}` can be set; until some were, no cycle is admitted. */"
        yield f"{signature};"


def initial(plan: Layout) -> Iterator[str]:
    """Statements of tm_init."""
    for name, default, _ in LIMITS:
        yield f"  c->door.limits.{name} = {literal(default)};"
    yield "  c->door.t = 0.0;"
    yield "  c->door.number = 0;"
    yield "  c->door.begun = false;"
    yield "  c->door.admitted = false;"
    for name in sources(plan):
        yield f"  c->door.{_setters(plan)[name].removeprefix('tm_set_')} = false;"


def functions(plan: Layout) -> Iterator[str]:
    """Definitions: the lines' and the cycle's admission."""
    setters = _setters(plan)
    for name, signature in _line_signatures(plan):
        flag = f"c->door.{setters[name].removeprefix('tm_set_')}"
        lines = ("left", "right") if _bordered(plan, name) else ("points",)
        yield signature
        yield "{"
        for line in lines:
            count, field = ("count", "") if line == "points" else (f"{line}_count", line)
            yield f'  {flag} = {f"{flag} && " if line == "right" else ""}tm_admit_line(fault, {_text(name)}, "{field}", {line}, {count}, TM_MAX_BORDER);'
        yield f"  return {flag};"
        yield "}"
        yield ""
    plan_input = plan.input(PLAN)
    yield "/* Whether a candidate keeps the contract of a trajectory. */"
    yield f"static bool tm_admit_plan(const tm_in_{plan_input.c_name} *in, const char *signal, tm_fault *fault)"
    yield "{"
    yield from _columns(plan_input, "in", "signal")
    yield "  return true;"
    yield "}"
    yield ""
    yield "/* Whether what both candidates have in common keeps the contract. */"
    yield "static bool tm_admit_shared(const tm_context *c, const tm_input *in, tm_fault *fault)"
    yield "{"
    for name in sources(plan):
        flag = f"c->door.{setters[name].removeprefix('tm_set_')}"
        yield f'  if (!{flag}) {{ return tm_refuse(fault, TM_FAULT_MISSING, {_text(name)}, "", TM_NOWHERE); }}'
    if not sources(plan):
        yield "  (void)c;"
    for item in plan.inputs.values():
        if item.name in (PLAN, IS_EMERGENCY):
            continue
        place = f"in->{item.c_name}"
        if item.kind == "event":
            yield f'  if (!tm_admit_flag(fault, {_text(item.name)}, "", {place})) {{ return false; }}'
        elif item.kind == "columns":
            yield from _columns(item, f"(&{place})", _text(item.name))
        else:
            yield from _record(item, place)
    yield "  return true;"
    yield "}"
    yield ""
    yield "bool tm_admit(tm_context *c, const tm_stamp *stamp, const tm_input *driving, const tm_input *emergency, tm_fault *fault)"
    yield "{"
    named = {name: plan.field_name(PLAN, name) for name in ("x", "y", "heading", "v")}
    d, e = f"driving->{plan_input.c_name}", f"emergency->{plan_input.c_name}"

    def apart(name: str) -> str:
        return f"{d}.{named[name]}[0] - {e}.{named[name]}[0]"

    yield "  bool fine;"
    yield '  (void)tm_refuse(fault, TM_FAULT_NONE, "", "", TM_NOWHERE);'
    yield "  fine = tm_admit_stamp(&c->door, stamp, fault);"
    yield f'  fine = fine && tm_admit_plan(&{d}, "driving", fault) && tm_admit_plan(&{e}, "emergency", fault);'
    yield "  fine = fine && tm_admit_candidates("
    yield f"    &c->door.limits, {apart('x')}, {apart('y')}, {apart('heading')}, {apart('v')},"
    yield f"    {e}.{named['v']}[{e}.count - 1u], {e}.count, fault);"
    yield "  fine = fine && tm_admit_shared(c, driving, fault);"
    told = plan.inputs.get(IS_EMERGENCY)
    if told is not None and told.kind == "event":
        yield f"  if (fine && ((driving->{told.c_name} != TM_FALSE) || (emergency->{told.c_name} != TM_TRUE))) {{"
        yield f'    fine = tm_refuse(fault, TM_FAULT_OUT_OF_RANGE, {_text(told.name)}, "", TM_NOWHERE);'
        yield "  }"
    yield "  c->door.admitted = fine;"
    yield "  return fine;"
    yield "}"
    yield ""


def check_both(plan: Layout, calls: Iterator[str], shared: list[str]) -> Iterator[str]:
    """Definition of the check of both candidates: calls for what depends on the candidate, copies of the rest."""
    yield "tm_status tm_check_both(tm_context *c, const tm_input *driving, const tm_input *emergency, tm_output *out_driving,"
    yield "                        tm_output *out_emergency)"
    yield "{"
    yield "  tm_status status = tm_check(c, driving, out_driving);"
    yield "  if (status == TM_OK) {"
    yield "    const tm_input *in = emergency;"
    yield "    tm_output *out = out_emergency;"
    yield "    status = tm_fits(in);"
    yield "    if (status == TM_OK) {"
    yield from (f"    {line}" for line in calls)
    for constant in shared:
        yield f"      out->rule[{constant}] = out_driving->rule[{constant}];"
    yield "    }"
    yield "  }"
    yield "  if (status != TM_OK) {"
    yield "    for (size_t i = 0u; i < TM_RULES; ++i) {"
    yield "      tm_undefined(&out_driving->rule[i]);"
    yield "      tm_undefined(&out_emergency->rule[i]);"
    yield "    }"
    yield "  }"
    yield "  return status;"
    yield "}"
    yield ""


def of_candidate(rule: RuleInfo) -> bool:
    """Whether a rule reads anything that differs between the candidates."""
    if any(signal in (PLAN, IS_EMERGENCY) for signal, _ in rule.reads):
        return True
    for root in (rule.formula, rule.active):
        for node in ir.below(root) if root is not None else ():
            named = getattr(node, "signal", None) or (node.name if isinstance(node, ir.Line) else None)
            if named in (PLAN, IS_EMERGENCY):
                return True
    return False


def _line_signatures(plan: Layout) -> Iterator[tuple[str, str]]:
    for name in sources(plan):
        function = _setters(plan)[name].replace("tm_set_", "tm_admit_", 1)
        given = (
            "const double *left, size_t left_count, const double *right, size_t right_count"
            if _bordered(plan, name)
            else "const double *points, size_t count"
        )
        yield name, f"bool {function}(tm_context *c, {given}, tm_fault *fault)"


def _columns(item: Input, place: str, signal: str) -> Iterator[str]:
    """Statements that return false for a timeline or set that breaks its contract."""
    assert item.signal is not None
    least = (
        2 if item.signal.kind == "trajectory" and item.signal.sequence else 1 if item.signal.sequence else 0
    )
    most = "TM_MAX_SAMPLES" if item.signal.sequence else "TM_MAX_ELEMENTS"
    first = _text(item.fields[0][0].name if item.fields else "")
    yield f"  if (!tm_admit_count(fault, {signal}, {first}, {place}->count, {least}u, {most})) {{ return false; }}"
    for info, c_name in item.fields:
        given = f"fault, {signal}, {_text(info.name)}, {place}->{c_name}, {place}->count"
        if info.kind == "bool":
            yield f"  if (!tm_admit_flags({given})) {{ return false; }}"
            continue
        yield f"  if (!tm_admit_column({given}, {_low(info.lower)}, {_high(info.upper)})) {{ return false; }}"
        if info.increasing or (item.name == PLAN and info.name == "t"):
            yield f"  if (!tm_admit_increasing({given})) {{ return false; }}"


def _record(item: Input, place: str) -> Iterator[str]:
    for info, c_name in item.fields:
        given = f"fault, {_text(item.name)}, {_text(info.name)}, {place}.{c_name}"
        if info.kind == "bool":
            yield f"  if (!tm_admit_flag({given})) {{ return false; }}"
        else:
            yield f"  if (!tm_admit_number({given}, {_low(info.lower)}, {_high(info.upper)})) {{ return false; }}"


def _low(bound: float | None) -> str:
    return "-DBL_MAX" if bound is None else literal(bound)


def _high(bound: float | None) -> str:
    return "DBL_MAX" if bound is None else literal(bound)


def _text(name: str) -> str:
    return '"' + comment(name).replace('"', "'") + '"'
