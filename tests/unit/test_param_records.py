"""Records of parameters: read and passed whole, each field overridden by itself wherever parameters are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from trackmarshal.backends.c.source import generate
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, load, loads
from trackmarshal.semantics.compile import compile_text
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests

BACKENDS = ("reference", "numpy", "c")
SPEC = """module made

signal ego : state { v: m/s, response: s, braking: m/s^2 }

shape answer = { response: ms }
shape rss = answer with { braking: m/s^2 }

param response : s = 7 s
param limits : rss = { response: 500 ms in [100, 2000], braking: 4 m/s^2 source "brake test" }
param wet : rss = { response: 2 * limits.response, braking: limits.braking / 2 }

constrain limits.response <= 1.5 s

define needed(v: m/s, l: rss) -> m = v * answered(l) + v^2 / (2 * l.braking)
define answered(a: answer) -> s = a.response

rule dry "Stands within 60 m"
  require   needed(ego.v, limits) <= 60 m

rule rain "Stands within 100 m"
  let       l = wet
  require   needed(ego.v, l) <= 100 m

rule own "as the car says"
  require   needed(ego.v, ego) <= 60 m

test dry "as declared"
  given  ego = { v: 20 m/s }
  expect satisfied, margin 0 m

test dry "it answers later"
  given  ego = { v: 20 m/s }
  given  limits = { response: 1 s }
  expect violated, margin -10 m
"""
EGO = {"v": 20.0, "response": 1.0, "braking": 4.0}


def margins(spec: Any, backend: str, **more: Any) -> list[float]:
    rules = Evaluator(spec, backend=backend).case({"signals": {"ego": EGO}, **more}).rules
    return [rule.margin for rule in rules.values()]


@pytest.mark.parametrize("backend", BACKENDS)
def test_fields_are_read_and_overridden_one_by_one(backend: str) -> None:
    spec = loads(SPEC)
    assert margins(spec, backend) == [0.0, -20.0, -10.0]
    assert margins(spec, backend, params={"limits.response": 1000}) == [-10.0, -20.0, -10.0]
    assert margins(spec, backend, params={"made.limits.braking": 8}) == [25.0, -20.0, -10.0]
    assert margins(spec, backend, params={"response": 1}) == [0.0, -20.0, -10.0]


@pytest.mark.parametrize(
    ("name", "value", "code"),
    [("limits.response", 99.0, "D204"), ("limits.response", 2001.0, "D204"), ("limits.reponse", 200.0, "D203"), ("limits", 200.0, "D203"), ("braking", 3.0, "D203")],
)  # fmt: skip
def test_what_is_no_field_or_outside_its_range_is_refused(name: str, value: float, code: str) -> None:
    with pytest.raises(TrackmarshalError) as refused:
        margins(loads(SPEC), "reference", params={name: value})
    assert refused.value.code == code


def test_ranges_include_their_ends_and_constraints_hold_for_fields() -> None:
    evaluator = Evaluator(loads(SPEC))
    for value, broken in ((100.0, 0), (1500.0, 0), (1501.0, 1), (2000.0, 1)):
        case = evaluator.case({"signals": {"ego": EGO}, "params": {"limits.response": value}})
        assert len(case.broken) == broken


def test_a_configuration_sets_fields_and_nothing_of_the_same_name(tmp_path: Path) -> None:
    (tmp_path / "made.spec").write_text(SPEC, "utf-8")
    (tmp_path / "car.spec").write_text(
        "module car\nparam limits.response : s = 1 s\nparam limits.braking : m/s^2 = 8 m/s^2\n", "utf-8"
    )
    (tmp_path / "other.spec").write_text("module other\nparam response : s = 1 s\n", "utf-8")
    (tmp_path / "wrong.spec").write_text("module wrong\nparam limits.answer : s = 1 s\n", "utf-8")
    (tmp_path / "far.spec").write_text("module far\nparam limits.response : s = 3 s\n", "utf-8")
    for backend in BACKENDS:
        assert margins(load([tmp_path / "made.spec"], [tmp_path / "car.spec"]), backend) == [
            15.0,
            -20.0,
            -10.0,
        ]
        assert margins(load([tmp_path / "made.spec"], [tmp_path / "other.spec"]), backend) == [
            0.0,
            -20.0,
            -10.0,
        ]
    for name in ("wrong", "far"):
        with pytest.raises(TrackmarshalError) as refused:
            load([tmp_path / "made.spec"], [tmp_path / f"{name}.spec"])
        assert refused.value.code == "E402"


def test_a_whole_record_is_a_configuration_too(tmp_path: Path) -> None:
    shapes, rest = SPEC.split("param response", 1)
    (tmp_path / "shapes.spec").write_text(shapes.replace("module made", "module shapes"), "utf-8")
    (tmp_path / "made.spec").write_text("module made\nuse shapes\nparam response" + rest, "utf-8")
    (tmp_path / "car.spec").write_text(
        "module car\nuse shapes\nparam limits : rss = { response: 1 s, braking: 8 m/s^2 }\n", "utf-8"
    )
    assert margins(load([tmp_path / "made.spec"], [tmp_path / "car.spec"]), "numpy")[0] == 15.0


def test_tests_give_some_fields() -> None:
    compiled = compile_text(SPEC)
    assert compiled.found == ()
    tests, found = prepare(compiled)
    assert found == []
    assert [outcome.message for outcome in run_tests(compiled.spec, tests)] == ["", ""]


def test_parameters_of_no_record_are_described_as_ever() -> None:
    """What is kept of runs rests on fingerprints, and these on descriptions."""
    spec = loads("module made\nparam a : m = 1 m\n")
    assert repr(spec.params["made.a"]) == (
        "ParamInfo(name='made.a', value=1.0, unit='m', lower=None, upper=None, source=None)"
    )


def test_in_c_each_has_a_name_of_its_own() -> None:
    spec = loads(SPEC.replace("<= 60 m\n", "<= 60 m + response * 1 m/s\n", 1))
    header = generate(spec, spec.rules).header
    for name in ("made.response", "made.limits.response", "made.limits.braking", "made.wet.response"):
        assert f"{name} " in header
