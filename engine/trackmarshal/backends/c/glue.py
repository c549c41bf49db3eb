"""The binding of a program: everything flattened to arrays, so that Python needs to know no struct."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from trackmarshal.backends.c import parts
from trackmarshal.backends.c.functions.online import Monitor
from trackmarshal.backends.c.rendering import render
from trackmarshal.backends.c.setters import glue as places
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.supervised.binding import glue as supervised


@dataclass(frozen=True)
class Flat:
    """The order of what the binding takes: sets and timelines; their columns; numbers; flags, events among them (field "").

    ids: the sets whose elements are known again in other cycles. timed: whether cycles have a stamp.
    """

    counts: tuple[str, ...]
    columns: tuple[tuple[str, str, bool], ...]
    numbers: tuple[tuple[str, str], ...]
    flags: tuple[tuple[str, str], ...]
    ids: tuple[str, ...]
    timed: bool


def flat(source: Source) -> Flat:
    """The order for a program."""
    inputs = source.plan.inputs.values()
    return Flat(
        tuple(item.name for item in inputs if item.kind == "columns"),
        tuple(
            (item.name, info.name, info.kind == "bool")
            for item in inputs
            if item.kind == "columns"
            for info, _ in item.fields
        ),
        tuple(
            (item.name, info.name)
            for item in inputs
            if item.kind == "record"
            for info, _ in item.fields
            if info.kind != "bool"
        ),
        tuple(
            (item.name, info.name if info is not None else "")
            for item in inputs
            for info in (
                [None]
                if item.kind == "event"
                else [f for f, _ in item.fields if item.kind == "record" and f.kind == "bool"]
            )
        ),
        tuple(item.name for item in source.plan.named),
        source.plan.remembers,
    )


def glue(source: Source) -> str:
    """The C of the binding."""
    given = source.supervised
    body = _rules(source) if given is None else "\n".join([*supervised(given), ""])
    return render(
        "program/glue.c.j2",
        {"name": source.name, "rules": body, "monitors": [_monitor(each) for each in source.monitors]},
    )


def _monitor(each: Monitor) -> dict[str, Any]:
    fields = [(c_name, "tm_flag" if info.kind == "bool" else "double") for info, c_name in each.fields]
    return {"name": each.c_name, "fields": fields}


def _alongs(source: Source) -> list[str]:
    """What says a formula's value at every sample, and functions that only this calls."""
    texts = [code.along for code in source.rules if code.along]
    known = parts.functions()
    return [known[name] for name in parts.needed(texts) if known[name] not in source.source] + texts


def _rules(source: Source) -> str:
    """The rules by themselves."""
    plan, order = source.plan, flat(source)

    def place(name: str, field: str) -> str:
        c_name = plan.input(name).c_name
        return f"{c_name}.{plan.field_name(name, field)}" if field else c_name

    context = {
        "params": list(plan.params.values()), "tables": list(plan.tables.values()), "places": "\n".join(places(plan)),
        "counts": [plan.input(name).c_name for name in order.counts],
        "columns": [(place(name, field), "tm_flag" if flag else "double") for name, field, flag in order.columns],
        "numbers": [place(*each) for each in order.numbers], "flags": [place(*each) for each in order.flags],
        "ids": [plan.input(name).c_name for name in order.ids], "timed": order.timed,
        "nothing": not plan.inputs and not order.timed, "alongs": _alongs(source),
        "waiting": bool(plan.future.rules), "lasting": [plan.input(name).c_name for name in plan.lasting],
        "cases": [(index, code.c_name) for index, code in enumerate(source.rules) if code.along],
    }  # fmt: skip
    return render("program/rules.c.j2", context)
