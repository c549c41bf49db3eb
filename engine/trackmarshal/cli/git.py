"""How git is asked about a project: of what is recorded, and of nothing that stands in its place on this machine (`git replace`)."""

from __future__ import annotations

from pathlib import Path


def asking(folder: Path, *words: str) -> list[str]:
    """The command that asks git, in a folder."""
    return ["git", "--no-replace-objects", "-C", str(folder), *words]


__all__ = ["asking"]
