"""The messages to and from a Supervisor that is a process of its own: one table, from which header, packers and description are made.

Every message has a fixed length; every entry of it has a fixed place, with room for as much as was declared. docs/process.md says what
the messages are for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from trackmarshal.backends.c.capacities import capacities
from trackmarshal.backends.c.cycles import FOUND
from trackmarshal.backends.c.header import unit
from trackmarshal.backends.c.layout import Input
from trackmarshal.backends.c.process.messages import CAUSES, Item, Table, message, own
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.supervised.binding import SAID
from trackmarshal.backends.c.supervised.contract import Supervised
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.contract import RECORD, TIMELINE, Signal
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.decision import MOST_REASONS
from trackmarshal.units import parse_unit, show

#: The most lines, and fields of a signal, that a mask of 64 bits tells apart.
_MOST = 64


def table(source: Source, sizes: Mapping[str, int]) -> Table:
    """The messages of a program with these capacities; raises TrackmarshalError E476 where it has too many lines or fields."""
    given = source.supervised
    assert given is not None
    lines = tuple(
        (signal.name, field.name, given.signals[signal.name], given.lines[signal.name, field.name])
        for signal in given.borders
        for field in signal.lines
    )
    for signal in given.lanes:
        raise TrackmarshalError(
            "E476", f"messages have no place for the lanes of `{signal.name}`", help="run the Supervisor where the cycles are made"
        )  # fmt: skip
    signals, fields = _names(given)
    _bounded(lines, "lines")
    messages = (
        message("cycle", 1, True, "one cycle: what `tm_cycle` has", _cycle(source, given, lines, sizes)),
        message(
            "line",
            2,
            True,
            "the points of a border or line, sent when they change",
            _line(sizes) if lines else (),
        ),
        message("tick", 3, True, "time has passed: for a Supervisor whose clock is that of its messages", ()),
        message("decision", 4, False, "what is driven, and why", _decision(source, given, sizes)),
        message("beat", 5, False, "the Supervisor is there", _beat()),
    )
    return Table(
        messages, lines, signals, fields, {name: sizes[name] for name in capacities(source.plan, given)}
    )


def _names(given: Supervised) -> tuple[tuple[str, ...], tuple[str, ...]]:
    contract = given.contract
    assert contract.plan is not None
    every = (contract.plan, *contract.signals)
    signals = [
        DRIVING,
        EMERGENCY,
        "cycle",
        "clock",
        "supervisor",
        *(signal.name for signal in contract.signals),
    ]
    # Parts of the Supervisor stand where a field does.
    parts = [
        "door",
        "judge",
        "rating",
        "watchdog",
        "sound",
        "store",
        "machine",
        "memory",
        "supervisor",
        "number",
        "t",
        "step",
    ]
    fields = ["", *(field.name for signal in every for field in signal.fields_), "id", "closed", *parts]
    return tuple(dict.fromkeys(signals)), tuple(dict.fromkeys(fields))


def _bounded(things: Sequence[object], what: str) -> None:
    if len(things) > _MOST:
        raise TrackmarshalError(
            "E476",
            f"{len(things)} {what}, where messages tell {_MOST} apart",
            help="leave rules out that read them",
        )


def _cycle(
    source: Source, given: Supervised, lines: Sequence[tuple[str, str, str, str]], sizes: Mapping[str, int]
) -> Iterator[Item]:
    contract = given.contract
    assert contract.plan is not None
    yield own("came", "u64", "1: a cycle; 0: one was due and did not come, or it is none for what was found")
    yield own("numbered", "u64", "1: `number` is one")
    yield own("stamped", "u64", "1: `t` is a stamp")
    yield own("number", "i64", "one more than in the cycle before")
    yield own("t", "f64", "s, the stamp, on the Supervisor's clock")
    yield own("found_count", "u64", f"faults that the sender has found, to {FOUND}")
    yield own("found_index", "i64", "sample or element of each; -1: none", FOUND)
    yield own("found_name", "u16", "the fault, by its place in `faults` of the description", FOUND)
    yield own("found_signal", "u16", "its signal, by its place in `signals`", FOUND)
    yield own(
        "found_field",
        "u16",
        "its field, by its place in `fields`; beyond them: one that no spec knows",
        FOUND,
    )
    for name in (DRIVING, EMERGENCY):
        yield from _columns(contract.plan, given.plan, name, name, sizes, True)
    for signal in given.inputs:
        c_name = f"in_{given.signals[signal.name]}"
        yield from _columns(
            signal, source.plan.input(signal.name), f"signals.{signal.name}", c_name, sizes, True
        )
    for signal in given.borders:
        group, c_group = f"signals.{signal.name}", f"in_{given.signals[signal.name]}"
        yield own("present", "u64", "1: the signal is there", None, group, c_group)
        if any(field.name for field in signal.lines):
            yield own("closed", "u64", "1: the last point is followed by the first", None, group, c_group)
        for name, field, _, member in lines:
            if name == signal.name:
                yield Item(
                    group, field or "line", "u64", 1, "version of the line that counts; 0: there is none", False, c_group, member, True
                )  # fmt: skip
    for signal in given.events:
        yield Item(
            f"signals.{signal.name}", "event", "i64", 1, "1, 0; anything else: missing", True, f"in_{given.signals[signal.name]}",
            "tm_event", True,
        )  # fmt: skip


def _columns(
    signal: Signal, item: Input, group: str, c_group: str, sizes: Mapping[str, int], asked: bool
) -> Iterator[Item]:
    """A timeline, set or record: whether it is there, how many entries it has, its columns. asked: as a cycle has it."""
    names = {info.name: (c_name, info) for info, c_name in item.fields}
    record = signal.form == RECORD
    capacity = 1 if record else sizes["TM_MAX_SAMPLES" if signal.form == TIMELINE else "TM_MAX_ELEMENTS"]
    _bounded(signal.fields_, f"fields of `{signal.name}`")
    if asked:
        yield own("present", "u64", "1: the signal is there", None, group, c_group)
        if not record:
            yield own("absent", "u64", "bit k: column k of this list is not there", None, group, c_group)
    if not record:
        yield own(
            "count",
            "u64",
            f"entries; of more than {capacity}, the first {capacity} stand here",
            None,
            group,
            c_group,
        )
    if signal.named and asked:
        yield own("named", "u64", "1: each entry has an id, and these stand here", None, group, c_group)
        yield own(
            "id", "u64", "what each is known by in other cycles; no two alike", capacity, group, c_group
        )
    for kind, fields in (("f64", signal.numbers), ("i8", signal.flags)):
        for field in fields:
            c_name, info = names[field.name]
            about = "1, 0, -1 for missing" if kind == "i8" else f"{unit(info)}; NaN: missing"
            yield Item(
                group,
                field.name,
                kind,
                capacity,
                about,
                False,
                c_group,
                c_name,
                record,
                0,
                field.default,
                field.members,
                show(parse_unit(info.unit)[2]) if kind == "f64" and not field.members else "",
            )


def _line(sizes: Mapping[str, int]) -> Iterator[Item]:
    most = sizes["TM_MAX_BORDER"]
    yield own("slot", "u64", "which line: its place in `lines` of the description")
    yield own(
        "line_version", "u64", "counts the lines of a session, from 1 on; a cycle names the one that counts"
    )
    yield own("count", "u64", f"points; of more than {most}, the first {most} stand here")
    yield own("points", "f64", "m, x and y by turns", 2 * most)


def _decision(source: Source, given: Supervised, sizes: Mapping[str, int]) -> Iterator[Item]:
    contract, rules = given.contract, len(source.rules)
    assert contract.plan is not None
    yield own("about_session", "u64", "of the cycle that is decided about")
    yield own(
        "about_sequence",
        "u64",
        "of the cycle's message; 0: none came in time, and this is what follows from that",
    )
    yield own("simulated", "u64", "1: the Supervisor's clock is that of its messages")
    yield own(
        "wanted", "u64", "bit k: line k was not known in the version that the cycle named; send it again"
    )
    yield own("number", "i64", "of the cycle; 0 where it has none")
    yield own("t", "f64", "s, the cycle's stamp; NaN where it has none")
    for name, kind in SAID:
        yield own(name, "f64" if kind == "d" else "i64", f"`tm_decision.{name}`")
    for name in (DRIVING, EMERGENCY):
        yield own(f"{name}_margin", "f64", "by rule, in SI", max(1, rules))
    yield own("reason_index", "i64", "sample or element of each reason; -1: none", MOST_REASONS)
    yield own(
        "reason_name", "u16", "fault, or why nothing stored is driven, by its place in `faults`", MOST_REASONS
    )
    yield own("reason_signal", "u16", "by its place in `signals`", MOST_REASONS)
    yield own("reason_field", "u16", "by its place in `fields`", MOST_REASONS)
    yield own("reason_rule", "u16", "by its place in `rules`", MOST_REASONS)
    yield own("reason_kind", "u8", "0 a fault, 1 a rule, 2 why nothing stored is driven", MOST_REASONS)
    yield own("reason_candidate", "u8", "of a rule: 0 driving, 1 emergency", MOST_REASONS)
    for name in (DRIVING, EMERGENCY):
        yield own(f"{name}_verdict", "u8", "by rule: its place in `verdicts`", max(1, rules))
    for group, about in (
        (DRIVING, "this cycle's, where it is driven"),
        ("fallback", "the stored emergency trajectory"),
    ):
        most = sizes["TM_MAX_SAMPLES"]
        yield own("due", "f64", f"s, when each sample is due; {about}", most, group, group)
        yield from _columns(contract.plan, given.plan, group, group, sizes, False)


def _beat() -> Iterator[Item]:
    yield own("simulated", "u64", "1: the Supervisor's clock is that of its messages")
    yield own("decided", "u64", "sequence of the last decision; 0: none yet")
    yield own("state", "i64", "after it, by its place in `states`")
    yield own("client", "u64", "session of the newest client; 0: none yet")
    yield own("heard", "u64", "sequence of its newest cycle or tick; 0: none yet")
    yield own("taken", "u64", "messages that were taken")
    yield own("refused", "u64", "messages that were not, by their place in `causes`", len(CAUSES))
