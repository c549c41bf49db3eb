"""Counts and `since` of generated C over cycles of which not all is known, against all that may have been in them."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from functools import reduce
from itertools import product
from operator import eq, ge, gt, le, lt, ne
from pathlib import Path
from typing import Any

import pytest

from trackmarshal.backends.c import parts
from trackmarshal.backends.c.build import compiler, small_library
from trackmarshal.backends.c.functions.types import CASES, TALLY

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

#: What Python calls: the functions themselves are a part of the programs that need them.
CALLED = """
void no_tally(tm_tally *out) { *out = tm_no_tally(); }
void any_tally(uint64_t cycles, int anew, tm_tally *out) { *out = tm_any_tally(cycles, anew != 0); }
void tally_of(const tm_cases *counted, const tm_cases *reset, tm_tally *out) { *out = tm_tally_of(*counted, *reset); }
void tallied(const tm_tally *newer, const tm_tally *older, tm_tally *out) { *out = tm_tallied(*newer, *older); }
void no_step(tm_steps *out) { *out = tm_no_step(); }
void any_step(tm_steps *out) { *out = tm_any_step(); }
void step_after(const tm_steps *newer, const tm_steps *older, tm_steps *out) { *out = tm_step_after(*newer, *older); }
"""
COMPARED = {"less": lt, "at_most": le, "greater": gt, "at_least": ge, "equal": eq, "unequal": ne}
MARGINS: dict[str, Callable[[float, float], float]] = {
    "less": lambda n, limit: limit - n, "at_most": lambda n, limit: limit - n, "greater": lambda n, limit: n - limit,
    "at_least": lambda n, limit: n - limit, "equal": lambda n, limit: -abs(n - limit), "unequal": lambda n, limit: abs(n - limit),
}  # fmt: skip
STEPS = "typedef struct {\n  tm_cases goal;\n  tm_cases hold;\n} tm_steps;\n"


class Cases(ctypes.Structure):
    _fields_ = [
        ("worst", ctypes.c_double), ("best", ctypes.c_double), ("worst_sat", ctypes.c_bool), ("best_sat", ctypes.c_bool)
    ]  # fmt: skip

    @property
    def said(self) -> tuple[float, float, bool, bool]:
        return self.worst, self.best, self.worst_sat, self.best_sat


class Tally(ctypes.Structure):
    _fields_ = [
        ("sure", ctypes.c_uint64), ("possible", ctypes.c_uint64), ("surely_anew", ctypes.c_bool), ("possibly_anew", ctypes.c_bool)
    ]  # fmt: skip

    @property
    def said(self) -> tuple[int, int, bool, bool]:
        return self.sure, self.possible, self.surely_anew, self.possibly_anew


class Steps(ctypes.Structure):
    _fields_ = [("goal", Cases), ("hold", Cases)]


#: Margins of what holds, of what does not, and of what is not known.
TRUE, FALSE, MAYBE = (
    Cases(1.0, 2.0, True, True),
    Cases(-3.0, -0.5, False, False),
    Cases(-1.5, 0.5, False, True),
)
#: In Kleene's logic each may be any of these.
KLEENE = {False: (FALSE, {False}), True: (TRUE, {True}), None: (MAYBE, {False, True})}


@pytest.fixture(scope="module")
def called(tmp_path_factory: pytest.TempPathFactory) -> Any:
    text = CALLED + "".join(
        f"void {name}(const tm_tally *n, double limit, tm_cases *out) {{ *out = tm_count_{name}(*n, limit); }}\n"
        for name in COMPARED
    )
    known = parts.functions()
    head = (
        "#include <float.h>\n#include <math.h>\n#include <stdbool.h>\n#include <stddef.h>\n#include <stdint.h>\n"
        "#define TM_INF ((double)INFINITY)\n#define TM_NAN ((double)NAN)\n"
    )
    path: Path = tmp_path_factory.mktemp("tallies") / "tallies.c"
    path.write_text(
        head + CASES + STEPS + TALLY + "\n".join(known[name] for name in parts.needed([text])) + text,
        encoding="utf-8",
    )
    library = ctypes.CDLL(str(small_library(path)))
    library.any_tally.argtypes = [ctypes.c_uint64, ctypes.c_int, ctypes.c_void_p]
    for name in COMPARED:
        getattr(library, name).argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p]
    return library


def of(kind: type[Any], function: Any, *given: Any) -> Any:
    """What a function of C puts into its last argument."""
    out = kind()
    function(
        *(ctypes.byref(one) if isinstance(one, ctypes.Structure) else one for one in given), ctypes.byref(out)
    )
    return out


def joined(kind: type[Any], function: Any, cycles: Sequence[Any], empty: Any) -> tuple[Any, Any]:
    """Cycles, the oldest first, each after those before it, and in the other order, as windows join them by turns."""
    after = reduce(lambda older, newer: of(kind, function, newer, older), cycles, empty)
    before = reduce(lambda newer, older: of(kind, function, newer, older), reversed(cycles), empty)
    return after, before


#: A cycle that counts, and starts the count anew, surely, possibly or not; or so many that are missing, and whether the count may start anew.
CYCLES: list[tuple[Any, Any]] = [*product(KLEENE, KLEENE), *product((1, 2), ("may", "not"))]


def numbers(cycles: Sequence[tuple[Any, Any]]) -> set[int]:
    """All that a count may be."""
    found = {0}
    for counted, anew in cycles:
        again = {False, True} if anew == "may" else {False} if anew == "not" else KLEENE[anew][1]
        each = set(range(counted + 1)) if anew in ("may", "not") else KLEENE[counted][1]
        found = {(0 if starts else n) + more for n in found for starts, more in product(again, each)}
    return found


def test_a_tally_is_from_the_least_to_the_most_that_may_have_counted(called: Any) -> None:
    made = {
        cycle: of(Tally, called.any_tally, cycle[0], cycle[1] == "may")
        if cycle[1] in ("may", "not")
        else of(Tally, called.tally_of, KLEENE[cycle[0]][0], KLEENE[cycle[1]][0])
        for cycle in CYCLES
    }
    empty = of(Tally, called.no_tally)
    for length in range(4):
        for cycles in product(CYCLES, repeat=length):
            one, other = joined(Tally, called.tallied, [made[cycle] for cycle in cycles], empty)
            resets = [{"may": None, "not": False}.get(anew, anew) for _, anew in cycles]
            found = numbers(cycles)
            expected = (min(found), max(found), True in resets, any(anew is not False for anew in resets))
            assert one.said == other.said == expected, cycles


@pytest.mark.parametrize("name", COMPARED)
def test_a_comparison_holds_where_each_number_of_a_tally_meets_it(name: str, called: Any) -> None:
    """Margins are those of the number with the least and of that with the greatest one, of whole numbers; of a limit that is none, nothing is known."""
    for sure in range(5):
        for possible in range(sure, 6):
            tally, each = Tally(sure, possible, False, False), range(sure, possible + 1)
            for limit in (-1.0, 0.0, 0.25, 1.0, 1.5, 2.0, 2.75, 3.0, 4.0, 5.0, 6.5):
                held = [COMPARED[name](n, limit) for n in each]
                margins = [MARGINS[name](n, limit) for n in each]
                said = of(Cases, getattr(called, name), tally, limit).said
                assert said == (min(margins), max(margins), all(held), any(held)), (sure, possible, limit)
            for limit in (math.nan, math.inf, -math.inf):
                said = of(Cases, getattr(called, name), tally, limit).said
                assert said == (-math.inf, math.inf, False, True)


def test_what_held_since_something_is_worked_out_in_any_order(called: Any) -> None:
    """After each cycle: its goal, or what held before it and goes on; of no cycle, nothing held."""

    def either(a: Any, b: Any) -> Any:
        return tuple(map(max, a, b))

    def both(a: Any, b: Any) -> Any:
        return tuple(map(min, a, b))

    empty, unknown = of(Steps, called.no_step), of(Steps, called.any_step)
    anything = (-math.inf, math.inf, False, True)
    assert (unknown.goal.said, unknown.hold.said) == (anything, anything)
    known = [Steps(KLEENE[goal][0], KLEENE[hold][0]) for goal, hold in product(KLEENE, KLEENE)]
    for length in range(4):
        for cycles in product([*known, unknown], repeat=length):
            one, other = joined(Steps, called.step_after, cycles, empty)
            held: Any = (-math.inf, -math.inf, False, False)
            goes_on: Any = (math.inf, math.inf, True, True)
            for cycle in cycles:
                held = either(cycle.goal.said, both(cycle.hold.said, held))
                goes_on = both(cycle.hold.said, goes_on)
            assert one.goal.said == other.goal.said == held
            assert one.hold.said == other.hold.said == goes_on
