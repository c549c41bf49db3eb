"""The nodes: expressions, statements, functions. `Expr` and `Statement` are closed unions.

Nodes are compared by identity: two expressions that look alike are two places in a program.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal as Word
from typing import TypeAlias, assert_never

from trackmarshal.node import Node

BinaryOp: TypeAlias = Word["+", "-", "*", "/", "<", "<=", ">", ">=", "==", "!=", "&&", "||"]
UnaryOp: TypeAlias = Word["-", "!", "*", "++"]


class Tree(Node):
    """A node of the tree; equal only to itself."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__


# Expressions --------------------------------------------------------------------------------------------------


class Name(Tree):
    """A variable or a parameter of the function, or a constant with a name."""

    name: str


class Literal(Tree):
    """A constant as it is written; a negative number stands in parentheses."""

    text: str


class Member(Tree):
    """`record.name`, or `record->name` where the record is behind a pointer."""

    record: Expr
    name: str
    pointer: bool


class Element(Tree):
    """`array[index]`."""

    array: Expr
    index: Expr


class Address(Tree):
    """`&operand`."""

    operand: Expr


class Call(Tree):
    """A call of a function by its name."""

    function: str
    arguments: tuple[Expr, ...]


class Unary(Tree):
    """An operator before its operand."""

    op: UnaryOp
    operand: Expr


class Binary(Tree):
    """Two operands, evaluated as the tree says: nothing is reassociated when it is printed."""

    op: BinaryOp
    left: Expr
    right: Expr


class Conditional(Tree):
    """`condition ? then : otherwise`."""

    condition: Expr
    then: Expr
    otherwise: Expr


class Slot(Tree):
    """A series of the context, by a number of its own until `slots.assign` gives it a place."""

    number: int


Expr: TypeAlias = Name | Literal | Member | Element | Address | Call | Unary | Binary | Conditional | Slot

# Statements ---------------------------------------------------------------------------------------------------


class Declare(Tree):
    """`const type name = value;`, without the `const` for what changes."""

    type: str
    name: str
    value: Expr
    constant: bool = True


class Assign(Tree):
    """`target = value;`."""

    target: Expr
    value: Expr


class Evaluate(Tree):
    """An expression for what it does; `(void)x;` where all that it does is to be named."""

    value: Expr
    unused: bool = False


class Return(Tree):
    """`return value;`, or `return;`."""

    value: Expr | None = None


class Remark(Tree):
    """A comment on a line of its own, whose text is safe in comments."""

    text: str


class If(Tree):
    """`if (condition) { body }`."""

    condition: Expr
    body: tuple[Statement, ...]


class For(Tree):
    """`for (size_t index = 0u; condition; step) { body }`; an index of "" is declared elsewhere.

    over: the signal whose samples or elements it goes through, for the report.
    """

    index: str
    condition: Expr
    step: Expr
    body: tuple[Statement, ...]
    over: str = ""


Statement: TypeAlias = Declare | Assign | Evaluate | Return | Remark | If | For


class Function(Tree):
    """A static function: parameters are (type, name), the type up to the name (`tm_context *`); comment lines are safe in comments."""

    comment: tuple[str, ...]
    result: str
    name: str
    parameters: tuple[tuple[str, str], ...]
    body: tuple[Statement, ...]


def operands(expr: Expr) -> tuple[Expr, ...]:
    """The expressions directly in one, in order."""
    match expr:
        case Name() | Literal() | Slot():
            return ()
        case Member():
            return (expr.record,)
        case Element():
            return (expr.array, expr.index)
        case Address() | Unary():
            return (expr.operand,)
        case Call():
            return expr.arguments
        case Binary():
            return (expr.left, expr.right)
        case Conditional():
            return (expr.condition, expr.then, expr.otherwise)
        case _:
            assert_never(expr)


def expressions(statement: Statement) -> Iterator[Expr]:
    """The expressions directly in a statement, those of inner statements not included."""
    for child in statement.children():
        if isinstance(child, Expr):
            yield child


def within(expr: Expr) -> Iterator[Expr]:
    """An expression and all in it."""
    stack = [expr]
    while stack:
        item = stack.pop()
        yield item
        stack += operands(item)
