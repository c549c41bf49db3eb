"""Findings for people: carets under the right characters, both places, help, on any text."""

from __future__ import annotations

import io
import sys
from typing import Any

import pytest

from trackmarshal.cli.output import print_problem
from trackmarshal.diagnostics import text
from trackmarshal.diagnostics.base import Diagnostic, Diagnostics
from trackmarshal.diagnostics.excerpt import width
from trackmarshal.errors import TrackmarshalError
from trackmarshal.source import NOWHERE, SourceFile, Span


class Clash(Diagnostic):
    code = "E999"
    title = "a clash"
    text = "{left} beside {right}"
    label = "a {left}"
    other_label = "a {right}"
    remedy = "{hint}"
    explanation = "Two things that do not go together."

    span: Span
    left: str
    right: str
    hint: str = ""
    other: Span | None = None


class Warned(Clash):
    code = "E998"
    level = "warning"


def span_of(file: SourceFile, part: str, nth: int = 0) -> Span:
    start = -1
    for _ in range(nth + 1):
        start = file.text.index(part, start + 1)
    return Span(file, start, start + len(part))


def shown(file: SourceFile, part: str, **fields: object) -> str:
    values: dict[str, Any] = {"left": "speed", "right": "length", **fields}
    return text.render([Clash(span_of(file, part), **values)])


def test_one_place() -> None:
    file = SourceFile("a.spec", "rule r\n  require p.v < 3 m\n")
    assert shown(file, "p.v", hint="compare it with a speed") == (
        "error[E999]: speed beside length\n"
        " --> a.spec:2:11\n"
        "  |\n"
        "2 |   require p.v < 3 m\n"
        "  |           ^^^ a speed\n"
        "  = help: compare it with a speed\n"
    )


def test_two_places_on_a_line() -> None:
    file = SourceFile("a.spec", "rule r\n  require p.v < 3 m\n")
    assert shown(file, "p.v", other=span_of(file, "3 m")).split("\n")[3:6] == [
        "2 |   require p.v < 3 m",
        "  |           ^^^ a speed",
        "  |                 --- a length",
    ]


def test_a_second_place_nearby_is_in_the_same_excerpt() -> None:
    file = SourceFile("a.spec", "\n" * 7 + "one\ntwo\nthree\nfour\nfive\n")
    assert shown(file, "three", other=span_of(file, "one")).split("\n")[1:] == [
        "  --> a.spec:10:1",
        "   |",
        " 8 | one",
        "   | --- a length",
        " 9 | two",
        "10 | three",
        "   | ^^^^^ a speed",
        "",
    ]
    assert "...\n" in shown(file, "five", other=span_of(file, "one"))


def test_a_second_place_elsewhere_has_its_own_excerpt() -> None:
    file = SourceFile("a.spec", "one\n" + "\n" * 40 + "two\n")
    other = SourceFile("b.spec", "three\n")
    assert shown(file, "two", other=span_of(file, "one")).count("-->") == 1
    assert " ::: a.spec:1:1\n" in shown(file, "two", other=span_of(file, "one"))
    assert shown(file, "one", other=span_of(other, "three")).split("\n")[1:] == [
        " --> a.spec:1:1", "  |", "1 | one", "  | ^^^ a speed", " ::: b.spec:1:1", "  |", "1 | three", "  | ----- a length", "",
    ]  # fmt: skip


def test_a_place_over_several_lines() -> None:
    file = SourceFile("a.spec", "x = (one\n  + two\n\n  + three) y\n")
    assert shown(file, "(one\n  + two\n\n  + three)").split("\n")[3:-1] == [
        "1 | x = (one",
        "  |     ^^^^",
        "2 |   + two",
        "  |   ^^^^^",
        "3 |",
        "4 |   + three) y",
        "  |   ^^^^^^^^ a speed",
    ]
    long = SourceFile("a.spec", "\n".join(f"line {i}" for i in range(30)))
    out = text.render([Clash(Span(long, 0, len(long.text)), "a", "b")])
    assert "line 0\n" in out
    assert "line 29\n" in out
    assert "line 15" not in out


@pytest.mark.parametrize(
    "before",
    [
        "\t",
        "\t\t",
        "x\t",
        "速度",
        "제한 ",
        "e\u0301e\u0301",
        "한",
        "ｆｕｌｌ",
        "🏎",
        "a\u200bb",
        "α",
        "\u202e",
        "½",
        "\x9b31m",
    ],
)
def test_carets_stand_under_the_characters(before: str) -> None:
    file = SourceFile("a.spec", f'{before}WRONG "x"')
    lines = shown(file, "WRONG").split("\n")
    line, carets = lines[3], lines[4]
    assert width(line[: line.index("WRONG")]) == carets.index("^")
    assert carets.count("^") == 5
    assert all(char not in "".join(lines) for char in "\t\u202e\u200b\x9b")


def test_carets_under_wide_characters_are_wide() -> None:
    assert "^^^^ a speed" in shown(SourceFile("a.spec", "x 速度 y"), "速度")


@pytest.mark.parametrize("at", [0, 10, 60, 110, 500, 900, 989])
def test_long_lines_are_cut_around_the_place(at: int) -> None:
    for filler in ("abcdefghi ", "速度 "):
        whole = filler * 100
        line = whole[:at] + "WRONG" + whole[at:]
        lines = shown(SourceFile("a.spec", line), "WRONG").split("\n")
        assert width(lines[3]) <= 120
        assert width(lines[3][: lines[3].index("WRONG")]) == lines[4].index("^")
        assert lines[4].count("^") == 5
        assert "…" in lines[3]


def test_places_far_from_each_other_in_a_long_line_are_both_shown() -> None:
    for filler in ("abcdefghi ", "速度 "):
        file = SourceFile("a.spec", f"FIRST {filler * 1000} WRONG")
        lines = shown(file, "WRONG", other=span_of(file, "FIRST")).split("\n")
        assert max(map(width, lines)) <= 120
        for part, sign in (("FIRST", "-----"), ("WRONG", "^^^^^")):
            at = next(row for row, line in enumerate(lines) if part in line)
            assert width(lines[at][: lines[at].index(part)]) == lines[at + 1].index(sign)


def test_a_place_longer_than_the_window_is_cut() -> None:
    file = SourceFile("a.spec", "x" * 1000)
    lines = text.render([Clash(Span(file, 100, 900), "a", "b")]).split("\n")
    assert width(lines[4].partition(" a a")[0]) <= 120


@pytest.mark.parametrize(("source", "offset"), [("", 0), ("a", 1), ("a\n", 2), ("\n\n", 1), ("a\nb", 3)])
def test_empty_places_show_one_caret(source: str, offset: int) -> None:
    file = SourceFile("a.spec", source)
    assert text.render([Clash(Span(file, offset, offset), "a", "b")]).count("^") == 1


def test_errors_without_a_place() -> None:
    errors = [
        TrackmarshalError("E001", "no such file", file="x.spec", help="check the path"),
        TrackmarshalError("D101", "unequal columns", file="x.jsonl", line=7),
        TrackmarshalError("T301", "no project here"),
    ]
    assert text.render(errors) == (
        "error[E001]: no such file\n --> x.spec\n  = help: check the path\n"
        "\nerror[D101]: unequal columns\n --> x.jsonl:7\n"
        "\nerror[T301]: no project here\n"
    )


def test_what_no_file_holds_is_shown_without_an_excerpt() -> None:
    file = SourceFile("a.spec", "abc")
    assert text.render([Clash(NOWHERE, "a", "b")]) == "error[E999]: a beside b\n --> <built-in>: a a\n"
    assert " ::: <built-in>: a length\n" in shown(file, "abc", other=NOWHERE)


def test_a_raised_collection_is_shown_one_by_one() -> None:
    file = SourceFile("a.spec", "one two")
    both = Diagnostics([Clash(span_of(file, "two"), "a", "b"), Clash(span_of(file, "one"), "c", "d")])
    assert text.render([both]).index("c beside d") < text.render([both]).index("a beside b")


def test_colour_is_only_added() -> None:
    file = SourceFile("a.spec", "rule r\n  require p.v < 3 m\n")
    diagnostic = Clash(span_of(file, "p.v"), "a", "b", "help", span_of(file, "3 m"))
    plain, coloured = text.render([diagnostic]), text.render([diagnostic], colour=True)
    assert "\033" not in plain
    assert "\033[1;31m" in coloured
    import re

    assert re.sub("\033\\[[0-9;]*m", "", coloured) == plain


def test_warnings_say_so() -> None:
    file = SourceFile("a.spec", "abc")
    assert text.render([Warned(span_of(file, "abc"), "a", "b")]).startswith("warning[E998]: ")


def test_nothing_is_shown_of_nothing() -> None:
    assert text.render([]) == ""


def test_what_is_no_diagnostic_is_refused() -> None:
    with pytest.raises(TypeError):
        text.render(["error"])  # type: ignore[list-item]


def test_an_unknown_level_is_refused() -> None:
    class Loud(Clash):
        level = "fatal"

    with pytest.raises(ValueError, match="fatal"):
        text.render([Loud(NOWHERE, "a", "b")])


@pytest.mark.parametrize(
    ("terminal", "environment", "colours"),
    [
        (True, {}, True),
        (True, {"NO_COLOR": ""}, True),
        (True, {"NO_COLOR": "1"}, False),
        (True, {"TERM": "dumb"}, False),
        (False, {}, False),
    ],
)
def test_colours_are_for_terminals_that_want_them(
    monkeypatch: pytest.MonkeyPatch, terminal: bool, environment: dict[str, str], colours: bool
) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    shown = io.StringIO()
    monkeypatch.setattr(shown, "isatty", lambda: terminal)
    monkeypatch.setattr(sys, "stderr", shown)
    print_problem(TrackmarshalError("E410", "no project"))
    assert ("\033[" in shown.getvalue()) == colours
