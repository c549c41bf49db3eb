"""The C that generated code calls, function by function; only what is called is put into a program."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

#: The files, in the order in which their functions may call each other.
FILES = (
    "numbers",
    "verdicts",
    "formulas",
    "several",
    "cases",
    "temporal",
    "online",
    "run",
    "lives",
    "pairs",
    "course",
    "future",
    "hopes",
    "geometry/exact",
    "geometry/curve",
    "geometry/near",
    "geometry/points",
    "geometry/hulls",
    "geometry/gaps",
    "geometry/inside",
    "geometry/stretches",
    "geometry/timelines",
    "geometry/clear",
    "geometry/lines",
    "geometry/paths",
    "geometry/lanes",
    "geometry/blocks",
    "geometry/polygons",
    "geometry/quads",
    "geometry/tracks",
    "door",
    "machine",
    "rulebooks",
)
_FOLDER = Path(__file__).parent
#: Begins with letters, not with a word boundary: that is found ten times as fast.
_NAME = re.compile(r"tm_[a-z0-9_]+")
#: Comments say what a spec says, which may be anything.
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
#: A function begins with the comment on it.
_BEGIN = re.compile(r"^(?=/\*\* )", re.MULTILINE)
_DEFINED = re.compile(r"\b(tm_[a-z0-9_]+)\(")

#: What a Supervisor's step is made of, around the functions that are generated for its contract; needed as a whole.
STEP = _FOLDER / "step.c"


@cache
def functions() -> dict[str, str]:
    """Function name -> its text with the comment before it, in order."""
    found: dict[str, str] = {}
    for file in FILES:
        text = (_FOLDER / f"{file}.c").read_text(encoding="utf-8")
        _, *chunks = _BEGIN.split(text)  # before the first function stands what the file is about
        for chunk in chunks:
            match = _DEFINED.search(_COMMENT.sub("", chunk))
            assert match is not None, chunk
            found[match.group(1)] = chunk.replace("/** ", "/* ", 1).rstrip() + "\n"
    return found


def needed(texts: Iterable[str]) -> list[str]:
    """The functions that texts call, directly or through others, in order."""
    known = functions()
    wanted: set[str] = set()
    stack = [name for text in texts for name in _NAME.findall(_COMMENT.sub("", text)) if name in known]
    while stack:
        name = stack.pop()
        if name not in wanted:
            wanted.add(name)
            stack += [other for other in _NAME.findall(known[name]) if other in known]
    return [name for name in known if name in wanted]
