"""Faults that campaigns put in, and what the Supervisor did about them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from trackmarshal.records.fields import Fields
from trackmarshal.records.tests import OUTCOMES


@dataclass(frozen=True, slots=True)
class FaultCase:
    """A fault that a campaign declares, put in or not."""

    campaign: str  #: path relative to the project
    id: str
    title: str
    requirement: str
    line: int
    fingerprint: str  #: sha256 of all that its outcome depends on; empty when that is not known
    open: str = ""  #: why it cannot be put in
    says: str = ""  #: sha256 of what is put in, when, and what is expected
    begin: float | None = (
        None  #: the first cycle that is changed, s; None where it is not put in, or changes nothing
    )

    def to_json(self) -> dict[str, Any]:
        return {
            "campaign": self.campaign, "id": self.id, "title": self.title, "requirement": self.requirement, "line": self.line,
            "fingerprint": self.fingerprint, "open": self.open, "says": self.says, "begin": self.begin,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> FaultCase:
        f = Fields(data, "fault")
        return cls(
            f.text("campaign"), f.text("id"), f.text("title"), f.text("requirement"), f.count("line"), f.text("fingerprint"),
            f.text("open", ""), f.text("says", ""), f.time("begin"),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class FaultResult:
    """What the Supervisor did about a fault: what found it, in which cycle (s) first, and what was driven then."""

    campaign: str
    id: str
    outcome: str  #: "passed": as expected, or "failed"
    fingerprint: str
    by: tuple[str, ...] = ()  #: rules and faults of the first unsafe cycle, the expected one first
    code: str = ""  #: the code of the first, if it is a fault
    first: float | None = None
    last: float | None = None
    driven: str = ""
    since: float | None = None  #: of which cycle the trajectory is that was driven instead
    lost: str = ""  #: why nothing stored was driven from `lost_at` on
    lost_at: float | None = None
    message: str = ""  #: how it differs from what was expected

    def to_json(self) -> dict[str, Any]:
        return {
            "campaign": self.campaign, "id": self.id, "outcome": self.outcome, "fingerprint": self.fingerprint, "by": list(self.by),
            "code": self.code, "first": self.first, "last": self.last, "driven": self.driven, "since": self.since, "lost": self.lost,
            "lost_at": self.lost_at, "message": self.message,
        }  # fmt: skip

    @classmethod
    def from_json(cls, data: object) -> FaultResult:
        f = Fields(data, "fault result")
        return cls(
            f.text("campaign"), f.text("id"), f.word("outcome", OUTCOMES), f.text("fingerprint"), f.texts("by"), f.text("code", ""),
            f.time("first"), f.time("last"), f.text("driven", ""), f.time("since"), f.text("lost", ""), f.time("lost_at"),
            f.text("message", ""),
        )  # fmt: skip
