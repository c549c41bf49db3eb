"""Files that are shared beside the repository, not part of it: oracles and recordings."""

from __future__ import annotations

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


def oracle(name: str) -> Any:
    """The content of a file of worked cases."""
    return json.loads(shared("oracles", name).read_text(encoding="utf-8"))
