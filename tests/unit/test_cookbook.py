"""docs/cookbook.md: every idiom compiles after the page's head, with tests or a run on both sides, and does what the page says."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from support.shared import REPOSITORY
from trackmarshal.evaluation import Evaluator
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.source import of_text
from trackmarshal.syntax.format import format_text
from trackmarshal.testing.builders import line
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests

PAGE = (REPOSITORY / "docs" / "cookbook.md").read_text("utf-8")
HEAD = re.findall(r"```spec\n(.*?)```", PAGE, re.DOTALL)[0]
IDIOMS = [
    pytest.param(rule, run, id=re.findall(r"^rule (\w+)", rule, re.MULTILINE)[0])
    for rule, run in re.findall(r"```rule\n(.*?)```(?:\n\n```run\n(.*?)```)?", PAGE, re.DOTALL)
]
EGO = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 20.0}
CAR = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 20.0, "length": 4.7, "width": 2.0}
FLAGS = {"yes": True, "no": False}


def test_there_are_many() -> None:
    assert len(IDIOMS) >= 30
    assert PAGE.count("```rule\n") == len(IDIOMS)
    assert PAGE.count("```run\n") == sum(bool(param.values[1]) for param in IDIOMS)


@pytest.mark.parametrize(("rule", "run"), IDIOMS)
def test_it_does_what_the_page_says(rule: str, run: str, tmp_path: Path) -> None:
    path = tmp_path / "cookbook.spec"
    path.write_text(f"{HEAD}\n{rule}", "utf-8")
    compiled = compile_paths([path])
    assert [str(d) for d in compiled.found] == []
    tests, found = prepare(compiled)
    assert found == []
    assert [(o.test.title, o.message) for o in run_tests(compiled.spec, tests) if o.outcome != "passed"] == []
    for info in compiled.spec.rules:
        verdicts = {test.verdict for test in tests if test.rule.name == info.name}
        if run:
            wanted, said = ran(Evaluator(compiled.spec, [info.name], "numpy"), run)
            assert said == wanted
            assert (wanted, ran(Evaluator(compiled.spec, [info.name], "reference"), run)[1]) == (wanted, said)
            verdicts |= set(said)
        assert "violated" in verdicts
        assert verdicts & {"satisfied", "inactive"}


def ran(evaluator: Evaluator, run: str) -> tuple[list[str], list[str]]:
    """The verdicts of a run that the page shows, and those of the evaluator."""
    head, *rows = [text.split() for text in run.splitlines()]
    assert head[-1] == evaluator.rules[0].name
    over, said = evaluator.over_run(), []
    for row in rows:
        cells = dict(zip(head[:-1], row, strict=False))
        assert len(row) == len(head)
        said.append(over.step(evaluator.read(cycle(cells))).rules[head[-1]].verdict)
    return [row[-1] for row in rows], said


def cycle(cells: dict[str, str]) -> dict[str, Any]:
    """A cycle with what a line of a run says, and otherwise a car alone at 20 m/s on a straight plan."""
    ego, cars = dict(EGO), dict[str, dict[str, Any]]()
    signals: dict[str, Any] = {"emergency": False, "yellow": False, "braking": False, "plan": line(v=20.0)}
    for name, text in cells.items():
        owner, _, field = name.partition(".")
        if name == "t":
            continue
        if not field:
            signals[name] = FLAGS[text]
        elif owner == "race":
            signals[owner] = {field: text}
        elif owner == "ego":
            ego[field] = float(text)
        elif text != "-":
            cars.setdefault(owner, {"id": owner, **CAR})[field] = float(text)
    return {"t": float(cells["t"]), "signals": {**signals, "ego": ego, "objects": list(cars.values())}}


def test_it_is_laid_out() -> None:
    for param in IDIOMS:
        text = f"{HEAD}\n{param.values[0]}"
        assert format_text(of_text(text)) == text, param.id
