"""What operators over the run keep: one memory for each of them, whichever rules it stands in."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import assert_never

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import over_run, parts, sets
from trackmarshal.ir.spec import RuleInfo

#: Times of generated C are whole nanoseconds in 64 bits; stamps and windows stay below this, so that their sums fit.
MOST_NANOSECONDS = 4_000_000_000_000_000_000


@dataclass(frozen=True)
class Kept:
    """The memory of one operator. kind: which sort of memory it has; axis: the set of whose elements it has one each, None for the run."""

    node: ir.Remembered
    kind: str
    c_name: str
    axis: ir.Axis | None

    @property
    def shown(self) -> str:
        """The operator with its window, in words."""
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
        return self.node.lower or 0

    @property
    def upper(self) -> int | None:
        """How many nanoseconds ago it begins; None: with the run."""
        return self.node.upper


def _seconds(nanoseconds: int | None) -> str:
    return "..." if nanoseconds is None else f"{nanoseconds / 1e9:g} s"


def kind_of(node: ir.Remembered) -> str:
    """The sort of memory that an operator has."""
    if isinstance(node, ir.Counted):
        return "recount" if len(node.operands) > 1 else "count"
    match node.op:
        case "once" | "historically" | "since" | "previous":
            return node.op
        case "always" | "eventually" | "until" | "next":
            raise AssertionError(f"`{node.op}` waits for what will be")
        case _:
            assert_never(node.op)


def remembered(formula: ir.Formula) -> Iterator[ir.Remembered]:
    """The operators over the run in a formula, those inside others before them."""
    stack: list[tuple[ir.Formula, bool]] = [(formula, False)]
    seen: set[ir.Formula] = set()
    while stack:
        node, ready = stack.pop()
        if ready:
            if isinstance(node, ir.Remembered):
                yield node
            continue
        if node in seen:
            continue
        seen.add(node)
        stack.append((node, True))
        stack += [(part, False) for part in parts(node) or ()]


def kept_by(rules: Iterable[RuleInfo], same: Callable[[ir.Formula], ir.Formula]) -> dict[ir.Formula, Kept]:
    """Memories by their operators, those inside others before them. `same` gives the one node of those that say the same.

    Raises TrackmarshalError E470 for what generated C cannot remember.
    """
    found: dict[ir.Formula, Kept] = {}
    for rule in rules:
        for root in (rule.formula, rule.active):
            if root is None or not over_run(root):
                continue
            for each in remembered(root):
                node = same(each)
                if node not in found:
                    assert isinstance(node, ir.Remembered)
                    why = obstacle(node)
                    if why is not None:
                        raise TrackmarshalError(
                            "E470", f"rule `{rule.name}`: {why}", file=each.span.file.path, line=each.span.line,
                            help="choose rules with --rule, or another backend",
                        )  # fmt: skip
                    kind, axes = kind_of(node), sets(node)
                    found[node] = Kept(node, kind, f"{kind}_{len(found) + 1}", axes[0] if axes else None)
    return found


def obstacle(node: ir.Remembered) -> str | None:
    """Why generated C cannot keep what an operator needs; None where it can."""
    if any(isinstance(part, ir.Remembered) and not part.past for part in ir.below(node)):
        return "generated C does not wait for what will be"
    if len(sets(node)) > 1:
        return "generated C keeps no memory for each pair of elements"
    if max(node.lower or 0, node.upper or 0) > MOST_NANOSECONDS:
        return f"the window is longer than {MOST_NANOSECONDS / 1e9:g} s"
    return None
