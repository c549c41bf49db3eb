"""The user's cache folder: built tables, compiled code. Everything in it can be deleted at any time."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path


def cache_folder() -> Path | None:
    """The folder, made if need be; None where it cannot be made (a read-only system)."""
    base = os.environ.get("TRACKMARSHAL_CACHE")
    try:
        root = (
            Path(base)
            if base
            else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "trackmarshal"
        )
        root.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # RuntimeError: nobody knows where home is
        return None
    return root if os.access(root, os.W_OK) else None


def replace(path: Path, content: bytes) -> bool:
    """Write a file aside and move it: a parallel reader sees all of it or nothing. False where it cannot be written."""
    try:
        descriptor, name = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    except OSError:
        return False
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(content)
        os.replace(name, path)
    except OSError:
        Path(name).unlink(missing_ok=True)
        return False
    return True
