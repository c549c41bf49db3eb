"""What something was made from: hashes by name."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import TypeAlias

#: By kind and name (`param vehicles.devbot.mass`), the sha256 of what it means.
Inputs: TypeAlias = Mapping[str, str]


def sha256(*parts: str) -> str:
    """Of several texts; where one ends and the next begins counts."""
    digest = hashlib.sha256()
    for part in parts:
        held = part.encode("utf-8", "surrogatepass")
        digest.update(b"%d:" % len(held) + held)
    return digest.hexdigest()


def key(inputs: Inputs) -> str:
    """One hash for all of them, in whatever order they are given."""
    return sha256(json.dumps(dict(inputs), sort_keys=True))
