"""YAML text to a tree with places, refusing whatever a requirements file has no need for.

The parser's events are read one by one, so nothing is built before it has been judged: no anchors and aliases (and so
no bombs of them), no tags (and so no objects), one document, no duplicate keys, bounded depth. Values stay text; what
kind of value a place wants is the business of `shapes`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from trackmarshal.files import SETTLE, UNMERGED, read_regular, unmerged
from trackmarshal.trace.findings import Finding, Place, error

#: The largest requirements file that is read; 10,000 requirements are about 6 MB.
MAX_BYTES = 16_000_000
#: How deep lists and mappings may nest; the documents here need 7.
MAX_DEPTH = 20
#: What turns the direction of writing, so that a text looks like another one.
_TURNS = re.compile("[\u202a-\u202e\u2066-\u2069]")
#: A comment behind a value.
_COMMENT = re.compile(r"[ \t]+#[^\r\n]*")


class Node:
    """A value with its place."""

    __slots__ = ("column", "line")

    def __init__(self, line: int, column: int) -> None:
        self.line = line
        self.column = column


class Scalar(Node):
    """Text; `plain` when it stands without quotes, so that YAML readers might take it for a number or a Boolean.

    comment: what follows a plain one on its line, from `#` on: to YAML no part of it, which whoever wrote a text may not know.
    """

    __slots__ = ("comment", "plain", "text")

    def __init__(self, text: str, plain: bool, line: int, column: int, comment: str = "") -> None:
        self.line = line  # without `super`: there are as many of them as values
        self.column = column
        self.text = text
        self.plain = plain
        self.comment = comment


class Refused(Node):
    """What stands where something was refused, and reported: it has no value, and is not judged further."""

    __slots__ = ()


class Listing(Node):
    """A list."""

    __slots__ = ("items",)

    def __init__(self, line: int, column: int) -> None:
        super().__init__(line, column)
        self.items: list[Node] = []


class Mapping(Node):
    """Keys, which are text, and values, in the order written."""

    __slots__ = ("entries", "key", "keys")

    def __init__(self, line: int, column: int) -> None:
        super().__init__(line, column)
        self.entries: dict[str, Node] = {}
        self.keys: dict[str, Scalar] = {}
        self.key: Scalar | None = None


def read(path: Path, shown: str, found: list[Finding]) -> bytes | None:
    """The bytes of a file, or None where it cannot be read or is too large; what is wrong goes to `found` (T101, T102)."""
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            message = f"{size} bytes, the limit is {MAX_BYTES}"
            found.append(error("T102", message, Place(shown), "split it into several files"))
            return None
        return read_regular(path)
    except OSError as problem:
        found.append(
            error(
                "T101", problem.strerror or str(problem), Place(shown), "check the path and its permissions"
            )
        )
        return None


def parse(data: bytes, shown: str, found: list[Finding]) -> Node | None:
    """The tree of a text in UTF-8 (byte order mark and CRLF allowed), or None; what is wrong goes to `found` (T103 to T111)."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = data.count(b"\n", 0, problem.start) + 1
        message = f"byte {data[problem.start]:#04x} at offset {problem.start} is not UTF-8"
        found.append(error("T104", message, Place(shown, line), "save the file as UTF-8"))
        return None
    if not text.strip():
        found.append(
            error(
                "T103",
                "the file is empty",
                Place(shown, 1),
                "start with `document: requirements`, or delete it",
            )
        )
        return None
    if begins := unmerged(data):
        found.append(error("T105", UNMERGED, Place(shown, begins), SETTLE))
        return None
    turn = _TURNS.search(text)
    if turn is not None:
        place = Place(shown, text.count("\n", 0, turn.start()) + 1)
        shape = f"U+{ord(turn[0]):04X}"
        message = f"{shape} turns the direction of writing, so that the text looks like another one"
        help_ = f'take it out, or write it as "\\u{ord(turn[0]):04X}" in double quotes, where it is seen'
        found.append(error("T105", message, place, help_))
        return None
    try:
        return _Builder(shown, found).build(_events(text), text)
    except _TooDeep as stop:
        found.append(_too_deep(stop.place))
    except yaml.reader.ReaderError as problem:
        line = text.count("\n", 0, problem.position) + 1
        message = f"the control character U+{ord(problem.character) if isinstance(problem.character, str) else problem.character:04X} is no text"
        found.append(error("T105", message, Place(shown, line), "is this a text file?"))
    except yaml.MarkedYAMLError as problem:
        mark = problem.problem_mark or problem.context_mark
        place = Place(shown, mark.line + 1, mark.column + 1) if mark else Place(shown)
        # libyaml has a limit of its own since 0.2.6, and looks so far ahead before it tells of anything.
        if "nesting depth" in str(problem.problem):
            found.append(_too_deep(place))
            return None
        context = f" {problem.context}" if problem.context else ""
        help_ = "indent with blanks; quote texts that hold `: ` or ` #`"
        found.append(error("T105", f"not YAML: {problem.problem}{context}", place, help_))
    return None


def _too_deep(place: Place) -> Finding:
    return error("T110", f"nested more than {MAX_DEPTH} deep", place, "no document here needs such depth")


def _events(text: str) -> Iterator[Any]:
    """The parser's events, one by one."""
    loader = yaml.CSafeLoader(text)
    try:
        yield from iter(loader.get_event, None)
    finally:
        loader.dispose()


#: Stands for a key that was refused; its value is dropped.
_NO_KEY = Scalar("", False, 0, 0)


class _TooDeep(Exception):
    def __init__(self, place: Place) -> None:
        self.place = place


class _Builder:
    """Events to nodes, iteratively."""

    def __init__(self, shown: str, found: list[Finding]) -> None:
        self._shown = shown
        self._found = found
        self._stack: list[Listing | Mapping] = []
        self._root: Node | None = None
        self._documents = 0
        self._aliases: set[str] = set()

    def build(self, events: Iterator[Any], text: str) -> Node | None:
        scalar, begins, ends = yaml.ScalarEvent, (yaml.MappingStartEvent, yaml.SequenceStartEvent), (
            yaml.MappingEndEvent, yaml.SequenceEndEvent,
        )  # fmt: skip
        stack, add = self._stack, self._add
        for event in events:
            kind = type(event)
            if kind is scalar:  # nine of ten
                mark = event.start_mark
                line, column = mark.line + 1, mark.column + 1
                fine = (event.tag is None and event.anchor is None) or self._judge(event)
                plain = not event.style
                comment = _COMMENT.match(text, event.end_mark.index) if plain else None
                said = comment[0].strip() if comment else ""
                add(Scalar(event.value, plain, line, column, said) if fine else Refused(line, column))
            elif kind in begins:
                self._open(event, Mapping if kind is yaml.MappingStartEvent else Listing)
            elif kind in ends:
                stack.pop()
            elif kind is yaml.AliasEvent:
                if event.anchor not in self._aliases:
                    self._refuse(event, "T107", f"the alias `*{event.anchor}`", "write the value out")
                self._aliases.add(event.anchor)
                add(Refused(event.start_mark.line + 1, event.start_mark.column + 1))
            elif kind is yaml.DocumentStartEvent:
                self._documents += 1
                if self._documents == 2:
                    self._refuse(
                        event,
                        "T106",
                        "a second document begins",
                        "one file holds one document; split it at `---`",
                    )
                    return None
            elif kind not in (yaml.StreamStartEvent, yaml.StreamEndEvent, yaml.DocumentEndEvent):
                raise RuntimeError(f"unknown YAML event {kind.__name__}")
        if self._root is None:
            self._found.append(
                error(
                    "T103",
                    "the file holds nothing but comments",
                    Place(self._shown, 1),
                    "fill it, or delete it",
                )
            )
        return self._root

    def _open(self, event: Any, kind: type[Listing] | type[Mapping]) -> None:
        mark = event.start_mark
        fine = self._judge(event)
        if len(self._stack) >= MAX_DEPTH:
            raise _TooDeep(Place(self._shown, mark.line + 1, mark.column + 1))
        node = kind(mark.line + 1, mark.column + 1)
        self._add(node if fine else Refused(node.line, node.column))
        self._stack.append(node)

    def _judge(self, event: Any) -> bool:
        """Report anchors and tags; whether the value can be used: an anchor by itself does it no harm."""
        if event.anchor is not None:
            self._refuse(event, "T107", f"the anchor `&{event.anchor}`", "write the value out at each place")
        if event.tag is not None:
            self._refuse(event, "T108", f"the tag `{event.tag}`", "remove the tag")
        return event.tag is None

    def _refuse(self, event: Any, code: str, message: str, help_: str) -> None:
        mark = event.start_mark
        self._found.append(error(code, message, Place(self._shown, mark.line + 1, mark.column + 1), help_))

    def _add(self, node: Node) -> None:
        if not self._stack:
            self._root = node
            return
        parent = self._stack[-1]
        if type(parent) is Listing:
            parent.items.append(node)
            return
        assert type(parent) is Mapping  # two kinds of nodes hold others
        key = parent.key
        if key is None:
            parent.key = node if type(node) is Scalar else self._key(node)
        else:
            parent.key = None
            if key is _NO_KEY:
                return
            first = parent.keys.get(key.text)
            if first is not None:
                place = Place(self._shown, key.line, key.column)
                also = ((Place(self._shown, first.line, first.column), "first given here"),)
                message = f"the key `{key.text}` is given twice"
                self._found.append(Finding("T109", "error", message, place, "keep one of them", "", also))
            else:
                parent.entries[key.text] = node
                parent.keys[key.text] = key

    def _key(self, node: Node) -> Scalar:
        if isinstance(node, Scalar):
            return node
        if not isinstance(node, Refused):
            place = Place(self._shown, node.line, node.column)
            self._found.append(error("T111", "a key that is not a text", place, "keys are plain words"))
        return _NO_KEY
