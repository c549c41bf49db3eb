"""Evidence that says of itself that there is none: a page whose existence makes nothing true."""

from __future__ import annotations

import codecs
import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from trackmarshal.files import read_regular
from trackmarshal.records.specs import SpecItem
from trackmarshal.trace import sections
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.model import Project, matches
from trackmarshal.trace.shapes import ID
from trackmarshal.trace.spec import item_place

#: What such pages say; a project adds phrases of its own under `denials`.
PHRASES = Path(__file__).with_name("denials.txt")
#: Marks of Markdown between words, which are read as blanks; an underscore within a word is part of it.
_MARKS = re.compile(r"[\s*>~`]|(?<![^\W_])_|_(?![^\W_])")
#: Marks of HTML.
_TAG = re.compile(r"</?[A-Za-z][^<>]*>")
#: What shows the mark itself (`<!--` in code, or escaped) begins no comment; one that nothing ends is none, whatever browsers make of it.
_COMMENT = re.compile(r"(?<![`\\])<!--(?:-?>|.*?(?:-->|\Z))", re.DOTALL)
#: What no text has: of files with such characters nothing is read, as they hold words by chance.
_BINARY = re.compile(r"[\x00-\x08\x0e-\x1a\x1c-\x1f]")

#: What stands in a block of its own: an item of a list, a row of a table.
_ITEM = re.compile(r"\s*(?:[-*+]\s|\d+[.)]\s|\|)")
_ID = re.compile(rf"(?<![\w-]){ID}(?![\w-])")
_WORD = re.compile(r"[\w-]+")
#: Files that programs read, in which words such as `todo` are names.
_DATA = (".json", ".jsonl", ".csv", ".tsv", ".xml", ".yaml", ".yml")

#: Of what a page says gladly that there is none: a list, or a heading, of what went wrong.
_GLAD = re.compile(
    r"\b(?:deviations?|anomal(?:y|ies)|findings?|defects?|failures?|faults?|errors?|issues?|bugs?|violations?|accidents?|incidents?|limitations?|objections?|remarks?|"
    r"restrictions?|exceptions?|nonconformit(?:y|ies)|open points?|known problems?)[^\w.;]+(there (?:is|are) none)\b",
    re.IGNORECASE,
)
#: Headings of what was so in earlier versions of a page.
_HISTORY = re.compile(
    r"[\s#*_]*(?:\d[\d.]*\s+)?(?:(?:document|revision|version|change|release)s?\s+)?history[\s#*_:]*",
    re.IGNORECASE,
)
#: What stands within words, and nobody sees: soft hyphens, joiners, blanks of no width.
_UNSEEN = re.compile("[\u00ad\u200b-\u200f\u2060-\u2064\ufeff]")


class Claim(NamedTuple):
    """A document that is to show something of a thing, by its name. kind: of the thing; place: where it is said."""

    path: str
    name: str
    kind: str
    place: Place

    @property
    def key(self) -> tuple[str, str]:
        """By which it stands among the denials: a section of the design for itself, as the page may be evidence too."""
        return (sections.key(self.path, self.name) if self.kind == "section" else self.path), self.name


#: By path and assumption, requirement, analysis or review, the place where a document says so of it, and its words.
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
    """A phrase as a regular expression: `a|b` is the one or the other, with `?` behind it it may be missing, with `!` before it it may not follow, or
    as the first word come before; behind `!...`, no word may follow."""
    made, gap = "", ""
    for word in said.split():
        some = "(?:" + "|".join(map(re.escape, word.strip("!?").split("|"))) + ")"
        if word.startswith("!") and not made:
            made = "".join(rf"(?<!\b{re.escape(before)}\s)" for before in word.strip("!").split("|"))
        elif word == "!...":
            made += r"(?!\s\w)"
        elif word.startswith("!"):
            made += rf"(?!\s+{some}(?![\w-]))"
        elif not word.endswith("?"):
            made, gap = made + gap + some, r"\s+"
        else:
            made += f"(?:{gap}{some})?"
    return made


def claims(project: Project, items: Iterable[SpecItem], denying: Container[str]) -> Iterator[Claim]:
    """What documents are to show: assumptions, requirements, analyses that leave nothing open, reviews; and sections of the design.

    denying: the documents that deny anything; the others are not held against every requirement."""
    for item in items:
        if item.kind == "assume" and item.evidence:
            yield Claim(item.evidence, item.name, "assumption", item_place(item))
    for entry in project.evidence:
        for r in project.by_id.values() if entry.path in denying else ():
            if r.demanded and matches(r.id, entry.requirements):
                yield Claim(str(entry.path), str(r.id), "requirement", entry.path.place)
    for made in project.entries:
        # An analysis that says what it leaves open shows nothing as long as it does, and may say so in its document as well.
        if made.kind in ("analysis", "review") and "open" not in made.attributes:
            for kind, path in made.links:
                if kind == "backed_by":
                    yield Claim(str(path), str(made.id), made.kind, path.place)
    for target, _, page, requirement in sections.allocated(project):
        yield Claim(page, requirement, "section", target.place)


def denying(root: Path, project: Project, own: Sequence[str] = ()) -> set[str]:
    """The documents among a project's evidence that deny anything at all."""
    pattern = _pattern((*phrases(), *own))
    paths = dict.fromkeys(str(entry.path) for entry in project.evidence)
    return {path for path in paths if _denied(pattern, _text(root, path))}


def load(root: Path, claimed: Iterable[Claim], own: Sequence[str] = ()) -> Denials:
    """What documents deny of what they are to show: where it is named, what stands there about it counts, else the whole document; of the design, sections
    alone.

    own: phrases of the project, beside those that come with the program.
    """
    pattern = _pattern((*phrases(), *own))
    pages: dict[str, _Page] = {}
    found = {}
    for claim in claimed:
        if claim.key in found or (claim.kind != "assumption" and claim.path.lower().endswith(_DATA)):
            continue
        if claim.path not in pages:
            pages[claim.path] = _Page(_text(root, claim.path), pattern)
        said = pages[claim.path].denial(claim.name, section=claim.kind == "section")
        if said is not None:
            line, column, words = said
            found[claim.key] = (Place(claim.path, line, column), words)
    return found


class _Page:
    """A document, looked through once however much it is to show."""

    def __init__(self, text: str, pattern: re.Pattern[str]) -> None:
        self._text = text
        self._whole = _denied(pattern, text)
        #: Level of headings, the words of the block, and what in it denies. What nothing in all of the text denies, nothing in a block does.
        self._blocks = (
            [(depth, set(_WORD.findall(block)), _ID.search(block) is not None, start, _denied(pattern, block)) for start, depth, block in _blocks(text)]
            if self._whole
            else []
        )  # fmt: skip

    def denial(self, name: str, section: bool) -> tuple[int, int, str] | None:
        """Line, column and words that deny something: what stands below a heading that names it, and blocks from one that names it on, down to the next
        heading; but not what names something else. section: all that stands below such headings, and nothing else. Where it is not named, all of the text."""
        level, about, named = 0, False, False
        for depth, words, others, start, match in self._blocks:
            here = name in words
            if depth:
                level = 0 if depth <= level else level
                level = level or (depth if here else 0)
                about = here or (level > 0 and not others)
            elif section:
                about = about or (here and level > 0)
            else:
                about = here or (about and not others)
            named = named or about
            if about and match is not None:
                return self._at(start, match)
        return None if named or section or self._whole is None else self._at(0, self._whole)

    def _at(self, start: int, match: re.Match[str]) -> tuple[int, int, str]:
        before = self._text[: start + match.start()]
        return before.count("\n") + 1, len(before) - before.rfind("\n"), " ".join(match[0].split())


def _denied(pattern: re.Pattern[str], text: str) -> re.Match[str] | None:
    """What denies in a text, as it is written, or as browsers show it; a sentence may go on in the next line."""
    found = pattern.search(_MARKS.sub(" ", text))
    if found is None and _TAG.search(text) is not None:
        found = pattern.search(_MARKS.sub(" ", _TAG.sub(lambda tag: " " * len(tag[0]), text)))
    return found


def _blocks(text: str) -> Iterator[tuple[int, int, str]]:
    """Headings with their levels, and paragraphs, items of lists and rows of tables with 0, each with where it begins."""
    begun, block, at = 0, "", 0
    for line, (depth, _) in zip(text.splitlines(keepends=True), sections.headed(text), strict=True):
        if block and (depth or not line.strip() or _ITEM.match(line)):
            yield begun, 0, block
            block = ""
        if depth:
            yield at, depth, line
        elif line.strip():
            begun, block = (begun, block + line) if block else (at, line)
        at += len(line)
    if block:
        yield begun, 0, block


def _text(root: Path, path: str) -> str:
    """A document's text, in whichever encoding; empty for what is no text, is too large or is not there, which is told elsewhere."""
    try:
        whole = (root / path).resolve()
        if not whole.is_relative_to(root.resolve()) or whole.stat().st_size > sections.LARGEST:
            return ""
        data = read_regular(whole)
        text = _decoded(data)
    except (OSError, ValueError, RuntimeError):
        return ""
    return "" if _BINARY.search(text) else _present(_GLAD.sub(_left_out, _uncommented(_UNSEEN.sub("", text))))


def _decoded(data: bytes) -> str:
    """UTF-8; UTF-16 where a mark says so; else an encoding of one byte a character, as words of denials have letters that all of them have."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _uncommented(text: str) -> str:
    """A text with blanks in place of its comments, which nobody sees who reads the page; all of it where it says nothing else."""
    seen = _COMMENT.sub(_hidden, text)
    return seen if any(_WORD.search(block) for _, depth, block in _blocks(seen) if not depth) else text


def _hidden(comment: re.Match[str]) -> str:
    """Blanks in place of a comment that has an end."""
    return re.sub(r"[^\s]", " ", comment[0]) if comment[0].endswith(">") else comment[0]


def _left_out(glad: re.Match[str]) -> str:
    """What stands there, with blanks in place of what denies nothing: all else stays where it is."""
    return glad[0][: -len(glad[1])] + " " * len(glad[1])


def _present(text: str) -> str:
    """A text with blanks in place of its history, as what was not there then may be now; all of it where it says nothing else."""
    if "history" not in text.lower():
        return text
    level, rest, kept = 0, False, list(text)
    for start, depth, block in _blocks(text):
        if depth and not 0 < level < depth:
            level = depth if _HISTORY.fullmatch(block.splitlines()[0]) else 0
        elif level:
            kept[start : start + len(block)] = re.sub(r"[^\s#]", " ", block)
        else:
            rest = rest or (not depth and re.search(r"\w", block) is not None)
    return "".join(kept) if rest else text


#: What is said of a document, by what it is to show.
_SAID = {
    "assumption": "the evidence `{path}` of the assumption `{name}` says that there is none",
    "requirement": "the evidence `{path}` of `{name}` says that there is none",
    "analysis": "the document `{path}` of the analysis `{name}` says that there is none",
    "review": "the document `{path}` of the review `{name}` says that there is none",
    "section": "the section of `{path}` about `{name}` says that it is still to come",
}


def check(project: Project, items: Iterable[SpecItem], denials: Denials) -> Iterator[Finding]:
    """T253 for everything that such a document is to show, once."""
    claimed = claims(project, items, {path for path, _ in denials}) if denials else ()
    for key, claim in {claim.key: claim for claim in claimed}.items():
        if key in denials:
            place, words = denials[key]
            message = f'{_SAID[claim.kind].format(path=claim.path, name=claim.name)}: "{words}"'
            help_ = "back it by a record, or have somebody answer for the gap by a waiver"
            yield Finding("T253", "error", message, claim.place, help_, claim.name, ((place, "said here"),))


__all__ = ["PHRASES", "Claim", "Denials", "check", "claims", "denying", "load", "phrases"]
