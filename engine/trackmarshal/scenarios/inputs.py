"""Inputs that a recording's cycles do not have: one number for all of them, given with a reason, or the default of the spec."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.scenarios.recording import COLUMNS, Cycle, Recording

#: Signals whose fields may be given for all cycles; `plan` stands for both candidates.
SIGNALS = ("plan", "ego", "objects", "obstacles")
#: What these have in every recording.
_POSE = ("x", "y", "heading")
NEEDED = {
    "plan": COLUMNS,
    "ego": (*_POSE, "v"),
    "objects": ("id", *_POSE, "v", "length", "width"),
    "obstacles": ("id", *_POSE, "length", "width"),
}


def not_to_be_given(name: str) -> str:
    """Why an input cannot be given for all cycles, in words; empty where it can."""
    signal, _, field = name.partition(".")
    if signal not in SIGNALS or not field.isidentifier():
        return f"{name!r:.40} is no field of {', '.join(SIGNALS)}, such as `plan.grip`"
    return f"`{name}` is part of every cycle" if field in NEEDED[signal] else ""


def recorded(recording: Recording) -> frozenset[str]:
    """The fields, `plan.grip`, that every record of a signal has, of those signals that there are any records of."""
    found: set[str] = set()
    for signal in SIGNALS:
        fields = [set(each) for each in records_of(recording, signal)]
        found |= {f"{signal}.{field}" for field in (set.intersection(*fields) if fields else ())}
    return frozenset(found)


def filled(recording: Recording) -> Recording:
    """The recording with what is given (`Recording.given`) in every cycle, candidate and object that does not have it."""
    if not recording.given:
        return recording
    of: dict[str, dict[str, float]] = {signal: {} for signal in SIGNALS}
    for name, value in recording.given.items():
        signal, _, field = name.partition(".")
        of[signal][field] = value
    cycles = tuple(_filled(cycle, of) for cycle in recording.cycles)
    obstacles = [_with(obstacle, of["obstacles"]) for obstacle in recording.obstacles]
    return replace(recording, cycles=cycles, obstacles=obstacles)


def _filled(cycle: Cycle, of: Mapping[str, Mapping[str, float]]) -> Cycle:
    candidates = {
        name: _with(plan, {field: [value] * len(plan["t"]) for field, value in of["plan"].items()})
        for name, plan in cycle.candidates.items()
    }
    objects = [_with(each, of["objects"]) for each in cycle.objects]
    standing = cycle.obstacles
    obstacles = None if standing is None else [_with(each, of["obstacles"]) for each in standing]
    return replace(
        cycle, ego=_with(cycle.ego, of["ego"]), objects=objects, candidates=candidates, obstacles=obstacles
    )


def _with(record: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """A record with what it does not have itself."""
    return {**record, **{name: value for name, value in given.items() if name not in record}}


def defaulted(recording: Recording, spec: Spec, rules: Iterable[RuleInfo]) -> dict[str, tuple[str, ...]]:
    """Fields with a default that some cycle lacks, `plan.grip`, each with the names of the rules that read it: there, the default is what they judge."""
    return {
        f"{signal}.{field}": readers
        for (signal, field), readers in with_default(spec, rules).items()
        if any(field not in each for each in records_of(recording, signal))
    }


def with_default(spec: Spec, rules: Iterable[RuleInfo]) -> dict[tuple[str, str], tuple[str, ...]]:
    """Fields of `SIGNALS` that need not be sent, as they have a default, each with the names of the rules that read it."""
    readers: dict[tuple[str, str], dict[str, None]] = {}
    for rule in rules:
        for read in rule.reads:
            readers.setdefault(read, {})[rule.name] = None
    return {
        (signal, field.name): tuple(readers[signal, field.name])
        for signal in SIGNALS
        if signal in spec.signals
        for field in spec.signals[signal].fields_
        if field.default is not None and (signal, field.name) in readers
    }


def records_of(recording: Recording, signal: str) -> Iterator[Mapping[str, Any]]:
    """Every record, or set of columns, that a recording has of one of `SIGNALS`."""
    if signal == "obstacles":
        yield from recording.obstacles
    for cycle in recording.cycles:
        if signal == "plan":
            yield from cycle.candidates.values()
        elif signal == "ego":
            yield cycle.ego
        elif signal == "objects":
            yield from cycle.objects
        elif signal == "obstacles":
            yield from cycle.obstacles or ()
        else:
            raise ValueError(f"no records of {signal!r} in a recording")
