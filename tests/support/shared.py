"""Worked cases to hold evaluators against: the project's own in tests/oracles; others, and recordings, shared beside the repository."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
SHARED = REPOSITORY.parent / "shared"
#: The shipped rules that the oracles are held against.
SUPERVISOR = REPOSITORY / "specs" / "supervisor"


def shared(*parts: str) -> Path:
    """A shared file; the test is skipped, saying so, where it is absent."""
    path = SHARED.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"{path} is not here: it is shared beside the repository, not part of it")
    return path


#: Files of worked cases that were made for this project, and are part of it.
OWN = ("seed_dev.json", "rss_dev.json", "stl_dev.json", "envelope_dev.json")
ORACLES = REPOSITORY / "tests" / "oracles"


def oracle(name: str) -> Any:
    """The content of a file of worked cases; the test is skipped, saying so, where it is none of our own and absent."""
    if name in OWN:
        return json.loads(gzip.decompress((ORACLES / f"{name}.gz").read_bytes()))
    return json.loads(shared("oracles", name).read_text(encoding="utf-8"))
