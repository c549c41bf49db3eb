"""What nodes of formulas are used for, before a function is written: how often each is read, and what the spec calls it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from trackmarshal.backends.c.facts import Facts, Value
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import Called


class Usage:
    """How often each node of some formulas is read, and what the spec calls it."""

    def __init__(self, facts: Facts, roots: Iterable[ir.Formula], called: Mapping[ir.IR, Called]) -> None:
        self.readers: dict[Value, int] = {}
        self._facts = facts
        #: Those that the spec has a name for.
        self.own: set[Value] = set()
        names: dict[Value, str] = {}
        stack: list[Value] = list(roots)
        for root in stack:
            self.readers[root] = self.readers.get(root, 0) + 1
        seen: set[Value] = set()
        while stack:
            node = stack.pop()
            if node in seen:
                continue
            seen.add(node)
            name = called.get(node)
            if name is not None and not isinstance(node, _PLAIN):
                names[node] = name.name
                if name.own:
                    self.own.add(node)
            for child in facts.operands(node):
                self.readers[child] = self.readers.get(child, 0) + 1
                stack.append(child)
        several = Counter(names.values())
        #: What the spec calls nodes; those whose name others have, too.
        self.names = names
        self.ambiguous = {node for node, name in names.items() if several[name] > 1}

    def only_in(self, roots: Iterable[Value]) -> frozenset[Value]:
        """The nodes in some, these among them, that are read for them alone. Of what was made beside the rules that is not known."""
        found: set[Value] = set()
        read: Counter[Value] = Counter()
        stack = list(roots)
        while stack:
            node = stack.pop()
            read[node] += 1
            if read[node] == self.readers.get(node):
                found.add(node)
                stack += self._facts.operands(node)
        return frozenset(found)


#: What has a name of its own, whatever else it is called.
_PLAIN = (ir.Const, ir.Param, ir.Column, ir.Sample, ir.Scalar, ir.Truth, ir.Flag)
