"""The definitions of docs/geometry.md one by one, in plain Python: the oracle of `trackmarshal.runtime.geometry`."""

from trackmarshal.backends.reference.geometry.corridor import (
    corridor_fault,
    hull_inside_margin,
    hull_margin_in,
    hull_meets_margin,
    in_zone_margin,
    region_between,
    region_of,
    zone_fault,
)
from trackmarshal.backends.reference.geometry.curve import Curve, curve_between
from trackmarshal.backends.reference.geometry.curvilinear import (
    Line,
    centre_again,
    centre_line,
    distance_to_line,
    distance_to_path,
    line_again,
    line_fault,
    project,
    station_gap,
    stretch_room,
)
from trackmarshal.backends.reference.geometry.footprint import (
    clear_margin,
    convex_clearance,
    footprint,
    swept_clearance,
)
from trackmarshal.backends.reference.geometry.region import Region

__all__ = [
    "Curve", "Line", "Region", "centre_again", "centre_line", "clear_margin", "convex_clearance", "corridor_fault", "curve_between", "distance_to_line", "distance_to_path",
    "footprint", "hull_inside_margin", "hull_margin_in", "hull_meets_margin", "in_zone_margin", "line_again", "line_fault", "project",
    "region_between", "region_of", "station_gap", "stretch_room", 
    "swept_clearance", "zone_fault",
]  # fmt: skip
