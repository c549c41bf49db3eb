"""The layer that executes decisions, as a reference: what to drive at a time, given what was heard last.

It does no input or output: whoever drives hands it what comes, and asks it. docs/process.md has its rules; executing.c does the same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from .messages import Layout, Message

NOTHING, DRIVE, FALLBACK = "nothing", "drive", "fallback"
#: Why.
UNHEARD, DECIDED, RESTARTED, SILENT = "unheard", "decided", "restarted", "silent"
OUTDATED, LEFT, ENDED = "outdated", "left", "ended"


@dataclass(frozen=True)
class Setpoint:
    """What to drive at a time: sample `index` and the share of the way to the next one, and all columns of numbers there, None for nothing.

    action: `nothing`: no trajectory may be driven, and the layer below has to know what to do; `drive`: the driving trajectory of the newest
    decision; `fallback`: the emergency trajectory that was stored last. number: of the cycle that it is from.
    """

    action: str
    why: str
    number: int = 0
    index: int = 0
    share: float = 0.0
    sample: dict[str, float] | None = None


class Executing:
    """silence: s without a sign of life after which the Supervisor is taken for dead. simulated: whether the Supervisor's clock has to be,
    or must not be, that of its messages."""

    def __init__(self, layout: Layout, silence: float | None = None, simulated: bool = False) -> None:
        self._layout = layout
        self._silence = layout.silence if silence is None else silence
        self._simulated = simulated
        self._session = self._decided = self._beats = 0
        self._alive = -math.inf
        #: What the newest decision said to drive was left: it is not taken up again.
        self._left = False
        self._newest: Message | None = None
        self._fallback: Message | None = None
        #: Messages that were not taken, by cause.
        self.refused: dict[str, int] = {}

    def hear(self, data: bytes) -> str:
        """Bytes that came; "none", or why they are not taken: then they have changed nothing."""
        cause, message = self._layout.look(data, up=False)
        if message is not None:
            cause = self._judge(message)
        if cause != "none":
            self.refused[cause] = self.refused.get(cause, 0) + 1
        return cause

    def _judge(self, message: Message) -> str:
        head, decision = message.head, message.kind.name == "decision"
        last = 0 if head.session > self._session else self._decided if decision else self._beats
        if bool(message["simulated"]) != self._simulated:
            return "content"
        if head.session < self._session:
            return "session"
        if head.sequence <= last:
            return "sequence"
        if head.session > self._session:
            # A Supervisor that started later. What is stored from the one before stays: it was safe, and the new one knows nothing.
            self._session, self._decided, self._beats, self._alive = head.session, 0, 0, -math.inf
        self._alive = max(self._alive, head.sent)
        if not decision:
            self._beats = head.sequence
            return "none"
        self._decided, self._newest, self._left = head.sequence, message, False
        if message["stored"]:
            self._fallback = message
        elif self._fallback is not None and self._fallback.head.session == head.session:
            self._fallback = None  # the one who stored it says that it is lost
        return "none"

    def at(self, now: float) -> Setpoint:
        """What to drive at `now`, s on the Supervisor's clock. Not to be asked for times that go back."""
        newest = self._newest
        if self._decided == 0 or newest is None:  # the Supervisor before this one may have left a trajectory
            return Setpoint(NOTHING, UNHEARD) if self._fallback is None else self._fall_back(now, RESTARTED)
        why = ""
        if not now - self._alive <= self._silence:
            why = SILENT
        elif not newest["now"] <= now <= newest["valid_until"]:
            why = OUTDATED
        elif self._left:
            why = LEFT
        elif newest["driven"] == 1 and not now <= newest.due("driving")[-1]:
            why = ENDED
        if why:
            # A clock that was read just before the decision came leaves nothing: it is driven from its own time on.
            self._left = self._left or why != OUTDATED or not now < newest["now"]
            return self._fall_back(now, why)
        if newest["driven"] == 1:
            return self._sampled(newest, "driving", now, DRIVE, DECIDED, newest["driven_number"])
        if newest["driven"] == 2 or self._fallback is None:
            return self._fall_back(now, DECIDED)
        return self._fall_back(now, RESTARTED)

    def _fall_back(self, now: float, why: str) -> Setpoint:
        stored = self._fallback
        if stored is None or not now <= stored.due("fallback")[-1]:
            return Setpoint(NOTHING, why)
        return self._sampled(stored, "fallback", now, FALLBACK, why, stored["stored_number"])

    def _sampled(
        self, source: Message, group: str, now: float, action: str, why: str, number: int
    ) -> Setpoint:
        """A trajectory at a time, straight between samples; before its first sample, that one. A member stays until the next sample is due."""
        due = source.due(group)
        i = 0
        while i + 2 < len(due) and due[i + 1] <= now:
            i += 1
        step = due[i + 1] - due[i]
        # Samples that a large stamp has moved to one time: behind them, the second one.
        share = min(1.0, max(0.0, (now - due[i]) / step)) if step > 0.0 else float(now > due[i])
        sample = {}
        for name in self._layout.plan:
            before, after = source.column(group, name)[i : i + 2]
            if name in self._layout.plan_members:  # between two there is none
                sample[name] = before if share < 1.0 else after
                continue
            step = after - before
            if name == "heading":
                step = math.remainder(step, math.tau) if math.isfinite(step) else math.nan
            sample[name] = before + share * step
        return Setpoint(action, why, number, i, share, sample)
