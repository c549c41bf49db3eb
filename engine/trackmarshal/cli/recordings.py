"""A scenario's recording, and all that it was read from: one that is declared names its track, and others."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.kept import opened

if TYPE_CHECKING:
    from trackmarshal.scenarios.recording import Recording


def recorded(root: Path, path: Path, shown: str) -> tuple[Recording, str]:
    """A recording, and one sha256 of the files that it was read from besides its own; empty where there are none.

    Specs are left out: what they mean is hashed elsewhere.
    """
    from trackmarshal.scenarios import load

    with opened(root) as found:
        recording = load(path, shown)
    own = os.path.realpath(path)
    others = sorted(
        name for name in found if os.path.realpath(root / name) != own and not name.endswith(".spec")
    )
    if not others:
        return recording, ""
    # Where a file outside of the project is, is another matter on another machine.
    hashes = [
        (
            os.path.basename(name) if os.path.isabs(name) else name,
            hashlib.sha256((root / name).read_bytes()).hexdigest(),
        )
        for name in others
    ]
    return recording, hashlib.sha256(json.dumps(hashes).encode()).hexdigest()
