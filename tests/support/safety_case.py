"""The document of the safety case read back: its visible texts, its numbers with their ids, its places and links."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from html.parser import HTMLParser

#: Elements of HTML that have no end.
VOID = {"meta", "br", "hr", "img", "input", "link"}
NUMBER = re.compile(r"[0-9]+(?:[.,][0-9]+)*")


@dataclass
class Page(HTMLParser):
    """What a reader sees. numbers: id and text of those that carry an id; texts: all else, block by block; formulas apart."""

    html: str
    texts: list[str] = field(default_factory=list)
    numbers: list[tuple[str, str]] = field(default_factory=list)
    ids: list[str] = field(default_factory=list)
    targets: list[str] = field(default_factory=list)
    tags: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self._open: list[str] = []
        self._number: str | None = None
        self.feed(re.sub(r"<math.*?</math>|<svg.*?</svg>", " ", self.html, flags=re.DOTALL))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        said = dict(attrs)
        self.tags.add(tag)
        if said.get("id"):
            self.ids.append(str(said["id"]))
        if tag == "a" and said.get("href"):
            self.targets.append(str(said["href"]))
        if tag not in VOID:
            self._open.append(tag)
        self._number = said.get("data-number")

    def handle_endtag(self, tag: str) -> None:
        while self._open and self._open.pop() != tag:
            pass
        self._number = None

    def handle_data(self, data: str) -> None:
        if not data.strip() or "style" in self._open or "title" in self._open:
            return
        if self._number is not None:
            self.numbers.append((self._number, data.strip()))
        else:
            self.texts.append(" ".join(data.split()))

    @property
    def formulas(self) -> list[str]:
        return re.findall(r"<math.*?</math>", self.html, flags=re.DOTALL)

    @property
    def first(self) -> str:
        """What stands before the table of contents."""
        return self.html.partition("<nav")[0]
