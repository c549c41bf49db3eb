"""The C of a Supervisor as a process, as files: messages, mailboxes, the process, clients, the executing layer."""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from trackmarshal.backends.c.capacities import of_limits
from trackmarshal.backends.c.cycles import FOUND, label
from trackmarshal.backends.c.header import compiled
from trackmarshal.backends.c.names import literal
from trackmarshal.backends.c.process.description import PERIOD, SILENCE, describe, fingerprint, text_of
from trackmarshal.backends.c.process.messages import CAUSES, HEAD, MAGIC, VERSION, Table
from trackmarshal.backends.c.process.regions import BELL, LINE, regions
from trackmarshal.backends.c.process.regions import MAGIC as REGION_MAGIC
from trackmarshal.backends.c.process.regions import VERSION as REGION_VERSION
from trackmarshal.backends.c.process.table import table
from trackmarshal.backends.c.rendering import render
from trackmarshal.backends.c.source import Source, generated
from trackmarshal.backends.c.supervised.binding import SAID
from trackmarshal.backends.c.supervised.interface import FAULT_NAMES, LIMITS, in_force
from trackmarshal.runtime.contract import LINES, RECORD, TIMELINE, Signal
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.decision import MOST_REASONS
from trackmarshal.runtime.frame import NO_SETTINGS, Settings
from trackmarshal.runtime.machine import STATES

#: Why an executing layer does what it does, in the order in which C counts.
WHYS = {
    "unheard": "nothing was ever decided",
    "decided": "the newest decision says so",
    "restarted": "this Supervisor has nothing stored; the one before it had",
    "silent": "no sign of life of the Supervisor",
    "outdated": "no decision in time, or one from the future",
    "left": "what was decided has been left before, and is not taken up again",
    "ended": "the driving trajectory has been driven to its end",
}
#: The sources of the process, beside that of the Supervisor itself.
UNITS = ("messages.c", "desk.c", "mailbox.c", "process.c")
_GENERATED = (
    "messages.h", "messages.c", "desk.c", "mailbox.h", "mailbox.c", "client.c", "client_example.c", "executing.h", "executing.c",
)  # fmt: skip
_PLAIN = ("desk.h", "process.c", "client.h")
#: What is compiled of these into the process.
_COMPILED = (*UNITS, "messages.h", "desk.h", "mailbox.h")
FILES = (*_GENERATED, *_PLAIN, "messages.json")
_FOLDER = Path(__file__).parent / "templates"


class Emitted:
    """Files of a process by name, and the description of its messages. limits by name, capacities among them; settings as those of the
    Supervisor in Python. Raises TrackmarshalError E476 for what messages cannot tell apart."""

    def __init__(self, source: Source, limits: Mapping[str, float], settings: Settings = NO_SETTINGS) -> None:
        #: Capacities by macro, for the compiler.
        made = table(source, of_limits(source.plan.spec, limits))
        self.sizes = dict(made.capacities)
        self.description = describe(source, made, limits, settings.params, settings.tables)
        context = _context(source, made, self.description, limits, settings)
        self.files = {name: render(f"{name}.j2", context, _FOLDER) for name in _GENERATED}
        self.files |= {name: (_FOLDER / name).read_text(encoding="utf-8") for name in _PLAIN}
        self.description["engine"] = _engine(source, [self.files[name] for name in _COMPILED])
        self.description["layout"] = context["layout"] = fingerprint(self.description)
        self.files["messages.h"] = render("messages.h.j2", context, _FOLDER)
        self.files["messages.json"] = text_of(self.description)


def _engine(source: Source, files: Iterable[str]) -> str:
    """The hash of all code of a process, which differs where another engine made it of the same spec. Monitors, which only `compile` writes and no
    process calls, are none of it."""
    rules = [code.rule for code in source.rules]
    plain = generated(source.plan.spec, rules, doored=True) if source.monitors else source
    code = [
        compiled(plain.header + plain.source, plain.name),
        *(compiled(file, source.name) for file in files),
    ]
    return hashlib.sha256("\0".join(code).encode()).hexdigest()[:16]


def _context(
    source: Source, made: Table, said: Mapping[str, Any], limits: Mapping[str, float], settings: Settings
) -> dict[str, Any]:
    given, spec = source.supervised, source.plan.spec
    assert given is not None
    assert given.contract.plan is not None
    groups = [
        *(
            _group(given.contract.plan, given.plan.fields, given.plan.c_name, name)
            for name in (DRIVING, EMERGENCY)
        )
    ]
    for signal in given.inputs:
        c_name = given.signals[signal.name]
        groups.append(_group(signal, source.plan.input(signal.name).fields, c_name, ""))
    for signal in given.borders:
        groups.append(_bordered(signal, given.signals[signal.name], made))
    numbers = [field for field in groups[0]["fields"] if not field["flag"]]
    heading = [field["name"] for field in numbers].index("heading")
    members = [k for k, field in enumerate(given.contract.plan.numbers) if field.members]
    plan_t = next(field["c"] for field in numbers if field["name"] == "t")
    tables = []
    for name, c_name in source.plan.tables.items():
        knots, values = settings.tables.get(name, (spec.tables[name].knots, spec.tables[name].values))
        tables.append({"c": c_name, "knots": [*map(literal, knots)], "values": [*map(literal, values)]})
    return {
        "name": source.name, "messages": made.messages, "head": HEAD, "head_size": said["head"], "magic": MAGIC, "version": VERSION,
        "layout": "0", "period": PERIOD, "silence": SILENCE, "causes": CAUSES, "found": FOUND, "reasons": MOST_REASONS,
        "capacities": list(made.capacities.items()), "lines": made.lines, "datagrams": said["datagrams"],
        "longest": max(message.length for message in made.messages),
        "signals": [*map(_word, made.signals)], "fields": ["", *map(_word, made.fields[1:])], "faults": list(FAULT_NAMES),
        "rules": [_word(code.rule.name) for code in source.rules], "states": list(STATES),
        "plan": [_word(field["name"]) for field in numbers], "plan_fields": groups[0]["fields"], "numbers": numbers,
        "heading": heading, "members": members, "plan_t": plan_t, "given": groups, "said": SAID, "whys": WHYS,
        "events": [{"c": given.signals[s.name], "group": f"in_{given.signals[s.name]}"} for s in given.events],
        "every_line": [{"slot": slot, "signal": c, "c": member} for slot, (_, _, c, member) in enumerate(made.lines)],
        "limits": [(name, _c(limits[name])) for name in LIMITS],
        "params": [
            (source.plan.params[name], literal(value)) for name, value in in_force(source.plan, settings.params, limits).items()
        ],
        "tables": tables, "crc": _crc(),
        "regions": regions(made), "region_magic": REGION_MAGIC, "region_version": REGION_VERSION, "bell": BELL, "line": LINE,
    }  # fmt: skip


def _crc() -> list[list[str]]:
    """What a CRC of zero comes to of each byte, with 0, 1, ... 7 others behind it that are 0."""
    return [
        [f"0x{zlib.crc32(bytes([one, *behind]), 2**32 - 1) ^ 2**32 - 1:08x}u" for one in range(256)]
        for behind in map(bytes, range(8))
    ]


def _word(name: str) -> str:
    return label(name)


def _c(x: float) -> str:
    return "(double)INFINITY" if x == float("inf") else literal(float(x))


def _group(signal: Signal, infos: Sequence[tuple[Any, str]], c_name: str, candidate: str) -> dict[str, Any]:
    """Columns, or a record. A field's place is its bit in `absent`."""
    names = {info.name: c for info, c in infos}
    fields = [
        {"name": field.name, "c": names[field.name], "place": place, "flag": field.kind == "bool"}
        for place, field in enumerate((*signal.numbers, *signal.flags))
    ]
    record = signal.form == RECORD
    return {
        "kind": "record" if record else "columns", "record": record, "c": candidate or f"in_{c_name}", "type": f"tm_in_{c_name}",
        "member": candidate or f"signals.{c_name}", "fields": fields, "closed": False, "lines": [],
        "named": signal.named, "capacity": "TM_MAX_SAMPLES" if signal.form == TIMELINE else "TM_MAX_ELEMENTS",
    }  # fmt: skip


def _bordered(signal: Signal, c_name: str, made: Table) -> dict[str, Any]:
    if signal.form != LINES:
        raise AssertionError(f"{signal.name} has no borders")
    lines = [
        {"c": member, "slot": slot}
        for slot, (name, _, _, member) in enumerate(made.lines)
        if name == signal.name
    ]
    return {
        "kind": "lines", "record": False, "c": f"in_{c_name}", "type": f"tm_in_{c_name}", "member": f"signals.{c_name}", "fields": [],
        "closed": any(field.name for field in signal.lines), "lines": lines, "capacity": "",
        "named": False,
    }  # fmt: skip
