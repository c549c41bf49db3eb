"""The matrix page read back, by nothing that made it: its elements, and what its JSON says with names in place of numbers."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from html.parser import HTMLParser
from typing import Any

#: A node's kind and id.
Key = tuple[str, str]


class _Elements(HTMLParser):
    def __init__(self, page: str) -> None:
        super().__init__(convert_charrefs=True)
        self.scripts: list[tuple[str | None, str]] = []
        self.without: list[list[str]] = []  # the rows of the table that stands without a script
        self.ids: list[str] = []
        self.hrefs: list[str] = []
        self.tags: list[str] = []
        self._open: list[str] = []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        said = dict(attrs)
        self.tags.append(tag)
        self._open.append(tag)
        if tag == "script":
            self.scripts.append((said.get("type"), ""))
        if said.get("id"):
            self.ids.append(str(said["id"]))
        if said.get("href"):
            self.hrefs.append(str(said["href"]))
        if tag == "tr" and "noscript" in self._open:
            self.without.append([])
        if tag in ("td", "th") and "noscript" in self._open:
            self.without[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        while self._open and self._open.pop() != tag:
            pass

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] == "script":
            kind, text = self.scripts[-1]
            self.scripts[-1] = (kind, text + data)
        if "noscript" in self._open and {"td", "th"} & set(self._open):
            self.without[-1][-1] += data


@dataclass
class Walk:
    """A page. nodes: title, place, status and attributes by key; links: kind, ends, state and place; cells: by requirement and stage, status and items."""

    html: str
    data: dict[str, Any] = field(default_factory=dict)
    nodes: dict[Key, tuple[str, str, str, dict[str, str]]] = field(default_factory=dict)
    links: list[tuple[str, Key, Key, str, str]] = field(default_factory=list)
    cells: dict[str, dict[str, tuple[str, list[tuple[str, ...]]]]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.elements = _Elements(self.html)
        held = [text for kind, text in self.elements.scripts if kind == "application/json"]
        assert len(held) == 1
        self.data = data = json.loads(held[0])
        self._keys = [(data["kinds"][kind][0], id_) for kind, id_, *_ in data["nodes"]]
        for key, (_, _, title, place, status, *said) in zip(self._keys, data["nodes"]):
            names = [data["names"][number] for number in said[::2]]
            texts = [text if isinstance(text, str) else data["texts"][text] for text in said[1::2]]
            self.nodes[key] = (title, self._place(place), self._status(status), dict(zip(names, texts)))
        assert len(self.nodes) == len(data["nodes"])
        for way, source, target, state, place in data["links"]:
            end = tuple(target) if isinstance(target, list) else self._keys[target]
            self.links.append(
                (data["ways"][way][0], self._keys[source], end, data["states"][state], self._place(place))
            )
        for (row, _), cells in zip(data["rows"], data["cells"], strict=True):
            self.cells[self._keys[row][1]] = {
                data["stages"][stage]["id"]: (self._status(status), [self._item(item) for item in items])
                for stage, status, items in cells
            }

    def of(self, kind: str, table: str) -> dict[str, Any]:
        """What a table by numbers of nodes says of nodes of a kind, by their ids."""
        return {
            self._keys[int(number)][1]: said
            for number, said in self.data[table].items()
            if self._keys[int(number)][0] == kind
        }

    def key(self, number: int) -> Key:
        return self._keys[number]

    def _place(self, place: list[int]) -> str:
        if not place:
            return ""
        file, line, column = place
        return ":".join([self.data["files"][file], *(str(part) for part in (line, column) if part)])

    def _status(self, number: int) -> str:
        return "" if number < 0 else str(self.data["statuses"][number][0])

    def _item(self, item: list[Any]) -> tuple[str, ...]:
        """Kind, id, status and detail."""
        status, detail, node, *rest = item
        kind, name = (rest[0], rest[1]) if node < 0 else self._keys[node]
        return (kind, name, self._status(status), detail)
