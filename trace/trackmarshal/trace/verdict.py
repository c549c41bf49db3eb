"""The verdict on a project, and its words: every page and every format says these and no others."""

from __future__ import annotations

from collections.abc import Sequence

PASS = "pass"
RESERVED = "pass with reservations"
FAIL = "fail"
#: Where no matrix was made.
NONE = "no verdict"

#: From worst to best, with what each means.
MEANINGS = {
    FAIL: "at least one finding is an error",
    NONE: "nothing was held against requirements",
    RESERVED: "no finding is an error, and something is waived, not covered where the gate asks for nothing, reviewed by nobody, or should be looked at",
    PASS: "no finding is an error, every demand of the V-model is covered, and all that is to be reviewed has been",
}
#: The status of cells whose colours a verdict has.
LOOKS = {PASS: "covered", RESERVED: "waived", NONE: "partial", FAIL: "failed"}
#: Beside the word, never instead of it.
SIGNS = {PASS: "✓", RESERVED: "⚑", FAIL: "✗", NONE: "○"}


def verdict(errors: int, reservations: Sequence[str]) -> str:
    """The word for so many errors and these reservations."""
    if errors:
        return FAIL
    return RESERVED if reservations else PASS


def worse(one: str, other: str) -> str:
    """The worse of two verdicts; raises ValueError for what is none."""
    order = list(MEANINGS)
    return order[min(order.index(one), order.index(other))]


__all__ = ["FAIL", "LOOKS", "MEANINGS", "NONE", "PASS", "RESERVED", "SIGNS", "verdict", "worse"]
