"""The tree of C: what is printed is evaluated as the tree says, fits its lines, and has names of its own."""

from __future__ import annotations

import ctypes
import math
import random
import struct
import subprocess
from pathlib import Path

import pytest

from trackmarshal.backends.c import build
from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.slots import assign
from trackmarshal.backends.c.names import literal, written
from trackmarshal.backends.c.tree.printing import WIDTH, expression, wrapped

a, b, d = (c.Name(name) for name in ("a", "b", "d"))


def of(op: str, left: c.Expr, right: c.Expr) -> c.Expr:
    return c.Binary(op, left, right)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (of("-", of("-", a, b), d), "a - b - d"),
        (of("-", a, of("-", b, d)), "a - (b - d)"),
        (of("+", a, of("*", b, d)), "a + (b * d)"),
        (of("*", a, of("+", b, d)), "a * (b + d)"),
        (of("*", of("*", a, b), d), "a * b * d"),
        (of("*", a, of("*", b, d)), "a * (b * d)"),
        (of("/", of("*", a, b), d), "a * b / d"),
        (of("/", a, of("*", b, d)), "a / (b * d)"),
        (of("-", a, c.Unary("-", b)), "a - (-b)"),
        (c.Unary("-", of("+", a, b)), "-(a + b)"),
        (c.Unary("-", c.Unary("-", a)), "-(-a)"),
        (of("<", of("+", a, b), d), "(a + b) < d"),
        (of("&&", of("<", a, b), of("<", b, d)), "(a < b) && (b < d)"),
        (of("&&", of("&&", a, b), d), "a && b && d"),
        (of("&&", a, of("&&", b, d)), "a && (b && d)"),
        (of("||", of("&&", a, b), c.Unary("!", d)), "(a && b) || !d"),
        (c.Conditional(of("<", a, b), a, of("-", a, b)), "(a < b) ? a : (a - b)"),
        (c.Member(c.Element(c.Member(a, "b", True), d), "e", False), "a->b[d].e"),
        (c.Address(c.Member(a, "b", True)), "&a->b"),
        (c.Member(c.Unary("*", a), "b", False), "(*a).b"),
    ],
)  # fmt: skip
def test_parentheses(expr: c.Expr, text: str) -> None:
    assert expression(expr) == text


def made(rng: random.Random, depth: int) -> tuple[c.Expr, float]:
    """A random expression, and its value as the tree says."""
    if depth == 0 or rng.random() < 0.1:
        value = rng.choice([rng.uniform(-3.0, 3.0), 1e16, -1.0, 0.1, -0.0])
        return c.Literal(literal(value)), value
    if rng.random() < 0.15:
        operand, value = made(rng, depth - 1)
        return c.Unary("-", operand), -value
    (left, x), (right, y) = made(rng, depth - 1), made(rng, depth - 1)
    op = rng.choice("+-*/")
    value = x + y if op == "+" else x - y if op == "-" else x * y if op == "*" else quotient(x, y)
    return of(op, left, right), value


def quotient(x: float, y: float) -> float:
    if y != 0.0:
        return x / y
    return math.nan if x == 0.0 or math.isnan(x) else math.copysign(math.inf, x) * math.copysign(1.0, y)


@pytest.mark.skipif(build.compiler() is None, reason="no C compiler")
def test_what_is_printed_is_evaluated_as_the_tree_says(tmp_path: Path) -> None:
    """Bit for bit, also where lines are broken: sums and products are not associative."""
    rng = random.Random(20)
    trees = [made(rng, 1 + n % 6) for n in range(400)]
    lines = ["#include <math.h>", "void values(double *out) {"]
    for n, (tree, _) in enumerate(trees):
        lines += wrapped(f"  out[{n}] = {expression(tree)};")
    (tmp_path / "tree.c").write_text("\n".join([*lines, "}", ""]), encoding="utf-8")
    command = build.compiler()
    assert command is not None
    library = tmp_path / "tree.so"
    flags = [*build.EXACT, "-Wall", "-Wextra", "-Wparentheses", "-Werror", "-Wno-div-by-zero", *build.SHARED]
    subprocess.run([*command, *flags, "-o", library, tmp_path / "tree.c"], check=True)
    out = (ctypes.c_double * len(trees))()
    ctypes.CDLL(str(library)).values(out)
    for n, (tree, value) in enumerate(trees):
        same = (math.isnan(value) and math.isnan(out[n])) or struct.pack("<d", out[n]) == struct.pack(
            "<d", value
        )
        assert same, expression(tree)


def test_lines_are_broken_where_the_nesting_is_least() -> None:
    long = c.Call("function", tuple(c.Call(f"inner_{n}", (of("+", a, b), d)) for n in range(8)))
    lines = list(wrapped(f"  const double x = {expression(long)};"))
    assert len(lines) > 1
    assert all(len(line) <= WIDTH for line in lines)
    assert " ".join(line.strip() for line in lines) == f"const double x = {expression(long)};"
    assert all(line.endswith("),") for line in lines[:-1])
    assert all(line.startswith("      inner_") for line in lines[1:])


def test_no_two_names_are_alike_where_both_are_known() -> None:
    root = c.Scope()
    loops = [root.open(lambda body: c.If(a, body)) for _ in range(2)]
    assert loops[0].take("x") == "x"
    assert loops[1].take("x") == "x"  # neither knows the other's
    assert loops[0].take("X", "o_x") == "o_x"
    assert loops[0].take("x") == "x_2"
    assert root.take("x") == "x_3"  # what is inside would hide it
    assert loops[1].take("x_3") == "x_3_2"


def test_what_is_computed_once_stands_before_the_loop_that_needs_it() -> None:
    root = c.Scope()
    loop = root.open(lambda body: c.If(a, body))
    loop.add(c.Evaluate(b), "line 3")
    root.add(c.Declare("double", "b", d), "line 2")
    root.close(loop)
    root.add(c.Evaluate(d), "line 3")
    body = root.statements(["line 1"])
    assert [*c.printed(c.Function((), "void", "g", (), body))] == [
        "static void g(void)", "{",
        "  /* line 2 */", "  const double b = d;",
        "  if (a) {", "    /* line 3 */", "    b;", "  }",
        "  d;", "}",
    ]  # fmt: skip


def test_series_share_places_unless_both_are_in_use() -> None:
    def uses(*numbers: int) -> c.Statement:
        return c.Evaluate(c.Call("f", tuple(c.Slot(number) for number in numbers)))

    body, count = assign((uses(1), uses(1, 2), uses(2, 3), c.If(a, (uses(3), uses(4), uses(3)))))
    assert count == 2
    printed = "\n".join(c.printed(c.Function((), "void", "g", (), body)))
    assert [line.strip() for line in printed.splitlines() if "f(" in line] == [
        "f(0u);", "f(0u, 1u);", "f(1u, 0u);", "f(0u);", "f(1u);", "f(0u);",
    ]  # fmt: skip


def test_text_of_a_spec_is_safe_in_comments() -> None:
    assert written('rule x "a */ b"\n  -- what /* is ??/ this\\\n\trequire ä') == (
        'rule x "a * / b"', "  -- what / * is ? ?/ this/", "        require ?",
    )  # fmt: skip
