"""What operators over the run keep: one memory for each of them, whichever rules it stands in."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import assert_never

from trackmarshal.backends.c.over_run.future import settled, too_many
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import FURTHEST, over_run, parts, recalled, recalls, sets
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.source import Span


@dataclass(frozen=True)
class Cell:
    """The memory of one operator, or of one state machine. kind: which sort of memory it has; axes: the set of whose elements it has one each, or the two
    of whose pairs; none for the run."""

    node: ir.OverRun | ir.Counted | ir.Machine
    kind: str
    c_name: str
    axes: tuple[ir.Axis, ...]

    @property
    def shown(self) -> str:
        """The operator with its window, in words."""
        if isinstance(self.node, ir.Machine):
            return f"state {self.node.name}"
        name = self.kind if isinstance(self.node, ir.OverRun) else "count"
        weak = "weak " if isinstance(self.node, ir.OverRun) and self.node.weak else ""
        bounds = (
            ""
            if self.upper is None and self.lower == 0
            else f"[{self.lower / 1e9:g} s, {_seconds(self.upper)}]"
        )
        return f"{weak}{name}{bounds}"

    @property
    def lower(self) -> int:
        """How many nanoseconds ago its window ends."""
        return 0 if isinstance(self.node, ir.Machine) else self.node.lower or 0

    @property
    def upper(self) -> int | None:
        """How many nanoseconds ago it begins; None: with the run."""
        return None if isinstance(self.node, ir.Machine) else self.node.upper

    @property
    def span(self) -> Span | None:
        return None if isinstance(self.node, ir.Machine) else self.node.span


def _seconds(nanoseconds: int | None) -> str:
    return "..." if nanoseconds is None else f"{nanoseconds / 1e9:g} s"


def kind_of(node: ir.OverRun | ir.Counted | ir.Machine) -> str:
    """The sort of memory that an operator or machine has."""
    if isinstance(node, ir.Machine):
        return "machine"
    if isinstance(node, ir.Counted):
        return "recount" if len(node.operands) > 1 else "count"
    match node.op:
        case "once" | "historically" | "since" | "previous":
            return node.op
        case "always" | "eventually" | "until" | "next":
            raise AssertionError(f"`{node.op}` waits for what will be")
        case _:
            assert_never(node.op)


Holder = ir.OverRun | ir.Counted | ir.Machine


def holders(formula: ir.Formula) -> Iterator[tuple[Holder, Span]]:
    """What in a formula has a memory, each once, with where it is spoken of; what is inside others before them."""
    stack: list[tuple[ir.Formula, bool]] = [(formula, False)]
    seen: set[ir.Formula] = set()
    machines: set[ir.Machine] = set()
    while stack:
        node, ready = stack.pop()
        if not ready:
            if node not in seen:
                seen.add(node)
                stack.append((node, True))
                stack += [(part, False) for part in parts(node) or ()]
            continue
        asked = [one.machine for one in recalled(node)] if recalls(node) else []
        if isinstance(node, (ir.OverRun, ir.Counted)):
            yield node, node.span
        elif isinstance(node, ir.InState):
            asked = [node.machine]
        for machine in asked:
            if machine not in machines:
                machines.add(machine)
                yield machine, getattr(node, "span", None) or _span(machine)


def _span(machine: ir.Machine) -> Span:
    """Where the first part of its guards stands that knows it."""
    spans = (getattr(part, "span", None) for guard in machine.guards for part in ir.below(guard))
    return next(span for span in spans if isinstance(span, Span))


def cells_of(
    rules: Iterable[RuleInfo], same: Callable[[ir.Formula], ir.Formula]
) -> dict[ir.Formula | ir.Machine, Cell]:
    """Memories by their operators and machines, those inside others before them. `same` gives the one node of those that say the same.

    Raises TrackmarshalError E470 for what generated C cannot remember.
    """
    found: dict[ir.Formula | ir.Machine, Cell] = {}
    for rule in rules:
        for root in settled(rule):
            if not over_run(root):
                continue
            for holder, span in holders(root):
                node = holder if isinstance(holder, ir.Machine) else same(holder)
                if node not in found:
                    assert isinstance(node, Holder)
                    why = obstacle(node)
                    if why is not None:
                        raise TrackmarshalError(
                            "E470", f"rule `{rule.name}`: {why}", file=span.file.path, line=span.line,
                            help="choose rules with --rule, or another backend",
                        )  # fmt: skip
                    kind = kind_of(node)
                    found[node] = Cell(node, kind, f"{kind}_{len(found) + 1}", sets(node))
    return found


def obstacle(node: Holder) -> str | None:
    """Why generated C cannot keep what an operator or machine needs; None where it can."""
    if len(sets(node)) > 2:
        return too_many(sets(node))
    if not isinstance(node, ir.Machine) and max(node.lower or 0, node.upper or 0) > FURTHEST:
        return f"the window is longer than {FURTHEST / 1e9:g} s"
    return None


#: Bytes of an item of a window, by the sort of memory.
_BYTES = {"once": 40, "historically": 40, "since": 88, "count": 40, "recount": 40}


#: Of a pair what is known of its life, and its two places; what an operator keeps without items, and how many of these it has room for at any rate.
_PAIR, _CELL, _LEAST = 40, 80, 4


def bytes_of_rate(cells: Iterable[Cell], elements: int, paired: int) -> float:
    """About how many bytes windows take for each cycle a second that they have room for; paired: how many elements a set has of which there are pairs."""
    found = 0.0
    for cell in cells:
        longest = cell.lower if cell.upper is None else cell.upper
        many = elements ** len(cell.axes) if len(cell.axes) < 2 else _pairs(cell, paired)
        found += _BYTES.get(cell.kind, 0) * (longest / 1e9) * many
    return found


def bytes_of_pairs(cells: Iterable[Cell], elements: int) -> int:
    """About how many bytes pairs of elements take, whatever the rate."""
    two = [cell for cell in cells if len(cell.axes) == 2]
    places = len({tuple(axis.signal for axis in cell.axes) for cell in two}) * elements**2
    return _PAIR * places + sum(
        (_CELL + _LEAST * _BYTES.get(cell.kind, 0)) * _pairs(cell, elements) for cell in two
    )


def _pairs(cell: Cell, elements: int) -> int:
    """How many pairs of two sets there may be."""
    return math.prod((axis.capacity or elements) if axis.forget else elements for axis in cell.axes)
