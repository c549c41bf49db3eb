"""The one layout, by example: columns, blank lines, wrapping, parentheses, signs, comments."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.node import Node
from trackmarshal.source import NOWHERE, SourceFile, Span, decode, read
from trackmarshal.syntax import ast
from trackmarshal.syntax.comments import comments_of
from trackmarshal.syntax.format import format_module, format_text
from trackmarshal.syntax.parser import MAX_DEPTH, parse

REPOSITORY = Path(__file__).parents[2]
SHIPPED = sorted(
    [*REPOSITORY.glob("specs/**/*.spec"), *REPOSITORY.glob("engine/trackmarshal/prelude/*.spec")]
)
SAMPLE = REPOSITORY / "tests" / "property" / "strategies" / "sample.spec"


def laid_out(text: str) -> str:
    once = format_text(SourceFile("t.spec", text))
    assert format_text(SourceFile("t.spec", once)) == once
    return once


def formula(text: str) -> str:
    out = laid_out(f"rule r require {text}")
    return out.removeprefix("rule r\n  require   ").removesuffix("\n")


def test_the_sample_is_laid_out() -> None:
    assert format_text(read(SAMPLE)) == SAMPLE.read_text("utf-8")


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_specs_keep_their_meaning_and_their_comments(path: Path) -> None:
    """As they are: what is laid out already is read once, since the same text means the same."""
    file = read(path)
    out = SourceFile("out.spec", format_text(file))
    if out.text != file.text:
        assert parse(out)[0].items == parse(file)[0].items
        assert [c.text for c in comments_of(out.text)] == [c.text for c in comments_of(file.text)]
        assert format_text(out) == out.text


def test_clauses_stand_one_a_line_with_one_column_of_keywords() -> None:
    out = laid_out(
        'rule friction "Combined" satisfies S-1-A-4,S-1-A-5 source r eq 2,3 for all p in plan where p.v>0 m/s '
        'except a behind b "why" let d=p.v  require d<1 m/s'
    )
    assert out == (
        'rule friction "Combined"\n'
        "  satisfies S-1-A-4, S-1-A-5\n"
        "  source    r eq 2, 3\n"
        "  for all   p in plan where p.v > 0 m/s\n"
        '  except    a behind b  "why"\n'
        "  let       d = p.v\n"
        "  require   d < 1 m/s\n"
    )


def test_neighbouring_parameters_share_columns() -> None:
    out = laid_out(
        'param mass : kg = 1160 kg in [900, 1400]\nparam mu:1=1.1 source "sheet"\nparam R_min : m = 11 m in [1, 20] source "x"\n'
        "\nparam far_away : m/s^2 = 1 m/s^2\n"
    )
    assert out == (
        "param mass  : kg = 1160 kg  in [900, 1400]\n"
        'param mu    : 1  = 1.1      source "sheet"\n'
        'param R_min : m  = 11 m     in [1, 20]  source "x"\n'
        "\n"
        "param far_away : m/s^2 = 1 m/s^2\n"
    )


def test_a_source_that_does_not_fit_goes_to_the_next_line() -> None:
    source = "s" * 95
    assert (
        laid_out(f'param a : m = 1 m in [0, 2] source "{source}"')
        == f'param a : m = 1 m  in [0, 2]\n  source "{source}"\n'
    )


def test_blank_lines_between_declarations() -> None:
    out = laid_out(
        "module m\nuse a\n\n\n\nuse b\nparam p : m = 1 m\nrule a require x\nrule b require x\ntest a expect open\ntest a expect open"
    )
    assert out.split("\n") == [
        "module m", "use a", "", "use b", "", "param p : m = 1 m", "", "rule a", "  require   x", "", "rule b", "  require   x", "",
        "test a", "  expect open", "test a", "  expect open", "",
    ]  # fmt: skip


def test_fields_are_filled_and_aligned() -> None:
    fields = ", ".join(f"field_{i}: m in [0, {i}]" for i in range(8))
    out = laid_out(f"signal plan : trajectory {{ {fields}, }}\nsignal track : corridor")
    lines = out.split("\n")
    assert lines[0].startswith("signal plan  : trajectory { field_0: m in [0, 0], ")
    assert lines[1].startswith(" " * len("signal plan  : trajectory { ") + "field_")
    assert lines[-3].endswith(" }")
    assert lines[-2] == "signal track : corridor"
    assert max(map(len, lines)) <= 110


def test_lists_in_tests_are_filled_and_records_stand_in_rows() -> None:
    numbers = ", ".join(f"{i} m" for i in range(40))
    record = "{ x: 1 m, y: 2 m, heading: 0 rad, length: 4.7 m, width: 2.8 m }"
    out = laid_out(f"test r given x = [{numbers}] given o = [{record}, {record}] expect open")
    assert "  given  x = [\n    0 m, 1 m, " in out
    assert f"  given  o = [\n    {record},\n    {record}\n  ]\n" in out
    assert max(map(len, out.split("\n"))) <= 110


@pytest.mark.parametrize(
    ("written", "printed"),
    [
        ("a * (b + c)", "a * (b + c)"), ("a - (b - c)", "a - (b - c)"), ("(a^b)^c", "(a^b)^c"), ("a^(b + c)", "a^(b + c)"),
        ("(-a)^2", "(-a)^2"), ("-(-a)", "-(-a)"), ("- -a", "-(-a)"), ("a - -b", "a - -b"), ("(5 m)^2", "(5 m)^2"), ("(5 m) ^ 2", "(5 m)^2"),
        ("5^2", "5^2"), ("a < b and (c or d)", "a < b and (c or d)"), ("(a implies b) implies c", "(a implies b) implies c"),
        ("not (a < b)", "not (a < b)"), ("not a < b", "not (a < b)"), ("not not a", "not not a"), ("always (a and b)", "always (a and b)"),
        ("(for all p in q: a) and b", "(for all p in q: a) and b"), ("b and for all p in q: a", "b and for all p in q: a"),
        ("(b and for all p in q: a) or c", "(b and for all p in q: a) or c"),
        ("(if a then b else c) < d", "(if a then b else c) < d"), ("d < (if a then b else c)", "d < (if a then b else c)"),
        ("(a until b) until c", "(a until b) until c"), ("(a + b).x", "(a + b).x"), ("(3) m x", "(3) m x"),
        ("5m<6  m", "5 m < 6 m"), ("weak  next a", "weak next a"), ("{}", None),
    ],
)  # fmt: skip
def test_parentheses_stand_where_they_are_needed(written: str, printed: str | None) -> None:
    if printed is None:
        with pytest.raises(Diagnostics):
            formula(written)
    else:
        assert formula(written) == printed


@pytest.mark.parametrize(
    "written",
    [
        "(a)", "(a + b)", "(a * b) + c", "(a - b) - c", "-(a^2)", "(a < b) and (c or d)", "(a and b) or c", "a or (b and c)",
        "a implies (b implies c)", "(a iff b) iff c", "not (not a)", "(not a) and b", "(always a) and b", "always (a < b)",
        "b and (for all p in q: a)", "(b and (for all p in q: a)) or c", "b and (for all p in q: a) or c", "a in [(b), c + 1]",
        "f((a), n: (b))", "(a).x", "always[0 s, 1 s] (a)", "a^(2)", "a^(-b)", "a^-(b)", "(a^2) + (b * c)", "if a then b else (if c then d else e)",
        "if (a) then (b) else (c)", "(a + b) behind (c)", "for all p in (q) where (a): (b)", "(a) until[(0 s), (1 s)] (b)", "(p) in zone z",
        "(if a then b else c)", "(3) * (5 m)", "sqrt((a))",
    ],
)  # fmt: skip
def test_parentheses_that_were_written_stay(written: str) -> None:
    assert formula(written) == written


@pytest.mark.parametrize(
    ("written", "printed"),
    [
        ("((a))", "(a)"),
        ("a or ((b and c))", "a or (b and c)"),
        ("(((a + b))) * c", "(a + b) * c"),
        ("(  a )", "(a)"),
    ],
)
def test_of_double_parentheses_one_pair_stays(written: str, printed: str) -> None:
    assert formula(written) == printed


def test_written_parentheses_stay_where_signs_are_used() -> None:
    assert formula("a ≤ b ∨ (c ∧ d)") == "a ≤ b ∨ (c ∧ d)"
    assert formula("a ≤ b^(2) + (c²)") == "a ≤ b^(2) + (c²)"


def test_written_parentheses_stay_in_all_declarations() -> None:
    text = (
        "param p : m = (1 m)  in [0, 2]\n\nconstrain (p > 0 m) and p < (3 m)\n\ndefine d(a: m) -> m = (a)\n"
        "predicate q(a: m) = (a > 0 m)\n\ntest r\n  given  x = [(1 m), 2 m] with v = (2)\n  expect violated, margin about (2) within (1)\n"
    )
    assert laid_out(text) == text


def test_written_parentheses_stay_in_formulas_of_several_lines() -> None:
    side = "gap_lengthways(ego, o) > needed_distance"
    inner = f"({side} and {side})"
    assert formula(f"{side} or {inner} or ({side} or {side})").count("(gap_lengthways") == 2
    assert formula(f"({side} or {side}) or {side} or {side}").startswith("(gap_lengthways")
    assert formula(f"{side} implies ({side} implies {side})").count("(gap_lengthways") == 1
    assert formula(f"if {side} then {'a' * 60} else (if {side} then {'b' * 60} else c)").count("(if") == 1


def test_long_formulas_break_at_the_loosest_operator() -> None:
    side = "gap_lengthways(ego, o) > needed_distance"
    assert formula(f"{side} or {side} and {side} or not {side}") == (
        f"{side}\n              or {side} and {side}\n              or not ({side})"
    )


def test_nested_formulas_break_inside_their_parentheses() -> None:
    side = "gap_longitudinal(ego, object) > needed_distance"
    assert formula(f"always ({side} implies eventually[0 s, 1 s] ({side} or {side}))") == (
        f"always ({side}\n"
        f"                      implies eventually[0 s, 1 s] ({side}\n"
        f"                                                      or {side}))"
    )


def test_a_long_choice_breaks_into_its_cases() -> None:
    body = "some_function_of(v, w) + another_function_of(v, w)"
    out = laid_out(f"define f(v: m) -> m = if v < 1 m then {body} else if v < 2 m then {body} else {body}")
    assert out == (
        f"define f(v: m) -> m =\n  if v < 1 m then {body}\n  else if v < 2 m then {body}\n  else {body}\n"
    )


def test_predicates_never_start_a_line() -> None:
    side = "somewhere_far_behind_the_leading_vehicle(ego, object, track)"
    assert formula(f"{side} requires {side}") == f"{side} requires\n              {side}"


def test_signs_are_kept_throughout() -> None:
    text = "param κ : 1/m = 1 1/m\n\nrule r\n  ∀         p ∈ plan\n  require   √(p.v² + mu_left) ≤ 3 m/s² ∧ p.κ · 2 ≠ 0 → ¬ a ↔ ∃ q ∈ b: x³ ≥ 1\n"
    out = laid_out(text)
    assert out == text.replace("mu_left", "μ_left")


def test_words_are_kept_throughout() -> None:
    out = laid_out("rule r\n  for all   p in plan\n  require   p.v² ≤ 3 m/s² ∧ p.κ · 2 ≠ 0\n")
    assert out == "rule r\n  for all   p in plan\n  require   p.v^2 <= 3 m/s^2 and p.kappa * 2 != 0\n"


def test_comments_stay_where_they_belong() -> None:
    text = """-- the file

-- the module
module m  -- its name

-- about the rule
rule r "t"  -- its title
  -- about the range
  for all   p in plan
  require   p.v < 1 m/s  -- slow
  -- require p.a < 1

-- about the signal
signal s : series {
  -- time
  t: s increasing,  -- must grow
  x: m,
  -- nothing more
}

table f(v: m/s) -> m = linear clamp  -- piecewise
  | 0: 1  -- first
  -- middle
  | 1: 2 |
  -- from the data sheet
  source "sheet"

-- the end
"""
    assert laid_out(text) == text


def test_comments_inside_an_expression_move_above_its_clause() -> None:
    out = laid_out("rule r -- head\n  require a -- one\n    and -- two\n    b -- three\n")
    assert out == "rule r  -- head\n  -- one\n  -- two\n  require   a and b  -- three\n"


def test_comments_between_clauses_on_one_line_go_with_the_last() -> None:
    assert (
        laid_out("rule r let a = b require c -- why") == "rule r\n  let       a = b\n  require   c  -- why\n"
    )


def test_two_dashes_in_a_string_are_no_comment() -> None:
    assert laid_out('event e "a -- b" -- c') == 'event e "a -- b"  -- c\n'


def test_a_file_of_comments_stays() -> None:
    assert laid_out("\n\n-- a\n\n\n   -- b  \n--c") == "-- a\n\n-- b\n--c\n"


def test_line_ends_and_marks_go() -> None:
    assert (
        format_text(decode("t.spec", b"\xef\xbb\xbfmodule m\r\n\r\n\r\n-- c\r\nuse b\r\n"))
        == "module m\n\n-- c\nuse b\n"
    )


def test_a_file_with_errors_is_refused_with_all_of_them() -> None:
    with pytest.raises(Diagnostics) as caught:
        format_text(SourceFile("t.spec", "rule r require a = b\nrule s require (a\n"))
    assert [item.code for item in caught.value.items] == ["E101", "E108"]


def test_an_unknown_node_is_refused() -> None:
    class Strange(ast.Expr):
        span: Span = NOWHERE

    class Odd(ast.Item):
        span: Span = NOWHERE

    class Other(ast.Clause):
        span: Span = NOWHERE

    rule = ast.Rule("r", "", (ast.Require("require", Strange()),))
    nodes: list[Node] = [rule, Odd(), ast.Rule("r", "", (Other(),))]
    for node in nodes:
        assert isinstance(node, ast.Item)
        with pytest.raises(TypeError, match=r"no (notation|layout)"):
            format_module(ast.Module((node,)), SourceFile("t.spec", ""))


@pytest.mark.parametrize(
    "op", ["-", "not ", "always ", "a and ", "a implies ", "f(1, ", "a + ", "a ^ ", "if a then b else "]
)
def test_the_deepest_tree_is_laid_out(op: str) -> None:
    closing = ")" * 40 if "(" in op else ""
    depth = 40 if "(" in op else 100
    text = "rule r require " + (op + "(") * depth + "a" + ")" * depth + closing
    if parse(SourceFile("t.spec", text))[1]:
        pytest.fail("the text should parse")
    assert laid_out(text)


def test_depth_of_a_tree_is_limited_by_the_parser_only() -> None:
    expr: ast.Expr = ast.Name("a" * 30)
    for _ in range(MAX_DEPTH):
        expr = ast.Call("f", (expr, ast.Unary("-", ast.Name("b"))), ("", ""))
    module = ast.Module((ast.Rule("r", "", (ast.Require("require", expr),)),))
    assert format_module(module, SourceFile("t.spec", "")).count("f(") == MAX_DEPTH
