"""The grammar is free of conflicts and of colliding terminals, and its closed lists are closed."""

from __future__ import annotations

import re
from functools import cache
from importlib.util import find_spec
from unittest import mock

import pytest
from lark import Lark

from trackmarshal.syntax.grammar import make_parser
from trackmarshal.syntax.keywords import CLAUSES, DECLARATIONS, RESERVED
from trackmarshal.syntax.names import GREEK, lettered, spelled
from trackmarshal.units import UNITS

#: Lark's strict mode, which refuses colliding terminals, needs interegular.
STRICT = find_spec("interegular") is not None


@cache
def parser() -> Lark:
    with mock.patch("lark.lexer.has_interegular", False):  # it would look for collisions, strict or not
        return make_parser()


@pytest.mark.acceptance  # whoever writes the tables anew has it checked as well
@pytest.mark.skipif(not STRICT, reason="lark's strict mode needs interegular")
def test_strict_mode_finds_no_collision() -> None:
    assert make_parser(strict=True).options.strict


def test_every_declaration_and_clause_keyword_is_in_the_grammar() -> None:
    terminals = {terminal.name for terminal in parser().terminals}
    words = {word for words in CLAUSES.values() for word in words} | set(DECLARATIONS)
    assert {f"_{word.upper()}" for word in words} <= terminals


@pytest.mark.parametrize(
    "before",
    [
        "rule r require", "rule r require a", "rule r require a and b + c", "rule r let a = b.c", "rule r require always",
        "rule r require if a", "rule r require for all", "rule r require f(a", "test r given a = b", "test r given a =",
        "constrain a", "state a : { b, c } starts b becomes c when d", "predicate p(a: m) = b",
    ],
)  # fmt: skip
def test_where_a_name_can_stand_every_word_is_reserved(before: str) -> None:
    # Otherwise a name could be taken for the word, or the word for a name.
    interactive = parser().parse_interactive(before)
    interactive.exhaust_lexer()
    patterns = {terminal.name: terminal.pattern.value for terminal in parser().terminals}
    accepted = interactive.accepts()  # type: ignore[no-untyped-call]
    assert "NAME" in accepted
    spelled_out = accepted & patterns.keys() - {"NAME", "NUMBER", "QUANTITY", "UNIT", "STRING"}
    words = {
        word for name in spelled_out for word in re.findall(r"[a-z]{2,}", patterns[name].split("(?!")[0])
    } - {"all"}
    assert words <= RESERVED
    assert words


@pytest.mark.parametrize("word", sorted(RESERVED))
def test_a_reserved_word_is_no_name(word: str) -> None:
    (name,) = (terminal for terminal in parser().terminals if terminal.name == "NAME")
    pattern = re.compile(name.pattern.to_regexp())
    assert not pattern.match(word)
    assert pattern.fullmatch(f"{word}_")
    assert pattern.fullmatch(f"q{word}")


@pytest.mark.parametrize("unit", sorted(UNITS))
def test_a_unit_is_read_as_a_unit(unit: str) -> None:
    tree = parser().parse(f"param x : {unit} = 3 {unit}")
    tokens = [(token.type, str(token)) for token in tree.scan_values(lambda value: True) if token is not None]
    assert tokens == [("NAME", "x"), ("UNIT", unit), ("QUANTITY", f"3 {unit}")]


@pytest.mark.parametrize(
    "word", ["requirea", "thenb", "inside", "orbit", "notes", "iffy", "xorb", "weaker", "settle", "untilnow"]
)
def test_a_keyword_ends_at_a_word_end(word: str) -> None:
    tree = parser().parse(f"rule r require {word}")
    assert word in tree.pretty()


@pytest.mark.parametrize("letter", sorted(GREEK))
def test_greek_letters_have_one_spelling(letter: str) -> None:
    assert spelled(letter) == GREEK[letter]
    assert spelled(lettered(GREEK[letter])) == GREEK[letter]
    assert spelled(f"a_{letter}") == f"a_{GREEK[letter]}"
    assert parser().parse(f"rule r require {letter}").pretty()
