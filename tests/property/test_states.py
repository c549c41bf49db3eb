"""State machines over the run: what they may be in is what plain machines come to in every way to fill what is not known."""

from __future__ import annotations

import re
from itertools import product
from typing import Any, NamedTuple

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from property.test_over_run import said
from support.length import amount
from support.run_formulas import SIGNALS, formulas, runs
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.evaluation import Evaluator, loads

STATES = ("a", "b", "c", "d")
BACKENDS = ("reference", "numpy")
Known = bool | None


class Way(NamedTuple):
    """A transition, taken on the flag of its number. sources: empty where it leads from all other states. keeps: it remembers a number."""

    target: str
    sources: tuple[str, ...]
    keeps: bool = False


@st.composite
def machines(draw: st.DrawFn) -> tuple[tuple[str, ...], list[Way]]:
    """States, and transitions that lead to each of them and out of it, among others, in any order."""
    states = STATES[: draw(st.integers(2, 4))]
    ways = [Way(after, (before,)) for before, after in zip(states, (*states[1:], states[0]))]
    for _ in range(draw(st.integers(0, 3))):
        target = draw(st.sampled_from(states))
        sources = draw(st.lists(st.sampled_from([one for one in states if one != target]), unique=True))
        ways.append(Way(target, tuple(sources)))
    keeping = [way._replace(keeps=draw(st.booleans())) for way in draw(st.permutations(ways))]
    return states, [keeping[0]._replace(keeps=True), *keeping[1:]]


def declared(states: tuple[str, ...], ways: list[Way], element: str, flag: str, kept: str = "") -> str:
    lines = [f"state m : {{ {', '.join(states)} }}{element} starts a\n"]
    for number, way in enumerate(ways):
        origin = f"from {', '.join(way.sources)} " if way.sources else ""
        lines.append(f"  becomes {way.target} {origin}when {flag.format(number)}\n")
        lines += [f"    remember entry = {kept}\n"] * (way.keeps and bool(kept))
    return "".join(lines)


def number_of(flag: Known) -> float:
    """What has no root leaves a comparison of its root undefined; a number that is missing would make the cycle a gap."""
    return -1.0 if flag is None else float(flag)


# The oracle: machines of which everything is known, one for each way to fill what is not.


class Fully(NamedTuple):
    state: str
    entered: object
    kept: object = None


def moved(one: Fully, ways: list[Way], flags: tuple[bool, ...], t: object) -> Fully:
    for way, holds in zip(ways, flags):
        if holds and one.state != way.target and (not way.sources or one.state in way.sources):
            return Fully(way.target, t, t if way.keeps else one.kept)
    return one


def filled(flags: list[Known]) -> list[tuple[bool, ...]]:
    return list(product(*([True, False] if flag is None else [flag] for flag in flags)))


class Oracle:
    """All machines that one may be."""

    def __init__(self, ways: list[Way]) -> None:
        self.ways, self.possible, self.missed, self.gaps = ways, set[Fully](), 0, 0

    def cycle(self, t: int, flags: list[Known]) -> None:
        if not self.possible:
            self.possible = {Fully("a", t)}
        elif self.missed:
            self.gaps += 1
            self._gap()
        self.missed = 0
        self.possible = {moved(one, self.ways, way, t) for one in self.possible for way in filled(flags)}

    def _gap(self) -> None:
        """Any flags, as often as they may come; when that was is not known, so that it is never the same."""
        unknown = filled([None] * len(self.ways))
        while True:
            more = {
                moved(one, self.ways, way, when)
                for one in self.possible
                for way in unknown
                for when in ("some time", "some other time")
            }
            if more <= self.possible:
                return
            self.possible |= more

    def at_most(self, field: int, limit: int) -> str:
        """Whether a number that is kept, the cycle of its transition, is at most another, where it is the same whatever is not known."""
        values = {one[field] for one in self.possible}
        value = values.pop()
        if values or not isinstance(value, int):
            return "undefined"
        return "satisfied" if value <= limit else "violated"

    def verdict(self, state: str) -> str:
        found = {one.state for one in self.possible}
        return "undefined" if found > {state} else "satisfied" if found == {state} else "violated"


_CYCLES = st.lists(
    st.tuples(st.integers(0, 5), st.lists(st.sampled_from([True, False, False, None]), min_size=7, max_size=7)),
    min_size=1, max_size=10,
)  # fmt: skip


@given(machines(), _CYCLES, st.sampled_from(BACKENDS))
@settings(max_examples=amount(6, 60), deadline=None)
def test_one_of_the_run(machine: tuple[tuple[str, ...], list[Way]], cycles: list[Any], backend: str) -> None:
    states, ways = machine
    fields = ", ".join(f"f{number}: 1" for number in range(len(ways)))
    rules = "".join(f'rule is_{state} "" require m is {state}\n' for state in states)
    rules += 'rule early "" require time_in(m) >= s.now * 1 s - 3 s\nrule kept "" require m.entry <= 3\n'
    evaluator = Evaluator(
        loads(
            f"module t\nsignal s : state {{ now: 1, {fields} }}\n{declared(states, ways, '', 'sqrt(s.f{}) > 0', 's.now')}{rules}"
        ),
        backend=backend,
    )
    run, oracle = evaluator.over_run(), Oracle(ways)
    for number, (refused, flags) in enumerate(cycles):
        if not refused:
            run.missed()
            oracle.missed += bool(oracle.possible)
            continue
        flags = flags[: len(ways)]
        oracle.cycle(number, flags)
        signals = {"s": {"now": number, **{f"f{place}": number_of(flag) for place, flag in enumerate(flags)}}}
        found = run.step(evaluator.read({"id": number, "t": float(number), "signals": signals})).rules
        for state in states:
            result = found[f"is_{state}"]
            assert result.verdict == oracle.verdict(state), (number, state)
            infinite = {"satisfied": "inf", "violated": "-inf", "undefined": "nan"}
            assert str(result.margin) == infinite[result.verdict]
        assert found["early"].verdict == oracle.at_most(1, 3), number
        # After a gap, the engines keep no more of a state that may have been entered in it.
        if not (oracle.gaps and found["kept"].verdict == "undefined"):
            assert found["kept"].verdict == oracle.at_most(2, 3), number


_OF_OBJECTS = st.lists(
    st.tuples(
        st.integers(0, 5),
        st.lists(
            st.none() | st.lists(st.sampled_from([True, False, False, None]), min_size=7, max_size=7),
            min_size=3, max_size=3,
        ),
    ),
    min_size=1, max_size=8,
)  # fmt: skip


@given(machines(), _OF_OBJECTS, st.sampled_from(BACKENDS))
@settings(max_examples=amount(6, 60), deadline=None)
def test_one_of_each_object(
    machine: tuple[tuple[str, ...], list[Way]], cycles: list[Any], backend: str
) -> None:
    """Objects that come and go: whoever was absent for a cycle begins anew, whoever was there before and after a gap does not."""
    states, ways = machine
    fields = "".join(f", f{number}: 1" for number in range(len(ways)))
    rules = "".join(
        f'rule is_{state}_{which} "" for all o in objects where o.n in [{which - 0.1}, {which + 0.1}] require m(o) is {state}\n'
        for state in states
        for which in range(3)
    )
    text = declared(states, ways, " for each o in objects", "sqrt(o.f{}) > 0")
    evaluator = Evaluator(
        loads(f"module t\nsignal objects : set of object {{ n: 1{fields} }}\n{text}{rules}"), backend=backend
    )
    run, lives = evaluator.over_run(), dict[int, Oracle]()
    for number, (refused, there) in enumerate(cycles):
        if not refused:
            run.missed()
            for life in lives.values():
                life.missed += 1
            continue
        t, present = number / 10, [which for which in range(3) if there[which] is not None]
        lives = {which: lives.get(which) or Oracle(ways) for which in present}
        for which in present:
            lives[which].cycle(number, there[which][: len(ways)])
        columns: dict[str, Any] = {
            "id": [str(which) for which in present],
            "n": [float(which) for which in present],
        }
        columns |= {
            f"f{place}": [number_of(there[which][place]) for which in present] for place in range(len(ways))
        }
        found = run.step(evaluator.read({"id": number, "t": t, "signals": {"objects": columns}})).rules
        for state in states:
            for which in range(3):
                wanted = lives[which].verdict(state) if which in lives else "inactive"
                assert found[f"is_{state}_{which}"].verdict == wanted, (number, state, which)


#: What stands for some leaves of generated formulas.
ASKED = {
    "o.v <= ego.v": "m(o) is b", "flag": "light is a", "o.v > 0 m/s": "m(o).entry <= o.v", "ego.w <= 1 m/s": "light.entry > ego.w",
    "ego.v >= ego.w": "time_in(light) <= 0.3 s",
}  # fmt: skip


@given(
    st.lists(formulas(False, False, 1), min_size=3, max_size=4),
    st.lists(formulas(True, False, 1), min_size=3, max_size=4),
    formulas(),
    runs(),
)
@settings(max_examples=amount(6, 60), deadline=None)
def test_both_engines_say_the_same(
    guards: list[str], of_objects: list[str], formula: str, cycles: list[dict[str, Any] | None]
) -> None:
    """With guards that look back, machines that ask for another one, and what looks back and ahead at them."""
    asking = formula
    for leaf, instead in ASKED.items():
        asking = re.sub(rf"(?<!\w){re.escape(leaf)}", instead, asking)
    assume(asking != formula)
    ways = [Way(target, (), True) for target in ("b", "c", "a", "c")]
    light = declared(("a", "b", "c"), ways[: len(guards)], "", "{}", "ego.v").replace(
        "state m", "state light"
    )
    each = declared(("a", "b", "c"), ways[: len(of_objects)], " for each o in objects", "{}", "o.v")
    each = guarded(each, of_objects).replace("flag", "light is c")
    text = f'{SIGNALS}{guarded(light, guards)}{each}rule f "x"\n  require {asking}\n'
    try:
        loads(text)
    except Diagnostics as error:
        assume({one.code for one in error.items} - {"E241", "E242", "E243", "E217"})
        raise
    assert said(text, "reference", cycles) == said(text, "numpy", cycles)


def guarded(text: str, guards: list[str]) -> str:
    for number, guard in enumerate(guards):
        text = text.replace(f"when {number}\n", f"when {guard}\n")
    return text


@pytest.mark.parametrize("backend", BACKENDS)
def test_one_flag_in_two_guards_is_two(backend: str) -> None:
    """Strong Kleene logic takes each guard by itself: that one of the two holds is not seen."""
    text = "module t\nsignal s : state { f: 1 }\nstate m : { a, b } starts a\n  becomes b when sqrt(s.f) > 0\n  becomes b when not sqrt(s.f) > 0\n  becomes a from b when sqrt(s.f) > 0\n"
    evaluator = Evaluator(loads(text + 'rule r "" require m is b\n'), backend=backend)
    run = evaluator.over_run()
    assert (
        run.step(evaluator.read({"t": 0.0, "signals": {"s": {"f": -1.0}}})).rules["r"].verdict == "undefined"
    )
