"""The description of a program's messages as JSON, and its fingerprint: what both sides have to have in common."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from typing import Any

from trackmarshal.backends.c.cycles import digest
from trackmarshal.backends.c.process.messages import CAUSES, HEAD, MAGIC, VERSION, Message, Table
from trackmarshal.backends.c.process.regions import BELL, LINE, Region, regions
from trackmarshal.backends.c.process.regions import MAGIC as REGION_MAGIC
from trackmarshal.backends.c.process.regions import VERSION as REGION_VERSION
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.supervised.interface import FAULT_NAMES, LIMITS, in_force
from trackmarshal.runtime.contract import SET
from trackmarshal.runtime.machine import STATES
from trackmarshal.runtime.verdict import VERDICTS

#: s: from one sign of life of the Supervisor to the next, and how long none may be heard before it is taken for dead.
PERIOD, SILENCE = 0.01, 0.05
#: The largest message that one datagram takes.
DATAGRAM = 65_507


def describe(
    source: Source,
    table: Table,
    limits: Mapping[str, float],
    params: Mapping[str, float],
    tables: Mapping[str, Any],
) -> dict[str, Any]:
    """What JSON says but for what is known once all is written: `engine`, the hash of what is compiled, and `layout`, the fingerprint of the rest.

    limits, params (SI) and tables (knots, values; SI) are those in force.
    """
    spec = source.plan.spec
    assert source.supervised is not None
    assert source.supervised.contract.plan is not None
    return {
        "format": "trackmarshal-messages",
        "version": VERSION,
        "byte_order": "little",
        "magic": MAGIC,
        "head": HEAD[-1].size + sum(item.size for item in HEAD[:-1]),
        "program": digest(source),
        "period": PERIOD,
        "silence": SILENCE,
        "datagrams": all(message.length <= DATAGRAM for message in table.messages),
        "capacities": dict(table.capacities),
        "limits": {name: _number(limits[name]) for name in LIMITS},
        "params": {name: _number(value) for name, value in in_force(source.plan, params, limits).items()},
        "tables": {
            name: [[_number(x) for x in column] for column in tables.get(name, (spec.tables[name].knots, spec.tables[name].values))]
            for name in source.plan.tables
        },
        "plan": [field.name for field in source.supervised.contract.plan.numbers],
        "rules": [{"name": code.rule.name, "unit": code.rule.unit} for code in source.rules],
        "lines": [{"signal": signal, "field": field} for signal, field, _, _ in table.lines],
        "sets": [signal.name for signal in source.supervised.inputs if signal.form == SET],
        "signals": list(table.signals),
        "fields": list(table.fields),
        "faults": list(FAULT_NAMES),
        "states": list(STATES),
        "verdicts": list(VERDICTS),
        "causes": list(CAUSES),
        "messages": [_message(message) for message in table.messages],
        "memory": {
            "magic": REGION_MAGIC, "version": REGION_VERSION, "bell": BELL, "line": LINE,
            "files": [_region(region) for region in regions(table)],
        },
    }  # fmt: skip


def fingerprint(said: Mapping[str, Any]) -> str:
    """Of a description: two that have the same one are of one program."""
    text = json.dumps(_bare(said), sort_keys=True, ensure_ascii=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _bare(said: Any) -> Any:
    """Without explanations: other words for the same are no other layout."""
    if isinstance(said, dict):
        return {name: _bare(value) for name, value in said.items() if name != "about"}
    return [_bare(value) for value in said] if isinstance(said, list) else said


def text_of(said: Mapping[str, Any]) -> str:
    """For a file: an entry a line."""
    whole = json.dumps(said, indent=1, ensure_ascii=True, allow_nan=False)
    return whole + "\n"


def _number(x: float) -> float | str:
    return float(x) if math.isfinite(x) else "inf" if x > 0 else "-inf" if x < 0 else "nan"


def _message(message: Message) -> dict[str, Any]:
    entries = [
        {
            "name": item.key, "offset": item.offset, "type": item.type, "count": item.count, "array": not item.scalar,
            "about": item.about, **({} if item.default is None else {"default": _number(item.default)}),
            **({"members": [*item.members]} if item.members else {}), **({"unit": item.unit} if item.unit else {}),
        }
        for item in message.items
    ]  # fmt: skip
    return {
        "name": message.name, "kind": message.kind, "from": "planner" if message.up else "supervisor", "length": message.length,
        "about": message.about, "entries": entries,
    }  # fmt: skip


def _region(region: Region) -> dict[str, Any]:
    boxes = [
        {
            "name": box.name,
            "message": box.message,
            "place": box.place,
            "first": box.first,
            "slots": box.slots,
            "step": box.step,
        }
        for box in region.mailboxes
    ]
    return {"name": region.name, "size": region.size, "mailboxes": boxes}
