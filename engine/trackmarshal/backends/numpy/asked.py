"""Which margins of swept footprints somebody takes: of many a `for all` takes only the least, and the rest is not worked out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from trackmarshal.backends.numpy.blocks import Node
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme


class Asked(NamedTuple):
    """Who asks for a margin: by which axes, under which guards; and the formulas on the way to whoever asks for the least, from the margin's on."""

    axes: tuple[ir.Axis, ...]
    guards: tuple[ir.Formula, ...]
    partly: tuple[Node, ...]
    #: What it stands beside in an `or`: of both margins the greater one is asked for.
    floors: tuple[ir.Formula, ...]
    #: Whether the least margin of a case is all that is asked.
    by_case: bool


def of_least(
    made_of: Mapping[Node, Sequence[Node]], roots: Iterable[ir.Formula], same: Mapping[Node, Node]
) -> dict[ir.IR, ir.Axis]:
    """Swept footprints in an area that one `for all` asks for and nobody else, with its axis.

    made_of: of all nodes what they are computed of. same: of every node the one that is computed alike.
    """
    uses = _uses(made_of, roots, same)
    return {
        same[node.body]: node.axis
        for node in made_of
        if isinstance(node, ir.Quantify) and node.extreme is Extreme.LEAST and node.guard is None
        if isinstance(node.body, ir.SweptInside)
        if uses[same[node.body]] == 1
    }


def of_some(
    made_of: Mapping[Node, Sequence[Node]], roots: Iterable[ir.Formula], same: Mapping[Node, Node]
) -> dict[ir.IR, Asked]:
    """Swept footprints that keep clear of a box, which a `for all` asks for and nobody else; parameters as above."""
    uses = _uses(made_of, roots, same)
    users = {child: node for node, children in made_of.items() for child in children}
    found: dict[ir.IR, Asked] = {}
    for node in made_of:
        if not isinstance(node, ir.SweptClear):
            continue
        axes, guards, partly = list[ir.Axis](), list[ir.Formula](), list[Node]()
        at: Node = node
        floors, least = list[ir.Formula](), True
        while uses[at] == 1:
            user = users.get(at)
            if isinstance(user, ir.Connective):
                least = least and user.op in ("and", "or")  # these grow with each of their parts
                if user.op == "or":
                    floors.append(user.right if same[user.left] is at else user.left)
            elif isinstance(user, ir.Quantify) and user.extreme is Extreme.LEAST and same[user.body] is at:
                axes.append(user.axis)
            elif not (isinstance(user, ir.Guarded) and same[user.body] is at):
                break
            if isinstance(user, (ir.Quantify, ir.Guarded)) and user.guard is not None:
                guards.append(user.guard)
            partly.append(at)
            at = user
        if axes:
            varying = {below for below in ir.below(node) if isinstance(below, ir.Axis)}
            by_case = least and varying.issubset(axes)
            found[node] = Asked(tuple(axes), tuple(guards), tuple(partly), tuple(floors), by_case)
    return found


def _uses(
    made_of: Mapping[Node, Sequence[Node]], roots: Iterable[ir.Formula], same: Mapping[Node, Node]
) -> Counter[Node]:
    """How often each node is asked for, by others or as a root."""
    uses = Counter(child for children in made_of.values() for child in children)
    uses.update(same[root] for root in roots)
    return uses
