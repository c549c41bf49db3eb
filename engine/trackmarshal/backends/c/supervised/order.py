"""What is demanded of a cycle as a whole, in C: that it follows the one before, comes in time, and has candidates that fit together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from trackmarshal.backends.c.supervised.checks import breach, text
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.backends.c.supervised.interface import LIMITS
from trackmarshal.runtime.contract.cycles import COUNTED, END, NUMBER, STAMP, START, TIMELY, Demand
from trackmarshal.runtime.cycle import EMERGENCY

_LIMITS = {name: f"c->limits.{name}" for name in LIMITS}
_CYCLE = '"cycle"'


def order(given: Supervised) -> Iterator[str]:
    """Number and stamp."""
    stamp = {"t": "t", "now": "now", "since": "since", "begun": "stamped", **_LIMITS}
    number = {"number": "number", "last": "last", "begun": "numbered"}
    yield "/* Whether number and stamp go on from those of the last cycle whose stamp was in order, and the stamp is in time. */"
    yield "static void tm_door_order(tm_context *c, const tm_cycle *cycle, tm_look *look)"
    yield "{"
    yield "  const int stamped = c->stamped ? 1 : 0;"
    yield "  const int numbered = c->numbered ? 1 : 0;"
    yield "  const int64_t number = cycle->number;"
    yield "  const int64_t last = c->number;"
    yield "  const double t = cycle->t;"
    yield "  const double now = look->out->now;"
    yield "  const double since = c->stamped ? (t - c->stamp) : 0.0;"
    yield "  if (!cycle->stamped) {"
    yield f'    if (!tm_named(cycle, "cycle", "t")) {{ {breach("missing", _CYCLE, text("t"))} }}'
    yield from _chain(STAMP, stamp, "} else ")
    yield "  } else {"
    yield "    look->in_order = true;"
    for demand in (*TIMELY, *(COUNTED if given.contract.over_run else ())):
        yield f"    if (!{demand.holds.c(stamp)}) {{ {_breach(demand)} }}"
    yield "  }"
    yield "  if (!cycle->numbered) {"
    yield f'    if (!tm_named(cycle, "cycle", "number")) {{ {breach("missing", _CYCLE, text("number"))} }}'
    yield from _chain(NUMBER, number, "} else ")
    yield "  } else {"
    yield "    /* in order */"
    yield "  }"
    yield "  if (look->in_order) {"
    yield "    c->stamp = t;"
    yield "    c->stamped = true;"
    yield "    if (cycle->numbered) {"
    yield "      c->number = number;"
    yield "      c->numbered = true;"
    yield "    }"
    yield "  }"
    yield "  ++look->parts;"
    yield "}"
    yield ""


def fit(given: Supervised) -> Iterator[str]:
    """What the candidates have to be together."""
    columns = {info.name: c_name for info, c_name in given.plan.fields}

    def apart(name: str) -> str:
        return f"d->{columns[name]}[0] - e->{columns[name]}[0]"

    names = {name: name for name in ("dx", "dy", "turn", "faster", "last")} | _LIMITS
    yield "/* Whether the emergency trajectory starts where the driving one does, and ends at rest; both have passed by themselves. */"
    yield f"static void tm_door_fit(const tm_context *c, const tm_in_{given.plan.c_name} *d, const tm_in_{given.plan.c_name} *e, tm_look *look)"
    yield "{"
    yield f"  const double dx = {apart('x')};"
    yield f"  const double dy = {apart('y')};"
    yield f"  const double turn = {apart('heading')};"
    yield f"  const double faster = {apart('v')};"
    yield f"  const double last = e->{columns['v']}[e->count - 1u];"
    for demands, index in ((START, "0u"), (END, "e->count - 1u")):
        for demand in demands:
            fault = breach(demand.fault, text(EMERGENCY), text(demand.field), index)
            yield f"  if (!{demand.holds.c(names)}) {{ {fault} }}"
    yield "  ++look->parts;"
    yield "}"
    yield ""


def _breach(demand: Demand) -> str:
    return breach(demand.fault, _CYCLE, text(demand.field))


def _chain(demands: Sequence[Demand], names: Mapping[str, str], before: str) -> Iterator[str]:
    """Branches of which the first demand that does not hold is taken."""
    for demand in demands:
        yield f"  {before}if (!{demand.holds.c(names)}) {{"
        yield f"    {_breach(demand)}"
