"""Swept footprints, corridors, clearances and curvilinear coordinates, many at a time over numpy arrays."""

from trackmarshal.runtime.geometry.clearance import boxes_clear, least_clear, sweeps_clear
from trackmarshal.runtime.geometry.corridor import Corridor, Polygon
from trackmarshal.runtime.geometry.paths import distance_to_paths
from trackmarshal.runtime.geometry.polyline import Polyline

__all__ = [
    "Corridor",
    "Polygon",
    "Polyline",
    "boxes_clear",
    "distance_to_paths",
    "least_clear",
    "sweeps_clear",
]
