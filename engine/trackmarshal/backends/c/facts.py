"""What is so of nodes of formulas, whoever asks: what they are made of, along which axes they depend, and which of them say the same."""

from __future__ import annotations

from typing import Any

from trackmarshal.ir import nodes as ir

#: What both have: numbers and formulas.
Value = ir.Num | ir.Formula


class Facts:
    """What does not depend on who asks: the operands of nodes, and the axes whose variables they depend on."""

    def __init__(self) -> None:
        self._operands: dict[Value, list[Value]] = {}
        self._free: dict[Value, frozenset[ir.Axis]] = {}
        self._asks: dict[Value, bool] = {}

    def operands(self, node: Value) -> list[Value]:
        """The numbers and formulas directly in a node."""
        found = self._operands.get(node)
        if found is None:
            own = (
                [*node.machine.guards, *node.machine.numbers]
                if isinstance(node, ir.InState | ir.Kept)
                else []
            )
            found = self._operands[node] = [*ir.operands(node), *own]
        return found

    def free(self, node: Value) -> frozenset[ir.Axis]:
        """The axes whose variables a node depends on."""
        found = self._free.get(node)
        if found is None:
            found = self._free[node] = self._free_of(node)
        return found

    def _free_of(self, node: Value) -> frozenset[ir.Axis]:
        match node:
            case ir.Column():
                return frozenset([node.axis])
            case ir.Flag():
                return frozenset() if node.axis is None else frozenset([node.axis])
            case ir.InState() | ir.Kept():
                return frozenset() if node.machine.axis is None else frozenset([node.machine.axis])
            case ir.Quantify():
                inner = self.free(node.body) | (frozenset() if node.guard is None else self.free(node.guard))
                return inner - {node.axis}
            case ir.Ordinal():
                return frozenset([node.axis])
            case ir.Fold():
                inner = self.free(node.body) | (frozenset() if node.guard is None else self.free(node.guard))
                outer = frozenset() if node.otherwise is None else self.free(node.otherwise)
                return (inner - {node.axis}) | outer
            case ir.At():
                return self.free(node.operand) - {node.axis}
            case ir.Temporal() | ir.Shift():
                return self.free(node.operand) | {node.axis}
            case ir.Tallied():
                own = frozenset[ir.Axis]().union(*map(self.free, self.operands(node)))
                return own | {node.axis}
            case ir.Until():
                return self.free(node.left) | self.free(node.right) | {node.axis}
            case _:  # nodes that bind no axis
                result: frozenset[ir.Axis] = frozenset()
                for child in self.operands(node):
                    result |= self.free(child)
                return result

    def asks(self, node: Value) -> bool:
        """Whether a number depends on a formula; formulas do."""
        if not isinstance(node, ir.Num):
            return True
        found = self._asks.get(node)
        if found is None:
            found = self._asks[node] = any(self.asks(child) for child in self.operands(node))
        return found


class Same:
    """Makes of nodes that say the same, in other places of the spec, one node: the first one, so that it is computed once.

    The interner does so for numbers, but formulas know their places, and numbers may depend on formulas.
    """

    def __init__(self, facts: Facts) -> None:
        self._facts = facts
        self._known: dict[tuple[object, ...], Value] = {}
        self._same: dict[Value, Value] = {}

    def formula(self, node: ir.Formula) -> ir.Formula:
        """The formula that says what one says."""
        found = self.of(node)
        assert not isinstance(found, ir.Num)
        return found

    def of(self, node: Value) -> Value:
        """The node that says what one says."""
        if not self._facts.asks(node):
            return node
        found = self._same.get(node)
        if found is None:
            found = self._same[node] = self._made(node)
        return found

    def _made(self, node: Value) -> Value:
        before = [node.__dict__[name] for name in node.fields]
        parts = [self._part(value) for value in before]
        told = _TURNED if isinstance(node, ir.Compare) else _TOLD
        said = [part for name, part in zip(node.fields, parts) if name not in told]
        key = (type(node), *(repr(part) if isinstance(part, float) else part for part in said))
        found = self._known.get(key)
        if found is None:
            changed = any(part is not value for part, value in zip(parts, before))
            found = self._known[key] = type(node)(*parts) if changed else node
        return found

    def _part(self, value: Any) -> Any:
        if isinstance(value, tuple):
            parts = [self._part(each) for each in value]
            if all(part is each for part, each in zip(parts, value)):
                return value
            return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
        return self.of(value) if isinstance(value, ir.Num | ir.Formula) else value


#: What is told about a formula, and is no part of what it says; of a comparison also which side stood at the left.
_TOLD = ("span", "unit", "shown")
_TURNED = (*_TOLD, "turned")
