"""What a cycle was once it is decided what is driven: rules that remember see it so from then on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal.runtime.contract import FOLLOWED, IS_DRIVEN, IS_EMERGENCY, PLAN
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.faults import Fault, fault, name_of
from trackmarshal.runtime.frame import Columns, Frame

if TYPE_CHECKING:
    from trackmarshal.runtime.decision import Decision
    from trackmarshal.runtime.plan import Plan

#: Faults after the door for which it is not known what a cycle came to.
_IN_DOUBT = {"judge_failed", "incomplete", "internal"}
#: More cycles than this are not missed for their numbers alone: sums of them fit whole numbers of C, and no count is compared with as many.
MOST_LOST = 2**40


def in_doubt(frame: Frame, decision: Decision | None) -> bool:
    """Whether a cycle says nothing for sure: the door refused it, or the Supervisor failed in it. An overrun leaves no doubt."""
    if frame.faults:
        return True
    return decision is not None and any(name_of(found) in _IN_DOUBT for found in decision.faults)


def drives_on(frame: Frame, decision: Decision | None) -> bool:
    """Whether what was decided to be driven is a frame's own driving candidate: then the cycle was what its rules saw."""
    driven = None if decision is None else decision.driven
    if driven is None or decision is None or driven.candidate != DRIVING or driven.t != decision.t:
        return False
    return not frame.faults and driven.columns is frame.candidates.get(DRIVING)


def as_driven(frame: Frame, decision: Decision | None) -> Frame:
    """A frame with the `plan` that was decided to be driven, unusable where there was none; a case stays as it is."""
    return frame if decision is None else driving(frame, decision.driven, decision.t)


def driving(frame: Frame, driven: Plan | None, t: float) -> Frame:
    """The same, given what is driven at a stamp."""
    if not frame.candidates:
        return frame
    emergency = driven is not None and driven.candidate == EMERGENCY
    events = {**frame.events, IS_EMERGENCY: int(emergency), IS_DRIVEN: int(driven is not None)}
    columns, faults = dict(frame.columns), list[Fault]()
    if driven is None:
        faults = [fault("missing", name) for name in (PLAN, FOLLOWED)]
        some = next(iter(frame.candidates.values()))
        columns |= {PLAN: some, FOLLOWED: some}
    else:
        now = _from_now(driven, t)
        columns |= {PLAN: now, FOLLOWED: now}
    return Frame(
        frame.id, frame.settings, columns, events, frame.lines, frame.closed, {}, faults, frame.orders, t=frame.t,
        number=frame.number, lanes=frame.lanes,
    )  # fmt: skip


def _from_now(plan: Plan, t: float) -> Columns:
    """A plan's samples from the last one that was due at a stamp on, their times counted from it; of its own cycle, all as they are."""
    if plan.t == t:
        return plan.columns
    first = plan.first(t)
    values = plan.columns.values[:, first:].copy()
    values[plan.columns.names.rows["t"]] += plan.t - t
    flags = None if plan.columns.flags is None else plan.columns.flags[:, first:]
    return Columns(plan.columns.names, values, flags)
