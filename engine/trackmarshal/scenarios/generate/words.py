"""Expressions of a declaration in the spec language: compiled beside the specs that the declaration names, and evaluated by the reference."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import FieldType, Spec
from trackmarshal.runtime.contract import FOLLOWED, IS_DRIVEN
from trackmarshal.runtime.cycle import DRIVING
from trackmarshal.scenarios.fields import own_names
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.overrides import spoken
from trackmarshal.scenarios.recording import Recording, only
from trackmarshal.semantics.compile import Compiled, compile_paths, compile_text
from trackmarshal.semantics.modules import root_of
from trackmarshal.units import from_si

_MODULE = "words_of_the_scenario"
_DEFINED = "what rules read is never undefined in a scenario"
_NOT_YET = "give it, by a value or `at`; what expressions give, only those see that stand below it, and no field of a car sees a signal of an expression"


@dataclass(frozen=True, slots=True)
class Words:
    """An expression: a number in a declared unit, or a formula where `unit` is None; of `o`, an object, where `each`."""

    text: str
    item: Item
    unit: str | None = None
    each: bool = False


class Specs:
    """The specs that a declaration names; raises D252 where they have errors, or lie in several libraries."""

    def __init__(self, named: Sequence[tuple[Path, Item]]) -> None:
        self._named = named
        compiled = compile_paths([path for path, _ in named])
        _raise(compiled, named[0][1])
        self.spec: Spec = compiled.spec
        # As if the expressions stood there: what a spec uses can be said without naming it again.
        used = (use.name for name in compiled.asked for use in compiled.library.modules[name].uses)
        self.modules = tuple(dict.fromkeys([*compiled.asked, *used]))
        roots = {root_of(compiled.library.modules[name]) for name in compiled.asked}
        if len(roots) > 1:
            message = "the specs are of several libraries of modules"
            raise named[0][1].wrong(message, "name specs whose module names start in one folder", "D252")
        (self._root,) = roots

    def evaluator(self, words: Sequence[Words], also: frozenset[str]) -> Evaluator:
        """Each expression as a rule, `w0`, `w1`, ...; raises D252 for one that has no meaning.

        also: names that the data may have besides those of the specs.
        """
        lines = [f"module {_MODULE}", *(f"use {name}" for name in self.modules)]
        at: dict[int, Item] = {}
        for number, each in enumerate(words):
            lines.append(f'rule w{number} "an expression of the scenario"')
            lines += ["  for all o in objects"] if each.each else []
            text = " ".join(each.text.split())
            unit = "" if each.unit in (None, "1") else f" {each.unit}"
            lines.append(f"  require ({text})" + ("" if each.unit is None else f" >= 0{unit}"))
            at |= dict.fromkeys(range(len(lines) - 3, len(lines) + 1), each.item)
        compiled = compile_text("\n".join(lines) + "\n", folder=self._root)
        for found in compiled.errors:
            item = at.get(found.span.line, self._named[0][1])
            said = f"the expression has no meaning: {found.message} [{found.code}]"
            raise item.wrong(said, found.help or "see docs/language.md", "D252")
        if compiled.failures:
            raise compiled.failures[0]
        names = [f"w{number}" for number in range(len(words))]
        return Evaluator(compiled.spec, names, "reference", lambda: also)


def _raise(compiled: Compiled, item: Item) -> None:
    try:
        compiled.raise_errors()
    except TrackmarshalError as error:
        where = f"{error.file}:{error.line}: " if error.line is not None else ""
        message = f"the specs have errors: {where}{error.message} [{error.code}]"
        raise item.wrong(message, "mend them first: `trackmarshal check`", "D252") from error


def values(
    specs: Specs, words: Sequence[Words], recording: Recording, candidate: str, alone: str | None = None
) -> Iterator[list[float | bool]]:
    """Of every cycle, the value of each expression, with `candidate` as `plan`; numbers are in the declared unit.

    `alone` names the one object that there is: what is asked of `o` is asked of it. An expression may look back over the run. Raises D253
    where one has no value.
    """
    evaluator = specs.evaluator(words, own_names(recording) | _names(recording))
    settings = known_settings(recording, evaluator.spec)
    run = evaluator.over_run()
    for cycle in recording.cycles:
        signals = recording.signals(cycle if alone is None else only(cycle, alone), candidate)
        if FOLLOWED in evaluator.spec.signals:
            signals[FOLLOWED] = cycle.candidates[DRIVING]
        if IS_DRIVEN in evaluator.spec.events:
            signals[IS_DRIVEN] = True
        frame = evaluator.read({"t": cycle.t, "signals": signals, **settings})
        result = run.step(frame)
        found: list[float | bool] = []
        for number, each in enumerate(words):
            outcome = result.rules[f"w{number}"]
            if outcome.verdict not in ("satisfied", "violated"):
                why = "it looks ahead" if outcome.verdict == "open" else outcome.reason or outcome.verdict
                message = f"the expression has no value at t = {cycle.t:g} s: {why}"
                help_ = _NOT_YET if why.startswith("D211 ") else _DEFINED
                raise each.item.wrong(message, help_, "D253")
            if each.unit is None:
                found.append(outcome.verdict == "satisfied")
            elif math.isfinite(outcome.margin):
                found.append(round(from_si(outcome.margin, each.unit), 9) + 0.0)
            else:
                message = f"the expression is not finite at t = {cycle.t:g} s"
                raise each.item.wrong(message, "give a number", "D253")
        yield found


def _names(recording: Recording) -> frozenset[str]:
    """Signals that the recording has so far: whatever an expression does not read is not asked for."""
    names = set(recording.always)
    for cycle in recording.cycles:
        names |= cycle.more.keys() | {f"objects.{name}" for each in cycle.objects for name in each}
        names |= {f"ego.{name}" for name in cycle.ego}
    return frozenset(names)


def known_settings(recording: Recording, spec: Spec) -> Mapping[str, Any]:
    """Of the recording's parameters and tables, those that a spec declares."""
    params, tables = spoken(spec.params), spoken(spec.tables)
    return {
        "params": {name: value for name, value in recording.params.items() if name in params},
        "tables": {name: rows for name, rows in recording.tables.items() if name in tables},
    }


def unit_of(field: FieldType) -> str | None:
    """In what an expression of a field is: None for a Boolean."""
    return None if field.kind == "bool" else field.unit
