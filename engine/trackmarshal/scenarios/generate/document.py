"""YAML documents of declarations, read with limits: plain maps, lists and scalars, each with its line."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import SETTLE, UNMERGED, unmerged
from trackmarshal.scenarios import content

#: Declarations are short; a long one is something else.
MAX_BYTES = 100_000
MAX_DEPTH = 20
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")
#: A comment behind a value.
_COMMENT = re.compile(r"[ \t]+#[^\r\n]*")
#: What says what stands in which document, where that is not the page of scenarios, tracks and vehicles.
_PAGES = {"trackmarshal-log-map": "docs/field.md", "trackmarshal-faults": "docs/faults.md"}
_PLAIN = "write the values out, as plain YAML"


def read(data: bytes, shown: str) -> Item:
    """The one document in the bytes; raises D124, D126 or D150."""
    import yaml

    if len(data) > MAX_BYTES:
        message = f"{len(data)} bytes, declarations have at most {MAX_BYTES}"
        raise TrackmarshalError("D124", message, file=shown, help="is this a declaration?")
    text = content.text(data, shown)
    if begins := unmerged(data):
        raise TrackmarshalError("D150", UNMERGED, file=shown, line=begins, help=SETTLE)
    try:
        try:
            node = _composed(text, shown, yaml.CSafeLoader)
        except yaml.YAMLError:  # the parser in Python says more of what is wrong
            node = _composed(text, shown, yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = None if mark is None else mark.line + 1
        message = str(error.problem or error.context)
        raise TrackmarshalError(
            "D150", message, file=shown, line=line, help="is the layout right?"
        ) from error
    except (yaml.YAMLError, ValueError) as error:
        message = str(error).splitlines()[0]
        raise TrackmarshalError("D150", message, file=shown, help="is this YAML?") from error
    if node is None:
        raise TrackmarshalError("D126", "the document is empty", file=shown, line=1, help="was it cut off?")
    return Item(node, "", shown, _page(node))


def _composed(text: str, shown: str, loader: Any) -> Any:
    """The root of the one document of a text, or None; raises D150, and errors of yaml."""
    import yaml

    # Events first: aliases, tags and depth are refused before anything is built of them.
    depth = 0
    for event in yaml.parse(text, Loader=loader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        message = ""
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None) is not None:
            message = "anchors and aliases are not read"
        elif getattr(event, "tag", None) is not None:
            message = "tags are not read"
        elif depth > MAX_DEPTH:
            message = "nested too deeply"
        if message:
            line = None if event.start_mark is None else event.start_mark.line + 1
            raise TrackmarshalError("D150", message, file=shown, line=line, help=_PLAIN)
    root: Any = yaml.compose(text, Loader=loader)
    waiting: list[Any] = [] if root is None else [root]
    while waiting:
        node = waiting.pop()
        if node.id == "scalar":
            comment = None if node.style else _COMMENT.match(text, node.end_mark.index)
            node.comment = comment[0].strip() if comment else ""
        else:
            waiting += chain.from_iterable(node.value) if node.id == "mapping" else node.value
    return root


def _page(root: Any) -> str:
    """The page of the documentation that says what such a document holds, by its `format`."""
    entries = root.value if root.id == "mapping" else ()
    said = next((node.value for key, node in entries if key.value == "format"), "")
    return _PAGES.get(str(said), "docs/scenarios.md")


class Item:
    """A value of the document with its path in it and its line; the methods say what it has to be, or raise D151."""

    def __init__(self, node: Any, path: str, shown: str, page: str) -> None:
        self._node = node
        self.path = path
        self.shown = shown
        #: Of the documentation, what says which keys and values there are.
        self._page = page

    @property
    def line(self) -> int:
        return int(self._node.start_mark.line) + 1

    def wrong(self, message: str, help: str, code: str = "D151") -> TrackmarshalError:
        """An error at this place."""
        where = f"{self.path}: " if self.path else ""
        return TrackmarshalError(code, where + message, file=self.shown, line=self.line, help=help)

    def _kind(self) -> str:
        value = self._node.value
        if isinstance(value, str):
            return repr(value[:40]) if value else "nothing"
        return {"mapping": "a map", "sequence": "a list"}.get(self._node.id, "something else")

    def fields(self, needed: Iterable[str], optional: Iterable[str] = ()) -> dict[str, Item]:
        """The items of a map with these keys, and no others, each once."""
        known = [*needed, *optional]
        found = self.any_fields()
        for key, item in found.items():
            if key not in known:
                from trackmarshal.diagnostics.base import close_matches

                help_ = close_matches(key, known) or f"known: {', '.join(known)}"
                raise item.wrong("this key is not known", help_)
        for key in needed:
            if key not in found:
                raise self.wrong(f"`{key}` is missing", f"see {self._page}")
        return found

    def expect(self, format_: str) -> None:
        """The document does not say that it has another format: of such a one, no key is known."""
        said = self.any_fields().get("format")
        if said is not None and said.text() != format_:
            raise said.wrong(f"{said.text()!r:.40} is not {format_!r}", "is it the right file?")

    def any_fields(self) -> dict[str, Item]:
        """The items of a map with any keys, each once."""
        if self._node.id != "mapping":
            raise self.wrong(f"{self._kind()} stands where a map is expected", f"see {self._page}")
        found: dict[str, Item] = {}
        for key_node, node in self._node.value:
            key = Item(key_node, self.path, self.shown, self._page).text()
            path = f"{self.path}.{key}" if self.path else key
            if key in found:
                raise Item(key_node, path, self.shown, self._page).wrong(
                    "this key stands twice", "keep one of them"
                )
            found[key] = Item(node, path, self.shown, self._page)
        return found

    def items(self) -> Iterator[Item]:
        """The items of a list."""
        if self._node.id != "sequence":
            raise self.wrong(f"{self._kind()} stands where a list is expected", f"see {self._page}")
        for i, node in enumerate(self._node.value):
            yield Item(node, f"{self.path}[{i}]", self.shown, self._page)

    def text(self) -> str:
        """A text that is not empty."""
        if self._node.id != "scalar" or not self._node.value:
            raise self.wrong(f"{self._kind()} stands where a text is expected", f"see {self._page}")
        return str(self._node.value)

    def said(self) -> str:
        """A text that people wrote, or a name as somebody else's file has it: whether what follows ` #` is a part of it, nobody could tell."""
        text = self.text()
        if self._node.comment:
            message = f"the text ends before `{self._node.comment:.40}`, which is a comment to YAML"
            raise self.wrong(
                message,
                "put the text in quotes: inside them what is a part of it, behind them what is a comment",
            )
        return text

    def choice(self, known: Sequence[str]) -> str:
        """One of these words."""
        if (word := self.text()) not in known:
            raise self.wrong(f"`{word}` is not known", f"one of {', '.join(known)}")
        return word

    def plain(self) -> Any:
        """The value as maps, lists and texts."""
        match self._node.id:
            case "mapping":
                return {name: item.plain() for name, item in self.any_fields().items()}
            case "sequence":
                return [item.plain() for item in self.items()]
            case _:
                return self._node.value

    def value(self) -> Any:
        """The value as maps and lists of numbers, true and false, and texts; what is in quotes is a text. Raises D151 where there is none."""
        match self._node.id:
            case "mapping":
                return {name: item.value() for name, item in self.any_fields().items()}
            case "sequence":
                return [item.value() for item in self.items()]
            case _:
                text = self._node.value
                if self._node.style:
                    return text
                if _NUMBER.fullmatch(text):
                    return float(text)
                return text == "true" if text in ("true", "false") else self.text()

    def is_map(self) -> bool:
        """Whether it is a map."""
        return bool(self._node.id == "mapping")

    def is_list(self) -> bool:
        """Whether it is a list."""
        return bool(self._node.id == "sequence")

    def number(self, low: float = -1e6, high: float = 1e6) -> float:
        """A decimal number in [low, high]."""
        if self._node.id != "scalar" or self._node.style or not _NUMBER.fullmatch(self._node.value):
            raise self.wrong(
                f"{self._kind()} stands where a number is expected", "a plain number in SI units"
            )
        value = float(self._node.value)
        if not low <= value <= high:
            raise self.wrong(f"{value:g} is out of range", f"from {low:g} to {high:g}")
        return value

    def count(self, low: int, high: int) -> int:
        """A whole number in [low, high]."""
        value = self.number(low, high)
        if value != math.floor(value):
            raise self.wrong(f"{value:g} is not a whole number", f"from {low} to {high}")
        return int(value)

    def flag(self) -> bool:
        """true or false."""
        if self._node.id != "scalar" or self._node.style or self._node.value not in ("true", "false"):
            raise self.wrong(f"{self._kind()} stands where true or false is expected", "true or false")
        return bool(self._node.value == "true")

    def rows(self) -> list[list[float]]:
        """Pairs of numbers, the first strictly increasing; at least one."""
        rows: list[list[float]] = []
        for item in self.items():
            pair = [number.number() for number in item.items()]
            if len(pair) != 2:
                raise item.wrong(f"{len(pair)} numbers", "pairs of numbers are expected")
            if rows and pair[0] <= rows[-1][0]:
                raise item.wrong(f"{pair[0]:g} does not come after {rows[-1][0]:g}", "sort the pairs")
            rows.append(pair)
        if not rows:
            raise self.wrong("the list is empty", "pairs of numbers are expected")
        return rows
