"""Which nodes of rules are computed alike: they share one variable, wherever in the rules they stand."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import Any

from trackmarshal.ir import nodes as ir

#: Fields that say how a value is shown, not what it is. Of all others, also of those that a node gets one day, a difference counts;
#: spans are never compared.
_SHOWN = {"unit", "shown", "names"}
#: Nodes of which `name`, too, is that of a variable; of all others it says what is read.
_CALLED = ir.At


def representatives(nodes: Iterable[ir.Num | ir.Formula]) -> dict[ir.Num | ir.Formula, ir.Num | ir.Formula]:
    """For each of some nodes, given children first, the first one that is computed alike.

    What a body sweeps beside others is nobody's but its own: each rule asks for it under guards of its own, which leave most of it out.
    """
    same: dict[ir.Num | ir.Formula, ir.Num | ir.Formula] = {}
    known: dict[Hashable, ir.Num | ir.Formula] = {}
    for node in nodes:
        parts = [
            _key(getattr(node, field), same)
            for field in node.compared
            if field not in _SHOWN and not (field == "name" and isinstance(node, _CALLED))
        ]
        alone = isinstance(node, ir.SweptClear)
        same[node] = node if alone else known.setdefault((type(node), *parts), node)
    return same


def _key(part: Any, same: Mapping[Any, ir.IR]) -> Hashable:
    """What a field has in common with fields that say the same."""
    if isinstance(part, tuple):
        return tuple(_key(item, same) for item in part)
    if isinstance(part, ir.IR):
        return same.get(part, part)
    # repr tells -0.0 from 0.0 and joins equal NaNs; True equals 1, but is not the same.
    return type(part), repr(part) if isinstance(part, float) else part
