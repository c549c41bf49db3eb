"""Which nodes matter only where the guard of one formula holds: where that is nowhere in a batch, nobody works them out.

Of what a guard leaves out nothing counts, in the worst case and in the best one: whether it is undefined does not either.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from trackmarshal.ir import nodes as ir

Node = ir.Num | ir.Formula
Guarding = ir.Quantify | ir.Guarded
#: Fewer nodes than this are worked out about as fast as it is asked whether anybody needs them.
FEW = 4


def blocks(
    nodes: Sequence[Node], roots: Iterable[ir.Formula], same: Mapping[Node, Node]
) -> dict[Node, Guarding]:
    """By node the outermost formula with a guard without whose body nobody asks for it; nodes that others ask for are left out.

    nodes: children first, none computed like another one. roots: formulas that are asked for whatever holds. same: of every node the one
    of `nodes` that is computed alike.
    """
    asking: dict[Node, set[Guarding | None]] = {same[root]: {None} for root in roots}
    found: dict[Node, Guarding] = {}
    for node in reversed(nodes):
        within, *others = asking.get(node, {None})
        if within is not None and not others:
            found[node] = within
        body = None
        if isinstance(node, (ir.Quantify, ir.Guarded)) and node.guard is not None and not _around(node):
            body = same[node.body]
            asking.setdefault(body, set()).add(found.get(node, node))
        for child in ir.operands(node):
            if same[child] is not body or child is getattr(node, "guard", None):
                asking.setdefault(same[child], set()).add(found.get(node))
    sizes: dict[Guarding, int] = {}
    for top in found.values():
        sizes[top] = sizes.get(top, 0) + 1
    return {node: top for node, top in found.items() if sizes[top] >= FEW}


def _around(node: Guarding) -> bool:
    """Whether a `whenever` is right around a quantifier that asks of elements: of driving and emergency trajectories in one batch it holds
    somewhere, and who is meant is mostly nobody."""
    return isinstance(node, ir.Guarded) and isinstance(node.body, ir.Quantify) and node.body.guard is not None


def together(nodes: Sequence[Node], within: Mapping[Node, Guarding]) -> list[Node]:
    """The same nodes, children first still, in which those of a block stand in a row right before its formula."""
    members: dict[Node, list[Node]] = {}
    for node in nodes:
        if node in within:
            members.setdefault(within[node], []).append(node)
    return [each for node in nodes if node not in within for each in (*members.get(node, ()), node)]
