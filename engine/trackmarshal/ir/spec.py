"""A compiled spec: the input contract, parameters, rules as formulas, and where each came from."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, NamedTuple

from trackmarshal.ir.nodes import IR, Axis, Formula, GridLookup, Lookup, Param, below
from trackmarshal.ir.overrun import over_run
from trackmarshal.ir.tables import LINEAR_CLAMP, Way
from trackmarshal.node import Node
from trackmarshal.source import Span

if TYPE_CHECKING:
    from trackmarshal.typed import Rule


class Enumeration(Node):
    """Names of which a field is one, by its qualified name. A field has the place of its member, from 0, as its number."""

    name: str
    members: tuple[str, ...]


class FieldType(Node):
    """One field of a signal. `kind` is number, bool or polyline; numbers come in `unit`, ranges and defaults are in SI.

    enumeration: of a number that is the place of a member. The default of a bool is 1 or 0.
    """

    name: str
    kind: str
    unit: str
    increasing: bool
    lower: float | None
    upper: float | None
    default: float | None
    span: Span
    enumeration: Enumeration | None = None


#: The kind of a field whose type has an error: nothing that reads it has one of its own.
UNKNOWN = "unknown"
#: The kind of a timeline that is no input: what was driven, and what is planned.
COURSE = "course"


class SignalType(Node):
    """The contract of one signal: trajectory, series, state, object (many: a set), corridor, polyline.

    capacity: the most elements of a set, and the most of which anything is remembered, those that are absent included; None: as many as the
    limit `elements` says, and nothing of what is absent. forget: for how long one may be absent and keep its history [ns].
    """

    name: str
    kind: str
    many: bool
    fields_: tuple[FieldType, ...]
    span: Span
    capacity: int | None = None
    forget: int = 0

    def field(self, name: str) -> FieldType | None:
        for field in self.fields_:
            if field.name == name:
                return field
        return None

    @property
    def sequence(self) -> bool:
        """Whether the signal is a timeline: columns of samples."""
        return self.kind in ("trajectory", "series", COURSE) and not self.many


class CourseInfo(Node):
    """What was driven and what is planned as one timeline: records of one signal as far back as a time [ns], now, and samples of another one.

    signal: what its samples have: the time from now on, and the fields that both signals have.
    """

    signal: SignalType
    lived: str
    planned: str
    back: int


class ParamInfo(Node):
    """A parameter: value and range in SI; `unit` is what overrides come in."""

    name: str
    value: float
    unit: str
    lower: float | None
    upper: float | None
    source: str | None
    span: Span
    #: The record of parameters that it is a field of; "": of none.
    record: str = ""
    #: The parameters of which its value is made, by their names: a value for them changes it no more.
    made_of: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """As it is by itself; one that is in no record, as it was before there were any: what is kept of runs rests on it."""
        told = [name for name in self.compared if name != "made_of" and (name != "record" or self.record)]
        return f"ParamInfo({', '.join(f'{name}={self.__dict__[name]!r}' for name in told)})"

    @property
    def short(self) -> str:
        """What it is called in its module: `mass`, `limits.response`."""
        last = self.name.rpartition(".")[2]
        return f"{self.record}.{last}" if self.record else last


class Across(Node):
    """The second argument of a table: its knots in SI, ascending, their unit, and how the table is read along it."""

    knots: tuple[float, ...]
    unit: str
    way: Way


class TableInfo(Node):
    """A table: knots in SI, ascending; `units` are those that overrides come in. `way`: how it is read along its (first) argument.

    across: of a table of two arguments the second one; `values` are then row by row.
    """

    name: str
    knots: tuple[float, ...]
    values: tuple[float, ...]
    units: tuple[str, str]
    span: Span
    way: Way = LINEAR_CLAMP
    across: Across | None = None

    def __repr__(self) -> str:
        """A `linear clamp` of one argument is described as it was before there were others: what is kept of runs rests on it."""
        more = {"way": self.way != LINEAR_CLAMP, "across": self.across is not None}
        told = [name for name in self.compared if more.get(name, True)]
        return f"TableInfo({', '.join(f'{name}={self.__dict__[name]!r}' for name in told)})"


class PlaceInfo(Node):
    """A zone (polygon) or a line, in metres, on a track; "" where it belongs to none by name."""

    name: str
    kind: str
    points: tuple[tuple[float, float], ...]
    span: Span
    track: str = ""


def short_name(info: ParamInfo | TableInfo | PlaceInfo) -> str:
    """What a setting is called in its module, by which others replace it."""
    return info.short if isinstance(info, ParamInfo) else info.name.rpartition(".")[2]


def track_of(module: str) -> str:
    """The track that a module's places are on: `tracks.NAME` has those of NAME; empty for another module, whose places hold anywhere."""
    first, _, rest = module.partition(".")
    return rest.rpartition(".")[2] if first == "tracks" else ""


class ConstraintInfo(Node):
    """A demand on parameters."""

    formula: Formula
    because: str | None
    span: Span


class Called(NamedTuple):
    """What a rule calls a number or a formula. `own`: it is a `let`, or what a definition makes; else it is given to a definition, which calls it so.

    unit: of a number, in SI. text: as it is written where it is called, with what it is given.
    """

    node: IR
    name: str
    own: bool
    unit: str = "1"
    text: str = ""


#: The severity of rules that warn, and never decide.
ADVISORY = "advisory"


class RuleInfo(Node):
    """A rule, or an assumption with a monitor, as a formula."""

    name: str
    kind: str  # "rule" or "assume"
    title: str
    module: str
    formula: Formula | None
    #: Holds where the rule applies at all; None: always.
    active: Formula | None
    along: Axis | None
    unit: str
    satisfies: tuple[tuple[str, Span], ...]
    assuming: tuple[tuple[str, Span], ...]
    source: str
    because: str
    severity: str
    evidence: str
    owner: str
    #: (signal, field) pairs that the formula reads; the field is "" for whole signals.
    reads: frozenset[tuple[str, str]]
    fingerprint: str
    span: Span
    #: What it means, as written, of which `formula` is made; None where there is no formula.
    typed: Rule | None = None
    #: The rule as it is written, and what it calls the values in it.
    text: str = ""
    names: tuple[Called, ...] = ()
    #: The course that it lives along, if its timeline is one.
    course: CourseInfo | None = None

    @property
    def roots(self) -> list[Formula]:
        """Its formula, and that of its range: those that it has."""
        return [root for root in (self.formula, self.active) if root is not None]

    @property
    def over_run(self) -> bool:
        """Whether its formula, or the range of that, speaks of other cycles than the present one: then it has a worst and a best case."""
        return over_run(self.formula) or over_run(self.active)

    @property
    def advisory(self) -> bool:
        """Whether it warns and never decides."""
        return self.severity == ADVISORY


def remembers(rule: RuleInfo) -> bool:
    """Whether what a rule says of a cycle depends on others."""
    return rule.over_run or rule.course is not None


class RulebookInfo(Node):
    """A pre-order of rules: all that it names, and what is said of them, those of the rulebook that it builds on first.

    relations: (rule, `>` outranks, `~` equals or `&` counts as one with, rule).
    """

    name: str
    title: str
    rules: tuple[str, ...]
    relations: tuple[tuple[str, str, str], ...]
    span: Span


class Spec(Node):
    """Everything that a set of modules demands. Maps are keyed by qualified names (`vehicles.devbot.mass`)."""

    signals: dict[str, SignalType]
    events: dict[str, Span]
    params: dict[str, ParamInfo]
    tables: dict[str, TableInfo]
    places: dict[str, PlaceInfo]
    constraints: tuple[ConstraintInfo, ...]
    rules: tuple[RuleInfo, ...]
    rulebooks: tuple[RulebookInfo, ...]
    fingerprint: str
    #: By SI unit what margins in it are divided by where they meet margins in other ones; units that are not there have 1.
    scales: tuple[tuple[str, float], ...] = ()
    courses: tuple[CourseInfo, ...] = ()

    @property
    def inputs(self) -> str:
        """A hash of what it says of its inputs, of which its fingerprint knows nothing: signals with the kinds, ranges and defaults of their fields,
        and events."""
        said = repr([[signal for _, signal in sorted(self.signals.items())], sorted(self.events)])
        return hashlib.sha256(said.encode()).hexdigest()

    def scale(self, rule: RuleInfo) -> float:
        """What the margin of a rule is divided by before it is compared with that of another one: 1 where it is a number of scales already."""
        return dict(self.scales).get(rule.unit, 1.0)

    def field(self, signal: str, name: str) -> FieldType | None:
        """A field of a signal, or of a course."""
        courses = (course.signal for course in self.courses if course.signal.name == signal)
        info = self.signals.get(signal) or next(courses, None)
        return None if info is None else info.field(name)

    def rule(self, name: str) -> RuleInfo | None:
        return next((rule for rule in self.rules if rule.name == name), None)

    def declares(self, *formulas: Formula) -> bool:
        """Whether every parameter and table that formulas read is declared; what has an error of its own is not."""
        nodes = [node for formula in formulas for node in below(formula)]
        params = {node.name for node in nodes if isinstance(node, Param)}
        tables = {node.table for node in nodes if isinstance(node, Lookup | GridLookup)}
        return params <= self.params.keys() and tables <= self.tables.keys()
