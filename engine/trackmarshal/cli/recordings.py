"""A scenario's recording, and all that it was read from: one that is declared names its track, and others."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.cli.kept import opened
from trackmarshal.files import digest

if TYPE_CHECKING:
    from trackmarshal.scenarios.recording import Recording


def recorded(root: Path, path: Path, shown: str) -> tuple[Recording, str]:
    """A recording, and one sha256 of what it was made from besides its own file; empty where that is nothing.

    What specs mean for rules is hashed elsewhere; here, of specs, what its vehicles are, and when it has to be unsafe.
    """
    from trackmarshal.scenarios import load

    with opened(root) as found:
        recording = load(path, shown)
    own = os.path.realpath(path)
    others = sorted(
        name for name in found if os.path.realpath(root / name) != own and not name.endswith(".spec")
    )
    by_specs = [recording.of_specs] * bool(recording.of_specs)
    if any(name.endswith(".spec") for name in found):
        by_specs.append(repr(sorted(recording.ground_truth.items())))
    if not others and not by_specs:
        return recording, ""
    # Where a file outside of the project is, is another matter on another machine.
    hashes = [
        (
            os.path.basename(name) if os.path.isabs(name) else name,
            digest((root / name).read_bytes()),
        )
        for name in others
    ] + [("specs", hashlib.sha256("\0".join(by_specs).encode()).hexdigest())] * bool(by_specs)
    return recording, hashlib.sha256(json.dumps(hashes).encode()).hexdigest()
