"""A part of the generated Supervisor that does not run is never taken for one that found nothing."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from support.cycles import PERIOD, cycle
from support.si_cycles import Driver, program
from support.supervised import shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.parts import functions
from trackmarshal.backends.c.said import Said
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.step import Stepper

pytestmark = [pytest.mark.skipif(compiler() is None, reason="no C compiler"), pytest.mark.verifies("S-1-B-4")]

_FUNCTION = re.compile(
    r"^(?:static (?:inline )?)?(?P<type>void|bool|size_t|int|double|tm_status|tm_configured)\s+(?P<name>tm_[a-z0-9_A-Z]+)\([^;{]*?\)\s*\{\n",
    re.MULTILINE,
)
#: What computes numbers, and geometry below what prepares a shape: nobody can see that a number is another one.
_NUMBERS = set(functions()) - {
    "tm_add", "tm_same_text", "tm_named", "tm_read", "tm_due_by", "tm_pose_at", "tm_decide", "tm_undefined", "tm_conclude",
    "tm_conclude_any", "tm_fill_table",
    "tm_make_polygon", "tm_make_corridor", "tm_make_line", "tm_make_centre",
}  # fmt: skip
#: Of what answers yes or no, an answer that is no claim: `something is not known` makes the rule be computed the longer way, and
#: where nothing was found before, nothing is named.
_HONEST = re.compile(r"tm_rule_\w+_known|tm_conclude|tm_named|tm_same_text")
_DRIVING, _STORED = 1, 2


def names(text: str) -> Iterator[tuple[str, str]]:
    """Name and type of every function that is emptied; once where it stands in the source twice, for different targets."""
    found = {match.group("name"): match.group("type") for match in _FUNCTION.finditer(text)}
    yield from ((name, kind) for name, kind in found.items() if name not in _NUMBERS)


def switched(text: str) -> str:
    """The source with functions that do nothing while `tmg_emptied` has their number."""
    found = [name for name, _ in names(text)]

    def opened(match: re.Match[str]) -> str:
        name, kind = match.group("name"), match.group("type")
        if name not in found:
            return match.group()
        nothing = {"void": "", "tm_configured": "tmg_nothing"}.get(kind, f"({kind})tmg_answer")
        return f"{match.group()}  if (tmg_emptied == {found.index(name)}) {{ ++tmg_called; return {nothing}; }}\n"

    changed = _FUNCTION.sub(opened, text)
    head, include, rest = changed.partition('#include "supervisor.h"\n')
    assert include
    state = 'int tmg_emptied = -1, tmg_answer; unsigned tmg_called; static const tm_configured tmg_nothing = {TM_OK, ""};\n'
    return head + include + state + rest


@cache
def as_it_is() -> Source:
    return program(shipped())


@cache
def source() -> Source:
    return replace(as_it_is(), source=switched(as_it_is().source))


@cache
def emptied() -> list[tuple[str, str]]:
    """Asked for by tests, and not while they are collected: by all workers, of which one runs them."""
    return list(names(as_it_is().source))


def number_of(name: str) -> int:
    return [each for each, _ in emptied()].index(name)


class Bold(Stepper):
    """Drives with what tm_init has put in, whatever came of it."""

    def _configure(self, *given: Any) -> None:
        pass


@dataclass
class Run:
    """What was said in each step, and whether the function was called in it, or when the context was made."""

    said: list[Said]
    called: list[bool]
    reasons: list[set[str]]
    verdicts: list[bytes]


@cache
def run(function: int, answer: int) -> Run:
    """A drive with cycles of all sorts, the function of a number doing nothing."""
    ctypes.c_int.in_dll(dll(), "tmg_answer").value = answer
    ctypes.c_int.in_dll(dll(), "tmg_emptied").value = function
    called = ctypes.c_uint.in_dll(dll(), "tmg_called")
    called.value = 0
    driver = Driver(source(), Bold)
    found = Run([], [], [], [])
    at_first = called.value
    for number in range(16):
        given: Any = cycle(number)
        more: dict[str, Any] = {}
        driver.took = 0.01
        match number:
            case 3:
                given.driving["v"][5] = np.nan
            case 4:
                given = None  # and the next one is late
            case 7:
                given.driving["a"][:] = 40.0  # no friction for this
            case 8:
                more["found"] = [("wrong_type", "objects", "x", None)]
            case 10:
                driver.took = 0.07
            case 11 | 12:
                given.signals["ego"]["x"] += 50.0  # far from what is stored
                given.emergency["v"][-1] = 1.0
            case 13:
                given.signals["track"] = {
                    **given.signals["track"],
                    "left": given.signals["track"]["left"] + 0.01,
                }
            case 14:
                crossing = given.signals["track"]["left"].copy()
                crossing[100, 1] = -7.0
                given.signals["track"] = {**given.signals["track"], "left": crossing}
            case _:
                pass
        called.value = 0
        found.said.append(driver.step(given, number * PERIOD + 0.01, **more))
        found.called.append(at_first + called.value > 0)
        found.reasons.append({reason.name for reason in driver.made.reasons(found.said[-1])})
        found.verdicts.append(driver.made.verdicts.tobytes())
    return found


@cache
def dll() -> ctypes.CDLL:
    return Driver(source(), Bold).made._dll


def whole() -> Run:
    return run(-1, 0)


def test_the_drive_has_cycles_of_all_sorts() -> None:
    said = whole().said
    assert [one.safe for one in said] == [1, 1, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 1]
    assert {one.driven for one in said} == {0, _DRIVING, _STORED}
    assert {"not_finite", "missing_cycle", "none", "wrong_type", "overrun", "not_at_rest", "apart", "none_stored"} <= set().union(*whole().reasons)  # fmt: skip


def test_a_function_that_does_nothing_makes_no_cycle_safe() -> None:
    assert len(emptied()) > 100
    for function, (name, kind) in enumerate(emptied()):
        for answer in (0, 1) if kind in ("bool", "int") else (0,):
            found = run(function, answer)
            if answer == 0 and _HONEST.fullmatch(name):
                assert found.verdicts == whole().verdicts or name.startswith(("tm_named", "tm_same")), name
                assert [one.safe for one in found.said] == [one.safe for one in whole().said], name
                continue
            for step, (said, other, called) in enumerate(zip(found.said, whole().said, found.called)):
                if called:
                    assert (said.safe, said.driven == _DRIVING) == (0, False), (name, step, answer)
                if other.driven == 0:
                    assert said.driven == 0, (name, step, answer)


def test_every_function_is_called() -> None:
    """Otherwise, that nothing comes of emptying it means nothing."""
    uncalled = []
    for number, (name, kind) in enumerate(emptied()):
        if not any(any(run(number, answer).called) for answer in ((0, 1) if kind == "bool" else (0,))):
            uncalled.append(name)
    rare = re.compile(r"tm_rule_\w+_any|tm_rule_\w+|tm_conclude_any|tm_incomplete|tm_stored_\w+|tm_set_\w+")
    assert [name for name in uncalled if not rare.fullmatch(name)] == []


def test_parts_that_did_not_run_are_named() -> None:
    for name, part in (
        ("tm_door", "door"),
        ("tm_judge", "judge"),
        ("tm_watch", "watchdog"),
        ("tm_advance", "machine"),
    ):
        driver_said = run(number_of(name), 0)
        assert "incomplete" in driver_said.reasons[0], part
