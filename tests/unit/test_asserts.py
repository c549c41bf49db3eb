"""`python -O` leaves out every `assert`: in the product they tell the type checker what a thing is, and nothing else depends on them."""

from __future__ import annotations

import ast

import pytest

from support.shared import REPOSITORY

FILES = [path for room in ("engine", "trace") for path in sorted((REPOSITORY / room).rglob("*.py"))]


def narrows(test: ast.expr) -> bool:
    """Whether a condition says of which type a thing is, or that it is not None."""
    match test:
        case ast.BoolOp(values=values):
            return all(map(narrows, values))
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return narrows(operand)
        case ast.Call(func=ast.Name(id="isinstance")):
            return True
        case ast.Compare(ops=[ast.IsNot()], comparators=[ast.Constant(value=None)]):
            return True
        case ast.Compare(left=ast.Call(func=ast.Name(id="type")), ops=[ast.Is()]):
            return True
        case _:
            return False


def test_nothing_but_types_is_asserted() -> None:
    texts = {path: path.read_text("utf-8") for path in FILES}
    found = [
        f"{path.relative_to(REPOSITORY)}:{node.lineno}"
        for path, text in texts.items()
        if "assert" in text  # no statement is one without the word
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Assert) and not narrows(node.test)
    ]
    assert len(FILES) > 500
    assert found == []


@pytest.mark.parametrize(
    "text", ["x == 1", "x", "not x", "x is y", "isinstance(x, int) and x > 1", "len(x) is not 1"]
)
def test_what_is_more_than_a_type(text: str) -> None:
    assert not narrows(ast.parse(text, mode="eval").body)
