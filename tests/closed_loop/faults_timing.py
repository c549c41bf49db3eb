"""Faults in time: messages that do not come, come late, or lie about when they are from; and a Supervisor that dies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from closed_loop.fault import Fault
from closed_loop.message import Message


class PlannerDies(Fault):
    id, group, requirement = "T-01", "timing", "S-1-B-6"
    title = "The planner dies: nothing comes any more"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        return []


class EverySecond(Fault):
    id, group, requirement = "T-02", "timing", "S-1-B-6"
    title = "Every second message is lost"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        return [message] if message.number % 2 else []


class Late(Fault):
    id, group, requirement = "T-03", "timing", "S-1-B-6"
    title = "Messages come 0.15 s later than they should"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        return [replace(message, arrival=message.arrival + 0.15)]


class Ahead(Fault):
    id, group, requirement = "T-04", "timing", "S-1-B-9"
    title = "The planner's clock jumps 5 s ahead"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        return [replace(message, t=message.t + 5.0)]


class SupervisorDies(Fault):
    id, group, requirement = "T-05", "timing", "S-1-B-4"
    title = "The Supervisor dies: no decision any more"

    def alive(self, since: float) -> bool:
        return False


FAULTS = (PlannerDies, EverySecond, Late, Ahead, SupervisorDies)
