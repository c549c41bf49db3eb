"""Who owns a waiver does not approve it, however the two are written."""

from __future__ import annotations

from pathlib import Path

import pytest

from golden.trace.cases import Small

PERSONS = """document: assurance
title: Who did what
persons:
  - {id: P-1, title: The Maintainers}
  - {id: P-2, title: the safety manager}
"""


@pytest.mark.parametrize(
    ("owner", "approver", "same"),
    [
        ("P-1", "The Maintainers", True),
        ("P-1", "the maintainers", True),
        ("the maintainers", '"THE  maintainers"', True),
        ("p-1", "The Maintainers", True),
        ("P-1", "P-2", False),
        ("The Maintainers", "the safety manager", False),
    ],
)
def test_the_owner_does_not_approve(owner: str, approver: str, same: bool, tmp_path: Path) -> None:
    made = Small.copy(tmp_path)
    (made.root / "requirements" / "assurance.yaml").write_text(PERSONS, "utf-8")
    made.replace(
        "requirements/v-model.yaml",
        "owner: the maintainers\n    approver: the safety manager",
        f"owner: {owner}\n    approver: {approver}",
    )
    found = [finding for finding in made.matrix().findings if finding.code == "T234"]
    assert [finding.subject for finding in found] == ["W-1"] * same


@pytest.mark.parametrize(
    ("subjects", "blanket"),
    [
        ("*", True),
        ("*:*", True),
        ("S-*, RR-*, CR-*", True),
        ("S-*:*, RR-*:*, CR-*:*", True),
        ("S-*, RR-*", True),
        ("S-*", False),
        ("*:review", False),
        ("S-1-A-1:monitor", False),
    ],
)
def test_a_waiver_for_subjects_of_every_requirement_is_a_blanket(
    subjects: str, blanket: bool, tmp_path: Path
) -> None:
    made = Small.copy(tmp_path)
    listed = ", ".join(f'"{pattern}"' for pattern in subjects.split(", "))
    made.replace(
        "requirements/v-model.yaml",
        "waivers:\n",
        f"waivers:\n  - {{id: W-2, codes: [T255], subjects: [{listed}], justification: None., residual_risk: None., owner: the maintainers, "
        "approver: the safety manager, granted: 2026-01-01, expires: 2026-12-31}\n",
    )
    found = [finding for finding in made.matrix().findings if finding.code == "T236"]
    assert [finding.subject for finding in found] == ["W-2"] * blanket
