"""What goes from the planner, the localisation and the perception to the Supervisor: one cycle, and when it arrives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from closed_loop.executing import Sensed

Columns = dict[str, list[float]]
Object = dict[str, Any]


@dataclass(frozen=True)
class Message:
    """number and t as the planner stamps them; arrival, s: when the Supervisor has it. Columns and objects as the contract names them."""

    number: int
    t: float
    arrival: float
    driving: Columns
    emergency: Columns
    ego: Sensed
    objects: tuple[Object, ...] | None
    obstacles: tuple[Object, ...] = ()
    said: tuple[str, ...] = field(default=(), compare=False)
    action: str = ""
