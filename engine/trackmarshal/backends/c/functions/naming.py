"""What values are called in a function: as in the spec, after what they are made of, or after what they are for."""

from __future__ import annotations

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.facts import Value
from trackmarshal.backends.c.functions.writer import Writer
from trackmarshal.backends.c.names import identifier
from trackmarshal.ir import nodes as ir


def wanted(writer: Writer, node: Value, made: c.Expr, role: str, home: c.Scope) -> tuple[str, ...]:
    """What a value may be called: as in the spec, after what it is made of, or after what it is for."""
    spoken = writer.usage.names.get(node)
    if spoken is not None:
        plain = identifier(spoken)
        longer = f"{plain}_{whose(writer, node, home)}"
        return (longer,) if node in writer.usage.ambiguous else (plain, longer)
    own = _own_name(writer, node, made, home)
    if own:
        return own
    return (
        (f"{writer.plan.rule_names[writer.rule.name]}_{role}" if writer.grouped else role,)
        if role
        else ("value",)
    )


def _own_name(writer: Writer, node: Value, made: c.Expr, home: c.Scope) -> tuple[str, ...]:
    match node:
        case ir.Param():
            return identifier(node.name.rpartition(".")[2]), writer.plan.params[node.name]
        case ir.Column() | ir.Flag() if node.axis is not None:
            return (_of_axis(writer, node.axis, node.field or "", node.offset, home),)
        case ir.Scalar():
            return (identifier(f"{node.signal}_{node.field}"),)
        case ir.Flag():
            return (identifier(f"{node.signal}_{node.field}" if node.field else node.signal),)
        case ir.Sample():
            return (identifier(f"{node.signal}_{'first' if node.index == 0 else 'last'}_{node.field}"),)
        case ir.Station() | ir.Offset() | ir.Direction() | ir.Distance():
            return (identifier(f"{node.spoken}_{whose(writer, node, home)}"),)
        case ir.Arith() if node.op == "*" and node.left is node.right:
            named = writer.usage.names.get(node.left)
            own = (named,) if named else _own_name(writer, node.left, made, home)
            return (identifier(f"{own[0]}_squared"),) if own else ()
        case ir.Arith() if isinstance(made, c.Binary):
            return _of_arithmetic(made)
        case ir.Neg() if isinstance(made, c.Unary):
            return (f"minus_{made.operand.name}",) if isinstance(made.operand, c.Name) else ()
        case ir.Func() if isinstance(made, c.Call) and len(node.args) == 1:
            of = made.arguments[0]
            return (f"{node.name}_{of.name}",) if isinstance(of, c.Name) else ()
        case _:
            return ()


def _of_axis(writer: Writer, axis: ir.Axis, field: str, offset: int, home: c.Scope) -> str:
    names = writer.names_of(axis, home)
    if offset < 0:
        return identifier(f"{names[0]}_{field}_before")
    who = names[offset] if offset < len(names) else f"{names[0]}{offset}"
    return identifier(f"{who}_{field}")


def whose(writer: Writer, node: Value, home: c.Scope) -> str:
    """The variables that a value is about, or the signals; for names that would be alike."""
    axes = sorted(writer.facts.free(node), key=lambda axis: axis.level)
    if axes:
        return "_".join(identifier(writer.names_of(axis, home)[0]) for axis in axes)
    read: dict[str, None] = {}
    for each in ir.below(node):
        if isinstance(each, ir.Scalar | ir.Sample | ir.Flag):
            read.setdefault(identifier(each.signal))
    return "_".join(read) or "it"


def _of_arithmetic(made: c.Binary) -> tuple[str, ...]:
    """What simple arithmetic on something with a name is called."""
    match made.left, made.op, made.right:
        case c.Name(), "/", c.Literal() if made.right.text == "2.0":
            return (f"half_{made.left.name}",)
        case c.Literal(), "*", c.Name() if made.left.text == "2.0":
            return (f"twice_{made.right.name}",)
        case _:
            return ()
