"""Text to syntax tree: what binds how tightly, where things are, and how the parser gets over errors."""

from __future__ import annotations

import pytest

from trackmarshal.source import SourceFile, decode
from trackmarshal.syntax import ast
from trackmarshal.syntax.ast import Attribute, Binary, Call, Name, Number, Temporal, Unary
from trackmarshal.syntax.notation import Notation
from trackmarshal.syntax.parser import MAX_DEPTH, parse

A, B, C, D = Name("a"), Name("b"), Name("c"), Name("d")


def items(text: str) -> tuple[ast.Item, ...]:
    module, found = parse(SourceFile("t.spec", text))
    assert not found, found
    return module.items


def item(text: str) -> ast.Item:
    (only,) = items(text)
    return only


def formula(text: str) -> ast.Expr:
    rule = item(f"rule r\n  require {text}\n")
    assert isinstance(rule, ast.Rule)
    (clause,) = rule.clauses
    assert isinstance(clause, ast.Require)
    return clause.condition


def codes(text: str) -> list[str]:
    return [found.code for found in parse(SourceFile("t.spec", text))[1]]


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("a + b * c", Binary("+", A, Binary("*", B, C))),
        ("a - b - c", Binary("-", Binary("-", A, B), C)),
        ("a / b * c", Binary("*", Binary("/", A, B), C)),
        ("a - (b - c)", Binary("-", A, Binary("-", B, C))),
        ("-a^2", Unary("-", Binary("^", A, Number("2")))),
        ("a^-b", Binary("^", A, Unary("-", B))),
        ("-a * b", Binary("*", Unary("-", A), B)),
        ("a * -b", Binary("*", A, Unary("-", B))),
        ("a.b.c", Attribute(Attribute(A, "b"), "c")),
        ("a and b or c", Binary("or", Binary("and", A, B), C)),
        ("a or b and c", Binary("or", A, Binary("and", B, C))),
        ("a implies b implies c", Binary("implies", A, Binary("implies", B, C))),
        ("a or b implies c", Binary("implies", Binary("or", A, B), C)),
        ("a iff b implies c", Binary("iff", A, Binary("implies", B, C))),
        ("a xor b iff c", Binary("iff", Binary("xor", A, B), C)),
        ("not a and b", Binary("and", Unary("not", A), B)),
        ("not a < b", Unary("not", Binary("<", A, B))),
        ("always a and b", Binary("and", Temporal("always", A), B)),
        ("a until b and c", Binary("and", ast.Until("until", A, B), C)),
        ("a < b + c", Binary("<", A, Binary("+", B, C))),
        ("a behind b + c", ast.Infix(A, "behind", Binary("+", B, C))),
        ("a in [b, c]", ast.Within(A, B, C)),
        ("a < b <= c", ast.Chained((A, B, C), ("<", "<="))),
        ("a >= b + c > d > e", ast.Chained((A, Binary("+", B, C), Name("d"), Name("e")), (">=", ">", ">"))),
        ("a < b < c and d", Binary("and", ast.Chained((A, B, C), ("<", "<")), Name("d"))),
        ("not a < b < c", Unary("not", ast.Chained((A, B, C), ("<", "<")))),
        ("a < if b then c else d < e", ast.Chained((A, ast.IfElse(B, C, Name("d")), Name("e")), ("<", "<"))),
        ("a in zone b", ast.InZone(A, "b")),
        ("if a then b else c + d", ast.IfElse(A, B, Binary("+", C, D))),
        ("for all p in a: b and c", Binary("and", ast.Quantified("for all", False, ("p",), A, None, B), C)),
        ("exists p, q in a where b: c", ast.Quantified("exists", False, ("p", "q"), A, B, C)),
        ("weak next a", Temporal("next", A, None, True)),
        ("once[0 s, 1 s] a", Temporal("once", A, ast.Window(Number("0", "s"), Number("1", "s")))),
        ("f(a, n: b)", Call("f", (A, B), ("", "n"))),
        ("true or false", Binary("or", ast.Boolean(True), ast.Boolean(False))),
    ],
)
def test_what_binds_how_tightly(text: str, tree: ast.Expr) -> None:
    assert formula(text) == tree


@pytest.mark.parametrize(
    ("signs", "plain"),
    [
        ("a ≤ b ∧ c ≥ d", "a <= b and c >= d"),
        ("0 ≤ a ≤ b", "0 <= a <= b"),
        ("a ≠ b ∨ ¬ c", "a != b or not c"),
        ("a → b ↔ c", "a implies b iff c"),
        ("a² · b³ − c", "a^2 * b^3 - c"),
        ("√(a) < 1 m/s²", "sqrt(a) < 1 m/s^2"),
        ("∀ p ∈ a: ∃ q ∈ b: c", "for all p in a: exists q in b: c"),
        ("p.κ < μ_left", "p.kappa < mu_left"),
        ("µ < ∆v", "mu < Deltav"),
    ],
)
def test_signs_mean_their_words(signs: str, plain: str) -> None:
    assert formula(signs) == formula(plain)


@pytest.mark.parametrize(
    ("text", "number", "unit"),
    [
        ("5 m/s^2", "5", "m/s^2"), ("5m", "5", "m"), ("0.5 1/m", "0.5", "1/m"), ("10 %", "10", "%"), ("1e-3 km", "1e-3", "km"),
        (".5 h", ".5", "h"), ("60 km/h", "60", "km/h"), ("5 m/s²", "5", "m/s^2"), ("7", "7", ""), ("1.50 kN", "1.50", "kN"),
        ("2 m/s/s", "2", "m/s/s"), ("3 min", "3", "min"),
    ],
)  # fmt: skip
def test_quantities_keep_the_digits_and_the_unit(text: str, number: str, unit: str) -> None:
    assert formula(text) == Number(number, unit)


def test_a_blank_around_the_slash_divides() -> None:
    assert formula("5 m / s") == Binary("/", Number("5", "m"), Name("s"))
    assert formula("5 / s") == Binary("/", Number("5"), Name("s"))
    assert codes("rule r\n  require 5 m/x < 3") == ["E106"]


def test_a_unit_is_a_name_elsewhere() -> None:
    assert formula("m * s < t") == Binary("<", Binary("*", Name("m"), Name("s")), Name("t"))


def test_spans_are_those_of_the_text() -> None:
    text = "module a.b\nrule r\n  let d = (a + b) * c  -- half\n  require d.x <= 5 m\n"
    rule = items(text)[1]
    assert isinstance(rule, ast.Rule)
    assert rule.span.text == text[11:].rstrip()
    let, require = rule.clauses
    assert isinstance(let, ast.Let)
    assert isinstance(require, ast.Require)
    assert let.span.text == "let d = (a + b) * c"
    assert isinstance(let.value, Binary)
    assert let.value.span.text == "(a + b) * c"
    assert isinstance(require.condition, Binary)
    assert require.condition.right.__dict__["span"].text == "5 m"
    assert str(require.span) == "t.spec:4:3"


def test_all_declarations_are_read() -> None:
    text = """module a
use b.c
reference r = "title"
signal s : set of object { t: s increasing, x: m in [-1, inf] default 0, on: bool }
signal bare : series
event e "text"
param p : kg/m = 1 kg/m in [0, 2] source "sheet"
constrain p > 0 because "why"
table f(v: m/s) -> m/s^2 = linear clamp | 0: 1 | -3 m/s: 2 | source "sheet"
zone z = polygon (0 m, 0 m) (1 m, -1 m)
line l "text" = (0, 0) (1, 1)
define d(a: pose, b: m) -> m = b
define e2 = 1
predicate q(a: body) = a.x > 0 m
assume A-1 "text"
  owner "me"
  monitor a
rule r
  require a
state x : { a, final b } for each o in s starts a
  becomes b when c
rulebook k a ~ b > c, d
test r "text"
  given a = { x: [1, 2], y: {} } with v[3] = nan, w = 2
  expect violated, margin about 2 within 1, at p = 3
"""
    kinds = [type(item).__name__ for item in items(text)]
    assert kinds == [
        "ModuleName", "Use", "Reference", "Signal", "Signal", "Event", "Param", "Constrain", "Table", "Place", "Place", "Define",
        "Define", "Define", "Assume", "Rule", "State", "Rulebook", "Test",
    ]  # fmt: skip


def test_a_test_holds_what_is_given_and_expected() -> None:
    test = item(
        'test r "t"\n given a = { x: [1, 2], y: {} } with v[3] = nan\n expect open, margin about 2 within 1, at p = "o"'
    )
    values = ast.RecordValue(("x", "y"), (ast.ListValue((Number("1"), Number("2"))), ast.RecordValue((), ())))
    given = ast.Given("a", values, (ast.Change("v", "3", Name("nan")),))
    assert test == ast.Test("r", "t", (given,), ast.Expect("open", Number("2"), Number("1"), "p", '"o"'))


def test_strings_are_unescaped() -> None:
    assert item(r'reference r = "say \"no\" to C:\\ and \\\""') == ast.Reference(
        "r", 'say "no" to C:\\ and \\"'
    )


def test_every_declaration_reports_its_error_and_the_others_stay() -> None:
    text = "module m\nrule a\n  require x = 1\nrule b\n  require x\nrul c\n  require x\nrule d\n  require (x\nparam p : m = 1 m\n"
    module, found = parse(SourceFile("t.spec", text))
    assert [d.code for d in found] == ["E101", "E103", "E108"]
    assert [d.span.line for d in found] == [3, 6, 9]
    assert [item.__dict__["name"] for item in module.items] == ["m", "b", "p"]


@pytest.mark.parametrize("line", ["requre x < 3", "assumign A-1", "becuase x", "requires x", "monitr x"])
def test_a_misspelt_clause_is_never_taken_for_a_predicate(line: str) -> None:
    kind, word = ("assume A-1", "monitor") if line.startswith("mon") else ("rule r", "require")
    assert codes(f"{kind}\n  {word} x\n  {line}\n") == ["E107"]


def test_a_predicate_may_have_such_a_name_within_a_line() -> None:
    assert formula("a requires b") == ast.Infix(A, "requires", B)


def test_clauses_may_stand_on_one_line_or_in_column_1() -> None:
    one = item("rule r for all p in plan require p.v < 3 m/s")
    assert one == item("rule r\nfor all p in plan\nrequire p.v <\n3 m/s")


def test_a_file_of_comments_is_an_empty_module() -> None:
    assert items("-- nothing yet\n\n  -- rule r\n") == ()


def test_line_ends_and_byte_order_marks_do_not_matter() -> None:
    text = "module m\nrule r\n  require a < b\n"
    plain = parse(decode("t.spec", text.encode()))[0]
    assert parse(decode("t.spec", b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode()))[0] == plain


@pytest.mark.parametrize(
    ("text", "unicode"),
    [
        ("rule r require a ≤ b", True), ("rule r require a <= b", False), ("rule r require a <= b and c ≤ d", False),
        ("rule r require p.κ <= b", True), ("-- κ ≤\nrule r require a <= b", False), ('rule "≤" require a', False),
        ("param p : m/s² = 1", True), ("param p : m/s^2 = p.v²", False), ("rule A-or require a² < b", True), ("module m", False),
    ],
)  # fmt: skip
def test_the_first_sign_decides_the_style(text: str, unicode: bool) -> None:
    assert parse(SourceFile("t.spec", text))[0].unicode is unicode


def test_nesting_is_bounded_and_what_is_below_the_bound_can_be_written() -> None:
    below = formula("not " * (MAX_DEPTH - 5) + "a")
    assert Notation(False).expr(below).count("not") == MAX_DEPTH - 5
    assert codes("rule r\n  require " + "not " * (MAX_DEPTH + 5) + "a") == ["E104"]
    assert formula("(" * 5000 + "a" + ")" * 5000) == A
