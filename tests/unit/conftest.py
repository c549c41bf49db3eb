"""The warehouse robot, a project that is not this one, for tests of what is said of projects."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from support.safety_case import made_ready


@pytest.fixture(scope="session")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """It, accepted, with its evidence: to be copied, not to be changed."""
    return made_ready(tmp_path_factory.mktemp("ready"))


@pytest.fixture
def warehouse(ready: Path, tmp_path: Path) -> Path:
    """A copy of its own."""
    return Path(shutil.copytree(ready, tmp_path / "warehouse"))
