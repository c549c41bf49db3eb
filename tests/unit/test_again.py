"""What was compiled with other modules is taken over where all that it rests on is the same, and nowhere else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from trackmarshal.semantics.compile import Compiled, compile_paths

SIGNALS = """module signals
signal ego : state { v: m/s, a: m/s^2 }
"""
BASE = """module base
use signals
param most : m/s = 10 m/s
predicate slow(limit: m/s) = ego.v <= limit
rule limited "Slow"
  require slow(most)
rule both "Slow, and gently"
  require ego.v <= most and ego.a <= 2 m/s^2
"""
MORE = """module more
use signals
use base
rule gentle "Gently"
  require ego.a <= 1 m/s^2
"""
ASSUMED = """module base
use signals
assume A-1 "It is measured"
  owner "someone"
"""
ASSUMING = """module assumed
use signals
rule assumed "Assumed"
  assuming A-1
  require ego.v <= 1 m/s
"""
STATE = """module states
use signals
state lamp : { off, on } starts off
  becomes on when ego.v > 1 m/s
  becomes off when ego.v <= 1 m/s
"""
ASKING = """module asking
use states
rule dark "Dark"
  require lamp is off
"""


def files(folder: Path, **texts: str) -> dict[str, Path]:
    folder.mkdir(exist_ok=True)
    for name, text in texts.items():
        (folder / f"{name}.spec").write_text(text, encoding="utf-8")
    return {name: folder / f"{name}.spec" for name in texts}


def taken(now: Compiled, before: Compiled) -> set[str]:
    """The names of rules that were not made again."""
    known = {id(rule) for rule in before.spec.rules}
    return {rule.name for rule in now.spec.rules if id(rule) in known}


def as_alone(now: Compiled, alone: Compiled) -> bool:
    """Whether it is what a compilation of nothing else comes to."""
    return (
        now.spec.fingerprint == alone.spec.fingerprint
        and [(rule.name, rule.fingerprint, rule.unit, str(rule.span)) for rule in now.spec.rules]
        == [(rule.name, rule.fingerprint, rule.unit, str(rule.span)) for rule in alone.spec.rules]
        and [(found.code, str(found.span), found.message) for found in now.found]
        == [(found.code, str(found.span), found.message) for found in alone.found]
    )


def test_rules_of_the_same_modules_are_taken_over(tmp_path: Path) -> None:
    paths = files(tmp_path, signals=SIGNALS, base=BASE, more=MORE)
    before = compile_paths([tmp_path], tmp_path)
    assert not before.found
    for asked in (["base"], ["more"], ["signals", "more", "base"]):
        given = [paths[name] for name in asked]
        now, alone = compile_paths(given, tmp_path, before), compile_paths(given, tmp_path)
        assert taken(now, before) == {rule.name for rule in alone.spec.rules}
        assert as_alone(now, alone)


CHANGES: Mapping[str, tuple[Mapping[str, str], set[str]]] = {
    "a rule": ({"base": BASE.replace("2 m/s^2", "3 m/s^2")}, set()),
    "a value": ({"base": BASE.replace("10 m/s", "11 m/s")}, set()),
    "what is used by what is used": ({"signals": SIGNALS.replace("a: m/s^2", "a: m/s^2, kappa: 1/m")}, set()),
    "a module of its own": ({"more": MORE.replace("1 m/s^2", "3 m/s^2")}, {"limited", "both"}),
    "a scale for all": ({"more": MORE + "scale m/s = 5 m/s\n"}, set()),
    "a second event": ({"more": MORE + 'event yellow "a flag"\n'}, set()),
    "a second signal": ({"more": MORE + "signal other : state { v: m/s }\n"}, set()),
    "an error beside them": ({"more": MORE.replace("1 m/s^2", "1 m")}, {"limited", "both"}),
}


@pytest.mark.parametrize("change", CHANGES)
def test_what_rests_on_something_else_is_made_again(change: str, tmp_path: Path) -> None:
    texts, expected = CHANGES[change]
    paths = files(tmp_path, signals=SIGNALS, base=BASE, more=MORE)
    before = compile_paths([tmp_path], tmp_path)
    files(tmp_path, **texts)
    now, alone = compile_paths([paths["more"]], tmp_path, before), compile_paths([paths["more"]], tmp_path)
    assert taken(now, before) == expected
    assert as_alone(now, alone)


def test_a_scale_that_was_there_is_gone(tmp_path: Path) -> None:
    paths = files(
        tmp_path, signals=SIGNALS, base=BASE, more=MORE + "scale m/s = 5 m/s\nscale m/s^2 = 2 m/s^2\n"
    )
    before = compile_paths([tmp_path], tmp_path)
    now, alone = compile_paths([paths["base"]], tmp_path, before), compile_paths([paths["base"]], tmp_path)
    assert not before.found
    assert not taken(now, before)
    assert as_alone(now, alone)


def test_an_assumption_that_is_not_there_any_more_is_reported(tmp_path: Path) -> None:
    paths = files(tmp_path, signals=SIGNALS, base=ASSUMED, assumed=ASSUMING)
    before = compile_paths([tmp_path], tmp_path)
    assert not before.found
    both = compile_paths([paths["assumed"], paths["base"]], tmp_path, before)
    assert taken(both, before) == {"assumed", "A-1"}
    now = compile_paths([paths["assumed"]], tmp_path, before)
    assert as_alone(now, compile_paths([paths["assumed"]], tmp_path))
    assert now.errors


def test_a_state_that_nothing_asks_for_any_more_is_reported(tmp_path: Path) -> None:
    paths = files(tmp_path, signals=SIGNALS, states=STATE, asking=ASKING)
    before = compile_paths([tmp_path], tmp_path)
    assert not before.found
    for asked in (["states"], ["asking"]):
        given = [paths[name] for name in asked]
        now = compile_paths(given, tmp_path, before)
        assert as_alone(now, compile_paths(given, tmp_path))
        assert bool(now.found) == (asked == ["states"])


def test_nothing_is_taken_from_what_had_a_finding(tmp_path: Path) -> None:
    paths = files(tmp_path, signals=SIGNALS, base=BASE, more=MORE.replace("1 m/s^2", "1 m"))
    before = compile_paths([tmp_path], tmp_path)
    assert before.found
    now = compile_paths([paths["base"]], tmp_path, before)
    assert not taken(now, before)
    assert as_alone(now, compile_paths([paths["base"]], tmp_path))
