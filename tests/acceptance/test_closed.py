"""What is added to the language and forgotten somewhere: mypy names every place, before anything runs."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

pytestmark = pytest.mark.acceptance

ROOT = Path(__file__).parents[2]
NODES, OPERATORS = "engine/trackmarshal/ir/nodes.py", "engine/trackmarshal/ir/operators.py"
FORMULAS = "engine/trackmarshal/typed/formulas.py"

#: By what is added: where, the changes, and the files in which it is not handled then.
ADDED: dict[str, tuple[str, list[tuple[str, str]], set[str]]] = {
    "sinh": (  # a function
        OPERATORS,
        [
            ('"atan2", "tanh",\n', '"atan2", "tanh", "sinh",\n'),
            ('FUNCTIONS: dict[FunctionName, Function] = {\n', 'FUNCTIONS: dict[FunctionName, Function] = {\n    "sinh": Function(1, _PLAIN, libm=True),\n'),
        ],
        {
            "ir/arithmetic.py", "backends/numpy/steps.py", "backends/c/functions/operators.py", "reading/formulas.py", "reading/solving/algebra.py",
            "semantics/advice/intervals.py",
        },
    ),
    "nand": (  # a connective
        OPERATORS,
        [('ConnectiveOp = Literal["and", ', 'ConnectiveOp = Literal["nand", "and", ')],
        {
            "runtime/kleene.py", "backends/numpy/formulas.py", "backends/numpy/whole/ahead.py", "backends/numpy/whole/values.py", "backends/c/functions/expressions.py", "backends/over_run/hoping.py",
            "backends/witness.py", "explaining/trail.py", "semantics/advice/starting.py",
        },
    ),
    "Weight": (  # a number
        NODES,
        [
            ("class Line(IR):", "class Weight(IR):\n    power: float\n\n\nclass Line(IR):"),
            ("    Const | Param | Column", "    Weight | Const | Param | Column"),
        ],
        {
            "backends/reference/functions.py", "backends/numpy/code.py", "backends/c/functions/expressions.py", "backends/c/layout.py",
            "backends/undefined.py", "ir/constants.py", "ir/reads.py", "semantics/advice/bounds.py",
        },
    ),
    "Sorcery": (  # a formula
        NODES,
        [
            ("class Not(IR):", "class Sorcery(IR):\n    power: float\n\n\nclass Not(IR):"),
            ("    Truth | Flag | Compare", "    Sorcery | Truth | Flag | Compare"),
        ],
        {
            "backends/reference/functions.py", "backends/numpy/formulas.py", "backends/c/functions/expressions.py", "backends/c/layout.py",
            "backends/witness.py", "ir/margins.py", "ir/reads.py", "semantics/advice/bounds.py",
            "testing/moving.py",
        },
    ),
    "Saying": (  # what the core can say needs its definition and how it reads, and no evaluator
        FORMULAS,
        [
            ("class Not(FormulaNode):", "class Saying(FormulaNode):\n    power: float\n    span: Span\n\n\nclass Not(FormulaNode):"),
            ("    Boolean | Event | BooleanField", "    Saying | Boolean | Event | BooleanField"),
        ],
        {
            "lowering/expressions.py", "reading/drawing/quantities.py", "reading/formulas.py", "reading/sentences.py",
        },
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def named(tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    """By what is added, the files in which mypy finds it unhandled: all at once, told apart by what the message names."""
    folder = tmp_path_factory.mktemp("closed")
    for part in ("engine", "trace"):
        shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    for path, changes, _ in ADDED.values():
        text = (folder / path).read_text(encoding="utf-8")
        for before, after in changes:
            assert text.count(before) == 1, before
            text = text.replace(before, after)
        (folder / path).write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "engine", "trace"]  # tests stay where they are
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    found: dict[str, set[str]] = defaultdict(set)
    for line in done.stdout.splitlines():
        if "assert_never" in line:
            file = re.sub(r"^engine/trackmarshal/", "", line.partition(":")[0])
            for one in re.findall(rf"\b(?:{'|'.join(ADDED)})\b", line):
                found[one].add(file)
    return found


@pytest.mark.parametrize("added", ADDED)
def test_what_is_added(named: dict[str, set[str]], added: str) -> None:
    assert named[added] == ADDED[added][2]
