"""How a requirement's statement is worded: one `shall`, and no words that nobody can test."""

from __future__ import annotations

import re
from collections.abc import Iterator

from trackmarshal.trace.findings import Finding, error, warning
from trackmarshal.trace.model import Requirement

#: Words that leave open what is demanded.
WEAK = (
    "adequate", "and/or", "appropriate", "approximately", "as far as possible", "as possible", "be able to", "could", "easy", "etc",
    "fast", "flexible", "generally", "if necessary", "if possible", "may", "might", "normally", "quickly", "reasonable", "robust",
    "should", "some", "sufficient", "suitable", "tbc", "tbd", "timely", "typically", "user-friendly", "usually", "where possible",
)  # fmt: skip
_WEAK = re.compile(r"(?<![\w-])(" + "|".join(map(re.escape, WEAK)) + r")(ly)?(?![\w-])", re.IGNORECASE)
_SHALL = re.compile(r"\bshall\b", re.IGNORECASE)


def check(requirement: Requirement) -> Iterator[Finding]:
    """T140 for other than one `shall`, T141 (a warning) for weak words."""
    statement = requirement.statement
    if not statement:
        return
    number = len(_SHALL.findall(statement))
    if number != 1:
        said = "no `shall`" if number == 0 else f"{number} times `shall`"
        help_ = "say what shall be" if number == 0 else "split it into one requirement for each"
        yield error(
            "T140", f"the statement of `{requirement.id}` has {said}", statement.place, help_, requirement.id
        )
    weak = dict.fromkeys(match.group(0).lower() for match in _WEAK.finditer(statement))
    if weak:
        words = ", ".join(f"`{word}`" for word in weak)
        help_ = "say how much, or under which condition"
        yield warning(
            "T141",
            f"the statement of `{requirement.id}` leaves open what {words} means",
            statement.place,
            help_,
            requirement.id,
        )
