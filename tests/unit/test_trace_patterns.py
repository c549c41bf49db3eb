"""Patterns of ids, in which `*` stands for any characters."""

from __future__ import annotations

import itertools
from functools import cache

import pytest

from trackmarshal.trace.model import matches


@cache
def fits(name: str, pattern: str) -> bool:
    """What a star means, by its definition: nothing, or one character and then the same again."""
    if not pattern:
        return not name
    if pattern[0] == "*":
        return fits(name, pattern[1:]) or (bool(name) and fits(name[1:], pattern))
    return name[:1] == pattern[0] and fits(name[1:], pattern[1:])


def _texts(letters: str, most: int) -> list[str]:
    return ["".join(each) for n in range(most + 1) for each in itertools.product(letters, repeat=n)]


def test_all_short_names_and_patterns() -> None:
    for pattern in filter(None, _texts("ab*", 5)):
        for name in filter(None, _texts("ab", 5)):
            assert matches(name, (pattern,)) == fits(name, pattern), (name, pattern)


def test_a_dot_is_a_dot_and_lines_are_characters() -> None:
    assert matches("S-1.2", ("S-*.2",))
    assert not matches("S-1x2", ("S-*.2",))
    assert matches("a\nb", ("a*b",))


@pytest.mark.parametrize(
    "pattern", ["*" * 3000 + "x", "*a" * 300 + "*x", "*a*" * 300 + "x", "*".join("ab" * 200) + "*x"]
)
def test_many_stars_take_no_longer(pattern: str) -> None:
    """Of which there would be more ways to share out a name than there is time for."""
    assert not matches("ab" * 500, (pattern,))
    assert matches("ab" * 500 + "x", (pattern,))
