"""Maps of lanelets and vehicles on them, as the cycles that the rulebook `interstate` takes: docs/interstate.md."""

from trackmarshal.lanes.cycle import Vehicle, cycle
from trackmarshal.lanes.lanelet import Lanelet
from trackmarshal.lanes.network import Lane, Network

__all__ = ["Lane", "Lanelet", "Network", "Vehicle", "cycle"]
