"""What the Python API takes: one path where there may be several, and what can be gone through once."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.shared import SUPERVISOR
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, load, loads
from trackmarshal.runtime.faults import NAMES, fault
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.semantics.errors.names import ModuleName

SPEC = 'module m\nparam most : m/s = 3 m/s\nsignal ego : state { v: m/s }\nrule slow "slow"\n  require ego.v <= most\n'


@pytest.mark.parametrize("one", [str, Path])
def test_one_configuration(one: type, tmp_path: Path) -> None:
    spec, fast = tmp_path / "m.spec", tmp_path / "fast.spec"
    spec.write_text(SPEC, "utf-8")
    fast.write_text("module fast\nparam most : m/s = 9 m/s\n", "utf-8")
    assert load(one(spec), one(fast)).params["m.most"].value == 9.0


def test_names_and_cases_that_can_be_gone_through_once() -> None:
    evaluator = Evaluator(loads(SPEC), (name for name in ["slow"]))
    assert [rule.name for rule in evaluator.rules] == ["slow"]
    frames = (evaluator.read({"signals": {"ego": {"v": v}}}) for v in (1.0, 5.0))
    assert [result.safe for result in evaluator.evaluate(frames)] == [True, False]


def test_a_fault_says_its_name() -> None:
    said = fault("missing", "ego", "v")
    assert (said.name, said.code) == (
        "missing",
        next(code for code, name in NAMES.items() if name == "missing"),
    )


@pytest.mark.parametrize("stem", ["speed-limit", "10_yard", "my rules", "ünfall", "rule"])
def test_the_name_that_is_proposed_for_a_module_is_one(stem: str, tmp_path: Path) -> None:
    path = tmp_path / f"{stem}.spec"
    body = 'signal ego : state { v: m/s }\nrule slow "slow"\n  require ego.v <= 3 m/s\n'
    path.write_text(body, "utf-8")
    (found,) = compile_paths([path]).errors
    assert isinstance(found, ModuleName)
    proposed = found.hint.split("`")[1]
    path.write_text(f"{proposed}\n{body}", "utf-8")
    assert not compile_paths([path]).errors


def test_a_spec_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(TrackmarshalError, match=r"E001|No such file"):
        load(SUPERVISOR, tmp_path / "none.spec")
