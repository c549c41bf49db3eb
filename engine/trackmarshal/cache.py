"""The user's cache folder: built tables, compiled code. Everything in it can be deleted at any time."""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any


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
    # A name that nobody else has, as of tempfile, which takes longer to import than a tree to be written.
    aside = path.with_name(f"{os.urandom(16).hex()}.tmp")
    try:
        with open(aside, "xb", opener=partial(os.open, mode=0o600)) as stream:
            stream.write(content)
        os.replace(aside, path)
    except OSError:
        with suppress(OSError):
            aside.unlink()
        return False
    return True


def of_project(name: str, root: Path) -> Path | None:
    """Where something about a project is kept, by the project's folder; None where nothing can be kept."""
    folder = cache_folder()
    if folder is None:
        return None
    return folder / f"{name}-{hashlib.sha256(os.fsencode(root.resolve())).hexdigest()[:32]}.json"


def keep(path: Path, said: Any) -> None:
    """Write a value of JSON with the hash of its text before it."""
    content = json.dumps(said, allow_nan=False).encode()
    replace(path, hashlib.sha256(content).hexdigest().encode() + b"\n" + content)


def kept(path: Path) -> Any:
    """The value, if what is there is what was written; else None."""
    try:
        held = path.read_bytes()
        intact = hashlib.sha256(held[65:]).hexdigest().encode() == held[:64]
        return json.loads(held[65:]) if intact else None
    except (OSError, ValueError):
        return None
