"""What chosen rules read, and how C calls it: inputs, parameters, tables, places, lines and areas."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import assert_never

from trackmarshal.backends.c.courses import Course, courses_of
from trackmarshal.backends.c.facts import Facts, Same
from trackmarshal.backends.c.names import distinct
from trackmarshal.backends.c.over_run.cells import Cell, cells_of
from trackmarshal.backends.c.over_run.future import Future, future_of
from trackmarshal.backends.c.over_run.pairs import Pairs, pairs_of
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.reads import known_again
from trackmarshal.ir.spec import FieldType, RuleInfo, SignalType, Spec
from trackmarshal.ir.tables import LINEAR_CLAMP


@dataclass(frozen=True)
class Input:
    """One signal or event of the input struct: its C name, its fields as (spec field, C name)."""

    name: str
    c_name: str
    kind: str  # "columns", "record" or "event"
    signal: SignalType | None
    fields: tuple[tuple[FieldType, str], ...]


@dataclass(frozen=True)
class Shape:
    """A prepared polyline or region of the context: `key` tells what it is made of, `sources` its border lines.

    kind: "zone", "corridor" (regions), "place", "signal", "centre" (lines). many: one for each lane of a set.
    """

    key: tuple[str, str, str]
    c_name: str
    kind: str
    region: bool
    many: bool = False


@dataclass
class Layout:
    """Everything that the chosen rules need, with C names."""

    spec: Spec
    rules: list[RuleInfo]
    inputs: dict[str, Input] = field(default_factory=dict)
    params: dict[str, str] = field(default_factory=dict)
    tables: dict[str, str] = field(default_factory=dict)
    #: Tables of two arguments; those of one are `tables`, which can be replaced.
    grids: dict[str, str] = field(default_factory=dict)
    shapes: dict[tuple[str, str, str], Shape] = field(default_factory=dict)
    rule_names: dict[str, str] = field(default_factory=dict)
    facts: Facts = field(default_factory=Facts)
    #: What operators over the run and state machines keep, those inside others before them.
    kept: dict[ir.Formula | ir.Machine, Cell] = field(default_factory=dict)
    #: What rules that look ahead keep.
    future: Future = field(default_factory=Future)
    #: What was driven and what is planned, where rules live along both.
    courses: dict[str, Course] = field(default_factory=dict)
    #: The pairs of elements of which something is remembered, by the signals of both; and those of which the last cycles are kept.
    pairs: dict[tuple[str, ...], Pairs] = field(default_factory=dict, init=False)
    pairs_ahead: dict[tuple[str, ...], Pairs] = field(default_factory=dict, init=False)
    _pairs: dict[tuple[str, ...], Pairs] = field(default_factory=dict, init=False)
    _known_again: set[str] = field(default_factory=set, init=False)

    def __post_init__(self) -> None:
        self._same = Same(self.facts)

    def input(self, signal: str) -> Input:
        return self.inputs[signal]

    def event(self, name: str) -> Input | None:
        """The event of this name, where rules read one: a signal may be called so, too."""
        found = self.inputs.get(name)
        return found if found is not None and found.kind == "event" else None

    def field_name(self, signal: str, name: str) -> str:
        fields = self.courses[signal].fields if signal in self.courses else self.inputs[signal].fields
        return next(c for info, c in fields if info.name == name)

    def shape(self, item: ir.Line | ir.Area | ir.OnLane) -> Shape:
        return self.shapes[shape_key(item)]

    def memory(self, node: ir.OverRun | ir.Counted | ir.Machine) -> Cell:
        """The memory of a machine, of an operator over the run, or of one that says the same."""
        return self.kept[node if isinstance(node, ir.Machine) else self._same.formula(node)]

    def remember(self) -> None:
        """Give all operators over the run their memory; raises TrackmarshalError E470 for what C cannot remember."""
        self.kept = cells_of(self.rules, self._same.formula)
        self.future = future_of(self.rules, self._same.formula)
        about = [each.axes for each in self.kept.values()]
        self._known_again = {axis.signal for axes in about for axis in axes} | set(self.future.sets)
        self._pairs = pairs_of([*about, *self.future.pairs])
        self.pairs, self.pairs_ahead = self._pairs_of(about), self._pairs_of(self.future.pairs)
        asked = {name for rule in self.rules for root in rule.roots for name in known_again(root)}
        unasked = self._known_again - asked
        if unasked:  # a program would read ids that are not there
            raise AssertionError(f"no door asks for the ids of {sorted(unasked)}")

    def same(self, node: ir.Formula) -> ir.Formula:
        """The one formula of those that say the same."""
        return self._same.formula(node)

    @property
    def remembers(self) -> bool:
        """Whether anything is kept from one cycle to the next."""
        return bool(self.kept or self.future.rules or self.courses)

    def put_tables(self, names: set[str]) -> None:
        """Name the tables of the spec that are read."""
        read = {name: table for name, table in self.spec.tables.items() if name in names}
        self.tables = distinct(name for name, table in read.items() if table.across is None)
        self.grids = distinct(name for name, table in read.items() if table.across is not None)

    @property
    def other_ways(self) -> bool:
        """Whether a table of one argument is read in another way than `linear clamp`."""
        return any(self.spec.tables[name].way != LINEAR_CLAMP for name in self.tables)

    @property
    def lasting(self) -> list[str]:
        """Those of them that are known again after an absence."""
        return [item.name for item in self.named if item.signal is not None and item.signal.forget]

    @property
    def named(self) -> list[Input]:
        """The sets whose elements are known again in other cycles."""
        return [item for item in self.inputs.values() if item.name in self._known_again]

    def input_names(self, used: Sequence[str], stamped: bool) -> dict[str, str]:
        """Signals and events to members of the input, which has the stamp beside them where it is `stamped`. What is remembered of a set whose
        elements are known again is called as the set is, and stands beside memories."""
        names = distinct(used, ("t",) if stamped else ())
        memories = {each.c_name for each in self.kept.values()} | _OF_THE_RUN
        memories |= {each.c_name for each in self._pairs.values()}
        for name in used:
            if name in self._known_again and names[name].casefold() in memories:
                others = {c_name.casefold() for c_name in names.values()}
                names |= distinct([name], memories | others)
        return names

    def _pairs_of(self, about: Iterable[tuple[ir.Axis, ...]]) -> dict[tuple[str, ...], Pairs]:
        """Those that some operators are about."""
        kept = {tuple(axis.signal for axis in axes) for axes in about}
        return {signals: pair for signals, pair in self._pairs.items() if signals in kept}

    def places_of(self, axes: tuple[ir.Axis, ...]) -> str:
        """What has the places in memories of the elements of a set, or of pairs, as C calls it; nothing of the run."""
        if len(axes) == 2:
            return self._pairs[tuple(axis.signal for axis in axes)].c_name
        return self.input(axes[0].signal).c_name if axes else ""

    @property
    def paired(self) -> set[str]:
        """The sets of whose elements there are pairs that are known again after an absence: where elements of one of both are gone at once,
        they may be absent for no time."""
        return {signal for signals, pair in self.pairs.items() if pair.forget for signal in signals}

    @property
    def nodes(self) -> Iterator[ir.AnyNode]:
        """All that the rules are made of."""
        return (node for rule in self.rules for root in rule.roots for node in ir.below(root))

    @property
    def lines(self) -> list[Shape]:
        return [s for s in self.shapes.values() if not s.region]

    @property
    def regions(self) -> list[Shape]:
        return [s for s in self.shapes.values() if s.region]


def shape_key(item: ir.Line | ir.Area | ir.OnLane) -> tuple[str, str, str]:
    """What a line or region is made of; of lanes, all of them."""
    if isinstance(item, ir.OnLane):
        if item.what in ("inside", "meets"):
            return "corridor", item.signal, ""
        return ("centre", item.signal, "") if item.side == "centre" else ("signal", item.signal, item.side)
    return (item.kind, item.name, item.field if isinstance(item, ir.Line) else "")


def is_lanes(spec: Spec, name: str) -> bool:
    """Whether a signal or place is a set of lanes."""
    return name in spec.signals and spec.signals[name].many


def layout(spec: Spec, rules: Sequence[RuleInfo], whole: Sequence[str] = ()) -> Layout:
    """Collect what the rules read; rules without a formula are left out.

    whole: signals that are read in any case; with them, all fields of every signal count, as in the input contract.
    """
    result = Layout(spec, [rule for rule in rules if rule.formula is not None])
    result.remember()
    columns: dict[str, set[str]] = {}
    params: list[str] = []
    tables: list[str] = []
    shapes: dict[tuple[str, str, str], bool] = {}
    events: list[str] = []
    for node in result.nodes:
        match node:
            case ir.Column():
                columns.setdefault(node.axis.signal, set()).add(node.field)
            case ir.Axis():
                columns.setdefault(node.signal, set())
            case ir.Sample() | ir.Scalar():
                columns.setdefault(node.signal, set()).add(node.field)
            case ir.Flag():
                if node.signal in spec.events:
                    events.append(node.signal)
                else:
                    columns.setdefault(node.signal, set()).add(node.field or "")
            case ir.Temporal() | ir.Until() | ir.Tallied():
                columns.setdefault(node.axis.signal, set()).add("t")
            case ir.Param():
                params.append(node.name)
            case ir.Lookup() | ir.GridLookup():
                tables.append(node.table)
            case ir.Line() if node.kind == "path":
                columns.setdefault(node.name, set()).update(("x", "y"))
            case ir.Line() | ir.Area():
                shapes[shape_key(node)] = isinstance(node, ir.Area)
            case ir.OnLane():
                columns.setdefault(node.signal, set())
                shapes[shape_key(node)] = node.what in ("inside", "meets")
            case (
                ir.Const() | ir.Arith() | ir.Neg() | ir.Func() | ir.Choose() | ir.Ordinal() | ir.Fold()
                | ir.Station() | ir.Offset() | ir.Direction() | ir.Distance() | ir.StationGap() | ir.StretchRoom()
                | ir.Truth() | ir.Compare() | ir.Scaled() | ir.Not() | ir.Connective() | ir.Quantify() | ir.Guarded()
                | ir.SweptInside() | ir.SweptClear() | ir.InArea() | ir.Shift() | ir.At()
            ):  # fmt: skip
                pass  # what they are made of is below, too
            case ir.OverRun() | ir.Counted() | ir.InState() | ir.Kept() | ir.Machine():
                pass  # see `remember`
            case _:
                assert_never(node)
    result.courses = courses_of(result.rules, columns)
    for name in whole:
        columns.setdefault(name, set())
        if any(info.kind == "polyline" for info in spec.signals[name].fields_) and spec.signals[name].many:
            shapes["corridor", name, ""] = True  # lanes: the door asks whether they are roads
    if whole:
        for name, fields in columns.items():
            if name in spec.signals:
                fields.update(info.name for info in spec.signals[name].fields_)
    used = [name for name in (*spec.signals, *spec.events) if name in columns or name in events]
    for name, c_name in result.input_names(used, result.remembers and not whole).items():
        if name in spec.events:
            result.inputs[name] = Input(name, c_name, "event", None, ())
            continue
        signal = spec.signals[name]
        chosen = [info for info in signal.fields_ if info.name in columns[name] and info.kind != "polyline"]
        names = distinct(info.name for info in chosen)
        kind = "columns" if signal.many or signal.sequence else "record"
        result.inputs[name] = Input(
            name, c_name, kind, signal, tuple((info, names[info.name]) for info in chosen)
        )
    result.params = distinct(name for name in spec.params if name in set(params))
    result.put_tables(set(tables))
    order = sorted(shapes)
    c_names = distinct(".".join(part for part in key if part) for key in order)
    for key, c_name in zip(order, c_names.values(), strict=True):
        result.shapes[key] = Shape(key, c_name, key[0], shapes[key], is_lanes(spec, key[1]))
    rules_ = distinct((rule.name for rule in result.rules), endings=_ENDINGS)
    result.rule_names = {name: c_name.lower() for name, c_name in rules_.items()}
    return result


#: Other members of what rules remember of the run, beside those of its sets.
_OF_THE_RUN = frozenset(
    {"any", "begun", "crowded", "future", "last", "lived", "missed", "now", "number", "parts", "serial"}
)
#: What the names of a rule's functions end in, after the rule's own: no other rule's name may.
_ENDINGS = (
    "_known",
    "_any",
    "_along",
    "_start",
    "_push",
    "_finish",
    "_advance",
    "_said",
    "_applies",
    "_hope",
)
