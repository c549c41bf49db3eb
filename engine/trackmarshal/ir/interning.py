"""Makes nodes of the core such that whatever is computed alike is one node."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

from trackmarshal.ir import nodes as ir

T = TypeVar("T")
Parts = ParamSpec("Parts")


class Interner:
    """Makes nodes; numeric nodes and axes with equal parts are the same node."""

    def __init__(self) -> None:
        self._known: dict[tuple[Any, ...], ir.IR] = {}
        self._depths: dict[ir.Num | ir.Formula, int] = {}

    def make(self, kind: Callable[Parts, T], *parts: Parts.args, **named: Parts.kwargs) -> T:
        """A node of a class, with all of its fields: in order, or by name."""
        whole: tuple[Any, ...] = parts
        if named:
            rest = cast("type[ir.IR]", kind).fields[len(parts) :]
            if len(rest) != len(named):
                raise AssertionError(f"{rest} are to be given, not {[*named]}")
            whole = (*parts, *(named[name] for name in rest))
        # repr tells -0.0 from 0.0 and joins equal NaNs; children are interned, so identity is equality.
        key = (kind, *[repr(part) if type(part) is float else part for part in whole])
        known = self._known.get(key)
        if known is None:
            known = self._known[key] = cast("type[ir.IR]", kind)(*whole)
        return known  # type: ignore[return-value]

    def depth(self, root: ir.Num | ir.Formula) -> int:
        """How many nodes stand in each other; iterative, since that is what may be too much."""
        depths = self._depths
        stack = [(root, ir.operands(root))]
        while stack:
            node, parts = stack[-1]
            waiting = [(part, ir.operands(part)) for part in parts if part not in depths]
            if waiting:
                stack += waiting
            else:
                depths[node] = 1 + max((depths[part] for part in parts), default=0)
                stack.pop()
        return depths[root]
