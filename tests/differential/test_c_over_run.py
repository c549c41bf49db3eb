"""Rules over the run in generated C: what they say in every cycle is what the other evaluators say, to the last bit."""

from __future__ import annotations

import ctypes
import json
import math
import os
import random
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

from property.test_states import ASKED, Way, declared, guarded
from support import run_pairs
from support.length import AT_LENGTH, amount, at_length
from support.run_formulas import SIGNALS, formulas, runs
from trackmarshal.backends.c import program
from trackmarshal.backends.c.library import Library
from trackmarshal.backends.c.program import CProgram
from trackmarshal.backends.c.source import Source
from trackmarshal.cli.main import main
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime.verdict import VERDICTS, About

#: Rules of one program, so that not each needs a compiler.
RULES = 12
EXAMPLES = int(os.environ.get("TRACKMARSHAL_EXAMPLES", "3"))
#: Runs of one program.
RUNS = amount(3, 8)
OTHERS = ("reference", "numpy")


def said(evaluators: dict[str, Evaluator], cycles: list[dict[str, Any] | None]) -> dict[str, list[Any]]:
    """By backend, verdicts and margins of all rules in every cycle, of which cycles each is about, and what is said at the end."""
    found: dict[str, list[Any]] = {}
    for name, evaluator in evaluators.items():
        run, each = evaluator.over_run(), list[Any]()
        for cycle in cycles:
            if cycle is None:
                run.missed()
                continue
            result = run.step(evaluator.read(cycle))
            each.append(
                {
                    rule: (one.verdict, exact(one.margin), told(one.about))
                    for rule, one in result.rules.items()
                }
            )
        each.append({rule: told(said) for rule, said in run.end().items()})
        found[name] = each
    return found


def told(about: tuple[About, ...]) -> list[tuple[object, str, str, bool]]:
    return [(one.cycle, one.verdict, exact(one.margin), one.final) for one in about]


def exact(margin: float) -> str:
    return "nan" if math.isnan(margin) else float(margin).hex()


def spec_of(drawn: list[str]) -> str:
    return SIGNALS + "".join(f'rule f{number} "x"\n  require {one}\n' for number, one in enumerate(drawn))


_CLAUSES = st.builds(
    lambda whenever, guard, but, body: (
        f'whenever {whenever}\n  for all o in objects where {guard}\n  except {but} "why"\n  require {body}'
    ),
    formulas(depth=1), formulas(True, depth=1), formulas(True, depth=1),
    formulas(True, depth=2),
)  # fmt: skip
_SETTINGS = settings(
    derandomize=not AT_LENGTH, max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), phases=[Phase.explicit, Phase.generate],
)  # fmt: skip


@given(
    st.lists(formulas(), min_size=RULES, max_size=RULES),
    st.lists(_CLAUSES, min_size=3, max_size=3),
    st.lists(runs(), min_size=RUNS, max_size=RUNS),
)
@_SETTINGS
def test_all_three_agree(
    drawn: list[str], clauses: list[str], several: list[list[dict[str, Any] | None]]
) -> None:
    text = spec_of(drawn) + "".join(f'rule g{number} "x"\n  {one}\n' for number, one in enumerate(clauses))
    spec = loads(text)
    evaluators = {name: Evaluator(spec, backend=name) for name in (*OTHERS, "c")}
    for cycles in several:
        found = said(evaluators, cycles)
        assert found["c"] == found["reference"] == found["numpy"], text


@given(
    st.sampled_from(["", " capacity 3", " capacity 5"]),
    st.sampled_from([run_pairs.SETS, ("objects", "objects")]),
    st.lists(run_pairs.paired(), min_size=RULES // 2, max_size=RULES // 2),
    st.lists(run_pairs.runs(), min_size=RUNS, max_size=RUNS),
)
@_SETTINGS
def test_pairs_of_elements(
    capacity: str, sets: tuple[str, str], drawn: list[str], several: list[list[dict[str, Any] | None]]
) -> None:
    """What has a history for each pair, of two sets or of one twice."""
    text = run_pairs.signals(capacity, capacity) + run_pairs.rules(drawn, sets)
    evaluators = {name: Evaluator(loads(text), backend=name) for name in (*OTHERS, "c")}
    for cycles in several:
        found = said(evaluators, cycles)
        assert found["c"] == found["reference"] == found["numpy"], text


class Again(Library):
    """In the memory that the one before leaves, as a context of a user's is with which a run is begun anew."""

    before: Library | None = None

    def __init__(self, source: Source, sizes: dict[str, int]) -> None:
        super().__init__(source, sizes)
        if Again.before is not None:
            assert sizes == Again.before.sizes
            ctypes.memmove(self.context, Again.before.context, self.dll.tmg_size())
            self.status = self.dll.tmg_init(self.context)
        Again.before = self


def one_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each run begins in what the one before has left."""
    monkeypatch.setattr(Again, "before", None)
    monkeypatch.setattr(program, "Library", Again)


#: What is kept of a run, of elements, and of what is still open.
ANEW = """module m
signal lights : set of object { v: m/s }
event flag
rule a "" require previous flag or once[0.1 s, 0.9 s] flag
rule b "" for all o in lights require historically[0.1 s, 0.3 s] o.v > -1 m/s
rule c "" for all o in lights require count(o.v > 0 m/s, reset: o.v > 1 m/s) <= 3
rule d "" for all o in lights for all l in lights require not rising(o.v > l.v)
rule e "" for all o in lights require eventually[0 s, 0.3 s] o.v > 0 m/s
state m : { p, q } for each o in lights starts p
  becomes q when o.v > 1 m/s
  becomes p when o.v < 0 m/s
rule f "" for all o in lights require m(o) is p or time_in(m(o)) < 0.3 s
"""


def test_nothing_is_left_of_the_run_before(monkeypatch: pytest.MonkeyPatch) -> None:
    one_memory(monkeypatch)
    spec, dice = loads(ANEW), random.Random(2)
    evaluators = {name: Evaluator(spec, backend=name) for name in ("numpy", "c")}
    for _ in range(4):
        t, cycles = 0.0, list[dict[str, Any] | None]()
        for number in range(20):
            t = round(t + dice.choice([0.1, 0.1, 0.2, 0.6]), 9)
            there = dice.sample("abc", dice.randint(0, 3))
            lights = {"id": there, "v": [dice.choice([-2.0, 0.0, 0.5, 2.0]) for _ in there]}
            signals = {"lights": lights, "flag": dice.random() < 0.5}
            cycles.append(None if dice.random() < 0.1 else {"id": number, "t": t, "signals": signals})
        found = said(evaluators, cycles)
        assert found["c"] == found["numpy"]


@pytest.mark.acceptance  # short ones every day
def test_long_runs_wrap_all_rings() -> None:
    """Windows of many cycles, in runs many times as long: rings begin anew, stacks turn, unsteady stamps fill and empty them."""
    spec = loads(
        SIGNALS
        + 'rule a "" require once[0 s, 3 s] ego.v > 1.9 m/s\nrule b "" require historically[0.5 s, 2 s] ego.v > -1.9 m/s\n'
        'rule c "" require ego.v > -1.5 m/s since[0.3 s, 4 s] flag\nrule d "" require count(flag, last: 2.5 s) <= 6\n'
        'rule e "" for all o in objects require once[0.2 s, 1.5 s] o.v > 1 m/s or o.v > -1.9 m/s since[0 s, 1 s] o.v > 1.5 m/s\n'
        'rule f "" require ego.v > -1.8 m/s since flag\nrule g "" require once[1 s, 1.2 s] flag\n'
        'rule h "" require eventually[0 s, 3 s] ego.v > 1.9 m/s\nrule i "" require ego.v > -1.5 m/s until[0.3 s, 4 s] flag\n'
        'rule j "" for all o in objects require always[0.2 s, 1.5 s] (o.v < 1.9 m/s or once[0 s, 0.3 s] flag)\n'
        'rule k "" whenever rising(flag) within 0.5 s require (exists o in objects: o.v > 1.5 m/s)\n'
    )
    evaluators = {name: Evaluator(spec, backend=name) for name in ("numpy", "c")}
    dice = random.Random(7)
    t, cycles = 0.0, list[dict[str, Any] | None]()
    there = ["a", "b", "c", "d"]
    for number in range(amount(120, 1500)):
        t = round(t + dice.choice([0.01, 0.05, 0.05, 0.1, 0.7]), 9)
        if dice.random() < 0.03:
            cycles.append(None)
            continue
        present = [name for name in there if dice.random() < 0.97]
        dice.shuffle(present)
        objects = {"id": present, "v": [dice.uniform(-2, 2) for _ in present]}
        ego = {"v": dice.uniform(-2, 2), "w": 0.0}
        signals = {"ego": ego, "objects": objects, "flag": dice.choice([True, False, False, False])}
        cycles.append({"id": number, "t": t, "signals": signals})
    found = said(evaluators, cycles)
    assert found["c"] == found["numpy"]
    for rule in "abcdefghijk":
        assert len({each[rule][0] for each in found["c"][:-1]}) >= 2, rule


@given(
    st.lists(formulas(False, False, 1), min_size=4, max_size=4),
    st.lists(formulas(True, False, 1), min_size=4, max_size=4),
    st.lists(formulas(), min_size=RULES, max_size=RULES),
    st.lists(runs(), min_size=RUNS, max_size=RUNS),
)
@_SETTINGS
def test_machines(
    guards: list[str], of_objects: list[str], drawn: list[str], several: list[list[dict[str, Any] | None]]
) -> None:
    """State machines whose guards look back and ask one another, and what looks back at their states and at what they keep."""
    ways = [Way(target, (), True) for target in ("b", "c", "a", "c")]
    light = declared(("a", "b", "c"), ways, "", "{}", "ego.v").replace("state m", "state light")
    each = guarded(declared(("a", "b", "c"), ways, " for each o in objects", "{}", "o.v"), of_objects)
    asking = [*drawn, "light is a", "light.entry > ego.w", "time_in(light) <= 0.3 s"]
    for leaf, instead in ASKED.items():
        asking = [re.sub(rf"(?<!\w){re.escape(leaf)}", instead, one) for one in asking]
    asking.append("for all o in objects: (m(o) is b or m(o).entry <= o.v or time_in(m(o)) <= 0.2 s)")
    rules = "".join(f'rule f{number} "x"\n  require {one}\n' for number, one in enumerate(asking))
    text = f"{SIGNALS}{guarded(light, guards)}{each.replace('flag', 'light is c')}{rules}"
    try:
        spec = loads(text)
    except Diagnostics as error:
        assume({one.code for one in error.items} - {"E241", "E242", "E243", "E217"})
        raise
    evaluators = {name: Evaluator(spec, backend=name) for name in (*OTHERS, "c")}
    for cycles in several:
        found = said(evaluators, cycles)
        assert found["c"] == found["reference"] == found["numpy"], text


def test_memory_has_a_bound() -> None:
    """Windows that are long have room for fewer cycles a second; those that are too long are refused before there is memory for them."""
    spec = loads(
        SIGNALS + 'rule long "" for all o in objects require once[0 s, 10 min] o.v > 0 m/s\n'
        'rule endless "" for all o in objects require once[0 s, 100 h] o.v > 0 m/s\n'
    )
    program = CProgram(spec, [rule for rule in spec.rules if rule.name == "long"])
    library = program.library_for()
    assert 50 <= library.sizes["TM_MAX_RATE"] < 1000
    assert library.dll.tmg_size() < 300 << 20
    with pytest.raises(TrackmarshalError) as caught:
        CProgram(spec, spec.rules).library_for()
    assert caught.value.code == "E473"
    assert Evaluator(spec, backend="auto").program.identity["backend"] == "numpy"


def test_memory_of_pairs_has_a_bound() -> None:
    """There is one for each place of both sets: as many as fit, or none."""
    for capacity, window, fits in (
        (32, "", True),
        (32, "[0 s, 60 s]", True),
        (32, "[0 s, 3 h]", False),
        (1000, "", False),
    ):
        spec = loads(
            f"module m\nsignal objects : set of object {{ v: m/s }} capacity {capacity}\n"
            f'rule f "" for all o in objects for all b in objects require once{window} o.v > b.v\n'
        )
        if fits:
            library = CProgram(spec, spec.rules).library_for()
            assert library.dll.tmg_size() < 300 << 20
            assert Evaluator(spec, backend="auto").program.identity["backend"] == "c"
            continue
        with pytest.raises(TrackmarshalError) as caught:
            CProgram(spec, spec.rules).library_for()
        assert caught.value.code == "E473"
        assert Evaluator(spec, backend="auto").program.identity["backend"] == "numpy"


@pytest.mark.parametrize("operator", ["once", "next"])
def test_what_is_about_three_elements_is_refused(operator: str) -> None:
    spec = loads(
        f'{SIGNALS}rule f "" for all o in objects for all b in objects for all p in objects '
        f"require {operator} (o.v > b.v or p.v > b.v)\n"
    )
    with pytest.raises(TrackmarshalError) as caught:
        CProgram(spec, spec.rules)
    assert (caught.value.code, caught.value.line) == ("E470", 6)
    assert "not for each 3 of them" in str(caught.value)


@pytest.mark.parametrize(
    "body",
    [
        at_length("once (always[0 s, 0.6 s] ego.v > 1 m/s)"),
        "(always[0 s, 0.6 s] ego.w > 0 m/s) since (always[0 s, 0.6 s] ego.v > 1 m/s)",
        at_length("historically (eventually[0 s, 0.5 s] ego.v > 1 m/s)"),
        "count(eventually[0 s, 0.3 s] ego.v > 1 m/s, last: 1 s) <= 5",
    ],
)
def test_cycles_in_which_nothing_is_demanded_are_asked_for_later(body: str) -> None:
    """A rule that does not apply in a cycle says so at once, and what it looks ahead for there is open all the same."""
    spec = loads(f'{SIGNALS}rule f "" whenever flag require {body}\n')
    evaluators = {name: Evaluator(spec, backend=name) for name in (*OTHERS, "c")}
    dice, verdicts = random.Random(3), set[str]()
    for _ in range(12):
        t, cycles = 0.0, list[dict[str, Any] | None]()
        for number in range(16):
            t = round(t + dice.choice([0.05, 0.1, 0.1, 0.2]), 9)
            ego = {"v": dice.choice([0.0, 2.0, 2.0, 3.0]), "w": dice.choice([-1.0, 1.0, 2.0])}
            signals = {"ego": ego, "objects": {"id": [], "v": []}, "flag": dice.random() < 0.25}
            cycles.append({"id": number, "t": t, "signals": signals})
        found = said(evaluators, cycles)
        assert found["numpy"] == found["reference"]
        assert found["c"] == found["reference"]
        verdicts |= {each["f"][0] for each in found["c"][:-1]}
    assert {"inactive", "satisfied"} <= verdicts


def test_counts_go_over_gaps() -> None:
    """Of a formula that looks ahead, too: as many cycles as were missed may have counted."""
    drawn = [
        "count(eventually[0 s, 0.3 s] ego.v > 1 m/s, last: 1 s) <= 3",
        "count(always[0 s, 0.2 s] ego.v > 1 m/s, last: 0.5 s) >= 2",
        "eventually[0 s, 0.4 s] count(ego.v > 1 m/s, last: 0.6 s) == 2",
        "always[0.1 s, 0.3 s] count(ego.v > 1 m/s, last: 0.4 s) <= 2",
        "always[0 s, 0.3 s] count(next ego.v > 1 m/s, last: 0.5 s) != 2",
        "count(ego.v > 1 m/s) <= 6",
    ]
    evaluators = {name: Evaluator(loads(spec_of(drawn)), backend=name) for name in (*OTHERS, "c")}
    dice, verdicts = random.Random(5), set[str]()
    for _ in range(amount(2, 12)):
        t, cycles = 0.0, list[dict[str, Any] | None]()
        for number in range(16):
            t = round(t + dice.choice([0.05, 0.1, 0.1, 0.2]), 9)
            signals = {
                "ego": {"v": dice.choice([0.0, 2.0]), "w": 0.0},
                "objects": {"id": [], "v": []},
                "flag": False,
            }
            missed = dice.random() < 0.15
            cycles += [None] * dice.choice([1, 2]) if missed else [{"id": number, "t": t, "signals": signals}]
        found = said(evaluators, cycles)
        assert found["numpy"] == found["reference"]
        assert found["c"] == found["reference"]
        verdicts |= {verdict for each in found["c"][:-1] for verdict, *_ in each.values()}
    assert {"undefined", "satisfied", "violated", "open"} <= verdicts


def test_who_had_more_elements_than_there_is_room_for_is_not_forgotten() -> None:
    """There is room for 32 of a set that declares no capacity. In the middle of a run a cycle of more is refused, and is a gap; behind it, the run began anew."""
    spec = loads(
        SIGNALS + 'rule run "" require not once[0 s, 5 s] flag\n'
        'rule each "" for all o in objects require not once[0 s, 5 s] o.v > 1 m/s\n'
    )

    def cycle(number: int, count: int) -> dict[str, Any]:
        objects = {"id": [str(i) for i in range(count)], "v": [2.0 if number == 0 and i == 0 else 0.0 for i in range(count)]}  # fmt: skip
        ego = {"v": 0.0, "w": 0.0}
        return {"id": number, "t": number / 10, "signals": {"ego": ego, "objects": objects, "flag": number == 0}}  # fmt: skip

    evaluator = Evaluator(spec, backend="c")
    run, found = evaluator.over_run(), list[Any]()
    for number, count in enumerate((3, 33, 2, 32)):
        if count > 32:
            with pytest.raises(TrackmarshalError, match="in the middle of a run") as caught:
                run.step(evaluator.read(cycle(number, count)))
            assert caught.value.code == "E473"
            run.missed()
        else:
            rules = run.step(evaluator.read(cycle(number, count))).rules
            found.append({name: (one.verdict, exact(one.margin), told(one.about)) for name, one in rules.items()})  # fmt: skip
    others = [cycle(0, 3), None, cycle(2, 2), cycle(3, 32)]
    (wanted,) = said({"reference": Evaluator(spec, backend="reference")}, others).values()
    assert found == wanted[: len(found)]
    assert {one["run"][0] for one in found} == {"violated"}


def test_a_longer_line_in_the_middle_of_a_run_leaves_windows_as_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Windows of pairs have room for fewer cycles where the first one has more elements; a program for a longer line had room for more again, and
    took nothing over (E473). For more elements no program is compiled that could not be taken."""
    spec = loads(
        "module m\nsignal ego : state { x: m, y: m }\nsignal a : set of object { v: m/s }\n"
        "signal b : set of object { v: m/s }\nsignal way : polyline\n"
        'rule pairs "" for all o in a for all q in b require not once[1 s, 20 s] o.v > q.v\n'
        'rule near "" require distance_to(ego, way) <= 9 m\n'
    )

    def cycle(number: int, count: int, points: int) -> dict[str, Any]:
        ids = [str(i) for i in range(count)]
        a, b = ({"id": ids, "v": [v] * count} for v in (2.0 * (number == 0), 1.0))
        way = [[float(i), 0.0] for i in range(points)]
        return {"t": float(number), "signals": {"ego": {"x": 0.0, "y": 0.0}, "a": a, "b": b, "way": way}}

    evaluator = Evaluator(spec, backend="c")
    run, made = evaluator.over_run(), list[dict[str, int]]()

    def built(source: Source, sizes: dict[str, int]) -> Library:
        made.append(sizes)
        return Library(source, sizes)

    monkeypatch.setattr(program, "Library", built)
    for number, (count, points) in enumerate(((40, 5), (2, 5), (2, 5000), (2, 5))):
        verdict = run.step(evaluator.read(cycle(number, count, points))).rules["pairs"].verdict
        assert verdict == ("violated" if number else "satisfied")
    assert len(made) == 2
    with pytest.raises(TrackmarshalError, match="in the middle of a run"):
        run.step(evaluator.read(cycle(4, 41, 5)))
    assert len(made) == 2


def test_cases_by_themselves_have_as_many_elements_as_they_have() -> None:
    """Each is the first cycle of a run of its own: with more than 32 elements, and more than the case before, it was refused as one of the same run."""
    spec = loads(SIGNALS + 'rule each "" for all o in objects require not once[0 s, 5 s] o.v > 1 m/s\n')
    evaluator = Evaluator(spec, backend="c")

    def case(count: int) -> dict[str, Any]:
        objects = {"id": [str(i) for i in range(count)], "v": [0.0] * (count - 1) + [count % 2 * 2.0]}
        return {"signals": {"ego": {"v": 0.0, "w": 0.0}, "objects": objects, "flag": False}}

    found = evaluator.evaluate(evaluator.read_all([case(count) for count in (2, 33, 40, 3)]))
    assert [one.safe for one in found] == [True, False, True, False]


@pytest.mark.parametrize("block", [1, 2, 3, 8])
def test_of_a_piece_that_c_does_not_hold_nothing_is_known(
    block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run that is read in pieces: rules that go cycle by cycle went on as if the piece had not been, and others knew it."""
    monkeypatch.setattr("trackmarshal.runs.BLOCK", block)
    spec = loads(
        SIGNALS + 'rule each "" for all o in objects require not once[0 s, 9 s] ego.v > o.v + 20 m/s\n'
        'rule run "" require not once[0 s, 9 s] ego.v > 20 m/s\n'
    )
    run, said = Evaluator(spec, backend="c").whole_run(), list[Any]()
    for first, count, speeds in ((0, 2, [5.0, 5.0]), (2, 33, [5.0, 5.0, 30.0, 5.0]), (6, 2, [5.0, 5.0])):
        t = np.arange(first, first + len(speeds)) * 10**8
        objects = {"id": [str(i) for i in range(count)], "v": np.zeros((len(speeds), count))}
        ego = {"v": np.array(speeds), "w": np.zeros(len(speeds))}
        signals = {"ego": ego, "objects": objects, "flag": np.zeros(len(speeds), dtype=bool)}
        if count > 32:
            with pytest.raises(TrackmarshalError, match="in the middle of a run"):
                run.step(t, signals)
        else:
            said.append({name: list(verdicts) for name, verdicts in run.step(t, signals).verdicts.items()})
    assert said[0] == {"each": ["satisfied"] * 2, "run": ["satisfied"] * 2}
    assert said[1]["each"] == ["undefined"] * 2
    assert set(said[1]["run"]) <= {"undefined", "violated"}


def test_a_run_that_began_with_many_elements_is_restored() -> None:
    """There is memory for as many as the first cycle has; what was saved of more than 32 was refused as damaged."""
    spec = loads(SIGNALS + 'rule f "" for all o in objects require not once[0 s, 5 s] o.v > 0 m/s\n')
    for count in (32, 33):
        evaluator, saved = Evaluator(spec, backend="c"), list[str]()
        for number, v in enumerate((1.0, 0.0)):
            run = evaluator.over_run(saved or None)
            objects = {"id": [str(i) for i in range(count)], "v": [v] * count}
            signals = {"ego": {"v": 0.0, "w": 0.0}, "objects": objects, "flag": False}
            result = run.step(evaluator.read({"t": number / 10, "signals": signals}))
            assert result.rules["f"].verdict == "violated", count
            saved = run.save()


def test_a_run_goes_on_in_c_where_another_case_takes_numpy(capsys: pytest.CaptureFixture[str]) -> None:
    """With `auto`, an evaluator does without C from the first case on that C refuses; numpy was asked about what C remembered of the run."""
    spec = loads(
        "module m\nsignal ego : state { x: m, y: m }\nevent flag\n"
        "zone z = polygon (0 m, 0 m) (9 m, 0 m) (9 m, 9 m)\n"
        'rule f "" require not once[0 s, 5 s] flag\nrule g "" require ego in zone z or ego.x < 99 m\n'
    )
    evaluator = Evaluator(spec, backend="auto")

    def case(number: int, **more: Any) -> Any:
        signals = {"ego": {"x": 1.0, "y": 0.5}, "flag": number == 0}
        return evaluator.read({"t": number / 10, "signals": signals, **more})

    run = evaluator.over_run()
    found = [run.step(case(0)).rules["f"].verdict]
    all_but_zero = {"z": [[1e-70, 0.0], [8.0, 0.0], [8.0, 8.0]]}
    assert next(iter(evaluator.evaluate([case(1, places=all_but_zero)]))).safe
    assert evaluator.backend == "numpy", capsys.readouterr().err
    saved = run.save()
    found += [run.step(case(2)).rules["f"].verdict]
    found += [Evaluator(spec, backend="auto").over_run(saved).step(case(2)).rules["f"].verdict]
    assert found == ["violated"] * 3


def test_rules_that_go_cycle_by_cycle_do_without_c_where_the_others_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What C says of some of the rules is no part of a run that numpy evaluates: with `auto`, `eval --run` ended in the first cycle that C did not hold."""
    (tmp_path / "run.spec").write_text(
        SIGNALS + 'rule all_in_all "" require count(flag, last: 900 h) <= 3\n'  # C has no room for it
        'rule each "" for all o in objects require not once[0 s, 5 s] o.v > 1 m/s\n'
    )  # fmt: skip
    cases = []
    for number, count in enumerate((2, 33, 2)):
        speeds = [2.0 * (number == i == 0) for i in range(count)]
        objects = {"id": [str(i) for i in range(count)], "v": speeds}
        signals = {"ego": {"v": 0.0, "w": 0.0}, "objects": objects, "flag": False}
        cases.append(json.dumps({"t": number / 10, "signals": signals}))
    (tmp_path / "run.jsonl").write_text("\n".join(cases) + "\n")
    said = []
    given = ["eval", str(tmp_path / "run.spec"), "--data", str(tmp_path / "run.jsonl"), "--run"]
    for backend in ("numpy", "auto"):
        assert main([*given, "--backend", backend]) == 1
        said.append(capsys.readouterr())
    assert said[0].out == said[1].out
    assert said[1].err.startswith("note: numpy evaluates instead of generated C: ")


def test_rules_by_themselves_refuse_what_cannot_come_next() -> None:
    """Before the rules alone there is no door: a time that does not follow, and ids that are not there or alike, are refused in C itself."""
    spec = loads(SIGNALS + 'rule f "" for all o in objects require once[0 s, 1 s] o.v > 0 m/s\n')
    lib = CProgram(spec, spec.rules).library_for()
    context, flags, v = lib.context, (ctypes.c_byte * 1)(), (ctypes.c_double * 2)(1.0, 1.0)
    unusable, ok, kept = 3, 0, list[Any]()

    def given(t: float, count: int, ids: tuple[int, ...] | None) -> tuple[Any, ...]:
        kept.append((ctypes.c_uint64 * 2)(*ids or (0, 0)))  # as long as its address is in use
        columns = (ctypes.c_void_p * 2)(
            ctypes.addressof(v), None if ids is None else ctypes.addressof(kept[-1])
        )
        return (ctypes.c_size_t * 1)(count), columns, (ctypes.c_double * 1)(t), flags

    def checked(t: float, count: int = 2, ids: tuple[int, ...] | None = (7, 8)) -> tuple[int, int]:
        margin, verdict = ctypes.c_double(), ctypes.c_byte(-1)
        out = ctypes.byref(margin), ctypes.byref(verdict)
        return lib.dll.tmg_run(context, 1, *given(t, count, ids), *out), verdict.value

    satisfied, undefined = VERDICTS.index("satisfied"), VERDICTS.index("undefined")
    assert lib.sizes["TM_MAX_ELEMENTS"] >= 2
    assert checked(4e9) == checked(math.nan) == (unusable, undefined)
    assert checked(0.5) == checked(0.5) == (ok, satisfied)
    assert lib.dll.tmg_remember(context, *given(0.5, 2, (7, 8)), 1) == 0
    assert checked(0.5) == checked(0.4) == checked(0.5 + 1e-10) == (unusable, undefined)
    assert checked(0.5 + 0.6e-9) == (ok, satisfied)  # to the nearest nanosecond
    assert checked(0.6, ids=None) == checked(0.6, ids=(7, 7)) == (unusable, undefined)
    assert checked(0.6, 1, (7, 7)) == checked(0.6, 1) == (ok, satisfied)
    assert checked(0.6, 0, None)[0] == ok


@pytest.mark.acceptance  # a Supervisor is, every day
def test_rules_by_themselves_are_saved_in_the_middle() -> None:
    """Saved after any cycle, another run of the same program goes on as if nothing had happened; what was changed is refused."""
    spec = loads(
        SIGNALS
        + 'rule a "" require always[0 s, 0.5 s] ego.v > -1.5 m/s\nrule b "" require once[0 s, 0.4 s] flag\n'
        'rule c "" for all o in objects require eventually[0 s, 0.3 s] o.v > 0 m/s\nrule d "" require count(flag) <= 5\n'
        'rule e "" for all o in objects for all b in objects require not once[0.1 s, 0.6 s] o.v > b.v + 1.5 m/s\n'
    )
    evaluator, dice = Evaluator(spec, backend="c"), random.Random(11)
    cycles = list[dict[str, Any] | None]()
    for number in range(40):
        present = [name for name in "abc" if dice.random() < 0.9]
        objects = {"id": present, "v": [dice.uniform(-2, 2) for _ in present]}
        signals = {
            "ego": {"v": dice.uniform(-2, 2), "w": 0.0},
            "objects": objects,
            "flag": dice.random() < 0.3,
        }
        cycles.append(None if dice.random() < 0.05 else {"id": number, "t": number / 10, "signals": signals})
    (whole,) = said({"c": evaluator}, cycles).values()
    run, found = evaluator.over_run(), list[Any]()
    for cycle in cycles:
        lines = run.save()
        run = evaluator.over_run(lines)
        if cycle is None:
            run.missed()
            continue
        rules = run.step(evaluator.read(cycle)).rules
        found.append({name: (one.verdict, exact(one.margin), told(one.about)) for name, one in rules.items()})
    found.append({rule: told(about) for rule, about in run.end().items()})
    assert found == whole
    for place in range(1, len(lines)):
        line, middle = lines[place], len(lines[place]) // 2
        other = line[:middle] + ("1" if line[middle] != "1" else "2") + line[middle + 1 :]
        with pytest.raises(TrackmarshalError) as caught:
            evaluator.over_run([*lines[:place], other, *lines[place + 1 :]])
        assert caught.value.code == "D163"
