"""Words and signs that the reports share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from trackmarshal.trace.findings import LEVELS, Finding
from trackmarshal.trace.matrix import Matrix

#: Beside the word, never instead of it; from best to worst.
SIGNS = {"covered": "✓", "waived": "⚑", "partial": "◐", "missing": "○", "stale": "↻", "failed": "✗"}

MEANINGS = {
    "covered": "all that counts here is there, is up to date and passed",
    "waived": "a gap that somebody answers for until a day",
    "partial": "some of what counts here is missing",
    "missing": "nothing of what counts here is there, or it was not run",
    "stale": "what it was made from has changed since",
    "failed": "a test failed, or a run contradicts its expectation",
}

#: Statuses and outcomes by the status of cells that they look like: its sign and colour stand beside the word.
LIKE: Mapping[str, str] = {
    **{word: word for word in ("covered", "waived", "partial", "missing", "stale", "failed")},
    "passed": "covered", "run": "covered", "there": "covered", "accepted": "covered", "supported": "covered", "pass": "covered", "complete": "covered",
    "pass with reservations": "waived", "open": "partial", "with reservations": "waived", "not run": "missing", "skipped": "missing", "no verdict": "missing", "not written down": "missing",
    "changed": "stale", "error": "failed", "fail": "failed", "not supported": "failed",
}  # fmt: skip


def tally(matrix: Matrix) -> str:
    """How many findings of each level, and what a pass is reserved by."""
    number = {level: sum(finding.level == level for finding in matrix.findings) for level in LEVELS}
    said = ", ".join(f"{count} {level}{'' if count == 1 else 's'}" for level, count in number.items())
    held = [what for what in matrix.reservations if "should be looked at" not in what]
    return f"{said}; {', '.join(held)}" if held and matrix.passes else said


def follows(found: Sequence[Finding]) -> str:
    """How many findings follow from another one, by their codes; empty for none."""
    codes = Counter(finding.code for finding in found)
    said = ", ".join(
        code if number == 1 else f"{code} {number} times" for code, number in sorted(codes.items())
    )
    return f"and {len(found)} that follow{'s' if len(found) == 1 else ''} from it: {said}" if found else ""


def unreviewed(matrix: Matrix) -> list[tuple[str, list[str]]]:
    """What nobody has reviewed, by kind; the kinds in the order in which their first thing comes."""
    found: dict[str, list[str]] = {}
    for kind, id_ in matrix.unreviewed:
        found.setdefault(kind, []).append(id_)
    return list(found.items())


def inputs(matrix: Matrix) -> str:
    """What went in."""
    names = {"test_results": "test results", "external_tests": "external tests", "code_links": "code links"}
    return ", ".join(
        f"{count} {names.get(what, what) if count != 1 else names.get(what, what)[:-1]}"
        for what, count in matrix.counts.items()
    )


def printable(text: str) -> str:
    """Text in one line, without control characters that would steer a terminal."""
    return text if text.isprintable() else "".join(char if char.isprintable() else " " for char in text)
