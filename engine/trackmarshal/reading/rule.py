"""A rule for readers: its clauses one below the other, the definitions that it calls, and all that its numbers rest on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, assert_never

from trackmarshal import typed
from trackmarshal.ir.nodes import JudgedAt
from trackmarshal.ir.spec import FieldType, ParamInfo, PlaceInfo, RuleInfo, Spec, TableInfo
from trackmarshal.node import Node
from trackmarshal.reading.formulas import Formulas
from trackmarshal.reading.layout import Call, Chain, Joined, Layout, Sign
from trackmarshal.reading.names import Names, bridged
from trackmarshal.syntax import ast

Kind = Literal["along", "whenever", "within", "each", "where", "except", "let", "require", "monitor"]


class Shown(Node):
    """A clause: what it is, how far it is moved in, its formula, an author's words on it ("": none), and at which sample a rule along a timeline is judged."""

    kind: Kind
    depth: int
    formula: Layout
    said: str = ""
    judged: JudgedAt | None = None


class Definition(Node):
    """`gap(o) = ...`: what stands before the sign, and after it."""

    symbol: typed.Symbol
    head: Layout
    sign: Literal["=", "⇔"]
    body: Layout


class Move(Node):
    """A transition of a state machine: from which states to which, when, and what is remembered."""

    sources: tuple[str, ...]
    target: str
    guard: Layout
    kept: tuple[Layout, ...]


class MachineShown(Node):
    """A state machine: of what it is, its states with the first one first, the gap that it bridges, and its transitions in the order in which they are looked at."""

    head: Layout
    states: tuple[str, ...]
    start: str
    bridges: str
    moves: tuple[Move, ...]


class Setting(Node):
    """A parameter in force, and as the spec declares it; unit: the one that its value is written in. overridden: a configuration replaced it."""

    shown: Layout
    unit: str
    info: ParamInfo
    declared: ParamInfo
    overridden: bool


class Reading(Node):
    """All that a reader of a rule is shown. Tables and zones are as they are in force."""

    rule: RuleInfo
    clauses: tuple[Shown, ...]
    definitions: tuple[Definition, ...]
    machines: tuple[MachineShown, ...]
    settings: tuple[Setting, ...]
    tables: tuple[tuple[Layout, TableInfo], ...]
    places: tuple[PlaceInfo, ...]
    #: What is read of the input: signal, field, and the field's declaration (None: a whole signal).
    inputs: tuple[tuple[str, str, FieldType | None], ...]


def read(rule: RuleInfo, spec: Spec, declared: Spec | None = None, expand: bool = False) -> Reading:
    """A rule with a condition, for readers; declared: the spec as its files have it, before a configuration changed it (None: nothing did).

    expand: definitions are written out. Raises TrackmarshalError E490 where that is too long.
    """
    assert rule.typed is not None, "a rule without a condition says nothing"
    writing = Formulas(expand)
    clauses = tuple(_clauses(rule.typed, writing))
    reached = list(typed.below(rule.typed))
    definitions = () if expand else tuple(_definitions(reached, writing))
    machines = tuple(_machines(reached, writing))
    return Reading(
        rule, clauses, definitions, machines, tuple(_settings(reached, spec, declared or spec, writing.names)),
        tuple(_tables(reached, spec, writing.names)), tuple(_places(reached, spec)),
        tuple((signal, field, spec.field(signal, field)) for signal, field in sorted(rule.reads)),
    )  # fmt: skip


def _clauses(rule: typed.Rule, writing: Formulas) -> Iterator[Shown]:
    """In the order written; whatever stands below a quantifier or a condition is moved in. A deadline stands at what is demanded in time: it is one for
    each that the quantifiers range over."""
    depth, deadline = 0, None
    for clause in rule.clauses:
        match clause:
            case typed.Along():
                writing.keep(clause.range)
                yield Shown("along", depth, writing.ranged(clause.range), "", clause.place)
                depth += 1
            case typed.Whenever():
                yield Shown("whenever", depth, writing.formula(clause.condition))
                depth += 1
            case typed.Deadline():
                deadline = writing.number(clause.limit)
            case typed.ForEach():
                writing.keep(clause.range)
                yield Shown("each", depth, writing.quantifier(clause.quantifier, clause.range, clause.by))
                depth += 1
                if clause.where is not None:
                    yield Shown("where", depth, writing.formula(clause.where))
            case typed.Except():
                yield Shown("except", depth, writing.formula(clause.condition), clause.reason)
            case typed.Let():
                value = writing.value(clause.value)
                yield Shown("let", depth, _equal(writing.let(clause.name), value, clause.value))
            case typed.Require():
                if deadline is not None:
                    yield Shown("within", depth, deadline)
                yield Shown(clause.keyword, depth, writing.formula(clause.condition))
            case _:
                assert_never(clause)


def _equal(head: Layout, body: Layout, value: typed.Value) -> Layout:
    return Chain(head, (Joined(Sign("⇔" if isinstance(value, typed.FormulaNode) else "="), body),), True)


def _definitions(reached: list[typed.Typed], writing: Formulas) -> Iterator[Definition]:
    """Each definition and each stretch that has a name once, in the order in which they are come upon."""
    seen = set()
    for node in reached:
        if (
            isinstance(node, typed.InStretch)
            and node.symbol is not None
            and node.symbol.qualified not in seen
        ):
            seen.add(node.symbol.qualified)
            yield Definition(node.symbol, writing.named("place", node.symbol), "=", writing.ends(node))
        if not isinstance(node, typed.CalledNumber | typed.CalledFormula) or node.symbol.qualified in seen:
            continue
        seen.add(node.symbol.qualified)
        item = node.symbol.item
        assert isinstance(item, ast.Define)
        number = isinstance(node, typed.CalledNumber)
        head = writing.named("function" if number else "predicate", node.symbol)
        with writing.apart():
            given = tuple(writing.names.of("local", one.name, one.name) for one in item.parameters)
            body = (
                writing.number(node.body)
                if isinstance(node, typed.CalledNumber)
                else writing.formula(node.body)
            )
        yield Definition(node.symbol, Call(head, given) if given else head, "=" if number else "⇔", body)


def _machines(reached: list[typed.Typed], writing: Formulas) -> Iterator[MachineShown]:
    seen = set()
    for node in reached:
        if not isinstance(node, typed.Machine) or node.symbol.qualified in seen:
            continue
        seen.add(node.symbol.qualified)
        item = node.symbol.item
        assert isinstance(item, ast.State)
        with writing.apart():
            moves = tuple(
                Move(
                    one.sources, one.target, writing.formula(one.guard),
                    tuple(_equal(writing.names.of("local", keep.name, keep.name), writing.number(keep.value), keep.value) for keep in one.kept),
                )
                for one in node.transitions
            )  # fmt: skip
        head: Layout = writing.named("machine", node.symbol)
        if node.element is not None:
            assert isinstance(node.element, typed.NamedRecord)
            head = Call(head, (writing.names.of("local", node.element.name, node.element.name),))
        states = tuple(state.name for state in item.states)
        yield MachineShown(head, states, item.start.name, bridged(item), moves)


def _settings(reached: list[typed.Typed], spec: Spec, declared: Spec, names: Names) -> Iterator[Setting]:
    seen = set()
    for node in reached:
        if isinstance(node, typed.Parameter) and node.symbol.qualified not in seen:
            name = node.symbol.qualified
            seen.add(name)
            info, own = spec.params[name], declared.params[name]
            shown = names.of("parameter", name, info.short)
            unit = node.written or info.unit
            # Places are compared as text: the spec was read twice, each time into objects of its own.
            yield Setting(shown, unit, info, own, str(info.span) != str(own.span))


def _tables(reached: list[typed.Typed], spec: Spec, names: Names) -> Iterator[tuple[Layout, TableInfo]]:
    seen = set()
    for node in reached:
        if isinstance(node, typed.TableValue) and node.symbol.qualified not in seen:
            seen.add(node.symbol.qualified)
            yield (
                names.of("table", node.symbol.qualified, node.symbol.name),
                spec.tables[node.symbol.qualified],
            )


def _places(reached: list[typed.Typed], spec: Spec) -> Iterator[PlaceInfo]:
    seen = set()
    for node in reached:
        if isinstance(node, typed.Zone | typed.PlacedLine) and node.symbol.qualified not in seen:
            seen.add(node.symbol.qualified)
            yield spec.places[node.symbol.qualified]
