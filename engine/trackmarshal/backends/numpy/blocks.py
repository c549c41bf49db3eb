"""Which nodes matter only where the guard of one formula holds: where that is nowhere in a batch, nobody works them out.

Of what a guard leaves out nothing counts, in the worst case and in the best one: whether it is undefined does not either.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from trackmarshal.ir import nodes as ir

Node = ir.Num | ir.Formula
Guarding = ir.Quantify | ir.Guarded
#: Fewer nodes than this are worked out about as fast as it is asked whether anybody needs them.
FEW = 4


def blocks(
    nodes: Sequence[Node], roots: Iterable[ir.Formula], same: Mapping[Node, Node]
) -> tuple[dict[Node, Guarding], dict[Node, frozenset[Guarding]]]:
    """By node the outermost formula with a guard without whose body nobody asks for it; and of numbers that several such formulas ask for, and
    nobody else, all of them: each works them out for itself. Nodes that others ask for are left out.

    nodes: children first, none computed like another one. roots: formulas that are asked for whatever holds. same: of every node the one
    of `nodes` that is computed alike.
    """
    asking: dict[Node, set[Guarding | None]] = {same[root]: {None} for root in roots}
    found: dict[Node, Guarding] = {}
    shared: dict[Node, frozenset[Guarding]] = {}
    for node in reversed(nodes):
        askers = frozenset(one for one in asking.get(node, {None}) if one is not None)
        outside = None in asking.get(node, {None})
        if not outside and len(askers) == 1:
            (found[node],) = askers
        elif not outside and isinstance(node, ir.Num):
            shared[node] = askers
        by: Iterable[Guarding | None] = shared.get(node) or (found.get(node),)
        body = None
        if isinstance(node, (ir.Quantify, ir.Guarded)) and node.guard is not None and not _around(node):
            body = same[node.body]
            asking.setdefault(body, set()).add(found.get(node, node))
        for child in ir.operands(node):
            if same[child] is not body or child is getattr(node, "guard", None):
                asking.setdefault(same[child], set()).update(by)
    sizes = Counter([*found.values(), *(top for tops in shared.values() for top in tops)])
    return (
        {node: top for node, top in found.items() if sizes[top] >= FEW},
        {node: tops for node, tops in shared.items() if all(sizes[top] >= FEW for top in tops)},
    )


def _around(node: Guarding) -> bool:
    """Whether a `whenever` is right around a quantifier that asks of elements: of driving and emergency trajectories in one batch it holds
    somewhere, and who is meant is mostly nobody."""
    return isinstance(node, ir.Guarded) and isinstance(node.body, ir.Quantify) and node.body.guard is not None


def together(
    nodes: Sequence[Node], within: Mapping[Node, Guarding], shared: Mapping[Node, frozenset[Guarding]]
) -> list[Node]:
    """The same nodes, children first still, in which those of a block stand in a row right before its formula; what blocks share, in each."""
    members: dict[Node, list[Node]] = {}
    for node in nodes:
        for top in shared.get(node) or ((within[node],) if node in within else ()):
            members.setdefault(top, []).append(node)
    return [
        each
        for node in nodes
        if node not in within and node not in shared
        for each in (*members.get(node, ()), node)
    ]
