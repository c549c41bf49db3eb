"""What comes with the generated code: an example program and a build file.

A whole Supervisor gets a program that runs from a file of cycles; rules alone get one that checks constant data.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from trackmarshal.backends.c.build import DIGITS, UNSIGNALLED
from trackmarshal.backends.c.cycles import FORMAT, FOUND, LETTERS, VERSION, digest, label
from trackmarshal.backends.c.layout import Input, is_lanes
from trackmarshal.backends.c.names import comment, distinct
from trackmarshal.backends.c.places import bordered, setter_names, sources
from trackmarshal.backends.c.rendering import render
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.backends.c.supervised.interface import LIMITS
from trackmarshal.ir.spec import FieldType
from trackmarshal.runtime.contract import EVENT, LINES, RECORD, TIMELINE, Signal
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.faults import FAULTS
from trackmarshal.runtime.machine import STATES

#: Samples of timelines in constant data; its sets have one element.
SAMPLES = 8


def example(source: Source, capacities: Mapping[str, int] | None = None) -> dict[str, str]:
    """The files of the example by name, with the build file. capacities: by macro, of a process, which is built too."""
    if source.supervised is None:
        files = {"main.c": render("example/check.c.j2", _constant(source))}
    else:
        context = _supervisor(source, source.supervised)
        files = {name: render(f"example/{name}.j2", context) for name in ("main.c", "cycles.c", "cycles.h")}
    made = {
        "name": source.name, "sources": [name for name in files if name.endswith(".c")], "process": capacities is not None,
        "capacities": list((capacities or {}).items()), "exact": DIGITS, "fast": UNSIGNALLED,
    }  # fmt: skip
    return files | {"CMakeLists.txt": render("example/CMakeLists.txt.j2", made)}


def _text(name: str) -> str:
    """What may stand between the quotation marks of C."""
    return comment(name).replace('"', "'")


# A whole Supervisor ----------------------------------------------------------------------------------------------


def _supervisor(source: Source, given: Supervised) -> dict[str, Any]:
    plan, contract = source.plan, given.contract
    assert contract.plan is not None
    candidates = [_columns(contract.plan, given.plan, name, name) for name in (DRIVING, EMERGENCY)]
    signals = [*candidates, *(_signal(source, given, signal) for signal in contract.signals)]
    return {
        "name": source.name,
        "format": FORMAT, "version": VERSION, "letters": LETTERS, "found": FOUND, "digest": digest(source),
        "plan": candidates[0],
        "signals": signals,
        "limits": list(LIMITS),
        "params": [{"name": label(name), "c": c_name} for name, c_name in plan.params.items()],
        "tables": [{"name": label(name), "c": c_name} for name, c_name in plan.tables.items()],
        "faults": list(FAULTS),
        "states": list(STATES),
        "rules": [label(code.rule.name) for code in source.rules],
        "borders": [signal for signal in signals if signal["form"] == "lines"], "lanes": bool(given.lanes),
        "has_flags": any(s["form"] == "event" or (s["form"] == "record" and s["flags"]) for s in signals),
        "has_flag_columns": any(s["form"] == "columns" and s["flags"] for s in signals),
    }  # fmt: skip


def _signal(source: Source, given: Supervised, signal: Signal) -> dict[str, Any]:
    c_name = given.signals[signal.name]
    if signal.form == EVENT:
        return {"form": "event", "name": label(signal.name), "member": f"signals.{c_name}", "flags": 0}
    if signal.form == LINES:
        fields = [
            {"name": label(field.name or "line"), "c": given.lines[signal.name, field.name], "row": row}
            for row, field in enumerate(signal.lines)
        ]
        closed = any(field.name for field in signal.lines)
        return {
            "form": "lines", "name": label(signal.name), "c": c_name, "member": f"signals.{c_name}", "type": f"tm_in_{c_name}",
            "what": f"Borders or a line: {comment(signal.name)}", "fields": fields, "closed": closed, "flags": 0,
        }  # fmt: skip
    return _columns(signal, source.plan.input(signal.name), c_name, f"signals.{c_name}")


def _columns(signal: Signal, item: Input, c_name: str, member: str) -> dict[str, Any]:
    """A timeline, set or record. The rows of numbers and of flags are counted each by themselves."""
    names = {info.name: name for info, name in item.fields}
    fields = [
        {"name": label(field.name), "c": names[field.name], "kind": field.kind, "row": row}
        for group in (signal.numbers, signal.flags)
        for row, field in enumerate(group)
    ]
    return {
        "form": "record" if signal.form == RECORD else "columns", "name": label(member.rpartition(".")[2]), "c": c_name,
        "member": member, "type": f"tm_in_{item.c_name}", "what": f"A {signal.form}: {comment(member.rpartition('.')[2])}",
        "capacity": "TM_MAX_SAMPLES" if signal.form == TIMELINE else "TM_MAX_ELEMENTS",
        "named": signal.named, "lanes": bool(signal.lines), "fields": fields, "numbers": len(signal.numbers), "flags": len(signal.flags),
    }  # fmt: skip


# Rules alone -----------------------------------------------------------------------------------------------------


def _constant(source: Source) -> dict[str, Any]:
    plan = source.plan
    setters = setter_names(plan)
    places = [
        (
            {"setter": setters[name], "name": _text(name), "lanes": is_lanes(plan.spec, name)},
            bordered(plan, name),
        )
        for name in sources(plan)
    ]
    inputs = list(plan.inputs.values())
    columns = [(item, info) for item in inputs if item.kind == "columns" for info, _ in item.fields]
    # What stands beside them in the program is one word.
    arrays = distinct(f"{item.name}.{info.name}" for item, info in columns)
    assignments = [pair for item in inputs for pair in _assignments(item, arrays)]
    return {
        "name": source.name,
        "data": [_data(item, info, arrays[f"{item.name}.{info.name}"]) for item, info in columns],
        "bordered": [place for place, bordered in places if bordered],
        "lined": [place for place, bordered in places if not bordered],
        "rules": [_text(code.rule.name) for code in source.rules],
        "assignments": assignments or ([] if plan.remembers else [("unused", "0")]),
        "over_run": plan.remembers,
        "ids": [f"{item.c_name}.id" for item in plan.named],
    }


def _data(item: Input, info: FieldType, array: str) -> dict[str, Any]:
    assert item.signal is not None
    count = SAMPLES if item.signal.sequence else 1
    if info.kind == "bool":
        return {"type": "tm_flag", "name": array, "values": ["TM_TRUE"] * count}
    step = 0.1 if info.increasing else 0.5 if item.signal.sequence and info.name in ("x", "s") else 0.0
    start = (
        info.default
        if info.default is not None
        else 1.0
        if info.name in ("length", "width", "grip")
        else 30.0
        if not item.signal.sequence and info.name == "x"
        else 0.0
    )
    values = [repr(round(start + step * k, 6)) for k in range(count)]
    return {"type": "double", "name": array, "values": values}


def _assignments(item: Input, arrays: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    if item.kind == "event":
        yield item.c_name, "TM_FALSE"
        return
    assert item.signal is not None
    if item.kind == "columns":
        yield f"{item.c_name}.count", f"{SAMPLES if item.signal.sequence else 1}u"
        yield from ((f"{item.c_name}.{c}", arrays[f"{item.name}.{info.name}"]) for info, c in item.fields)
        return
    for info, c_name in item.fields:
        yield f"{item.c_name}.{c_name}", "TM_TRUE" if info.kind == "bool" else "0.0"
    if not item.fields:
        yield f"{item.c_name}.unused", "0"
