"""The C of what rules remember: its types, the functions that recall it, and those that put a cycle into it once it is driven."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.courses import counts_samples
from trackmarshal.backends.c.courses import described as course
from trackmarshal.backends.c.functions.types import CASES, TALLY
from trackmarshal.backends.c.layout import Input, Layout
from trackmarshal.backends.c.names import comment, where
from trackmarshal.backends.c.over_run import waiting
from trackmarshal.backends.c.over_run.cells import Cell
from trackmarshal.backends.c.over_run.noting import note, settle
from trackmarshal.backends.c.over_run.pairs import Pairs
from trackmarshal.backends.c.rendering import render
from trackmarshal.backends.over_run.machines import reached
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import SignalType

#: Sorts of windows: what they keep, what an empty one comes to, how newer and older items are joined, what a gap and what anything may be.
_CASES: dict[str, Any] = {"value": "tm_cases", "gap": "tm_unknown_any()", "unknown": "tm_unknown_any()"}
_TALLY: dict[str, Any] = {
    "value": "tm_tally",
    "nothing": "tm_no_tally()",
    "join": "  return tm_tallied(newer, older);",
}
WINDOWS: dict[str, dict[str, Any]] = {
    "once": {**_CASES, "nothing": "tm_false_any()", "join": "  return tm_or_any(newer, older);"},
    "historically": {**_CASES, "nothing": "tm_true_any()", "join": "  return tm_and_any(newer, older);"},
    "since": {
        "value": "tm_steps", "nothing": "tm_no_step()", "join": "  return tm_step_after(newer, older);", "gap": "tm_any_step()",
        "unknown": "tm_any_step()",
    },
    "count": {**_TALLY, "gap": "tm_any_tally(run->missed, false)", "unknown": "tm_any_tally(UINT64_C(1) << 60u, false)"},
    "recount": {**_TALLY, "gap": "tm_any_tally(run->missed, true)", "unknown": "tm_any_tally(UINT64_C(1) << 60u, true)"},
}  # fmt: skip
_ABOUT = {
    "once": "`once`", "historically": "`historically`", "since": "`since`", "count": "A count", "recount": "A count that starts anew",
}  # fmt: skip
#: What operands are called, by the sort of memory.
_OPERANDS = {
    "once": ("p",), "historically": ("p",), "previous": ("p",), "since": ("p", "q"), "count": ("p",), "recount": ("p", "reset"),
}  # fmt: skip


def described(plan: Layout) -> dict[str, Any]:
    """What the templates ask about what is remembered."""
    kinds = {
        name: {"name": name, "about": _ABOUT[name], **window}
        for name, window in WINDOWS.items() if any(each.kind == name for each in plan.kept.values())
    }  # fmt: skip
    return {
        "cases": CASES,
        "kinds": kinds,
        "sets": [_set(plan, item) for item in plan.named],
        "pairs": [_pairs(plan, pair) for pair in plan.pairs.values()],
        "lasting": any(item.signal is not None and item.signal.forget for item in plan.named),
        "kept": [_described(plan, each) for each in plan.kept.values()],
        "comment": comment,
        "tally": TALLY if counts_samples(plan.nodes) else "",
        "courses": [course(each, partial(_of_input, plan)) for each in plan.courses.values()],
        "notes": any(rule.over_run for rule in plan.rules),
        "ahead": waiting.described(plan) if plan.future.rules else None,
    }


def _of_input(plan: Layout, signal: str, field: str) -> str:
    """C of a field of an input; of none, how many samples it has."""
    name = plan.field_name(signal, field) if field else "count"
    return f"{plan.input(signal).c_name}.{name}"


def _described(plan: Layout, each: Cell) -> dict[str, Any]:
    spoken = "" if each.span is None else f": {where(each.span)}"
    axes, pair = each.axes, plan.pairs.get(tuple(axis.signal for axis in each.axes))
    own: dict[str, Any] = {
        "kind": each.kind, "c_name": each.c_name, "about": f"{comment(each.shown)}{spoken}", "set": plan.places_of(axes),
        "most": _lasting(plan.spec.signals[axes[0].signal] if axes else None)["room"], "pair": None,
        "forget": any(axis.forget for axis in axes), "reaches": each.upper is None or each.upper > 0,
        "lives": f"{plan.places_of(axes)}.life", "absent": "tm_absent",
    }  # fmt: skip
    if pair is not None:
        both = _pairs(plan, pair)
        own |= {
            "pair": both,
            "most": both["room"],
            "lives": f"{pair.c_name}.pair",
            "absent": "tm_pairs_absent",
        }
    if isinstance(each.node, ir.Machine):
        asked = list(plan.nodes)
        machine = each.node
        said = any(isinstance(node, ir.InState) and node.machine is machine for node in asked)
        kept = any(isinstance(node, ir.Kept) and node.machine is machine for node in asked)
        return {**own, **_machine(machine), "said": said, "recalled": kept}
    return {
        **own, "operands": _OPERANDS[each.kind], "room": _room(each),
        "value": WINDOWS[each.kind]["value"] if each.kind in WINDOWS else "tm_cases",
        "lower": f"INT64_C({each.lower})", "upper": "INT64_C(-1)" if each.upper is None else f"INT64_C({each.upper})",
        "weak": isinstance(each.node, ir.OverRun) and each.node.weak, "ripe": each.lower == 0,
    }  # fmt: skip


def _set(plan: Layout, item: Input) -> dict[str, Any]:
    """A set whose elements are known again in other cycles. Where others that they are paired with may be absent, they may be so for no time."""
    lasting, paired = _lasting(item.signal), item.name in plan.paired
    forget = lasting["forget"] or ("INT64_C(0)" if paired else "")
    return {"name": item.name, "c_name": item.c_name, **lasting, "forget": forget, "paired": paired}


def _pairs(plan: Layout, pair: Pairs) -> dict[str, Any]:
    first, second = (_set(plan, plan.input(signal)) for signal in (pair.first, pair.second))
    return {
        "c_name": pair.c_name, "first": first, "second": second, "room": f"({first['room']} * {second['room']})", "forget": pair.forget,
    }  # fmt: skip


def _lasting(signal: SignalType | None) -> dict[str, str]:
    """For how long elements of a set may be absent, in C, and how many have a memory."""
    if signal is None or not signal.forget:
        return {"forget": "", "room": "TM_MAX_ELEMENTS"}
    return {"forget": f"INT64_C({signal.forget})", "room": f"{signal.capacity}u"}


def _machine(machine: ir.Machine) -> dict[str, Any]:
    """A state machine: of each state what leads out of it, in order, and where transitions may lead from it."""
    states, names = list(machine.states), list(machine.names)
    leads = {
        state: [
            {
                "guard": number, "target": states.index(target),
                "notes": [(names.index(name), k) for k, (taker, name) in enumerate(machine.kept) if taker == number],
            }
            for number, (target, sources) in enumerate(zip(machine.targets, machine.sources)) if state in sources
        ]
        for state in states
    }  # fmt: skip
    return {
        "states": [{"name": comment(state), "leads": leads[state], "reached": list(map(states.index, reached(machine, [state])))} for state in states],
        "bridges": f"INT64_C({machine.bridges})" if machine.bridges else "",
        "start": states.index(machine.start), "names": [comment(name) for name in names],
        "guards": range(len(machine.guards)), "numbers": range(len(machine.numbers)),
    }  # fmt: skip


def _room(each: Cell) -> str:
    """C of how many items a window has room for."""
    longest = each.lower if each.upper is None else each.upper
    if each.upper is None and longest == 0:
        return "2u"
    return f"TM_CYCLES_IN(UINT64_C({math.ceil(longest / 1e6)}))"


def types(plan: Layout, supervised: bool) -> str:
    """Types of what is remembered, for the header."""
    return (
        render("program/over_run/types.h.j2", {**described(plan), "supervised": supervised})
        if plan.remembers
        else ""
    )


def recalling(plan: Layout) -> list[str]:
    """Functions that rules call."""
    if not plan.remembers:
        return []
    given = described(plan)
    windows = [
        render("program/over_run/window.c.j2", {"kind": kind, "lasting": given["lasting"]})
        for kind in given["kinds"].values()
    ]
    found = [*windows, render("program/over_run/recall.c.j2", given)]
    if plan.future.rules:
        found += [*waiting.put_together(plan), render("program/over_run/future.c.j2", given)]
    return found


def joining(plan: Layout) -> list[str]:
    """Functions that keep what was driven, and join it with what is planned."""
    return [render("program/over_run/course.c.j2", described(plan))] if plan.courses else []


def remembering(plan: Layout, supervised: bool) -> list[str]:
    """Functions that put a cycle into memory."""
    if not plan.remembers:
        return []
    given = {**described(plan), "supervised": supervised}
    found = ["\n".join([*c.printed(note(plan)), ""])] if given["notes"] else []
    if plan.future.rules:
        found += ["\n".join([*c.printed(settle(plan)), ""]), render("program/over_run/follow.c.j2", given)]
    return [*found, render("program/over_run/remember.c.j2", given)]
