"""What is handed in where something else is expected is said in the caller's terms: the first mistakes that somebody makes with the package.

A bare AttributeError of the inside (`'str' object has no attribute 'rules'`) says neither which argument it was nor what it should be.
"""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm

SPEC = """module small
signal plan : trajectory { t: s increasing, v: km/h }
rule slow "Not faster than in town"
  for all p in plan
  require p.v <= 50 km/h
rule slower "Slower"
  for all p in plan
  require p.v <= 30 km/h
rulebook book "slow first" slow > slower
"""
RECORDING = Path(__file__).parents[2] / "specs" / "scenarios" / "cut_in.tmrec.jsonl"
#: What comes back from functions, and nobody makes by hand: a caller has it right, or not at all.
RESULTS = {"Batch", "Decision", "TrackmarshalError"}
WRONG: list[Any] = [
    None, "specs", Path("specs"), 3, -1.5, float("nan"), True, b"x", [], {}, [None], [["a"]], {"a": None}, [[1, 2], [3, 4]], np.zeros(3), object(), int,
]  # fmt: skip


def arguments() -> dict[str, tuple[Any, ...]]:
    """Of every public function, arguments that are right."""
    spec = tm.loads(SPEC)
    evaluator = tm.Evaluator(spec)
    order = tm.rulebook(spec, "book")
    plan = {"t": [0.0, 0.1, 0.2], "v": [36.0, 36.0, 36.0]}
    result = evaluator.case({"signals": {"plan": plan}})
    recording = tm.load_recording(RECORDING)
    t = np.linspace(0.0, 1.0, 5)
    columns = {"x": t, "y": 0.0 * t, "v": 0.0 * t + 1.0}
    return {
        "Cycle": (0, 0.0, {}, {}, {}),
        "Evaluator": (spec,),
        "Limits": (),
        "acceleration_along": (t, t),
        "arc_length": (t, t),
        "check_planner": ([{"plan": plan}], spec),
        "choose": (order, [result, result]),
        "compare": (order, result, result),
        "complete": (columns,),
        "curvature_along": (t, t),
        "cut_at_rest": (tm.complete(columns),),
        "cycles": (recording,),
        "direction_along": (t, t),
        "heading_from": (t,),
        "line": ([[0.0, 0.0], [1.0, 0.0]],),
        "load": (Path(__file__).parents[2] / "specs" / "vehicles",),
        "load_recording": (RECORDING,),
        "loads": (SPEC,),
        "replay": (recording, evaluator),
        "resample": (tm.complete(columns), 3),
        "rulebook": (spec, "book"),
        "supervisor": (spec,),
        "time_along": (t, t + 1.0),
    }


RIGHT = arguments()
METHODS = ("batch", "case", "evaluate", "read", "read_all")


def test_every_public_name_is_tried() -> None:
    public = {name for name in dir(tm) if not name.startswith("_")}
    assert public == RIGHT.keys() | RESULTS


@pytest.mark.parametrize("name", sorted(RIGHT))
def test_a_wrong_argument_is_told(name: str) -> None:
    function = getattr(tm, name)
    parameters = list(inspect.signature(function).parameters)
    for wrong in WRONG:
        for place in range(len(RIGHT[name])):
            given = list(RIGHT[name])
            given[place] = wrong
            _is_told(partial(function, *given), f"{name}: {parameters[place]} = {wrong!r:.40}")
        for keyword in parameters[len(RIGHT[name]) :]:
            _is_told(
                partial(function, *RIGHT[name], **{keyword: wrong}), f"{name}: {keyword} = {wrong!r:.40}"
            )


@pytest.mark.parametrize("method", METHODS)
def test_a_wrong_argument_of_an_evaluator_is_told(method: str) -> None:
    function = getattr(tm.Evaluator(tm.loads(SPEC)), method)
    for wrong in WRONG:
        _is_told(partial(function, wrong), f"{method}: {wrong!r:.40}")


def _is_told(call: Callable[[], Any], what: str) -> None:
    """Nothing at all, one of our errors, or a TypeError or ValueError that somebody here wrote, and that is no accident of Python's."""
    try:
        made = call()
        if isinstance(made, Iterator):
            next(made, None)
    except tm.TrackmarshalError:
        pass
    except (TypeError, ValueError) as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        assert "raise" in (last.line or ""), f"{what}: {error}"
    except Exception as error:
        pytest.fail(f"{what}: {type(error).__name__}: {error}")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: tm.supervisor("specs/supervisor"), "a spec is what `load` and `loads` return, not str 'specs/supervisor'"),  # type: ignore[arg-type]
        (lambda: tm.Evaluator(None), "a spec is what `load` and `loads` return, not None"),  # type: ignore[arg-type]
        (lambda: tm.replay("a.tmrec.jsonl", tm.Evaluator(tm.loads(SPEC))), "a recording is what `load_recording` returns, not str 'a.tmrec.jsonl'"),  # type: ignore[arg-type]
        (lambda: list(tm.Evaluator(tm.loads(SPEC)).evaluate([{"signals": {}}])), "a frame is what `read` makes of a case, not dict"),  # type: ignore[list-item]
        (lambda: tm.load([3]), "a path is a text or a `Path`, not int '3'"),  # type: ignore[list-item]
    ],
)  # fmt: skip
def test_what_is_said(call: Callable[[], Any], said: str) -> None:
    with pytest.raises(TypeError) as caught:
        call()
    assert str(caught.value) == said


def test_no_files_are_no_spec() -> None:
    """Of a pattern that fits nothing, a spec came out that finds nothing wrong."""
    with pytest.raises(tm.TrackmarshalError) as caught:
        tm.load([])
    assert caught.value.code == "E006"


def test_a_step_of_a_run_takes_a_frame() -> None:
    run = tm.Evaluator(tm.loads(SPEC)).over_run()
    for wrong in WRONG:
        _is_told(partial(run.step, wrong), f"step: {wrong!r:.40}")


@pytest.mark.parametrize(
    ("candidate", "rule", "code"), [("drivin", "slow", "D144"), ("driving", "slwo", "E401")]
)
def test_what_a_run_does_not_have_is_not_safe_all_along(candidate: str, rule: str, code: str) -> None:
    """Of a misspelt candidate, a rule was violated at no time."""
    spec = tm.loads('module small\nsignal ego : state { v: m/s }\nrule slow "s"\n  require ego.v <= 1 m/s\n')
    run = tm.replay(tm.load_recording(RECORDING), tm.Evaluator(spec))
    assert run.unsafe_times("driving", "slow") != []
    with pytest.raises(tm.TrackmarshalError) as caught:
        run.unsafe_times(candidate, rule)
    assert caught.value.code == code
