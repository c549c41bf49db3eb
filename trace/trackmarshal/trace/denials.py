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

#: By path and assumption, the place where a document says so of it, and its words.
Denials = Mapping[tuple[str, str], tuple[Place, str]]


def load(root: Path, items: Iterable[SpecItem]) -> Denials:
    """What the documents that back assumptions deny of them: where one is named, the paragraphs that name it count, else the whole document."""
    texts: dict[str, str] = {}
    found = {}
    for item in items:
        if item.kind == "assume" and item.evidence:
            text = texts.setdefault(item.evidence, _text(root, item.evidence))
            for start, part in _about(text, item.name):
                match = _SAID.search(re.sub(r"\s", " ", part))  # a sentence may go on in the next line
                if match is not None:
                    before = text[: start + match.start()]
                    place = Place(item.evidence, before.count("\n") + 1, len(before) - before.rfind("\n"))
                    found[item.evidence, item.name] = (place, match[0])
                    break
    return found


def _about(text: str, name: str) -> Iterator[tuple[int, str]]:
    """The parts of a text that are about something, with where they begin."""
    named = [
        m
        for m in re.finditer(r"(?:[^\n]|\n(?!\s*\n))+", text)
        if re.search(rf"(?<![\w-]){re.escape(name)}(?![\w-])", m[0])
    ]
    if not named:
        yield 0, text
    for paragraph in named:
        yield paragraph.start(), paragraph[0]


def _text(root: Path, path: str) -> str:
    """A document's text; empty for what is no text, is too large or is not there, which is told elsewhere."""
    try:
        whole = (root / path).resolve()
        if not whole.is_relative_to(root.resolve()) or whole.stat().st_size > _MOST:
            return ""
        return read_regular(whole).decode("utf-8")
    except (OSError, ValueError):
        return ""


def check(spec: Spec, denials: Denials) -> Iterator[Finding]:
    """T253 for every assumption that such a document is to back."""
    for item in spec.by_name.values():
        if item.kind == "assume" and (item.evidence, item.name) in denials:
            place, words = denials[item.evidence, item.name]
            message = f'the evidence `{item.evidence}` of the assumption `{item.name}` says that there is none: "{words}"'
            help_ = "back it by a record, or have somebody answer for the gap by a waiver"
            yield Finding(
                "T253", "error", message, item_place(item), help_, item.name, ((place, "said here"),)
            )


__all__ = ["SAID", "Denials", "check", "load"]
