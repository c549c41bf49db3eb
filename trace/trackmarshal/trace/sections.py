"""Sections of Markdown documents that are about one requirement: found by their headings, held by their hashes."""

from __future__ import annotations

import hashlib
import re
import unicodedata
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from trackmarshal.files import POINTERS
from trackmarshal.trace.model import Entry, Project
from trackmarshal.trace.shapes import MORE, put_off
from trackmarshal.trace.values import Placed

_HEADING = re.compile(r"[ ]{0,3}(#{1,6})(?:[ \t]+(.*?))?[ \t#]*")
#: What stands below a line that is a heading by that; and how lines begin below which it is a rule.
_UNDERLINE = re.compile(r"[ ]{0,3}(=+|-+)[ \t]*")
_NO_TEXT = re.compile(r"\s|[>#|<]|[-*+]\s|\d+[.)]\s|\[[^\]]+\]:")
#: What browsers show nothing of: comments, and elements whose contents are not for readers.
_COMMENT = re.compile(r"<!--.*?-->|<(script|style|template)\b[^>]*>.*?</\1\s*>", re.DOTALL | re.IGNORECASE)
#: How one begins that no end follows: at the beginning of a line, it goes on to the end of the document.
_UNENDED = re.compile(r"^[ ]{0,3}<(?:!--(?!-?>)|(?:script|style|template)\b)", re.IGNORECASE | re.MULTILINE)
_FENCE = re.compile(r"[ ]{0,3}(```+|~~~+)")
#: Letters and symbols by their category, which look like blanks.
_BLANK = "\u115f\u1160\u2800\u3164\uffa0"
#: What stands at the head of Markdown documents for programs.
_FRONT = re.compile(r"\A---\n.*?\n---(\n|\Z)", re.DOTALL)
#: What a link leads to, in a line of its own.
_LINK = re.compile(r"[ ]{0,3}\[[^\]]+\]:.*")
#: Larger documents are read by nobody; they have no sections here.
LARGEST = 16_000_000


def silent(document: bytes, markdown: bool = False) -> bool:
    """Whether a document says nothing: it has no letter or digit that anybody sees, or it is what Git LFS or git-annex puts in the place of contents that were not
    fetched. Comments of HTML nobody sees. One in Markdown says nothing below its headings, either. What is no text in UTF-8 says something."""
    if document.startswith(POINTERS):
        return True
    try:
        text = _seen(document.decode("utf-8-sig")) if len(document) <= LARGEST else None
    except UnicodeDecodeError:
        return False
    if text is None:
        return False
    legible = filter(_legible, _below(text) if markdown else text)
    said = "".join(islice(legible, MORE))  # of a long document, what follows changes nothing
    return not said or put_off(said)


def _below(text: str) -> str:
    """What a document in Markdown says beside its headings and what programs read at its head."""
    text = _FRONT.sub("", text.replace("\r\n", "\n"))
    return "\n".join(
        line
        for depth, line in headed(text)
        if not depth and not _FENCE.match(line) and not _LINK.fullmatch(line)
    )


def _legible(character: str) -> bool:
    """Whether anybody reads it: a letter or a digit, of any script, or a symbol."""
    return character not in _BLANK and unicodedata.category(character)[0] in "LNS"


def lettered(text: str) -> bool:
    """Whether a name or a reason has a letter that anybody sees."""
    return any(_legible(character) and character.isalpha() for character in text)


def _seen(text: str) -> str:
    """A text without what browsers show nothing of; what begins within a line, and no end follows, is seen."""
    text = _COMMENT.sub("", text)
    if _UNENDED.search(text) is None:
        return text
    lines = list(_lines(text))
    end = next((n for n, (code, line) in enumerate(lines) if not code and _UNENDED.match(line)), None)
    return text if end is None else "\n".join(line for _, line in lines[:end])


def _named(name: str) -> re.Pattern[str]:
    """An id, as a word of its own."""
    return re.compile(rf"(?<![\w-]){re.escape(name)}(?![\w-])")


def names(text: str, name: str) -> bool:
    """Whether a page names an id where somebody sees it."""
    return _named(name).search(_seen(text)) is not None


def section(text: str, name: str) -> str | None:
    """What stands below the first heading that names an id, down to the next heading of its level; None where there is none, or nothing is said below it.

    The id stands in the heading as a word of its own. Headings in code blocks are none, and comments of HTML say nothing.
    """
    found = _section(text, name)
    return None if found is None else found[1]


def _section(text: str, name: str) -> tuple[str, str] | None:
    """The heading of a section, and what it says."""
    named = _named(name)
    level, title, lines, below = 0, "", [], [""]
    for depth, line in headed(_seen(text)):
        if level and 0 < depth <= level:
            break
        if level:
            lines.append(line)
            below += [] if depth else [line]
        elif depth and named.search(line):
            level, title = depth, line
    said = "\n".join(lines).strip()
    # Headings within it say nothing. A line before all: it may begin with a rule and end with one, as what programs read does.
    return None if silent("\n".join(below).encode(), markdown=True) else (title, said)


def headed(text: str) -> Iterator[tuple[int, str]]:
    """Every line, with the level of the heading that it is, 0 for others."""
    lines = list(_lines(text))
    begun = plain = False  # whether a paragraph is, and whether it is one of text alone
    for n, (code, line) in enumerate(lines):
        heading = None if code else _HEADING.fullmatch(line)
        if code or heading is not None or not line.strip():
            begun = plain = False
        elif not begun:
            begun, plain = True, not _NO_TEXT.match(line)
        if heading is not None:
            yield len(heading[1]), heading[2] or ""
            continue
        below = lines[n + 1] if plain and n + 1 < len(lines) else (True, "")
        under = None if below[0] or _UNDERLINE.fullmatch(line) else _UNDERLINE.fullmatch(below[1])
        yield (0, line) if under is None else (1 if "=" in under[1] else 2, line)


def _lines(text: str) -> Iterator[tuple[bool, str]]:
    """Every line, and whether it is in a block of code."""
    fence = ""
    for line in text.splitlines():
        mark = _FENCE.match(line)
        rest = "" if mark is None else line[mark.end() :]
        begins = mark is not None and not fence and not (mark[1][0] == "`" and "`" in rest)
        # It ends with as many signs of the same kind, or more, and nothing behind them.
        ends = mark is not None and fence != "" and mark[1].startswith(fence) and not rest.strip()
        yield bool(fence) or begins, line
        if mark is not None and (begins or ends):
            fence = "" if ends else mark[1]


def key(path: str, requirement: str) -> str:
    """What the section about a requirement is called, among hashes of files."""
    return f"{path}#{requirement}"


def heading(path: str, requirement: str) -> str:
    """And what its heading is called there, as people read it."""
    return f"{key(path, requirement)} heading"


def allocated(project: Project) -> Iterator[tuple[Placed, Entry, str, str]]:
    """Where a requirement is allocated to an element with a document: the place where that is said, the element, the document, the requirement's id."""
    elements = {str(entry.id): entry for entry in reversed(project.entries) if entry.kind == "design element"}
    for requirement in project.by_id.values():
        for kind, target in requirement.links:
            element = elements.get(target) if kind == "allocated_to" and requirement.demanded else None
            for path in () if element is None else documents(element):
                if element is not None:
                    yield target, element, path, str(requirement.id)


def documents(element: Entry) -> tuple[str, ...]:
    """The files in which an element is written down."""
    return tuple(str(path) for kind, path in element.links if kind == "backed_by")


def hashes(root: Path, project: Project) -> dict[str, str | None]:
    """The SHA-256 of every section that a design element is to have, however its lines are broken; None where there is none."""
    found: dict[str, str | None] = {}
    texts: dict[str, str] = {}
    for _, _, path, requirement in allocated(project):
        if path not in texts:
            texts[path] = _read(root, path)
        there = _section(texts[path], requirement)
        title, said = there or ("", "")
        digest = hashlib.sha256(" ".join(said.split()).encode()).hexdigest()
        found[key(path, requirement)] = digest if there else None
        found[heading(path, requirement)] = " ".join(title.split())
    return found


def _read(root: Path, path: str) -> str:
    """The text of a document; empty where it cannot be read, which is said of the file."""
    try:
        whole = (root / path).resolve()
        if not whole.is_relative_to(root.resolve()) or whole.stat().st_size > LARGEST:
            return ""
        return whole.read_text(encoding="utf-8")
    except (OSError, ValueError, RuntimeError):
        return ""


__all__ = ["allocated", "documents", "hashes", "headed", "key", "section", "silent"]
