"""What a test says."""

from __future__ import annotations

import json
from typing import Any

from trackmarshal.meaning.inputs import sha256
from trackmarshal.testing.cases import PreparedTest


def fingerprint_of_test(test: PreparedTest) -> str:
    """sha256 of what it gives and what it expects: its case as data, so that how it is written does not count."""
    given = {name: part for name, part in test.case.items() if name != "id"}
    expected = [
        test.verdict,
        test.margin,
        test.tolerance if test.margin is not None else None,
        test.unit,
        test.binder,
        test.at,
    ]
    said = json.dumps([given, test.later, expected], sort_keys=True, default=_plain)
    return sha256(said)


def _plain(value: Any) -> Any:
    """Arrays as lists; raises TypeError for what is no data."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"a test gives {type(value).__name__}, which is no data")
