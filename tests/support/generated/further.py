"""What the other writers never write: enumerations, tables of two arguments and of periods, records of parameters, chains, counts of samples,
rules at the last sample, and what was said before, said again of other variables."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from support.generated.choices import Choices
from support.generated.formulas import FormulaWriter, Scope
from support.generated.inputs import Inputs
from support.generated.modules import ModuleWriter
from support.generated.subject import Subject
from support.generated.vocabulary import LENGTH, NUMBER, SPEED, Dimension, FieldInfo, SignalInfo

#: Stands in place of a dimension for members, so that no number is one.
SHADE: Dimension = (99, 99)
SHADES = ("green", "yellow", "red")
_DECLARED = (
    "enum shade { green, yellow, red }",
    "shape limits = { far: m, fast: m/s, many: 1 }",
    "param dry : limits = { far: 120 cm in [-1000, 1000], fast: 36 km/h, many: 50 % }",
    "param wet : limits = { far: dry.far * 2, fast: dry.fast / 2 in [0, 100], many: 3 }",
    "signal race : state { flag: shade, before: shade default red, on: bool default true, n: 1 default 2 }",
    "signal marks : set of object { x: m, n: 1 default 1, mark: shade default yellow, on: bool default false }",
    "table sheet(x: m, y: 1) -> m/s = linear clamp, step | y: 0, 100 %, 3 | 0: 1, 36 km/h, 0 | 500 cm: 2, -1, 10 |",
    "table turns(x: 1, y: m/s) -> 1 = step wrap 4, linear wrap 10 m/s | y: 0 | 0: 1 | 2: 200 % |",
    "table lap(x: m) -> m = linear wrap 7 m | 1: 2 | 300 cm: 0.5 | 6: -1 |",
    "table one(x: m/s) -> 1 = linear clamp | 1: 2 |",
    "define reach(a: m, b: s = 0.5 s, c: m/s = dry.fast) -> m = a + b * c",
    "define room(l: limits, k: 1) -> m = l.far * k - l.fast * 1 s * l.many",
)
_SIGNALS = {
    "race": SignalInfo("state", {"flag": FieldInfo(SHADE, "shade"), "before": FieldInfo(SHADE, "shade", default=2.0), "on": FieldInfo(None, "bool"), "n": FieldInfo(NUMBER, "1", default=2.0)}),
    "marks": SignalInfo("set of object", {"x": FieldInfo(LENGTH, "m"), "n": FieldInfo(NUMBER, "1", default=1.0), "mark": FieldInfo(SHADE, "shade", default=1.0), "on": FieldInfo(None, "bool")}),
}  # fmt: skip
#: Variables that quantifiers and `along` bind; names that stand for something in one rule or definition alone.
_VARIABLES, _LOCAL = re.compile(r"\b[qs]\d+\b"), re.compile(r"\b(a|let_)\d+\b")


class FurtherWriter(FormulaWriter):
    """Writes what `FormulaWriter` does, and the rest of the language beside it."""

    def __init__(self, choices: Choices, module: ModuleWriter, inexact: str) -> None:
        super().__init__(choices, module.world, inexact)
        self.domains = (*self.domains, "marks")
        #: What was said, by its kind, with the fields of the variables that are free in it.
        self._said: dict[object, list[tuple[str, dict[str, frozenset[str]]]]] = {}

    def number(self, dimension: Dimension, depth: int, scope: Scope, soft: bool = True) -> str:
        return self._again(
            (dimension, scope.timeline), scope, lambda: super(FurtherWriter, self).number(dimension, depth, scope, soft)
        )  # fmt: skip

    def formula(self, depth: int, scope: Scope, soft: bool = True) -> str:
        return self._again(
            scope.timeline, scope, lambda: super(FurtherWriter, self).formula(depth, scope, soft)
        )

    def _again(self, kind: object, scope: Scope, write: Callable[[], str]) -> str:
        """What was said before, of variables here that have the same fields; else something new."""
        fields = {name: frozenset(own) for name, own in scope.records}
        if kind in self._said and self.choices.chance(20):
            text, free = self.choices.pick(self._said[kind])
            fitting = {name: [one for one in fields if fields[one] == own] for name, own in free.items()}
            if all(fitting.values()):
                new = {name: self.choices.pick(ones) for name, ones in fitting.items()}
                return _VARIABLES.sub(lambda m: new.get(m[0]) or new.setdefault(m[0], self.fresh("q")), text)
        text = write()
        if not _LOCAL.search(text):
            free = {name: fields[name] for name in _VARIABLES.findall(text) if name in fields}
            self._said.setdefault(kind, []).append((text, free))
        return text

    def on_lines(self, dimension: Dimension, depth: int, scope: Scope) -> list[Callable[[], str]]:
        """Cases, tables, records of parameters, definitions with defaults; beside numbers read off lines."""

        def one(of: Dimension) -> str:
            return self.number(of, depth - 1, scope, self._any)

        ways = [*super().on_lines(dimension, depth, scope), lambda: self._case(scope, lambda: one(dimension))]
        if dimension == LENGTH:
            ways += [
                lambda: f"lap({one(LENGTH)})",
                lambda: f"reach({one(LENGTH)}, c: {one(SPEED)})",
                lambda: f"room({self.choices.pick(('dry', 'wet'))}, {one(NUMBER)})",
            ]
        if dimension == SPEED:
            ways += [lambda: f"sheet({one(LENGTH)}, {one(NUMBER)})", lambda: "wet.fast"]
        if dimension == NUMBER:
            ways += [lambda: f"turns({one(NUMBER)}, {one(SPEED)})", lambda: f"one({one(SPEED)})"]
        return ways

    def in_places(self, depth: int, scope: Scope) -> list[Callable[[], str]]:
        """Members, cases, chains, a sample's Booleans; beside geometric predicates."""

        def member() -> str:
            return self.choices.pick(self._members(scope))

        return [
            *super().in_places(depth, scope),
            lambda: f"({member()} is {self.choices.pick(SHADES)})",
            lambda: f"({member()} is {member()})",
            lambda: self._case(scope, lambda: self.formula(depth - 1, scope, self._any)),
            lambda: self._chain(depth, scope),
            lambda: self.choices.pick(("plan.first.ok", "plan.last.ok", "trace.last.hot")),
        ]

    def _members(self, scope: Scope) -> list[str]:
        bound = [f"{name}.{field}" for name, own in scope.records for field, d in own.items() if d == SHADE]
        return [*bound, "race.flag", "race.before"]

    def _case(self, scope: Scope, one: Callable[[], str]) -> str:
        branches = self.choices.pick((SHADES, ("green, red", "yellow"), ("yellow", "else")))
        told = ", ".join(f"{branch}: {one()}" for branch in branches)
        return f"(case {self.choices.pick(self._members(scope))} {{ {told} }})"

    def _chain(self, depth: int, scope: Scope) -> str:
        dimension = self.choices.pick((LENGTH, SPEED, NUMBER))
        first, *rest = (self.number(dimension, depth - 1, scope, False) for _ in range(3))
        ways = self.choices.pick((("<", "<="), (">", ">=")))
        return f"({first}{''.join(f' {self.choices.pick(ways)} {one}' for one in rest)})"

    def _temporal(self, depth: int, scope: Scope, soft: bool) -> str:
        if not self.choices.chance(20):
            return super()._temporal(depth, scope, soft)
        counted = self.formula(depth - 1, scope, soft)
        last = f", last: {self.choices.pick(('0.5 s', '250 ms', '0 s', '1 min'))}"
        rest = self.choices.pick(("", last, f", reset: {self.formula(depth - 1, scope, soft)}"))
        sides = [f"count({counted}{rest})", self.choices.pick(("0", "1", "2", "wet.many", "50 % * 4"))]
        left, right = sides if self.choices.chance(60) else sides[::-1]
        return f"({left} {self.choices.pick(('<=', '<', '>=', '>', '==', '!='))} {right})"


class FurtherModule(ModuleWriter):
    """A module with all of that."""

    def __init__(self, choices: Choices, inexact: str) -> None:
        super().__init__(choices, inexact)
        self.writer = FurtherWriter(choices, self, inexact)
        self.lines += _DECLARED

    def signals(self) -> None:
        super().signals()
        self.world.signals.update(_SIGNALS)

    def rule(self, name: str, depth: int) -> None:
        begun = len(self.lines)
        super().rule(name, depth)
        for place, line in enumerate(self.lines[begun:], begun):
            if line.startswith("  along ") and self.choices.chance(30):
                self.lines[place] = f"{line} at last"
            elif line.startswith("rule ") and self.choices.chance(15):
                self.lines[place] = f"{line}\n  severity {self.choices.pick(('minor', 'critical'))}"


class FurtherInputs(Inputs):
    """Cases for it."""

    def value(self, info: FieldInfo, dirt: int) -> Any:
        if info.dimension != SHADE:
            return super().value(info, dirt)
        if self.choices.chance(dirt):
            return self.choices.pick((None, "none", 1.5, 99, -1, float("nan")))
        return self.choices.pick((*SHADES, 0, 1, 2))

    def _overrides(self, case: dict[str, Any]) -> None:
        super()._overrides(case)
        if self.choices.chance(20):
            params = case.setdefault("params", {})
            params[self.choices.pick(("dry.far", "wet.many"))] = self.choices.real(-5.0, 5.0)


def further(choices: Choices, rules: int = 3, depth: int = 3, cases: int = 6) -> Subject:
    """A subject of all that, with functions of any kind."""
    module = FurtherModule(choices, "any")
    module.declarations(depth - 1)
    for index in range(choices.integer(1, rules)):
        module.rule(f"rule{index}", depth)
    inputs = FurtherInputs(choices, module.world)
    dirt = [choices.pick((0, 0, 0, 8, 8, 30)) for _ in range(choices.integer(1, cases))]
    return Subject(module.text, tuple(inputs.case(index, percent) for index, percent in enumerate(dirt)))
