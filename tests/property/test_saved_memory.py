"""What rules remember, saved and restored: a run that goes on from there says what it would have said without."""

from __future__ import annotations

import json
import math
import os
import re
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from property.test_over_run import _about, exact, rule
from property.test_states import ASKED, Way, declared, guarded
from support.run_formulas import SIGNALS, formulas, runs
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.over_run import Run
from trackmarshal.runtime.saving import VERSION

EXAMPLES = int(os.environ.get("TRACKMARSHAL_EXAMPLES", "4"))
Cycles = list[dict[str, Any] | None]


def told(text: str, cycles: Cycles, restarts: set[int]) -> list[Any]:
    """Everything that a rule says; before the cycles of these places, the run is saved, and another one goes on."""
    run, found = Evaluator(loads(text)).over_run(), list[Any]()
    for place, cycle in enumerate(cycles):
        if place in restarts:
            saved = json.loads(json.dumps(run.save(), allow_nan=False))
            run = Evaluator(loads(text)).over_run(saved)
            assert run.save() == saved
        if cycle is None:
            run.missed()
            continue
        result = run.step(run._evaluator.read(cycle)).rules["f"]
        found.append((result.verdict, exact(result.margin), [_about(one) for one in result.about]))
    found.append({name: [_about(one) for one in each] for name, each in run.end().items()})
    return found


@given(formulas(), runs(), st.sets(st.integers(0, 14), min_size=1))
@settings(max_examples=4 * EXAMPLES, deadline=None)
def test_a_run_goes_on_as_if_it_had_not_stopped(formula: str, cycles: Cycles, restarts: set[int]) -> None:
    text = rule(f"require {formula}")
    assert told(text, cycles, restarts) == told(text, cycles, set())


@given(
    formulas(depth=2), formulas(True, depth=1), formulas(True, depth=2), st.booleans(), runs(), st.sets(st.integers(0, 14), min_size=1),
)  # fmt: skip
@settings(max_examples=2 * EXAMPLES, deadline=None)
def test_and_with_all_clauses(
    whenever: str, guard: str, body: str, within: bool, cycles: Cycles, restarts: set[int]
) -> None:
    deadline = "within 0.3 s\n  " if within else ""
    text = rule(f"whenever {whenever}\n  {deadline}for all o in objects where {guard}\n  require {body}")
    assert told(text, cycles, restarts) == told(text, cycles, set())


@given(
    st.lists(formulas(False, False, 1), min_size=3, max_size=4),
    st.lists(formulas(True, False, 1), min_size=3, max_size=4),
    formulas(),
    runs(),
    st.sets(st.integers(0, 14), min_size=1),
)
@settings(max_examples=2 * EXAMPLES, deadline=None)
def test_and_with_machines(
    guards: list[str], of_objects: list[str], formula: str, cycles: Cycles, restarts: set[int]
) -> None:
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
    assert told(text, cycles, restarts) == told(text, cycles, set())


@pytest.mark.parametrize("formula", ["once (always[0 s, 0.2 s] flag)", "(flag or ego.v > 0 m/s) since (eventually[0 s, 0.2 s] ego.w > 1 m/s)",
                                     "historically (eventually[0 s, 0.3 s] flag)"])  # fmt: skip
def test_what_is_left_of_cycles_that_are_dropped(formula: str) -> None:
    """An operator without a bound, over what looks ahead: what decided it is long gone."""
    cycles: Cycles = []
    for number in range(40):
        signals = {
            "ego": {"v": 1.0, "w": 2.0 if number == 3 else 0.0}, "objects": {"id": [], "v": []},
            "flag": 4 <= number <= 8 or (formula.startswith("historically") and number % 3 == 0),
        }  # fmt: skip
        cycles.append({"id": number, "t": number / 10, "signals": signals})
    text = rule(f"require {formula}")
    assert told(text, cycles, {15, 30}) == told(text, cycles, set())


# What is refused --------------------------------------------------------------------------------------------------------

REMEMBERING = """module m
param limit : m/s = 2 m/s
signal ego : state { v: m/s }
signal objects : set of object { v: m/s }
event flag
state light : { a, b } starts a
  becomes b when flag
    remember entry = ego.v
  becomes a when not flag
rule f "" for all o in objects require once[0.1 s, 0.5 s] o.v > limit or (flag since[0 s, 0.4 s] ego.v < 0 m/s) or light is b
rule g "" whenever flag within 0.3 s require count(ego.v > 0 m/s, last: 1 s) <= 3 and light.entry > 1 m/s
rule h "" require always[0 s, 0.5 s] (historically flag or previous flag)
"""


def cycle(number: int) -> dict[str, Any]:
    signals = {
        "ego": {"v": -math.sqrt(2) * (number % 3)}, "objects": {"id": ["a", "b"], "v": [0.1 * number, 3.0]}, "flag": number % 4 < 2,
    }  # fmt: skip
    return {"id": number, "t": number / 10, "signals": signals}


def saved(text: str = REMEMBERING, count: int = 12) -> list[str]:
    evaluator = Evaluator(loads(text))
    run = evaluator.over_run()
    for number in range(count):
        run.step(evaluator.read(cycle(number)))
    return run.save()


def code_of(lines: Any, text: str = REMEMBERING, **choice: Any) -> str:
    with pytest.raises(TrackmarshalError) as caught:
        Evaluator(loads(text), **choice).over_run(lines)
    return caught.value.code


def test_it_is_json_without_words_of_its_own() -> None:
    lines = saved()
    assert json.loads(lines[0])[:3] == ["trackmarshal-snapshot", VERSION, "numpy"]
    assert {json.loads(line)[0] for line in lines[1:]} >= {
        "run",
        "cells",
        "window",
        "machine",
        "before",
        "past",
        "pending",
        "end",
    }
    for line in lines:
        assert line == json.dumps(json.loads(line), allow_nan=False, separators=(",", ":"))


@pytest.mark.parametrize(
    ("old", "new"),
    [("once[0.1 s, 0.5 s]", "once[0.1 s, 0.6 s]"), ("= 2 m/s", "= 3 m/s"), ("starts a", "starts b"), ("rule g", "rule gg"),
     ("entry = ego.v", "entry = 2 * ego.v"), ("<= 3", "<= 4")],
)  # fmt: skip
def test_of_another_spec(old: str, new: str) -> None:
    assert old in REMEMBERING
    other = REMEMBERING.replace(old, new)
    assert code_of(saved(), other) == "D164"
    assert code_of(saved(other)) == "D164"


def test_of_other_rules_of_the_same_spec() -> None:
    assert code_of(saved(), names=["f", "g"]) == "D164"


def test_of_another_version_and_format() -> None:
    for place, value in (
        (0, "other"),
        (1, VERSION - 1),
        (1, VERSION + 1),
        (1, float(VERSION)),
        (1, True),
        (2, "c"),
        (3, "0" * 64),
    ):
        lines = [json.loads(line) for line in saved()]
        lines[0][place] = value
        assert code_of(sealed(lines)) == "D164"


def sealed(values: list[Any]) -> list[str]:
    """Lines with the digest that they should have: whoever made them meant it."""
    import hashlib

    lines = [json.dumps(value, separators=(",", ":")) for value in values[:-1]]
    digest = hashlib.sha256("".join(line + "\n" for line in lines).encode()).hexdigest()
    return [*lines, json.dumps(["end", digest])]


@pytest.mark.parametrize("backend", ["reference"])
def test_an_evaluator_that_saves_nothing(backend: str) -> None:
    text = 'module m\nsignal ego : state { v: m/s }\nrule f "" require once[0 s, 1 s] ego.v > 0 m/s\n'
    evaluator = Evaluator(loads(text), backend=backend)
    with pytest.raises(TrackmarshalError) as caught:
        evaluator.over_run().save()
    assert caught.value.code == "E486"
    run: Run = Evaluator(loads(text)).over_run()
    assert code_of(run.save(), text, backend=backend) in ("E486", "D164")


def test_a_name_that_json_has_no_word_for() -> None:
    evaluator = Evaluator(loads(REMEMBERING))
    run = evaluator.over_run()
    run.step(evaluator.read({**cycle(0), "id": [1, 2]}))
    with pytest.raises(TrackmarshalError) as caught:
        run.save()
    assert caught.value.code == "E486"


def test_lines_that_are_missing_or_changed() -> None:
    lines = saved()
    assert code_of([]) == code_of(lines[:1]) == code_of([7, 8]) == "D163"
    for place in range(len(lines)):
        assert code_of(lines[:place] + lines[place + 1 :]) == "D163"
        other = re.sub(r"\d", lambda digit: str((int(digit[0]) + 1) % 10), lines[place], count=1) + " "
        assert code_of([*lines[:place], other, *lines[place + 1 :]]) == "D163"


@given(st.data())
@settings(max_examples=6 * EXAMPLES, deadline=None)
def test_what_nobody_saved_is_refused_or_harmless(data: st.DataObject) -> None:
    """With a digest that fits: a value of another type or a piece too many is refused; nothing ends in another error."""
    values = [json.loads(line) for line in saved(count=data.draw(st.integers(1, 6)))]
    place = data.draw(st.integers(1, len(values) - 2))
    what = data.draw(st.sampled_from(["drop", "twice", "value"]))
    if what == "drop":
        del values[place]
    elif what == "twice":
        values.insert(place, values[place])
    else:
        spot: Any = values[place]
        while True:
            index = (
                data.draw(st.integers(0, len(spot) - 1))
                if type(spot) is list
                else data.draw(st.sampled_from(sorted(spot)))
            )
            if type(spot[index]) not in (list, dict) or not spot[index] or data.draw(st.booleans()):
                break
            spot = spot[index]
        before = spot[index]
        spot[index] = data.draw(
            st.sampled_from([None, -1, 10**6, 0.5, "x", "7ff0000000000000", [], [1], {}, True, False])
        )
        assume((type(before), before) != (type(spot[index]), spot[index]))
    evaluator = Evaluator(loads(REMEMBERING))
    try:
        run = evaluator.over_run(sealed(values))
    except TrackmarshalError as error:
        assert error.code == "D163"
        return
    assert what == "value", "a piece less, or one more"
    # It is another memory, of the same form: it works as one, or says that a stamp is not after the last one.
    try:
        run.step(evaluator.read(cycle(20)))
    except TrackmarshalError as error:
        assert error.code == "D206"


@pytest.mark.parametrize("margin", [math.nan, -math.nan, math.inf, -math.inf, -0.0, 5e-324, 0.1, 1e308])
def test_numbers_to_the_bit(margin: float) -> None:
    import struct

    from trackmarshal.runtime.saving import spelt, unspelt

    back = unspelt(json.loads(json.dumps(spelt(margin), allow_nan=False)))
    assert struct.pack("<d", back) == struct.pack("<d", margin)
