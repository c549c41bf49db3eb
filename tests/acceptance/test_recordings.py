"""The recordings of the paper's authors: verdicts inside the ground truth, and what the others must and may say."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from support.length import at_length
from support.shared import shared
from trackmarshal.backends.c.build import compiler
from trackmarshal.cli.replay import Known, evaluator_for
from trackmarshal.scenarios import load
from trackmarshal.scenarios.replay import Replay, intervals, replay

ROOT = Path(__file__).resolve().parents[2]
#: The reference takes its time: of the recordings every fourteenth cycle every day, each in `make acceptance`.
SOME = 14
BACKENDS = ("numpy", pytest.param("reference", marks=pytest.mark.acceptance), "c")
CYCLES = (pytest.param(1, marks=pytest.mark.acceptance, id="all"), pytest.param(SOME, id="some"))


_known = Known()


@cache
def run(name: str, backend: str, every: int = 1) -> Replay:
    recording = load(shared("data", "scenarios", f"{name}.saa"))
    recording = replace(recording, cycles=recording.cycles[::every])
    evaluator = evaluator_for(recording, ROOT / "specs" / "supervisor", [], None, None, backend, known=_known)
    return replay(recording, evaluator, brief=True)


def unsafe(name: str, candidate: str, rule: str, backend: str = "numpy") -> list[tuple[float, float]]:
    """When a rule made a candidate unsafe, as intervals of whole tenths of a second."""
    outcome = run(name, backend)
    times = [round(cycle.t, 1) for cycle in outcome.cycles]
    return intervals([round(t, 1) for t in outcome.unsafe_times(candidate, rule)], times)


def firing(name: str) -> set[str]:
    """The rules that made anything unsafe."""
    outcome = run(name, "numpy")
    rules = next(iter(outcome.cycles[0].results.values())).rules
    return {rule for rule in rules for c in ("driving", "emergency") if outcome.unsafe_times(c, rule)}


@pytest.mark.parametrize("backend", BACKENDS)
def test_cut_in_lies_inside_its_own_ground_truth(backend: str) -> None:
    outcome = run("modena_T1_cutin_collision", backend)
    assert {truth.kind: (truth.judged, truth.missed, truth.false_alarms) for truth in outcome.truths} == {
        "dynamic": (23, (), ()),
        "static": (53, (), ()),
    }


@pytest.mark.parametrize("every", CYCLES)
@pytest.mark.parametrize(
    "name", [at_length("modena_T1_cutin_collision"), "modena_T1_infeasible", at_length("modena_T1_valid")]
)
def test_both_evaluators_say_the_same(name: str, every: int) -> None:
    one, other = run(name, "numpy", every), run(name, "reference", every)
    for a, b in zip(one.cycles, other.cycles, strict=True):
        assert (a.decision, a.decision_from) == (b.decision, b.decision_from)
        for candidate, result in a.results.items():
            expected = b.results[candidate]
            assert {r: x.verdict for r, x in result.rules.items()} == {
                r: x.verdict for r, x in expected.rules.items()
            }
            for rule, x in result.rules.items():
                assert x.margin == pytest.approx(expected.rules[rule].margin, rel=1e-9, abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("every", CYCLES)
@pytest.mark.parametrize("other", ["reference", "numpy"])
@pytest.mark.parametrize("name", ["modena_T1_cutin_collision", "modena_T1_infeasible", "modena_T1_valid"])
@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_generated_c_says_the_same_to_the_last_bit(name: str, other: str, every: int) -> None:
    """The exception, see docs/generated-c.md: numpy has sines and cosines of its own, which one rule asks for."""
    margins = 0
    for a, b in zip(run(name, "c", every).cycles, run(name, other, every).cycles, strict=True):
        assert (a.decision, a.decision_from) == (b.decision, b.decision_from)
        for candidate, result in a.results.items():
            for rule, x in result.rules.items():
                y = b.results[candidate].rules[rule]
                same = x.margin == y.margin or (math.isnan(x.margin) and math.isnan(y.margin))
                if (rule, other) == ("heading_integrity", "numpy"):
                    same = abs(x.margin - y.margin) <= 1e-15
                assert (x.verdict, same) == (y.verdict, True), (a.t, candidate, rule, x, y)
                margins += 1
    assert margins > 1000 / every


def test_infeasible_is_unsafe_by_friction_drive_and_an_emergency_trajectory_that_does_not_stop() -> None:
    name = "modena_T1_infeasible"
    assert unsafe(name, "driving", "friction") == [(0.3, 5.0)]
    assert unsafe(name, "emergency", "friction") == [(2.4, 5.0)]
    assert unsafe(name, "emergency", "ends_at_rest") == [(2.3, 3.7)]
    assert unsafe(name, "driving", "drive_acceleration") == [(3.8, 6.9)]


def test_valid_is_unsafe_only_where_the_recording_is_at_fault() -> None:
    """See docs/recordings.md for the numbers behind each."""
    name = "modena_T1_valid"
    assert firing(name) == {"static_collision", "drive_acceleration", "acceleration_integrity"}
    assert unsafe(name, "driving", "drive_acceleration") == [(6.2, 9.5)]
    assert unsafe(name, "driving", "acceleration_integrity") == [(9.9, 9.9)]
    # The known borders begin at the car's middle in the first cycle and end before the horizon of the last one.
    assert unsafe(name, "driving", "static_collision") == [(0.0, 0.0), (9.9, 9.9)]
    assert unsafe(name, "emergency", "static_collision") == [(0.0, 0.0)]


def test_the_peer_agrees_on_friction_drive_and_standstill() -> None:
    """Where the authors' own supervisor and the shipped rules judge the same thing, they fire in the same cycles."""
    import json

    peer = json.loads(shared("data", "peer", "trajectory_supervisor_timelines.json").read_text())
    for name in ("modena_T1_cutin_collision", "modena_T1_infeasible", "modena_T1_valid"):
        theirs = peer[f"{name}__all"]["unsafe_intervals_s"]
        for candidate, short in (("driving", "perf"), ("emergency", "emerg")):
            pairs = [
                ("friction", "static_friction_ellipse"),
                ("drive_acceleration", "static_kinematic_dynamic"),
            ]
            if candidate == "emergency":  # a driving trajectory need not end in standstill
                pairs.append(("ends_at_rest", "static_safe_end_state"))
            for rule, metric in pairs:
                assert unsafe(name, candidate, rule) == [tuple(i) for i in theirs[f"{metric}/{short}"]], (
                    name,
                    candidate,
                    rule,
                )
