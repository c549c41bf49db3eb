"""Evidence that says of itself that there is none: a page whose existence makes nothing true."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from trackmarshal.files import read_regular
from trackmarshal.records import SpecItem
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.spec import Spec, item_place

#: What such pages say. Only sentences that can hardly mean anything else: a person reads the rest.
SAID = (
    r"(?:no|without(?: any)?) evidence", r"holds? none", r"there (?:is|are) none", r"no (?:evidence|record|report|proof|measurement)s? (?:exists?|yet|so far)",
    r"tb[cd]", r"todo", r"(?:is|are|has|have|still) to be (?:done|provided|written|shown|measured|determined)",
)  # fmt: skip
_SAID = re.compile(r"(?<![\w-])(?:" + "|".join(SAID) + r")(?![\w-])", re.IGNORECASE)
#: Larger files, and files that are no text, are not read.
_MOST = 1_000_000

#: By path, the place where a document says so, and its words.
Denials = Mapping[str, tuple[Place, str]]


def load(root: Path, items: Iterable[SpecItem]) -> Denials:
    """The documents that back assumptions and say that there is no evidence."""
    found = {}
    for path in sorted({item.evidence for item in items if item.evidence}):
        said = _denial(root, path)
        if said is not None:
            found[path] = said
    return found


def _denial(root: Path, path: str) -> tuple[Place, str] | None:
    try:
        whole = (root / path).resolve()
        if not whole.is_relative_to(root.resolve()) or whole.stat().st_size > _MOST:
            return None
        text = read_regular(whole).decode("utf-8")
    except (OSError, ValueError):  # that it is not there is told elsewhere
        return None
    match = _SAID.search(re.sub(r"\s", " ", text))  # a sentence may go on in the next line
    if match is None:
        return None
    before = text[: match.start()]
    return Place(path, before.count("\n") + 1, match.start() - before.rfind("\n")), match[0]


def check(spec: Spec, denials: Denials) -> Iterator[Finding]:
    """T253 for every assumption that such a document is to back."""
    for item in spec.by_name.values():
        if item.kind == "assume" and item.evidence in denials:
            place, words = denials[item.evidence]
            message = f'the evidence `{item.evidence}` of the assumption `{item.name}` says that there is none: "{words}"'
            help_ = "back it by a record, or have somebody answer for the gap by a waiver"
            yield Finding(
                "T253", "error", message, item_place(item), help_, item.name, ((place, "said here"),)
            )


__all__ = ["SAID", "Denials", "check", "load"]
