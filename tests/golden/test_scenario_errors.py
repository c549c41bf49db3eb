"""What the author of a scenario reads about each mistake in it, word for word, beside the edit that causes it.

The scenario and its mistakes are those of tests/unit/test_scenarios_given.py. After a change that is meant,
`TRACKMARSHAL_UPDATE_GOLDEN=1 pytest tests/golden` writes the text anew; read the difference before it is committed.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from support.project import run_command
from trackmarshal.errors import TrackmarshalError
from unit.test_scenarios_given import REFUSED, SPEC, scene, town

__all__ = ["town"]  # each scenario stands in a folder of its own

PAGE = Path(__file__).parent / "scenarios" / "given.txt"
CODES = {f"D25{digit}" for digit in range(7)}


def elsewhere() -> str:
    """A replay with a spec that lacks a rule of which the scenario says the truth."""
    scene()
    Path("other.spec").write_text(
        SPEC.replace("module town", "module other").replace("rule apart", "rule far")
    )
    status, _, said = run_command("replay", "scene.yaml", "--spec", "other.spec")
    assert status == 2
    return said


def test_every_mistake_is_told() -> None:
    found = []
    for old, new, code, _ in REFUSED:
        if code not in CODES:
            continue
        with pytest.raises(TrackmarshalError) as caught:
            scene((old, new))
        edit = f"-- {old.strip()}\n-> {new.strip()}\n".replace("\n      ", " ")
        found.append(f"{edit}\n{caught.value}\n")
    found.append(f"-- rule apart\n-> rule far, in another spec\n\n{elsewhere()}")
    made = "\n".join(found)
    assert all(f"error[{code}]" in made for code in CODES)
    if os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN"):
        PAGE.write_text(made, encoding="utf-8", newline="\n")
    assert made == PAGE.read_text(encoding="utf-8")
