"""What a fault can touch while the loop runs. The one that touches nothing is the control."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from closed_loop.executing import Sensed
from closed_loop.message import Message, Object

if TYPE_CHECKING:
    from closed_loop.traffic import Other, World

#: Who gets a pose or a list of objects.
PLANNER, SUPERVISOR, CAR = "planner", "supervisor", "car"


class Fault:
    """The control: nothing is wrong. Times are s since the fault began, never negative; before that none of this is called."""

    id = "none"
    title = "Nothing is wrong"
    group = "control"
    requirement = ""
    #: The assumption that the fault breaks, where it is outside of what the Supervisor answers for.
    beyond = ""

    def begins(self, world: World) -> list[Other]:
        """Cars that come upon the road as the fault begins."""
        return []

    def sensed(self, who: str, since: float, past: Sequence[Sensed]) -> Sensed:
        """The pose that somebody gets; past: true poses 0.01 s apart, the present one last."""
        return past[-1]

    def seen(self, who: str, since: float, objects: tuple[Object, ...]) -> tuple[Object, ...] | None:
        """The objects that somebody is told of."""
        return objects

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        """What becomes of the planner's message; past: all before it, as the planner sent them, every 0.1 s."""
        return [message]

    def alive(self, since: float) -> bool:
        """Whether the Supervisor lives."""
        return True
