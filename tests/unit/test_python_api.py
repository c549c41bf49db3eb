"""The public Python API: its names, specs that are texts, and batches of arrays, held against cases one by one."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.project import run_command
from trackmarshal.backends.c.build import compiler
from trackmarshal.diagnostics.base import Diagnostics

SPEC = """
module batch

use prelude.frames

signal plan : trajectory {
  t: s increasing, x: m, y: m, v: km/h in [-10, 300], grip: 1 in [0, 1.5] default 1, ready: bool
}
signal ego : state { v: m/s in [-10, 150], age: s in [0, 10] default 0 s, on: bool }
signal objects : set of object { x: m, y: m, v: m/s in [-50, 50] }
signal track : corridor { left: polyline, right: polyline }
event flag
param v_max : km/h = 100 km/h in [0, 200]
constrain v_max <= 150 km/h

rule limit "limit"
  for all p in plan
  require p.v <= v_max

rule gripped "where there is grip"
  for all p in plan where p.grip >= 0.5
  require p.v <= 90 km/h

rule flagged "under the flag"
  whenever flag
  for all p in plan
  require p.v <= 60 km/h and p.ready

rule apart "away from all"
  for all p in plan
  for all o in objects
  require hypot(p.x - o.x, p.y - o.y) >= 2 m

rule steady "from sample to sample"
  for all consecutive p, q in plan
  require abs(q.v - p.v) <= 30 km/h

rule rooted "undefined below 20 km/h"
  for all p in plan
  require sqrt((p.v - 20 km/h) / (1 km/h)) <= 8

rule soon "slow within half a second, from every sample"
  along plan as p
  require always[0 s, 0.5 s] p.v <= 110 km/h

rule near "somewhere near"
  exists p in plan
  require abs(p.v - ego.v) <= 5 m/s

rule awake "on"
  whenever ego.on
  require ego.v >= 0 m/s

rule tracked "between the borders"
  for all p in plan
  require distance_to(p, track.left) >= 1 m and distance_to(p, track.right) >= 1 m
"""
COUNT, SAMPLES = 40, 12
TRACK: dict[str, Any] = {"left": [[0, 9], [99, 9]], "right": [[0, -9], [99, -9]]}
OBJECTS = [{"id": "red", "x": 3.0, "y": 4.0, "v": 1.0}, {"id": "blue", "x": 8.0, "y": 4.5, "v": 2.0}]
BACKENDS = [
    "numpy",
    "reference",
    pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
]


def arrays(seed: int = 1) -> dict[str, Any]:
    """Signals of COUNT cases, some of which break the contract."""
    random = np.random.default_rng(seed)
    shape = COUNT, SAMPLES
    plan: dict[str, Any] = {
        "t": np.tile(np.arange(SAMPLES) * 0.2, (COUNT, 1)),
        "x": np.cumsum(random.uniform(0.1, 1.5, shape), axis=1),
        "y": random.uniform(-3, 3, shape),
        "v": random.uniform(15, 115, (COUNT, 1)) + random.uniform(-16, 16, shape),
        "grip": random.choice([0.4, 0.5, 1.0], shape),
        "ready": random.random(shape) < 0.98,
    }
    plan["v"][::2] = random.uniform(30, 55, plan["v"][::2].shape)  # these are calm
    plan["y"][::2] = -2.0
    plan["ready"][::2] = True
    plan["v"][3, 4] = math.nan
    plan["v"][4, 0] = 300.5
    plan["t"][5, 7] = plan["t"][5, 6]
    plan["x"][6, 2] = math.inf
    return {
        "plan": plan,
        "ego": {
            "v": np.where(np.arange(COUNT) % 2, random.uniform(-12, 30, COUNT), 12.0),
            "on": random.random(COUNT) < 0.7,
        },
        "flag": random.random(COUNT) < 0.4,
    }


def one(signals: Any, index: int) -> Any:
    """A case of arrays as plain data, made without anything of the engine."""
    if isinstance(signals, dict):
        return {name: one(value, index) for name, value in signals.items()}
    return signals[index : index + 1].tolist()[0] if isinstance(signals, np.ndarray) else signals


@pytest.fixture(scope="module")
def spec() -> Any:
    return tm.loads(SPEC)


@pytest.fixture(scope="module", params=BACKENDS)
def evaluator(request: pytest.FixtureRequest, spec: Any) -> tm.Evaluator:
    return tm.Evaluator(spec, backend=request.param)


SHARED: dict[str, Any] = {"track": TRACK, "objects": OBJECTS}


def same_as_alone(evaluator: tm.Evaluator, batch: tm.Batch, cases: list[dict[str, Any]]) -> None:
    frames = evaluator.read_all(cases)
    results = list(evaluator.evaluate(frames))
    assert len(batch) == len(cases) == len(results)
    for index, (frame, result) in enumerate(zip(frames, results)):
        for name, found in result.rules.items():
            assert batch.verdicts[name][index] == found.verdict, (index, name)
            np.testing.assert_array_equal(batch.margins[name][index], found.margin)
        assert batch.safe[index] == result.safe
        assert batch.faults.get(index, ()) == tuple(frame.faults)
        assert batch.broken.get(index, ()) == result.broken


# Batches --------------------------------------------------------------------------------------------------------


def test_a_batch_is_its_cases(evaluator: tm.Evaluator) -> None:
    signals = arrays()
    batch = evaluator.batch(signals, SHARED)
    same_as_alone(evaluator, batch, [{"signals": {**SHARED, **one(signals, i)}} for i in range(COUNT)])
    seen = {name for verdicts in batch.verdicts.values() for name in verdicts.tolist()}
    assert seen == {"satisfied", "violated", "undefined", "inactive"}
    assert set(batch.faults) >= {3, 4, 5, 6}
    assert 0 < batch.safe.sum() < COUNT


def test_a_batch_longer_than_what_is_evaluated_at_once(spec: Any) -> None:
    from trackmarshal import evaluation

    evaluator = tm.Evaluator(spec)
    signals = arrays()
    times = evaluation.CHUNK // COUNT + 2
    many = {
        "plan": {name: np.tile(a, (times, 1)) for name, a in signals["plan"].items()},
        "ego": {name: np.tile(a, times) for name, a in signals["ego"].items()},
        "flag": np.tile(signals["flag"], times),
    }
    few, batch = evaluator.batch(signals, SHARED), evaluator.batch(many, SHARED)
    assert len(batch) > evaluation.CHUNK
    for rule in batch.rules:
        assert batch.verdicts[rule].tolist() == few.verdicts[rule].tolist() * times
        np.testing.assert_array_equal(batch.margins[rule], np.tile(few.margins[rule], times))
    assert batch.safe.tolist() == few.safe.tolist() * times
    assert {i % COUNT for i in batch.faults} == set(few.faults)
    assert len(batch.faults) == len(few.faults) * times
    np.testing.assert_array_equal(batch.samples("limit"), np.tile(few.samples("limit"), (times, 1)))


def test_backends_agree(spec: Any) -> None:
    signals = arrays(2)
    batches = [tm.Evaluator(spec, backend=name).batch(signals, SHARED) for name in ("reference", "numpy")]
    if compiler() is not None:
        batches.append(tm.Evaluator(spec, backend="c").batch(signals, SHARED))
    first = batches[0]
    for other in batches[1:]:
        for rule in first.rules:
            assert first.verdicts[rule].tolist() == other.verdicts[rule].tolist()
            np.testing.assert_array_equal(first.margins[rule], other.margins[rule])
        for rule in ("limit", "gripped", "flagged", "apart", "steady", "rooted", "soon", "tracked"):
            np.testing.assert_array_equal(first.samples(rule), other.samples(rule))
        assert first.safe.tolist() == other.safe.tolist()
        assert first.faults == other.faults


def test_margins_by_sample(evaluator: tm.Evaluator) -> None:
    """Worked out here by what the rules say, in SI."""
    signals = arrays()
    batch = evaluator.batch(signals, SHARED)
    plan = signals["plan"]
    v = plan["v"] / 3.6
    usable = [i for i in range(COUNT) if i != 5]  # times out of order: nothing is known of any sample

    def close(rule: str, wanted: Any) -> None:
        found = batch.samples(rule)
        assert found.shape == (COUNT, SAMPLES)
        assert found.dtype == np.float64
        assert np.isnan(found[5]).all()
        np.testing.assert_allclose(found[usable], wanted[usable], rtol=1e-12, atol=1e-12)

    close("limit", 100 / 3.6 - v)
    close("gripped", np.where(plan["grip"] >= 0.5, 90 / 3.6 - v, np.inf))
    under = signals["flag"][:, None]
    close("flagged", np.where(~under, np.inf, np.where(plan["ready"], 60 / 3.6 - v, -np.inf)))
    distances = [np.hypot(plan["x"] - o["x"], plan["y"] - o["y"]) for o in OBJECTS]
    apart = np.where(np.isinf(plan["x"]), np.nan, np.min(distances, axis=0) - 2)
    close("apart", apart)
    steps = np.full(v.shape, np.inf)
    steps[:, :-1] = 30 / 3.6 - np.abs(np.diff(v, axis=1))
    close("steady", steps)
    with np.errstate(invalid="ignore"):
        close("rooted", 8 - np.sqrt(plan["v"] - 20))
    soon = np.array([[np.nanmin(row[k : k + 3]) for k in range(SAMPLES)] for row in 110 / 3.6 - v])
    checked = [i for i in usable if i != 3]  # next to the missing speed it depends on the others
    np.testing.assert_allclose(batch.samples("soon")[checked], soon[checked], rtol=1e-12, atol=1e-12)


def test_the_least_margin_by_sample_is_the_margin_of_the_rule(evaluator: tm.Evaluator) -> None:
    batch = evaluator.batch(arrays(3), SHARED)
    for rule in ("limit", "gripped", "flagged", "apart", "steady", "rooted", "tracked"):
        verdicts, samples = batch.verdicts[rule], batch.samples(rule)
        decided = np.isin(verdicts, ["satisfied", "violated"])
        assert decided.any()
        np.testing.assert_array_equal(np.nanmin(samples[decided], axis=1), batch.margins[rule][decided])
        assert np.isnan(samples[verdicts == "undefined"]).any(axis=1).all()
        assert (samples[verdicts == "inactive"] == np.inf).all()


def test_a_case_of_a_batch_says_what_decided(evaluator: tm.Evaluator) -> None:
    signals = arrays()
    batch = evaluator.batch(signals, SHARED)
    worst = int(np.nanargmin(batch.margins["apart"]))
    result = batch.case(worst)
    alone = evaluator.case({"id": worst, "signals": {**SHARED, **one(signals, worst)}})
    assert result == alone
    witness = result.rules["apart"].witness
    assert witness is not None
    assert witness.binders["p"] == int(np.nanargmin(batch.samples("apart")[worst]))
    assert witness.binders["o"] in ("red", "blue")
    assert batch.case(-1).id == COUNT - 1
    with pytest.raises(IndexError):
        batch.case(COUNT)


def test_arrays_of_sets_and_columns_that_all_share(evaluator: tm.Evaluator) -> None:
    random = np.random.default_rng(4)
    signals = arrays()
    signals["plan"]["t"] = np.arange(SAMPLES) * 0.2
    del signals["plan"]["grip"]
    signals["objects"] = {
        "id": ["a", "b", "c"], "x": random.uniform(0, 9, (COUNT, 3)), "y": random.uniform(-5, 5, (COUNT, 3)), "v": np.zeros(3),
    }  # fmt: skip
    signals["objects"]["x"][9, 1] = math.nan
    signals["ego"]["on"] = True
    cases = []
    for i in range(COUNT):
        objects = {name: signals["objects"][name][i].tolist() for name in ("x", "y")}
        case = {name: one(signals[name], i) for name in ("ego", "flag")}
        case["plan"] = {name: one(a, i) for name, a in signals["plan"].items() if name != "t"}
        case["plan"]["t"] = signals["plan"]["t"].tolist()
        case["objects"] = {"id": ["a", "b", "c"], "v": [0.0, 0.0, 0.0], **objects}
        cases.append({"signals": {"track": TRACK, **case}})
    batch = evaluator.batch(signals, {"track": TRACK})
    same_as_alone(evaluator, batch, cases)
    assert [f.signal for f in batch.faults[9]] == ["objects"]


def test_sets_may_be_empty(evaluator: tm.Evaluator) -> None:
    signals = arrays()
    signals["objects"] = {name: np.zeros((COUNT, 0)) for name in ("x", "y", "v")}
    batch = evaluator.batch(signals, {"track": TRACK})
    assert set(batch.verdicts["apart"]) == {"inactive", "undefined"}
    empty: dict[str, Any] = {name: [] for name in ("x", "y", "v")}
    cases = [{"signals": {"track": TRACK, **one(signals, i), "objects": empty}} for i in range(COUNT)]
    same_as_alone(evaluator, batch, cases)


def test_what_is_missing_is_missing_in_all_cases(evaluator: tm.Evaluator) -> None:
    signals = arrays()
    del signals["plan"]["v"]
    shared = {"track": {"left": TRACK["left"]}}
    batch = evaluator.batch(signals, shared)
    same_as_alone(evaluator, batch, [{"signals": {**shared, **one(signals, i)}} for i in range(COUNT)])
    assert len(batch.faults) == COUNT
    assert not batch.safe.any()
    assert set(batch.verdicts["limit"]) == {"undefined"}
    assert np.isnan(batch.samples("limit")).all()


def test_a_broken_track_is_everybodys_fault(evaluator: tm.Evaluator) -> None:
    signals = arrays()
    shared = {**SHARED, "track": {**TRACK, "left": [[0, 9], [math.nan, 9]]}}
    batch = evaluator.batch(signals, shared)
    same_as_alone(evaluator, batch, [{"signals": {**shared, **one(signals, i)}} for i in range(COUNT)])
    assert not batch.safe.any()


def test_masked_and_missing_entries(evaluator: tm.Evaluator) -> None:
    signals = arrays()
    v = signals["plan"]["v"]
    signals["plan"]["v"] = np.ma.array(v, mask=np.zeros(v.shape, dtype=bool))
    signals["plan"]["v"][8, 3] = np.ma.masked
    ready = signals["plan"]["ready"].astype(object)
    ready[9, 2] = None
    signals["plan"]["ready"] = ready
    flag = signals["flag"].astype(object)
    flag[10] = None
    signals["flag"] = flag
    batch = evaluator.batch(signals, SHARED)
    same_as_alone(evaluator, batch, [{"signals": {**SHARED, **one(signals, i)}} for i in range(COUNT)])
    assert [(f.signal, f.field, f.index) for f in batch.faults[8]] == [("plan", "v", 3)]
    assert [(f.signal, f.field, f.index) for f in batch.faults[9]] == [("plan", "ready", 2)]
    assert [f.signal for f in batch.faults[10]] == ["flag"]


def test_parameters_may_vary(evaluator: tm.Evaluator) -> None:
    signals = arrays()
    limits = np.linspace(90, 200, COUNT)
    batch = evaluator.batch(signals, SHARED, params={"v_max": limits})
    cases = [
        {"params": {"v_max": limits[i].item()}, "signals": {**SHARED, **one(signals, i)}}
        for i in range(COUNT)
    ]
    same_as_alone(evaluator, batch, cases)
    assert set(batch.broken) == set(np.flatnonzero(limits > 150))
    one_for_all = evaluator.batch(signals, SHARED, params={"v_max": 90})
    cases = [{"params": {"v_max": 90}, "signals": {**SHARED, **one(signals, i)}} for i in range(COUNT)]
    same_as_alone(evaluator, one_for_all, cases)


def test_arrays_may_change_afterwards(spec: Any) -> None:
    signals = arrays()
    batch = tm.Evaluator(spec).batch(signals, SHARED)
    before, case = batch.samples("limit").copy(), batch.case(0)
    for column in signals["plan"].values():
        column[...] = 0
    np.testing.assert_array_equal(batch.samples("limit"), before)
    assert batch.case(0) == case


def _with(place: str, value: Any) -> Any:
    signal, _, field = place.partition(".")

    def change(given: dict[str, Any]) -> None:
        if field:
            given[signal] = {**given.get(signal, {}), field: value}
        else:
            given[signal] = value

    return change


BAD = {
    "a case too many": (_with("ego.v", np.zeros(COUNT + 1)), "D205", "`plan.t` has 40 cases, `ego.v` has 41"),
    "an event too many": (_with("flag", np.zeros(COUNT + 1, dtype=bool)), "D205", "`flag` has 41"),
    "a sample too few": (_with("plan.v", np.zeros((COUNT, SAMPLES - 1))), "D205", "`plan.t` has 12 samples, `plan.v` has 11"),
    "no samples": (_with("plan", {"v": np.zeros((COUNT, 0))}), "D205", "`plan.v` has no samples"),
    "three axes": (_with("plan.v", np.zeros((COUNT, SAMPLES, 1))), "D205", "an array of 3 axes"),
    "a list among arrays": (_with("plan.v", [1.0] * SAMPLES), "D205", "`plan.v` is a list"),
    "texts": (_with("plan.v", np.full((COUNT, SAMPLES), "fast")), "D202", "plan.v"),
    "Booleans as numbers": (_with("plan.v", np.ones((COUNT, SAMPLES), dtype=bool)), "D202", "plan.v"),
    "numbers as Booleans": (_with("plan.ready", np.ones((COUNT, SAMPLES))), "D202", "plan.ready"),
    "an object in the middle": (_with("plan.v", np.array([[1.0] * 12] * 2 + [[1.0] * 5 + ["x"] + [1.0] * 6] + [[1.0] * 12] * 37, dtype=object)), "D202", "plan.v[2, 5]"),
    "a field that nobody declares": (_with("plan.speed", np.zeros((COUNT, SAMPLES))), "D203", "speed"),
    "a signal that nobody declares": (_with("plans", {"v": np.zeros((COUNT, SAMPLES))}), "D203", "plans"),
    "numbers as an event": (_with("flag", np.ones(COUNT)), "D202", "flag"),
    "given twice": (_with("track", TRACK), "D205", "`track` is among the signals, and shared"),
    "too many ids": (_with("objects", {"id": ["a"], "x": np.zeros((COUNT, 2)), "y": np.zeros((COUNT, 2))}), "D205", "`objects.id` has 1 entries for 2"),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_arrays_that_cannot_be_read(what: str, spec: Any) -> None:
    change, code, words = BAD[what]
    signals = arrays()
    change(signals)
    shared = SHARED if what != "too many ids" else {"track": TRACK}
    with pytest.raises(tm.TrackmarshalError) as raised:
        tm.Evaluator(spec).batch(signals, shared)
    assert raised.value.code == code
    assert words in raised.value.message
    assert raised.value.help


@pytest.mark.parametrize("signals", [{}, {"plan": {"v": np.zeros(5)}}, {"plan": {"v": np.zeros((0, 5))}}])
def test_no_cases_are_no_batch(signals: dict[str, Any], spec: Any) -> None:
    """Of nothing it could only be said that all of it is safe."""
    with pytest.raises(tm.TrackmarshalError) as raised:
        tm.Evaluator(spec).batch(signals, SHARED)
    assert raised.value.code == "D205"


@pytest.mark.parametrize("given", [{"params": [1.0]}, {"params": {"v_max": "fast"}}, {"tables": 3}])
def test_overrides_of_a_wrong_type(given: dict[str, Any], spec: Any) -> None:
    with pytest.raises(tm.TrackmarshalError) as raised:
        tm.Evaluator(spec).batch(arrays(), SHARED, **given)
    assert raised.value.code == "D202"


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_breaks_the_contract_is_not_safe_though_all_rules_hold(backend: str, tmp_path: Path) -> None:
    """A number beyond its range satisfies the rule that reads it; whoever judges cases has to see the fault beside the verdict."""
    text = "module m\nsignal ego : state { v: m/s in [0, 10] }\nrule slow\n  require ego.v <= 500 m/s\n"
    evaluator = tm.Evaluator(tm.loads(text), backend=backend)
    raws = [{"signals": {"ego": {"v": v}}} for v in (99.0, 1.0)]
    batch = evaluator.batch({"ego": {"v": np.array([99.0, 1.0])}})
    frames = evaluator.read_all(raws)
    for results in (
        list(map(evaluator.case, raws)),
        list(evaluator.evaluate(frames)),
        list(map(batch.case, range(2))),
    ):
        assert [result.rules["slow"].verdict for result in results] == ["satisfied"] * 2
        assert [result.safe for result in results] == [False, True]
    assert batch.safe.tolist() == [False, True]
    spec, data = tmp_path / "m.spec", tmp_path / "cases.jsonl"
    spec.write_text(text, encoding="utf-8")
    for raw, status in zip(raws, (1, 0)):
        data.write_text(json.dumps(raw), encoding="utf-8")
        assert run_command("eval", str(spec), "--data", str(data), "--backend", backend)[0] == status


def test_a_default_stands_in_though_no_rule_reads_what_is_given() -> None:
    """Only columns that no rule reads say how many samples there are."""
    rule = 'rule gripped "gripped"\n  for all p in plan\n  require p.grip >= 0.5\n'
    evaluator = tm.Evaluator(tm.loads(SPEC[: SPEC.index("rule limit")] + rule))
    signals = {"plan": {name: arrays()["plan"][name] for name in ("x", "v")}}
    batch = evaluator.batch(signals)
    same_as_alone(evaluator, batch, [{"signals": one(signals, i)} for i in range(COUNT)])
    assert batch.margins["gripped"].tolist() == [0.5] * COUNT
    assert batch.samples("gripped").tolist() == [[0.5] * SAMPLES] * COUNT


def test_auto_evaluates_batches(spec: Any) -> None:
    batch = tm.Evaluator(spec, backend="auto").batch(arrays(), SHARED)
    other = tm.Evaluator(spec, backend="numpy").batch(arrays(), SHARED)
    assert {name: found.tolist() for name, found in batch.verdicts.items()} == {
        name: found.tolist() for name, found in other.verdicts.items()
    }


def test_signals_are_given_by_name(spec: Any) -> None:
    with pytest.raises(tm.TrackmarshalError) as raised:
        tm.Evaluator(spec).batch([arrays()])  # type: ignore[arg-type]
    assert raised.value.code == "D202"


def test_parameters_are_checked_in_every_case(spec: Any) -> None:
    limits = np.full(COUNT, 90.0)
    limits[7] = 201.0
    with pytest.raises(tm.TrackmarshalError) as raised:
        tm.Evaluator(spec).batch(arrays(), SHARED, params={"v_max": limits})
    assert raised.value.code == "D204"


@pytest.mark.parametrize(("rule", "code"), [("near", "E406"), ("awake", "E406"), ("limits", "E401")])
def test_rules_without_margins_by_sample(rule: str, code: str, evaluator: tm.Evaluator) -> None:
    batch = evaluator.batch(arrays(), SHARED)
    with pytest.raises(tm.TrackmarshalError) as raised:
        batch.samples(rule)
    assert raised.value.code == code
    assert raised.value.help


@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_rules_over_the_run_have_no_margins_by_sample(backend: str) -> None:
    """Of cases by themselves; such a rule may be for all samples of each cycle."""
    spec = tm.loads(
        "module lasting\nevent yellow\nsignal plan : trajectory { t: s increasing, v: m/s }\n"
        'rule lasts "x"\n  whenever once[0 s, 5 s] yellow\n  for all p in plan\n  require p.v <= 30 m/s\n'
        'rule slow "x"\n  for all p in plan\n  require p.v <= 30 m/s\n'
    )
    signals = {"yellow": np.array([True, False]), "plan": {"t": np.arange(2.0), "v": np.full((2, 2), 20.0)}}
    batch = tm.Evaluator(spec, None, backend).batch(signals)
    assert batch.verdicts["lasts"].tolist() == ["satisfied", "inactive"]
    with pytest.raises(tm.TrackmarshalError, match="other cycles") as raised:
        batch.samples("lasts")
    assert raised.value.code == "E406"
    assert batch.samples("slow").tolist() == [[10.0, 10.0]] * 2


# Names ----------------------------------------------------------------------------------------------------------

PUBLIC = [
    "Batch", "Cycle", "Decision", "Evaluator", "Limits", "TrackmarshalError", "acceleration_along", "arc_length", "check_planner", "choose",
    "compare", "complete", "curvature_along", "cut_at_rest", "cycles", "direction_along", "heading_from", "line", "load", "load_recording", "loads",
    "replay", "resample", "rulebook", "supervisor", "time_along",
]  # fmt: skip


def test_the_public_names_are_listed_before_they_are_used() -> None:
    program = "import trackmarshal as tm; print([n for n in dir(tm) if n[0] != '_']); print(all(hasattr(tm, n) for n in dir(tm)))"
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert said == f"{PUBLIC}\nTrue\n"


def test_importing_costs_nothing() -> None:
    program = "import sys, trackmarshal as tm; dir(tm); print('numpy' in sys.modules)"
    assert (
        subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
        == "False\n"
    )


@pytest.mark.parametrize("backend", ["nunpy", "C", "", None, ["numpy"]])
def test_a_wrong_backend_is_refused_everywhere(backend: Any, spec: Any) -> None:
    for make in (lambda: tm.Evaluator(spec, backend=backend), lambda: tm.supervisor(spec, backend=backend)):
        with pytest.raises(tm.TrackmarshalError) as raised:
            make()
        assert raised.value.code == "E405"
        assert "numpy" in (raised.value.help or "") or backend == "C"


@pytest.mark.parametrize(
    ("option", "word"), [("--target", "rust"), ("--target", "numpy"), ("--backend", "c")]
)
def test_compile_refuses_any_other_target(option: str, word: str, tmp_path: Path) -> None:
    (tmp_path / "batch.spec").write_text(SPEC, encoding="utf-8")
    out = tmp_path / "out"
    status, _, err = run_command("compile", str(tmp_path / "batch.spec"), option, word, "--out", str(out))
    assert status == 2
    assert option in err
    assert not out.exists()


def test_a_line_costs_nothing_when_it_comes_again(spec: Any) -> None:
    points = np.array(TRACK["left"], dtype=float)
    left, right = tm.line(points), tm.line(TRACK["right"])
    points[0] = 77.0
    assert left.points.tolist() == TRACK["left"]
    with pytest.raises(ValueError, match="read-only"):
        left.points[0, 0] = 1.0
    evaluator = tm.Evaluator(spec)
    frame = evaluator.read(
        {"signals": {**SHARED, **one(arrays(), 0), "track": {"left": left, "right": right}}}
    )
    assert frame.lines["track", "left"] is left
    for bad in ([1.0, 2.0], [[1.0, 2.0, 3.0]], []):
        with pytest.raises(ValueError, match="list of points"):
            tm.line(bad)


# Specs that are texts -------------------------------------------------------------------------------------------

SMALL = 'module small\nsignal ego : state { v: m/s }\nrule slow "slow"\n  require ego.v <= 3 m/s\n'


def test_a_text_is_a_spec() -> None:
    spec = tm.loads(SMALL)
    (rule,) = spec.rules
    assert str(rule.span) == "<text>:3:1"
    result = tm.Evaluator(spec).case({"signals": {"ego": {"v": 5.0}}})
    assert result.rules["slow"].verdict == "violated"
    assert result.rules["slow"].margin == -2.0
    assert not result.safe


def test_errors_in_a_text_name_it() -> None:
    with pytest.raises(Diagnostics) as raised:
        tm.loads(SMALL.replace("3 m/s", "3 kg"))
    assert "<text>:4" in str(raised.value)
    assert "E301" in str(raised.value)


@pytest.mark.parametrize(
    ("text", "code"),
    [("", "E003"), ("module a\n\x00", "E005"), ("module \ud800", "E004"), ("x" * 4_000_001, "E002")],
)
def test_texts_that_cannot_be_read(text: str, code: str) -> None:
    with pytest.raises(tm.TrackmarshalError) as raised:
        tm.loads(text)
    assert raised.value.code == code
    assert raised.value.file == "<text>"


def test_a_text_says_which_module_it_is() -> None:
    with pytest.raises(Diagnostics, match="module NAME"):
        tm.loads(SMALL.replace("module small\n", ""))


def test_bytes_are_no_text() -> None:
    with pytest.raises(TypeError, match="bytes"):
        tm.loads(SMALL.encode())  # type: ignore[arg-type]


def test_a_text_uses_modules_of_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "cars").mkdir()
    (tmp_path / "cars" / "compact.spec").write_text("module cars.compact\nparam v_max : m/s = 3 m/s\n")
    (tmp_path / "slower.spec").write_text("module slower\nparam v_max : m/s = 1 m/s\n")
    monkeypatch.chdir(tmp_path)
    text = SMALL.replace("small\n", "small\nuse cars.compact\nuse prelude.frames\n").replace("3 m/s", "v_max")
    case = {"signals": {"ego": {"v": 2.0}}}
    assert tm.Evaluator(tm.loads(text)).case(case).safe
    assert not tm.Evaluator(tm.loads(text, ["slower.spec"])).case(case).safe
    with pytest.raises(Diagnostics) as raised:
        tm.loads(text.replace("cars.compact", "cars.compakt"))
    assert "<text>:2" in str(raised.value)
    assert "cars.compact" in str(raised.value)
    monkeypatch.chdir("/")
    with pytest.raises(Diagnostics, match="compact"):
        tm.loads(text)


@pytest.mark.parametrize(
    ("call", "code", "said"),
    [
        (lambda e: e.batch({"plans": {"v": np.zeros((3, 2))}}), "D203", "nothing declares `plans`\n  help: did you mean `plan`?"),
        (lambda e: e.batch({"signals": {"plan": {"v": np.zeros((3, 2))}}}), "D203", "a batch is given them by their names"),
        (lambda e: e.case({"plan": {"t": [0.0, 1.0]}}), "D203", 'signals stand under `signals`: {"signals": {"plan": ...}}'),
        (lambda e: e.case({"signals": {"plan": {"v": np.zeros((3, 2))}}}), "D202", "arrays of many cases are for `Evaluator.batch`"),
    ],
)  # fmt: skip
def test_where_signals_stand_is_said(call: Any, code: str, said: str, evaluator: tm.Evaluator) -> None:
    """What a case and a batch are is easily mixed up: the messages spoke of sizes, or suggested `places`."""
    with pytest.raises(tm.TrackmarshalError) as caught:
        call(evaluator)
    assert caught.value.code == code
    assert said in str(caught.value)
