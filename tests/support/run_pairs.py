"""Formulas about pairs of elements at random, of two sets or of one twice, and runs in which both come and go."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from support import run_formulas
from support.run_formulas import formulas

#: How elements are known again: not at all after an absence, or after one of up to so long, of so many.
LASTING = st.just("") | st.builds(
    lambda capacity, tenths: f" capacity {capacity} forget {tenths / 10!r} s",
    st.integers(1, 4),
    st.integers(0, 12),
)
SETS = ("objects", "others")
#: Leaves about one element as ones about two, or about the other one.
_OF_TWO = {
    "o.v <= ego.v": "o.v <= b.v",
    "o.seen is ego.seen": "o.seen is b.seen",
    "o.seen is red": "b.seen is red",
}


def signals(first: str = "", second: str = "") -> str:
    """The signals of two sets, with how their elements are known again."""
    objects = "signal objects : set of object { v: m/s, seen: shade default red }"
    given = run_formulas.SIGNALS
    assert given.count(objects) == 1
    return given.replace(objects, f"{objects}{first}\n{objects.replace('objects', 'others')}{second}")


def paired(ahead: bool = True, depth: int = 2) -> st.SearchStrategy[str]:
    """A formula about the elements that `o` and `b` stand for."""
    return formulas(True, ahead, depth).map(of_two)


def of_two(formula: str) -> str:
    for leaf, instead in _OF_TWO.items():
        formula = formula.replace(leaf, instead)
    return formula


def rules(bodies: list[str], sets: tuple[str, str] = SETS) -> str:
    """Two rules for each formula: of all pairs of two sets, and of any."""
    first, second = sets
    return "".join(
        f'rule f{n} "x" for all o in {first} for all b in {second} require {one}\n'
        f'rule g{n} "x" require exists o in {first}: (for all b in {second} where o.v <= 1 m/s or b.v > 0 m/s: ({one}))\n'
        for n, one in enumerate(bodies)
    )


_OTHERS = st.tuples(
    st.lists(st.sampled_from("abc"), unique=True),
    st.lists(run_formulas._NUMBERS, min_size=3, max_size=3),
    st.lists(st.sampled_from(["green", "red", "yellow", 1.5]), min_size=3, max_size=3),
)


def runs() -> st.SearchStrategy[list[dict[str, Any] | None]]:
    """Cycles as cases, with both sets; None: one that is refused."""
    each = st.tuples(run_formulas._CYCLE, _OTHERS)
    return st.lists(each, min_size=1, max_size=14).map(_cycles)


def _cycles(drawn: list[Any]) -> list[dict[str, Any] | None]:
    cycles = run_formulas._cycles([one for one, _ in drawn])
    for cycle, (_, (there, speeds, seen)) in zip(cycles, drawn):
        if cycle is not None:
            many = len(there)
            cycle["signals"]["others"] = {"id": there, "v": speeds[:many], "seen": seen[:many]}
    return cycles
