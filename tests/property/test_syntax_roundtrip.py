"""Syntax tree to text and back gives the same tree; the layout is stable and loses no comment."""

from __future__ import annotations

import re

from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from strategies.ast import COMMENT_TEXT, expressions, items, modules

from trackmarshal.source import SourceFile, decode
from trackmarshal.syntax import ast
from trackmarshal.syntax.comments import comments_of
from trackmarshal.syntax.format import format_module, format_text
from trackmarshal.syntax.parser import parse

#: No wall time in a verdict: a loaded machine is slow, not wrong.
unhurried = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
_TOKEN = re.compile(r'"(?:[^"\\\n]|\\.)*"|--[^\n]*|[ \t]+|\n|.')


def read_back(text: str) -> ast.Module:
    module, found = parse(SourceFile("made.spec", text))
    assert not found, (found, text)
    return module


def formatted(module: ast.Module) -> str:
    return format_module(module, SourceFile("made.spec", ""))


def texts_of_comments(text: str) -> list[str]:
    return [comment.text for comment in comments_of(text)]


@unhurried
@given(modules())
def test_reading_back_a_written_tree_gives_the_tree(module: ast.Module) -> None:
    assert read_back(formatted(module)).items == module.items


@unhurried
@given(expressions(40), st.booleans())
def test_large_expressions_are_read_back(expr: ast.Expr, unicode: bool) -> None:
    module = ast.Module((ast.Rule("r", "", (ast.Require("require", expr),)),), unicode)
    assert read_back(formatted(module)).items == module.items


@unhurried
@given(modules())
def test_the_layout_is_stable(module: ast.Module) -> None:
    text = formatted(module)
    assert format_text(SourceFile("made.spec", text)) == text


@unhurried
@given(modules())
def test_a_style_is_recognised_by_its_own_signs(module: ast.Module) -> None:
    text = formatted(module)
    again = read_back(text)
    assert again.unicode is False or module.unicode
    assert formatted(ast.Module(module.items, again.unicode)) == text


@unhurried
@given(modules())
def test_the_other_style_means_the_same(module: ast.Module) -> None:
    other = ast.Module(module.items, not module.unicode)
    assert read_back(formatted(other)).items == read_back(formatted(module)).items


@unhurried
@given(modules())
def test_ascii_style_is_ascii_outside_strings(module: ast.Module) -> None:
    text = formatted(ast.Module(module.items, False))
    assert re.sub(r'"(?:[^"\\\n]|\\.)*"', "", text).isascii()


@unhurried
@given(modules(), st.data())
def test_every_comment_is_kept_once_and_in_order(module: ast.Module, data: st.DataObject) -> None:
    text = disturbed(formatted(module), data)
    assert read_back(text).items == module.items
    once = format_text(SourceFile("made.spec", text))
    assert texts_of_comments(once) == texts_of_comments(text)
    assert read_back(once).items == module.items
    assert format_text(SourceFile("made.spec", once)) == once


@unhurried
@given(st.lists(items(), min_size=1, max_size=3), st.data())
def test_blanks_and_line_ends_do_not_change_the_layout(made: list[ast.Item], data: st.DataObject) -> None:
    text = formatted(ast.Module(tuple(made), data.draw(st.booleans())))
    spread = disturbed(text, data, comments=False, blank_lines=False)
    windows = b"\xef\xbb\xbf" + spread.replace("\n", "\r\n").encode()
    assert format_text(decode("made.spec", windows)) == format_text(SourceFile("made.spec", text))


@unhurried
@given(modules())
def test_no_line_ends_in_a_blank_or_holds_a_tab(module: ast.Module) -> None:
    for line in re.sub(r'"(?:[^"\\\n]|\\.)*"', '""', formatted(module)).split("\n"):
        assert line == line.rstrip()
        assert "\t" not in line


@unhurried
@given(expressions(30), st.booleans())
@example(ast.Name("x" * 200), False)
def test_lines_are_no_wider_than_their_parts_force_them_to_be(expr: ast.Expr, unicode: bool) -> None:
    text = formatted(ast.Module((ast.Rule("r", "", (ast.Require("require", expr),)),), unicode))
    for line in text.split("\n")[1:]:
        words = re.sub(r"^ *(require)? *", "", line)
        # A line may be too long only where it cannot be broken: after its indentation, one operand, call head or range.
        assert len(line) <= 110 or " and " not in re.sub(r"\[.*?\]", "", words.partition("(")[0].partition(" in ")[0])


def disturbed(text: str, data: st.DataObject, *, comments: bool = True, blank_lines: bool = True) -> str:
    """The text with blanks, line ends and comments put in where the language allows them."""
    seed = data.draw(st.randoms(use_true_random=False))
    out: list[str] = []
    for match in _TOKEN.finditer(text):
        token = match.group()
        if token == "\n":
            following = text[match.end() : match.end() + 1]
            if comments and seed.random() < 0.2:
                out.append("  " * seed.randrange(2) + data.draw(COMMENT_TEXT))
            out.append("\n" * (1 + (blank_lines and seed.random() < 0.2)))
            if comments and seed.random() < 0.1:
                out.append(seed.choice(["", "  ", "\t"]) + data.draw(COMMENT_TEXT) + "\n")
            if following in ("", "\n"):
                continue
        elif token.isspace():
            if comments and seed.random() < 0.1:
                out.append(" " + data.draw(COMMENT_TEXT))
                out.append("\n  ")
            else:
                out.append(seed.choice([token, " ", "  ", "\t"]) if out and out[-1] != "\n" else token)
        else:
            out.append(token)
    return "".join(out)
