"""Spec files as text: reading them safely, and places in them."""

from __future__ import annotations

import re
from bisect import bisect_right
from pathlib import Path

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import SETTLE, UNMERGED, fetching, read_regular, unmerged

#: The largest spec file that is read. 10,000 lines are about 0.6 MB.
MAX_BYTES = 4_000_000
#: A comment, or a string, in which there is none.
_COMMENT = re.compile(r'("(?:[^"\\\n]|\\.)*")|--[^\n]*')
#: What messages call a spec that comes from no file.
TEXT = "<text>"

CODES = {
    "E001": ("the file cannot be read", "The file does not exist, is a folder, a pipe or a device, or its permissions forbid reading it."),
    "E002": (
        "the file is too large",
        f"Spec files are read by people; one of more than {MAX_BYTES // 1_000_000} MB is taken for something else, and refused "
        "before it is read. Split a generated spec into modules.",
    ),
    "E003": ("the file is empty", "A spec file starts with `module NAME`. An empty file demands nothing, which is hardly meant."),
    "E004": ("the file is not UTF-8", "Spec files are UTF-8 text, with or without a byte order mark, with LF or CRLF line ends."),
    "E006": ("no spec files here", "The folder holds no file whose name ends in .spec, so that nothing would be checked or evaluated."),
    "E007": (
        "almost the name of a spec",
        "The file's suffix differs from .spec only by upper and lower case, so `use` would not find it and half of all systems would not read "
        "it. It is refused rather than left out: a rule less would read as safe.",
    ),
    "E008": (
        "a merge that is unfinished",
        "Both sides of what git could not merge stand in the file, between lines that begin with `<<<<<<<`, `=======` and `>>>>>>>`. Which of them "
        "holds is for people to say, so nothing of the file is read until then.",
    ),
    "E005": (
        "a control character in the file",
        "A NUL or another control character is never part of a spec; the file may be binary. Characters that turn the direction of "
        "writing, and line ends that few programs show, are refused too: what people read must be what is evaluated.",
    ),
}  # fmt: skip

#: Characters that a spec never holds: C0 and C1 controls but tab and line feed, odd line ends, changes of direction.
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u200e\u200f\u202a-\u202e\u2066-\u2069]")


class SourceFile:
    """The text of one spec file (line ends are LF), with the path that reports show."""

    def __init__(self, path: str, text: str) -> None:
        self.path = path
        self.text = text
        self._starts: list[int] | None = None

    def __repr__(self) -> str:
        return f"SourceFile({self.path!r})"

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column, both from 1, of a character offset."""
        starts = self._line_starts()
        line = bisect_right(starts, offset)
        return line, offset - starts[line - 1] + 1

    def line(self, number: int) -> str:
        """The text of line `number` (from 1), without its end."""
        starts = self._line_starts()
        if number > len(starts):
            return ""
        return self.text[starts[number - 1] : starts[number] - 1 if number < len(starts) else len(self.text)]

    def _line_starts(self) -> list[int]:
        if self._starts is None:
            self._starts = [0, *(match.end() for match in re.finditer("\n", self.text))]
        return self._starts


class Span:
    """A stretch of a source file: character offsets, the end not included."""

    __slots__ = ("end", "file", "start")

    def __init__(self, file: SourceFile, start: int, end: int) -> None:
        self.file = file
        self.start = start
        self.end = end

    @property
    def line(self) -> int:
        return self.file.position(self.start)[0]

    @property
    def column(self) -> int:
        return self.file.position(self.start)[1]

    def __str__(self) -> str:
        line, column = self.file.position(self.start)
        return f"{self.file.path}:{line}:{column}"

    def __repr__(self) -> str:
        return f"<{self}>"

    def to(self, other: Span) -> Span:
        """From the start of this span to the end of another one in the same file."""
        return Span(self.file, self.start, other.end)

    @property
    def head(self) -> Span:
        """The part of this span on its first line: where messages point to a declaration."""
        stop = self.file.text.find("\n", self.start)
        return Span(self.file, self.start, min(self.end, stop if stop >= 0 else self.end))

    def word(self, name: str) -> Span:
        """The first place in this span where a word stands; the head of the span when it does not occur."""
        text, at = self.file.text, self.start - 1
        while name:
            at = text.find(name, at + 1, self.end)
            if at < 0:
                break
            end = at + len(name)
            if not (at > 0 and _in_word(text[at - 1])) and not (end < self.end and _in_word(text[end])):
                return Span(self.file, at, end)
        return self.head

    @property
    def text(self) -> str:
        return self.file.text[self.start : self.end]

    @property
    def in_line(self) -> str:
        """The text as one line, without comments, each of which would take all that follows with it."""
        text = self.text
        if "--" in text:
            text = _COMMENT.sub(lambda found: found[1] or "", text)
        return " ".join(text.split())


def _in_word(char: str) -> bool:
    return char.isalnum() or char in "_-"


#: The span of things that no file holds (built-in names, trees made by programs).
NOWHERE = Span(SourceFile("<built-in>", ""), 0, 0)


def decode(path: str, data: bytes) -> SourceFile:
    """Bytes to a SourceFile; raises E003, E004, E005 or E008 with the line."""
    if not data.strip(b"\xef\xbb\xbf \t\r\n"):
        raise TrackmarshalError(
            "E003", "the file is empty", file=path, line=1, help="a spec file starts with `module NAME`"
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        message = f"byte {data[error.start]:#04x} at offset {error.start} is not UTF-8"
        raise TrackmarshalError(
            "E004", message, file=path, line=line, help="save the file as UTF-8"
        ) from error
    if line := unmerged(data):
        raise TrackmarshalError("E008", UNMERGED, file=path, line=line, help=SETTLE)
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    odd = _CONTROL.search(text)
    if odd is not None:
        line = text.count("\n", 0, odd.start()) + 1
        message = f"control character U+{ord(odd.group()):04X}"
        raise TrackmarshalError("E005", message, file=path, line=line, help="delete it; is this a text file?")
    return SourceFile(path, text)


def read(path: Path, shown: str | None = None) -> SourceFile:
    """Read a spec file; raises E001 to E005, E008. `shown` is the path that reports print."""
    name = shown or str(path)
    try:
        data = read_regular(path, MAX_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        message = getattr(error, "strerror", None) or str(error)
        help_ = fetching(path) or "check the path and its permissions"
        raise TrackmarshalError("E001", f"cannot be read: {message}", file=name, help=help_) from error
    return _within(name, data)


def of_text(text: str, shown: str = TEXT) -> SourceFile:
    """A text in memory as a spec file; raises E002 to E005, E008."""
    return _within(shown, text.encode("utf-8", "surrogatepass"))  # half a character is no UTF-8: E004


def _within(name: str, data: bytes) -> SourceFile:
    if len(data) > MAX_BYTES:
        message = f"the file is larger than {MAX_BYTES // 1_000_000} MB"
        raise TrackmarshalError("E002", message, file=name, help="split it into modules, if it is a spec")
    return decode(name, data)
