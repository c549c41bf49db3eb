"""What the safety case says of how requirements are verified, of what is not done for them and why, and of those that nobody demands any longer."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from support.planted.project import SOURCE
from support.safety_case import edit, html

UNUSED = "Tests and scenarios show more than reading does."


@pytest.fixture
def shuttle(tmp_path: Path) -> Path:
    return Path(shutil.copytree(SOURCE, tmp_path / "shuttle"))


def section(project: Path, name: str) -> str:
    """The text of a section."""
    found = html(project).html.partition(f'<section id="section-{name}"')[2].partition("</section>")[0]
    return " ".join(re.sub(r"<[^>]*>", " ", found).split())


def test_methods_stand_with_what_they_are_and_who_goes_by_them(shuttle: Path) -> None:
    edit(shuttle, "requirements/design.yaml", "title: proof,", "title: proof, description: by a prover that others check,")  # fmt: skip
    said = section(shuttle, "verification")
    assert re.search(r"M-3 proof ✎ by a prover that others check \S+ D ✎ project handbook S-3 ", said), said[
        :2000
    ]
    assert re.search(r"M-1 tests on both sides of the boundary B ✎ project handbook S-1 , S-2 , S-32", said)


def test_a_method_that_is_not_used_stands_with_the_reason(shuttle: Path) -> None:
    said = section(shuttle, "requirements")
    assert said.count(f"methods not used M-2 : ✎ {UNUSED}") == 4
    assert "methods M-1 methods not used" in said


def test_a_requirement_that_nobody_demands_any_longer_stands_at_the_end(shuttle: Path) -> None:
    statement = "The shuttle shall not overtake."
    before, _, after = section(shuttle, "requirements").partition("No longer demanded")
    assert statement not in before
    assert statement in after
    edit(shuttle, "requirements/requirements.yaml", "status: obsolete", "status: approved")
    said = section(shuttle, "requirements")
    assert "No longer demanded" not in said
    assert statement in said


def test_what_nobody_demands_any_longer_serves_and_refines_nothing(shuttle: Path) -> None:
    """The gate counts it for nothing (T150, T161): a goal that the document shows as achieved by it would look served."""
    old = "    adopted: An earlier permit.\n    status: obsolete\n    asil: C\n"
    edit(shuttle, "requirements/requirements.yaml", old, "    refines: [S-3]\n    achieves: [SG-1]\n    status: obsolete\n    asil: A(C)\n")  # fmt: skip
    for name in ("hazards", "decomposition", "requirements"):
        said = section(shuttle, name).partition("No longer demanded")[0]
        assert "S-3" in said
        assert "S-9" not in said, name
