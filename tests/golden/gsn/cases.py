"""The small project of the goldens of traceability with hazards, design and people, and the program's templates as its own: faults are planted there.

Case files are as in golden/trace/cases.py.
"""

from __future__ import annotations

from pathlib import Path

from golden.trace.cases import HERE as TRACE
from golden.trace.cases import Small, apply
from trackmarshal.trace import requirements
from trackmarshal.trace.gsn.building import build
from trackmarshal.trace.gsn.case import Case
from trackmarshal.trace.gsn.document import DEFAULT
from trackmarshal.trace.matrix import Matrix

HERE = Path(__file__).parent
ARGUMENT = "requirements/argument.yaml"


def argued(folder: Path, edits: str = "") -> Small:
    """The project, edited."""
    small = Small.copy(folder)
    apply(small, (TRACE / "all_kinds.edits").read_text("utf-8").splitlines())
    (small.root / ARGUMENT).write_text(DEFAULT.read_text("utf-8"), "utf-8")
    apply(small, edits.splitlines())
    return small


def argument(small: Small) -> tuple[Matrix, Case]:
    """The matrix of a project, and the argument made of it."""
    matrix = small.matrix()
    project = requirements.load(small.root, [])
    return matrix, build(matrix, project, small.root)
