"""Evidence that says of itself that there is none: a page whose existence makes nothing true."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

from trackmarshal.files import read_regular
from trackmarshal.records import SpecItem
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.spec import Spec, item_place

#: What such pages say; a project adds phrases of its own under `denials`.
PHRASES = Path(__file__).with_name("denials.txt")
#: Marks of Markdown between words, which are read as blanks.
_MARKS = re.compile(r"[\s*>]")
#: Larger files, and files that are no text, are not read.
_MOST = 1_000_000

#: By path and assumption, the place where a document says so of it, and its words.
Denials = Mapping[tuple[str, str], tuple[Place, str]]


@cache
def phrases() -> tuple[str, ...]:
    """The phrases that come with the program."""
    lines = PHRASES.read_text("utf-8").splitlines()
    return tuple(line for line in lines if line.strip() and not line.startswith("#"))


@cache
def _pattern(said: tuple[str, ...]) -> re.Pattern[str]:
    """Any of some phrases, as whole words, however the lines between them are broken."""
    return re.compile(r"(?<![\w-])(?:" + "|".join(map(_phrase, said)) + r")(?![\w-])", re.IGNORECASE)


def _phrase(said: str) -> str:
    """A phrase as a regular expression: `a|b` is the one or the other, with `?` behind it it may be missing, with `!` before it it may not follow."""
    made = ""
    for word in said.split():
        some = "(?:" + "|".join(map(re.escape, word.strip("!?").split("|"))) + ")"
        gap = r"\s+" if made else ""
        if word.startswith("!"):
            made += rf"(?!\s+{some}(?![\w-]))"
        elif word.endswith("?"):
            made += f"(?:{gap}{some})?"
        else:
            made += gap + some
    return made


def load(root: Path, items: Iterable[SpecItem], own: Sequence[str] = ()) -> Denials:
    """What the documents that back assumptions deny of them: where one is named, the paragraphs that name it count, else the whole document.

    own: phrases of the project, beside those that come with the program.
    """
    pattern = _pattern((*phrases(), *own))
    texts: dict[str, str] = {}
    found = {}
    for item in items:
        if item.kind == "assume" and item.evidence:
            text = texts.setdefault(item.evidence, _text(root, item.evidence))
            for start, part in _about(text, item.name):
                match = pattern.search(_MARKS.sub(" ", part))  # a sentence may go on in the next line
                if match is not None:
                    before = text[: start + match.start()]
                    place = Place(item.evidence, before.count("\n") + 1, len(before) - before.rfind("\n"))
                    found[item.evidence, item.name] = (place, " ".join(match[0].split()))
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
    except (OSError, ValueError, RuntimeError):
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


__all__ = ["PHRASES", "Denials", "check", "load", "phrases"]
