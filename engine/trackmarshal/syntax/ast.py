"""The syntax tree of a spec: what the author wrote, with spans, before any meaning.

Expressions first, then the clauses of rules, then declarations. Every node's last field is its `span`, which
equality ignores: `parse(format(tree)) == tree`. Literals keep the author's digits.
"""

from __future__ import annotations

from trackmarshal.node import Node
from trackmarshal.source import NOWHERE, Span


class Ranged(Node):
    """A quantifier. Without `by` it is described as it was before there was one: what is kept of runs rests on descriptions of rules."""

    def __repr__(self) -> str:
        told = [name for name in self.compared if name != "by" or self.__dict__[name] is not None]
        return f"{type(self).__name__}({', '.join(f'{name}={self.__dict__[name]!r}' for name in told)})"


class Expr(Node):
    """An expression; numbers and formulas share one syntax and are told apart by the type checker."""


class Parenthesised(Span):
    """The place of an expression that its author put in parentheses (which it does not cover): the formatter keeps them.

    They are part of the place, so that they are no part of what is compared: parentheses that change nothing change nothing.
    """

    __slots__ = ()


def parenthesised(expr: Expr) -> Expr:
    """An expression that was just made, as one that stands in parentheses."""
    span = expr.__dict__["span"]
    expr.__dict__["span"] = Parenthesised(span.file, span.start, span.end)
    return expr


def span_of(expr: Expr) -> Span:
    """Where an expression stands: it is no field, so that equal expressions are equal wherever they are written."""
    span: Span = expr.__dict__["span"]
    return span


def names_in(part: Node) -> set[str]:
    """The names that are mentioned in a part of a declaration."""
    return {node.name for node in part.walk() if isinstance(node, Name)}


def is_parenthesised(expr: Expr) -> bool:
    """Whether the author put an expression in parentheses."""
    return isinstance(expr.__dict__["span"], Parenthesised)


class Number(Expr):
    """`1160 kg`: digits as written, and the unit as written (empty for a bare number)."""

    text: str
    unit: str = ""
    span: Span = NOWHERE


class Boolean(Expr):
    """`true` or `false`."""

    value: bool
    span: Span = NOWHERE


class Name(Expr):
    """A name: a signal, a parameter, a variable, a definition."""

    name: str
    span: Span = NOWHERE


class Attribute(Expr):
    """`p.v`."""

    value: Expr
    name: str
    span: Span = NOWHERE


class Call(Expr):
    """`f(a, b)`; `names` holds the argument names, empty strings where there are none (builders only have names)."""

    function: str
    args: tuple[Expr, ...]
    names: tuple[str, ...] = ()
    span: Span = NOWHERE


class Infix(Expr):
    """A two-place predicate between its arguments: `o behind ego`."""

    left: Expr
    predicate: str
    right: Expr
    span: Span = NOWHERE


class Unary(Expr):
    """`-x`, `not x`."""

    op: str
    operand: Expr
    span: Span = NOWHERE


class Binary(Expr):
    """Arithmetic (+ - * / ^), comparison (< <= > >= == !=), and, or, implies, iff, xor."""

    op: str
    left: Expr
    right: Expr
    span: Span = NOWHERE


class Chained(Expr):
    """`0 m <= a <= b`: neighbours compared, all in one direction; one operand more than operators."""

    operands: tuple[Expr, ...]
    ops: tuple[str, ...]
    span: Span = NOWHERE


class IfElse(Expr):
    """`if c then a else b`: a number chosen by a formula."""

    condition: Expr
    then: Expr
    otherwise: Expr
    span: Span = NOWHERE


class Member(Node):
    """The name of a member of an enumeration."""

    name: str
    span: Span = NOWHERE


class Branch(Node):
    """`green, blue: 30 m/s`: what a `case` comes to for these members; none named: `else`."""

    members: tuple[Member, ...]
    value: Expr
    span: Span = NOWHERE


class Case(Expr):
    """`case race.flag { green, blue: 30 m/s, else: 10 m/s }`: a number or a formula for each member of an enumeration."""

    value: Expr
    branches: tuple[Branch, ...]
    span: Span = NOWHERE


class Within(Expr):
    """`x in [a, b]`, both ends included."""

    value: Expr
    lower: Expr
    upper: Expr
    span: Span = NOWHERE


class InZone(Expr):
    """`p in zone pit_lane`."""

    value: Expr
    zone: str
    span: Span = NOWHERE


class InStretch(Expr):
    """`p in stretch chicane`."""

    value: Expr
    stretch: str
    span: Span = NOWHERE


class BetweenStations(Expr):
    """`p in stretch(track, 4900 m, 120 m)`."""

    value: Expr
    line: Expr
    start: Expr
    end: Expr
    span: Span = NOWHERE


class Window(Node):
    """The bounds of a temporal operator, `[0 s, 0.5 s]`."""

    lower: Expr
    upper: Expr
    span: Span = NOWHERE


class Temporal(Expr):
    """always, eventually, historically, once, next, previous (`weak` for the last two)."""

    op: str
    operand: Expr
    window: Window | None = None
    weak: bool = False
    span: Span = NOWHERE


class Until(Expr):
    """`p until[a, b] q`, `p since[a, b] q`."""

    op: str
    left: Expr
    right: Expr
    window: Window | None = None
    span: Span = NOWHERE


class Quantified(Ranged, Expr):
    """`for all p in plan where c: body` inside an expression; `by`: of the nearest alone, `for nearest o in objects by E: body`."""

    quantifier: str
    consecutive: bool
    names: tuple[str, ...]
    domain: Expr
    where: Expr | None
    body: Expr
    by: Expr | None = None
    span: Span = NOWHERE


class Folded(Expr):
    """`sum(E for o in objects where c else d)`; a count has no body: `count(o in objects where c)`."""

    function: str
    body: Expr | None
    consecutive: bool
    names: tuple[str, ...]
    domain: Expr
    where: Expr | None
    otherwise: Expr | None
    span: Span = NOWHERE


class RecordValue(Expr):
    """`{ x: 0 m, y: 0 m }`, in tests."""

    names: tuple[str, ...]
    values: tuple[Expr, ...]
    span: Span = NOWHERE


class ListValue(Expr):
    """`[1 m, 2 m]`, in tests."""

    values: tuple[Expr, ...]
    span: Span = NOWHERE


class Clause(Node):
    """One clause of a rule, an assumption or a test."""


class Satisfies(Clause):
    """`satisfies S-1-A-4, S-1-A-5`."""

    ids: tuple[Name, ...]
    span: Span = NOWHERE


class Assuming(Clause):
    """`assuming A-FRICTION`."""

    ids: tuple[Name, ...]
    span: Span = NOWHERE


class SourceClause(Clause):
    """`source stahl2020 eq 2, 3`, `source stahl2020 "section V"` or `source "data sheet"` (no reference)."""

    reference: Name | None
    locator: str
    quoted: bool = False
    span: Span = NOWHERE


class Because(Clause):
    """`because "why"`."""

    text: str
    span: Span = NOWHERE


class Severity(Clause):
    """`severity minor`."""

    word: str
    span: Span = NOWHERE


class Allow(Clause):
    """`allow W301 because "why"`: warnings that are not given for this rule."""

    codes: tuple[Name, ...]
    reason: str
    span: Span = NOWHERE


class Evidence(Clause):
    """`evidence "path"`, of an assumption."""

    path: str
    span: Span = NOWHERE


class Owner(Clause):
    """`owner "who answers for it"`, of an assumption."""

    text: str
    span: Span = NOWHERE


class Bind(Ranged, Clause):
    """`for all o in objects where c`, `exists ...`, `for all consecutive p, q in plan`, `for nearest o in objects by E`."""

    quantifier: str
    consecutive: bool
    names: tuple[str, ...]
    domain: Expr
    where: Expr | None = None
    by: Expr | None = None
    span: Span = NOWHERE


class Except(Clause):
    """`except o behind ego "the rear vehicle is responsible"`."""

    condition: Expr
    reason: str
    span: Span = NOWHERE


class Let(Clause):
    """`let needed = ...`."""

    name: str
    value: Expr
    span: Span = NOWHERE


class Along(Clause):
    """`along plan as p at last`: the timeline that temporal operators range over, and at which sample the rule is judged, if it says so."""

    signal: Name
    name: str
    at: Name | None = None
    span: Span = NOWHERE


class Whenever(Clause):
    """`whenever blue_flag`: the rule applies in the cycles where this holds."""

    condition: Expr
    span: Span = NOWHERE


class WithinTime(Clause):
    """`within 5 s`: the deadline of a `whenever`."""

    bound: Expr
    span: Span = NOWHERE


class Require(Clause):
    """`require FORMULA`; `monitor FORMULA` in an assumption."""

    keyword: str
    condition: Expr
    span: Span = NOWHERE


class Item(Node):
    """A declaration; it starts with its keyword in column 1."""


class ModuleName(Item):
    """`module supervisor.trajectory`."""

    name: str
    span: Span = NOWHERE


class Use(Item):
    """`use vehicles.devbot`."""

    name: str
    span: Span = NOWHERE


class Reference(Item):
    """`reference stahl2020 = "T. Stahl et al. ..."`."""

    name: str
    text: str
    span: Span = NOWHERE


class Range(Node):
    """`in [900, 1400]`, in the unit of what it limits."""

    lower: Expr
    upper: Expr
    span: Span = NOWHERE


class Field(Node):
    """One field of a signal: `kappa: 1/m in [-1, 1]`. `type` is a unit, `polyline`, `bool`, or the name of an enumeration."""

    name: str
    type: str
    increasing: bool = False
    range: Range | None = None
    default: Expr | None = None
    span: Span = NOWHERE


class Signal(Item):
    """`signal plan : trajectory { ... }`; `many` for `set of`, `capacity 32 forget 2 s` of which says how many elements are known, and for how long."""

    name: str
    kind: str
    many: bool
    fields_: tuple[Field, ...]
    capacity: Expr | None = None
    forget: Expr | None = None
    span: Span = NOWHERE


class Course(Item):
    """`course driven = ego for 10 s then plan`: what was driven, as far back as this, and what is planned, as one timeline."""

    name: str
    lived: Name
    bound: Expr
    planned: Name
    span: Span = NOWHERE


class Enum(Item):
    """`enum flag "shown to the car" { green, yellow }`: names of which a field is one."""

    name: str
    text: str
    members: tuple[Member, ...]
    span: Span = NOWHERE


class Event(Item):
    """`event blue_flag "shown to the car"`: a Boolean of each cycle."""

    name: str
    text: str
    span: Span = NOWHERE


class Param(Item):
    """`param mass : kg = 1160 kg in [900, 1400] source "..."`; in a configuration also `limits.response`, a field of a record."""

    name: str
    unit: str
    value: Expr
    range: Range | None = None
    source: str | None = None
    span: Span = NOWHERE


class ParamField(Node):
    """`response: 0.5 s in [0.1, 1] source "..."`: a field of a record of parameters."""

    name: str
    value: Expr
    range: Range | None = None
    source: str | None = None
    span: Span = NOWHERE


class ParamRecord(Item):
    """`param limits : rss_limits = { response: 0.5 s, braking: 4 m/s^2 }`: parameters as one record, by a shape."""

    name: str
    shape: str
    entries: tuple[ParamField, ...]
    span: Span = NOWHERE


class Constrain(Item):
    """`constrain b_rear <= b_front because "..."`: a demand on parameters."""

    condition: Expr
    because: str | None = None
    span: Span = NOWHERE


class Scale(Item):
    """`scale m/s = 5 m/s`: what margins of a dimension are divided by where they meet those of another one."""

    unit: str
    value: Expr
    span: Span = NOWHERE


class Way(Node):
    """`linear clamp`, `step wrap 5000 m`: how a table is read along an argument; outside: clamp, wrap or "", length: of a `wrap`."""

    reading: str
    outside: str = ""
    length: Expr | None = None
    span: Span = NOWHERE


class Second(Node):
    """The second argument of a table, and the row of its knots, `| load: 900 kg, 1400 kg`, which begins with its name."""

    name: str
    unit: str
    label: str
    knots: tuple[Expr, ...]
    span: Span = NOWHERE


class Table(Item):
    """`table ax_max(v: m/s) -> m/s^2 = linear clamp | 0 m/s: 6 m/s^2 | ... |`.

    rows: the knot and its value; of a table of two arguments as many values as the second one has knots. ways: one for all arguments, or
    one each. second: its span is that of the row of knots, or of the argument where there is no such row.
    """

    name: str
    argument: str
    unit: str
    result: str
    rows: tuple[tuple[Expr, ...], ...]
    source: str | None = None
    ways: tuple[Way, ...] = (Way("linear", "clamp"),)
    second: Second | None = None
    span: Span = NOWHERE


class Place(Item):
    """`zone pit_lane = polygon (..) (..)` or `line start_line = (..) (..)`."""

    kind: str
    name: str
    text: str
    points: tuple[tuple[Expr, Expr], ...]
    span: Span = NOWHERE


class Shape(Item):
    """`shape car = vehicle with { lane: 1, braking: bool }`: fields that a record has; base: the shape whose fields it has, too, or ""."""

    name: str
    text: str
    base: str
    fields_: tuple[Field, ...]
    span: Span = NOWHERE


class Stretch(Item):
    """`stretch chicane on track = 4900 m to 120 m`: what lies along a line from one station ahead to another."""

    name: str
    text: str
    line: Expr
    start: Expr
    end: Expr
    span: Span = NOWHERE


class Parameter(Node):
    """A parameter of a definition: a unit (number), a record shape, or a kind of signal; and what it is where nothing is given."""

    name: str
    type: str
    default: Expr | None = None
    span: Span = NOWHERE


class Define(Item):
    """`define f(a: m) -> m = ...` (a number) or `predicate f(a: body) = ...` (a formula)."""

    keyword: str
    name: str
    parameters: tuple[Parameter, ...]
    result: str | None
    body: Expr
    span: Span = NOWHERE


class Assume(Item):
    """An assumption on the inputs, with its monitor."""

    name: str
    title: str
    clauses: tuple[Clause, ...]
    span: Span = NOWHERE


class Rule(Item):
    """A rule: what is demanded, of what, why, and what it traces to."""

    name: str
    title: str
    clauses: tuple[Clause, ...]
    span: Span = NOWHERE


class StateName(Node):
    """One of the states that a machine can be in; `final`: it is never left, and that is meant."""

    name: str
    final: bool = False
    span: Span = NOWHERE


class Keep(Node):
    """`remember entry = station(ego, track)`: a number as it is in the cycle of a transition."""

    name: str
    value: Expr
    span: Span = NOWHERE


class Transition(Node):
    """`becomes offence from neutral, defence when ...`, and what it remembers; no sources: from every other state."""

    target: Name
    sources: tuple[Name, ...]
    condition: Expr
    kept: tuple[Keep, ...] = ()
    span: Span = NOWHERE


class State(Item):
    """`state role : { neutral, offence } for each o in objects starts neutral bridges 1 s becomes ...`: a state machine over the run."""

    name: str
    states: tuple[StateName, ...]
    binder: str
    domain: str
    start: Name
    transitions: tuple[Transition, ...]
    bridges: Expr | None = None
    span: Span = NOWHERE


class Base(Node):
    """`refines a` or `extends a`: the rulebook that another one builds on."""

    how: str
    name: Name
    span: Span = NOWHERE


class Chain(Node):
    """`a & b ~ c > d`: rule names, and the relation after each but the last."""

    names: tuple[Name, ...]
    relations: tuple[str, ...]
    span: Span = NOWHERE


class Rulebook(Item):
    """A pre-order of rules, by itself or on top of another one."""

    name: str
    title: str
    base: Base | None
    chains: tuple[Chain, ...]
    span: Span = NOWHERE


class Change(Node):
    """`v[3] = nan` after `with`, in a test; no index changes the whole column."""

    field: str
    index: str | None
    value: Expr
    span: Span = NOWHERE


class Given(Node):
    """`given plan = arc(radius: 60 m, v: 20 m/s) with v[3] = nan`."""

    name: str
    value: Expr
    changes: tuple[Change, ...] = ()
    span: Span = NOWHERE


class After(Node):
    """`after 3 s`: the next cycle of a run, so long after the one before; what is given below is new in it, everything else stays."""

    time: Expr
    span: Span = NOWHERE


class Expect(Node):
    """`expect satisfied, margin about 4784 N within 1 N, at p = 3`."""

    verdict: str
    margin: Expr | None = None
    tolerance: Expr | None = None
    binder: str | None = None
    at: str | None = None
    span: Span = NOWHERE


class Test(Item):
    """A worked case of one rule: what is given, cycle by cycle, and what is expected in the last one."""

    rule: str
    title: str
    steps: tuple[Given | After, ...]
    expect: Expect
    span: Span = NOWHERE


class Module(Node):
    """A whole file: its declarations in order, and whether it is written with mathematical signs."""

    items: tuple[Item, ...]
    unicode: bool = False
    span: Span = NOWHERE
