"""Signals, and fields of cars, that a declaration gives a generated recording; they have to keep to the contract of the specs that declare them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import FieldType, SignalType
from trackmarshal.runtime.contract import IS_DRIVEN
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.door.cases import CasesReader
from trackmarshal.scenarios.fields import ELSEWHERE, OWN, own_names
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.generate.given import Given, GivenSignal
from trackmarshal.scenarios.generate.words import Specs, Words, known_settings, unit_of, values
from trackmarshal.scenarios.recording import Recording


@dataclass(frozen=True, slots=True)
class Further:
    """What is given besides the generator's own: signals, fields of the car under test, of other cars and of obstacles by their ids."""

    signals: tuple[GivenSignal, ...] = ()
    ego: tuple[Given, ...] = ()
    objects: tuple[tuple[str, tuple[Given, ...]], ...] = ()
    obstacles: tuple[tuple[str, tuple[Given, ...]], ...] = ()

    @property
    def first(self) -> Item | None:
        """Where the first of it stands; None where there is nothing."""
        return next((item for item, _, _ in _places(self)), None)


#: Columns of an archive, one entry a cycle.
Table = Mapping[str, Sequence[Any]]


def with_further(
    recording: Recording, further: Further, specs: Specs, columns: Table = MappingProxyType({})
) -> Recording:
    """The recording with all that is given; columns are those of the archive that it is from. Raises D151, and D250 to D254."""
    # What is given as it is needs nothing else, and so may be asked for by the fields of cars, too.
    known, asking = ([s for s in further.signals if s.asks is asks] for asks in (False, True))
    for signal in known:
        recording = _signal(recording, specs, signal, columns)
    for given in further.ego:
        field = _field(specs, "ego", given)
        found = _all(specs, recording, given, field, columns=columns)
        cycles = [replace(c, ego={**c.ego, given.name: x}) for c, x in zip(recording.cycles, found)]
        recording = replace(recording, cycles=tuple(cycles))
    for name, fields in further.objects:
        for given in fields:
            recording = _of_object(recording, specs, name, given)
    for name, fields in further.obstacles:
        for given in fields:
            recording = _of_obstacle(recording, specs, name, given)
    for signal in asking:
        recording = _signal(recording, specs, signal, columns)
    # They are written as they are declared, whichever came first: the file of a declaration stays the one that it was.
    order = {signal.name: number for number, signal in enumerate(further.signals)}
    written = [replace(c, more=_in_order(c.more, order)) for c in recording.cycles]
    recording = replace(recording, cycles=tuple(written), always=_in_order(recording.always, order))
    _check(recording, further, specs)
    return recording


def _of_object(recording: Recording, specs: Specs, name: str, given: Given) -> Recording:
    found = _all(specs, recording, given, _field(specs, "objects", given), name)
    cycles = []
    for cycle, value in zip(recording.cycles, found):
        objects = [{**o, given.name: value} if o["id"] == name else o for o in cycle.objects]
        cycles.append(replace(cycle, objects=objects))
    return replace(recording, cycles=tuple(cycles))


def _in_order(signals: Mapping[str, Any], order: Mapping[str, int]) -> dict[str, Any]:
    return {name: signals[name] for name in sorted(signals, key=lambda name: order.get(name, -1))}


def _of_obstacle(recording: Recording, specs: Specs, name: str, given: Given) -> Recording:
    _field(specs, "obstacles", given)
    if not given.constant:
        raise given.item.wrong("an obstacle is the same in all cycles", "give one value")
    obstacles = [{**o, given.name: given.values[0]} if o["id"] == name else o for o in recording.obstacles]
    return replace(recording, obstacles=obstacles)


def _signal(recording: Recording, specs: Specs, given: GivenSignal, columns: Table) -> Recording:
    """The recording with one more signal, in the first line where it is the same in all cycles."""
    name = given.name
    if name == EMERGENCY or (name == IS_DRIVEN and name in specs.spec.events):
        message = f"`{name}` is told by the Supervisor, whatever is given"
        raise given.item.wrong(message, "give an event of your own another name", "D250")
    if name in ELSEWHERE:
        raise given.item.wrong(
            f"`{name}` has its own place", "fields of cars stand under `fields` of each car", "D250"
        )
    declared: SignalType | None = specs.spec.signals.get(name)
    if declared is None and name not in specs.spec.events:
        known = sorted({*specs.spec.signals, *specs.spec.events} - ELSEWHERE.keys())
        help_ = close_matches(name, known) or "a spec of `specs` has to declare it: `signal`, or `event`"
        raise given.item.wrong(f"the signal `{name}` is declared nowhere", help_, "D250")
    if given.whole is not None:
        if (given.whole.expression or given.whole.members) and declared is not None:
            help_ = "an expression is of an event, or of a field: `fields: {NAME: {is: ..}}`"
            raise given.item.wrong(f"an expression has no value for the whole signal `{name}`", help_, "D250")
        found: Sequence[Any] = _all(specs, recording, given.whole, None, columns=columns)
        constant = given.whole.constant
    elif declared is None or declared.kind != "state":
        message = f"`{name}` has no fields that are given one by one"
        raise given.item.wrong(message, "that is for a `state`; give the whole: `value`, or `at`", "D250")
    else:
        by_name = {
            each.name: _all(specs, recording, each, _field(specs, name, each), columns=columns)
            for each in given.fields
        }
        # Of no field, a record of defaults in each cycle.
        found = [{each: values[k] for each, values in by_name.items()} for k in range(len(recording.cycles))]
        constant = False
    if constant:
        return replace(recording, always={**recording.always, name: found[0]})
    cycles = [
        replace(c, more={**c.more, name: value}) for c, value in zip(recording.cycles, found, strict=True)
    ]
    return replace(recording, cycles=tuple(cycles))


def _field(specs: Specs, signal: str, given: Given) -> FieldType:
    """What the specs declare of a field; raises D250."""
    declared = specs.spec.signals.get(signal)
    field = None if declared is None else declared.field(given.name)
    if signal in OWN and given.name in OWN[signal]:
        raise given.item.wrong(f"`{given.name}` comes from the car's motion", "give other fields", "D250")
    if field is None:
        known = [] if declared is None else [each.name for each in declared.fields_]
        message = f"`{given.name}` is declared nowhere as a field of `{signal}`"
        raise given.item.wrong(
            message, close_matches(given.name, known) or "a spec of `specs` has to", "D250"
        )
    return field


def _all(
    specs: Specs, recording: Recording, given: Given, field: FieldType | None, alone: str | None = None, columns: Table = MappingProxyType({}),
) -> list[Any]:  # fmt: skip
    """The value in every cycle; raises D151, D250, D252 and D253."""
    if given.column:
        if given.column not in columns:
            message = f"there is no column `{given.column}` that is not the format's own"
            help_ = (
                close_matches(given.column, columns) or "columns are those of the header line of an archive"
            )
            raise given.item.wrong(message, help_)
        return list(columns[given.column])
    if given.members:
        return _members(specs, recording, given, field, alone)
    if not given.expression:
        return given.over([cycle.t for cycle in recording.cycles])
    if field is not None and (field.enumeration is not None or field.kind == "polyline"):
        what = "a member of an enumeration" if field.enumeration is not None else "a line"
        raise given.item.wrong(
            f"`{given.name}` is {what}, which no expression gives",
            "give it over time: `at`; members also by formulas: `is: {yellow: .., green: otherwise}`",
            "D250",
        )
    unit = None if field is None else unit_of(field)
    words = Words(given.expression, given.item, unit, alone is not None)
    return [row[0] for row in values(specs, [words], recording, DRIVING, alone)]


def _members(
    specs: Specs, recording: Recording, given: Given, field: FieldType | None, alone: str | None
) -> list[str]:
    """In every cycle, the first member whose formula holds."""
    if field is None or field.enumeration is None:
        raise given.item.wrong(f"`{given.name}` has no members", "an expression is a text", "D250")
    for member in given.members:
        if member.name not in field.enumeration.members:
            message = f"`{member.name}` is no member of `{field.enumeration.name}`"
            help_ = close_matches(member.name, field.enumeration.members) or "its members: " + ", ".join(
                field.enumeration.members
            )
            raise member.item.wrong(message, help_, "D250")
    *conditional, other = given.members
    words = [Words(member.formula, member.item, None, alone is not None) for member in conditional]
    rows = values(specs, words, recording, DRIVING, alone)
    return [next((m.name for m, holds in zip(conditional, row) if holds), other.name) for row in rows]


def _places(further: Further) -> Iterator[tuple[Item, str, str]]:
    """Where each of the given things stands, its signal, and its field; "" for the whole."""
    for given in further.ego:
        yield given.item, "ego", given.name
    for where, cars in (("objects", further.objects), ("obstacles", further.obstacles)):
        for _, fields in cars:
            for given in fields:
                yield given.item, where, given.name
    for signal in further.signals:
        yield signal.item, signal.name, ""


def _check(recording: Recording, further: Further, specs: Specs) -> None:
    """Hold all that is given against its contract; raises D254."""
    places = list(_places(further))
    reads: set[tuple[str, str]] = set()
    for _, name, field in places:
        declared = specs.spec.signals.get(name)
        every = [""] if declared is None else [each.name for each in declared.fields_] or [""]
        reads |= {(name, each) for each in ([field] if field else every)}
    reader = CasesReader(specs.spec, reads, lambda: own_names(recording))
    settings = known_settings(recording, specs.spec)
    for cycle in recording.cycles:
        signals = {
            name: value for name, value in recording.signals(cycle, DRIVING).items() if name in dict(reads)
        }
        try:
            faults = reader.read({"t": cycle.t, "signals": signals, **settings}).faults
            problem = str(faults[0]) if faults else ""
            names = (faults[0].signal, faults[0].field) if faults else ("", "")
        except TrackmarshalError as error:
            problem, names = error.message, (error.message.split(".")[0].split("[")[0].split(":")[0], "")
        if problem:
            fitting = [item for item, name, field in places if name == names[0] and field in ("", names[1])]
            item = (fitting or [item for item, name, _ in places if name == names[0]] or [places[0][0]])[0]
            raise item.wrong(
                f"at t = {cycle.t:g} s: {problem}", "the spec that declares it says what it may be", "D254"
            )
