"""What is known of a log's recording without the log: what it is evaluated with. Needs no numpy."""

from __future__ import annotations

from typing import Any

from trackmarshal.scenarios.field.mapping import Mapping
from trackmarshal.scenarios.recording import Recording


def header(mapping: Mapping) -> Recording:
    """The recording without its cycles and borders."""
    track = {"left": [], "right": [], "closed": mapping.closed}
    return Recording(
        mapping.name, mapping.source, (), track, use=(mapping.vehicle, *mapping.use), **given(mapping)
    )


def given(mapping: Mapping) -> dict[str, Any]:
    """What the mapping gives for all cycles, and why, as a recording has it."""
    return {
        "given": {name: value for name, (value, _) in mapping.given.items()},
        "because": {name: why for name, (_, why) in mapping.given.items()},
    }
