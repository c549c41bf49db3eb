"""Formatted text in ReqIF, which is XHTML, as plain text."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

#: Elements that are lines of their own.
_BLOCKS = frozenset({
    "div", "p", "li", "tr", "h1", "h2", "h3", "h4", "h5", "h6", "ul", "ol", "dl", "dt", "dd", "table", "caption", "blockquote", "pre", "hr", "address",
})  # fmt: skip
#: Elements whose text is shown as no longer said.
_STRUCK = frozenset({"del", "s", "strike"})
#: What stands before the text of an element that means something else without it: 10^-3, and two cells that are no number together.
_BEFORE = {"sup": "^", "sub": "_", "td": " ", "th": " "}


def plain(value: Any, name: str, dropped: Callable[[str, Any], None]) -> str:
    """The text of an element, which is the value of an attribute of that name; what formats it, or is struck out in it, is told as not taken over."""
    said = struck = ""
    inside = 0  # in how many elements that strike out
    verbatim = 0  # in how many whose lines stand as they are
    for event, node in _walk(value):
        tag = str(node.tag).rsplit("}", 1)[-1]
        begins = event == "start"
        if strikes := tag in _STRUCK or "line-through" in (node.get("style") or ""):
            inside += 1 if begins else -1
        if inside or strikes:  # that a text holds no more is no part of what it says
            struck += (node.text or "") if begins else (node.tail or "") if inside else ""
            if inside:
                continue
            dropped(f"`{' '.join(struck.split())}`, which is struck out in `{name}`,", node)
            struck = ""
            behind = node.tail or ""
            behind = behind if verbatim else re.sub(r"[ \t\r\n]+", " ", behind)
            said += behind.removeprefix(" ") if said.endswith((" ", "\n")) else behind
            continue
        if begins and tag not in _BLOCKS and tag not in ("br", "span", "THE-VALUE"):
            dropped(f"`{tag}` in formatted text", node)
        if tag in _BLOCKS:
            said = said.rstrip(" ")
        if (tag == "br" and begins) or (tag in _BLOCKS and not said.endswith("\n")):
            said += "\n"
        if begins:
            said += _BEFORE.get(tag, "")
        if tag == "pre":
            verbatim += 1 if begins else -1
        text = (node.text if begins else node.tail) or ""
        said += text if verbatim else re.sub(r"[ \t\r\n]+", " ", text)
    return "\n".join(line.strip() for line in said.strip().split("\n"))


def _walk(node: Any) -> Iterator[tuple[str, Any]]:
    """An element's children, each at its start and at its end; the element itself at its start."""
    yield "start", node
    for child in node:
        yield from _walk(child)
        yield "end", child
