"""Parentheses that change nothing: the formatter keeps them, and nothing else sees them."""

from __future__ import annotations

from support.agreement import compiled
from trackmarshal.ir.description import describe
from trackmarshal.source import SourceFile
from trackmarshal.syntax.format import format_text

HEAD = "module made\nsignal plan : trajectory { t: s increasing, v: m/s, a: m/s^2 }\n"
PLAIN = """define twice(x: m/s) -> m/s = 2 * x
rule r "Title"
  for all p in plan where p.v > 1 m/s and p.a > 0 m/s^2
  except p.v < 0 m/s or p.v > 90 m/s and p.a > 1 m/s^2 "why"
  let limit = 3 m/s + 2 * p.v - 1 m/s
  require twice(p.v) <= limit or p.v < 5 m/s and not p.a > 2 m/s^2 implies p.v^2 < 9 m^2/s^2
"""
CLEAR = """define twice(x: m/s) -> m/s = (2) * ((x))
rule r "Title"
  for all p in (plan) where (p.v > 1 m/s) and (p.a > 0 m/s^2)
  except p.v < 0 m/s or (p.v > 90 m/s and p.a > 1 m/s^2) "why"
  let limit = (3 m/s + (2 * p.v)) - 1 m/s
  require (twice((p.v)) <= limit or ((p.v < 5 m/s) and (not (p.a > 2 m/s^2)))) implies ((p).v^2) < (9 m^2/s^2)
"""


def test_they_change_neither_the_rule_nor_its_fingerprint() -> None:
    assert "(plan)" in format_text(SourceFile("t.spec", HEAD + CLEAR))
    plain, clear = compiled(HEAD + PLAIN), compiled(HEAD + CLEAR)
    assert [rule.fingerprint for rule in plain.rules] == [rule.fingerprint for rule in clear.rules]
    assert plain.fingerprint == clear.fingerprint
    for one, other in zip(plain.rules, clear.rules, strict=True):
        assert one.formula is not None
        assert other.formula is not None
        assert describe(one.formula) == describe(other.formula)


def test_those_that_change_something_change_the_fingerprint() -> None:
    plain = compiled(HEAD + PLAIN)
    other = compiled(
        HEAD
        + PLAIN.replace("limit or p.v < 5 m/s and not", "limit and (p.v < 5 m/s or not").replace(
            "implies", ") implies"
        )
    )
    assert plain.fingerprint != other.fingerprint
