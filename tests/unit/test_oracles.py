"""The project's own worked cases are part of it: nothing is skipped in a clone that stands alone."""

from __future__ import annotations

import gzip
import hashlib
from pathlib import Path

import pytest

import support.shared
from support.shared import ORACLES, OWN, SHARED, oracle

COUNTS = {"seed_dev.json": 500, "rss_dev.json": 1000, "stl_dev.json": 200, "envelope_dev.json": 200}


@pytest.mark.parametrize("name", OWN)
def test_our_own_are_here_without_the_shared_folder(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(support.shared, "SHARED", tmp_path / "absent")
    content = oracle(name)
    assert len(content.get("cases", content.get("entries"))) == COUNTS[name]


@pytest.mark.parametrize("name", OWN)
def test_they_are_packed_the_same_on_every_machine(name: str) -> None:
    """No time and no name in the head, so that packing anew changes no byte."""
    head = (ORACLES / f"{name}.gz").read_bytes()[:10]
    assert head[:4] == b"\x1f\x8b\x08\x00"
    assert head[4:8] == bytes(4)


@pytest.mark.parametrize("name", OWN)
def test_they_are_those_that_are_shared(name: str) -> None:
    path = SHARED / "oracles" / name
    if not path.is_file():
        pytest.skip(f"{path} is not here: nothing to compare with")
    ours = gzip.decompress((ORACLES / f"{name}.gz").read_bytes())
    assert hashlib.sha256(ours).digest() == hashlib.sha256(path.read_bytes()).digest()


def test_others_are_skipped_and_say_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(support.shared, "SHARED", tmp_path / "absent")
    with pytest.raises(pytest.skip.Exception, match="shared beside the repository"):
        oracle("mltl_r2u2_vectors.json")
