"""The nodes of the IR. Numbers are floats in SI units; formulas have a truth and a margin.

Nodes are compared by identity: the interner makes equal numeric nodes one node (`interning`), so that whatever two rules
compute alike is computed once. `Num` and `Formula` are closed unions: an evaluator's `match` over one ends in
`assert_never`, so that mypy names whoever forgets a node, and at run time any other raises AssertionError.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import ClassVar, Literal, NamedTuple, TypeAlias
from weakref import WeakKeyDictionary

from trackmarshal.ir.operators import (
    OVER_RUN,
    QUANTIFIERS,
    TEMPORAL,
    UNTIL,
    ArithmeticOp,
    ComparisonOp,
    ConnectiveOp,
    Extreme,
    FoldOp,
    FunctionName,
    Quantifier,
    RunOp,
    TemporalOp,
    UntilOp,
)
from trackmarshal.node import Node
from trackmarshal.source import Span


class IR(Node):
    """A node of the IR; equal only to itself."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__


class Axis(IR):
    """What a variable ranges over: the samples of a timeline, or the elements of a set.

    `width` consecutive samples are bound at once; `level` is the nesting depth inside the rule, from 0. forget: how long an element of
    the set may be absent and keep its history [ns]; capacity: of how many anything is remembered, None where none is that is absent.
    """

    signal: str
    kind: Literal["samples", "elements"]
    width: int
    level: int
    forget: int = 0
    capacity: int | None = None


# Numbers ------------------------------------------------------------------------------------------------------


class Const(IR):
    """A number of the spec, in SI."""

    value: float


class Param(IR):
    """A parameter, by its qualified name."""

    name: str


class Column(IR):
    """A field of the variable of an axis; `offset` counts samples from the first bound one, clamped at the start."""

    axis: Axis
    field: str
    offset: int = 0


class Sample(IR):
    """A field of one sample of a timeline, by index (-1: the last)."""

    signal: str
    field: str
    index: int


class Scalar(IR):
    """A field of a single record."""

    signal: str
    field: str


class Arith(IR):
    """`+ - * /`, IEEE double, in the order written."""

    op: ArithmeticOp
    left: Num
    right: Num


class Neg(IR):
    """Minus a number."""

    operand: Num


class Func(IR):
    """A built-in function of numbers: see `operators.FUNCTIONS`."""

    name: FunctionName
    args: tuple[Num, ...]


class Choose(IR):
    """One of two numbers by a formula; undefined (NaN) where the formula is."""

    condition: Formula
    then: Num
    otherwise: Num


class Lookup(IR):
    """A table of one argument, read as it is declared; NaN where it has no value."""

    table: str
    argument: Num


class GridLookup(IR):
    """A table of two arguments; NaN where it has no value."""

    table: str
    first: Num
    second: Num


class Ordinal(IR):
    """Which value of its axis the variable has, from 0."""

    axis: Axis


class Fold(IR):
    """One number of all values of an axis for which the guard holds; undefined (NaN) where a guard is.

    sum: in the order of the axis, from 0.0 on. least, greatest: as `min` and `max` of two; `otherwise` where there is none. nearest: the
    ordinal of the first one of which the body is least, NaN where the body of one is not finite; -1 where there is none.
    """

    op: FoldOp
    axis: Axis
    guard: Formula | None
    body: Num
    otherwise: Num | None
    names: tuple[str, ...]


class Line(IR):
    """A polyline: `place` (a `line` of a spec), a field of a signal (`track.left`), or the path of a trajectory."""

    kind: Literal["place", "signal", "path", "centre"]
    name: str
    field: str


class Area(IR):
    """A region: a `zone` of a spec, or a corridor signal."""

    kind: Literal["zone", "corridor"]
    name: str


class Pose(NamedTuple):
    """Where something is and which way it points: m, m, rad."""

    x: Num
    y: Num
    heading: Num


class Station(IR):
    """How far along a line the point nearest to (x, y) is [m]."""

    spoken: ClassVar[str] = "station"
    line: Line
    x: Num
    y: Num


class Offset(IR):
    """How far to the left of a line the point (x, y) is [m]."""

    spoken: ClassVar[str] = "offset"
    line: Line
    x: Num
    y: Num


class Direction(IR):
    """The heading of a line where it is nearest to the point (x, y) [rad]."""

    spoken: ClassVar[str] = "direction"
    line: Line
    x: Num
    y: Num


class Distance(IR):
    """How far from a line the point (x, y) is [m]."""

    spoken: ClassVar[str] = "distance"
    line: Line
    x: Num
    y: Num


class StationGap(IR):
    """How far one station of a line lies ahead of another [m]; on a closed line the shorter way round."""

    spoken: ClassVar[str] = "station_gap"
    line: Line
    start: Num
    end: Num


class StretchRoom(IR):
    """How far inside the stretch of a line from one station ahead to another a station lies, along the line [m]; negative: outside.

    On a closed line a stretch goes on over the finish line, and one that ends where it begins is the whole lap. NaN on an open line
    where `end` is before `start`. name: of its declaration, by which it may be on a certain track; "" without one.
    """

    spoken: ClassVar[str] = "room in a stretch"
    line: Line
    name: str
    station: Num
    start: Num
    end: Num


class OnLane(IR):
    """A number of one of a set of lanes, which is the road between two borders, open at both ends.

    lane: which one, from 0. ends: what it is of, in this order. station, offset, direction: of a point x, y along `side` (a border, or
    the centre); distance: of a point from it; gap: of two stations; room: of a station in a stretch from one to another. inside, meets:
    how far what a box sweeps from one pose to another (x, y, heading of both, length, width, and the curvatures where it follows a
    curve) lies inside the lane, and how far it reaches into it [m].
    """

    what: LaneWhat
    signal: str
    side: LaneSide
    lane: Num
    ends: tuple[Num, ...]

    @property
    def spoken(self) -> str:
        """What messages call it."""
        return _OF_LANE[self.what]


class Kept(IR):
    """A number that a state machine keeps, where it is known: since when it is in its state, as a duration [s], or what it remembers.

    name: of what is remembered; "" for the duration.
    """

    machine: Machine
    name: str


LaneWhat: TypeAlias = Literal["station", "offset", "direction", "distance", "gap", "room", "inside", "meets"]
LaneSide: TypeAlias = Literal["left", "right", "centre"]
_OF_LANE: dict[LaneWhat, str] = {
    "station": "station", "offset": "offset", "direction": "direction", "distance": "distance", "gap": "station_gap",
    "room": "room in a stretch", "inside": "room inside", "meets": "reach into",
}  # fmt: skip
#: What is written of a comparison that was turned round.
_TURNED: dict[str, str] = {"<": ">", "<=": ">="}


# Formulas: something true, false or undefined, with a margin --------------------------------------------------


class Truth(IR):
    """`true`, `false`."""

    value: bool


class Flag(IR):
    """A Boolean of the input: an event (no field), a field of a record, or of the variable of an axis.

    offset: from the first bound sample; without an axis, of which sample of a timeline (0: the first, -1: the last).
    """

    signal: str
    field: str | None
    axis: Axis | None
    offset: int
    span: Span


class Compare(IR):
    """A comparison; `unit` is the SI unit of its margin, `shown` the one in which its limit is written ("": in SI).

    turned: it is written the other way round, `right > left`, which only what shows it has to know.
    """

    op: ComparisonOp
    left: Num
    right: Num
    unit: str
    span: Span
    shown: str = ""
    turned: bool = False

    @property
    def written(self) -> tuple[str, Num, Num]:
        """Operator and sides as they are written."""
        return (_TURNED[self.op], self.right, self.left) if self.turned else (self.op, self.left, self.right)


# Geometric predicates: the margin is a signed distance in metres, and they hold where that is not negative.


class SweptInside(IR):
    """What a box of a length and a width sweeps from one pose to another lies in an area.

    bend: the curvatures at both poses [1/m], where it follows a curve; empty where it goes straight.
    """

    start: Pose
    end: Pose
    length: Num
    width: Num
    bend: tuple[Num, ...]
    area: Area
    span: Span


class SweptClear(IR):
    """What a box of a length and a width sweeps from one pose to another keeps clear of another box, which stands; `bend` as above."""

    start: Pose
    end: Pose
    length: Num
    width: Num
    box: Pose
    box_length: Num
    box_width: Num
    bend: tuple[Num, ...]
    span: Span


class InArea(IR):
    """The point (x, y) lies in an area."""

    x: Num
    y: Num
    area: Area
    span: Span


class Not(IR):
    """The denial of a formula."""

    operand: Formula


class Scaled(IR):
    """A comparison or a geometric predicate that holds as it is, with a margin divided by the scale of its dimension, a number above 0."""

    operand: Formula
    scale: float


class Connective(IR):
    """and, or, iff, xor."""

    op: ConnectiveOp
    left: Formula
    right: Formula


class Quantify(IR):
    """`for all` or `exists` over an axis; elements whose guard does not hold are not in its range."""

    quantifier: Quantifier
    axis: Axis
    guard: Formula | None
    body: Formula
    names: tuple[str, ...]

    @property
    def extreme(self) -> Extreme:
        return QUANTIFIERS[self.quantifier]


class Guarded(IR):
    """`whenever guard require body`: only the cycles in which the guard holds count."""

    guard: Formula
    body: Formula


class Temporal(IR):
    """always, eventually (future), historically, once (past), along an axis; no bounds means to the end."""

    op: TemporalOp
    axis: Axis
    operand: Formula
    lower: float | None
    upper: float | None

    @property
    def extreme(self) -> Extreme:
        return TEMPORAL[self.op].extreme

    @property
    def past(self) -> bool:
        return TEMPORAL[self.op].past


class Until(IR):
    """until (future), since (past), along an axis."""

    op: UntilOp
    axis: Axis
    left: Formula
    right: Formula
    lower: float | None
    upper: float | None

    @property
    def past(self) -> bool:
        return UNTIL[self.op]


class Shift(IR):
    """next (step 1), previous (step -1); weak ones hold outside the trace."""

    axis: Axis
    operand: Formula
    step: Literal[1, -1]
    weak: bool


class Tallied(IR):
    """At how many samples of a timeline a formula held, up to this one, compared with a number that no input changes.

    reset: what the count starts anew with, if anything. upper: how far back [s]; None: from the first sample. turned: the number stands at the left.
    """

    axis: Axis
    op: ComparisonOp
    counted: Formula
    reset: Formula | None
    upper: float | None
    limit: Num
    turned: bool
    span: Span

    past: ClassVar[bool] = True
    lower: ClassVar[None] = None


class At(IR):
    """The value at the sample of a timeline at which a rule is judged: the first one, the last one, or the one that is now."""

    axis: Axis
    name: str
    operand: Formula
    place: JudgedAt


class OverRun(IR):
    """A temporal operator over the run, cycle by cycle; its history is that of the elements which its operands are about.

    operands: one, or two of `until` and `since`. lower, upper: the bounds of its window, in whole nanoseconds; None: from now, to the
    end (start) of the run. weak: `next` and `previous` that hold where there is no such cycle.
    """

    op: RunOp
    operands: tuple[Formula, ...]
    lower: int | None
    upper: int | None
    weak: bool
    span: Span

    @property
    def past(self) -> bool:
        return OVER_RUN[self.op]


class Counted(IR):
    """In how many cycles of the run a formula held, up to now, compared with a number that no input changes.

    operands: what is counted and, where there is such, what the count starts anew with. upper: how far back, in whole nanoseconds; None: from the
    start of the run. turned: the number stands at the left.
    """

    op: ComparisonOp
    operands: tuple[Formula, ...]
    upper: int | None
    limit: Num
    turned: bool
    span: Span

    past: ClassVar[bool] = True
    lower: ClassVar[None] = None


class Machine(IR):
    """A state machine over the run, or one for each element of a set: the states that it can be in, the one that it starts in, and what
    leads from one to another.

    axis: of the variable that stands for the element; None: there is one machine. targets, sources, guards: the transitions in the order in
    which they are looked at, in every cycle: where each leads, from which states, and when. kept: by which transition a number is remembered,
    and its name; numbers: as many, each as it is in the cycle of the transition. bridges: a gap of up to so many nanoseconds, from stamp to
    stamp, leaves it as it was.
    """

    name: str
    axis: Axis | None
    states: tuple[str, ...]
    start: str
    targets: tuple[str, ...]
    sources: tuple[tuple[str, ...], ...]
    guards: tuple[Formula, ...]
    kept: tuple[tuple[int, str], ...]
    numbers: tuple[Num, ...]
    bridges: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """What it remembers."""
        return tuple(dict.fromkeys(name for _, name in self.kept))


class InState(IR):
    """A state machine is in a state, after what the present cycle made of it."""

    machine: Machine
    state: str
    span: Span

    past: ClassVar[bool] = True
    lower: ClassVar[None] = None
    upper: ClassVar[None] = None

    @property
    def operands(self) -> tuple[Formula, ...]:
        """What decides which state it is in, in every cycle."""
        return self.machine.guards


#: What a projection of a point onto a line gives.
Projected: TypeAlias = Station | Offset | Direction
#: Numbers read off a line.
Along: TypeAlias = Station | Offset | Direction | Distance | StationGap | StretchRoom
#: A number.
Num: TypeAlias = (
    Const | Param | Column | Sample | Scalar | Arith | Neg | Func | Choose | Lookup | GridLookup
    | Station | Offset | Direction | Distance | StationGap | StretchRoom | OnLane | Ordinal | Fold | Kept
)  # fmt: skip
#: Geometric predicates.
Geometry: TypeAlias = SweptInside | SweptClear | InArea
#: Formulas over the run.
Remembered: TypeAlias = OverRun | Counted | InState
#: Formulas along a timeline.
Timed: TypeAlias = Temporal | Until | Shift
#: A formula.
Formula: TypeAlias = (
    Truth | Flag | Compare | SweptInside | SweptClear | InArea | Scaled | Not | Connective | Quantify | Guarded
    | Temporal | Until | Shift | Tallied | At | OverRun | Counted | InState
)  # fmt: skip
#: Any node.
AnyNode: TypeAlias = Num | Formula | Axis | Line | Area | Machine

#: Nodes that have no value of their own: what others are about.
_SUBJECTS = (Axis, Line, Area, Machine)

#: Where along a timeline a rule is judged.
JudgedAt: TypeAlias = Literal["first", "last", "now"]


def operands(node: IR) -> list[Num | Formula]:
    """The numbers and formulas directly in a node, in order."""
    return [child for child in node.children() if not isinstance(child, _SUBJECTS)]  # type: ignore[misc]


#: What is below a node, without itself, as long as it is there: nodes do not change, and those of rules are gone through again and again.
_BELOW: WeakKeyDictionary[IR, tuple[AnyNode, ...]] = WeakKeyDictionary()


def below(root: AnyNode) -> Iterator[AnyNode]:
    """A node and all below it, each shared one once."""
    found = _BELOW.get(root)
    if found is None:
        found = _BELOW[root] = tuple(islice(walked(root), 1, None))
    yield root
    yield from found


def walked(root: AnyNode) -> Iterator[AnyNode]:
    """The same for whoever stops at the first that it looks for: nothing is kept."""
    seen: set[AnyNode] = set()
    stack: list[AnyNode] = [root]
    while stack:
        node = stack.pop()
        if node not in seen:
            seen.add(node)
            yield node
            stack.extend(child for child in node.children() if isinstance(child, IR))  # type: ignore[misc]


def ordered(roots: Iterable[Num | Formula]) -> list[Num | Formula]:
    """All numbers and formulas below roots, children first; iterative, so depth is no limit."""
    done: dict[Num | Formula, None] = {}
    stack = [(root, False) for root in reversed(list(roots))]
    while stack:
        node, ready = stack.pop()
        if node in done:
            continue
        if ready:
            done[node] = None
        else:
            stack.append((node, True))
            stack.extend((child, False) for child in reversed(operands(node)))
    return list(done)
