"""What source code says it implements: `implements S-1-B-4` in a comment of its own, or at the start of one."""

from __future__ import annotations

import io
import re
import tokenize
from collections.abc import Collection, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from trackmarshal.files import below, read_regular
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error
from trackmarshal.trace.model import Project
from trackmarshal.trace.shapes import ID
from trackmarshal.trace.values import Placed

#: The largest source file that is read.
MAX_BYTES = 16_000_000
_PYTHON = (".py", ".pyi")
_HASH = (".sh", ".bash", ".yaml", ".yml", ".toml", ".cmake", ".rb", ".pl", ".mk")
_SLASHES = (
    ".c", ".h", ".cc", ".cpp", ".cxx", ".hh", ".hpp", ".hxx", ".cu", ".rs", ".go", ".java", ".kt", ".scala", ".swift", ".js", ".mjs",
    ".ts", ".tsx", ".jsx", ".cs", ".proto",
)  # fmt: skip
SUFFIXES = (*_PYTHON, *_HASH, *_SLASHES)

_MARKER = re.compile(r"[\s*/#!]*implements:?[ \t]+(?P<ids>[^\n]*)")
_ID = re.compile(ID)
#: A first word that was hardly meant as prose: an id, or one misspelt.
_LIKE_AN_ID = re.compile(rf"{ID}|[A-Za-z][A-Za-z0-9]*([-_][A-Za-z0-9]+)*[-_][0-9]+")
#: An id with whatever marks around it. In prose, names such as `Cooley-Tukey` stand so, too; they have no number.
_MARKED = re.compile(rf"[^\w\s]*(?P<id>{ID})[^\w\s]*")
#: Strings, so that what looks like a comment in them is passed over, and comments.
_C = r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|(?P<line>//[^\n]*)|(?P<block>/\*.*?\*/)'
_THREE_QUOTES = r'"""(?:\\.|(?!""").)*"""'
_BACKTICKS = r"`(?:\\.|[^`\\])*`"
#: By suffix, strings of the language that may go over lines; they come before all others.
_OVER_LINES = {
    **dict.fromkeys(
        (".h", ".cc", ".cpp", ".cxx", ".hh", ".hpp", ".hxx", ".cu"), r'R"([^()\\\s]{0,16})\(.*?\)\1"'
    ),
    ".rs": r'r(#*)".*?"\1|"(?:\\.|[^"\\])*"',
    ".go": r"`[^`]*`",
    **dict.fromkeys((".js", ".mjs", ".ts", ".tsx", ".jsx"), _BACKTICKS),
    **dict.fromkeys((".java", ".kt", ".scala", ".swift"), _THREE_QUOTES),
    ".cs": rf'{_THREE_QUOTES}|(?:@\$?|\$@)"(?:""|[^"])*"',
}


@cache
def _code(suffix: str) -> re.Pattern[str]:
    """Of a language with slashes, strings and comments."""
    return re.compile("|".join([*filter(None, [_OVER_LINES.get(suffix)]), _C]), re.DOTALL)


_SHELL = re.compile(r"(?:^|(?<=\s))#[^\n]*", re.MULTILINE)


class Marker(NamedTuple):
    """A requirement that source code says it implements, and where."""

    requirement: str
    place: Place


def load(root: Path, project: Project, found: list[Finding]) -> tuple[Marker, ...]:
    """The markers of all files of source code in the folders that the project names; what cannot be read goes to `found` (T343 to T345)."""
    markers: dict[Marker, None] = {}
    for folder in project.sources:
        for path in _files(root, folder, found):
            shown = path.relative_to(root).as_posix()
            try:
                data = read_regular(path, MAX_BYTES + 1)
                if len(data) > MAX_BYTES:
                    raise ValueError(f"larger than {MAX_BYTES // 1_000_000} MB")
                if b"implements" not in data:
                    continue
                comments = list(_comments(path.suffix.lower(), data.decode("utf-8-sig")))
            except (OSError, ValueError, SyntaxError, tokenize.TokenError) as problem:
                help_ = "it may say what it implements: make it readable, as UTF-8"
                message = f"a source file that cannot be read: {_why(problem)}"
                found.append(error("T344", message, Place(shown), help_))
                continue
            for line, column, text in comments:
                markers |= dict.fromkeys(_markers(shown, line, column, text, project.by_id, found))
    return tuple(markers)


def check(project: Project, markers: tuple[Marker, ...]) -> Iterator[Finding]:
    """Markers of what is not demanded (T342)."""
    for marker in markers:
        requirement = project.by_id.get(marker.requirement)
        if requirement is None or not requirement.demanded:
            why = "which is no requirement" if requirement is None else "which is demanded no longer"
            message = f"this implements `{marker.requirement}`, {why}"
            help_ = did_you_mean(marker.requirement, project.by_id) if requirement is None else ""
            yield error("T342", message, marker.place, help_, marker.requirement)


def _files(root: Path, folder: Placed, found: list[Finding]) -> list[Path]:
    path = root / folder
    if path.is_file():
        return [path]
    if not path.is_dir():
        message = f"the folder of source code `{folder}` is not there"
        found.append(error("T343", message, folder.place, "correct the path, or strike it", folder))
        return []
    files, problems = below(path, SUFFIXES)
    for problem in problems:
        message = f"`{folder}`: {problem.strerror or problem}"
        found.append(error("T343", message, folder.place, "make it readable", folder))
    return files


def _why(problem: Exception) -> str:
    match problem:
        case OSError(strerror=str(said)):
            return said
        case tokenize.TokenError(args=(str(said), *_)):
            return said
        case _:
            return str(problem)


def _comments(suffix: str, text: str) -> Iterator[tuple[int, int, str]]:
    """The comments of a file that may hold a marker: line and column from 1, and the text, each line of a block by itself."""
    if suffix in _PYTHON:
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            if token.type == tokenize.COMMENT:
                yield token.start[0], token.start[1] + 1, token.string
        return
    for match in (_code(suffix) if suffix in _SLASHES else _SHELL).finditer(text):
        if "implements" not in match[0] or (suffix in _SLASHES and match.lastgroup is None):
            continue
        line = text.count("\n", 0, match.start()) + 1
        column = match.start() - text.rfind("\n", 0, match.start())
        for number, part in enumerate(match[0].split("\n")):
            yield line + number, column if number == 0 else 1, part


def _markers(
    shown: str, line: int, column: int, text: str, known: Collection[str], found: list[Finding]
) -> Iterator[Marker]:
    match = _MARKER.match(text)
    if match is None:
        return
    said = match["ids"].partition(":")[0].replace("*/", " ")  # what follows a colon is for people
    words = [word for word in re.split(r"[,\s]+", said) if word]
    if not words or not (_LIKE_AN_ID.fullmatch(words[0]) or _is_marked(words[0], known)):
        return  # prose that begins with this word
    place = Place(shown, line, column + match.start("ids"))
    for word in words:
        if _ID.fullmatch(word):
            yield Marker(word, place)
        else:
            help_ = "write ids with commas between them, and what else there is to say behind a colon"
            found.append(error("T345", f"`{word}` is no id of a requirement", place, help_))
            return


def _is_marked(word: str, known: Collection[str]) -> bool:
    marked = _MARKED.fullmatch(word)
    return marked is not None and (marked["id"] in known or any(map(str.isdigit, marked["id"])))
