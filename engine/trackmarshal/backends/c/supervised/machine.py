"""The state machine in C: its table, when the stored trajectory may be driven, and how one is stored; and the step around it all."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.backends.c.over_run.step import CALL, END, commit
from trackmarshal.backends.c.parts import STEP
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.backends.c.supervised.interface import DUE, LIMITS
from trackmarshal.runtime.contract import EGO
from trackmarshal.runtime.contract.cycles import STORED
from trackmarshal.runtime.machine import HOLDS, LOST, NEXT, NONE, SAFE, STATES

_EVENTS = (SAFE, HOLDS, LOST, NONE)


def types(given: Supervised, parts: int) -> Iterator[str]:
    """Types and constants that the parts of a step have in common."""
    columns = {info.name: c_name for info, c_name in given.plan.fields}
    yield "/* Where the car is. */"
    yield "typedef struct {"
    yield "  int posed; /* whether it is known */"
    yield "  double x;"
    yield "  double y;"
    yield "  double heading;"
    yield "  int paced; /* whether its speed is known too */"
    yield "  double v;"
    yield "} tm_pose;"
    yield ""
    yield "/* A place of a path: how far from the point that was asked for, and the path's heading and speed there. */"
    yield "typedef struct {\n  double away;\n  double heading;\n  double v;\n} tm_spot;"
    yield ""
    yield "/* What the parts of a step tell each other. */"
    yield "typedef struct {"
    yield "  tm_decision *out;"
    yield "  size_t parts; /* that ran */"
    yield "  size_t breaches; /* all faults, counted beside the decision's */"
    yield "  size_t expected; /* candidates whose results were made ready for the rules */"
    yield "  size_t against; /* rules */"
    yield "  bool in_order; /* the stamp is */"
    yield "  bool doubt; /* a part did not run: nothing is sure about the step */"
    yield "  tm_pose car;"
    yield "  double car_t; /* s, when it was there */"
    yield "} tm_look;"
    yield ""
    yield "/* A cycle without fault goes through so many parts, up to the door's end. */"
    yield f"#define TM_PARTS {parts}u"
    yield "/* The margin of a rule, undefined, before it ran: no rule gives it. */"
    yield "#define TM_DID_NOT_RUN 0.0"
    yield "/* A context that tm_init has made, a configuration that is valid. */"
    yield f"#define TM_MADE UINT64_C(0x{int(given.layout.spec.fingerprint[:16] or '0', 16) | 1:016x})"
    yield f"#define TM_PLAN_T {columns['t']}"
    for number, name in enumerate(_EVENTS):
        yield f"#define TM_SO_{name.upper()} {number}u"
    yield f"#define TM_STATES {len(STATES)}u"
    yield "/* The state after a cycle, by the state before and what is so; -1: cannot be. */"
    rows = ", ".join("{" + ", ".join(str(_next(state, event)) for event in _EVENTS) + "}" for state in STATES)
    yield f"static const int tm_next[TM_STATES][{len(_EVENTS)}] = {{{rows}}};"
    yield "/* Which rules warn, and never decide. */"
    told = [str(rule.advisory).lower() for rule in given.layout.rules]
    yield "static const bool tm_advisory[TM_RULES] = {"
    yield from (f"  {', '.join(told[i : i + 16])}," for i in range(0, len(told), 16))
    yield "};"
    yield ""


def _next(state: str, event: str) -> int:
    after = NEXT.get((state, event))
    return -1 if after is None else STATES.index(after)


def functions(given: Supervised) -> Iterator[str]:
    """Definitions, the step last."""
    yield from _store(given)
    yield from _examine(given)
    step = STEP.read_text(encoding="utf-8").replace("/** ", "/* ")
    if given.layout.remembers:
        yield from commit(given.layout, given)
        body, end, rest = step.rpartition(END)
        step = body + CALL + end + rest
    yield step
    yield from _stored(given)


def _store(given: Supervised) -> Iterator[str]:
    t = next(c_name for info, c_name in given.plan.fields if info.name == "t")
    yield "/* Store the emergency trajectory of a safe cycle. */"
    yield "static void tm_store(tm_context *c, const tm_cycle *cycle)"
    yield "{"
    yield f"  const tm_in_{given.plan.c_name} *in = cycle->emergency;"
    yield "  tm_stored *to = &c->stored;"
    yield "  to->serial = 0u;"
    yield "  to->number = cycle->number;"
    yield "  to->t = cycle->t;"
    yield "  to->count = in->count;"
    yield "  for (size_t i = 0u; i < in->count; ++i) {"
    yield f"    to->{DUE}[i] = in->{t}[i] + cycle->t;"
    for _, c_name in given.plan.fields:
        yield f"    to->plan.{c_name}[i] = in->{c_name}[i];"
    yield "  }"
    yield "  to->serial = c->serial;"
    yield "  c->marks.store = c->serial;"
    yield "}"
    yield ""


def _examine(given: Supervised) -> Iterator[str]:
    """The chain of demands on a stored trajectory, of which the first that does not hold is the reason."""
    columns = {info.name: f"s->plan.{c_name}" for info, c_name in given.plan.fields}
    yield "/* Whether the stored trajectory may be driven now: why not, or TM_FAULT_NONE; and when the car was last seen on it. */"
    yield "static void tm_examine(const tm_context *c, const tm_look *look, double *confirmed, tm_fault_name *lost)"
    yield "{"
    yield "  const tm_stored *s = &c->stored;"
    yield "  const double now = look->out->now;"
    yield f"  const double end = s->{DUE}[s->count - 1u];"
    yield "  tm_spot at = {0.0, TM_NAN, TM_NAN};"
    yield "  double station = 0.0;"
    x, y, heading, v = (columns[name] for name in ("x", "y", "heading", "v"))
    yield f"  const int posed = ((look->car.posed != 0) && tm_station_at(s->{DUE}, {x}, {y}, s->count, look->car_t, &station)) ? 1 : 0;"
    yield "  const int paced = ((posed != 0) && (look->car.paced != 0)) ? 1 : 0;"
    yield "  if (posed != 0) {"
    yield f"    at = tm_spot_near({x}, {y}, {heading}, {v}, s->count, look->car.x, look->car.y, station - c->limits.apart,"
    yield "                    station + c->limits.apart);"
    yield "  }"
    yield "  const double away = at.away;"
    yield "  const double turn = look->car.heading - at.heading;"
    yield "  const double speed = look->car.v;"
    yield "  const double planned = at.v;"
    yield "  const double seen = ((posed != 0) && (look->car_t > s->confirmed)) ? look->car_t : s->confirmed;"
    names = {name: name for name in ("now", "end", "posed", "paced", "away", "turn", "speed", "planned")} | {
        "confirmed": "seen", **{name: f"c->limits.{name}" for name in LIMITS}
    }  # fmt: skip
    for place, demand in enumerate(STORED):
        yield f"  {'} else ' if place else ''}if (!{demand.holds.c(names)}) {{"
        yield f"    *lost = TM_FAULT_{demand.fault.upper()};"
    yield "  } else {"
    yield "    *confirmed = seen;"
    yield "    *lost = TM_FAULT_NONE;"
    yield "  }"
    yield "}"
    yield ""


def _stored(given: Supervised) -> Iterator[str]:
    own = given.plan.c_name
    yield f"bool tm_stored_plan(const tm_context *c, tm_in_{own} *plan, const double **due)"
    yield "{"
    yield "  if ((c->made != TM_MADE) || (c->stored.serial == 0u)) {"
    yield "    return false;"
    yield "  }"
    yield "  plan->count = c->stored.count;"
    for _, c_name in given.plan.fields:
        yield f"  plan->{c_name} = c->stored.plan.{c_name};"
    yield f"  if (due != NULL) {{ *due = c->stored.{DUE}; }}"
    yield "  return true;"
    yield "}"
    yield ""
    yield "size_t tm_stored_first(const tm_context *c, double now)"
    yield "{"
    yield "  size_t first = 0u;"
    yield "  if ((c->made == TM_MADE) && (c->stored.serial != 0u)) {"
    yield "    tm_due_by(c->stored.plan.TM_PLAN_T, c->stored.count, c->stored.t, now, &first);"
    yield "  }"
    yield "  return first;"
    yield "}"
    yield ""


def ego_of(given: Supervised) -> Iterator[str]:
    """Statements that note the car's pose, where it is usable."""
    c_name = given.signals[EGO]
    fields = {info.name: name for info, name in given.layout.input(EGO).fields}
    age = f" - ego->{fields['age']}" if "age" in fields else ""
    yield "  if (look->car.posed != 0) {"
    yield f"    const tm_in_{c_name} *ego = cycle->signals.{c_name};"
    yield f"    look->car_t = cycle->t{age};"
    for name in ("x", "y", "heading"):
        yield f"    look->car.{name} = ego->{fields[name]};"
    if "v" in fields:
        yield "    look->car.paced = 1;"
        yield f"    look->car.v = ego->{fields['v']};"
    yield "  }"
