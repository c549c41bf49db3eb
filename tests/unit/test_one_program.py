"""A Supervisor in C is one compiled program: what it is called in a record is known without another."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.cycles import cycle
from trackmarshal.backends import programs
from trackmarshal.evaluation import Evaluator, load, loads
from trackmarshal.supervision import rulebox

ROOT = Path(__file__).resolve().parents[2]
REMEMBERS = """
module m
signal ego : state { v: m/s }
rule fast   require ego.v <= 50 m/s
rule braked require once ego.v <= 20 m/s
"""


def test_a_supervisor_in_c_compiles_no_second_program(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(programs, "generated", lambda *_: pytest.fail("the program that rates cases is made"))
    box = rulebox(Evaluator(load([ROOT / "specs" / "supervisor"]), backend="c"))
    assert box.running().step(cycle(0)) is not None


@pytest.mark.parametrize("rules", [["friction", "static_collision"], None])
def test_it_is_called_what_its_program_is_called(rules: list[str] | None) -> None:
    evaluator = Evaluator(load([ROOT / "specs" / "supervisor"]), rules, "c")
    assert evaluator.identity == evaluator.program.identity


def test_so_is_one_that_remembers() -> None:
    evaluator = Evaluator(loads(REMEMBERS), backend="c")
    assert evaluator.backend == "c"
    assert evaluator.identity == evaluator.program.identity
