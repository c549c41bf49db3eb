"""The header of a Supervisor in C: a cycle as it comes, limits, configuration, the context's memory, and the decision."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

from trackmarshal.backends.c.contract import Supervised
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.names import comment
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.decision import MOST_REASONS
from trackmarshal.runtime.faults import FAULTS
from trackmarshal.runtime.machine import STATES

#: Limits that are numbers; capacities are macros in C.
LIMITS: dict[str, float] = {
    field.name: getattr(Limits(), field.name)
    for field in fields(Limits)
    if field.name not in ("samples", "elements", "border")
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
    "overspeed": "m/s, how much faster than it is there",
    "blind": "s, how long no pose may confirm it",
}
#: Names of faults by their number in C.
FAULT_NAMES = ("none", *FAULTS)
#: The member of what is stored that says when each sample is due.
DUE = "due"


def types(plan: Layout, given: Supervised) -> Iterator[str]:
    """Types of the header that the context needs."""
    yield "/* What is wrong with a cycle, or why nothing stored is driven. */"
    yield "typedef enum {"
    yield "  TM_FAULT_NONE = 0,"
    for number, (name, code) in enumerate(FAULTS.items(), start=1):
        yield f"  TM_FAULT_{name.upper()} = {number}{',' if number < len(FAULTS) else ''} /* {code} */"
    yield "} tm_fault_name;"
    yield ""
    yield "#define TM_NOWHERE ((size_t)-1)"
    yield ""
    yield "/* One fault: the signal (for a candidate `driving` or `emergency`), its field, the sample or element, or TM_NOWHERE. */"
    yield "typedef struct {\n  tm_fault_name name;\n  const char *signal;\n  const char *field;\n  size_t index;\n} tm_fault;"
    yield ""
    yield from _borders(given)
    yield from _cycle(given)
    yield "/* Reads the clock that stamps are from, s; `user` is what was handed to tm_step. */"
    yield "typedef double (*tm_clock)(void *user);"
    yield ""
    yield "/* What cycles and the Supervisor are held to; from 0, INFINITY takes a limit away. */"
    yield "typedef struct {"
    for name, default in LIMITS.items():
        yield f"  double {name}; /* {_MEANING.get(name, '')}; {default!r} */"
    yield "} tm_limits;"
    yield ""
    yield "typedef enum {"
    for number, name in enumerate(STATES):
        yield f"  TM_STATE_{name.upper()} = {number}{',' if number + 1 < len(STATES) else ''}"
    yield "} tm_state;"
    yield ""


def _borders(given: Supervised) -> Iterator[str]:
    if not given.borders:
        return
    yield "/* A border or line: x and y by turns, m. `id` is any number that changes whenever the points do: with that of the points that"
    yield "   passed last, they are not looked at again. With 0 they are looked at, and prepared, in every cycle. */"
    yield "typedef struct {\n  const double *points;\n  size_t count;\n  uint64_t id;\n} tm_points;"
    yield ""
    for signal in given.borders:
        yield f"/* {comment(signal.name)}: borders or a line. */"
        yield "typedef struct {"
        for field in signal.lines:
            yield f"  tm_points {given.lines[signal.name, field.name]};"
        if any(field.name for field in signal.lines):
            yield "  bool closed; /* the last point is followed by the first */"
        yield f"}} tm_in_{given.signals[signal.name]};"
        yield ""


def _cycle(given: Supervised) -> Iterator[str]:
    yield "/* One cycle as it came. Its memory is read in tm_step and not afterwards. A pointer that is NULL: the signal is missing. */"
    yield "typedef struct {"
    yield "  bool came; /* false: a cycle was due and did not come, or it is none for what was `found`; else only `now` counts then */"
    yield "  bool numbered; /* `number` is one */"
    yield "  bool stamped; /* `t` is a stamp */"
    yield "  int64_t number; /* one more than in the cycle before */"
    yield "  double t; /* s, when its data was taken and its trajectories begin, on the Supervisor's clock */"
    yield "  double now; /* s, that clock when the cycle arrived */"
    yield f"  const tm_in_{given.plan.c_name} *driving;"
    yield f"  const tm_in_{given.plan.c_name} *emergency;"
    if given.contract.signals:
        yield "  struct {"
        for signal in given.inputs:
            yield f"    const tm_in_{given.signals[signal.name]} *{given.signals[signal.name]};"
        for signal in given.borders:
            yield f"    const tm_in_{given.signals[signal.name]} *{given.signals[signal.name]};"
        for signal in given.events:
            yield f"    tm_flag {given.signals[signal.name]}; /* event {comment(signal.name)} */"
        yield "  } signals;"
    yield "  const tm_fault *found; /* faults that whoever received the cycle has found: the signals that they name are not looked at */"
    yield "  size_t found_count;"
    yield "} tm_cycle;"
    yield ""


def memory(plan: Layout, given: Supervised) -> Iterator[str]:
    """Types of the context's memory, once parameters and tables are known."""
    yield "/* What is put into a context: tm_defaults fills in the spec's own. */"
    if plan.tables:
        yield "typedef struct {\n  const double *knots; /* ascending */\n  const double *values;\n  size_t count; /* to TM_MAX_KNOTS */\n} tm_rows;"
        yield ""
    yield "typedef struct {"
    yield "  tm_limits limits;"
    if plan.params:
        yield "  tm_params params;"
    if plan.tables:
        yield "  struct {"
        for name, c_name in plan.tables.items():
            units = " over ".join(comment(unit) for unit in reversed(plan.spec.tables[name].units))
            yield f"    tm_rows {c_name}; /* {units}; {comment(name)} {comment(str(plan.spec.tables[name].span))} */"
        yield "  } tables;"
    yield "} tm_configuration;"
    yield ""
    yield "/* Whether a configuration is in force: TM_OK; or what is wrong with it, and the name of the first limit, parameter, table or"
    yield "   constraint that cannot stand. */"
    yield "typedef struct {\n  tm_status status;\n  const char *which;\n} tm_configured;"
    yield ""
    yield "/* The emergency trajectory of the last safe cycle. */"
    yield "typedef struct {"
    yield "  uint64_t serial; /* of the step that stored it; 0: nothing is stored */"
    yield "  int64_t number; /* of its cycle */"
    yield "  double t; /* s, that cycle's stamp */"
    yield "  double confirmed; /* s, when the car was last seen on it */"
    yield "  size_t count;"
    yield f"  double {DUE}[TM_MAX_SAMPLES]; /* s, when each sample is due on the Supervisor's clock */"
    yield "  struct {"
    for info, c_name in given.plan.fields:
        yield f"    {'tm_flag' if info.kind == 'bool' else 'double'} {c_name}[TM_MAX_SAMPLES];"
    yield "  } plan;"
    yield "} tm_stored;"
    yield ""
    if given.borders:
        yield "/* Points that passed the contract last. */"
        yield "typedef struct {\n  uint64_t id;\n  size_t count;\n} tm_passed;"
        yield ""
    yield "/* The serial of the step in which each part ran to its end. */"
    yield "typedef struct {"
    for part in MARKS:
        yield f"  uint64_t {part};"
    yield "} tm_marks;"
    yield ""


#: Parts of a step, each of which leaves the step's serial when it ran to its end.
MARKS = ("door", "judge", "rating", "watchdog", "sound", "store", "machine")


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
    return found


def results(given: Supervised) -> Iterator[str]:
    """Types that come after the rules' results: the decision."""
    yield "/* Most reasons that a decision holds; what is more, `more` says. */"
    yield "#ifndef TM_MAX_REASONS"
    yield f"#define TM_MAX_REASONS {MOST_REASONS}u"
    yield "#endif"
    yield ""
    yield "typedef enum {"
    yield "  TM_REASON_FAULT = 0, /* `fault` */"
    yield "  TM_REASON_RULE = 1, /* `rule`, of `candidate`, with `result` */"
    yield "  TM_REASON_LOST = 2 /* `fault.name`: why nothing stored is driven */"
    yield "} tm_reason_kind;"
    yield ""
    yield "typedef enum {\n  TM_DRIVING = 0,\n  TM_EMERGENCY = 1\n} tm_candidate;"
    yield ""
    yield "typedef struct {"
    yield "  tm_reason_kind kind;\n  tm_fault fault;\n  size_t rule; /* TM_RULE_... */\n  tm_candidate candidate;\n  tm_result result;"
    yield "} tm_reason;"
    yield ""
    yield "typedef enum {"
    yield "  TM_DRIVE_NOTHING = 0,"
    yield "  TM_DRIVE_DRIVING = 1, /* this cycle's driving trajectory, from sample `first` on */"
    yield "  TM_DRIVE_STORED = 2 /* the stored emergency trajectory, from sample `first` on: tm_stored_plan */"
    yield "} tm_driven;"
    yield ""
    yield "/* What is driven, and why. */"
    yield "typedef struct {"
    yield "  uint64_t serial; /* one more than in the decision before; 0: none was made */"
    yield "  tm_state state;"
    yield "  bool safe; /* this cycle is */"
    yield "  tm_driven driven;"
    yield "  size_t first; /* the last sample that is due by now, 0 before all; TM_NOWHERE where nothing is driven */"
    yield "  int64_t driven_number; /* number and stamp [s] of the cycle that it is from; 0 and NaN where nothing is driven */"
    yield "  double driven_t;"
    yield "  bool stored; /* an emergency trajectory is: drive it when no decision has come by `valid_until` */"
    yield "  int64_t stored_number;"
    yield "  double stored_t;"
    yield "  tm_fault_name lost; /* why nothing stored is driven; TM_FAULT_NONE where it is, or need not be */"
    yield "  double now; /* s, the clock at arrival; NaN where it was wrong */"
    yield "  double finished; /* s, the clock as it was read when the verdict was there; NaN: there is none */"
    yield "  double valid_until; /* s */"
    yield "  bool judged; /* the rules were asked; otherwise all of them are undefined */"
    yield "  tm_output driving;"
    yield "  tm_output emergency;"
    yield "  size_t fault_count; /* all faults, also those that found no room */"
    yield "  size_t reason_count; /* the door's faults, rules (of the driving trajectory, then of the emergency one), later faults, `lost` */"
    yield "  bool more; /* there were more reasons than there is room */"
    yield "  tm_reason reasons[TM_MAX_REASONS];"
    yield "} tm_decision;"
    yield ""


def prototypes(plan: Layout, given: Supervised) -> Iterator[str]:
    """Declarations of the header."""
    yield "/* Make a context new, with the spec's own values and no memory of any cycle. TM_UNUSABLE: a place of the spec is none; rules"
    yield "   that need it are undefined. Anything else but TM_OK: the spec's own values are not valid, no cycle will be admitted. */"
    yield "tm_status tm_init(tm_context *c);"
    yield "/* The spec's own parameters and tables, the Supervisor's own limits. */"
    yield "void tm_defaults(tm_configuration *configuration);"
    yield "/* Put a configuration into a context, before the first cycle or between cycles. What cannot stand is not put in, and no cycle is"
    yield "   admitted until a configuration is valid. */"
    yield "tm_configured tm_configure(tm_context *c, const tm_configuration *configuration);"
    yield "/* One cycle: what is driven, and why. The clock is read once, when the rules are done. */"
    yield "void tm_step(tm_context *c, const tm_cycle *cycle, tm_clock clock, void *user, tm_decision *out);"
    yield "/* The stored emergency trajectory, in the context's memory, until the next step; false: there is none. `due`, where it is not"
    yield "   NULL: when each sample is due, s. */"
    yield f"bool tm_stored_plan(const tm_context *c, tm_in_{given.plan.c_name} *plan, const double **due);"
    yield "/* The last of its samples that is due by a time, 0 before all. */"
    yield "size_t tm_stored_first(const tm_context *c, double now);"
