"""A module of a spec: signals of every kind, parameters, tables, definitions, and rules with all their clauses."""

from __future__ import annotations

from dataclasses import replace

from support.generated.choices import Choices
from support.generated.formulas import DEEPEST, FormulaWriter, Scope
from support.generated.places import PlaceWriter, Road
from support.generated.vocabulary import (
    COMMON,
    PLAIN,
    SHAPES,
    SIGNALS,
    TIMELINES,
    UNITS,
    DefineInfo,
    Dimension,
    FieldInfo,
    ParamInfo,
    SignalInfo,
    TableInfo,
    World,
    spelled,
)


class ModuleWriter:
    """Writes a module line by line; `world` is what it has declared so far."""

    def __init__(self, choices: Choices, inexact: str = "no", geometry: bool = False) -> None:
        self.choices = choices
        self.world = World(road=geometry)
        self.writer = (PlaceWriter if geometry else FormulaWriter)(choices, self.world, inexact)
        self.lines = ["module made"]

    @property
    def text(self) -> str:
        return "\n".join(self.lines) + "\n"

    def declarations(self, depth: int) -> None:
        """Everything but rules."""
        self.signals()
        self._params()
        self._tables()
        if self.world.road:
            self._places()
        self._definitions(depth)

    def signals(self) -> None:
        for name, (kind, fields) in SIGNALS.items():
            infos = {field: self._field(name, field, dimension) for field, dimension in fields.items()}
            self.world.signals[name] = SignalInfo(kind, infos)
            texts = ", ".join(f"{field}: {self._field_text(info)}" for field, info in infos.items())
            self.lines.append(f"signal {name} : {kind} {{ {texts} }}")
        for name in ("go", "halt")[: self.choices.integer(0, 2)]:
            self.world.events.append(name)
            self.lines.append(f'event {name} "as it happens"')

    def _field(self, signal: str, field: str, dimension: Dimension | None) -> FieldInfo:
        if dimension is None:
            return FieldInfo(None, "bool")
        if field == "t" and signal in TIMELINES:
            return FieldInfo(dimension, self.choices.pick(("s", "ms")), increasing=True)
        unit = self.choices.pick(UNITS[dimension]) if self.choices.chance(20) else UNITS[dimension][0]
        limits = (
            self.choices.pick(((-10.0, 10.0), (0.0, 1.0), (-1e9, 1e9))) if self.choices.chance(15) else None
        )
        default = None
        if self.choices.chance(15):
            default = self.choices.pick([v for v in PLAIN if limits is None or limits[0] <= v <= limits[1]])
        return FieldInfo(dimension, unit, False, limits, default)

    @staticmethod
    def _field_text(info: FieldInfo) -> str:
        text = info.unit + (" increasing" if info.increasing else "")
        if info.range is not None:
            text += f" in [{_signed(info.range[0])}, {_signed(info.range[1])}]"
        return text if info.default is None else f"{text} default {_signed(info.default)}"

    def _params(self) -> None:
        for index in range(self.choices.integer(0, 4)):
            dimension = self.choices.pick((*COMMON, *UNITS))
            unit = self.choices.pick(UNITS[dimension])
            value = self.choices.pick(PLAIN)
            bounded = self.choices.chance(50)
            low, high = (value - 2.0, value + 3.0) if bounded else (None, None)
            name = f"limit{index}"
            self.world.params[name] = ParamInfo(dimension, unit, low, high)
            text = f"param {name} : {unit} = {_signed(value)}" + ("" if unit == "1" else f" {unit}")
            self.lines.append(
                text
                + (f" in [{_signed(low)}, {_signed(high)}]" if low is not None and high is not None else "")
            )

    def _tables(self) -> None:
        for index in range(self.choices.integer(0, 2)):
            argument, result = self.choices.pick(tuple(UNITS)), self.choices.pick(COMMON)
            units = UNITS[argument][0], UNITS[result][0]
            rows = self.choices.integer(1, 4)
            name = f"curve{index}"
            texts, knot = [], self.choices.pick(PLAIN)
            for _ in range(rows):
                texts.append(f"| {_signed(knot)}: {_signed(self.choices.pick(PLAIN))} ")
                knot += self.choices.pick((0.5, 1.0, 0.1, 5.0))
            self.world.tables[name] = TableInfo(argument, result, rows)
            way = self.choices.pick(("linear clamp", "linear clamp", "step", "step clamp", "linear"))
            self.lines.append(f"table {name}(x: {units[0]}) -> {units[1]} = {way} {''.join(texts)}|")

    def _places(self) -> None:
        self.lines += [
            "signal track : corridor { left: polyline, right: polyline }",
            "signal fence : polyline",
        ]
        road = Road(self.choices)
        for index in range(self.choices.integer(1, 2)):
            self.world.zones.append(f"area{index}")
            self.lines.append(f"zone area{index} = polygon {_points(road.ring())}")
        for index in range(self.choices.integer(0, 1)):
            self.world.lines.append(f"mark{index}")
            self.lines.append(f"line mark{index} = {_points(road.mark())}")

    def _definitions(self, depth: int) -> None:
        for index in range(self.choices.integer(0, 3)):
            parameters: list[tuple[str, Dimension | str]] = []
            for number in range(self.choices.integer(0, 3)):
                kind: Dimension | str = self.choices.pick(tuple(UNITS))
                if self.choices.chance(40):
                    kind = self.choices.pick(
                        (*SHAPES, "polyline", "corridor", "trajectory") if self.world.road else tuple(SHAPES)
                    )
                parameters.append((f"a{number}", kind))
            scope = Scope()
            for name, kind in parameters:
                if kind == "corridor":
                    scope = replace(scope, corridors=(*scope.corridors, name))
                elif kind in ("polyline", "trajectory"):
                    scope = replace(scope, lines=(*scope.lines, name))
                elif isinstance(kind, str):
                    scope = scope.bind(name, dict(SHAPES[kind]), False)
                else:
                    scope = replace(scope, numbers=(*scope.numbers, (name, kind)))
            temporal = self.choices.chance(20)
            # A definition is written out where it is called, up to two axes deep and inside others.
            scope = replace(scope, timeline=temporal, axes=DEEPEST - 1)
            listed = ", ".join(f"{n}: {k if isinstance(k, str) else UNITS[k][0]}" for n, k in parameters)
            head = f"({listed})" if parameters else ""
            if temporal or self.choices.chance(50):
                name, result = f"holds{index}", None
                self.lines.append(f"predicate {name}{head} = {self.writer.formula(depth, scope, False)}")
            else:
                name, result = f"of{index}", self.choices.pick(COMMON)
                arrow = f" -> {UNITS[result][0]}" if self.choices.chance(70) else ""
                self.lines.append(
                    f"define {name}{head}{arrow} = {self.writer.number(result, depth, scope, False)}"
                )
            self.world.defines[name] = DefineInfo(tuple(parameters), result, temporal)

    def rule(self, name: str, depth: int) -> None:
        """A rule, or an assumption with a monitor, with any of the clauses that change its meaning."""
        choices = self.choices
        assume = choices.chance(10)
        lines = [f'{"assume" if assume else "rule"} {name} "made up"']
        scope = Scope()
        head = choices.integer(0, 3)
        if head == 3 and choices.chance(20):
            lines.append(f"  whenever {self.writer.formula(depth - 1, scope, self.writer.inexact == 'any')}")
        if head >= 2:
            timeline = choices.pick(TIMELINES)
            sample = self.writer.fresh("s")
            scope = replace(
                scope.bind(sample, self.world.signals[timeline].dimensions(), True), timeline=True, axes=1
            )
            lines.append(f"  along {timeline} as {sample}")
        if len(lines) < 3 and not any("whenever" in line for line in lines) and choices.chance(15):
            lines.append(f"  whenever {self.writer.formula(depth - 1, scope, self.writer.inexact == 'any')}")
        for _ in range(choices.pick((0, 1, 1, 2))):
            scope = self._let(lines, scope, depth)
            if not self.writer.domains:
                continue
            clause, scope = self.writer.binder(depth - 1, scope)
            lines.append(f"  {clause}")
            if choices.chance(20):
                lines.append(
                    f'  except {self.writer.formula(depth - 1, scope, self.writer.inexact == "any")} "for a reason"'
                )
        scope = self._let(lines, scope, depth)
        lines.append(f"  {'monitor' if assume else 'require'} {self.writer.formula(depth, scope)}")
        self.lines += lines

    def _let(self, lines: list[str], scope: Scope, depth: int) -> Scope:
        if not self.choices.chance(20):
            return scope
        name = self.writer.fresh("let_")
        if self.choices.chance(30):
            lines.append(
                f"  let {name} = {self.writer.formula(depth - 1, scope, self.writer.inexact == 'any')}"
            )
            return replace(scope, formulas=(*scope.formulas, name))
        dimension = self.choices.pick(tuple(UNITS))
        lines.append(
            f"  let {name} = {self.writer.number(dimension, depth - 1, scope, self.writer.inexact == 'any')}"
        )
        return replace(scope, numbers=(*scope.numbers, (name, dimension)))


def _points(points: list[list[float]]) -> str:
    return " ".join(f"({_signed(x)}, {_signed(y)})" for x, y in points)


def _signed(value: float) -> str:
    text = spelled(abs(value))
    return f"-{text}" if value < 0 or str(value) == "-0.0" else text
