"""All rules on both candidates of a cycle in C; what reads nothing of a candidate is computed once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal.backends.c.functions.groups import GroupCode
from trackmarshal.backends.c.functions.rules import RuleCode, constant
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.backends.over_run.outcome import is_ahead
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.contract import FOLLOWED, IS_DRIVEN, IS_EMERGENCY, PLAN
from trackmarshal.runtime.driven import MOST_LOST


def of_candidate(rule: RuleInfo) -> bool:
    """Whether a rule reads anything that differs between the candidates."""
    if any(signal in (PLAN, IS_EMERGENCY) for signal, _ in rule.reads):
        return True
    for root in rule.roots:
        for node in ir.below(root):
            named = getattr(node, "signal", None) or (node.name if isinstance(node, ir.Line) else None)
            if named in (PLAN, IS_EMERGENCY):
                return True
    return False


def calls(plan: Layout, codes: Sequence[RuleCode], groups: Sequence[GroupCode]) -> Iterator[str]:
    """Statements that compute rules: groups, then what is left."""
    for course in plan.courses.values():
        yield f"  c->course.{course.c_name}.count = 0u;"
        yield f"  tm_join_{course.c_name}(c, in);"
    grouped = {rule.name for group in groups for rule in group.rules}
    if any(is_ahead(code.rule) for code in codes):
        yield "  c->run.future.ready = 0u;"
        yield "  tm_look_ahead(c, in, true, false);"
    for group in groups:
        yield f"  {group.c_name}(c, in, out);"
    for code in codes:
        if code.rule.name not in grouped:
            yield f"  {code.entry}(c, in, &out->rule[{constant(code.c_name)}]);"


def judge(
    plan: Layout, given: Supervised, codes: Sequence[RuleCode], groups: Sequence[GroupCode]
) -> Iterator[str]:
    """Definition of the judge: a cycle that has passed the door, and all rules' results in the decision."""
    mine = [code for code in codes if of_candidate(code.rule)]
    own = [group for group in groups if all(of_candidate(rule) for rule in group.rules)]
    told = plan.event(IS_EMERGENCY)
    yield "/* All rules on both candidates of a cycle that the door let pass. */"
    yield "static void tm_judge(tm_context *c, const tm_cycle *cycle, tm_look *look)"
    yield "{"
    yield "  tm_input given;"
    yield "  const tm_input *in = &given;"
    yield "  tm_output *out = &look->out->driving;"
    yield from driven(plan, given)
    if plan.remembers:
        yield from _missed()
        yield "  if (!tm_begin_cycle(c, in, cycle->t) || (c->run.begun != c->serial)) {"
        yield "    return; /* it is no cycle of the run: no rule says anything */"
        yield "  }"
    yield from calls(plan, codes, groups)
    yield f"  given.{given.plan.c_name} = *cycle->emergency;"
    if told is not None:
        yield f"  given.{told.c_name} = TM_TRUE;"
    yield "  out = &look->out->emergency;"
    yield from calls(plan, mine, own)
    for code in codes:
        if code not in mine:
            yield f"  out->rule[{constant(code.c_name)}] = look->out->driving.rule[{constant(code.c_name)}];"
    yield "  c->marks.judge = c->serial;"
    yield "}"
    yield ""


def _missed() -> Iterator[str]:
    """Statements that say how many cycles are missing before the present one: those of which a step knew, or as many as their numbers say
    where more were lost on the way."""
    yield "  c->run.missed = 0u;"
    yield "  if (c->run.any) {"
    yield "    const uint64_t steps = c->serial - c->run.serial;"
    yield "    uint64_t numbers = 0u;"
    yield "    if (cycle->number > c->run.number) {"
    yield "      numbers = (uint64_t)cycle->number - (uint64_t)c->run.number;"
    yield f"      numbers = (numbers < UINT64_C({MOST_LOST})) ? numbers : UINT64_C({MOST_LOST});"
    yield "    }"
    yield "    c->run.missed = ((numbers > steps) ? numbers : steps) - 1u;"
    yield "  }"


def driven(plan: Layout, given: Supervised) -> Iterator[str]:
    """Statements that put together what rules read of a cycle, `plan` being the driving trajectory."""
    yield f"  given.{given.plan.c_name} = *cycle->driving;"
    yield from _followed(plan, given)
    for signal in given.inputs:
        yield f"  given.{given.signals[signal.name]} = *cycle->signals.{given.signals[signal.name]};"
    for signal in given.events:
        if signal.name in plan.inputs:
            yield f"  given.{given.signals[signal.name]} = cycle->signals.{given.signals[signal.name]};"
    for name, said in ((IS_EMERGENCY, "TM_FALSE"), (IS_DRIVEN, "TM_TRUE")):
        told = plan.event(name)
        if told is not None:
            yield f"  given.{told.c_name} = {said};"


def _followed(plan: Layout, given: Supervised) -> Iterator[str]:
    """The driving trajectory, where rules read it beside their candidate: the same memory, of which they have a struct of their own."""
    followed = plan.inputs.get(FOLLOWED)
    if followed is None:
        return
    names = {info.name: c_name for info, c_name in given.plan.fields}
    yield f"  given.{followed.c_name}.count = cycle->driving->count;"
    for info, c_name in followed.fields:
        yield f"  given.{followed.c_name}.{c_name} = cycle->driving->{names[info.name]};"
