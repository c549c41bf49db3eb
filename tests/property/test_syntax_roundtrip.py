"""Syntax tree to text and back gives the same tree; the layout is stable and loses no comment.

A generated tree is expensive, so that each test holds it against several properties.
"""

from __future__ import annotations

import copy
import re
from random import Random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from property.strategies.ast import COMMENTS, expressions, items, modules
from trackmarshal.source import SourceFile, decode
from trackmarshal.syntax import ast
from trackmarshal.syntax.comments import comments_of
from trackmarshal.syntax.format import format_module, format_text
from trackmarshal.syntax.parser import parse

pytestmark = pytest.mark.filterwarnings("ignore:Generating overly large repr")
#: No wall time in a verdict: a loaded machine is slow, not wrong.
unhurried = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
_STRING = re.compile(r'"(?:[^"\\\n]|\\.)*"')
_TOKEN = re.compile(r'"(?:[^"\\\n]|\\.)*"|--[^\n]*|[ \t]+|\n|.')


def read_back(text: str) -> ast.Module:
    module, found = parse(SourceFile("made.spec", text))
    assert not found, (found, text)
    return module


def formatted(module: ast.Module) -> str:
    return format_module(module, SourceFile("made.spec", ""))


def of_one_rule(expr: ast.Expr, unicode: bool) -> ast.Module:
    return ast.Module((ast.Rule("r", "", (ast.Require("require", expr),)),), unicode)


@unhurried
@given(modules())
def test_reading_back_a_written_tree_gives_the_tree(module: ast.Module) -> None:
    text = formatted(module)
    again = read_back(text)
    assert again.items == module.items
    # The style is recognised by its own signs, and kept.
    assert module.unicode or not again.unicode
    assert formatted(again) == text
    for line in _STRING.sub('""', text).split("\n"):
        assert line == line.rstrip()
        assert "\t" not in line


@unhurried
@given(modules())
def test_the_other_style_means_the_same(module: ast.Module) -> None:
    text = formatted(ast.Module(module.items, not module.unicode))
    assert read_back(text).items == module.items
    assert _STRING.sub("", formatted(ast.Module(module.items, False))).isascii()


@unhurried
@given(expressions(4), st.booleans())
def test_wide_expressions_are_broken_and_read_back(expr: ast.Expr, unicode: bool) -> None:
    wide = ast.Binary(
        "or", ast.Binary("and", expr, ast.Name("x" * 60)), ast.Binary("implies", expr, ast.Name("y" * 60))
    )
    text = formatted(of_one_rule(wide, unicode))
    assert read_back(text).items == of_one_rule(wide, unicode).items
    assert format_text(SourceFile("made.spec", text)) == text
    assert text.count("\n") > 2


def parenthesised_somewhere(expr: ast.Expr, random: Random) -> ast.Expr:
    """The same expression (a copy) with some of its parts in parentheses."""
    own = copy.deepcopy(expr)
    for node in own.walk():
        if isinstance(node, ast.Expr) and not isinstance(node, (ast.RecordValue, ast.ListValue)):
            if random.random() < 0.4:
                ast.parenthesised(node)
    return own


def parentheses(node: ast.Expr | ast.Module) -> list[bool]:
    return [ast.is_parenthesised(part) for part in node.walk() if isinstance(part, ast.Expr)]


@unhurried
@given(expressions(4), st.booleans(), st.booleans(), st.randoms(use_true_random=False))
def test_written_parentheses_are_kept_and_mean_nothing(
    expr: ast.Expr, unicode: bool, wide: bool, random: Random
) -> None:
    written = parenthesised_somewhere(expr, random)
    assert written == expr
    if wide:
        written = ast.Binary("and", ast.Binary("or", written, ast.Name("x" * 60)), ast.Name("y" * 60))
    module = of_one_rule(written, unicode)
    text = formatted(module)
    again = read_back(text)
    assert again.items == module.items
    assert all(
        after or not before for before, after in zip(parentheses(module), parentheses(again), strict=True)
    )
    assert formatted(ast.Module(again.items, unicode)) == text
    if again.unicode == unicode:
        assert format_text(SourceFile("made.spec", text)) == text
    other = read_back(formatted(ast.Module(again.items, not unicode)))
    assert other.items == module.items
    # In ASCII more may be needed: `0 %² m 0` is `(0 %^2) m 0`, since a unit goes on after its exponent.
    assert all(
        after or not before for before, after in zip(parentheses(again), parentheses(other), strict=True)
    )


@unhurried
@given(modules(), st.data())
def test_every_comment_is_kept_once_and_in_order(module: ast.Module, data: st.DataObject) -> None:
    text = disturbed(formatted(module), data)
    assert read_back(text).items == module.items
    once = format_text(SourceFile("made.spec", text))
    assert [c.text for c in comments_of(once)] == [c.text for c in comments_of(text)]
    assert read_back(once).items == module.items
    assert format_text(SourceFile("made.spec", once)) == once


@unhurried
@given(st.lists(items(), min_size=1, max_size=3), st.booleans(), st.data())
def test_blanks_and_line_ends_do_not_change_the_layout(
    made: list[ast.Item], unicode: bool, data: st.DataObject
) -> None:
    text = formatted(ast.Module(tuple(made), unicode))
    spread = disturbed(text, data, comments=False)
    windows = b"\xef\xbb\xbf" + spread.replace("\n", "\r\n").encode()
    assert format_text(decode("made.spec", windows)) == format_text(SourceFile("made.spec", text)) == text


def disturbed(text: str, data: st.DataObject, *, comments: bool = True) -> str:
    """The text with other blanks, and with comments and empty lines put in, where the language allows them."""
    seed = data.draw(st.randoms(use_true_random=False))
    out: list[str] = []
    for match in _TOKEN.finditer(text):
        token = match.group()
        if token == "\n" and comments:
            if seed.random() < 0.2:
                # Right behind a name, what begins with a letter reads as two minus signs.
                comment = seed.choice(COMMENTS)
                out.append("  " * (comment[2:3].isalnum() or seed.randrange(2)) + comment)
            out.append("\n" * (1 + (seed.random() < 0.2)))
            if seed.random() < 0.1:
                out.append(seed.choice(["", "  ", "\t"]) + seed.choice(COMMENTS) + "\n")
        elif token.isspace() and token != "\n" and seed.random() < 0.3:
            comment = f" {seed.choice(COMMENTS)}\n  " if comments and seed.random() < 0.3 else " \t "
            # Not between a number and its unit, nor within `for all`, `set of` and `exists nearest`.
            joined = re.search(r"[0-9.]\Z|for\Z|set\Z", text[: match.start()])
            joined = joined or re.match("nearest", text[match.end() :])
            out.append(token if joined else comment)
        else:
            out.append(token)
    return "".join(out)
