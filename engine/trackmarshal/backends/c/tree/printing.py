"""The tree as text: parentheses wherever operators mix, lines of at most `WIDTH` columns.

What is printed is evaluated as the tree says: the left operand of its like needs no parentheses, the right one gets them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import assert_never

from trackmarshal.backends.c.tree.nodes import (
    Address,
    Assign,
    Binary,
    Call,
    Conditional,
    Declare,
    Element,
    Evaluate,
    Expr,
    For,
    Function,
    If,
    Literal,
    Member,
    Name,
    Remark,
    Return,
    Slot,
    Statement,
    Unary,
)  # fmt: skip

#: The longest line, where one can be broken.
WIDTH = 120
#: Operators that may stand side by side, the first of them computed first. Any other mixture gets parentheses (MISRA C:2012, 12.1).
_CHAINS = {"+": "sum", "-": "sum", "*": "product", "/": "product", "&&": "and", "||": "or"}


def expression(expr: Expr) -> str:
    """An expression on one line."""
    match expr:
        case Name():
            return expr.name
        case Literal():
            return expr.text
        case Member():
            return f"{_tight(expr.record)}{'->' if expr.pointer else '.'}{expr.name}"
        case Element():
            return f"{_tight(expr.array)}[{expression(expr.index)}]"
        case Call():
            return f"{expr.function}({', '.join([expression(each) for each in expr.arguments])})"
        case Binary():
            return f"{_operand(expr.op, expr.left, False)} {expr.op} {_operand(expr.op, expr.right, True)}"
        case Unary():
            return f"{expr.op}{_tight(expr.operand)}"
        case Address():
            return f"&{_tight(expr.operand)}"
        case Conditional():
            return f"{_tight(expr.condition)} ? {_tight(expr.then)} : {_tight(expr.otherwise)}"
        case Slot():
            raise AssertionError(f"series {expr.number} has no place yet")
        case _:
            assert_never(expr)


def _tight(expr: Expr) -> str:
    """An expression that what stands beside it cannot tear apart."""
    text = expression(expr)
    return f"({text})" if isinstance(expr, Binary | Unary | Address | Conditional) else text


def _operand(op: str, expr: Expr, right: bool) -> str:
    if isinstance(expr, Binary):
        chain = _CHAINS.get(op)
        if not right and chain is not None and chain == _CHAINS.get(expr.op):
            return expression(expr)
    elif isinstance(expr, Unary) and op in ("&&", "||"):
        return expression(expr)
    return _tight(expr)


def statements(body: Iterable[Statement], depth: int = 1) -> Iterator[str]:
    """Lines of statements, indented by twice `depth`."""
    pad = "  " * depth
    for item in body:
        match item:
            case Declare():
                kind = f"const {item.type}" if item.constant else item.type
                yield from wrapped(f"{pad}{kind} {item.name} = {expression(item.value)};")
            case Assign():
                yield from wrapped(f"{pad}{expression(item.target)} = {expression(item.value)};")
            case Evaluate():
                yield from wrapped(f"{pad}{'(void)' if item.unused else ''}{expression(item.value)};")
            case Return():
                yield from wrapped(
                    f"{pad}return{'' if item.value is None else ' ' + expression(item.value)};"
                )
            case Remark():
                yield f"{pad}/* {item.text} */"
            case If():
                yield from wrapped(f"{pad}if ({expression(item.condition)}) {{")
                yield from statements(item.body, depth + 1)
                yield pad + "}"
            case For():
                begin = f"size_t {item.index} = 0u; " if item.index else "; "
                yield from wrapped(
                    f"{pad}for ({begin}{expression(item.condition)}; {expression(item.step)}) {{"
                )
                yield from statements(item.body, depth + 1)
                yield pad + "}"
            case _:
                assert_never(item)


def function(item: Function) -> Iterator[str]:
    """Lines of a function, its comment before it."""
    for number, line in enumerate(item.comment):
        begin = "/* " if number == 0 else "   " if line else ""
        yield f"{begin}{line}{' */' if number == len(item.comment) - 1 else ''}"
    given = ", ".join(f"{kind}{'' if kind.endswith('*') else ' '}{name}" for kind, name in item.parameters)
    yield f"static {item.result} {item.name}({given or 'void'})"
    yield "{"
    yield from statements(item.body)
    yield "}"


def wrapped(line: str) -> Iterator[str]:
    """A line, broken after commas and before operators, the outermost ones first; what follows is indented by four more."""
    if len(line) <= WIDTH:
        yield line
        return
    pad = " " * (len(line) - len(line.lstrip()) + 4)
    while len(line) > WIDTH:
        place = _break(line)
        if place is None:
            break
        yield line[:place]
        line = pad + line[place + 1 :]
    yield line


def _break(line: str) -> int | None:
    """The space to break a line at: of those that leave it long enough, the last of the least nesting, after a comma if there is one."""
    best: int | None = None
    least, depth = len(line), 0
    begun = len(line) - len(line.lstrip())
    for place, character in enumerate(line[:WIDTH]):
        if character in "([":
            depth += 2
        elif character in ")]":
            depth -= 2
        elif character == " " and place > begun + 30:
            after = line[place - 1] in ",;"
            if (after or line[place + 1] in "+-*/<>!&|?:") and depth + (not after) <= least:
                best, least = place, depth + (not after)
    return best
