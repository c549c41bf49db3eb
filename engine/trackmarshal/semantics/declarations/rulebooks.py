"""Rulebooks: rules that are ranked, without a circle, and what one keeps of the one that it builds on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, assert_never

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir.ranking import above
from trackmarshal.ir.spec import RulebookInfo
from trackmarshal.semantics.errors.expressions import WrongKind
from trackmarshal.semantics.errors.names import UnknownReference
from trackmarshal.semantics.errors.rules import (
    RulebookBases,
    RulebookContradicts,
    RulebookCycle,
    RulebookNotRefined,
)
from trackmarshal.semantics.scope import Scope, spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.typed import Symbol


class _Step(NamedTuple):
    """One relation of a rulebook, and where it is written."""

    upper: str
    relation: str
    lower: str
    span: Span
    #: The rulebook that says so.
    book: str


class _Book(NamedTuple):
    """A rulebook with what it builds on. sound: nothing is wrong with it."""

    rules: tuple[str, ...]
    steps: tuple[_Step, ...]
    sound: bool


class Rulebooks:
    """The rulebooks of modules that are checked together; what is wrong with them is added to `found`."""

    def __init__(
        self, scopes: Mapping[str, Scope], rules: set[str], silent: set[str], found: list[Diagnostic]
    ) -> None:
        """`silent` are those of the rules that are assumptions without a condition."""
        self._scopes, self._rules, self._silent, self._found = scopes, rules, silent, found
        self._known: dict[str, _Book] = {}
        #: Those that are being looked at, by place and name: each builds on the next.
        self._open: dict[str, str] = {}

    def check(self, item: ast.Rulebook, module: str) -> RulebookInfo:
        """The order of a rulebook, what it builds on included; every name is a rule, and no rule outranks itself."""
        book = self._book(item, module)
        relations = tuple((step.upper, step.relation, step.lower) for step in book.steps)
        return RulebookInfo(item.name, item.title, book.rules, relations, item.span)

    def _book(self, item: ast.Rulebook, module: str) -> _Book:
        key = _key(item)
        if key not in self._known:
            self._open[key] = item.name
            before = len(self._found)
            base = self._base(item, module)
            made = self._made(item, base)
            sound = len(self._found) == before and (base is None or base.sound)
            self._known[key] = _Book(made.rules, made.steps, sound)
            del self._open[key]
        return self._known[key]

    def _base(self, item: ast.Rulebook, module: str) -> _Book | None:
        """The rulebook that one builds on; None where there is none, or none that can be built on."""
        if item.base is None:
            return None
        name, at = item.base.name.name, item.base.name.span
        looked_up = self._scopes[module].look_up(name, at, "rulebook", set())
        match looked_up:
            case None:
                return _UNKNOWN
            case Symbol(item=ast.Rulebook() as other):
                if _key(other) in self._open:
                    names = list(self._open.values())
                    circle = [*names[list(self._open).index(_key(other)) :], name]
                    self._found.append(RulebookBases(at, name, " > ".join(circle)))
                    return _UNKNOWN
                return self._book(other, looked_up.module)
            case Symbol():
                hint = "a rulebook refines or extends another rulebook"
                self._found.append(
                    WrongKind(at, "a rulebook", f"the name of a {spoken(looked_up.item)}", hint)
                )
                return _UNKNOWN
            case Diagnostic():
                self._found.append(looked_up)
                return _UNKNOWN
            case _:
                assert_never(looked_up)

    def _made(self, item: ast.Rulebook, base: _Book | None) -> _Book:
        places: dict[str, Span] = {}
        for chain in item.chains:
            for name in chain.names:
                places.setdefault(name.name, name.span)
                if name.name not in self._rules:
                    hint = (
                        close_matches(name.name, self._rules)
                        or "a rulebook orders the rules that are checked together with it"
                    )
                    self._found.append(UnknownReference(name.span, f"no rule `{name.name}`", hint))
                if name.name in self._silent:
                    problem = f"of the assumption `{name.name}` nothing is ever said: it has no `monitor`"
                    self._found.append(
                        UnknownReference(name.span, problem, "add a `monitor`, or leave it out here")
                    )
        own = tuple(
            _Step(left.name, relation, right.name, left.span.to(right.span), item.name)
            for chain in item.chains
            for left, relation, right in zip(chain.names, chain.relations, chain.names[1:])
        )
        inherited = () if base is None else base.steps
        known = () if base is None else base.rules
        rules = (*known, *(name for name in places if name not in known))
        circle = _circle(own)
        if circle:
            self._found.append(RulebookCycle(circle[-1].span, circle[0].upper, _told(circle)))
        elif item.base is not None and base is not None and base.sound:
            circle = _circle((*own, *inherited))
            if circle:
                self._found.append(_contradicts(circle, item))
            elif item.base.how == "refines":
                self._keeps(item.base, known, places, (*inherited, *own))
        return _Book(rules, (*inherited, *own), False)

    def _keeps(
        self, base: ast.Base, known: Sequence[str], places: Mapping[str, Span], steps: Sequence[_Step]
    ) -> None:  # fmt: skip
        """A refinement keeps every preference of its base: rules that are new rank below all of that."""
        ranks = above({*known, *places}, [(step.upper, step.relation, step.lower) for step in steps])
        for name, at in places.items():
            missing = next((rule for rule in known if rule not in ranks[name]), None)
            if name not in known and missing is not None:
                self._found.append(RulebookNotRefined(at, base.span, name, base.name.name, missing))
                return


def _key(item: ast.Rulebook) -> str:
    """Where a rulebook stands: there is one at a place, whatever others are called."""
    return str(item.span)


#: In place of a rulebook with which something is wrong that is told already.
_UNKNOWN = _Book((), (), False)


def _circle(steps: Sequence[_Step]) -> tuple[_Step, ...]:
    """A way from a rule back to itself with at least one strict step; empty where there is none."""
    onward: dict[str, list[_Step]] = {}
    for step in steps:
        onward.setdefault(step.upper, []).append(step)
        if step.relation != ">":
            back = step._replace(upper=step.lower, lower=step.upper)
            onward.setdefault(step.lower, []).append(back)
    for start in onward:
        seen: set[tuple[str, bool]] = set()
        waiting: list[tuple[str, bool, tuple[_Step, ...]]] = [(start, False, ())]
        while waiting:
            name, strict, path = waiting.pop()
            for step in onward.get(name, []):
                now = strict or step.relation == ">"
                if step.lower == start and now:
                    return (*path, step)
                if (step.lower, now) not in seen:
                    seen.add((step.lower, now))
                    waiting.append((step.lower, now, (*path, step)))
    return ()


def _told(circle: Sequence[_Step]) -> str:
    """A circle with the relations as they are written."""
    return circle[0].upper + "".join(f" {step.relation} {step.lower}" for step in circle)


def _contradicts(circle: tuple[_Step, ...], item: ast.Rulebook) -> RulebookContradicts:
    """A circle through a rulebook and what it builds on: told from a strict step of its own on, where there is one."""
    inside, file = range(item.span.start, item.span.end), item.span.file.path
    own = [step for step in circle if step.span.start in inside and step.span.file.path == file]
    place = circle.index(next((step for step in own if step.relation == ">"), own[0]))
    turned = (*circle[place:], *circle[:place])
    theirs = [step for step in circle if step not in own]
    other = next((step for step in theirs if step.relation == ">"), theirs[0])
    return RulebookContradicts(turned[0].span, other.span, turned[0].upper, _told(turned), other.book)
