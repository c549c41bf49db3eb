"""What is kept of a project's specs was read from what is there: a file that is written meanwhile leaves nothing behind."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from trackmarshal.cli import facts


@pytest.mark.parametrize("meanwhile", [None, "written", "gone", "another"])
def test_what_is_written_while_it_is_read_is_not_kept(
    meanwhile: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "project"
    (root / "specs").mkdir(parents=True)
    spec, other = root / "specs" / "a.spec", root / "b.spec"
    spec.write_text("before")
    other.write_text("latter")  # as many letters
    made: list[str] = []

    def make() -> facts.Facts:
        made.append(spec.read_text())
        if meanwhile == "written":
            spec.write_text("after")
        elif meanwhile == "gone" and len(made) == 1:
            spec.unlink()
        elif meanwhile == "another" and other.exists():
            os.replace(other, spec)
        return facts.Facts([], [], [], {}, [], [])

    facts.facts(root, ["specs"], [], make)
    if meanwhile == "gone":
        spec.write_text("after")
    facts.facts(root, ["specs"], [], make)
    assert len(made) == (1 if meanwhile is None else 2)
