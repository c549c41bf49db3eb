"""What is known of a log's recording without the log: what it is evaluated with. Needs no numpy."""

from __future__ import annotations

from trackmarshal.scenarios.field.mapping import Mapping
from trackmarshal.scenarios.recording import Recording


def header(mapping: Mapping) -> Recording:
    """The recording without its cycles and borders."""
    track = {"left": [], "right": [], "closed": mapping.closed}
    return Recording(mapping.name, mapping.source, (), track, use=(mapping.vehicle, *mapping.use))
