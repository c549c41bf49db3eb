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
