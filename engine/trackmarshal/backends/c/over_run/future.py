"""What rules that look ahead keep: the last cycles, with the values of all that was settled in them, until nothing can change what is said of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from trackmarshal.backends.over_run.history import parts_ahead
from trackmarshal.backends.over_run.outcome import is_ahead
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import ahead, back, leaves, looks_ahead, sets
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.source import Span


@dataclass(frozen=True)
class Table:
    """The values of a formula about each of the last cycles; axes: the set of whose elements it has one each, or the two of whose pairs; none for the
    run."""

    node: ir.Formula
    c_name: str
    axes: tuple[ir.Axis, ...]


@dataclass(frozen=True)
class Operator:
    """An operator over what looks ahead, or that does so itself: the table of its values, and those of its operands."""

    table: Table
    operands: tuple[Table, ...]

    @property
    def node(self) -> ir.OverRun | ir.Counted:
        assert isinstance(self.table.node, ir.OverRun | ir.Counted)
        return self.table.node


@dataclass
class Future:
    """Everything that is kept for rules that look ahead, by the nodes of the formulas."""

    rules: list[RuleInfo] = field(default_factory=list)
    leaves: dict[ir.Formula, Table] = field(default_factory=dict)
    #: Those inside others before them.
    operators: dict[ir.Formula, Operator] = field(default_factory=dict)
    #: Operands of operators that are neither of these, but put together from them.
    given: dict[ir.Formula, Table] = field(default_factory=dict)
    #: How long after a cycle it may still change what is said of it, and how far before the oldest such one anything is looked at [ns].
    reach: int = 0
    back: int = 0
    #: Cycles that are kept for `previous`, and those that `next` waits for.
    steps: int = 0
    waits: int = 0

    def table(self, node: ir.Formula) -> Table | None:
        """The table of a formula; None where it is put together from others."""
        if node in self.operators:
            return self.operators[node].table
        return self.leaves.get(node) or self.given.get(node)

    @property
    def tables(self) -> list[Table]:
        return [
            *self.leaves.values(),
            *self.given.values(),
            *(each.table for each in self.operators.values()),
        ]

    @property
    def sets(self) -> list[str]:
        """Signals of whose elements it is kept which were there: those that tables are about, and that quantifiers go through."""
        found = dict.fromkeys(axis.signal for table in self.tables for axis in table.axes)
        for rule in self.rules:
            for root in rule.roots:
                for node in ir.below(root):
                    if isinstance(node, ir.Quantify) and looks_ahead(node):
                        found.setdefault(node.axis.signal)
        return list(found)

    @property
    def pairs(self) -> list[tuple[ir.Axis, ...]]:
        """The pairs of sets of whose elements tables are about both."""
        return [axes for axes in dict.fromkeys(table.axes for table in self.tables) if len(axes) == 2]

    def bytes_of_rate(self, elements: int) -> float:
        """About how many bytes are kept for each cycle a second that there is room for."""
        each = sum(112 * elements ** len(table.axes) for table in self.tables)
        each += 2 * (elements * len(self.sets) + elements**2 * len(self.pairs))
        return float(16 + 2 * len(self.rules) + each) * (self.reach + self.back) / 1e9

    @property
    def room(self) -> str:
        """C of how many cycles there is room for."""
        longest = math.ceil((self.reach + self.back) / 1e6)
        return f"(TM_CYCLES_IN(UINT64_C({longest})) + {self.steps + self.waits + 2}u)"


def settled(rule: RuleInfo) -> Iterable[ir.Formula]:
    """The largest formulas of a rule that are settled in their own cycles."""
    for root in rule.roots:
        yield from leaves(root, parts_ahead)


def future_of(rules: Iterable[RuleInfo], same: Callable[[ir.Formula], ir.Formula]) -> Future:
    """What rules need that look ahead. `same` gives the one node of those that say the same.

    Raises TrackmarshalError E470 for what generated C does not keep.
    """
    found = Future([rule for rule in rules if is_ahead(rule)])
    for rule in found.rules:
        for root in rule.roots:
            formula = same(root)
            reach = ahead(formula)
            assert reach is not None, "what looks ahead without a bound is refused before"
            own, steps = back(formula)
            found.reach, found.back = max(found.reach, reach), max(found.back, own)
            found.steps = max(found.steps, steps)
            found.waits = max(found.waits, sum(_waits(node) for node in ir.below(formula)))
            _collect(found, rule, formula)
    return found


def _waits(node: ir.AnyNode) -> bool:
    return isinstance(node, ir.OverRun) and node.op == "next"


def _collect(found: Future, rule: RuleInfo, formula: ir.Formula) -> None:
    """Tables for all in a formula, what is inside others before them."""
    stack: list[tuple[ir.Formula, bool]] = [(formula, False)]
    done: set[ir.Formula] = set()
    while stack:
        node, ready = stack.pop()
        below = parts_ahead(node)
        if below is None:
            if node not in found.leaves:
                found.leaves[node] = Table(node, f"leaf_{len(found.leaves) + 1}", _axes(rule, node))
        elif ready:
            if isinstance(node, ir.OverRun | ir.Counted) and node not in found.operators:
                operands = tuple(_operand(found, rule, each) for each in node.operands)
                table = Table(node, f"{_kind(node)}_ahead_{len(found.operators) + 1}", _axes(rule, node))
                found.operators[node] = Operator(table, operands)
        elif node not in done:
            done.add(node)
            if isinstance(node, ir.Counted) and (node.upper is None or len(node.operands) > 1):
                raise _refused(rule, node, "generated C counts what looks ahead in windows alone")
            stack.append((node, True))
            stack += [(part, False) for part in below]


def _operand(found: Future, rule: RuleInfo, node: ir.Formula) -> Table:
    known = found.table(node)
    if known is None:
        known = found.given[node] = Table(node, f"given_{len(found.given) + 1}", _axes(rule, node))
    return known


def _axes(rule: RuleInfo, node: ir.Formula) -> tuple[ir.Axis, ...]:
    axes = sets(node)
    if len(axes) > 2:
        raise _refused(rule, node, too_many(axes))
    return axes


def too_many(axes: tuple[ir.Axis, ...]) -> str:
    """Why generated C keeps nothing for the elements of so many sets."""
    return f"generated C has memory for elements and pairs of them, and not for each {len(axes)} of them"


def _kind(node: ir.OverRun | ir.Counted) -> str:
    return node.op if isinstance(node, ir.OverRun) else "count"


def _refused(rule: RuleInfo, node: ir.Formula, why: str) -> TrackmarshalError:
    span = getattr(node, "span", None)
    place = span if isinstance(span, Span) else rule.span
    return TrackmarshalError(
        "E470", f"rule `{rule.name}`: {why}", file=place.file.path, line=place.line,
        help="choose rules with --rule, or another backend",
    )  # fmt: skip
