"""Comments of a spec file, which the syntax tree does not hold."""

from __future__ import annotations

import re

from trackmarshal.node import Node

_COMMENT = re.compile(r'"(?:[^"\\\n]|\\.)*"|(--[^\n]*)')


class Comment(Node):
    """A comment as written, without blanks at its end."""

    text: str
    start: int
    #: Nothing but blanks stands before it on its line.
    own_line: bool
    #: It starts in column 1.
    outside: bool
    #: An empty line stands above it.
    after_blank: bool


def comments_of(text: str) -> list[Comment]:
    """All comments of a text that parses, in order."""
    found = []
    for match in _COMMENT.finditer(text):
        if match[1] is None:
            continue
        start = match.start()
        begin = text.rfind("\n", 0, start) + 1
        own_line = not text[begin:start].strip()
        found.append(
            Comment(match[1].rstrip(), start, own_line, start == begin, own_line and after_blank(text, start))
        )
    return found


def after_blank(text: str, offset: int) -> bool:
    """Whether the line above that of an offset is empty."""
    begin = text.rfind("\n", 0, offset) + 1
    if begin == 0:
        return False
    return not text[text.rfind("\n", 0, begin - 1) + 1 : begin - 1].strip()


def code_before(text: str, offset: int, comments: list[Comment]) -> int:
    """The offset after the last character before `offset` that is neither blank nor in one of the comments."""
    for comment in reversed(comments):
        if comment.start < offset:
            if text[comment.start + len(comment.text) : offset].strip():
                break
            offset = comment.start
    return len(text[:offset].rstrip())
