"""How what is new since the baseline is told."""

from __future__ import annotations

from trackmarshal.trace.baseline.changes import changes
from trackmarshal.trace.baseline.check import _others
from trackmarshal.trace.findings import Place


def test_pairs_of_subsystems_that_never_meet_are_called_so() -> None:
    now: dict[str, dict[str, str | list[str]]] = {
        "infeasible SO-DI": {"reason": "a"},
        "infeasible CO-SO": {"reason": "b"},
    }
    (note,) = _others(list(changes({}, now)), now, Place("requirements/baseline.json"))
    assert "new since the baseline: 2 pairs without an interface" in note.message
