"""A part of what remembers, in the generated Supervisor, that does not run leaves a gap, and never a past in which nothing was."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from support.cycles import PERIOD, cycle
from support.shared import REPOSITORY
from support.si_cycles import Driver, program
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.source import Source

pytestmark = [pytest.mark.skipif(compiler() is None, reason="no C compiler"), pytest.mark.verifies("S-1-B-4")]

#: Each is violated in some cycles, because of what was in another one.
RULES = """module m
use supervisor.interface
rule once_wet "" require not once[0.05 s, 0.25 s] ego.y > 0.2 m
rule just_wet "" require weak previous ego.y < 0.2 m
rule long_dry "" require ego.y < 0.2 m since[0.15 s, 0.5 s] ego.v > 1 m/s
rule few_wet "" require count(ego.y > 0.2 m) <= 1
rule each_once "" for all o in objects require not once[0.05 s, 0.25 s] o.v > 26 m/s
rule each_just "" for all o in objects require weak previous o.v < 26 m/s
rule stays_dry "" require always[0.05 s, 0.25 s] ego.y < 0.2 m
rule each_stays "" for all o in objects require always[0.05 s, 0.25 s] o.v < 26 m/s
rule two_once "" for all a in objects for all b in objects where a.x < b.x require not once[0.05 s, 0.25 s] a.v + b.v > 51 m/s
rule two_just "" for all a in objects for all b in objects where a.x < b.x require weak previous a.v + b.v < 51 m/s
rule two_stay "" for all a in objects for all b in objects where a.x < b.x require always[0.05 s, 0.25 s] a.v + b.v < 51 m/s
rule both_once "" for all o in objects for all c in obstacles require not once[0.05 s, 0.25 s] (o.v > 26 m/s and c.x > o.x)
course lived = ego for 0.3 s then plan
rule lived_dry "" along lived as c require historically[0.05 s, 0.25 s] c.y < 0.2 m
rule few_lived "" along lived as c require count(c.y > 0.2 m, last: 0.25 s) < 1
"""
#: Of the obstacles, so that pairs with one are known again after an absence.
LASTING = "capacity 3 forget 0.3 s"
_FUNCTION = re.compile(
    r"^static (?:inline )?(?P<type>void|bool|size_t)\s+(?P<name>tm_[a-z0-9_]+)\([^;{]*?\)\s*\{\n",
    re.MULTILINE,
)
#: What moves the items of one window computes what it comes to.
_INSIDE = re.compile(
    r"tm_(once|historically|since|count|recount)_(empty|at|turn|grown|move|add)|tm_lived_lived_(at|add|gap|now)|tm_join_lived_item"
)
#: What comes behind the rules in a step leaves it in doubt when it does not run.
_DOUBT = ("tm_expect", "tm_rate", "tm_watch")
_MEMORY = re.compile(
    r"tm_(expect|rate|watch|\w+_note|note|\w+_remember|remember_\w+|join_\w+|begin_cycle|begin_future|look_ahead|settle|work_out|let_go|follow|worst_said|places_\w+|lives_\w+|pairs_\w+|nanoseconds|ids_differ|id_again)"
)


def names(text: str) -> Iterator[tuple[str, str]]:
    for match in _FUNCTION.finditer(text):
        if _MEMORY.fullmatch(match.group("name")) and not _INSIDE.fullmatch(match.group("name")):
            yield match.group("name"), match.group("type")


@cache
def plain() -> Source:
    """The rules beside the signals of the shipped specs, and no others."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder) / "supervisor"
        own.mkdir()
        given = REPOSITORY / "specs" / "supervisor" / "interface.spec"
        signals, found = re.subn(
            r"(signal obstacles : set of object \{[^}]*\})",
            rf"\1 {LASTING}",
            given.read_text(encoding="utf-8"),
        )
        assert found == 1
        (own / "interface.spec").write_text(signals, encoding="utf-8")
        (Path(folder) / "m.spec").write_text(RULES, encoding="utf-8")
        return program(tm.load([Path(folder)]))


@cache
def source() -> Source:
    """With functions that do nothing while `tmg_emptied` has their number."""
    text = plain().source
    found = [name for name, _ in names(text)]

    def opened(match: re.Match[str]) -> str:
        if match.group("name") not in found:
            return match.group()
        nothing = "" if match.group("type") == "void" else f"({match.group('type')})tmg_answer"
        at = found.index(match.group("name"))
        return f"{match.group()}  if (tmg_emptied == {at}) {{ ++tmg_called; return {nothing}; }}\n"

    head, include, rest = _FUNCTION.sub(opened, text).partition('#include "supervisor.h"\n')
    state = "int tmg_emptied = -1, tmg_answer; unsigned tmg_called;\n"
    return replace(plain(), source=head + include + state + rest)


@cache
def functions() -> list[tuple[str, str]]:
    """Asked for by tests, and not while they are collected: by all workers, of which one runs them."""
    return list(names(plain().source))


VIOLATED = 1


def run(emptied: int, answer: int, during: range) -> list[tuple[bool, bytes, int]]:
    """A drive, a function doing nothing in some of its cycles: whether each was safe, what the rules said, and how often it was called."""
    driver = Driver(source())
    dll = driver.made._dll
    said = []
    for number in range(14):
        ctypes.c_int.in_dll(dll, "tmg_answer").value = answer
        ctypes.c_int.in_dll(dll, "tmg_emptied").value = emptied if number in during else -1
        called = ctypes.c_uint.in_dll(dll, "tmg_called")
        called.value = 0
        given: Any = cycle(number, 2, 0 if number == 6 else 1)
        given.signals["ego"]["y"] = 0.3 if number in (4, 5) else 0.0
        given.signals["objects"]["v"][1] = 27.0 if number in (4, 5) else 25.0
        decision = driver.step(given, number * PERIOD + 0.01)
        said.append((bool(decision.safe), driver.made.verdicts.tobytes(), int(called.value)))
    ctypes.c_int.in_dll(dll, "tmg_emptied").value = -1
    return said


@cache
def whole() -> list[tuple[bool, bytes, int]]:
    return run(-1, 0, range(0))


def test_rules_are_violated_because_of_what_was() -> None:
    count = len(plain().rules)
    never = [
        code.rule.name
        for rule, code in enumerate(plain().rules)
        if VIOLATED not in {each[rule] for _, each, _ in whole()}
    ]
    assert count == 14
    assert never == []
    assert [safe for safe, _, _ in whole()][2:4] == [True] * 2  # nothing can have held for so long before


def test_what_did_not_run_was_not_nothing() -> None:
    """No cycle is safe in which a rule is violated when all parts run."""
    assert len(functions()) > 30
    for emptied, (name, kind) in enumerate(functions()):
        seen = 0
        for answer in (0, 1) if kind != "void" else (0,):
            for during in (range(3, 6), range(4, 5), range(0, 1), range(0, 14)):
                found = run(emptied, answer, during)
                seen += sum(called for _, _, called in found)
                for number, ((safe, _, _), (_, wanted, _)) in enumerate(zip(found, whole())):
                    assert not (safe and VIOLATED in wanted), (name, number, answer, during)
        assert seen or name == "tm_id_again", f"emptying {name}, which is never called, says nothing"


@pytest.mark.parametrize("name", _DOUBT)
def test_a_step_in_doubt_is_a_gap(name: str) -> None:
    """However harmless the cycle: the next one is not safe, though it is when all parts run."""
    found = run([each for each, _ in functions()].index(name), 0, range(2, 3))
    assert [safe for safe, _, _ in found][2:4] == [False, False]
    assert [safe for safe, _, _ in whole()][2:4] == [True, True]
