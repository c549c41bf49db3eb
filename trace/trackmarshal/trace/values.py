"""Trees to values of known shape: texts that know their place, tables of them; every misfit is reported."""

from __future__ import annotations

import re
from datetime import date
from typing import Any

import yaml

from trackmarshal.trace.findings import Finding, Place, did_you_mean, error
from trackmarshal.trace.shapes import Count, Date, Flag, Many, Pairs, Record, Shape, Text, Word, says_nothing
from trackmarshal.trace.tree import Listing, Mapping, Node, Refused, Scalar


class Placed(str):
    """A text that knows where it stands."""

    __slots__ = ("place",)
    place: Place

    @classmethod
    def at(cls, text: str, place: Place) -> Placed:
        self = cls(text)
        self.place = place
        return self


class Table(dict[str, Any]):
    """The fields of a mapping that are there and fit; `place` is where the mapping begins."""

    __slots__ = ("place",)
    place: Place

    def text(self, name: str) -> Placed:
        """A text field; the empty text when it is not there."""
        value = self.get(name)
        return value if isinstance(value, Placed) else Placed.at("", self.place)

    def texts(self, name: str) -> tuple[Placed, ...]:
        return tuple(self.get(name, ()))

    def tables(self, name: str) -> tuple[Table, ...]:
        return tuple(self.get(name, ()))


#: Plain scalars that YAML readers take for something else than text, by their first character.
_RESOLVERS: dict[str, list[tuple[str, re.Pattern[str]]]] = yaml.CSafeLoader.yaml_implicit_resolvers
_SAID = {
    "bool": "a Boolean",
    "int": "a number",
    "float": "a number",
    "null": "nothing",
    "timestamp": "a date",
}


def resolved(node: Scalar) -> str:
    """What YAML readers take a scalar for: str, bool, int, float, null, timestamp, merge or value."""
    if not node.plain or node.text[:1] not in _RESOLVERS:
        return "str"
    for tag, pattern in _RESOLVERS[node.text[:1]]:
        if pattern.match(node.text):
            return tag.rsplit(":", 1)[1]
    return "str"


class Reader:
    """Reads the trees of one file; what does not fit goes to `found` (T120 to T128) and is left out."""

    def __init__(self, file: str, found: list[Finding]) -> None:
        self._file = file
        self._found = found

    def place(self, node: Node) -> Place:
        return Place(self._file, node.line, node.column)

    def table(self, node: Node, record: Record, called: str) -> Table | None:
        """A mapping as a table; None when it is no mapping. `called` is its name in messages."""
        if isinstance(node, Refused):
            return None
        if not isinstance(node, Mapping):
            self._wrong(node, called, "a mapping")
            return None
        table = Table()
        table.place = self.place(node)
        for name, value in node.entries.items():
            key, field = node.keys[name], record.by_name.get(name)
            if field is None:
                known = "known are " + ", ".join(record.by_name)
                help_ = did_you_mean(name, record.by_name) or known
                self._found.append(error("T121", f"{called} has no field `{name}`", self.place(key), help_))
                continue
            value = self._value(value, field.shape, f"`{name}`")
            if value is not None:
                table[name] = value
        for field in record.fields:
            if field.required and field.name not in node.entries:
                message = f"{called} has no `{field.name}`"
                self._found.append(error("T120", message, table.place, f"add it: {field.description}"))
        return table

    def _value(self, node: Node, shape: Shape, called: str) -> Any:
        if isinstance(shape, Text) and isinstance(node, Scalar):  # the frequent case first
            return self._text(node, shape, called)
        if isinstance(node, Refused):
            return None
        if isinstance(shape, Record):
            return self.table(node, shape, f"the {shape.name}")
        if isinstance(shape, Many):
            return self._many(node, shape, called)
        if isinstance(shape, Pairs):
            return self._pairs(node, shape, called)
        if not isinstance(node, Scalar):
            self._wrong(node, called, _wanted(shape))
            return None
        return self._scalar(node, shape, called)

    def _many(self, node: Node, shape: Many, called: str) -> list[Any] | None:
        if not isinstance(node, Listing):
            self._wrong(node, called, "a list")
            return None
        if len(node.items) < shape.least:
            self._found.append(
                error(
                    "T126",
                    f"{called} is empty",
                    self.place(node),
                    "give at least one, or leave the field out",
                )
            )
        inner = f"an entry of {called}"
        values = [self._value(item, shape.of, inner) for item in node.items]
        return [value for value in values if value is not None]

    def _pairs(self, node: Node, shape: Pairs, called: str) -> dict[str, Placed] | None:
        if not isinstance(node, Mapping):
            self._wrong(node, called, "a mapping")
            return None
        values = {
            name: self._value(value, shape.of, f"`{name}` of {called}")
            for name, value in node.entries.items()
        }
        return {name: value for name, value in values.items() if value is not None}

    def _text(self, node: Scalar, shape: Text, called: str) -> Placed | None:
        kind = resolved(node)
        if kind == "str" and node.text and not node.text.isspace():  # as nearly all of them
            said = node.text if shape.pattern else node.text.strip()
            if not shape.pattern and not shape.verbatim and says_nothing(said):
                message = f"{called} says no more than `{said}`"
                self._found.append(error("T126", message, self.place(node), "write what it is to say"))
                return None
            if shape.fits(said):
                if node.comment and not shape.pattern:
                    self._cut_off(node, called)
                return Placed.at(said, Place(self._file, node.line, node.column))
        if kind == "null" or (kind == "str" and not node.text.strip()):
            help_ = "fill it in, or leave the field out"
            if node.comment:
                help_ = f"to YAML `{_short(node.comment)}` is a comment: quote the text, or fill it in"
            self._found.append(error("T126", f"{called} is empty", self.place(node), help_))
            return None
        if kind != "str":
            message = f"{called} is to be a text, but without quotes `{node.text}` is {_SAID.get(kind, 'no text')} in YAML"
            self._found.append(error("T128", message, self.place(node), f"write '{node.text}', in quotes"))
            return None
        text = node.text.strip() if not shape.pattern else node.text
        if not shape.fits(text):
            self._found.append(
                error("T124", f"{called} is `{text}`, wanted is {shape.said}", self.place(node))
            )
            return None
        return Placed.at(text, self.place(node))

    def _cut_off(self, node: Scalar, called: str) -> None:
        """Of a text that people read, nobody can tell whether what stands behind ` #` was meant as a part of it; an id says by its form where it ends."""
        message = f"{called} ends before `{_short(node.comment)}`, which is a comment to YAML"
        help_ = "put the text in quotes: inside them what is a part of it, behind them what is a comment"
        self._found.append(error("T114", message, self.place(node), help_))

    def _scalar(self, node: Scalar, shape: Shape, called: str) -> Any:
        kind, text = resolved(node), node.text
        match shape:
            case Word(choices=choices):
                if kind == "str" and text in choices:
                    return Placed.at(text, self.place(node))
                help_ = did_you_mean(text, choices) or "known are " + ", ".join(choices)
                self._found.append(error("T123", f"{called} cannot be `{text}`", self.place(node), help_))
            case Date():
                day = _date(text) if kind in ("str", "timestamp") else None
                if day is not None:
                    return day
                self._found.append(
                    error("T125", f"{called} is `{text}`, wanted is a day as YYYY-MM-DD", self.place(node))
                )
            case Count():
                if kind == "int" and re.fullmatch("0|[1-9][0-9]{0,8}", text):
                    return int(text)
                self._wrong(node, called, "a whole number from 0")
            case Flag():
                if kind == "bool" and text.lower() in ("true", "false"):
                    return text.lower() == "true"
                self._wrong(node, called, "true or false")
            case _:
                raise TypeError(f"unknown shape {shape!r}")
        return None

    def _wrong(self, node: Node, called: str, wanted: str) -> None:
        message = f"{called} is to be {wanted}, not {_described(node)}"
        self._found.append(error("T122", message, self.place(node)))


def _date(text: str) -> date | None:
    if not re.fullmatch(r"[0-9]{4}-[0-9]{2}-[0-9]{2}", text):
        return None
    try:
        return date.fromisoformat(text)
    except ValueError:
        return None


def _wanted(shape: Shape) -> str:
    match shape:
        case Text(said=said):
            return said
        case Word(choices=choices):
            return "one of " + ", ".join(choices)
        case Date():
            return "a day"
        case Count():
            return "a whole number"
        case Flag():
            return "true or false"
        case _:
            raise TypeError(f"unknown shape {shape!r}")


def _described(node: Node) -> str:
    if isinstance(node, Mapping):
        return "a mapping"
    if isinstance(node, Listing):
        return "a list"
    if isinstance(node, Scalar):
        return "nothing" if resolved(node) == "null" else f"`{_short(node.text)}`"
    raise TypeError(f"unknown node {node!r}")


def _short(text: str) -> str:
    return text if len(text) < 40 else text[:37] + "..."
