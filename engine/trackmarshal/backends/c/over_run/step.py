"""What a Supervisor in C remembers of a step: the cycle as it was decided, with the trajectory that is driven from its stamp on."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.backends.c.supervised.judging import driven
from trackmarshal.runtime.contract import FOLLOWED, IS_DRIVEN, IS_EMERGENCY

#: The end of a step, before which what was decided is remembered; and how.
END = """  if (!out->safe) {
    tm_mourn(out);
"""
CALL = """  if (asked && !look.doubt) {
    tm_remember_step(c, cycle, out);
    if (c->run.serial != c->serial) { /* the next cycle would not know of this one: nothing is driven */
      tm_incomplete(&look, "memory");
      c->state = TM_STATE_NO_SAFE_TRAJECTORY;
      c->stored.serial = 0u;
      out->state = c->state;
      out->safe = false;
      out->driven = TM_DRIVE_NOTHING;
      out->first = TM_NOWHERE;
      out->driven_number = 0;
      out->driven_t = TM_NAN;
      out->stored = false;
      out->lost = TM_FAULT_NONE_STORED;
    }
  }
"""


def commit(plan: Layout, given: Supervised) -> Iterator[str]:
    """Definition of the function that is called at the end of a step in which nothing is in doubt."""
    own = given.plan
    columns = {info.name: c_name for info, c_name in own.fields}
    yield "/* The cycle is past, and what is driven decided: rules remember it so. */"
    yield "static void tm_remember_step(tm_context *c, const tm_cycle *cycle, const tm_decision *out)"
    yield "{"
    yield "  tm_input given;"
    yield from driven(plan, given)
    yield "  if (out->driven == TM_DRIVE_STORED) { /* from the last sample that was due at the cycle's stamp, its times counted from it */"
    yield "    size_t first = 0u;"
    yield "    tm_due_by(c->stored.plan.TM_PLAN_T, c->stored.count, c->stored.t, cycle->t, &first);"
    yield "    for (size_t i = first; i < c->stored.count; ++i) {"
    yield "      c->from_now[i] = c->stored.plan.TM_PLAN_T[i] + (c->stored.t - cycle->t);"
    yield "    }"
    yield f"    given.{own.c_name}.count = c->stored.count - first;"
    for info, c_name in own.fields:
        source = "c->from_now" if info.name == "t" else f"c->stored.plan.{c_name}"
        yield f"    given.{own.c_name}.{c_name} = &{source}[first];"
    followed = plan.inputs.get(FOLLOWED)
    if followed is not None:
        yield f"    given.{followed.c_name}.count = given.{own.c_name}.count;"
        for info, c_name in followed.fields:
            yield f"    given.{followed.c_name}.{c_name} = given.{own.c_name}.{columns[info.name]};"
    told = plan.event(IS_EMERGENCY)
    if told is not None:
        yield f"    given.{told.c_name} = TM_TRUE;"
    yield "  }"
    told = plan.event(IS_DRIVEN)
    if told is not None:
        yield f"  given.{told.c_name} = (out->driven != TM_DRIVE_NOTHING) ? TM_TRUE : TM_FALSE;"
    yield "  tm_remember_cycle(c, &given, out->driven != TM_DRIVE_NOTHING);"
    yield "}"
    yield ""
