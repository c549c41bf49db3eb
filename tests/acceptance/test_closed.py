"""What is added to the language and forgotten somewhere: mypy names every place, before anything runs."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.acceptance

ROOT = Path(__file__).parents[2]
NODES, OPERATORS = "engine/trackmarshal/ir/nodes.py", "engine/trackmarshal/ir/operators.py"


def named(folder: Path, path: str, *changes: tuple[str, str]) -> set[str]:
    """The files in which mypy finds something unhandled, after changes of one file."""
    for part in ("engine", "trace"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    text = (folder / path).read_text(encoding="utf-8")
    for before, after in changes:
        assert text.count(before) == 1, before
        text = text.replace(before, after)
    (folder / path).write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "engine", "trace"]  # tests stay where they are
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    errors = [line for line in done.stdout.splitlines() if "assert_never" in line]
    return {re.sub(r"^engine/trackmarshal/", "", line.partition(":")[0]) for line in errors}


def test_a_function(tmp_path: Path) -> None:
    found = named(
        tmp_path, OPERATORS,
        ('"atan2", "tanh",\n', '"atan2", "tanh", "sinh",\n'),
        ('FUNCTIONS: dict[FunctionName, Function] = {\n', 'FUNCTIONS: dict[FunctionName, Function] = {\n    "sinh": Function(1, _PLAIN, libm=True),\n'),
    )  # fmt: skip
    assert found == {
        "ir/arithmetic.py", "backends/numpy/steps.py", "backends/c/expressions.py", "reading/formulas.py", "reading/solving/algebra.py",
        "semantics/bounds.py",
    }  # fmt: skip


def test_a_connective(tmp_path: Path) -> None:
    found = named(
        tmp_path, OPERATORS, ('ConnectiveOp = Literal["and", ', 'ConnectiveOp = Literal["nand", "and", ')
    )
    assert found == {
        "runtime/kleene.py", "backends/numpy/code.py", "backends/numpy/whole/values.py", "backends/c/expressions.py", "backends/witness.py",
        "explaining/trail.py",
    }  # fmt: skip


def test_a_number(tmp_path: Path) -> None:
    found = named(
        tmp_path, NODES,
        ("class Line(IR):", "class Sorcery(IR):\n    power: float\n\n\nclass Line(IR):"),
        ("    Const | Param | Column", "    Sorcery | Const | Param | Column"),
    )  # fmt: skip
    assert found == {
        "backends/reference/evaluator.py", "backends/numpy/code.py", "backends/c/expressions.py", "backends/c/layout.py",
        "backends/undefined.py", "ir/constants.py", "ir/reads.py", "semantics/bounds.py",
    }  # fmt: skip


def test_a_formula(tmp_path: Path) -> None:
    found = named(
        tmp_path, NODES,
        ("class Not(IR):", "class Sorcery(IR):\n    power: float\n\n\nclass Not(IR):"),
        ("    Truth | Flag | Compare", "    Sorcery | Truth | Flag | Compare"),
    )  # fmt: skip
    assert found == {
        "backends/reference/evaluator.py", "backends/numpy/code.py", "backends/c/expressions.py", "backends/c/layout.py",
        "backends/witness.py", "ir/margins.py", "ir/reads.py", "semantics/bounds.py",
        "testing/moving.py",
    }  # fmt: skip


def test_a_word(tmp_path: Path) -> None:
    """What the core can say needs its definition and how it reads, and no evaluator."""
    found = named(
        tmp_path, "engine/trackmarshal/typed/formulas.py",
        ("class Not(FormulaNode):", "class Sorcery(FormulaNode):\n    power: float\n    span: Span\n\n\nclass Not(FormulaNode):"),
        ("    Boolean | Event | BooleanField", "    Sorcery | Boolean | Event | BooleanField"),
    )  # fmt: skip
    assert found == {
        "lowering/expressions.py", "reading/drawing/quantities.py", "reading/formulas.py", "reading/sentences.py",
    }  # fmt: skip
