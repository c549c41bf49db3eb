"""docs/tutorial.md word for word: its files are written, its commands run, and they print what stands below them."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from support.shared import REPOSITORY
from support.tutorial import run, same


def test_the_tutorial(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    monkeypatch.chdir(tmp_path)
    ran = 0
    for step in run((REPOSITORY / "docs" / "tutorial.md").read_text("utf-8")):
        assert step.statuses == step.wanted, (step.commands, step.said)
        if step.shown is not None:
            assert same(step.said, step.shown), (step.commands, step.said, step.shown)
        ran += len(step.statuses)
    assert ran >= 15


def test_what_is_shown_is_compared() -> None:
    assert same("one\ntwo 2026-01-02\nthree\n", "one\ntwo 2020-11-12\nthree\n")
    assert same("one\ntwo\nthree\n", "one\n...\nthree\n")
    assert same("one\ntwo\n", "one\n...\n")
    assert not same("one\ntwo\nthree\n", "one\nthree\n")
    assert not same("one\ntwo\n", "one\n")
    assert not same("one (2)\n", "one 2\n")
