"""Faults of the planner: what it sends is not what it should be."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from closed_loop.adapter import times
from closed_loop.fault import Fault
from closed_loop.message import Columns, Message


def accelerations(s: list[float], v: list[float]) -> list[float]:
    """What the speeds ask for from each sample to the next, m/s^2; the last one is repeated."""
    a = [(q * q - p * p) / (2.0 * (t - s)) if t > s else 0.0 for p, q, s, t in zip(v, v[1:], s, s[1:])]
    return [*a, a[-1]]


def with_speeds(plan: Columns, v: list[float]) -> Columns:
    """The same path at other speeds: times and accelerations agree with them."""
    return {**plan, "v": v, "a": accelerations(plan["s"], v), "t": times(plan["s"], v)}


class Frozen(Fault):
    id, group, requirement = "P-01", "planner", "S-1-A-3"
    title = "The planner hangs: the same trajectories, with fresh stamps"

    def __init__(self) -> None:
        self._last: Message | None = None

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        self._last = self._last or past[-1]
        return [replace(message, driving=self._last.driving, emergency=self._last.emergency)]


class HalfSpeed(Fault):
    id, group, requirement = "P-02", "planner", "S-1-A-3"
    title = "Plans at half the speed, as if the car drove so"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        slow = [
            with_speeds(plan, [v / 2 for v in plan["v"]]) for plan in (message.driving, message.emergency)
        ]
        return [replace(message, driving=slow[0], emergency=slow[1])]


class Elsewhere(Fault):
    id, group, requirement = "P-03", "planner", "S-1-A-3"
    title = "Plans from a place 15 m ahead of the car"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        return [
            replace(message, driving=_from(message.driving, 15.0), emergency=_from(message.emergency, 15.0))
        ]


class Past(Fault):
    id, group, requirement = "P-04", "planner", "S-1-A-3"
    title = "Sends what it planned a second ago, with fresh stamps"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        old = past[-10]
        return [replace(message, driving=old.driving, emergency=old.emergency)]


class Drifting(Fault):
    id, group, requirement = "P-05", "planner", "S-1-A-2"
    title = "Plans off the road: 8 m to the left within 2.2 s"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        return [
            replace(message, driving=_aside(message.driving, 8.0, max(2.2 * message.driving["v"][0], 30.0)))
        ]


class TooFast(Fault):
    id, group, requirement = "P-06", "planner", "S-1-A-4"
    title = "Plans up to a third faster, beyond what the tyres hold"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        plan = message.driving
        v = [v * (1.0 + 0.33 * min(1.0, s / 60.0)) for s, v in zip(plan["s"], plan["v"])]
        return [replace(message, driving=with_speeds(plan, v))]


class NoRest(Fault):
    id, group, requirement = "P-07", "planner", "S-1-A-5"
    title = "The emergency trajectory drives on"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        plan = message.driving
        v = [max(v, 5.0) for v in plan["v"]]
        return [replace(message, emergency=with_speeds(plan, v))]


class TooHard(Fault):
    id, group, requirement = "P-08", "planner", "S-1-A-4"
    title = "The emergency trajectory brakes twice as hard as tyres can"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        plan = message.driving
        begin, v = plan["v"][0], []
        for s in plan["s"]:
            v.append(math.sqrt(max(begin * begin - 2.0 * 28.0 * s, 0.0)))
            if v[-1] == 0.0 and len(v) > 1:
                break
        cut = {name: column[: len(v)] for name, column in plan.items()}
        return [replace(message, emergency=with_speeds(cut, v))]


class NotANumber(Fault):
    id, group, requirement = "P-09", "planner", "S-1-B-9"
    title = "One coordinate is not a number"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        y = list(message.driving["y"])
        y[len(y) // 2] = math.nan
        return [replace(message, driving={**message.driving, "y": y})]


class OtherAxis(Fault):
    id, group, requirement = "P-10", "planner", "S-1-A-5"
    title = "Headings are counted from +y"

    def sent(self, since: float, message: Message, past: Sequence[Message]) -> list[Message]:
        turned = [
            {**plan, "heading": [heading - math.pi / 2 for heading in plan["heading"]]}
            for plan in (message.driving, message.emergency)
        ]
        return [replace(message, driving=turned[0], emergency=turned[1])]


def _from(plan: Columns, ahead: float) -> Columns:
    """A trajectory without its first metres; one that is shorter stays where it ends."""
    first = next((i for i, s in enumerate(plan["s"]) if s >= ahead), len(plan["s"]) - 2)
    first = min(first, len(plan["s"]) - 2)
    cut = {name: column[first:] for name, column in plan.items()}
    cut["s"] = [s - cut["s"][0] for s in cut["s"]]
    cut["t"] = [t - cut["t"][0] for t in cut["t"]]
    return cut


def _aside(plan: Columns, left: float, over: float) -> Columns:
    """A path that moves to the left over a distance, smoothly; all columns agree with it."""
    xs, ys = [], []
    for s, x, y, heading in zip(plan["s"], plan["x"], plan["y"], plan["heading"]):
        u = min(s / over, 1.0)
        d = left * u * u * (3.0 - 2.0 * u)
        xs.append(x - d * math.sin(heading))
        ys.append(y + d * math.cos(heading))
    count = len(xs)
    steps = [math.dist(p, q) for p, q in zip(zip(xs, ys), zip(xs[1:], ys[1:]))]
    s = [sum(steps[:i]) for i in range(count)]
    heading = list(plan["heading"])
    for i in range(1, count):
        before, after = max(i - 1, 0), min(i + 1, count - 1)
        heading[i] = math.atan2(ys[after] - ys[before], xs[after] - xs[before])
    kappa = list(plan["kappa"])
    for i in range(1, count - 1):
        kappa[i] = math.remainder(heading[i + 1] - heading[i - 1], math.tau) / max(s[i + 1] - s[i - 1], 1e-6)
    moved = {**plan, "x": xs, "y": ys, "s": s, "heading": heading, "kappa": kappa}
    return with_speeds(moved, plan["v"])


FAULTS = (Frozen, HalfSpeed, Elsewhere, Past, Drifting, TooFast, NoRest, TooHard, NotANumber, OtherAxis)
