"""Faults by their stable names: breaches of the input contract by a cycle, and of the Supervisor's own integrity.

One entry a name: what docs/supervisor.md lists, what the generated C reports, what `explain` tells by code.
"""

from __future__ import annotations

from dataclasses import dataclass

#: Names of faults and of reasons for which a stored trajectory is lost -> code.
FAULTS = {
    "missing_cycle": "D221",
    "repeated": "D222",
    "out_of_order": "D223",
    "skipped": "D224",
    "late": "D225",
    "stale": "D226",
    "early": "D227",
    "wrong_type": "D202",
    "missing": "D211",
    "wrong_length": "D212",
    "too_short": "D213",
    "not_increasing": "D214",
    "not_finite": "D215",
    "out_of_range": "D216",
    "bad_border": "D217",
    "duplicate": "D218",
    "over_capacity": "D219",
    "unknown": "D220",
    "starts_elsewhere": "D228",
    "not_at_rest": "D229",
    "wrong_track": "D230",
    "judge_failed": "D231",
    "incomplete": "D232",
    "overrun": "D233",
    "bad_clock": "D234",
    "internal": "D235",
    "not_configured": "D236",
    "none_stored": "D241",
    "expired": "D242",
    "apart": "D243",
    "unconfirmed": "D244",
    "too_fast": "D245",
    "no_member": "D237",
}
NAMES = {code: name for name, code in FAULTS.items()}


#: Faults for which a signal, or the field that they name, cannot be used: what reads it is undefined, whatever it computes.
UNUSABLE = {"missing", "wrong_type", "wrong_length", "too_short", "bad_border", "over_capacity"}


@dataclass(frozen=True, slots=True)
class Fault:
    """One breach of the input contract: which field, which sample or element, and what is wrong."""

    code: str
    signal: str
    field: str
    index: int | None
    message: str

    @property
    def name(self) -> str:
        """What it is called (docs/supervisor.md)."""
        return name_of(self)

    def __str__(self) -> str:
        place = (
            self.signal
            + (f".{self.field}" if self.field else "")
            + ("" if self.index is None else f"[{self.index}]")
        )
        return f"{self.code} {place}: {self.message}"


def fault(name: str, signal: str, field: str = "", index: int | None = None, message: str = "") -> Fault:
    """A fault by its name; raises KeyError for a name that is none."""
    return Fault(FAULTS[name], signal, _sayable(field), index, _sayable(message))


def _sayable(text: str) -> str:
    """A text that may be of what was handed in: what no encoding has, and what would end a text of C, stands as its number."""
    if text.isascii() and "\0" not in text:
        return text
    return text.encode("utf-8", "backslashreplace").decode("utf-8").replace("\0", "\\x00")


def name_of(fault: Fault) -> str:
    """The stable name of a fault."""
    return NAMES[fault.code]
