"""Maps of lanelets and vehicles on them, as the cycles that the rulebook `interstate` takes: docs/interstate.md.

Importing this costs nothing: each name is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from trackmarshal.lanes.lanelet import Lanelet
    from trackmarshal.lanes.network import Lane, Network
    from trackmarshal.lanes.vehicles import Vehicle, cycle

__all__ = ["Lane", "Lanelet", "Network", "Vehicle", "cycle"]
_HOMES = {
    "Lane": "network", "Lanelet": "lanelet", "Network": "network", "Vehicle": "vehicles", "cycle": "vehicles",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
